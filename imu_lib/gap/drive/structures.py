"""What the compiled linear filter is given and gives back, as named tuples of arrays.

n states: 9 errors of navigation, m of the sensors, then three Gauss-Markov errors of the positions
and of the velocities where there are some; P parameters (`columns`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Nominal(NamedTuple):
    """The nominal path at k epochs: position (k, 3), velocity (k, 3), quaternion (k, 4)."""

    position: np.ndarray
    velocity: np.ndarray
    quaternion: np.ndarray


class Pieces(NamedTuple):
    """What errors do over k intervals: phi (k, 9, 9), gain (k, 9, 6), noise (k, 6, 9, 9), force (k,
    columns, 9); jump (k, 9): nominal run on, minus nominal at the next node.
    """

    phi: np.ndarray
    gain: np.ndarray
    noise: np.ndarray
    force: np.ndarray
    jump: np.ndarray

    @classmethod
    def zeros(cls, k: int, columns: int) -> Pieces:
        """The two large ones in single precision: 1e-7 of a variance or of a sensitivity is
        nothing.
        """
        shapes = (9, 9), (9, 6), (6, 9, 9), (columns, 9), (9,)
        kinds = "d", "d", "f", "f", "d"
        return cls(*(np.zeros((k, *shape), kind) for shape, kind in zip(shapes, kinds)))


class Track(NamedTuple):
    """What `condense` made of the path, k nodes.

    begins (k,) bool: a stretch begins at the node; phi (k-1, 9, 9), gain (k-1, 9, 6), noise (k-1,
    6, 9, 9), force (k-1, columns, 9), jump (k-1, 9); kind (k-1,) which of `Random.powers` an
    interval takes; speed (k,) m/s; bias (6,) taken off the readings; first, last (k,) rows of the
    fixes at the node: from, to before.
    """

    begins: np.ndarray
    phi: np.ndarray
    gain: np.ndarray
    noise: np.ndarray
    force: np.ndarray
    jump: np.ndarray
    kind: np.ndarray
    speed: np.ndarray
    bias: np.ndarray
    first: np.ndarray
    last: np.ndarray


class Random(NamedTuple):
    """A hypothesis about noise.

    start (9,), sensors (m, m): variance and covariance at the begin of a stretch; powers, walks (u,
    m, m): transition and noise of the sensor states over an interval; channel (m,) of each state,
    its weight (m,) there, and first, last (m,) of the states that it follows from: from, to before;
    density, per_speed (6,): white noise N^2 and its growth with speed^2;
    decay (k-1, 2), sigma (2,) m, m/s: of the Gauss-Markov errors of positions and velocities; of
    (t,) which of the two each state after the sensors' is, and place (6,) which state is the error
    of each number of a fix, -1 where none; fraction, scale m: of wild positions.
    """

    start: np.ndarray
    sensors: np.ndarray
    powers: np.ndarray
    walks: np.ndarray
    channel: np.ndarray
    weight: np.ndarray
    first: np.ndarray
    last: np.ndarray
    density: np.ndarray
    per_speed: np.ndarray
    decay: np.ndarray
    sigma: np.ndarray
    of: np.ndarray
    place: np.ndarray
    fraction: float
    scale: float


class Fixes(NamedTuple):
    """y (f, 6) predicted minus measured; arm (f, 3, 3) rows of the attitude error; variance, use
    (f, 6); columns (f, 6, D): what the parameters number `of` (D,) do to y beyond what they do to
    the path.
    """

    y: np.ndarray
    arm: np.ndarray
    variance: np.ndarray
    use: np.ndarray
    columns: np.ndarray
    of: np.ndarray


class Out(NamedTuple):
    """e (f, 6) whitened, s (f, 6) variance of the innovations, jac (f, 6, P) whitened (empty where
    not asked for), wild (f,) bool, doubt (f,) nats by which one of wild and tame is likelier
    (infinite where no fix can be wild).
    """

    e: np.ndarray
    s: np.ndarray
    jac: np.ndarray
    wild: np.ndarray
    doubt: np.ndarray


class Room(NamedTuple):
    """States x (n,), covariance p (n, n), what parameters do to them z (n, P); top (9, n), es (6,
    n), zs (6, P), low (m, n), zt (n, P), ph, gain (n,), by_channel (9, 6), both (15, 9): room to
    work in.
    """

    x: np.ndarray
    p: np.ndarray
    z: np.ndarray
    top: np.ndarray
    es: np.ndarray
    zs: np.ndarray
    low: np.ndarray
    zt: np.ndarray
    ph: np.ndarray
    gain: np.ndarray
    by_channel: np.ndarray
    both: np.ndarray
