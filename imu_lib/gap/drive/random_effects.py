"""Effects on what is random: each is a change of the noise hypothesis, tried by its likelihood."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.optimize import minimize, minimize_scalar

from imu_lib.arrays import Array
from imu_lib.model import Model
from imu_lib.navigation.side_by_side import each
from imu_lib.processes import Process, Sum, WhiteNoise
from imu_lib.record import CHANNELS

from .problem import Noise, Problem
from .select import PER_EFFECT, PER_PARAMETER

if TYPE_CHECKING:
    from .state import State

_TRIES = 35
#: Nats for one of three parameters of six channels, and for one of six channels.
ALIKE = {"bias_model": float(np.log(18.0)), "vibration": float(np.log(6.0))}
LEAST = 0.001  # ratio of errors of fixes to the stated ones: below, it is no noise of a receiver
#: Of no name in the catalogue.
VELOCITY_LASTS = "other: errors of the receiver's velocities last"
LASTING = (1.0, 10.0)  # s, to start with
MEMORIES = (5.0, 60.0)  # s, of the errors of positions, to start with
PRIOR = 2.0  # of the logarithm of a parameter: a factor of seven is usual, a million is none


@dataclass(frozen=True)
class Change:
    """A change of the noise: effect and its `key` (what may change once), start values of its
    parameters, how they enter, and what is usual for them where that is not the start.
    """

    effect: str
    key: tuple[str, ...]
    start: tuple[float, ...]
    enter: Callable[[Noise, Array], Noise]
    describe: Callable[[Array], dict[str, Any]]
    usual: tuple[float, ...] = ()

    def pull(self, x: Array) -> float:
        """Nats by which logarithms of the parameters are away from what is usual."""
        return 0.5 * float(np.sum(((x - self.middle) / PRIOR) ** 2))

    @property
    def middle(self) -> Array:
        """Logarithms of what is usual."""
        return np.log(self.usual or self.start)

    def fitted(self, state: State, noise: Noise, base: float) -> tuple[Array, float, Noise]:
        """Maximise: (values, gain, Noise)."""

        def loss(x: Array) -> float:
            with np.errstate(over="ignore"):
                value = state.evaluate(self.enter(noise, np.exp(x))).log_likelihood
            return -value + self.pull(x) if np.isfinite(value) else 1e12

        start = np.log(self.start)
        k = start.size
        if k == 1:
            near = (float(start[0]) - 3.0, float(start[0]) + 3.0)
            found = minimize_scalar(
                lambda v: loss(np.array([v])), bounds=near, method="bounded",
                options={"xatol": 0.01, "maxiter": 18},
            )  # fmt: skip
            values = np.exp(np.atleast_1d(found.x))
            noise = self.enter(noise, values)
            return values, state.evaluate(noise).log_likelihood - base, noise
        simplex = np.vstack([start, start + 0.5 * np.eye(k)])
        found = minimize(
            loss, start, method="Nelder-Mead",
            options={
                "initial_simplex": simplex, "maxfev": _TRIES * k, "xatol": 0.01, "fatol": 0.05,
            },
        )  # fmt: skip
        values = np.exp(found.x)
        noise = self.enter(noise, values)
        gain = state.evaluate(noise).log_likelihood - base
        return values, gain, noise


def penalty(change: Change) -> float:
    """What a change has to gain, nats: which of so many of its kind it is has its price too."""
    return PER_PARAMETER * len(change.start) + PER_EFFECT + ALIKE.get(change.effect, 0.0)


def _with_process(noise: Noise, channel: str, position: int, name: str, value: float) -> Noise:
    terms = list(noise.model[channel].terms)
    term: Any = terms[position]
    terms[position] = replace(term, **{name: float(value)})
    return noise.with_(model=noise.model.with_channels({channel: Sum(tuple(terms))}))


def changes(problem: Problem, noise: Noise, given: bool) -> list[Change]:
    """All changes that could be tried on top of a hypothesis; given: the model is the user's, whose
    processes may be wrong.
    """
    out = _of_fixes(problem, noise)
    if given:
        out += _of_processes(noise)
    return out + _vibrations(problem, noise)


def _of_fixes(problem: Problem, noise: Noise) -> list[Change]:
    """Changes of the errors of the fixes: their size, their memory, and wild ones."""
    measured = [of for k, of in ((0, "position"), (3, "velocity")) if problem.use[:, k].any()]
    out = [_size_of_fixes(of, noise) for of in measured]
    if "velocity" in measured:
        out += [_lasting_velocity(tau, problem, noise) for tau in LASTING]
    if not problem.use[:, 0].any():
        return out
    typical = float(np.median(np.sqrt(problem.stated[problem.use[:, 0], :2])))
    for tau in MEMORIES:
        out.append(
            Change(
                "gnss_correlated",
                ("gnss_correlated",),
                (noise.sigma or typical, noise.tau if noise.sigma else tau),
                lambda n, v: n.with_(sigma=float(v[0]), tau=float(v[1])),
                lambda v: {"sigma": float(v[0]), "correlation_time": float(v[1])},
                (typical, float(np.sqrt(np.prod(MEMORIES)))),
            )  # fmt: skip
        )
    out.append(
        Change(
            "gnss_outliers",
            ("gnss_outliers",),
            (noise.fraction or 0.02, noise.scale or 12.0 * typical),
            lambda n, v: n.with_(fraction=float(min(v[0], 0.3)), scale=float(v[1])),
            lambda v: {"fraction": float(min(v[0], 0.3)), "scale": float(v[1])},
        )  # fmt: skip
    )
    return out


def _size_of_fixes(of: str, noise: Noise) -> Change:
    """Another ratio of the errors of positions or velocities to what is stated."""

    def enter(n: Noise, v: Array) -> Noise:
        return n.with_(**{of: max(float(v[0]), LEAST)})

    def describe(v: Array) -> dict[str, Any]:
        return {"ratio": max(float(v[0]), LEAST), "of": of}

    return Change("gnss_noise", ("gnss_noise", of), (getattr(noise, of),), enter, describe)


def _lasting_velocity(tau: float, problem: Problem, noise: Noise) -> Change:
    """Errors of the velocities that last, in the place of a part of those that do not; beside
    them, where those have a size of their own.
    """
    typical = float(np.median(np.sqrt(problem.stated[problem.use[:, 3], 3:5])))
    apart = noise.velocity != 1.0

    def enter(n: Noise, v: Array) -> Noise:
        n = n.with_(velocity_sigma=float(v[0]), velocity_tau=float(v[1]))
        return n if apart else n.with_(velocity=max(float(v[2]), LEAST))

    def describe(v: Array) -> dict[str, Any]:
        return dict(zip(("sigma", "correlation_time", "ratio"), map(float, v)))

    start: tuple[float, ...] = (typical, tau)
    if noise.velocity_sigma:
        start = noise.velocity_sigma, noise.velocity_tau
    if not apart:
        start = (*start, noise.velocity)
    return Change(VELOCITY_LASTS, (VELOCITY_LASTS,), start, enter, describe)


def _of_processes(noise: Noise) -> list[Change]:
    """Changes of the parameters of the model's processes."""
    out = []
    for channel in CHANNELS:
        for position, process in enumerate(noise.model[channel].terms):
            names = [p.name for p in getattr(type(process), "parameters", ())]
            for name in [n for n in names if (process.name, n) in _CHANGEABLE]:
                out.append(_of_process(channel, position, process, name))
    return out


