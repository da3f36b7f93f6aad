"""Time of the gap workflow on six channels of a minute and of an hour at 100 Hz, ensembles of a
hundred included.

    python benchmarks/gap_speed.py --first 1

Three records of each length: nothing hidden, an effect in one channel, effects in four channels;
each with its model and without one. Wall time depends on the machine and on what else runs: the load before, the
cores and the processor time of all processes are stored beside it, and the peak memory of the
process and of the largest of those that it starts (copies of it, which share what it has).
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import sys
import time
from datetime import date
from pathlib import Path

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(name, "1")
ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

import gap_generator as generator  # noqa: E402

from imu_lib.gap import close  # noqa: E402
from imu_lib.model import Model  # noqa: E402
from imu_lib.record import Record  # noqa: E402

HIDDEN = {
    "nothing": (),
    "one effect": ("gauss_markov",),
    "four effects": ("resolution", "step", "sinusoid", "low_pass"),
}

#: Lengths of the records, s.
LENGTHS = (60.0, 3600.0)


def used() -> float:
    """Processor time of this process and of those that it started and that have ended, s."""
    return sum(
        sum(resource.getrusage(which)[:2])
        for which in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    )


def timed(record: Record, model: Model | None) -> dict:
    """What the workflow takes for one record, and what it finds."""
    load = os.getloadavg()[0]
    started, processor = time.perf_counter(), used()
    found = close(record, model, jobs=2)
    return {
        "model": model is not None,
        "seconds": round(time.perf_counter() - started, 1),
        "processor": round(used() - processor, 1),
        "load_before": round(load, 2),
        "found": [s.effect for _, s in found.steps],
    }


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--first", type=int, default=1, help="first seed")
    args = parser.parse_args(argv)
    rows = []
    for duration in LENGTHS:
        for i, (what, effects) in enumerate(HIDDEN.items()):
            made = generator.make(args.first + i, effects, duration=duration)
            record = Record(made.channels, made.fs, temperature=made.temperature)
            for model in (Model.from_json(made.base), None):
                rows.append({"hidden": what, "duration": duration, **timed(record, model)})
                print(rows[-1], flush=True)
    command = " ".join(["python", "benchmarks/gap_speed.py", *(argv or sys.argv[1:])])
    out = {
        "command": command,
        "date": date.today().isoformat(),
        "cores": os.cpu_count(),
        "simulations": 100,
        "peak_mib": {
            who: round(resource.getrusage(which).ru_maxrss / 1024)
            for who, which in (
                ("process", resource.RUSAGE_SELF),
                ("largest_child", resource.RUSAGE_CHILDREN),
            )
        },
        "rows": rows,
    }
    (ROOT / "benchmarks" / "results" / "gap_speed.json").write_text(
        json.dumps(out, indent=1) + "\n"
    )


if __name__ == "__main__":
    main()
