"""How often do the 95 % intervals hold the truth? Two hundred draws of the seven-hour twin, all
methods side by side.

    python benchmarks/interval_coverage.py --seeds 1-200 --jobs 2

Each seed draws the six channels of the twin; each method sees a channel and its template (which
processes, with the filter, not their values) and answers with estimates. The table gives, by
method, channel and parameter: the share of intervals that hold the truth, the median and the
scatter of estimate / truth, and how often the term was said not to be shown. A run of some methods
keeps the stored results of the others. A method is one function below; `METHODS` lists it.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

import numpy as np

from imu_lib import allan, preset, scheduler
from imu_lib.estimate import Estimate
from imu_lib.processes import Sum

RESULT = Path(__file__).parent / "results" / "coverage.json"
HOURS, RATE = 7.0, 100.0


def allan_fit(x, fs, template, curve):
    """The joint fit of the whole Allan curve."""
    found = allan.fit(curve, template)
    return {**found.parameters, "flat": found.flat}


def allan_read_off(x, fs, template, curve):
    """What IEEE 952 and the 2013 paper read off the slopes; sigma = 0.664 B and Tc where the curve
    is flat.
    """
    found = allan.read_off(curve)
    out = {name: found[name] for name in ("N", "K") if name in found.coefficients}
    if found["B"].shown:
        out["flat"] = out["sigma"] = found["B"].scaled(allan.FLAT)
        out["correlation_time"] = found.correlation_time
    return out


def spectrum_read_off(x, fs, template, curve):
    """Lines of slope 0 and -2 through the frequency-averaged spectrum."""
    from imu_lib import spectrum

    found = spectrum.characterise(x, fs)
    return {name: found[name] for name in ("N", "K")}


def likelihood_fit(x, fs, template, curve):
    """The joint likelihood of the whole record."""
    from imu_lib import likelihood

    found = likelihood.fit(x, fs, template)
    return {**found.parameters, "flat": likelihood.flat_level(found)}


def wavelet_moments(x, fs, template, curve):
    """The generalised method of wavelet moments with the covariance of the moments as weights."""
    from imu_lib import gmwm

    return dict(gmwm.fit(x, fs, template).parameters)


METHODS = {
    "allan.fit": allan_fit,
    "allan.read_off": allan_read_off,
    "spectrum.read_off": spectrum_read_off,
    "likelihood.fit": likelihood_fit,
    "gmwm.fit": wavelet_moments,
}


def template_of(entry):
    """The channel's sum with all noise parameters to be estimated; stages stay."""
    return Sum(
        tuple(p.with_(**{q.name: None for q in p.parameters}) for p in entry.terms), entry.stages
    )


def truth_of(entry, fs, n):
    """Parameters by label, and the flat level: the Allan deviation where the model's is
    flattest.
    """
    labels = Sum(entry.terms).labels()
    out = {label: getattr(entry.terms[index], name) for label, index, name in labels}
    tau = np.array([allan.flat_time(entry, 1 / fs, n / fs / 3)])
    return out | {"flat": float(np.sqrt(entry.avar(tau, fs)[0]))}


def one_seed(name, seed, methods):
    """All channels of one draw: list of (method, channel, label, truth, value, low, high,
    seconds).
    """
    model, n = preset(name), round(HOURS * 3600 * RATE)
    rows = []
    for k, channel in enumerate(model.channels):
        entry = model[channel]
        x = entry.simulate(n, RATE, np.random.default_rng([seed, k]))
        curve = allan.deviation(x, RATE, threads=1)
        truth, template = truth_of(entry, RATE, n), template_of(entry)
        for method in methods:
            start = time.perf_counter()
            found = METHODS[method](x, RATE, template, curve)
            seconds = time.perf_counter() - start
            rows += [
                (method, channel, label, truth[label], e.value, e.low, e.high, seconds)
                for label, e in found.items()
                if label in truth and isinstance(e, Estimate)
            ]
    return rows


