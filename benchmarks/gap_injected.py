"""Effects put into stretches of recorded signals: is the name new there, and nothing new elsewhere?

    python benchmarks/gap_injected.py --cases 2 --log injected.jsonl     # every effect; resumes
    python benchmarks/gap_injected.py --effects ramp,spikes --cases 1 --print
    python benchmarks/gap_injected.py --drawn --together 3 --cases 2 --name gap_strange

A wrong rate (`rate_error`) is told by known lines alone: such a stretch has lines put in, is run,
and is given its own grown model with a rate that is wrong.

A stretch of a real record is run as it is and with one effect put into it (`gap_put`, which shares
nothing with the package), rounded to the digits of its file again. The effect counts as named where
it is a step of that channel (or of the record with that channel) that was not there before; `new`
counts steps of high confidence on other channels that were not there before. Cases whose effect
gains less than 20 in log-likelihood over the spectrum of the stretch are counted apart, and so are
those that the stretch has already, or that the fitted base says that it may have absorbed. Needs
the folder of recorded data, IMU_LIB_DATA. The table goes to benchmarks/results/gap_injected.json.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from datetime import date
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "benchmarks"), str(ROOT / "tests")]

import gap_put  # noqa: E402
import gap_strange  # noqa: E402
import numpy as np  # noqa: E402
from _log import Log  # noqa: E402
from statsmodels.stats.proportion import proportion_confint  # noqa: E402

from imu_lib.gap import close  # noqa: E402
from imu_lib.record import Record  # noqa: E402

RESULTS = ROOT / "benchmarks" / "results"
SURE = 0.9
#: File, rate in Hz where it has no stamps, samples of a stretch.
RECORDS = (
    ("adis16405_1", 100.0, 30_000),
    ("hipnuc_ch104", 100.0, 30_000),
    ("mpu6050_10min", None, 30_000),
    ("vn100_still", 40.0, 12_000),
    ("sbg_ig500n", None, 15_000),
    ("memsense_gyros", 250.0, 13_000),
    ("xsens_dot", 120.0, 14_000),
    ("mtig_gyro_x", 100.0, 40_000),
    ("adis16405_3", 100.0, 20_000),
    ("xsens_mtx", 200.0, 6_400),
)
#: Cases in a row that share a stretch.
SHARED = 4


def stretch(data: Path, number: int, whole_sensor: bool):
    """(name, rate, start, channels {name: (n,)}) of part `number` of the recorded signals; three
    channels at the most, or all.
    """
    rng = np.random.default_rng([number, 11])
    file, rate, n = RECORDS[number % len(RECORDS)]
    content = np.load(data / "static" / f"{file}.npz")
    channels = {}
    for kind in ("gyro", "accel"):
        if kind in content:
            for i, axis in enumerate("xyz"):
                channels[f"{kind}_{axis}"] = np.asarray(content[kind][:, i], float)
    if "gyro_x" in content:
        channels["gyro_x"] = np.asarray(content["gyro_x"], float)
    whole = len(next(iter(channels.values())))
    if rate is None:
        time = content["time"]
        rate = float((len(time) - 1) / (time[-1] - time[0]))
    n = min(n, whole)
    start = int(rng.integers(0, whole - n + 1))
    names = list(channels)
    keep = sorted(rng.choice(len(names), min(3, len(names)), replace=False))
    if whole_sensor:
        keep = range(len(names))
    return file, rate, start, {names[k]: channels[names[k]][start : start + n] for k in keep}


def _warmth(n, fs, rng):
    """A temperature that rises and swings, shape (n,)."""
    t = np.arange(n) / (n - 1)
    rise = rng.uniform(2, 8) * (1 - np.exp(-t / rng.uniform(0.1, 0.4)))
    return 25 + rise + rng.uniform(0.3, 1) * np.sin(2 * np.pi * t * rng.uniform(1.5, 4))


def named(found):
    """{channel: {effect: confidence}} of a report; what is on the record is on its channels."""
    out = {c: {} for c in found.channels}
    for where, s in found.steps:
        on = s.parameters.get("channels") or (
            list(found.channels) if where == "record" else [where]
        )
        for c in on:
            out.setdefault(c, {})[s.effect] = round(float(s.confidence), 4)
    return out


def _looked_at(channels, fs, temperature=None, time=None, model=None):
    record = Record(channels, fs, time=time, temperature=temperature)
    found = close(record, model, simulations=0, jobs=1)
    return _summed(found), found.model


def _summed(found):
    left = {c: r.result.unexplained for c, r in found.channels.items() if r.result.unexplained}
    absorbed = {c: list(r.result.absorbed) for c, r in found.channels.items()}
    return {
        "names": named(found),
        "absorbed": absorbed,
        "unexplained": left,
        "verdict": found.to_json()["verdict"],
    }


def _put_all(effects, channels, fs, temperature, rng):
    """(channels, time stamps or None, [(effect, channels it is on, gain, what was put in)])."""
    out, clock, truths = dict(channels), None, []
    for effect in sorted(effects, key=gap_put.EFFECTS.index):
        target = list(channels)[int(rng.integers(len(channels)))]
        out, on, gain, told = gap_put.put(effect, out, fs, target, rng, temperature)
        clock = out.pop("time", clock)
        truths.append((effect, on, gain, told))
    return out, clock, truths


def run(case, data, before):
    """Rows of one case, one for each effect; `before` holds what was found in stretches as they
    are.
    """
    rng = np.random.default_rng([case["seed"], 13])
    effects = {case["effect"], *case.get("with", ())}
    if data is None:
        file, start = "drawn", 0
        fs, channels = gap_strange.record(case["stretch"], six="tilt" in effects)
    else:
        file, fs, start, channels = stretch(data, case["stretch"], "tilt" in effects)
    if "tilt" in effects and len(channels) < 6 or "vibration" in effects and len(channels) < 2:
        return [{**case, "record": file, "skipped": "too few channels"}]
    n = len(next(iter(channels.values())))
    temperature = _warmth(n, fs, rng) if "temperature" in effects else None
    changed, clock, truths = _put_all(effects, channels, fs, temperature, rng)
    if any(e == "common_mode" and len(on) < 2 for e, on, _, _ in truths):
        return [{**case, "record": file, "skipped": "one channel of a kind"}]
    model = None
    if "rate_error" in effects:  # by its own model: what it is to be told from stands in that
        key, ratio = f"{case['stretch']} clock {case['seed']}", truths[0][3]["ratio"]
        before[key], model = _looked_at(changed, fs)
        fs = fs / ratio
    else:
        key = f"{case['stretch']} {' '.join(sorted(effects & {'tilt', 'temperature'}))}"
    if key not in before:
        before[key], _ = _looked_at(channels, fs, temperature)
    old, (new, _) = before[key], _looked_at(changed, fs, temperature, clock, model)
    about = {"record": file, "start": start, "key": key, "before": old, "after": new}
    touched = {c for _, on, _, _ in truths for c in on}
    more = {"touched": sorted(touched), "untouched": len(set(channels) - touched)}
    return [
        {**case, **about, **more, **_judged(truth, truths, old, new, first=k == 0)}
        for k, truth in enumerate(truths)
    ]


def _judged(truth, truths, old, new, *, first: bool) -> dict:
    """Whether an effect was named, and (once a record) what else was new."""
    effect, on, gain, told = truth
    names = gap_put.NAMES.get(effect, (effect,))
    fresh = {
        c: {e: s for e, s in found.items() if e not in old["names"].get(c, {})}
        for c, found in new["names"].items()
    }
    touched = {c for _, where, _, _ in truths for c in where}
    hit = any(e in names for c in on for e in fresh.get(c, {}))
    return {
        "effect": effect,
        "on": on,
        "gain": round(float(gain), 1),
        "put_in": told,
        "already": any(effect in old["names"].get(c, {}) for c in on),
        "absorbed": not hit and any(effect in new["absorbed"].get(c, ()) for c in on),
        "named": hit,
        "named_sure": any(
            e in names and sure >= SURE for c in on for e, sure in fresh.get(c, {}).items()
        ),
        "new": [
            f"{c} {e}"
            for c, found in (fresh if first else {}).items()
            for e, sure in found.items()
            if c not in touched and sure >= SURE
        ],
        "first": first,
    }


def summary(rows):
    """The table: by effect and all in all."""
    table = []
    rows = [r for r in rows if "skipped" not in r]
    for effect in [*gap_put.EFFECTS, "all"]:
        every = [r for r in rows if effect in ("all", r["effect"])]
        some = [r for r in every if _counts(r)]
        if not every:
            continue
        right = sum(r["named"] for r in some)
        clean = sum(r["untouched"] for r in every if r.get("first", True))
        new = sum(len({n.split()[0] for n in r["new"]}) for r in every)
        low, high = proportion_confint(right, len(some), method="wilson") if some else (0, 1)
        table.append(
            {
                "effect": effect,
                "cases": len(some),
                "named": right,
                "named_sure": sum(r["named_sure"] for r in some),
                "interval": [round(low, 3), round(high, 3)],
                "already": sum(r["already"] for r in every),
                "absorbed": sum(r["absorbed"] for r in every),
                "undetectable": sum(r["gain"] < gap_put.DETECTABLE for r in every),
                "untouched_channels": clean,
                "new_elsewhere": new,
            }
        )
    return table


def _fresh(row):
    """[channel, effect, confidence, right, beside something unexplained, in place of a name that is
    gone] of all that is new; of the last, nobody knows which of the two was right.
    """
    old, new, effect = row["before"]["names"], row["after"], row["effect"]
    names, out = gap_put.NAMES.get(effect, (effect,)), []
    for c, found in new["names"].items():
        gone = sum(e not in found for e in old.get(c, {}))
        for e, sure in found.items():
            if e in old.get(c, {}):
                continue
            right = c in row["on"] and e in names
            instead = not right and gone > 0
            gone -= instead
            out.append([c, e, sure, right, c in new["unexplained"], instead])
    return out


def _counts(row):
    """Whether a case is one that has to be named."""
    return row["gain"] >= gap_put.DETECTABLE and not (row["already"] or row["absorbed"])


def _plan(effects, cases, first, together):
    """Effects take turns; `SHARED` cases in a row look at one stretch. With more than one
    `together` others are drawn beside each.
    """
    out = []
    for i in range(cases):
        for k, effect in enumerate(effects):
            seed = first + i * len(effects) + k
            rng = np.random.default_rng([seed, 17])
            others = [e for e in effects if e not in (effect, "tilt", "time_gaps", "rate_error")]
            drawn = rng.choice(others, min(together - 1, len(others)), replace=False)
            case = {"effect": effect, "seed": seed, "stretch": first + (seed - first) // SHARED}
            out.append({**case, "with": sorted(map(str, drawn))} if together > 1 else case)
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=2, help="of each effect")
    parser.add_argument("--first", type=int, default=500)
    parser.add_argument("--effects", default=",".join(gap_put.EFFECTS))
    parser.add_argument("--log", help="JSON lines; what is there already is not run again")
    parser.add_argument("--drawn", action="store_true", help="records that are drawn")
    parser.add_argument("--together", type=int, default=1, help="effects in a record")
    parser.add_argument("--name", default="gap_injected", help="of the stored table")
    parser.add_argument("--minutes", type=float, default=1e9, help="stop after this time")
    parser.add_argument("--print", action="store_true", help="store nothing")
    args = parser.parse_args()
    data = None if args.drawn else Path(os.environ["IMU_LIB_DATA"])
    log = Log(args.log)
    rows = log.rows
    have = {r["seed"] for r in rows}
    before = {r["key"]: r["before"] for r in rows if "key" in r}
    started = time.time()
    for case in _plan(args.effects.split(","), args.cases, args.first, args.together):
        if case["seed"] in have:
            continue
        if time.time() - started > 60 * args.minutes:
            break
        new = run(case, data, before)
        log.add(*new)
        for row in new:
            if "skipped" not in row:
                _tell(row)
    table = summary(rows)
    for line in table:
        print(line)
    if not args.print:
        content = {
            "command": "python " + " ".join(["benchmarks/gap_injected.py", *sys.argv[1:]]),
            "date": date.today().isoformat(),
            "table": table,
            "cases": [
                {k: v for k, v in r.items() if k not in ("before", "after", "key")}
                | {"fresh": _fresh(r)}
                for r in rows
                if "skipped" not in r
            ],
        }
        (RESULTS / f"{args.name}.json").write_text(json.dumps(content, default=float) + "\n")


def _tell(row):
    verdict = "named" if row["named"] else "MISSED" if _counts(row) else "apart"
    print(verdict, row["effect"], row["seed"], row["record"], row["on"], f"gain {row['gain']:.0f}")
    if verdict == "MISSED" or row["new"]:
        print("   ", row["put_in"])
        for when in ("before", "after"):
            print("   ", when, row[when]["names"], row[when]["unexplained"])
        print("    absorbed", row["after"]["absorbed"], "new elsewhere", row["new"], flush=True)


if __name__ == "__main__":
    main()
