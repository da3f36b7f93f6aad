"""False alarms of the gap workflow on channels in which nothing is hidden.

    python benchmarks/gap_null.py --channels 1000 --first 500000

Single channels drawn from base models of six kinds by the generator of the blind tests; what is found or left unexplained
is a false alarm. Also the best candidate of every channel is kept, from which the acceptance threshold is read.
"""
from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections import Counter
from datetime import date
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests"), str(ROOT / "benchmarks")]

import gap_generator as generator  # noqa: E402
import numpy as np  # noqa: E402
from gap_score import wilson  # noqa: E402

from imu_lib.gap.channel import analyse  # noqa: E402
from imu_lib.processes import Sum, from_json  # noqa: E402


def run(seed, *, free=False):
    """One channel: (effects found, unexplained)."""
    rng = np.random.default_rng([seed, 5])
    duration, fs = [(3600.0, 100.0), (3600.0, 100.0), (1800.0, 100.0)][int(rng.integers(3))]
    made = generator.make(seed, (), duration=duration, fs=fs, channels=("gyro_x",))
    base = Sum.of(from_json(e) for e in made.base["gyro_x"])
    found = analyse("gyro_x", made.channels["gyro_x"], fs, None if free else base, temperature=made.temperature)
    return {"seed": seed, "base": [e["process"] for e in made.base["gyro_x"]], "duration": duration,
            "found": [(s.effect, round(s.confidence, 3), round(min(s.gain, 1e6), 2)) for s in found.steps],
            "unexplained": found.unexplained, "checks": {c.where[:40]: round(c.log_p, 2) for c in sorted(found.checks, key=lambda c: c.log_p)[:1]}}


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--channels", type=int, default=1000)
    parser.add_argument("--first", type=int, default=500000)
    parser.add_argument("--minutes", type=float, default=1e9)
    parser.add_argument("--free", action="store_true")
    parser.add_argument("--name", default="gap_null")
    args = parser.parse_args(argv)
    rows, started = [], time.time()
    for i in range(args.channels):
        if time.time() - started > 60 * args.minutes:
            break
        r = run(args.first + i, free=args.free)
        rows.append(r)
        if r["found"] or r["unexplained"]:
            print(r, flush=True)
        if i % 25 == 24 or i == args.channels - 1:
            _store(rows, args, argv)
    _store(rows, args, argv)


def _store(rows, args, argv):
    alarms = [r for r in rows if r["found"] or r["unexplained"]]
    out = {"command": "python " + " ".join(["benchmarks/gap_null.py", *(argv or sys.argv[1:])]), "date": date.today().isoformat(), "free_base": args.free,
           "channels": len(rows), "false_alarms": len(alarms), "share": round(len(alarms) / max(len(rows), 1), 5), "interval": wilson(len(alarms), len(rows)),
           "by_effect": dict(Counter(e[0] for r in rows for e in r["found"])), "unexplained": sum(bool(r["unexplained"]) for r in rows), "alarms": alarms}
    path = ROOT / "benchmarks" / "results" / f"{args.name}.json"
    path.parent.mkdir(exist_ok=True)
    path.write_text(json.dumps(out, indent=1, default=float) + "\n")


if __name__ == "__main__":
    main()
