"""Sensor states: what the processes of an error model become in the filter.

Nothing here knows a filter by its number of states: the 15-, 18- and 27-state filters of the 2013
paper (its Table 8)
are three models given to this one builder. Each process hands over its own state space; the blocks
stand channel by
channel, gyro x to accelerometer z, so that the transition is block diagonal.
"""

from dataclasses import dataclass

import numpy as np

from imu_lib.errors import InputError, UndefinedFormError
from imu_lib.model import Model
from imu_lib.processes import GaussMarkov
from imu_lib.record import CHANNELS

from .free import on_channels, on_measurements
from .structures import Sensors

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
class SensorStates:
    """The sensor half of the filter, for one sampling interval.

    transition, noise, initial : ndarray, shape (m, m), step matrix, step covariance, covariance at
    the start
    output : ndarray, shape (m,), weight of each state in its channel's error
    first : ndarray, shape (8,), int, where each channel's states begin, where those of the
    measurements begin, and m
    static : ndarray, shape (7,), int, where in each of these blocks the states begin that keep
    their value
    white : ndarray, shape (6,), two-sided densities N^2 of the channels' white noise; white_speed
    (6,) what is added to them per squared speed
    driver : ndarray, shape (m,), int, -1, or the reading (gyro 0-2, accelerometer 3-5) that the
    state is multiplied by (a scale factor error, ...)
    at : ndarray, shape (7,), int, first column of each group of `structures.MEASUREMENT_STATES`
    among the sensor states, -1 where there is none
    names : tuple of str, one per state; ignored : tuple of str, processes that have no state,
    channel by channel
    """

    transition: np.ndarray
    noise: np.ndarray
    initial: np.ndarray
    output: np.ndarray
    first: np.ndarray
    static: np.ndarray
    white: np.ndarray
    white_speed: np.ndarray
    driver: np.ndarray
    at: np.ndarray
    names: tuple
    ignored: tuple

    @property
    def count(self):
        """Number of sensor states; the filter has nine more."""
        return self.output.size

    def arrays(self) -> Sensors:
        """What the kernel takes of it."""
        return Sensors(
            self.transition,
            self.noise,
            self.output,
            self.first,
            self.static,
            self.driver,
            self.white,
            self.white_speed,
        )


