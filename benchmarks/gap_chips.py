"""What noise and its spectrum do in records whose noise nobody assumed: which names come back?

    python benchmarks/gap_chips.py --cases 5 --first 100 --minutes 8 --log chips.jsonl   # resumes

Channels are drawn by tests/gap_chips.py and looked at without a model and without simulations. A
case is right where a name of its kind has a confidence above one half; a name counts as wrong where
it is neither of the kind nor of what every record has (a power law, a filter, a grid). The table
goes to benchmarks/results/gap_chips.json, whose cases `gap_reliability.py` counts.
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
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

import gap_chips  # noqa: E402
from _log import Log  # noqa: E402

from imu_lib.gap import close  # noqa: E402
from imu_lib.record import Record  # noqa: E402

RESULTS = ROOT / "benchmarks" / "results"
CHANNEL = "gyro_x"
EVEN = 0.5


def run(kind: str, seed: int) -> dict:
    fs, x, right = gap_chips.record(kind, seed)
    found = close(Record({CHANNEL: x}, fs), simulations=0, jobs=1)
    told = {c: r.result.unexplained for c, r in found.channels.items() if r.result.unexplained}
    steps = [
        {
            "effect": s.effect,
            "channel": CHANNEL,
            "confidence": round(float(s.confidence), 4),
            "calibrated": True,
            "parameters": {
                k: v for k, v in s.to_json()["parameters"].items() if k in ("frequency", "duration")
            },
        }
        for _, s in found.steps
    ]
    truths = [{"effect": e, "channel": CHANNEL} for e in right]
    return {"kind": kind, "seed": seed, "steps": steps, "unexplained": told, "truths": truths}


def judged(case: dict) -> dict:
    """Surest name of its kind, and the wrong names above one half."""
    own, every = gap_chips.KINDS[case["kind"]], {t["effect"] for t in case["truths"]}
    sure = max((s["confidence"] for s in case["steps"] if s["effect"] in own), default=0.0)
    wrong = [
        s["effect"] for s in case["steps"] if s["confidence"] > EVEN and s["effect"] not in every
    ]
    return {"sure": sure, "wrong": wrong}


def summary(cases: list[dict]) -> list[dict]:
    out = []
    for kind in (*gap_chips.KINDS, "all"):
        some = [c for c in cases if kind in ("all", c["kind"])]
        if not some:
            continue
        asked = [judged(c)["sure"] for c in some if gap_chips.KINDS[c["kind"]]]
        out.append(
            {
                "kind": kind,
                "cases": len(some),
                "asked": len(asked),
                "named": sum(s > EVEN for s in asked),
                "unsure": sum(0 < s <= EVEN for s in asked),
                "wrong": [w for c in some for w in judged(c)["wrong"]],
                "unexplained": sum(bool(c["unexplained"]) for c in some),
            }
        )
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=3, help="of each kind")
    parser.add_argument("--first", type=int, default=100)
    parser.add_argument("--kinds", default=",".join(gap_chips.KINDS))
    parser.add_argument("--log", help="JSON lines; what is there already is not run again")
    parser.add_argument("--minutes", type=float, default=1e9, help="stop after this time")
    parser.add_argument("--print", action="store_true", help="store nothing")
    args = parser.parse_args()
    log = Log(args.log)
    cases = log.rows
    have, started = {(c["kind"], c["seed"]) for c in cases}, time.time()
    for seed in range(args.first, args.first + args.cases):
        for kind in args.kinds.split(","):
            if (kind, seed) in have or time.time() - started > 60 * args.minutes:
                continue
            log.add(run(kind, seed))
            names = {s["effect"]: s["confidence"] for s in cases[-1]["steps"]}
            print(kind, seed, judged(cases[-1]), names, cases[-1]["unexplained"], flush=True)
    table = summary(cases)
    for line in table:
        print(line)
    if not args.print:
        content = {
            "command": "python " + " ".join(["benchmarks/gap_chips.py", *sys.argv[1:]]),
            "date": date.today().isoformat(),
            "table": table,
            "cases": cases,
        }
        (RESULTS / "gap_chips.json").write_text(json.dumps(content) + "\n")


if __name__ == "__main__":
    main()
