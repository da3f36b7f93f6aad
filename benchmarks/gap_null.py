"""False alarms of the gap workflow on channels and on whole records in which nothing is hidden.

    python benchmarks/gap_null.py --channels 1000 --first 500000
    python benchmarks/gap_null.py --wide --channels 300 --first 700000    # 20 s to 24 h, 4 to 1000 Hz
    python benchmarks/gap_null.py --records 200 --first 600000 --log null.jsonl    # goes on from it
    python benchmarks/gap_null.py --records 200 --first 600000 --log null.jsonl --part 0/2  # a half

Single channels, or whole records of six channels (one hour, 100 Hz, even time stamps, all checks of
the record: noise in common, missing samples, jitter, coherence), drawn from base models of six
kinds by the generator of the blind tests. What is named or left unexplained is a false alarm; a record is
one alarm whatever raised it, and so is one on which the workflow fails. The results go to
benchmarks/results/gap_null.json or gap_null_records.json with the command, the date and the seeds.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections import Counter
from datetime import date
from functools import partial
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests"), str(ROOT / "benchmarks")]

import gap_generator as generator  # noqa: E402
import numpy as np  # noqa: E402
from gap_score import RESULTS, wilson  # noqa: E402

from imu_lib.gap import close  # noqa: E402
from imu_lib.gap.channel import analyse  # noqa: E402
from imu_lib.model import Model  # noqa: E402
from imu_lib.processes import Sum, from_json  # noqa: E402
from imu_lib.record import Record  # noqa: E402

#: Lengths, s, and rates, Hz, of the channels; the wide table has each equally often.
USUAL = [(3600.0, 100.0), (3600.0, 100.0), (1800.0, 100.0)]
WIDE = [
    (20.0, 100.0),
    (60.0, 100.0),
    (120.0, 100.0),
    (600.0, 100.0),
    (7200.0, 100.0),
    (20.0, 1000.0),
    (120.0, 1000.0),
    (900.0, 1000.0),
    (60.0, 200.0),
    (3600.0, 4.0),
    (20000.0, 4.0),
    (86400.0, 4.0),
    (86400.0, 25.0),
]


def run_channel(seed, *, free=False, wide=False):
    """One channel: what was found, what was left unexplained, the closest check."""
    rng = np.random.default_rng([seed, 5])
    places = WIDE if wide else USUAL
    duration, fs = places[int(rng.integers(len(places)))]
    made = generator.make(seed, (), duration=duration, fs=fs, channels=("gyro_x",))
    base = Sum.of(from_json(e) for e in made.base["gyro_x"])
    found = analyse(
        "gyro_x", made.channels["gyro_x"], fs, None if free else base, temperature=made.temperature
    )
    return {
        "seed": seed,
        "base": [e["process"] for e in made.base["gyro_x"]],
        "duration": duration,
        "rate": fs,
        "found": [_short(s) for s in found.steps],
        "unexplained": found.unexplained,
        "checks": {
            c.where[:40]: round(c.log_p, 2) for c in sorted(found.checks, key=lambda c: c.log_p)[:1]
        },
    }


def run_record(seed, *, free=False):
    """One record of six channels: what was found and left unexplained, by channel and on the
    record; only what is not empty.
    """
    made = generator.make(seed, (), duration=3600.0, fs=100.0, channels=generator.CHANNELS)
    n = len(made.channels["gyro_x"])
    record = Record(
        made.channels, made.fs, time=np.arange(n) / made.fs, temperature=made.temperature
    )
    started = time.perf_counter()
    report = close(record, None if free else Model.from_json(made.base), simulations=0, jobs=1)
    found, left = (
        {},
        {c: r.result.unexplained for c, r in report.channels.items()}
        | {"record": report.record_unexplained},
    )
    for where, step in report.steps:
        found.setdefault(where, []).append(_short(step))
    return {
        "seed": seed,
        "base": {c: [e["process"] for e in made.base[c]] for c in made.channels},
        "temperature": made.temperature is not None,
        "found": found,
        "unexplained": {c: text for c, text in left.items() if text},
        "seconds": round(time.perf_counter() - started, 2),
    }


def _short(step):
    return (
        step.effect,
        round(step.confidence, 3),
        None if step.gain is None else round(min(step.gain, 1e6), 2),
    )


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--channels", type=int, default=1000)
    parser.add_argument(
        "--records",
        type=int,
        metavar="K",
        help="count K whole records of six channels instead of single channels",
    )
    parser.add_argument(
        "--wide", action="store_true", help="channels of 20 s to 24 h at 4 Hz to 1 kHz"
    )
    parser.add_argument("--first", type=int, default=500000)
    parser.add_argument("--minutes", type=float, default=1e9, help="stop after this time")
    parser.add_argument(
        "--free", action="store_true", help="fit the base model instead of giving the true one"
    )
    parser.add_argument(
        "--log", help="a file of finished cases, one a line; a run that finds it goes on from there"
    )
    parser.add_argument(
        "--part",
        default="0/1",
        metavar="I/K",
        help="run every Kth case from the Ith on, into --log only",
    )
    parser.add_argument(
        "--name", help="of the stored result; gap_null or gap_null_records where not given"
    )
    args = parser.parse_args(argv)
    part, parts = map(int, args.part.split("/"))
    if parts > 1 and not args.log:
        parser.error("--part needs --log")
    run = partial(run_channel, wide=args.wide) if args.records is None else run_record
    seeds = range(
        args.first, args.first + (args.channels if args.records is None else args.records)
    )
    log = Path(args.log) if args.log else None
    lines = log.read_text().splitlines() if log and log.exists() else []
    rows = {
        r["seed"]: r
        for r in map(json.loads, lines)
        if r["seed"] in seeds and r["free"] == args.free and "failed" not in r
    }
    started = time.time()
    for i, seed in enumerate(seeds[part::parts]):
        if time.time() - started > 60 * args.minutes:
            break
        if seed in rows:
            continue
        try:
            row = run(seed, free=args.free)
        except (
            Exception
        ) as error:  # an untouched record that the workflow cannot answer counts as an alarm
            row = {"seed": seed, "found": {}, "unexplained": {}, "failed": repr(error)}
        rows[seed] = row = {**row, "free": args.free}
        if log:
            with log.open("a") as file:
                file.write(json.dumps(row, default=float) + "\n")
        if _alarm(row):
            print(row, flush=True)
        if i % 25 == 24 and parts == 1:
            _store(rows, args, argv)
    if parts == 1:
        _store(rows, args, argv)


def _alarm(row):
    return bool(row["found"] or row["unexplained"] or row.get("failed"))


def _store(rows, args, argv):
    rows = [rows[seed] for seed in sorted(rows)]
    alarms = [r for r in rows if _alarm(r)]
    out = {
        "command": "python " + " ".join(["benchmarks/gap_null.py", *(argv or sys.argv[1:])]),
        "date": date.today().isoformat(),
        "free_base": args.free,
        "seeds": [rows[0]["seed"], rows[-1]["seed"]] if rows else [],
        "channels" if args.records is None else "records": len(rows),
        "false_alarms": len(alarms),
        "share": round(len(alarms) / max(len(rows), 1), 5),
        "interval": wilson(len(alarms), len(rows)),
        "failed": sum("failed" in r for r in rows),
    }
    if args.records is None:
        out |= {
            "by_effect": dict(Counter(e[0] for r in rows for e in r["found"])),
            "unexplained": sum(bool(r["unexplained"]) for r in rows),
        }
        if args.wide:
            out["table"] = _by_size(rows)
    else:
        out |= {
            "by_effect": dict(
                Counter(e[0] for r in rows for steps in r["found"].values() for e in steps)
            ),
            "table": _table(rows),
            "seconds": float(np.median([r["seconds"] for r in rows if "seconds" in r] or [0.0])),
        }
    RESULTS.mkdir(exist_ok=True)
    usual = "gap_null_wide" if args.wide else "gap_null"
    name = args.name or (usual if args.records is None else "gap_null_records")
    (RESULTS / f"{name}.json").write_text(
        json.dumps({**out, "alarms": alarms}, indent=1, default=float) + "\n"
    )


def _by_size(rows):
    """Alarms by length and rate of the channel."""
    out = []
    for duration, fs in WIDE:
        part = [r for r in rows if (r.get("duration"), r.get("rate")) == (duration, fs)]
        alarms = sum(map(_alarm, part))
        out.append(
            {
                "duration": duration,
                "rate": fs,
                "channels": len(part),
                "alarms": alarms,
                "interval": wilson(alarms, len(part)),
            }
        )
    return out


def _table(rows):
    """Alarms where they were raised: each channel, and what acts on the record."""
    out = []
    for where in (*generator.CHANNELS, "record"):
        named, left = ([bool(r[key].get(where)) for r in rows] for key in ("found", "unexplained"))
        alarms = sum(a or b for a, b in zip(named, left))
        out.append(
            {
                "where": where,
                "records": len(rows),
                "named": sum(named),
                "unexplained": sum(left),
                "alarms": alarms,
                "interval": wilson(alarms, len(rows)),
            }
        )
    return out


if __name__ == "__main__":
    main()
