"""Time of the gap workflow on drives of twenty minutes at 100 Hz, outages before and after included.

    python benchmarks/drive_gap_speed.py --first 1

Four drives: nothing hidden, one effect, two, three; fixes at 5 and 10 Hz, smooth and rough roads;
each with its model and without one. Wall time depends on the machine and on what else runs: the
load before, the cores and the processor time are stored beside it.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from datetime import date
from pathlib import Path

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(name, "1")
ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

import drive_generator as generator  # noqa: E402

from imu_lib.drive import from_arrays  # noqa: E402
from imu_lib.gap import drive as gap_drive  # noqa: E402
from imu_lib.model import Model  # noqa: E402

DURATION = 1200.0  # s
LATE = ("gnss_time_offset", {"offset": 0.25})
ARM = ("lever_arm", {"arm": [1.0, 0.4, -1.0]})
CLOCK = ("imu_clock", {"scale": 4e-4})
SCALE = ("gyro_scale", {"scale": [0.02, -0.015, 0.03]})
DRIVES = (
    ("nothing", (), {"gnss_rate": 5.0}),
    ("one effect", (SCALE,), {"gnss_rate": 10.0, "kind": "motorway"}),
    ("two effects", (LATE, ARM), {"gnss_rate": 10.0}),
    ("three effects", (LATE, CLOCK, SCALE), {"gnss_rate": 5.0, "rough": 0.01, "slip": 0.004}),
)
STORED = ROOT / "benchmarks" / "results" / "drive_gap_speed.json"


def timed(hidden, seed, model):
    """A row: what was hidden and found, wall and processor seconds."""
    name, effects, options = hidden
    arrays = generator.make(seed, duration=DURATION, effects=list(effects), **options)
    drive = from_arrays(arrays, name)
    load, wall, work = os.getloadavg()[0], time.perf_counter(), time.process_time()
    found = gap_drive.close(drive, model)
    return {
        "hidden": [e for e, _ in effects], "named": [s["effect"] for s in found.steps],
        "fixes_hz": options["gnss_rate"], "model": model is not None, "seed": seed,
        "wall_s": round(time.perf_counter() - wall, 1),
        "processor_s": round(time.process_time() - work, 1), "load_before": round(load, 2),
    }  # fmt: skip


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--first", type=int, default=1, help="seed of the first drive")
    args = parser.parse_args()
    gap_drive.close(from_arrays(generator.make(0, duration=100.0), "compiled first"))
    rows = []
    for number, hidden in enumerate(DRIVES):
        for model in (Model.from_json(generator.MODEL), None):
            rows.append(timed(hidden, args.first + number, model))
            print(rows[-1], flush=True)
            table = {
                "rows": rows, "cores": os.cpu_count(),
                "command": " ".join(["python benchmarks/drive_gap_speed.py", *sys.argv[1:]]),
                "date": date.today().isoformat(),
            }  # fmt: skip
            STORED.write_text(json.dumps(table, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
