"""Effects put into stretches of recorded signals: is the name new there, and nothing new elsewhere?

    python benchmarks/gap_injected.py --cases 2 --log injected.jsonl     # every effect; resumes
    python benchmarks/gap_injected.py --effects ramp,spikes --cases 1 --print

A stretch of a real record is run as it is and with one effect put into it, rounded to the digits of
its file again. The effect counts as named where it is a step of that channel (or of the record with
that channel) that was not there before; `new` counts steps of high confidence on other channels that
were not there before. What is put in is made here, by code that the package does not share. Needs
the folder of recorded data, IMU_LIB_DATA. The table goes to benchmarks/results/gap_injected.json.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from datetime import date
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT)]

import numpy as np  # noqa: E402
from scipy.signal import lfilter  # noqa: E402
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
    ("mtig_gyro_x", 100.0, 40_000),
    ("vn100_still", 40.0, 12_000),
    ("sbg_ig500n", None, 15_000),
    ("memsense_gyros", 250.0, 13_000),
    ("xsens_dot", 120.0, 14_000),
)
#: Names by which each effect may come back: what no record can tell apart.
EFFECTS = {
    "sinusoid": ("sinusoid",),
    "vibration": ("vibration",),
    "step": ("step",),
    "ramp": ("ramp",),
    "warm_up": ("warm_up",),
    "random_walk": ("random_walk", "gauss_markov", "flicker"),
    "gauss_markov": ("gauss_markov", "gauss_markov_2", "flicker"),
    "spikes": ("spikes",),
    "stuck": ("stuck", "held"),
    "saturation": ("saturation",),
    "noise_level_change": ("noise_level_change", "wandering_level"),
    "wandering_level": ("wandering_level",),
    "heavy_tails": ("heavy_tails",),
    "dropout": ("dropout",),
}


def stretch(data: Path, which, rng):
    """(name, rate, channels {name: (n,)}) of a part of a recorded signal; two or three channels."""
    file, rate, n = which
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
    return file, rate, {names[k]: channels[names[k]][start : start + n] for k in keep}


def put(effect, channels, fs, target, rng):
    """The channels with the effect, and the channels that it is on."""
    x = np.array(channels[target])
    n, t = len(x), np.arange(len(x)) / fs
    fast = np.median(np.abs(np.diff(x))) / 0.954 or np.std(np.diff(x)) / np.sqrt(2)
    slow = fast / np.sqrt(n)  # of the mean of all samples
    unit, on = _digits(x), [target]
    out = dict(channels)
    size = rng.uniform(12, 40)
    sign = rng.choice([-1, 1])
    if effect == "sinusoid":
        x = x + 1.5 * size * slow * np.sin(2 * np.pi * rng.uniform(0.12, 0.4) * fs * t)
    elif effect == "vibration":
        line = np.sin(2 * np.pi * (rng.uniform(0.15, 0.4) * fs * t + 0.3 * np.sin(t / 17)))
        line *= (t > 0.2 * t[-1]) & (t < rng.uniform(0.5, 0.8) * t[-1])
        on = list(channels)[:2] if len(channels) > 1 else [target]
        for c in on:
            own = np.std(np.diff(channels[c])) / np.sqrt(2)
            out[c] = _rounded(
                channels[c] + 3 * size * own / np.sqrt(n) * line, _digits(channels[c])
            )
        return out, on
    elif effect == "step":
        x = x + sign * 6 * size * slow * (t > rng.uniform(0.3, 0.7) * t[-1])
    elif effect == "ramp":
        x = x + sign * 12 * size * slow * t / t[-1]
    elif effect == "warm_up":
        x = x + sign * 14 * size * slow * np.exp(-t / (rng.uniform(0.04, 0.12) * t[-1]))
    elif effect == "random_walk":
        x = x + 8 * size * slow * np.cumsum(rng.standard_normal(n)) / np.sqrt(n)
    elif effect == "gauss_markov":
        pole = np.exp(-60 / n)
        x = x + 5 * size * slow * lfilter(
            [np.sqrt(1 - pole**2)], [1, -pole], rng.standard_normal(n)
        )
    elif effect == "spikes":
        hit = rng.random(n) < 40 / n
        x[hit] += 14 * fast * rng.standard_normal(hit.sum())
    elif effect == "stuck":
        for k in rng.integers(0, n - 60, 12):
            x[k : k + 40] = x[k]
    elif effect == "saturation":
        x = np.minimum(x, np.quantile(x, 0.985))
    elif effect == "noise_level_change":
        k = int(rng.uniform(0.3, 0.7) * n)
        smooth = lfilter(np.ones(200) / 200, [1], x - x[0]) + x[0]
        x[k:] = smooth[k:] + 1.5 * (x[k:] - smooth[k:])
    elif effect == "wandering_level":
        pole = np.exp(-40 / n)
        g = lfilter([np.sqrt(1 - pole**2)], [1, -pole], rng.standard_normal(2 * n))[n:]
        x = np.mean(x) + (x - np.mean(x)) * np.exp(0.35 * g)
    elif effect == "heavy_tails":
        x = np.mean(x) + (x - np.mean(x)) * np.sqrt(2.0 / rng.chisquare(4, n))
    elif effect == "dropout":
        hit = rng.random(n) < 0.01
        on = list(channels)
        return {c: np.where(hit, 0.0, v) for c, v in channels.items()}, on
    out[target] = _rounded(x, unit)
    return out, on


def _digits(x):
    u = np.unique(x)
    gap = np.diff(u)
    return float(gap.min()) if len(u) < len(x) / 2 else None


def _rounded(x, unit):
    return x if unit is None else np.rint(x / unit) * unit


def named(found):
    """{channel: set of effects} of a report; what is on the record is on each of its channels."""
    out = {}
    for where, s in found.steps:
        on = s.parameters.get("channels") or (
            list(found.channels) if where == "record" else [where]
        )
        for c in on:
            out.setdefault(c, {})[s.effect] = s.confidence
    return out


def run(case, data):
    """One case: names before and after."""
    rng = np.random.default_rng([case["seed"], 11])
    which = RECORDS[case["seed"] % len(RECORDS)]
    file, fs, channels = stretch(data, which, rng)
    target = list(channels)[int(rng.integers(len(channels)))]
    changed, on = put(case["effect"], channels, fs, target, rng)
    before = named(close(Record(channels, fs), simulations=0, jobs=1))
    after = named(close(Record(changed, fs), simulations=0, jobs=1))
    hit, other = False, []
    for c in channels:
        fresh = {e: s for e, s in after.get(c, {}).items() if e not in before.get(c, {})}
        if c in on:
            hit |= any(e in EFFECTS[case["effect"]] for e in after.get(c, {})) and (
                bool(set(fresh) & set(EFFECTS[case["effect"]]))
                or case["effect"] in before.get(c, {})
            )
        else:
            other += [f"{c} {e}" for e, s in fresh.items() if s >= SURE]
    return {
        **case,
        "record": file,
        "on": on,
        "before": before,
        "after": after,
        "already": case["effect"] in before.get(target, {}),
        "named": bool(hit),
        "new": other,
        "untouched": len([c for c in channels if c not in on]),
    }


def summary(rows):
    """The table: by effect and all in all."""
    table = []
    for effect in [*EFFECTS, "all"]:
        some = [r for r in rows if effect in ("all", r["effect"]) and not r["already"]]
        if not some:
            continue
        right = sum(r["named"] for r in some)
        clean = sum(r["untouched"] for r in some)
        new = sum(len({n.split()[0] for n in r["new"]}) for r in some)
        low, high = proportion_confint(right, len(some), method="wilson")
        table.append(
            {
                "effect": effect,
                "cases": len(some),
                "named": right,
                "interval": [round(low, 3), round(high, 3)],
                "untouched_channels": clean,
                "new_elsewhere": new,
            }
        )
    return table


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=2, help="of each effect")
    parser.add_argument("--first", type=int, default=500)
    parser.add_argument("--effects", default=",".join(EFFECTS))
    parser.add_argument("--log", help="JSON lines; what is there already is not run again")
    parser.add_argument("--print", action="store_true", help="store nothing")
    args = parser.parse_args()
    data = Path(os.environ["IMU_LIB_DATA"])
    log = Path(args.log) if args.log else None
    rows = [json.loads(r) for r in log.read_text().splitlines()] if log and log.exists() else []
    have = {(r["effect"], r["seed"]) for r in rows}
    cases = [
        {"effect": e, "seed": args.first + 17 * k + i}
        for i in range(args.cases)
        for k, e in enumerate(args.effects.split(","))
    ]
    for case in cases:
        if (case["effect"], case["seed"]) in have:
            continue
        row = run(case, data)
        rows.append(row)
        if log:
            with log.open("a") as handle:
                handle.write(json.dumps(row) + "\n")
        print(
            row["effect"],
            row["record"],
            row["on"],
            "named" if row["named"] else row["after"],
            row["new"],
            flush=True,
        )
    table = summary(rows)
    for line in table:
        print(line)
    if not args.print:
        content = {
            "command": "python " + " ".join(["benchmarks/gap_injected.py", *sys.argv[1:]]),
            "date": date.today().isoformat(),
            "table": table,
            "cases": [{k: v for k, v in r.items() if k not in ("before", "after")} for r in rows],
        }
        (RESULTS / "gap_injected.json").write_text(json.dumps(content, indent=1) + "\n")


if __name__ == "__main__":
    main()