def _of_process(channel: str, position: int, process: Process, name: str) -> Change:
    """Another value of a parameter of a channel's process."""

    def enter(n: Noise, v: Array) -> Noise:
        return _with_process(n, channel, position, name, v[0])

    def describe(v: Array) -> dict[str, Any]:
        return {"channel": channel, "process": process.name, "name": name, "to": float(v[0])}

    key = ("bias_model", channel, process.name, name)
    return Change("bias_model", key, (float(getattr(process, name)),), enter, describe)


def _vibrations(problem: Problem, noise: Noise) -> list[Change]:
    """White noise that follows the speed, on each channel."""
    return [_vibration(number, noise, _usual(problem)) for number in range(len(CHANNELS))]


def _usual(problem: Problem) -> float:
    """Speed that is usual on the drive, m/s."""
    return float(np.sqrt(np.mean(problem.speed**2))) or 1.0


def _put(values: Sequence[Any], number: int, value: float) -> tuple[Any, ...]:
    """The values of the channels with another one of one of them."""
    return tuple(value if k == number else v for k, v in enumerate(values))


def _vibration(number: int, noise: Noise, speed: float) -> Change:
    """White noise of a channel that follows the speed; speed : m/s, usual on the drive."""
    channel = CHANNELS[number]
    density = max(_white(noise.model, channel), 1e-9)

    def enter(n: Noise, v: Array) -> Noise:
        return n.with_(per_speed=_put(n.per_speed, number, float(v[0])))

    def describe(v: Array) -> dict[str, Any]:
        return {"channel": channel, "N": density, "N_per_speed": float(v[0])}

    start = (noise.per_speed[number] or density / speed,)
    return Change("vibration", ("vibration", channel), start, enter, describe)


