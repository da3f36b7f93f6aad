"""A drive made ready for the search: its nominal path, condensed, and the innovations under a
hypothesis about noise.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from imu_lib.arrays import Array
from imu_lib.drive import Drive
from imu_lib.model import Model
from imu_lib.navigation.states import SensorStates, sensor_states
from imu_lib.navigation.tables import over
from imu_lib.processes import Constant, Flicker, GaussMarkov, Process, Sum, WhiteNoise
from imu_lib.record import CHANNELS
from imu_lib.units import DEG

from . import columns, linear

TURN_ON = (0.1 * DEG, 0.05)  # rad/s, m/s^2: biases left at switch-on where the model states none
STRETCHES, STRETCH = 3, 1000  # how many of how many nodes, of a long drive
#: Names in `Problem.arrays` of what `linear.Track` holds, in its order.
TRACK = (
    "begins", "phi", "gain", "noise", "force", "jump", "kind", "node_speed", "bias", "node_fix",
    "node_end",
)  # fmt: skip
# what the linear filter starts with, so that no alignment is believed: m, m/s, rad
START = np.array([30.0, 30.0, 30.0, 3.0, 3.0, 3.0, 0.06, 0.06, 0.5])


@dataclass(frozen=True)
class Noise:
    """A hypothesis about all that is random.

    model : Model of the six channels; per_speed (6,) growth of the white noise with speed;
    position, velocity : ratio of the fixes' true standard deviation to the stated one; sigma, tau :
    first-order Gauss-Markov error of the positions, m and s, and velocity_sigma, velocity_tau of
    the velocities, m/s and s; fraction, scale : wild fixes, m
    """

    model: Model
    per_speed: tuple[float, ...] = (0.0,) * 6
    still: tuple[float | None, ...] = (None,) * 6
    position: float = 1.0
    velocity: float = 1.0
    sigma: float = 0.0
    tau: float = 30.0
    velocity_sigma: float = 0.0
    velocity_tau: float = 10.0
    fraction: float = 0.0
    scale: float = 0.0

    def with_(self, **changes: Any) -> Noise:
        return replace(self, **changes)


@dataclass(frozen=True)
class Innovations:
    """Whitened innovations e (f, 6), their variances s, what a parameter does to each (f, 6, P)
    (None where not asked for), the log-likelihood of each fix (f,), nats, and which positions are
    taken for wild (f,).
    """

    e: np.ndarray
    s: np.ndarray
    jac: np.ndarray | None
    by_fix: np.ndarray
    wild: np.ndarray

    @property
    def log_likelihood(self) -> float:
        """Of all fixes, nats."""
        return float(self.by_fix.sum())


@dataclass
class Problem:
    """A drive along its nominal path. `stated`, `rounding` : variances of the fixes (f, 6) as they
    are stated, and of their last digit (6,); `arrays` : those of `linear.Track` and more.
    """

    drive: Drive
    turn_on: tuple[float, float]
    rate: float
    time: np.ndarray
    use: np.ndarray
    y: np.ndarray
    stated: np.ndarray
    rounding: np.ndarray
    course: np.ndarray
    speed: np.ndarray
    turn: np.ndarray
    ahead: np.ndarray
    aside: np.ndarray
    warmth: np.ndarray
    attitude_sd: np.ndarray
    path: dict[str, Array]
    arrays: dict[str, Array]
    notes: tuple[str, ...]
    _brief: tuple[dict[str, Array], Problem] | None = None
    _held: tuple[bytes, Array, Array] | None = None

    @property
    def long(self) -> bool:
        """Whether `brief` is a part of it."""
        return self.arrays["begins"].size >= 2 * STRETCHES * STRETCH

    def brief(self) -> Problem:
        """The problem on three stretches of a long drive: what is random is fitted there at a
        share of the time. Fixes left out have no innovations.
        """
        if not self.long:
            return self
        if self._brief is not None and self._brief[0] is self.arrays:
            return self._brief[1]
        first = np.linspace(0, self.arrays["begins"].size - STRETCH, STRETCHES).astype(int)
        kept = np.concatenate([np.arange(k, k + STRETCH) for k in first])
        arrays = dict(self.arrays)
        for name in ("begins", "node_fix", "node_end", "node_speed", "node_time"):
            arrays[name] = arrays[name][kept]
        for name in ("phi", "gain", "noise", "force", "jump", "gap", "kind"):
            arrays[name] = arrays[name][kept[1:] - 1]
        arrays["begins"] = arrays["begins"].copy()
        arrays["begins"][::STRETCH] = True
        self._brief = self.arrays, replace(self, arrays=arrays, _brief=None, _held=None)
        return self._brief[1]

    def _without(self, held: Array | None) -> tuple[Array, Array]:
        """(y, jump) without what the held values of the columns do."""
        a = self.arrays
        if held is None or not held.any():
            return self.y, a["jump"]
        key = held.tobytes()
        known = self._held  # another thread may put its own in the place
        if known is None or known[0] != key:
            inside = np.flatnonzero(held[: a["force"].shape[1]])
            y = self.y - a["d"] @ held[list(columns.IN_FIXES)]
            forced = np.einsum("kpi,p->ki", a["force"][:, inside], held[inside])
            self._held = known = key, y, a["jump"] - forced
        return known[1:]

    def _sensors(self, noise: Noise) -> tuple[SensorStates, Array]:
        """States of the sensors, and densities (6,) of their white noise at rest."""
        sensors = sensor_states(
            for_search(noise.model), self.rate, turn_on_sd=self.turn_on, flicker="markov"
        )
        white = [w if n is None else n**2 for w, n in zip(sensors.white, noise.still)]
        return sensors, np.array(white)

    def white(self, noise: Noise) -> Array:
        """Densities (6,) of the white noise of the channels at rest."""
        return self._sensors(noise)[1]

    def evaluate(
        self,
        noise: Noise,
        *,
        sens: bool = False,
        use: Array | None = None,
        held: Array | None = None,
        asked: Array | None = None,
        shown: Array | None = None,
    ) -> Innovations:
        """Innovations under a hypothesis; use (f, 6) bool: fixes taken (default: all); held
        (P,): values of columns taken as known; asked (k-1, count, 9): what other parameters than
        those of `columns` do to the path, or shown (f, 6, count): what they do to the fixes, whose
        sensitivities are wanted in their place.
        """
        a = self.arrays
        sensors, density = self._sensors(noise)
        random = linear.Random(
            START**2,
            sensors.initial,
            *(of_steps := _powers(sensors, a["counts"])),
            np.repeat(np.arange(6), np.diff(sensors.first[:7])),
            sensors.output,
            *_blocks(of_steps[0]),
            density,
            np.asarray(noise.per_speed, float) ** 2,
            *_of_fixes(noise, a["gap"], 9 + sensors.count),
            float(noise.fraction),
            float(noise.scale),
        )
        track = linear.Track(*(a[name] for name in TRACK))
        y, jump = self._without(held)
        track = track._replace(jump=jump)
        fixes = linear.Fixes(
            y,
            a["arm_rows"],
            self.stated * np.repeat([noise.position**2, noise.velocity**2], 3) + self.rounding,
            self.use if use is None else use,
            a["d"],
            np.array(columns.IN_FIXES),
        )
        count = len(columns.ALL) if sens else 0
        if asked is not None:
            none = np.zeros((len(y), 6, 0)), np.zeros(0, np.int64)
            track, fixes = track._replace(force=asked), fixes._replace(columns=none[0], of=none[1])
            count, sens = asked.shape[1], True
        if shown is not None:
            count, sens = shown.shape[2], True
            track = track._replace(force=track.force[:, :0].copy())
            fixes = fixes._replace(columns=shown, of=np.arange(count))
        e, s, jac, wild, doubt = linear.innovations(track, random, fixes, count)
        by_fix = -0.5 * np.nansum(e**2 + np.log(s), axis=1)
        if noise.fraction > 0.0:
            seen = np.isfinite(e[:, 0])
            share = np.where(wild[seen], noise.fraction, 1.0 - noise.fraction)
            # a fix may be either: the density is the sum of both
            by_fix[seen] += np.log(share) + np.log1p(np.exp(-doubt[seen]))
        return Innovations(e, s, jac if sens else None, by_fix, wild)


def _of_fixes(noise: Noise, gap: Array, first: int) -> tuple[Array, Array, Array, Array]:
    """`decay`, `sigma`, `of` and `place` of `linear.Random`; gap (k-1,) s, first: number of the
    first state after those of the sensors.
    """
    sigma = np.array([noise.sigma, noise.velocity_sigma], float)
    tau = np.maximum([noise.tau, noise.velocity_tau], 1e-3)
    of = np.repeat(np.flatnonzero(sigma > 0.0), 3)
    place = np.full(6, -1)
    place[np.repeat(sigma > 0.0, 3)] = first + np.arange(of.size)
    return np.exp(-gap[:, None] / tau), sigma, of, place


def _powers(sensors: SensorStates, counts: Array) -> tuple[Array, Array]:
    """Transition and noise of the sensor states over each number of IMU steps."""
    both = [over(sensors, int(count)) for count in counts]
    return np.array([s for s, _ in both]), np.array([q for _, q in both])


def _blocks(powers: Array) -> tuple[Array, Array]:
    """First and last of the states that each follows from in transitions (u, m, m): from, to
    before, (m,).
    """
    follows = (powers != 0.0).any(axis=0) | np.eye(powers.shape[1], dtype=bool)
    return follows.argmax(axis=1), follows.shape[1] - follows[:, ::-1].argmax(axis=1)


def turn_on_of(model: Model) -> tuple[float, float]:
    """Standard deviation of the biases left at switch-on, gyro rad/s and accelerometer m/s^2."""
    given: Any = getattr(model, "turn_on", None) or model.extra.get("turn_on")
    if not given:
        return TURN_ON
    if isinstance(given, dict):
        return float(given.get("gyro", TURN_ON[0])), float(given.get("accel", TURN_ON[1]))
    gyro, accel = (float(v) for v in given)
    return gyro, accel


def for_search(model: Model) -> Model:
    """The model with its turn-on biases held, and flicker noise as two Gauss-Markov processes, of
    16 and 160 s, and white noise for what is faster: between fixes and within a drive no more of it
    is seen, and each state costs the search time.
    """
    channels = {}
    for c in CHANNELS:
        terms: list[Process] = []
        for process in model[c].terms:
            if not isinstance(process, Flicker):
                terms.append(process)
                continue
            sigma = process.B * np.sqrt(np.log(10.0) / np.pi)  # one decade each
            times = [10.0**k / (2.0 * np.pi) for k in range(-1, 4)]
            white = np.sqrt(2.0 * sigma**2 * sum(times[:3]))
            terms += [WhiteNoise(N=float(white))]
            terms += [GaussMarkov(sigma=float(sigma), correlation_time=t) for t in times[3:]]
        channels[c] = Sum(tuple(terms))
    return with_constants(model.with_channels(channels))


def with_constants(model: Model) -> Model:
    """The model with what holds a turn-on bias on every channel, so that it is not forgotten with
    the correlation time of another process: a walk, or else a constant. Both would be two states
    whose sum alone is seen.
    """
    return model.with_channels({c: Sum(_held_once(model[c].terms)) for c in CHANNELS})


def _held_once(terms: tuple[Process, ...]) -> tuple[Process, ...]:
    """Processes of a channel with a walk or one constant among them."""
    walks = any(t.name == "random_walk" for t in terms)
    rest = tuple(t for t in terms if t.name != "constant")
    return rest if walks else (*rest, Constant(0.0))
