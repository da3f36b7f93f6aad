"""How long does an epoch take? Covariance at every IMU epoch, one core, after compilation.

    python benchmarks/filter_speed.py

Fifteen simulated minutes at 100 Hz; the least of `REPEATS` runs, as processor time and as wall
time of the whole run (alignment and logs included), divided by the number of IMU epochs. Last,
five models times seven outages times two drives.
"""

import json
import platform
import time
from pathlib import Path

import numba
import numpy as np

from imu_lib import preset
from imu_lib.navigation import models, outages, simulation, turin
from imu_lib.navigation.filter import FilterModel, LooselyCoupled

RESULT = Path(__file__).parent / "results" / "filter_speed.json"
REPEATS = 7


def epoch_times(drive, model):
    engine = LooselyCoupled(drive, model)
    solution = engine.solve(moments=[])
    runs = []
    for _ in range(REPEATS):
        cpu, wall = time.process_time(), time.perf_counter()
        engine.solve(moments=[])
        runs.append((time.process_time() - cpu, time.perf_counter() - wall))
    cpu, wall = np.min(runs, axis=0) / solution.time.size * 1e6
    return {
        "states": engine.states,
        "cpu_us": round(float(cpu), 3),
        "wall_us": round(float(wall), 3),
    }


def main():
    truth, paper = preset("3dm-gx3-25"), preset("3dm-gx3-25-2013")
    rows = []
    for rate in (1.0, 10.0):
        drive = simulation.simulate_drive(
            turin.drive(2), truth, np.random.default_rng(1), gnss=simulation.GnssErrors(rate=rate)
        )
        entries = models.five(names=("15AV", "18AV", "27AR"))
        entries["18AV and six scale factors"] = FilterModel("scale", paper, scale_sd=(0.01, 0.01))
        for name, model in entries.items():
            rows.append({"model": name, "fixes_hz": rate, **epoch_times(drive, model)})
            print(rows[-1])
    cpu, wall = time.process_time(), time.perf_counter()
    five = models.five()
    for number in (1, 2):
        drive = simulation.simulate_drive(turin.drive(number), truth, np.random.default_rng(number))
        outages.compare(drive, five, [(o.start, o.duration) for o in turin.outages_of(number)])
    study = {
        "cpu_s": round(time.process_time() - cpu, 2),
        "wall_s": round(time.perf_counter() - wall, 2),
    }
    print("five models x seven outages x two drives", study)
    RESULT.parent.mkdir(exist_ok=True)
    RESULT.write_text(
        json.dumps(
            {
                "command": "python benchmarks/filter_speed.py",
                "date": time.strftime("%Y-%m-%d"),
                "machine": f"{platform.machine()}, numba {numba.__version__}, numpy "
                f"{np.__version__}",
                "epochs": rows,
                "five_models_seven_outages_two_drives": study,
            },
            indent=1,
        )
        + "\n"
    )


if __name__ == "__main__":
    main()
