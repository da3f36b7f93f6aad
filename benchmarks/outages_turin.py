"""Which error model holds the position? Hundreds of outages on the two simulated drives, with
intervals.

    python benchmarks/outages_turin.py --drives 6 --workers 2

Two sensors: "calibrated", the twin of the 3DM-GX3-25 alone, its gyro bias removed at standstill;
"as mounted", the same with 20 mg of accelerometer bias, 0.3 % of scale factor and 3 mrad of
misalignment that nobody removed. Each drive is drawn anew; outages of 30 s every 40 s and of 60 s
every 80 s stand alone. The intervals take the drives, not the outages, as independent. Also the
paper's own seven outages and those of its Table 6 (no error model, wavelet levels 0, 3, 7), as
means over the drives.
"""

import argparse
import json
import time
from pathlib import Path

import numpy as np

from imu_lib import preset
from imu_lib.characterise import characterise
from imu_lib.navigation import ensemble, models, outages, simulation, statistics, turin
from imu_lib.navigation.filter import FilterModel

RESULT = Path(__file__).parent / "results" / "outages_turin.json"
SENSORS = {
    "calibrated": (simulation.ImuErrors(turn_on_sd=(3.5e-3, 0.0)), (2e-4, 0.0)),
    "as mounted": (
        simulation.ImuErrors(
            turn_on_sd=(3.5e-3, 0.2), scale_sd=(0.003, 0.003), misalignment_sd=(0.003, 0.003)
        ),
        (2e-4, 0.2),
    ),
}
STATIC_HOURS = 1.0


def contestants(fitted, turn_on_sd):
    """The five of the paper, the causal 18AVWD, the model that draws the errors, and what a joint
    fit of a static record gives.
    """
    out = models.five(turn_on_sd=turn_on_sd)
    out["18AVWD causal"] = models.five(names=("18AVWD",), causal=True, turn_on_sd=turn_on_sd)[
        "18AVWD"
    ].with_(name="18AVWD causal")
    truth = preset("3dm-gx3-25")
    out["truth"] = FilterModel("truth", truth, turn_on_sd=turn_on_sd)
    out["likelihood"] = FilterModel("likelihood", fitted, flicker="markov", turn_on_sd=turn_on_sd)
    out["likelihood + constant + scale"] = FilterModel(
        "likelihood + constant + scale",
        with_constants(fitted),
        flicker="markov",
        turn_on_sd=turn_on_sd,
        scale_sd=(0.005, 0.005),
    )
    out["likelihood + road"] = out["likelihood + constant + scale"].with_(
        name="likelihood + road", constraint_sd=0.1
    )
    return out


def with_constants(model):
    """The model with a constant on every channel, so that what is left at switch-on has a state
    that does not forget it.
    """
    from imu_lib.processes import Constant, Sum

    return model.with_channels(
        {c: Sum((*model[c].terms, Constant(value=0.0))) for c in model.channel_names}
    )


_ways = {}


def way(which):
    """A drive's path and true motion, once per process."""
    if which not in _ways:
        path = turin.drive(which)
        _ways[which] = path, simulation.true_motion(path)
    return _ways[which]


class Task:
    """One drive, all models: errors of the regular windows, of the seven outages, of Table 6."""

    def __init__(self, sensor, fitted):
        self.sensor, self.fitted = sensor, fitted

    def __call__(self, rng, number):
        errors, turn_on_sd = SENSORS[self.sensor]
        which = number % 2 + 1
        path, motion = way(which)
        drive = simulation.simulate_drive(
            path, preset("3dm-gx3-25"), rng, motion=motion, imu=errors
        )
        entries = contestants(self.fitted, turn_on_sd)
        out = {"drive": which}
        windows = {
            d: outages.regular_windows(drive, duration=d, every=every)
            for d, every in ((30.0, 40.0), (60.0, 80.0))
        }
        windows["seven"] = tuple(
            outages.Window(o.start, o.duration) for o in turin.outages_of(which)
        )
        study = outages.compare(
            drive, entries, sum(windows.values(), ())
        )  # one run of each model for all of them
        at = 0
        for kind, some in windows.items():
            part = slice(at, at + len(some))
            at += len(some)
            if kind == "seven":
                out[kind] = {
                    n: {
                        what: study.errors(n, what=what, against="full_gnss")[part]
                        for what in ("max", "mean")
                    }
                    for n in entries
                }
            else:
                out[kind] = {
                    n: {
                        "max": study.errors(n, against="reference")[part],
                        "sigma": np.array([s[-1] for s in study.models[n].sigma[part]]),
                    }
                    for n in entries
                }
        bare = simulation.white_only(preset("3dm-gx3-25-2013"))
        levels = {
            f"{level}{' causal' if causal else ''}": FilterModel(
                "none", bare, levels=by_channel, causal=causal
            )
            for level, by_channel in ((0, None), (3, turin.LEVELS_THREE), (7, turin.LEVELS_TABLE_7))
            for causal in (False, True)
            if level or not causal
        }
        starred = outages.compare(
            drive, levels, [(o.start, o.duration) for o in turin.outages_of(which, table_6=True)]
        )
        out["table 6"] = {n: starred.errors(n, against="full_gnss") for n in levels}
        return out


