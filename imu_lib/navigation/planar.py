"""The planar filters of the 2008 paper (Section 3.3, Eqs. 8 to 17): two accelerometers, one yaw
gyroscope, positions.

On flat ground, with heading p from north and specific force u forward, v right,

    n' = vn,  e' = ve,  vn' = cos(p) u - sin(p) v,  ve' = sin(p) u + cos(p) v,  p' = w             (1)

(its Eqs. 8, 9 and 11; the row of ve' in Eq. 8 is printed with a minus before cos(p) v, which Eqs.
9 and 11 do not
have). The errors, estimate minus truth, obey its Eq. 12; what the sensors add is whatever the
processes say:
random constants give its 8-state filter (Eq. 15), fourth-order AR models of u and v its 14-state
filter (Eq. 16).

What Eqs. 14 and 16 leave out, and `order=2` keeps: the half dt^2 that an acceleration error puts
into position within
one step. What Eq. 16 leaves out for good: any bias that lasts. Its AR states forget within
seconds, and its yaw
state is white (a zero row), so that neither can carry a zero-offset from one position fix to the
next.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.linalg import block_diag

from ..processes import Sum

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
        row is zero). It
        reaches the heading one step later, and costs a state.
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


@njit(cache=True)
def mechanize(state, forward, right, rate, dt):
    """One step of Eq. (1), in place: `state` (n, e, vn, ve, heading); heading at the middle of the
    step.

    Returns the north and east specific force.
    """
    middle = state[4] + 0.5 * rate * dt
    c, s = np.cos(middle), np.sin(middle)
    an, ae = c * forward - s * right, s * forward + c * right
    state[0] += dt * (state[2] + 0.5 * dt * an)
    state[1] += dt * (state[3] + 0.5 * dt * ae)
    state[2] += dt * an
    state[3] += dt * ae
    state[4] += rate * dt
    return an, ae


@njit(cache=True, fastmath=True)
def _apply(p, c, s, an, ae, dt, half, output, block, sensor, work):
    """work = Phi p with what is zero in Phi left out; `output` and `block` are (rows, columns,
    values), `sensor` (3, n) scratch.
    """
    n = p.shape[0]
    sensor[:] = 0.0
    for m in range(len(output[0])):
        for j in range(n):
            sensor[output[0][m], j] += output[2][m] * p[5 + output[1][m], j]
    for j in range(n):
        north = -ae * p[4, j] + c * sensor[0, j] - s * sensor[1, j]
        east = an * p[4, j] + s * sensor[0, j] + c * sensor[1, j]
        work[0, j] = p[0, j] + dt * p[2, j] + half * north
        work[1, j] = p[1, j] + dt * p[3, j] + half * east
        work[2, j] = p[2, j] + dt * north
        work[3, j] = p[3, j] + dt * east
        work[4, j] = p[4, j] + dt * sensor[2, j]
    work[5:] = 0.0
    for m in range(len(block[0])):
        for j in range(n):
            work[5 + block[0][m], j] += block[2][m] * p[5 + block[1][m], j]


@njit(cache=True)
def _run(
    readings,
    fixes,
    every,
    start,
    p0,
    gnss,
    dt,
    half,
    output,
    block,
    noise,
    direct,
    positions,
    sds,
    nees,
    truth,
):
    """One run of the filter; see `run`."""
    n = p0.shape[0]
    x, b, p = start.copy(), np.zeros(n - 5), p0.copy()
    work, turned, sensor = np.empty((n, n)), np.empty((n, n)), np.empty((3, n))
    error = np.zeros(3)
    next_fix = 0
    for k in range(len(readings)):
        error[:] = 0.0
        for m in range(len(output[0])):
            error[output[0][m]] += output[2][m] * b[output[1][m]]
        rate = readings[k, 2] - error[2]
        middle = x[4] + 0.5 * rate * dt
        an, ae = mechanize(x, readings[k, 0] - error[0], readings[k, 1] - error[1], rate, dt)
        c, s = np.cos(middle), np.sin(middle)
        _apply(p, c, s, an, ae, dt, half, output, block, sensor, work)
        for i in range(n):
            for j in range(n):
                turned[i, j] = work[j, i]
        _apply(turned, c, s, an, ae, dt, half, output, block, sensor, p)
        p[2, 2] += dt * (c * c * direct[0] + s * s * direct[1])
        p[3, 3] += dt * (s * s * direct[0] + c * c * direct[1])
        p[2, 3] += dt * c * s * (direct[0] - direct[1])
        p[3, 2] = p[2, 3]
        p[4, 4] += dt * direct[2]
        for i in range(n - 5):
            for j in range(n - 5):
                p[5 + i, 5 + j] += noise[i, j]
        old = b.copy()
        b[:] = 0.0
        for m in range(len(block[0])):
            b[block[0][m]] += block[2][m] * old[block[1][m]]
        if (k + 1) % every == 0 and next_fix < len(fixes):
            for axis in range(2):
                gain = p[:, axis] / (p[axis, axis] + gnss[axis])
                miss = x[axis] - fixes[next_fix, axis]
                row = p[axis].copy()
                for i in range(n):
                    for j in range(n):
                        p[i, j] -= gain[i] * row[j]
                for i in range(5):
                    x[i] -= gain[i] * miss
                for i in range(5, n):
                    b[i - 5] += gain[i] * miss  # the state is truth minus estimate here
            for i in range(n):
                for j in range(i):
                    p[i, j] = p[j, i] = 0.5 * (p[i, j] + p[j, i])
            next_fix += 1
        positions[k, 0], positions[k, 1] = x[0], x[1]
        sds[k, 0], sds[k, 1] = np.sqrt(p[0, 0]), np.sqrt(p[1, 1])
        if truth.shape[0]:
            d0, d1 = x[0] - truth[k, 0], x[1] - truth[k, 1]
            det = p[0, 0] * p[1, 1] - p[0, 1] * p[0, 1]
            nees[k] = (d0 * d0 * p[1, 1] - 2 * d0 * d1 * p[0, 1] + d1 * d1 * p[0, 0]) / det


def _sparse(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows, columns and values of what is not zero."""
    rows, columns = np.nonzero(matrix)
    return rows, columns, matrix[rows, columns]


@dataclass(frozen=True)
class PlanarRun:
    """Positions (r, n, 2) m and their predicted standard deviations (r, n, 2) m, after each step;
    `nees` (r, n) of the
    two positions where the truth was given (expected value 2)."""

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
    p0 = block_diag(np.diag(np.asarray(start_sd, float) ** 2), model.start)
    r, n = readings.shape[:2]
    position, sd, nees = np.empty((r, n, 2)), np.empty((r, n, 2)), np.full((r, n), np.nan)
    for k in range(r):
        _run(
            readings[k],
            fixes[k],
            int(every),
            np.asarray(start[k], float),
            p0,
            np.asarray(gnss_sd, float) ** 2,
            model.dt,
            0.5 * model.dt**2 * (order == 2),
            _sparse(model.output),
            _sparse(model.transition),
            model.noise,
            model.direct,
            position[k],
            sd[k],
            nees[k],
            np.zeros((0, 2)) if truth is None else np.asarray(truth, float),
        )
    return PlanarRun(position, sd, nees)
