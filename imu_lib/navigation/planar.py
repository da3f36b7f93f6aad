"""The planar filters of the 2008 paper (Section 3.3, Eqs. 8 to 17): two accelerometers, one yaw
gyroscope, positions.

On flat ground, with heading p from north and specific force u forward, v right,

    n' = vn,  e' = ve,  vn' = cos(p) u - sin(p) v,  ve' = sin(p) u + cos(p) v,  p' = w
    (1)

(its Eqs. 8, 9 and 11; the row of ve' in Eq. 8 is printed with a minus before cos(p) v, which Eqs.
9 and 11 do not have). The errors, estimate minus truth, obey its Eq. 12; what the sensors add is
whatever the processes say: random constants give its 8-state filter (Eq. 15), fourth-order AR
models of u and v its 14-state filter (Eq. 16).

What Eqs. 14 and 16 leave out, and `order=2` keeps: the half dt^2 that an acceleration error puts
into position within one step. What Eq. 16 leaves out for good: any bias that lasts. Its AR states
forget within seconds, and its yaw state is white (a zero row), so that neither can carry a
zero-offset from one position fix to the next.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag

from ..processes import Sum
from . import planar_loop

#: The sensors of Eq. (1), in the order of `PlanarSensors.output`.
SENSORS = ("accel_x", "accel_y", "gyro_z")
NAVIGATION = 5


@dataclass(frozen=True)
class PlanarSensors:
    """Discrete sensor error states at one rate: b_{k+1} = D b_k + w, error of sensor s = output[s]
    b + white.

    `transition` D (k, k), `noise` (k, k) covariance of w, `output` (3, k), `start` (k, k)
    covariance of b at first,
    `direct` (3,) two-sided densities of white noise without a state, `dt` s.
    """

    transition: np.ndarray
    noise: np.ndarray
    output: np.ndarray
    start: np.ndarray
    direct: np.ndarray
    dt: float

    @property
    def states(self) -> int:
        """States of the filter, the five of Eq. (1) included."""
        return NAVIGATION + len(self.transition)


def sensors(models: Mapping[str, Sum], dt: float, *, white_state: bool = False) -> PlanarSensors:
    """Sensor states from the processes of `accel_x`, `accel_y` and `gyro_z`.

    Parameters
    ----------
    models : mapping of channel to process or Sum
    dt : float, s; an AR model must have the rate 1/dt
    white_state : bool
        Give the yaw gyroscope's white noise a state of its own, as Eq. 16 of the paper does (its
        row is zero). It reaches the heading one step later, and costs a state.
    """
    blocks, direct = {s: [] for s in SENSORS}, np.zeros(3)
    for k, name in enumerate(SENSORS):
        model = models[name] if isinstance(models[name], Sum) else Sum((models[name],))
        for term in model.terms:
            if term.deterministic:  # a constant is a random constant of that size
                size = float(np.abs(term.mean(np.zeros(1)))[0])
                blocks[name].append(
                    (np.eye(1), np.zeros((1, 1)), np.ones(1), np.array([[size**2]]))
                )
                continue
            space = term.state_space()
            direct[k] += space.direct
            if space.order:
                blocks[name].append((*space.discrete(dt), space.H, space.P0))
    if white_state and direct[2]:
        variance = np.array([[direct[2] / dt]])
        blocks["gyro_z"].append((np.zeros((1, 1)), variance, np.ones(1), variance))
        direct[2] = 0.0
    flat = [b for name in SENSORS for b in blocks[name]]
    size = sum(len(b[2]) for b in flat)
    output, at = np.zeros((3, size)), 0
    for k, name in enumerate(SENSORS):
        for block in blocks[name]:
            output[k, at : at + len(block[2])] = block[2]
            at += len(block[2])
    if not flat:
        return PlanarSensors(
            np.zeros((0, 0)), np.zeros((0, 0)), output, np.zeros((0, 0)), direct, dt
        )
    return PlanarSensors(
        block_diag(*(b[0] for b in flat)),
        block_diag(*(b[1] for b in flat)),
        output,
        block_diag(*(b[3] for b in flat)),
        direct,
        dt,
    )


def transition(
    heading: float, force_ned: tuple[float, float], model: PlanarSensors, *, order: int = 2
) -> np.ndarray:
    """Transition matrix of the error states over one step, ndarray, shape (5 + k, 5 + k) (2008
    Eqs. 12 to 16).

    `force_ned`: north and east components of the specific force, m/s^2. `order` 1 is the paper's I
    + F dt.
    """
    dt, k = model.dt, len(model.transition)
    c, s = np.cos(heading), np.sin(heading)
    phi = np.eye(NAVIGATION + k)
    rates = np.zeros((2, NAVIGATION + k))  # of the velocity errors
    rates[:, 4] = -force_ned[1], force_ned[0]
    rates[0, 5:] = c * model.output[0] - s * model.output[1]
    rates[1, 5:] = s * model.output[0] + c * model.output[1]
    phi[0, 2] = phi[1, 3] = dt
    if order == 2:
        phi[:2] += dt**2 / 2 * rates
    phi[2:4] += dt * rates
    phi[4, 5:] = dt * model.output[2]
    phi[5:, 5:] = model.transition
    return phi


def _sparse(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows, columns and values of what is not zero."""
    rows, columns = np.nonzero(matrix)
    return rows, columns, matrix[rows, columns]