def sensor_states(
    model: Model,
    rate,
    *,
    turn_on_sd=(0.0, 0.0),
    scale_sd=(0.0, 0.0),
    constant=False,
    flicker="refuse",
    free=None,
    vibration=None,
    correlated=None,
) -> SensorStates:
    """The sensor states of an error model at a sampling rate.

    Parameters
    ----------
    model : Model with all six channels
    rate : float, Hz
    turn_on_sd : (gyro rad/s, accelerometer m/s^2)
        Standard deviation of the bias left at switch-on. It goes to the slowest state of each
        channel, so that it
        adds none: a Gauss-Markov state forgets it with its correlation time, as the paper's
        15-state filters do.
    constant : bool
        The bias goes to a state that keeps it, added where a channel has none.
    scale_sd : (gyro, accelerometer), dimensionless
        Where above zero, three scale factor states of that standard deviation are added for the
        sensor.
    flicker : "refuse" or "markov"
        1/f noise has no finite state space; "markov" puts one Gauss-Markov process per decade in
        its place
        (0.1 s to 10,000 s, sigma = B sqrt(ln 10 / pi)), within 10 % of its spectrum between 1e-4
        and 1 Hz.
    free : mapping of a group of `free.GROUPS` to standard deviations: parameters as states
    vibration : mapping of channel to (N or None, N_per_speed): white noise that follows the speed
    correlated : (sigma m, correlation_time s) of the fixes' positions

    Raises
    ------
    InputError
        If a channel is missing, or an autoregressive process has another rate.
    UndefinedFormError
        For flicker noise, unless an approximation was asked for, and for an unstable
        autoregressive process.
    """
    missing = [c for c in CHANNELS if c not in model]
    if missing:
        raise InputError(
            f"the error model {model.name or ''} has no channel {missing[0]}; the filter needs all six"
        )
    if flicker not in ("refuse", "markov"):
        raise ValueError(f"`flicker` must be 'refuse' or 'markov', not {flicker!r}")
    free = dict(free or {})
    for group, sd in zip(("gyro_scale", "accel_scale"), scale_sd):
        if sd > 0.0:
            free.setdefault(group, sd)
    extra, vibration = on_channels(free), dict(vibration or {})
    blocks, first, static, white, white_speed, ignored = [], [0], [], [], [], []
    for number, channel in enumerate(CHANNELS):
        density, parts, left = _parts(model[channel], channel, rate, flicker)
        ignored += left
        _turned_on(parts, turn_on_sd[number // 3], constant)
        parts = [
            _Part(f"{channel} {p.name}", p.transition, p.noise, p.output, p.initial) for p in parts
        ]
        moving = [p for p in parts if not p.static]
        still = [p for p in parts if p.static] + [
            _constant(name, sd**2, driver) for c, driver, name, sd in extra if c == number
        ]
        blocks += moving + still
        level, per_speed = vibration.get(channel, (None, 0.0))
        white.append(density if level is None else level**2)
        white_speed.append(per_speed**2)
        static.append(first[-1] + sum(p.output.size for p in moving))
        first.append(static[-1] + sum(p.output.size for p in still))
    more, sd, step, noise, at = on_measurements(free, correlated, 1.0 / rate)
    for i in range(len(more)):
        blocks.append(
            _Part(
                more[i],
                *(np.full((1, 1), v) for v in (step[i], noise[i])),
                np.zeros(1),
                np.full((1, 1), sd[i] ** 2),
            )
        )
    at = np.where(at >= 0, at + first[-1], -1)
    # the correlated errors of the fixes move, the rest of the measurements' states keep still: all
    # are taken as moving where there are some
    static.append(first[-1] + (len(more) if correlated is not None else 0))
    first.append(first[-1] + len(more))
    return _assembled(blocks, first, static, white, white_speed, at, ignored)


@dataclass(frozen=True)
class _Part:
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


def _constant(name, variance, driver=-1):
    return _Part(
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
            parts.append(_constant("constant", 0.0))
            continue
        for each in _states_of(process, channel, flicker):
            space = each.state_space()
            density += space.direct
            if not space.order:
                continue
            if space.rate is not None and abs(space.rate / rate - 1.0) > 5e-3:
                raise InputError(
                    f"the {each.name} process of {channel} steps at {space.rate:g} Hz, the drive at {rate:g} Hz; "
                    "fit it at the drive's rate"
                )
            step = space.discrete(1.0 / space.rate if space.rate is not None else 1.0 / rate)
            parts.append(_Part(each.name, *step, np.ravel(space.H), space.P0.copy()))
    return density, parts, ignored


def _turned_on(parts, sd, constant):
    """Adds the bias left at switch-on to the slowest of a channel's states, in place; constant : to
    one that does not forget it.
    """
    if not sd > 0.0:
        return
    if not parts or (constant and not {p.name for p in parts} & {"constant", "random_walk"}):
        parts.append(_constant("constant", 0.0))
    slowest = min(
        range(len(parts)),
        key=lambda i: (_SLOWEST_FIRST.index(parts[i].name), -parts[i].transition[0, 0]),
    )
    parts[slowest].initial[:, :] += sd**2 * _held(parts[slowest])


def _assembled(blocks, first, static, white, white_speed, at, ignored):
    m = first[-1]
    transition, noise, initial = np.zeros((m, m)), np.zeros((m, m)), np.zeros((m, m))
    output, driver, names, begin = np.zeros(m), np.full(m, -1, np.int64), [], 0
    for block in blocks:
        size = block.output.size
        part = slice(begin, begin + size)
        transition[part, part], noise[part, part] = block.transition, block.noise
        initial[part, part], output[part], driver[part] = block.initial, block.output, block.driver
        names += [block.name + (f" {i}" if size > 1 else "") for i in range(size)]
        begin += size
    return SensorStates(
        transition,
        noise,
        initial,
        output,
        np.array(first, np.int64),
        np.array(static, np.int64),
        np.array(white),
        np.array(white_speed),
        driver,
        at.astype(np.int64),
        tuple(names),
        tuple(ignored),
    )


def _states_of(process, channel, flicker):
    if process.name != "flicker":
        return [process]
    if flicker == "refuse":
        raise UndefinedFormError(
            f"the flicker noise of {channel} has no finite state space: fit a gauss_markov process in its place, "
            "or ask for flicker='markov', one Gauss-Markov process per decade"
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
