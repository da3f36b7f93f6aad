"""A level that jumps once and stays: taken for noise, it is a random walk that there is not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from imu_lib import units
from imu_lib.record import Record

#: Means over the record in which a jump is looked for, and samples of a mean at the least.
BLOCKS, LEAST = 120, 8
#: Means below which none is looked for.
FEWEST = 20
#: Shares of a jump that the second of two differences has.
SHARES = (0.0, 0.25, 0.5, 0.75)
#: Log-likelihood that a jump has to gain over white noise and a random walk, beyond the freedom of
#: its time, and over a single mean that is off.
GAIN, OVER = 10.0, 5.0
#: Random walks that are tried: variance of a step over that of the white noise in a mean.
WALKS = np.r_[0.0, np.geomspace(1e-4, 1e2, 19)]


#: How the sentence begins, whoever hands it on.
BEGINS = "The level jumps once and stays"


@dataclass(frozen=True)
class Jump:
    """time : s from the first sample, within a mean's length. amplitude : unit of the channel."""

    time: float
    amplitude: float
    gain: float


def of(x: np.ndarray, rate: float) -> Jump | None:
    """The one jump of a level that white noise and a random walk together do not explain; None
    where there is none. `x` has shape (n,), even and without gaps.

    Differences of block means have the covariance of a moving average of order one, and a jump is
    one of them that is off, or two neighbours where it lies within a block. The walk is as strong
    as the record likes, with the jump and without.
    """
    size = max(len(x) // BLOCKS, LEAST)
    k = len(x) // size
    if k < FEWEST:
        return None
    d = np.diff(x[: k * size].reshape(k, size).mean(axis=1))
    if not np.any(d):
        return None
    unit = np.eye(k - 1)
    white = 2.0 * unit - np.eye(k - 1, k=1) - np.eye(k - 1, k=-1)
    none, other, jump = -np.inf, -np.inf, (-np.inf, 0, 0.0)
    for walk in WALKS:
        inverse = np.linalg.inv(white + walk * unit)
        base = 0.5 * float(np.linalg.slogdet(inverse)[1])
        alone = inverse @ d
        misfit = float(d @ alone)

        def likelihood(fall, base=base, misfit=misfit):  # a common factor at its maximum
            return base - 0.5 * (k - 1) * np.log(misfit - fall)

        none = max(none, likelihood(0.0))
        other = max(other, likelihood(_largest(inverse, alone, (1.0, -1.0))[0]))
        for share in SHARES:
            fall, at, amplitude = _largest(inverse, alone, (1.0 - share, share))
            jump = max(jump, (likelihood(fall), at, amplitude))
    gain = float(jump[0] - none - np.log(len(SHARES) * k))
    if gain < GAIN or jump[0] - other < OVER:
        return None
    return Jump((jump[1] + 1) * size / rate, jump[2], gain)


def _largest(inverse, alone, shape) -> tuple[float, int, float]:
    """Greatest fall of the misfit by two neighbouring differences of that shape: (fall, place of
    the first, amplitude).
    """
    a, b = shape
    variance = np.diag(inverse)
    match = a * alone[:-1] + b * alone[1:]
    weight = a * a * variance[:-1] + b * b * variance[1:] + 2 * a * b * np.diag(inverse, 1)
    fall = match**2 / weight
    at = int(np.argmax(fall))
    return float(fall[at]), at, float(match[at] / weight[at])


def sentence(record: Record, names) -> str | None:
    """What is said of the channels whose level jumps once; None where none does. The record is
    even and has no gaps.
    """
    told = []
    for name in names:
        jump = of(record[name], record.rate)
        if jump is not None:
            factor, unit = (units.DEG_PER_S, "deg/s") if name.startswith("gyro") else (units.G, "g")
            told.append(f"{name} by {jump.amplitude / factor:.3g} {unit} near {jump.time:.3g} s")
    if not told:
        return None
    return (
        f"{BEGINS} ({'; '.join(told)}): K, B and slow Gauss-Markov processes of these channels "
        "take it for noise of the sensor; cut the record there with --start or --stop, or let "
        "`imu-lib gap` take it out."
    )
