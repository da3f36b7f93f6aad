"""The 2008 paper's update-interval study with many drives: how the error grows, and which noise
model wins by how much.

    python benchmarks/calibration_update_interval.py [--runs 200]

Writes benchmarks/results/update_interval.json: pooled horizontal RMS errors per interval, model
and ground, the paired ratio of
AR(4) to GM(1) with its 95 % interval, how often a set of ten drives names the wrong winner, and
the filter's time per epoch.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from datetime import date
from importlib.metadata import version
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402

import imu_lib as imu  # noqa: E402
from imu_lib import scheduler  # noqa: E402
from imu_lib.navigation import update_interval as study  # noqa: E402
from imu_lib.units import DEG  # noqa: E402

GROUNDS = {"flat": study.Scenario(), "tilted 0.6 deg": study.Scenario(tilt=0.6 * DEG)}


def batch(ground, seed, runs, models, drive, model):
    """Horizontal RMS of each run: {interval: {model: (r,)}}."""
    scenario = GROUNDS[ground]
    drawn = study.simulate(
        drive, model, np.random.default_rng((2008, seed)), runs=runs, scenario=scenario
    )
    found = study.study(drive, drawn, models, scenario=scenario)
    return {t: {name: e.horizontal for name, e in row.items()} for t, row in found.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--scheduler", help="address of a Dask cluster, instead of --jobs")
    args = parser.parse_args()
    model, drive = imu.preset("rga300ca"), study.parking_lot()
    fitted = study.fit_static(model, np.random.default_rng(2008))
    models = {
        "GM(1)": fitted.gm,
        "AR(4)": fitted.ar,
        "AR(4), slow state": study.with_slow_state(fitted.ar, 0.1, 20.0),
    }
    drawn = study.simulate(drive, model, np.random.default_rng(1), runs=2)
    study.errors(drive, drawn, fitted.ar, 10)  # compile
    begin = time.perf_counter()
    study.errors(drive, drawn, fitted.ar, 10)
    per_epoch = (time.perf_counter() - begin) / (2 * len(drive.inputs))
    table = {}
    for ground in GROUNDS:
        tasks = [(ground, k, 10, models, drive, model) for k in range(args.runs // 10)]
        rows = scheduler.every(batch, tasks, workers=args.jobs, address=args.scheduler)
        for t in study.INTERVALS:
            errors = {name: np.concatenate([r[t][name] for r in rows]) for name in models}
            ratio = study.paired(errors["AR(4)"], errors["GM(1)"])
            sets = [np.mean(np.log(r[t]["AR(4)"] / r[t]["GM(1)"])) for r in rows]
            table[f"{ground}, {t} s"] = {
                "horizontal_rms_m": {
                    name: float(f"{np.sqrt(np.mean(e**2)):.4g}") for name, e in errors.items()
                },
                "ar4_over_gm1": {k: round(v, 4) for k, v in ratio.to_json().items()},
                "ten_drives_name_the_other_winner_percent": round(
                    100 * float(np.mean(np.sign(sets) != np.sign(np.log(ratio.value)))), 1
                ),
            }
    result = {
        "command": f"python benchmarks/calibration_update_interval.py --runs {args.runs}",
        "date": date.today().isoformat(),
        "versions": {p: version(p) for p in ("numpy", "scipy", "numba", "statsmodels")},
        "seeds": f"(2008, 0) to (2008, {args.runs // 10 - 1}), ten drives each",
        "microseconds_per_epoch_13_states": round(1e6 * per_epoch, 2),
        "results": table,
    }
    path = ROOT / "benchmarks/results/update_interval.json"
    path.parent.mkdir(exist_ok=True)
    path.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    print(f"{1e6 * per_epoch:.2f} microseconds per epoch, 13 states")
    for name, row in table.items():
        r = row["ar4_over_gm1"]
        print(
            name.ljust(22),
            row["horizontal_rms_m"],
            f"AR(4)/GM(1) {r['value']:.3f} [{r['low']:.3f}, {r['high']:.3f}],",
            f"ten drives wrong {row['ten_drives_name_the_other_winner_percent']:.0f} %",
        )


if __name__ == "__main__":
    main()
