"""What the compiled filter is given and gives back, as named tuples of arrays.

n navigation and sensor states together, m = n - 9 sensor states: first those of the channels, gyro
x to accelerometer z, then those of the measurements (`MEASUREMENT_STATES`).
"""

from typing import NamedTuple

import numpy as np

#: Groups of states that act on the measurements, with their number, in the order of
#: `Measurements.at`.
MEASUREMENT_STATES = {
    "gnss_time_offset": 1,
    "velocity_offset": 1,
    "lever_arm": 3,
    "mounting": 3,
    "imu_clock": 1,
    "gnss_correlated": 3,
    "speed_scale": 1,
}
OFFSET, VELOCITY_OFFSET, LEVER, MOUNTING, CLOCK, CORRELATED, SPEED = range(len(MEASUREMENT_STATES))


class State(NamedTuple):
    """All the filter knows at a moment, changed in place.

    nav (16,) position 3, velocity 3, quaternion 4, the increments of the interval before 6; x (m,)
    sensor states; p (n, n) covariance; road (4,) sum of the unit velocity in the body frame and
    its count.
    """

    nav: np.ndarray
    x: np.ndarray
    p: np.ndarray
    road: np.ndarray


class Pieces(NamedTuple):
    """The covariance in three pieces: nn (9, 9), ns (9, m), ss (m, m)."""

    nn: np.ndarray
    ns: np.ndarray
    ss: np.ndarray


class Live(NamedTuple):
    """What the filter holds while it runs, changed in place: nav, x and road of `State`; the
    covariance in pieces; c (3, 3) the attitude as a matrix, cv (3, 3) the mounting.
    """

    nav: np.ndarray
    x: np.ndarray
    road: np.ndarray
    pieces: Pieces
    c: np.ndarray
    cv: np.ndarray


class Body(NamedTuple):
    """Motion over an interval: before (3,) velocity at its begin, middle (3, 3) mean attitude,
    force (3,) specific force NED, spin (3,) turn rate, motion (3, 3) acceleration of the interval
    and its average over the last tenths of a second, NED, and the turn rate's average before this
    interval.
    """

    before: np.ndarray
    middle: np.ndarray
    force: np.ndarray
    spin: np.ndarray
    motion: np.ndarray


class Correction(NamedTuple):
    """Of n states: dx (n,) the correction that is made; h (n,), h6 (6, n) rows of measurements,
    gain, ph (n,) room to work in; tail : how many of the states are the channels', on which the
    rows are zero.
    """

    dx: np.ndarray
    h: np.ndarray
    h6: np.ndarray
    gain: np.ndarray
    ph: np.ndarray
    tail: int


class Room(NamedTuple):
    """Room to work in: w9 (9, 9), vs (9, m), es (6, m), vh (9, 6), ts (m, m)."""

    w9: np.ndarray
    vs: np.ndarray
    es: np.ndarray
    vh: np.ndarray
    ts: np.ndarray


class Sensors(NamedTuple):
    """The sensor states as the kernel takes them.

    transition, noise (m, m), zero outside the channels' blocks; output (m,) weight of each state;
    first (8,) where each channel's states begin, where the measurements' begin, and m; static (7,)
    where the states without a motion of their own begin in each block; driver (m,) -1, or the
    reading (0-2 gyro, 3-5 accelerometer) that the state is multiplied by; white, white_speed (6,)
    two-sided density of the channels and what is added per squared speed.
    """

    transition: np.ndarray
    noise: np.ndarray
    output: np.ndarray
    first: np.ndarray
    static: np.ndarray
    driver: np.ndarray
    white: np.ndarray
    white_speed: np.ndarray


class Imu(NamedTuple):
    """Intervals of one stretch: dt (k,), dtheta, dvel (k, 3); extra_noise (k,) multiplies the white
    densities (bridged gaps).
    """

    dt: np.ndarray
    dtheta: np.ndarray
    dvel: np.ndarray
    extra_noise: np.ndarray


