"""What the gap workflow finds on recorded drives, and effects hidden in them.

    IMU_LIB_DATA=FOLDER python benchmarks/drive_gap_real.py     # FOLDER/drive/*.npz; resumes from its table

Each drive is searched as it is, without an error model; then with its stamps shifted by 0.3 s, its
x accelerometer scaled by 1.03, and its axes turned; what is found then is compared with what was
found before. Results go to benchmarks/results/drive_gap_real.json.
"""

from __future__ import annotations

import json
import os
import sys
import time
from datetime import date
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT)]

import numpy as np  # noqa: E402

from imu_lib.drive import Drive  # noqa: E402
from imu_lib.gap import drive as gap_drive  # noqa: E402
from imu_lib.gap.drive import columns  # noqa: E402
from imu_lib.navigation import gross  # noqa: E402

RESULTS = ROOT / "benchmarks" / "results" / "drive_gap_real.json"
SHIFT, SCALE = 0.3, 0.03
TURNED = ("+y", "-x", "+z")


def searched(drive, **options):
    begin = time.process_time()
    found = gap_drive.close(drive, **options)
    result = found.to_json()["drive"]
    for step in result["steps"]:
        step.pop("cause", None)
    result["seconds"] = time.process_time() - begin
    theta = found.state.theta
    result["held"] = {
        "offset": float(theta[columns.of("gnss_time_offset")[0]]),
        "velocity offset": float(theta[columns.of("gnss_time_offset")[1]])
        if found.state.use[:, 3].any()
        else None,
        "scale x": float(theta[columns.of("accel_scale")[0]]),
    }
    return result, found.model


def injected(drive, model):
    """Found beyond what was found before: offset s, scale of x, and the axes."""
    shifted = drive.with_(gnss_time=np.asarray(drive.gnss_time) + SHIFT)
    accel = np.array(drive.accel)
    accel[:, 0] *= 1.0 + SCALE
    c = gross.to_body(TURNED)
    turned = drive.with_(gyro=drive.gyro @ c, accel=drive.accel @ c)
    out = {"axes": {"put in": list(TURNED), "found": list(gross.axes(turned)[0])}}
    options = {"judge": False, "random": False}
    base = searched(drive, model=model, **options)[0]["held"]
    for name, key, put, other in (
        ("stamps shifted", "offset", SHIFT, shifted),
        ("accelerometer scaled", "scale x", SCALE, drive.with_(accel=accel)),
    ):
        held = searched(other, model=model, **options)[0]
        steps = {s["effect"]: s["intervals"] for s in held["steps"]}
        out[name] = {
            "put in": put,
            "found": held["held"][key] - base[key],
            "effects": sorted(steps),
        }
        if key == "offset" and base["velocity offset"] is not None:
            out[name]["found in velocities"] = (
                held["held"]["velocity offset"] - base["velocity offset"]
            )
    return out


def main():
    folder = Path(os.environ["IMU_LIB_DATA"]) / "drive"
    table = json.loads(RESULTS.read_text()) if RESULTS.exists() else {"drives": {}}
    names = sys.argv[1:] or [p.stem for p in sorted(folder.glob("*.npz"))]
    for name in names:
        if name in table["drives"]:
            continue
        drive = Drive.load(folder / f"{name}.npz")
        result, model = searched(drive)
        table["drives"][name] = result
        table |= {
            "command": "python benchmarks/drive_gap_real.py",
            "date": date.today().isoformat(),
        }
        RESULTS.write_text(json.dumps(table, indent=1) + "\n", encoding="utf-8")
        result["hidden"] = injected(drive, model)
        RESULTS.write_text(json.dumps(table, indent=1) + "\n", encoding="utf-8")
        print(name, json.dumps(result["hidden"]), flush=True)


if __name__ == "__main__":
    main()
