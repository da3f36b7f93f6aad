"""The states of a channel's processes: each hands over its own state space."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from imu_lib.errors import InputError, UndefinedFormError
from imu_lib.processes import GaussMarkov, Process, StateSpace

# deterministic functions of the time since switching on, or without a place in a state: said in
# `ignored`
_WITHOUT_STATE = ("ramp", "sinusoid", "warm_up", "temperature", "step", "quantization")
_SLOWEST_FIRST = (
    "constant",
    "random_walk",
    "gauss_markov",
    "gauss_markov_2",
    "telegraph",
    "autoregressive",
)


@dataclass(frozen=True)
class Part:
    """States of one process: step matrix and covariance, weights, covariance at the start."""

    name: str
    transition: np.ndarray
    noise: np.ndarray
    output: np.ndarray
    initial: np.ndarray
    driver: int = -1

    @property
    def static(self):
        return (self.transition == np.eye(self.output.size)).all() and not self.noise.any()


def of_channel(entry, channel, how, turn_on_sd, constant):
    """(white density, states that move, states that keep their value, processes without a state)
    of a channel; how: rate and what becomes of flicker noise.
    """
    density, parts, left = _parts(entry, channel, *how)
    _turned_on(parts, turn_on_sd, constant)
    parts = [Part(f"{channel} {p.name}", p.transition, p.noise, p.output, p.initial) for p in parts]
    return density, [p for p in parts if not p.static], [p for p in parts if p.static], left


def constant_state(name, variance, driver=-1):
    return Part(
        name, np.eye(1), np.zeros((1, 1)), np.ones(1), np.full((1, 1), float(variance)), driver
    )


def _parts(entry, channel, rate, flicker):
    """(white density, states of the processes, names of those without a state) of a channel."""
    density, parts, ignored = 0.0, [], []
    for process in entry.terms:
        if process.name in _WITHOUT_STATE:
            ignored.append(f"{channel}: {process.name}")
            continue
        if process.name == "constant":
            parts.append(constant_state("constant", 0.0))
            continue
        for each in _states_of(process, channel, flicker):
            space, step = _over_a_sample(each, rate)
            density += space.direct
            if not space.order:
                continue
            if space.rate is not None and abs(space.rate / rate - 1.0) > 5e-3:
                raise InputError(
                    f"the {each.name} process of {channel} steps at {space.rate:g} Hz, the drive "
                    f"at {rate:g} Hz; fit it at the drive's rate"
                )
            parts.append(Part(each.name, *step, np.ravel(space.H), space.P0.copy()))
    return density, parts, ignored


@lru_cache(maxsize=1024)
def _over_a_sample(process: Process, rate: float) -> tuple[StateSpace, tuple]:
    """A process as states, with its step matrix and covariance; its own rate is kept where it has
    one. A search asks for the same process thousands of times: what is returned is not to be
    changed.
    """
    space = process.state_space()
    return space, space.discrete(1.0 / (rate if space.rate is None else space.rate))


def _turned_on(parts, sd, constant):
    """Adds the bias left at switch-on to the slowest of a channel's states, in place; constant : to
    one that does not forget it.
    """
    if not sd > 0.0:
        return
    if not parts or (constant and not {p.name for p in parts} & {"constant", "random_walk"}):
        parts.append(constant_state("constant", 0.0))
    slowest = min(
        range(len(parts)),
        key=lambda i: (_SLOWEST_FIRST.index(parts[i].name), -parts[i].transition[0, 0]),
    )
    parts[slowest].initial[:, :] += sd**2 * _held(parts[slowest])


def _states_of(process, channel, flicker):
    if process.name != "flicker":
        return [process]
    if flicker == "refuse":
        raise UndefinedFormError(
            f"the flicker noise of {channel} has no finite state space: fit a gauss_markov process "
            "in its place, or ask for flicker='markov', one Gauss-Markov process per decade"
        )
    sigma = process.B * np.sqrt(np.log(10.0) / np.pi)
    return [
        GaussMarkov(sigma=sigma, correlation_time=float(10.0**power) / (2.0 * np.pi))
        for power in range(-1, 5)
    ]


def _held(part):
    """Covariance of a constant of unit variance in the states of a process: all lags alike where
    the states are lags.
    """
    size = part.output.size
    if part.name == "autoregressive":
        return np.ones((size, size))
    unit = np.zeros((size, size))
    unit[0, 0] = 1.0
    return unit
