"""The filter with all fixes on the recorded drives: is its position as good as the fixes
themselves?

    IMU_LIB_DATA=... python benchmarks/filter_real.py

Horizontal RMS distance from the reference, of the fixes and of the 15-state filter (white noise
and random walks of a module in a car), over the whole drive; of span_c the fixes of all codes and
of the single-point receiver alone.
"""

import json
import os
import time
from pathlib import Path

import numpy as np

from imu_lib.drive import Drive
from imu_lib.navigation import earth, tuning
from imu_lib.navigation.filter import FilterModel, run
from imu_lib.navigation.preparation import Gnss

RESULT = Path(__file__).parent / "results" / "filter_real.json"
MODEL = FilterModel(
    "in a car", tuning.vehicle_model(3e-4, 0.05, 3e-5, 3e-3), turn_on_sd=(3.5e-3, 0.2)
)


def distance(drive, when, position):
    truth = np.column_stack(
        [np.interp(when, drive.reference_time, c) for c in np.asarray(drive.reference_position).T]
    )
    return float(np.sqrt(np.mean(earth.horizontal(position, truth) ** 2)))


def main():
    data = Path(os.environ["IMU_LIB_DATA"]) / "drive"
    content = {
        "command": "python benchmarks/filter_real.py",
        "date": time.strftime("%Y-%m-%d"),
        "drives": {},
    }
    for name in ("span_a", "span_b", "span_c"):
        drive = Drive.load(data / f"{name}.npz")
        solution = run(
            drive,
            MODEL,
            gnss=Gnss(
                velocity_floor=0.15, position_floor=0.5, accept=(1,) if name == "span_c" else None
            ),
        )
        used = drive.gnss_fix == 1
        content["drives"][name] = {
            "fixes": distance(drive, drive.gnss_time, drive.gnss_position),
            "fixes used": distance(drive, drive.gnss_time[used], drive.gnss_position[used]),
            "filter": distance(drive, solution.time, solution.position),
            "notes": list(solution.notes),
        }
        print(name, content["drives"][name])
    RESULT.write_text(json.dumps(content, indent=1) + "\n")


if __name__ == "__main__":
    main()
