"""Is the filter honest about its errors? NEES and NIS against their chi-square bands (Bar-Shalom,
Li and Kirubarajan 2001, section 5.4).
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from . import attitude, earth
from .alignment import Alignment
from .filter import Solution


def errors(solution: Solution, drive):
    """Navigation errors at the stored moments: (time (k,), error (k, 9), covariance (k, 9, 9)),
    NED metres, m/s, rad, estimate minus truth.

    drive : one whose reference is the truth (a simulated one)
    """
    time = np.concatenate([m.time for m in solution.moments])
    nav = np.vstack([m.nav for m in solution.moments])
    p = np.concatenate([m.p[:, :9, :9] for m in solution.moments])
    at = np.searchsorted(drive.reference_time, time - 1e-6)
    e = np.empty((time.size, 9))
    e[:, :3] = earth.meters(nav[:, :3], drive.reference_position[at])
    e[:, 3:6] = nav[:, 3:6] - drive.reference_velocity[at]
    # C_hat = (I - [phi x]) C, so phi is the axis of C C_hat'
    turned = attitude.matrix(drive.reference_attitude[at]) @ np.swapaxes(
        attitude.matrix(attitude.euler(nav[:, 6:10])), 1, 2
    )
    e[:, 6:] = 0.5 * np.stack(
        [
            turned[:, 2, 1] - turned[:, 1, 2],
            turned[:, 0, 2] - turned[:, 2, 0],
            turned[:, 1, 0] - turned[:, 0, 1],
        ],
        axis=-1,
    )
    return time, e, p


def drawn_start(drive, sd, rng) -> Alignment:
    """An alignment that errs from the truth as its `sd` (9,) says: the start of a consistency run,
    where the covariance is true from the first epoch.
    """
    x = rng.standard_normal(9) * sd
    q = attitude.quaternion(drive.reference_attitude[0])
    attitude.rotate_frame(q, -x[6], -x[7], -x[8])
    return Alignment(
        0,
        earth.shift(drive.reference_position[0], x[:3]),
        drive.reference_velocity[0] + x[3:6],
        attitude.euler(q),
        np.asarray(sd, float),
        np.zeros(3),
    )


def nees(solution: Solution, drive):
    """Normalised estimation error squared of the nine navigation states at the stored moments:
    (time (k,), nees (k,)), mean 9 where honest.
    """
    time, e, p = errors(solution, drive)
    size = np.sqrt(np.diagonal(p, axis1=1, axis2=2))
    scaled = p / (size[:, :, None] * size[:, None, :])
    return time, np.einsum(
        "ki,ki->k", e / size, np.linalg.solve(scaled, (e / size)[:, :, None])[:, :, 0]
    )


@dataclass(frozen=True)
class Band:
    """A mean of chi-square variables with the band in which it lies with probability `level` where
    the filter is honest.
    """

    mean: float
    low: float
    high: float
    level: float

    @property
    def inside(self):
        return self.low <= self.mean <= self.high


def band(values, freedom, *, level=0.997) -> Band:
    """Mean over independent values (runs) against its band: freedom degrees of freedom each."""
    values = np.asarray(values, float)
    total = values.size * freedom
    low, high = chi2.ppf([0.5 * (1.0 - level), 0.5 * (1.0 + level)], total) / values.size
    return Band(float(values.mean()), float(low), float(high), level)
