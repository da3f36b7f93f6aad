"""What knowing the vehicle, the stamps and the scale factors is worth on the recorded drives.

    IMU_LIB_DATA=... python benchmarks/drive_additions.py [DRIVE ...]

The 18-state filter with the 2013 paper's noise on the recorded drives, 30 s outages every 30 s: as
it is, and with what `imu-lib outages --models 18AV+...` adds. "late" holds the lateness of the
fixes that the innovations ask for. Standard deviations of the fixes are as large as the
innovations ask. Errors are against the reference where it is fit, else against the same filter's
full-GNSS solution.
"""

import json
import os
import sys
import time
from pathlib import Path

import numpy as np

from imu_lib.drive_effects import DriveEffect
from imu_lib.navigation import models, outages, statistics, time_error, variants
from imu_lib.navigation.preparation import Gnss
from imu_lib.readers import read_drive
from imu_lib.units import DEG, MILLI_G

RESULT = Path(__file__).parent / "results" / "drive_additions.json"
DRIVES = ("everett", "kth_car", "mtig710", "span_a", "span_b", "span_c")
ADDITIONS = ((), ("road",), ("scale",), ("scale", "road"))


def entries(drive, found):
    """Filter models by name: with each addition, and again with the stamps put right."""
    base = models.five(names=("18AV",), turn_on_sd=(0.2 * DEG, 20.0 * MILLI_G))["18AV"]
    if found.velocity_offset is None:
        own = {}
    else:
        own = {"velocity_offset": found.velocity_offset}
    late = DriveEffect("gnss_time_offset", {"offset": found.offset, **own})
    out = {}
    for held in ((), (late,)):
        for extras in ADDITIONS:
            name = "+".join(("18AV", *extras, *(("late",) if held else ())))
            out[name] = variants.varied(base.with_(effects=held), extras, drive, name=name)
    return out


def main():
    data = Path(os.environ["IMU_LIB_DATA"])
    before = json.loads(RESULT.read_text())["drives"] if RESULT.exists() else {}
    content = {
        "command": "python benchmarks/drive_additions.py",
        "date": time.strftime("%Y-%m-%d"),
        "drives": {name: before[name] for name in DRIVES if name in before},
    }
    for name in sys.argv[1:] or DRIVES:
        drive = read_drive(data / "drive" / f"{name}.npz")
        plain = models.five(names=("18AV",), turn_on_sd=(0.2 * DEG, 20.0 * MILLI_G))["18AV"]
        found = time_error.time_error(drive, plain, gnss=Gnss())
        windows = outages.regular_windows(drive, duration=30.0, every=30.0)
        rows, against = {}, None
        # with the stamps put right the fixes are as good as their innovations then say
        for late, gnss in ((False, found.gnss), (True, found.corrected)):
            part = {n: m for n, m in entries(drive, found).items() if n.endswith("late") == late}
            study = outages.compare(drive, part, windows, gnss=gnss, strict=False)
            against = study.scored_against
            for n, m in study.models.items():
                e = study.errors(n, against=against)
                rows[n] = {
                    "median": statistics.median_interval(e[np.isfinite(e)]),
                    "predicted": float(np.median([s[-1] for s in m.sigma])),
                    "over_predicted": m.over_predicted(against),
                    "nis": m.nis,
                    "rejected": m.rejected,
                }
        content["drives"][name] = {
            "outages": len(study.windows),
            "against": against,
            "offset": found.offset,
            "velocity_offset": found.velocity_offset,
            "nats": found.gain,
            "models": rows,
        }
        print(name, round(found.offset, 2), found.velocity_offset, round(found.gain), flush=True)
        for n, row in rows.items():
            print(
                f"   {n:22s} median {row['median'][0]:6.1f} m, predicted {row['predicted']:6.1f} "
                f"m, NIS {row['nis']:.2f}, rejected {100 * max(row['rejected'].values()):.0f} %",
                flush=True,
            )
    RESULT.write_text(json.dumps(content, indent=1) + "\n")


if __name__ == "__main__":
    main()
