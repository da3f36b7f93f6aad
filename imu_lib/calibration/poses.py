"""Calibration from static poses, with and without a turntable.

Two cases:

- the true input of each pose is known (a levelled turntable, a six-position test, a rate table):
  Eq. (1) of `triad` is linear in M and b, and ordinary least squares answers (`from_reference`);
- it is not, but at rest the specific force has the magnitude of gravity (Tedaldi, Pretto and
  Menegatti
  2014; Eq. 10 there): nine parameters from

      sum over poses of ( |M^-1 (y_k - b)| - g )^2                                          (2)

  with M upper triangular: a rotation of the body axes does not change Eq. (2), so the body x axis
  is put along the x sensor and the y axis in the plane of the x and y sensors (`from_gravity`).
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares

from ..errors import InputError
from ..units import G
from ..words import number
from .triad import AXES, Triad

#: Elements of M (row by row) that Eq. (2) determines.
UPPER = (0, 1, 2, 4, 5, 8)
#: Parameters of Eq. (2); at least one pose more is needed.
PARAMETERS = 9
#: Smallest over largest singular value of the scaled design; 24 random poses have about 0.1, three
#: axes up and down 1e-4.
ALIKE = 3e-3


def from_reference(reading: np.ndarray, truth: np.ndarray, *, nominal: float = 1.0) -> Triad:
    """Least squares of readings on known inputs (Titterton and Weston's test, used by the 2008
    paper, Section 4).

    Parameters
    ----------
    reading, truth : ndarray, shape (n, 3)
        Mean reading of each position or rate step, and the true input there. An input axis that
        the test never excites leaves its column of M undetermined (held at `nominal` on the
        diagonal, zero elsewhere).
    nominal : float
        Nominal sensitivity, reading per unit of input.

    Raises
    ------
    InputError
        When there are too few positions, or they excite no axis.
    """
    reading, truth = (
        np.atleast_2d(np.asarray(reading, float)),
        np.atleast_2d(np.asarray(truth, float)),
    )
    spread = np.ptp(truth, axis=0)
    excited = np.flatnonzero(spread > 1e-3 * max(spread.max(), 1e-300))
    if not len(excited):
        raise InputError(
            "All reference inputs are equal, so bias and scale factor cannot be told apart; use "
            "at least two different positions or rates."
        )
    design = np.column_stack([truth[:, excited], np.ones(len(truth))])
    dof = len(truth) - design.shape[1]
    if dof < 1 or np.linalg.matrix_rank(design) < design.shape[1]:
        raise InputError(
            f"{len(truth)} positions do not determine {design.shape[1]} parameters per sensor; "
            f"at least {design.shape[1] + 1} that are not in one plane are needed."
        )
    solution, *_ = np.linalg.lstsq(design, reading, rcond=None)
    residual = reading - design @ solution
    variance = (residual**2).sum(axis=0) / dof  # one per sensor
    inverse = np.linalg.inv(design.T @ design)
    matrix, estimated, covariance = np.eye(3) * nominal, np.zeros(12, bool), np.zeros((12, 12))
    for i in range(3):
        index = np.append(3 * i + excited, 9 + i)
        matrix[i, excited] = solution[:-1, i]
        estimated[index] = True
        covariance[np.ix_(index, index)] = variance[i] * inverse
    return Triad(
        matrix,
        solution[-1],
        covariance,
        dof,
        estimated,
        nominal,
        float(np.sqrt(variance.mean()) / nominal),
    )


def from_gravity(reading: np.ndarray, *, gravity: float = G, nominal: float | None = 1.0) -> Triad:
    """Bias, scale factor and cross-coupling of three accelerometers from static poses alone, Eq.
    (2).

    Parameters
    ----------
    reading : ndarray, shape (k, 3)
        Mean reading of each pose, any unit (counts with an offset are welcome: the start is an
        algebraic fit).
    gravity : float
        Local gravity, m/s^2.
    nominal : float or None
        Nominal sensitivity, reading per m/s^2; None takes the mean of the three found.

    Raises
    ------
    InputError
        With fewer than ten poses, or poses that leave a sensor unexcited (which one is named).
    """
    y = np.asarray(reading, float)
    if len(y) <= PARAMETERS:
        raise InputError(
            f"{number(len(y), 'pose')} at rest cannot determine {PARAMETERS} parameters; record at "
            f"least {PARAMETERS + 1}, better 24 or more, with each axis up, down and level."
        )
    start = _sphere(y)
    unexcited(y, start[9:], np.mean(start[[0, 4, 8]]) * gravity)
    unit = np.mean(start[[0, 4, 8]])  # work with sensitivities near one
    x0 = np.append(start[list(UPPER)], start[9:]) / unit
    z = y / unit

    residuals, jacobian = _magnitude(z, gravity)
    fit = least_squares(residuals, x0, jacobian, method="lm", x_scale="jac")
    singular = np.linalg.svd(fit.jac / np.linalg.norm(fit.jac, axis=0), compute_uv=False)
    if singular[-1] < ALIKE * singular[0]:
        raise InputError(
            f"The {len(y)} poses lie in too few directions to tell cross-coupling from scale "
            "factor and bias; add poses with two axes tilted at once, or list what the poses are "
            "(--poses)."
        )
    matrix, bias = _split(fit.x)
    dof = len(y) - PARAMETERS
    variance = 2 * fit.cost / dof
    covariance = np.zeros((12, 12))
    index = np.array([*UPPER, 9, 10, 11])
    covariance[np.ix_(index, index)] = variance * np.linalg.inv(fit.jac.T @ fit.jac) * unit**2
    matrix = matrix * unit
    if nominal is None:
        nominal = float(np.mean(np.diag(matrix)))
    return Triad(
        matrix,
        bias * unit,
        covariance,
        dof,
        np.isin(np.arange(12), index),
        nominal,
        float(np.sqrt(variance)),
    )


def _split(p):
    """Upper triangular matrix and bias of the nine parameters."""
    matrix = np.zeros(9)
    matrix[list(UPPER)] = p[:6]
    return matrix.reshape(3, 3), p[6:]


def _magnitude(z, gravity):
    """Residuals of Eq. (2) on the readings `z` and their Jacobian, as functions of the
    parameters.
    """

    def inputs(p):
        matrix, bias = _split(p)
        return matrix, np.linalg.solve(matrix, (z - bias).T).T

    def residuals(p):
        return np.linalg.norm(inputs(p)[1], axis=1) - gravity

    def jacobian(p):
        matrix, u = inputs(p)
        a = -np.linalg.solve(matrix.T, (u / np.linalg.norm(u, axis=1, keepdims=True)).T).T
        return np.column_stack([a[:, i // 3] * u[:, i % 3] for i in UPPER] + [a])

    return residuals, jacobian


def _sphere(y: np.ndarray) -> np.ndarray:
    """Start values: the sphere nearest to the readings, |y|^2 = 2 y.c + (r^2 - c.c), linear in
    c and the rest.
    """
    middle, scale = y.mean(axis=0), np.ptp(y, axis=0).max() / 2
    z = (y - middle) / scale
    solution, *_ = np.linalg.lstsq(
        np.column_stack([2 * z, np.ones(len(z))]), (z**2).sum(axis=1), rcond=None
    )
    radius = np.sqrt(max(solution[3] + solution[:3] @ solution[:3], 1e-12)) * scale
    return np.concatenate([np.eye(3).ravel() * radius / G, middle + solution[:3] * scale])


def unexcited(y: np.ndarray, centre: np.ndarray, gravity: float) -> None:
    """Refuse poses in which a sensor never sees both signs of a good part of gravity.

    `y` (k, 3), `centre` (3,) and `gravity` in the unit of the reading.

    Raises
    ------
    InputError
        Naming the axes, and the remedy.
    """
    spread = np.ptp(y, axis=0)
    reach = max(gravity, spread.max() / 2)
    poor = [axis for axis, s in zip(AXES, spread) if s < reach]
    if poor:
        seen = ", ".join(
            f"{s / reach:.2g} g on accel_{a}" for a, s in zip(AXES, spread) if a in poor
        )
        raise InputError(
            f"The poses do not excite {' and '.join('accel_' + a for a in poor)}: the readings at "
            f"rest vary by {seen} only; add poses with {' and with '.join(poor)} up and down."
        )


def ferraris(
    positive: np.ndarray, negative: np.ndarray, *, gravity: float = G
) -> tuple[np.ndarray, np.ndarray]:
    """M and b of the classical six-position test (Ferraris, Grimaldi and Parvis 1995, Eqs. 19 to
    23).

    Parameters
    ----------
    positive, negative : ndarray, shape (3, 3)
        Row i: mean reading with axis i up, and down.

    Returns
    -------
    (M, b) : M (3, 3) equals `from_reference` on the six positions; b takes axis i's bias from its
    own two
        positions, where least squares uses all six.
    """
    positive, negative = np.asarray(positive, float), np.asarray(negative, float)
    return (positive - negative).T / (2 * gravity), np.diag(positive + negative) / 2


def held_out(
    reading: np.ndarray, *, gravity: float = G, nominal: float | None = None
) -> np.ndarray:
    """Length of the specific force less gravity of every second pose, calibrated by `from_gravity`
    from the others, ndarray, shape (k // 2,), m/s^2.
    """
    half = from_gravity(reading[::2], gravity=gravity, nominal=nominal)
    return np.linalg.norm(half.correct(reading[1::2]), axis=1) - gravity
