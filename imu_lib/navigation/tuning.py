"""An error model for the sensor in the moving car: fitted to what outages show, not to a
standstill.

A static record knows nothing of vibration, scale factors or mounting. Here the parameters of a
model are chosen so that the filter's own prediction over withheld windows is as likely as
possible: the density of the horizontal error after some seconds, under the covariance that the
filter gives it. It must be judged on a drive that it has not seen.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from imu_lib.model import Model
from imu_lib.processes import RandomWalk, Sum, WhiteNoise
from imu_lib.record import CHANNELS

from . import earth
from .filter import FilterModel, LooselyCoupled
from .preparation import Gnss

PARAMETERS = ("gyro N", "accelerometer N", "gyro K", "accelerometer K")


def vehicle_model(
    gyro_n: float, accel_n: float, gyro_k: float, accel_k: float, name: str = "in motion"
) -> Model:
    """White noise and a random walk on every channel, alike on the three axes: rad/s and m/s^2 per
    sqrt(Hz), and per s and sqrt(Hz).
    """
    return Model(
        {
            c: Sum(
                (
                    WhiteNoise(N=float(gyro_n if c.startswith("gyro") else accel_n)),
                    RandomWalk(K=float(gyro_k if c.startswith("gyro") else accel_k)),
                )
            )
            for c in CHANNELS
        },
        name=name,
    )


@dataclass(frozen=True)
class Tuned:
    """The fitted FilterModel, its parameters (4,) in the order of PARAMETERS, minus the mean log
    density, and how often it was evaluated.
    """

    model: FilterModel
    parameters: np.ndarray
    loss: float
    evaluations: int


def outage_loss(engine: LooselyCoupled, windows, *, times=(10.0, 20.0, 30.0), fix_sd=1.0):
    """Minus the mean log density of the horizontal errors against the full-GNSS solution, `times`
    s into each window.

    fix_sd : m, of the full-GNSS solution itself, added to the predicted covariance
    """
    solution = engine.solve(moments=sorted({w.start for w in windows}))
    total, count = 0.0, 0
    for moment in solution.moments:
        for i, start in enumerate(moment.time):
            time, position, sd, north_east = engine.coast(moment, i, max(times))
            for t in times:
                k = int(np.searchsorted(time, start + t - 1e-6))
                if k >= time.size:
                    continue
                n, e, _ = earth.meters(position[k], solution.at(time[k : k + 1])[0])
                a, b, c = sd[k, 0] ** 2 + fix_sd**2, sd[k, 1] ** 2 + fix_sd**2, north_east[k]
                det = a * b - c * c
                total += 0.5 * (
                    (b * n * n - 2.0 * c * n * e + a * e * e) / det + np.log(det)
                ) + np.log(2.0 * np.pi)
                count += 1
    return total / max(count, 1)


def fit_in_motion(
    cases,
    *,
    start=(5e-4, 0.03, 3e-5, 1e-3),
    turn_on_sd=(3.5e-3, 0.2),
    constraint_sd=0.0,
    evaluations=60,
    progress=None,
) -> Tuned:
    """Fit the four parameters of `vehicle_model` on one or several drives.

    cases : sequence of (drive, windows, Gnss or None); start : first guess; evaluations : the most
    of them
    progress : callable, told the loss after each evaluation
    """

    def filter_model(log):
        return FilterModel(
            "in motion",
            vehicle_model(*np.exp(log)),
            turn_on_sd=turn_on_sd,
            constraint_sd=constraint_sd,
        )

    first = np.log(np.asarray(start, float))
    engines = [
        (LooselyCoupled(drive, filter_model(first), gnss=gnss or Gnss()), windows)
        for drive, windows, gnss in cases
    ]
    seen = []  # (loss, parameters): the search may end between two steps, not on its best point

    def loss(log):
        value = float(
            np.mean(
                [
                    outage_loss(engine.with_model(filter_model(log)), windows)
                    for engine, windows in engines
                ]
            )
        )
        value += (
            0.5 * float(np.sum(((log - first) / np.log(100.0)) ** 2)) / 10.0
        )  # two decades are far: keeps what is not seen near the guess
        seen.append((value, np.array(log)))
        if progress is not None:
            progress(value)
        return value

    simplex = np.vstack([first, first + np.eye(4) * np.log(3.0)])
    minimize(
        loss,
        first,
        method="Nelder-Mead",
        options={"initial_simplex": simplex, "maxfev": evaluations, "xatol": 0.05, "fatol": 1e-3},
    )
    value, best = min(seen, key=lambda pair: pair[0])
    return Tuned(filter_model(best), np.exp(best), value, len(seen))