def summary(runs):
    content = {}
    for duration in (30.0, 60.0):
        names = list(runs[0][duration])
        pooled = {n: np.concatenate([r[duration][n]["max"] for r in runs]) for n in names}
        clusters = np.concatenate(
            [np.full(r[duration][names[0]]["max"].size, i) for i, r in enumerate(runs)]
        )
        sigma = {n: np.concatenate([r[duration][n]["sigma"] for r in runs]) for n in names}
        order = sorted(names, key=lambda n: np.log(pooled[n]).mean())
        content[f"{duration:g} s"] = {
            "outages": int(clusters.size),
            "drives": len(runs),
            "models": {
                n: {
                    "median": statistics.median_interval(pooled[n]),
                    "mean": float(pooled[n].mean()),
                    "p95": float(np.quantile(pooled[n], 0.95)),
                    "predicted": float(np.median(sigma[n])),
                }
                for n in order
            },
            "paired": [
                statistics.paired(pooled[a], pooled[b], (a, b), clusters=clusters).to_json()
                for i, a in enumerate(order)
                for b in order[i + 1 :]
            ],
            "improvement_of_18AVWD": {
                n: {
                    how: statistics.improvement(pooled["18AVWD"], pooled[n], how=how)
                    for how in ("mean_of_ratios", "ratio_of_sums")
                }
                for n in ("15AV", "18AV", "15AR", "27AR")
            },
        }
    for key in ("seven", "table 6"):
        by = {}
        for which in (1, 2):
            mine = [r[key] for r in runs if r["drive"] == which]
            for n in mine[0]:
                for what in mine[0][n] if key == "seven" else ("max",):
                    values = np.array([m[n][what] if key == "seven" else m[n] for m in mine])
                    by.setdefault(n, {}).setdefault(what, []).extend(values.mean(axis=0).tolist())
        content[key] = by
    return content


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--drives",
        type=int,
        default=6,
        help="of each sensor, half of them along each of the two ways",
    )
    parser.add_argument("--workers", type=int, default=2)
    args = parser.parse_args()
    truth = preset("3dm-gx3-25")
    static = truth.simulate_record(int(STATIC_HOURS * 3600 * 100), 100.0, np.random.default_rng(7))
    fitted = characterise(static, workers=args.workers).model
    content = {
        "command": f"python benchmarks/outages_turin.py --drives {args.drives}",
        "date": time.strftime("%Y-%m-%d"),
        "likelihood_model": {
            c: s for c, s in fitted.to_json().items() if c in fitted.channel_names
        },
        "sensors": {},
    }
    for sensor in SENSORS:
        runs = ensemble.monte_carlo(
            Task(sensor, fitted), args.drives, seed=20130724, workers=args.workers, progress=True
        )
        content["sensors"][sensor] = summary(runs)
        for duration in ("30 s", "60 s"):
            print(
                sensor,
                duration,
                {
                    n: round(m["median"][0], 1)
                    for n, m in content["sensors"][sensor][duration]["models"].items()
                },
            )
    RESULT.parent.mkdir(exist_ok=True)
    RESULT.write_text(json.dumps(content, indent=1) + "\n")


if __name__ == "__main__":
    main()