def shaken(problem: Problem, noise: Noise, channel: str) -> Change:
    """White noise of a channel that follows the speed, and at rest is larger than the sensor's own,
    too: an engine that shakes the car while it stands.
    """
    number, own = CHANNELS.index(channel), max(_white(noise.model, channel), 1e-9)

    def level(v: Array) -> float:
        return float(np.hypot(own, v[0]))

    def enter(n: Noise, v: Array) -> Noise:
        return n.with_(
            still=_put(n.still, number, level(v)),
            per_speed=_put(n.per_speed, number, float(v[1])),
        )

    def describe(v: Array) -> dict[str, Any]:
        return {"channel": channel, "N": level(v), "N_per_speed": float(v[1])}

    start = 3.0 * own, 3.0 * own / _usual(problem)
    return Change("vibration", ("vibration", channel), start, enter, describe)


_CHANGEABLE = {
    ("white_noise", "N"), ("random_walk", "K"), ("gauss_markov", "sigma"), ("flicker", "B"),
    ("gauss_markov", "correlation_time"), ("gauss_markov_2", "sigma"), ("autoregressive", "sigma"),
}  # fmt: skip


def _white(model: Model, channel: str) -> float:
    """Density N of the white noise of a channel."""
    return float(
        np.sqrt(sum(t.N**2 for t in model[channel].terms if isinstance(t, WhiteNoise)) or 0.0)
    )


#: Factors by which the first parameter is tried, on either side of what is held outward.
_FACTORS: dict[str, tuple[tuple[float, ...], ...]] = {
    "gnss_noise": ((0.87, 0.67, 0.4), (1.15, 1.5, 3.0, 30.0, 1000.0)),
    "bias_model": ((1.5, 6.0, 30.0), (0.67,)),
    "vibration": ((0.3, 1.0, 5.0, 25.0),),
}
_OTHERS = ((0.25, 1.0),)


def screen(
    state: State, noise: Noise, base: float, options: Sequence[Change]
) -> list[tuple[float, Change]]:
    """Gain of a few values of each change's first parameter, the best first, one for each key:
    [(gain, change)]. What is farther off than a value that gained less than the one before it is
    not tried: along one parameter the likelihood has one top.
    """

    def best(change: Change) -> tuple[float, Change]:
        top = -np.inf, change
        first, *others = change.start
        for side in _FACTORS.get(change.effect, _OTHERS):
            last = 0.0
            for factor in side:
                tried = replace(
                    change, start=(first * factor, *others), usual=change.usual or change.start
                )
                entered = tried.enter(noise, np.array(tried.start, float))
                value = state.evaluate(entered).log_likelihood - base
                value = value if np.isfinite(value) else -np.inf
                top = max(top, (value, tried), key=lambda t: t[0])
                if value <= last:
                    break
                last = value
            if last > 0.0:
                break
        return top

    ranked: dict[tuple[str, ...], tuple[float, Change]] = {}
    for value, change in each(best, options):
        if change.key not in ranked or ranked[change.key][0] < value:
            ranked[change.key] = value, change
    return sorted(ranked.values(), key=lambda g: -g[0])


def shortlist(ranked: list[tuple[float, Change]]) -> list[tuple[float, Change]]:
    """Of what `screen` ranked, what is fitted: the three best, and what else there is on the
    channel of the first, which a few values of one parameter do not part from it.
    """
    ranked = [r for r in ranked if r[0] > 1.0]
    if not ranked:
        return []
    top, first = ranked[0]
    near = [r for r in ranked[3:] if r[0] > top / 5.0 and r[1].key[1:2] == first.key[1:2]]
    return [*ranked[:3], *near]
