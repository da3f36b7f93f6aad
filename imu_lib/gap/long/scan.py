"""One pass over a channel of a long record: block means for the slow view, and of each window what
tells whether it is like the others.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy.fft import rfft

from imu_lib.arrays import Array
from imu_lib.long_record.record import LongRecord
from imu_lib.stream import Keep, Means

#: Samples of a window, nearly; of a segment of its spectrum.
WINDOW, SEGMENT = 1 << 16, 1 << 10
#: Robust standard deviations beyond which a sample does not count to its block's mean; where more
#: than a share of the samples do not, they are what the sensor does.
FAR, MANY = 8.0, 0.01
#: Robust standard deviations of the second difference beyond which a sample stands alone.
ALONE = 6.0

_TIME = np.arange(SEGMENT) - 0.5 * (SEGMENT - 1)
_TAPER = np.hanning(SEGMENT + 1)[:-1] * np.sqrt(8 / 3)


@dataclass(frozen=True)
class Scan:
    """What one pass leaves of a channel.

    Attributes
    ----------
    name : str
    means : ndarray, shape (blocks,)
        Of blocks of `block` samples, without what stands alone in them.
    density : ndarray of float32, shape (windows, SEGMENT / 2 - 1)
        Averaged spectrum of each window without what stands alone, unit^2 times samples.
    alone, same : ndarray, shape (windows,)
        Samples far off their block or both neighbours; samples equal to the one before.
    left_out : int
        Samples that do not count to the means.
    """

    name: str
    block: int
    window: int
    means: np.ndarray
    density: np.ndarray
    alone: np.ndarray
    same: np.ndarray
    left_out: int


def scan(record: LongRecord, name: str, runs: Array, block: int) -> Scan:
    """The pass over the samples of these runs of a LongRecord."""
    window = block * max(1, round(WINDOW / block))
    kept = Keep()
    blocks = Means(block, [kept])
    density, alone, same, left_out = [], [], [], 0
    for x in windows(record.pieces(name, runs), window):
        whole = x.size // block * block
        clean, out = _without_lone(x[:whole], block)
        blocks.feed(clean)
        left_out += out
        if x.size < window:
            break
        clean, lone = _without_single(clean)
        density.append(_spectrum(clean).astype(np.float32))
        alone.append(out + lone)
        same.append(int(np.count_nonzero(x[1:] == x[:-1])))
    return Scan(
        name,
        block,
        window,
        kept.values,
        np.array(density).reshape(len(density), SEGMENT // 2 - 1),
        np.array(alone),
        np.array(same),
        left_out,
    )


def windows(pieces: Iterable[Array], size: int) -> Iterator[Array]:
    """Pieces put together to windows of `size` samples; the last may be shorter."""
    held: list[Array] = []
    n = 0
    for x in pieces:
        held.append(x)
        n += x.size
        while n >= size:
            joined = np.concatenate(held)
            yield joined[:size]
            held, n = [joined[size:]], n - size
    if n:
        yield np.concatenate(held)


def _without_lone(x: Array, block: int) -> tuple[Array, int]:
    """(samples, number replaced): what stands far off its block's median takes the mean of the
    rest.
    """
    y = x.reshape(-1, block)
    off = y - np.median(y, axis=1)[:, None]
    sd = 1.4826 * np.median(np.abs(off))
    if sd == 0:
        sd = float(np.sqrt(np.mean(off**2)))
    far = np.abs(off) > FAR * sd
    count = int(np.count_nonzero(far))
    if count == 0 or count > MANY * x.size or far.all(axis=1).any():
        return x, 0
    out = np.where(far, np.nan, y)
    rows = np.flatnonzero(far.any(axis=1))
    out[rows] = np.where(far[rows], np.nanmean(out[rows], axis=1)[:, None], y[rows])
    return out.ravel(), count


def _without_single(x: Array) -> tuple[Array, int]:
    """(samples, number replaced): a sample far off both its neighbours takes their mean."""
    d = x[1:-1] - 0.5 * (x[:-2] + x[2:])
    size = np.abs(d)
    sd = 1.4826 * np.median(size)
    far = size > ALONE * sd if sd > 0 else np.zeros(size.size, bool)
    far[1:] &= size[1:] >= size[:-1]
    far[:-1] &= size[:-1] >= size[1:]
    at = np.flatnonzero(far) + 1
    if at.size == 0 or at.size > MANY * x.size:
        return x, int(at.size)
    y = x.copy()
    y[at] = 0.5 * (x[at - 1] + x[at + 1])
    return y, int(at.size)


def _spectrum(x: Array) -> Array:
    """Averaged squared transform of tapered segments, without the ends of the range."""
    y = x[: x.size // SEGMENT * SEGMENT].reshape(-1, SEGMENT)
    y = y - y.mean(axis=1)[:, None]
    y -= np.outer(y @ _TIME / (_TIME @ _TIME), _TIME)  # what drifts is the means' affair
    z = rfft(y * _TAPER, axis=1)[:, 1:-1]
    return (z.real**2 + z.imag**2).mean(axis=0) / SEGMENT