@dataclass(frozen=True)
class PlanarRun:
    """Positions (r, n, 2) m and their predicted standard deviations (r, n, 2) m, after each step;
    `nees` (r, n) of the two positions where the truth was given (expected value 2)."""

    position: np.ndarray
    sd: np.ndarray
    nees: np.ndarray


def run(
    readings: np.ndarray,
    fixes: np.ndarray,
    model: PlanarSensors,
    *,
    every: int,
    start: np.ndarray,
    start_sd: np.ndarray,
    gnss_sd: tuple[float, float],
    order: int = 2,
    truth: np.ndarray | None = None,
) -> PlanarRun:
    """The closed-loop planar filter over repeated runs.

    Parameters
    ----------
    readings : ndarray, shape (r, n, 3)
        Forward, right specific force m/s^2 and yaw rate rad/s; each sample is the mean over its
        step.
    fixes : ndarray, shape (r, m, 2)
        North and east of the fix at the end of every `every`-th step, m.
    model : PlanarSensors
    start : ndarray, shape (r, 5), and start_sd, shape (5,)
        Position m, velocity m/s, heading rad at the start, and how well they are known.
    gnss_sd : north, east, m
    truth : ndarray, shape (n, 2), m; gives `nees`
    """
    readings, fixes = np.ascontiguousarray(readings, float), np.ascontiguousarray(fixes, float)
    if readings.ndim != 3 or readings.shape[2] != 3:
        raise ValueError(f"`readings` must have the shape (r, n, 3), not {readings.shape}")
    if order not in (1, 2):
        raise ValueError(f"`order` must be 1 or 2, not {order!r}")
    how = planar_loop.Setup(
        block_diag(np.diag(np.asarray(start_sd, float) ** 2), model.start),
        np.asarray(gnss_sd, float) ** 2,
        int(every),
        float(model.dt),
        0.5 * model.dt**2 * (order == 2),
        _sparse(model.output),
        _sparse(model.transition),
        model.noise,
        model.direct,
    )
    r, n = readings.shape[:2]
    position, sd, nees = np.empty((r, n, 2)), np.empty((r, n, 2)), np.full((r, n), np.nan)
    true = np.zeros((0, 2)) if truth is None else np.asarray(truth, float)
    for k in range(r):
        out = planar_loop.Out(position[k], sd[k], nees[k])
        planar_loop.run(readings[k], fixes[k], np.asarray(start[k], float), how, out, true)
    return PlanarRun(position, sd, nees)