def summary(rows):
    """Coverage, bias and scatter of one method's rows."""

    def line(some):
        truth = np.array([r[3] for r in some])
        low, high = (
            np.array([r[i] if r[i] is not None else np.nan for r in some], dtype=float)
            for i in (5, 6)
        )
        shown = [r[4] / r[3] for r in some if r[4] is not None]
        out = {
            "draws": len(some),
            "covered": float(np.mean((low <= truth) & (truth <= high))),
            "truth_above": float(np.mean(truth > high)),
            "not_shown": 1 - len(shown) / len(some),
        }
        if shown:
            out |= {
                "median_ratio": float(np.median(shown)),
                "mean_ratio": float(np.mean(shown)),
                "sd_of_log": float(np.std(np.log(shown))),
            }
        return out

    table = {}
    for channel in dict.fromkeys(r[1] for r in rows):
        mine = [r for r in rows if r[1] == channel]
        table[channel] = {
            label: line([r for r in mine if r[2] == label])
            for label in dict.fromkeys(r[2] for r in mine)
        }
    pooled = {
        label: line([r for r in rows if r[2] == label])
        for label in dict.fromkeys(r[2] for r in rows)
    }
    return {
        "pooled": pooled,
        "pooled_all": line(rows)["covered"],
        "channels": table,
        "seconds_per_channel": float(np.median([r[7] for r in rows])),
    }


def main(arguments=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", default="1-200")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--scheduler", help="address of a Dask cluster, instead of --jobs")
    parser.add_argument("--twin", default="3dm-gx3-25")
    parser.add_argument(
        "--methods", default="allan.fit,allan.read_off,spectrum.read_off,likelihood.fit,gmwm.fit"
    )
    parser.add_argument("--out", type=Path, default=RESULT)
    parser.add_argument(
        "--log", type=Path, help="file of finished seeds: an interrupted study goes on from there"
    )
    options = parser.parse_args(arguments)
    first, last = (int(v) for v in options.seeds.split("-"))
    methods = options.methods.split(",")
    start = time.time()
    lines = options.log.read_text().splitlines() if options.log and options.log.exists() else []
    finished = {entry["seed"]: entry["rows"] for entry in map(json.loads, lines)}
    todo = [seed for seed in range(first, last + 1) if seed not in finished]
    tasks = [(options.twin, seed, methods) for seed in todo]
    work = scheduler.run(one_seed, tasks, workers=options.jobs, address=options.scheduler)
    for number, part in work:
        finished[seed := todo[number]] = part
        if options.log:
            with options.log.open("a") as file:
                file.write(json.dumps({"seed": seed, "rows": part}) + "\n")
    rows = [row for seed in range(first, last + 1) for row in finished[seed]]
    stored = json.loads(options.out.read_text()) if options.out.exists() else {"methods": {}}
    for method in methods:
        mine = [row for row in rows if row[0] == method]
        if mine:
            stored["methods"][method] = {
                "command": f"python benchmarks/interval_coverage.py --seeds {options.seeds} "
                f"--methods {method}",
                "date": time.strftime("%Y-%m-%d", time.gmtime()),
                "twin": options.twin,
                "hours": HOURS,
                "rate": RATE,
                "seeds": [first, last],
                **summary(mine),
            }
    options.out.parent.mkdir(exist_ok=True)
    options.out.write_text(json.dumps(stored, indent=1) + "\n")
    for method in methods:
        result = stored["methods"].get(method)
        if result:
            print(
                f"{method}: pooled {result['pooled_all']:.3f}, "
                f"{result['seconds_per_channel']:.2f} s a channel"
            )
            for label, line in result["pooled"].items():
                each = " ".join(
                    f"{channel} {table[label]['covered']:.3f}"
                    for channel, table in result["channels"].items()
                    if label in table
                )
                print(
                    f"  {label:17s} {line['covered']:.3f} ratio "
                    f"{line.get('median_ratio', np.nan):.3f}  {each}"
                )
    print(f"{time.time() - start:.0f} s")


if __name__ == "__main__":
    main()
