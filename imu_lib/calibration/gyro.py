"""Gyroscopes without a rate table: turns between poses, whose ends gravity has seen.

Between two rests the gyroscopes integrate to a rotation R_k (body axes at the second rest into
those at the first). Gravity's direction in body axes, g_k, is known at both ends from the
calibrated accelerometers, so that

    g_{k+1} - R_k^T g_k = 0                                                               (1)

is two equations per turn (the rotation about the vertical stays unseen) on the nine elements of M
(Tedaldi et al. 2014, their cost for the gyroscopes); the biases come from the rests. What Eq. (1)
leaves over is not white: neighbouring turns share the pose between them, and all of them share the
accelerometers' calibration and the biases. The first is whitened; the others are parameters with
their own covariance as prior, so that the intervals hold them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from ..errors import InputError
from ..units import G
from .poses import UPPER
from .rest import RestWindows
from .triad import Triad

#: The parameters that `from_gravity` finds, among the twelve of a triad.
CALIBRATED = np.array([*UPPER, 9, 10, 11])


@njit(cache=True)
def _turns(rate, start, stop, dt, out):
    """Rotations over samples start..stop of each turn, as quaternions: trapezoid with the coning
    term (Magnus).
    """
    c = dt * dt / 12
    for k in range(len(start)):
        w, x, y, z = 1.0, 0.0, 0.0, 0.0
        for i in range(start[k], stop[k] - 1):
            a0, a1, a2, b0, b1, b2 = (
                rate[i, 0],
                rate[i, 1],
                rate[i, 2],
                rate[i + 1, 0],
                rate[i + 1, 1],
                rate[i + 1, 2],
            )
            p = dt * (a0 + b0) / 2 + c * (a1 * b2 - a2 * b1)
            q = dt * (a1 + b1) / 2 + c * (a2 * b0 - a0 * b2)
            r = dt * (a2 + b2) / 2 + c * (a0 * b1 - a1 * b0)
            t = np.sqrt(p * p + q * q + r * r)
            h, s = 1 - t * t / 8, 0.5 - t * t / 48
            if t > 1e-3:
                h, s = np.cos(t / 2), np.sin(t / 2) / t
            p, q, r = s * p, s * q, s * r
            w, x, y, z = (
                w * h - x * p - y * q - z * r,
                w * p + x * h + y * r - z * q,
                w * q - x * r + y * h + z * p,
                w * r + x * q - y * p + z * h,
            )
        out[k, 0], out[k, 1], out[k, 2], out[k, 3] = x, y, z, w


def turns(rate: np.ndarray, start: np.ndarray, stop: np.ndarray, fs: float) -> np.ndarray:
    """Rotation of each turn, body axes at its last sample into those at its first, ndarray, shape
    (k, 3, 3).

    `rate` (n, 3) rad/s at `fs` Hz; a turn goes from sample `start` to sample `stop` - 1.
    """
    out = np.empty((len(start), 4))
    _turns(np.ascontiguousarray(rate, float), np.asarray(start), np.asarray(stop), 1.0 / fs, out)
    return Rotation.from_quat(out).as_matrix()


def from_turns(
    gyro: np.ndarray,
    accel: np.ndarray,
    fs: float,
    rests: RestWindows,
    accelerometers: Triad,
    *,
    nominal: float | None = 1.0,
) -> Triad:
    """Bias, scale factor and cross-coupling of three gyroscopes from hand-made turns between
    rests, Eq. (1).

    The axes are those of the accelerometers' calibration, so that the misalignment between the two
    triads is found as well. Earth's rotation is left in the bias (15 deg/h at most).

    Parameters
    ----------
    gyro, accel : ndarray, shape (n, 3)
        Readings of the whole record; gyroscopes in rad/s or counts.
    fs : float, Hz
    rests : RestWindows
    accelerometers : Triad
        What `from_gravity` found on the same rests.
    nominal : float or None
        Nominal sensitivity, reading per rad/s; None finds it (readings in counts).

    Raises
    ------
    InputError
        With too few turns for the nine parameters, or turns that leave a sensor undetermined.
    """
    if len(rests) < 7:
        raise InputError(
            f"{max(len(rests) - 1, 0)} turns between rests do not determine the gyroscopes' nine "
            f"parameters; at least 6, better 24 or more, about different axes are needed."
        )
    problem = _problem(gyro, accel, fs, rests, accelerometers)
    pose = problem.directions(np.zeros(9))
    if nominal is None:
        nominal = _sensitivity(lambda s: problem.misses(pose, s * np.eye(3)), problem.gyro)
    residuals = problem.residuals(pose, nominal)
    fit = least_squares(residuals, np.append(np.eye(3).ravel(), np.zeros(12)), method="trf")
    dof = 2 * len(problem.first) - 9
    information = fit.jac.T @ fit.jac
    _check_excited(information[:9, :9])
    scale = 2 * fit.cost / dof  # above one where the noise alone does not explain the misfit
    shares = np.concatenate([np.full(9, nominal), problem.spread])
    covariance = scale * np.linalg.inv(information)[:12, :12] * np.outer(shares, shares)
    matrix = nominal * fit.x[:9].reshape(3, 3)
    angle = problem.misses(pose, matrix)
    return Triad(
        matrix,
        problem.bias + fit.x[9:12] * problem.spread,
        covariance,
        dof,
        np.ones(12, bool),
        nominal,
        float(np.sqrt((angle**2).sum() / dof)),
        float(2 * fit.cost / dof),
    )


@dataclass(frozen=True)
class _Problem:
    """What the fit of the turns works on.

    gyro : (n, 3) readings less `bias`, from the first turn to the last; first, last : (k,) samples
    of the turns; walk, wander : (3,) variances of the gyroscopes' white noise per hertz and of
    their bias from rest to rest; spread : (3,) standard error of the biases; reading : (k+1, 3)
    accelerometers at rest; root : (9, 9) of the covariance of their calibration
    """

    gyro: np.ndarray
    fs: float
    first: np.ndarray
    last: np.ndarray
    bias: np.ndarray
    walk: np.ndarray
    wander: np.ndarray
    spread: np.ndarray
    reading: np.ndarray
    accelerometers: Triad
    root: np.ndarray

    def directions(self, z):
        """Gravity in body axes at each rest, the accelerometers' parameters `z` standard deviations
        off.
        """
        p = np.zeros(12)
        p[CALIBRATED] = self.root @ z
        matrix = self.accelerometers.matrix + p[:9].reshape(3, 3)
        u = np.linalg.solve(matrix, (self.reading - self.accelerometers.bias - p[9:]).T).T
        return u / np.linalg.norm(u, axis=1, keepdims=True)

    def rotations(self, matrix, shift=0.0):
        """Of each turn, with this matrix and the biases `shift` off."""
        rate = (self.gyro - shift) @ np.linalg.inv(matrix).T
        return turns(rate, self.first, self.last, self.fs)

    def misses(self, pose, matrix, shift=0.0):
        """Left side of Eq. (1), (k, 3)."""
        turned = np.einsum("kji,kj->ki", self.rotations(matrix, shift), pose[:-1])
        return pose[1:] - turned

    def residuals(self, pose, nominal):
        """Function of matrix over `nominal`, biases and accelerometers' parameters, these in
        standard deviations: white misfits, then the priors.
        """
        duration = (self.last - self.first - 1) / self.fs
        noise = self.walk.mean() * duration + self.wander.mean() * duration**2
        tangent, pose_sd = _tangent(pose[1:]), self.accelerometers.residual_sd / G
        whiten = _whitener(
            tangent, self.rotations(nominal * np.eye(3)), pose_sd, noise / nominal**2
        )

        def of(p):
            matrix = nominal * p[:9].reshape(3, 3)
            miss = self.misses(self.directions(p[12:]), matrix, p[9:12] * self.spread)
            return np.append(whiten @ np.einsum("kai,ki->ka", tangent, miss).ravel(), p[9:])

        return of


def _problem(gyro, accel, fs, rests, accelerometers) -> _Problem:
    """The turns between the rests, and what the rests say of biases and noises."""
    first, last = rests.stop[:-1] - 1, rests.start[1:] + 1
    means, length = rests.means(gyro), rests.stop - rests.start
    bias = length @ means / length.sum()
    within = [np.var(gyro[a:b], axis=0) for a, b in zip(rests.start, rests.stop, strict=True)]
    walk = np.mean(within, axis=0) / fs
    # from rest to rest, per axis, and what of it is not white noise
    scatter = length @ (means - bias) ** 2 / length.sum() * len(rests) / (len(rests) - 1)
    wander = np.maximum(scatter - walk * fs * len(rests) / length.sum(), 0.0)
    span = slice(int(first[0]), int(last[-1]) + 1)  # a long first rest need not be integrated
    return _Problem(
        gyro=np.asarray(gyro[span], float) - bias,
        fs=fs,
        first=first - span.start,
        last=last - span.start,
        bias=bias,
        walk=walk,
        wander=wander,
        spread=np.sqrt(scatter / len(rests)),
        reading=rests.means(accel),
        accelerometers=accelerometers,
        root=np.linalg.cholesky(accelerometers.covariance[np.ix_(CALIBRATED, CALIBRATED)]),
    )


def _check_excited(information: np.ndarray) -> None:
    """Raises InputError where the turns leave one of the nine elements open."""
    weak, vectors = np.linalg.eigh(information)
    if not weak[0] > 1e-9 * weak[-1]:
        poor = "xyz"[int(np.argmax((vectors[:, 0].reshape(3, 3) ** 2).sum(axis=0)))]
        raise InputError(
            f"The turns do not excite gyro_{poor}; add turns about the {poor} axis between poses."
        )


def _tangent(direction: np.ndarray) -> np.ndarray:
    """Two unit vectors across each direction, ndarray, shape (k, 2, 3)."""
    helper = np.eye(3)[np.argmin(np.abs(direction), axis=1)]
    first = np.cross(direction, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(direction, first)], axis=1)


def _whitener(
    tangent: np.ndarray, rotation: np.ndarray, pose_sd: float, walk: np.ndarray
) -> np.ndarray:
    """Inverse square root of the covariance of the misfits, ndarray, shape (2k, 2k).

    `pose_sd` rad, direction noise of each rest (shared by the turns before and after it); `walk`
    (k,) rad^2, the gyroscopes' own angle variance of each turn.
    """
    k = len(tangent)
    covariance = np.zeros((2 * k, 2 * k))
    for i in range(k):
        block = slice(2 * i, 2 * i + 2)
        covariance[block, block] = (2 * pose_sd**2 + walk[i]) * np.eye(2)
        if i:
            before = slice(2 * i - 2, 2 * i)
            cross = -(pose_sd**2) * tangent[i - 1] @ rotation[i] @ tangent[i].T
            covariance[before, block], covariance[block, before] = cross, cross.T
    return np.linalg.inv(np.linalg.cholesky(covariance))


def _sensitivity(misfit, centred: np.ndarray) -> float:
    """The common sensitivity (reading per rad/s) with the least misfit, from a grid over its
    possible range.
    """
    fastest = np.abs(centred).max()  # a hand turns at 0.5 to 40 rad/s at its fastest
    grid = fastest / np.geomspace(40.0, 0.5, 90)
    return float(grid[np.argmin([(misfit(s) ** 2).sum() for s in grid])])
