"""Random records in random dresses: how many are read as another value in silence.

`python benchmarks/random_logs.py --seeds 7373 8484 --cases 50` draws records and the ways in which some
logger might write them (unit and kind of stamps, order, delimiter, decimal sign, header, streams
held or in rows of their own), reads each without the answers and with them, and writes
benchmarks/results/random_logs.json: one row a seed.
"""

import argparse
import datetime
import json
import platform
import sys
import tempfile
import time
from pathlib import Path

from hypothesis import HealthCheck, Phase, assume, given, seed, settings

ROOT = Path(__file__).parents[1]
RESULT = Path(__file__).parent / "results" / "random_logs.json"
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

import test_readers_random as writers  # noqa: E402


def run(number: int, cases: int) -> dict:
    """Records drawn from one seed, and what went wrong with each."""
    wrong: list[str] = []
    drawn = [0]
    start = time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.csv"

        @seed(number)
        @settings(
            max_examples=cases,
            deadline=None,
            database=None,
            suppress_health_check=list(HealthCheck),
            phases=(Phase.generate,),
        )
        @given(plan=writers.PLANS)
        def one(plan):
            assume(writers.possible(plan))
            drawn[0] += 1
            said = writers.verdict(path, plan)
            if said:
                wrong.append(f"{said}: {plan}")
                print(wrong[-1], flush=True)

        one()
    spent = round(time.process_time() - start, 1)
    return {"records": drawn[0], "wrong": wrong, "processor_seconds": spent}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, nargs="+", default=[7373, 8484])
    parser.add_argument("--cases", type=int, default=50)
    parser.add_argument("--add", action="store_true", help="keep the seeds that are stored")
    args = parser.parse_args()
    import numpy

    rows = json.loads(RESULT.read_text())["seeds"] if args.add else {}
    for number in args.seeds:
        row = rows[str(number)] = run(number, args.cases)
        print(number, len(row["wrong"]), "wrong of", row["records"], flush=True)
    stored = {
        "seeds": rows,
        "command": f"python benchmarks/random_logs.py --cases {args.cases} --seeds {' '.join(rows)}",
        "date": datetime.date.today().isoformat(),
        "versions": {"python": platform.python_version(), "numpy": numpy.__version__},
    }
    RESULT.write_text(json.dumps(stored, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