class FixTable(NamedTuple):
    """Fixes by epoch: epoch, delay (f,) s from the fix to its epoch; time (f,) s; value, variance
    (f, 6); use (f,) bits POSITION and VELOCITY.
    """

    epoch: np.ndarray
    delay: np.ndarray
    time: np.ndarray
    value: np.ndarray
    variance: np.ndarray
    use: np.ndarray


class SpeedTable(NamedTuple):
    """Speeds over ground by epoch: epoch, value m/s, variance (f,)."""

    epoch: np.ndarray
    value: np.ndarray
    variance: np.ndarray


class Given(NamedTuple):
    """What a run is given to work on, fixes and speeds sorted by epoch."""

    imu: Imu
    fixes: FixTable
    speeds: SpeedTable


class Measurements(NamedTuple):
    """How measurements are taken.

    lever (3,) m, vehicle axes; mounting (3,) roll, pitch, yaw of the case against the vehicle;
    known : whether the vehicle's forward axis is that of `mounting` (else learnt from the fixes);
    gates (2,) limits of the squared distances of position and velocity; patience : rejected fixes
    in a row before the filter widens its covariance and takes the next; outliers (2,) fraction and
    scale m of wild positions (fraction 0: none); constraint (4,) sd m/s (0: off), epochs between
    uses, least speed m/s, fixes that must have shown the vehicle's forward axis; at (7,) first
    column of each group of MEASUREMENT_STATES, -1 where it has no states.
    """

    lever: np.ndarray
    mounting: np.ndarray
    known: bool
    gates: np.ndarray
    patience: int
    outliers: np.ndarray
    constraint: np.ndarray
    at: np.ndarray


class Logs(NamedTuple):
    """What a run writes: nav (k, 16); sd (k, 10) nine standard deviations and the north-east
    covariance; and per fix: normalised (f, 6), nis, freedom, bits (f,), innovation (f, 6) predicted
    minus measured, covariance (f, 6, 6), likelihood (f,), velocity (f, 3).
    """

    nav: np.ndarray
    sd: np.ndarray
    normalised: np.ndarray
    nis: np.ndarray
    freedom: np.ndarray
    bits: np.ndarray
    innovation: np.ndarray
    covariance: np.ndarray
    likelihood: np.ndarray
    velocity: np.ndarray

    @classmethod
    def empty(cls, epochs, fixes):
        """Room for a run of so many epochs and fixes."""
        return cls(
            np.empty((epochs, 16)),
            np.empty((epochs, 10)),
            np.full((fixes, 6), np.nan),
            np.zeros(fixes),
            np.zeros(fixes, np.int64),
            np.zeros(fixes, np.int64),
            np.full((fixes, 6), np.nan),
            np.full((fixes, 6, 6), np.nan),
            np.zeros(fixes),
            np.full((fixes, 3), np.nan),
        )


class Nodes(NamedTuple):
    """Epochs at which what the filter knows is kept: epoch (k,), x (k, m), p (k, n, n), road (k,
    4); prior, phi (k, n, n), dx (k, n) for the smoother (covariance before the update, transition
    since the last node, correction made), else empty.
    """

    epoch: np.ndarray
    x: np.ndarray
    p: np.ndarray
    road: np.ndarray
    prior: np.ndarray
    phi: np.ndarray
    dx: np.ndarray

    @classmethod
    def empty(cls, epoch, states, smooth):
        """Room for so many states; for the smoother too where that is asked for."""
        k, m, full = epoch.size, states - 9, epoch.size if smooth else 0
        return cls(
            epoch,
            np.empty((k, m)),
            np.empty((k, states, states)),
            np.empty((k, 4)),
            np.empty((full, states, states)),
            np.empty((full, states, states)),
            np.empty((full, states)),
        )


class Written(NamedTuple):
    """What a run writes."""

    logs: Logs
    nodes: Nodes
