"""Is the filter honest when its model is true? NEES and NIS over a hundred simulated drives.

    python benchmarks/filter_consistency.py --drives 100 --workers 2 [--backend dask]

Each drive draws its start, sensor errors and fixes from what the filter is told. The mean NEES at
each moment is compared with the 99.7 % band of a mean of chi-square variables (nine degrees of
freedom each), the mean NIS of all fixes likewise.
"""

import argparse
import json
import time
from pathlib import Path

import numpy as np
from scipy.stats import chi2

from imu_lib import preset
from imu_lib.navigation import consistency, ensemble, models, simulation, trajectory, turin
from imu_lib.navigation.filter import FilterModel, LooselyCoupled

RESULT = Path(__file__).parent / "results" / "filter_consistency.json"
SECONDS = 360.0
START_SD = np.concatenate([[1.0, 1.0, 2.0], np.full(3, 0.05), np.radians([0.3, 0.3, 2.0])])
TURN_ON = (
    0.0,
    0.0,
    # a constant bias is no part of a Gauss-Markov or AR model: with one, the model would not be
    # true
)
LEVER = (1.0, 0.3, -1.2)


def true_model(name):
    return preset("3dm-gx3-25-2013") if name == "18AV" else models.five(names=(name,))[name].model


_shared = {}


def task(name, rng, number):
    if name not in _shared:
        whole = turin.drive(1)
        path = trajectory.Trajectory(whole.position, whole.angles, 0.0, SECONDS)
        _shared[name] = path, simulation.true_motion(path), true_model(name)
    path, motion, model = _shared[name]
    drive = simulation.simulate_drive(
        path,
        model,
        rng,
        motion=motion,
        imu=simulation.ImuErrors(turn_on_sd=TURN_ON, lever_arm=LEVER),
    )
    engine = LooselyCoupled(
        drive,
        FilterModel(name, model, turn_on_sd=TURN_ON),
        remove_bias=False,
        start=consistency.drawn_start(drive, START_SD, rng),
    )
    solution = engine.solve(moments=np.arange(10.0, SECONDS - 1.0, 10.0))
    when, value = consistency.nees(solution, drive)
    return when, value, float(solution.nis.sum()), int(solution.freedom.sum())


class Task:
    """The task of one model, as something that travels to worker processes."""

    def __init__(self, name):
        self.name = name

    def __call__(self, rng, number):
        return task(self.name, rng, number)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--drives", type=int, default=100)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--backend", default="loky", choices=("loky", "sequential", "dask"))
    args = parser.parse_args()
    client = None
    if args.backend == "dask":
        from distributed import Client

        client = Client(n_workers=args.workers, threads_per_worker=1, dashboard_address=None)
    content = {
        "command": f"python benchmarks/filter_consistency.py --drives {args.drives}",
        "date": time.strftime("%Y-%m-%d"),
        "drives": args.drives,
        "seconds": SECONDS,
        "models": {},
    }
    for name in ("18AV", "27AR"):
        runs = ensemble.monte_carlo(
            Task(name),
            args.drives,
            seed=20130724,
            workers=args.workers,
            backend=args.backend,
            client=client,
            progress=True,
        )
        values = np.array([r[1] for r in runs])
        band = consistency.band(values[:, 0], 9)
        mean = values.mean(axis=0)
        fixes = sum(r[3] for r in runs)
        nis = sum(r[2] for r in runs) / fixes
        low, high = chi2.ppf([0.0015, 0.9985], fixes) / fixes
        # one number for the whole: the drives are independent, the moments of a drive are not
        each = values.mean(axis=1)
        content["models"][name] = {
            "time": runs[0][0].tolist(),
            "nees": [round(v, 3) for v in mean.tolist()],
            "band": [band.low, band.high],
            "share_of_moments_inside": float(np.mean((mean >= band.low) & (mean <= band.high))),
            "nees_mean": float(each.mean()),
            "nees_standard_error": float(each.std(ddof=1) / np.sqrt(len(each))),
            "nis_mean_per_degree": nis,
            "nis_band_per_degree": [float(low), float(high)],
        }
        print(name, {k: v for k, v in content["models"][name].items() if k not in ("time", "nees")})
    RESULT.parent.mkdir(exist_ok=True)
    RESULT.write_text(json.dumps(content, indent=1) + "\n")


if __name__ == "__main__":
    main()
