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
    first : ndarray, shape (7,), int, where each channel's states begin
    white : ndarray, shape (6,), two-sided densities N^2 of the channels' white noise
    scale : ndarray, shape (m,), bool: the state is multiplied by the channel's reading (a scale
    factor error)
    names : tuple of str, one per state; ignored : tuple of str, processes that have no state,
    channel by channel
    """

    transition: np.ndarray
    noise: np.ndarray
    initial: np.ndarray
    output: np.ndarray
    first: np.ndarray
    white: np.ndarray
    scale: np.ndarray
    names: tuple
    ignored: tuple

    @property
    def count(self):
        """Number of sensor states; the filter has nine more."""
        return self.output.size


def sensor_states(
    model: Model, rate, *, turn_on_sd=(0.0, 0.0), scale_sd=(0.0, 0.0), flicker="refuse"
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
    scale_sd : (gyro, accelerometer), dimensionless
        Where above zero, three scale factor states of that standard deviation are added for the
        sensor.
    flicker : "refuse" or "markov"
        1/f noise has no finite state space; "markov" puts one Gauss-Markov process per decade in
        its place
        (0.1 s to 10,000 s, sigma = B sqrt(ln 10 / pi)), within 10 % of its spectrum between 1e-4
        and 1 Hz.

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
    blocks, first, white, scale, names, ignored = [], [0], [], [], [], []
    for number, channel in enumerate(CHANNELS):
        sensor = number // 3
        density, parts = 0.0, []
        for process in model[channel].terms:
            if process.name in _WITHOUT_STATE:
                ignored.append(f"{channel}: {process.name}")
                continue
            if process.name == "constant":
                parts.append(
                    (process.name, np.eye(1), np.zeros((1, 1)), np.ones(1), np.zeros((1, 1)))
                )
                continue
            for each in _states_of(process, channel, flicker):
                space = each.state_space()
                density += space.direct
                if space.order:
                    if space.rate is not None and abs(space.rate / rate - 1.0) > 5e-3:
                        raise InputError(
                            f"the {each.name} process of {channel} steps at {space.rate:g} Hz, the drive at {rate:g} Hz; "
                            "fit it at the drive's rate"
                        )
                    step = space.discrete(
                        1.0 / space.rate if space.rate is not None else 1.0 / rate
                    )
                    parts.append((each.name, *step, np.ravel(space.H), space.P0.copy()))
        if turn_on_sd[sensor] > 0.0:
            if not parts:
                parts.append(
                    ("constant", np.eye(1), np.zeros((1, 1)), np.ones(1), np.zeros((1, 1)))
                )
            slowest = min(
                range(len(parts)),
                key=lambda i: (_SLOWEST_FIRST.index(parts[i][0]), -parts[i][1][0, 0]),
            )
            parts[slowest][4][:, :] += turn_on_sd[sensor] ** 2 * _held(parts[slowest])
        for name, transition, noise, output, initial in parts:
            blocks.append((transition, noise, output, initial))
            names += [
                f"{channel} {name}" + (f" {i}" if output.size > 1 else "")
                for i in range(output.size)
            ]
            scale += [False] * output.size
        if scale_sd[sensor] > 0.0:
            blocks.append(
                (np.eye(1), np.zeros((1, 1)), np.ones(1), np.full((1, 1), scale_sd[sensor] ** 2))
            )
            names.append(f"{channel} scale factor")
            scale.append(True)
        white.append(density)
        first.append(len(names))
    m = len(names)
    transition, noise, initial, output = (
        np.zeros((m, m)),
        np.zeros((m, m)),
        np.zeros((m, m)),
        np.zeros(m),
    )
    at = 0
    for s, q, h, p in blocks:
        part = slice(at, at + h.size)
        transition[part, part], noise[part, part], initial[part, part], output[part] = s, q, p, h
        at += h.size
    return SensorStates(
        transition,
        noise,
        initial,
        output,
        np.array(first),
        np.array(white),
        np.array(scale, bool),
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
    name, _, _, output, _ = part
    if name == "autoregressive":
        return np.ones((output.size, output.size))
    unit = np.zeros((output.size, output.size))
    unit[0, 0] = 1.0
    return unit


def van_loan(f, q, dt):
    """Exact transition and step covariance of dx/dt = f x + w (Van Loan 1978, Eqs. 1.1-1.4): what
    the fast forms are checked against.

    f, q : ndarray, shape (k, k), dynamics and two-sided density of w
    """
    from scipy.linalg import expm

    k = f.shape[0]
    block = expm(np.block([[-f, q], [np.zeros((k, k)), f.T]]) * dt)
    transition = block[k:, k:].T
    return transition, transition @ block[:k, k:]
