"""Sensor states: what the processes of an error model become in the filter.

Nothing here knows a filter by its number of states: the 15-, 18- and 27-state filters of the 2013
paper (its Table 8) are three models given to this one builder. Each process hands over its own
state space; the blocks stand channel by channel, gyro x to accelerometer z, so that the transition
is block diagonal.
"""

from dataclasses import dataclass

import numpy as np

from imu_lib.errors import InputError
from imu_lib.model import Model
from imu_lib.record import CHANNELS

from .free import on_channels, on_measurements
from .process_states import Part, constant_state, of_channel
from .structures import Sensors


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

    def over(self, intervals) -> Sensors:
        """What the kernel takes of it over several intervals at once."""
        once, (s, q) = self.arrays(), (np.eye(self.count), np.zeros((self.count, self.count)))
        for _ in range(intervals):
            s, q = once.transition @ s, once.transition @ q @ once.transition.T + once.noise
        return once._replace(transition=s, noise=q)

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
        channel, so that it adds none: a Gauss-Markov state forgets it with its correlation time,
        as the paper's 15-state filters do.
    constant : bool
        The bias goes to a state that keeps it, added where a channel has none.
    scale_sd : (gyro, accelerometer), dimensionless
        Where above zero, three scale factor states of that standard deviation are added for the
        sensor.
    flicker : "refuse" or "markov"
        1/f noise has no finite state space; "markov" puts one Gauss-Markov process per decade in
        its place (0.1 s to 10,000 s, sigma = B sqrt(ln 10 / pi)), within 10 % of its spectrum
        between 1e-4 and 1 Hz.
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
            f"the error model {model.name or ''} has no channel {missing[0]}; the filter needs "
            "all six"
        )
    if flicker not in ("refuse", "markov"):
        raise ValueError(f"`flicker` must be 'refuse' or 'markov', not {flicker!r}")
    free = dict(free or {})
    for group, sd in zip(("gyro_scale", "accel_scale"), scale_sd):
        if sd > 0.0:
            free.setdefault(group, sd)
    of_each = (rate, flicker), turn_on_sd, constant
    blocks, places, white, ignored = _of_channels(model, of_each, free, dict(vibration or {}))
    first, static = places
    more, at = _of_measurements(free, correlated, rate)
    blocks += more
    at = np.where(at >= 0, at + first[-1], -1)
    # the correlated errors of the fixes move, the rest of the measurements' states keep still: all
    # are taken as moving where there are some
    static.append(first[-1] + (len(more) if correlated is not None else 0))
    first.append(first[-1] + len(more))
    return _assembled(blocks, places, white, at, ignored)


def _of_channels(model, of_each, free, vibration):
    """States of the six channels; where each channel's, and those of them that keep still, begin;
    white densities and what is added per squared speed; processes without a state.

    of_each : (rate and what becomes of flicker noise), (bias at switch-on of gyro, accelerometer),
    and whether it is kept
    """
    how, turn_on_sd, constant = of_each
    extra = on_channels(free)
    blocks, first, static, white, white_speed, ignored = [], [0], [], [], [], []
    for number, channel in enumerate(CHANNELS):
        density, moving, still, left = of_channel(
            model[channel], channel, how, turn_on_sd[number // 3], constant
        )
        ignored += left
        still += [
            constant_state(name, sd**2, driver) for c, driver, name, sd in extra if c == number
        ]
        blocks += moving + still
        level, per_speed = vibration.get(channel, (None, 0.0))
        white.append(density if level is None else level**2)
        white_speed.append(per_speed**2)
        static.append(first[-1] + sum(p.output.size for p in moving))
        first.append(static[-1] + sum(p.output.size for p in still))
    return blocks, (first, static), (white, white_speed), ignored


def _of_measurements(free, correlated, rate):
    """States of the measurements, and where each group of them begins."""
    names, sd, step, noise, at = on_measurements(free, correlated, 1.0 / rate)
    parts = [
        Part(
            name,
            *(np.full((1, 1), v) for v in (step[i], noise[i])),
            np.zeros(1),
            np.full((1, 1), sd[i] ** 2),
        )
        for i, name in enumerate(names)
    ]
    return parts, at


def _assembled(blocks, places, white, at, ignored):
    first, static = places
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
        *(np.array(w) for w in white),
        driver,
        at.astype(np.int64),
        tuple(names),
        tuple(ignored),
    )
