"""Outages on the recorded drives: the paper's five models of a standstill against four numbers for
a module in a car.

    IMU_LIB_DATA=... python benchmarks/recorded_outages.py

Windows of 30 s every 30 s. The five models are read off a static record of the maker's other
module (HiPNUC CH104), for want of one of the same units. "in a car" is white noise and a random
walk for gyros and accelerometers; its four numbers were chosen by hand on span_a, so that span_c
and kth_car judge it and span_a and span_b do not; "+ road" adds that a car does not slide. span_a
and span_b are two modules on one drive.
"""

import json
import os
import time
from pathlib import Path

import numpy as np

from imu_lib.drive import Drive
from imu_lib.navigation import models, outages, preparation, statistics, tuning
from imu_lib.navigation.filter import FilterModel
from imu_lib.readers import read_record

RESULT = Path(__file__).parent / "results" / "recorded_outages.json"
TURN_ON = (3.5e-3, 0.2)  # 0.2 deg/s, 20 mg
IN_A_CAR = (3e-4, 0.05, 3e-5, 3e-3)


def main():
    data = Path(os.environ["IMU_LIB_DATA"])
    static = read_record(data / "static" / "hipnuc_ch104.npz")
    base = models.read_off(static, 100.0)
    five = models.five(base, static=static, turn_on_sd=TURN_ON)
    car = FilterModel("in a car", tuning.vehicle_model(*IN_A_CAR), turn_on_sd=TURN_ON)
    entries = {
        **five,
        "in a car": car,
        "in a car + road": car.with_(name="in a car + road", constraint_sd=0.3),
    }
    content = {
        "command": "python benchmarks/recorded_outages.py",
        "date": time.strftime("%Y-%m-%d"),
        "drives": {},
    }
    pooled = {}
    for name in ("span_a", "span_b", "span_c", "kth_car"):
        drive = Drive.load(data / "drive" / f"{name}.npz")
        gnss = preparation.Gnss(
            accept=(1,) if name == "span_c" else None, velocity_floor=0.15, position_floor=0.5
        )
        windows = outages.regular_windows(drive, duration=30.0, every=30.0, settle=60.0)
        study = outages.compare(drive, entries, windows, gnss=gnss, strict=False)
        errors = {n: study.errors(n, against=study.against[-1]) for n in entries}
        scored = np.isfinite(next(iter(errors.values())))  # where the reference is fit to judge
        errors = {n: e[scored] for n, e in errors.items()}
        content["drives"][name] = {
            "outages": int(scored.sum()),
            "against": study.against[-1],
            "notes": list(study.notes),
            "models": {
                n: {
                    "states": study.models[n].states,
                    "median": statistics.median_interval(e),
                    "mean": float(e.mean()),
                    "predicted": float(
                        np.median(
                            [
                                s[-1]
                                for s, is_scored in zip(study.models[n].sigma, scored)
                                if is_scored
                            ]
                        )
                    ),
                }
                for n, e in errors.items()
            },
        }
        for n, e in errors.items():
            pooled.setdefault(n, []).append(e)
        print(
            name,
            int(scored.sum()),
            {n: round(float(np.median(e)), 1) for n, e in errors.items()},
            flush=True,
        )
    for label, part in (("all", slice(None)), ("not seen", slice(2, None))):
        joined = {n: np.concatenate(e[part]) for n, e in pooled.items()}
        content[label] = {
            "outages": int(joined["18AV"].size),
            "paired": [
                statistics.paired(joined[one], joined[n], (one, n)).to_json()
                for one in ("in a car", "in a car + road", "18AV")
                for n in entries
                if n != one
            ],
        }
    RESULT.write_text(json.dumps(content, indent=1) + "\n")


if __name__ == "__main__":
    main()
