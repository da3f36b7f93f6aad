"""When was the sensor at rest? Windows found from the record itself.

The standard deviation over a moving window has two populations, at rest and handled, orders of
magnitude apart. The split between them is Otsu's (largest variance between two classes, on the
logarithm); the threshold is then drawn close to the resting class, from that class's own scatter,
so that the slow beginning and end of a movement do not count as rest. No threshold is set by hand
(Tedaldi et al. 2014 try multiples of the variance of a first rest of known length instead).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import InputError

#: Two classes closer than this factor are one class: the record rests all the time, or never.
SEPARATION = 3.0
#: A sensor at rest does not shake by more than this fraction of gravity.
REST_LIMIT = 0.05


@dataclass(frozen=True)
class RestWindows:
    """Where a record rests.

    `start`, `stop` (ndarray of int, shape (k,)): first sample and one past the last; `level`:
    median standard deviation at rest and `threshold`: what counts as rest, unit of the reading;
    `deviation` (ndarray, shape (n,)): the moving standard deviation they were found in.
    """

    start: np.ndarray
    stop: np.ndarray
    level: float
    threshold: float
    deviation: np.ndarray

    def __len__(self) -> int:
        return len(self.start)

    def means(self, reading: np.ndarray) -> np.ndarray:
        """Mean reading of each window, ndarray, shape (k, 3)."""
        return np.array(
            [reading[a:b].mean(axis=0) for a, b in zip(self.start, self.stop, strict=True)]
        )


def moving_deviation(reading: np.ndarray, width: int) -> np.ndarray:
    """Standard deviation over a centred window of `width` samples, axes pooled, ndarray, shape
    (n,).
    """
    x = reading - reading.mean(axis=0)
    sums = np.concatenate(
        [np.zeros((2, 1, x.shape[1])), np.stack([x, x * x]).cumsum(axis=1)], axis=1
    )
    n = len(x)
    low = np.clip(np.arange(n) - width // 2, 0, n - width)
    mean, square = (sums[:, low + width] - sums[:, low]) / width
    return np.sqrt(np.maximum(square - mean**2, 0).sum(axis=1))


def otsu(values: np.ndarray, bins: int = 200) -> float:
    """The value that splits `values` into the two classes of largest between-class variance (Otsu
    1979).
    """
    count, edges = np.histogram(values, bins)
    centre = (edges[1:] + edges[:-1]) / 2
    weight = np.cumsum(count)[:-1] / count.sum()
    total = (count * centre).sum() / count.sum()
    mean = np.cumsum(count * centre)[:-1] / count.sum()
    between = (total * weight - mean) ** 2 / np.maximum(weight * (1 - weight), 1e-12)
    return float(edges[1:-1][np.argmax(between)])


def rest_windows(
    accel: np.ndarray,
    fs: float,
    *,
    gyro: np.ndarray | None = None,
    window: float = 1.0,
    shortest: float = 1.0,
    gravity: float | None = None,
) -> RestWindows:
    """Windows in which the sensor is at rest.

    Parameters
    ----------
    accel : ndarray, shape (n, 3), any unit
    fs : float, Hz
    gyro : ndarray, shape (n, 3), any unit; a window must then be quiet in both
    window : float, s; length of the moving window
    shortest : float, s; shorter rests are left out
    gravity : float; gravity in the unit of `accel` (found from the spread of the readings when
    None)

    Raises
    ------
    InputError
        When the record is never at rest.
    """
    width = max(3, round(window * fs))
    if len(accel) < 2 * width:
        raise InputError(
            f"The record has {len(accel)} samples; {2 * width} are needed to look for rests of "
            f"{window:g} s at {fs:g} Hz."
        )
    accel = np.asarray(accel, float)
    deviation = moving_deviation(accel, width)
    quiet, level, threshold = _quiet(deviation)
    if gravity is None:  # gravity in counts: half the spread over the poses
        spread = np.ptp(np.quantile(accel, [0.01, 0.99], axis=0), axis=0).max() / 2
        gravity = max(spread, np.abs(np.median(accel, axis=0)).max())
    if level > REST_LIMIT * gravity:
        raise InputError(
            f"The sensor is never at rest: the accelerometers' standard deviation over {window:g} "
            f"s does not fall below {deviation.min():.3g}; record it standing still in several "
            "poses."
        )
    if gyro is not None:
        quiet &= _quiet(moving_deviation(np.asarray(gyro, float), width))[0]
    edges = np.flatnonzero(np.diff(np.concatenate([[False], quiet, [False]]).astype(int)))
    start, stop = edges[::2], edges[1::2]
    long = stop - start >= max(3, round(shortest * fs))
    if not long.any():
        raise InputError(f"The sensor is never at rest for {shortest:g} s; hold each pose longer.")
    return RestWindows(start[long], stop[long], level, threshold, deviation)


def _quiet(deviation: np.ndarray) -> tuple[np.ndarray, float, float]:
    """Which samples are at rest, the level of rest, and the threshold."""
    positive = deviation[deviation > 0]
    if not len(positive):  # a noiseless record that never moves
        return np.ones(len(deviation), bool), 0.0, 0.0
    log = np.log(np.maximum(deviation, positive.min()))
    split = otsu(log)
    low, high = log[log <= split], log[log > split]
    if np.exp(np.median(high) - np.median(low)) < SEPARATION:
        return np.ones(len(log), bool), float(np.exp(np.median(log))), float(deviation.max())
    middle = np.median(low)
    scatter = 1.4826 * np.median(np.abs(low[low <= middle] - middle))  # the side without movements
    threshold = min(split, middle + max(6 * scatter, np.log(1.5)))
    return log <= threshold, float(np.exp(middle)), float(np.exp(threshold))
