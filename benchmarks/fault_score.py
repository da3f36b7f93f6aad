"""Score of the detectors of faults and disturbances on records in which one was put, and on sound
ones.

    python benchmarks/fault_score.py --cases 40 --first 1000        # every kind, sound records;
    stores the table python benchmarks/fault_score.py --kinds tilt,knock --cases 10 --print

The generator (tests/fault_generator.py) shares no code with the package. A fault counts as found if
its kind, its time (1 s, or four samples), and its channels and rows, rate or angle are right and no
other of its kind is reported. Any finding of another kind is a false one. Sound records: any
finding at all that is more than told (jitter, a clock's grain) is a false alarm. The table goes to
benchmarks/results/fault_score.json with the command, the date and the seeds.
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
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

import fault_generator as generator  # noqa: E402
import numpy as np  # noqa: E402
from fault_judge import judge  # noqa: E402
from statsmodels.stats.proportion import proportion_confint  # noqa: E402

from imu_lib import faults  # noqa: E402
from imu_lib.record import Record  # noqa: E402

RESULTS = ROOT / "benchmarks" / "results"


#: Kind put in -> kind of the finding, where they differ.
FINDING = {
    **dict.fromkeys(("zero", "copy", "code", "nan"), "dropout"),
    **dict.fromkeys(("knock", "handling"), "disturbance"),
    "turned_in_hole": "tilt",
}


def record_of(case):
    """The case as a record, without stamps where it has none."""
    return Record(case.channels, case.rate, time=case.time)


def run(seed, kind, show):
    case = generator.make(seed, kind)
    record = record_of(case)
    started = time.process_time()
    findings = faults.find(record)
    spent = time.process_time() - started
    found, wrong = judge(case, findings)
    if show and (found is False or wrong):
        truth = {k: v for k, v in case.truth.items() if k != "rows"}
        print(f"{kind or 'sound'} {seed}: {case.base} {case.rate:g} Hz, {record.n} rows, {truth}")
        for f in findings:
            print(f"    {f.kind}: {f.sentence}")
    return found, wrong, spent / record.n


def wilson(count, total):
    if not total:
        return {"count": 0, "of": 0}
    low, high = proportion_confint(count, total, method="wilson")
    return {"count": int(count), "of": int(total), "low": round(low, 4), "high": round(high, 4)}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=40)
    parser.add_argument("--sound", type=int, default=200)
    parser.add_argument("--first", type=int, default=1000)
    parser.add_argument("--kinds", default=",".join(generator.KINDS))
    parser.add_argument("--print", action="store_true", help="store nothing")
    args = parser.parse_args()
    kinds = [k for k in args.kinds.split(",") if k]
    table, named, false, cost = {}, Counter(), Counter(), []
    for kind in kinds:
        hits = 0
        for seed in range(args.first, args.first + args.cases):
            found, wrong, spent = run(seed, kind, True)
            hits += found
            named[FINDING.get(kind, kind)] += found
            false.update(set(wrong))
            cost.append(spent)
        table[kind] = wilson(hits, args.cases)
        print(f"{kind:<15}{hits:>5} of {args.cases}", flush=True)
    alarms = 0
    for seed in range(args.first, args.first + args.sound):
        _, wrong, spent = run(seed, None, True)
        alarms += bool(wrong)
        false.update(set(wrong))
        cost.append(spent)
    print(f"false alarms   {alarms:>5} of {args.sound} sound records")
    total = sum(t["count"] for t in table.values())
    right = {
        kind: wilson(named[kind], named[kind] + false[kind])
        for kind in ("dropout", "disturbance", "tilt")
    }
    print(f"all            {total:>5} of {args.cases * len(kinds)}; false: {dict(false)}; {right}")
    print(f"{1e6 * np.median(cost):.2g} s a million rows of six channels")
    if args.print:
        return
    RESULTS.mkdir(exist_ok=True)
    content = {
        "command": "python benchmarks/fault_score.py " + " ".join(sys.argv[1:]),
        "date": date.today().isoformat(),
        "found": table,
        "all": wilson(total, args.cases * len(kinds)),
        "false_alarms_on_sound_records": wilson(alarms, args.sound),
        "false_findings": dict(false),
        "right_of_those_named": right,
        "seconds_a_million_rows": round(1e6 * float(np.median(cost)), 3),
    }
    (RESULTS / "fault_score.json").write_text(json.dumps(content, indent=1) + "\n")


if __name__ == "__main__":
    main()
