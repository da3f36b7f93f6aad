"""Coverage of the calibration's 95 % intervals over simulated hand-held records, every one of
another sensor.

    python benchmarks/calibration_coverage.py [--records 200]

Writes benchmarks/results/calibration_coverage.json: for 12, 24 and 48 poses the share of intervals
of bias, scale factor and cross-coupling that hold the truth, accelerometers and gyroscopes, and
the median half width.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from datetime import date
from importlib.metadata import version
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402

from imu_lib import calibration, scheduler  # noqa: E402
from imu_lib.calibration import simulated  # noqa: E402
from imu_lib.errors import InputError  # noqa: E402

FS, ACCEL_SD, GYRO_SD = 50.0, 0.03, 0.003


def one(poses, seed):
    """Hits and half widths of one record: {quantity: [(hit, half width), ...]}; None where its
    poses are refused.
    """
    rng = np.random.default_rng((poses, seed))
    upper = {k: rng.normal(0, 0.005) for k in ("xy", "xz", "yz")}
    full = {k: rng.normal(0, 0.005) for k in ("xy", "xz", "yx", "yz", "zx", "zy")}
    truth = {
        "accelerometers": calibration.triad(rng.normal(0, 0.005, 3), rng.normal(0, 0.1, 3), upper),
        "gyroscopes": calibration.triad(rng.normal(0, 0.005, 3), rng.normal(0, 0.01, 3), full),
    }
    accel, gyro = simulated.hand_held(
        poses,
        FS,
        rng,
        accelerometers=truth["accelerometers"],
        gyroscopes=truth["gyroscopes"],
        rest=3.0,
        accel_noise=simulated.white(ACCEL_SD, rng),
        gyro_noise=simulated.white(GYRO_SD, rng),
    )
    try:
        found = calibration.calibrate(accel, gyro, FS)
    except (
        InputError
    ):  # a dozen poses thrown at random may leave an axis out, which is refused by name
        return None
    out = {}
    for kind, true in truth.items():
        triad = getattr(found, kind)
        pairs = {
            "bias": zip(triad.biases, true.bias),
            "scale factor": zip(triad.scale_factors, np.diag(true.matrix) - 1),
            "cross-coupling": (
                (e, true.matrix["xyz".index(k[0]), "xyz".index(k[1])])
                for k, e in triad.cross_coupling.items()
            ),
        }
        for name, rows in pairs.items():
            out[f"{kind}, {name}"] = [
                (e.covers(t), (e.high - e.low) / 2) for e, t in rows if e is not None
            ]
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--records", type=int, default=200)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--scheduler", help="address of a Dask cluster, instead of --jobs")
    args = parser.parse_args()
    table, refused = {}, {}
    for poses in (12, 24, 48):
        tasks = [(poses, seed) for seed in range(args.records)]
        rows = scheduler.every(one, tasks, workers=args.jobs, address=args.scheduler)
        refused[f"{poses} poses"] = sum(row is None for row in rows)
        rows = [row for row in rows if row is not None]
        for name in rows[0]:
            values = np.array([v for row in rows for v in row[name]], float)
            table[f"{poses} poses, {name}"] = {
                "coverage_percent": round(100 * float(values[:, 0].mean()), 1),
                "intervals": len(values),
                "median_half_width": float(f"{np.median(values[:, 1]):.3g}"),
            }
    result = {
        "command": f"python benchmarks/calibration_coverage.py --records {args.records}",
        "date": date.today().isoformat(),
        "versions": {p: version(p) for p in ("numpy", "scipy", "numba")},
        "record": {
            "rate_hz": FS,
            "rest_s": 3.0,
            "turn_s": 2.0,
            "accel_sd": ACCEL_SD,
            "gyro_sd": GYRO_SD,
        },
        "seeds": f"(poses, 0) to (poses, {args.records - 1})",
        "refused": refused,
        "results": table,
    }
    path = ROOT / "benchmarks/results/calibration_coverage.json"
    path.parent.mkdir(exist_ok=True)
    path.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    for name, row in table.items():
        print(
            f"{name.ljust(44)} {row['coverage_percent']:5.1f} % of {row['intervals']}, half width "
            f"{row['median_half_width']:.3g}"
        )


if __name__ == "__main__":
    main()
