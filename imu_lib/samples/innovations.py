"""What a smooth spectrum does not foresee: whitening, and how far a sample is from what its
neighbours foretell.
"""

from __future__ import annotations

from copy import copy

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from imu_lib.arrays import Array
from imu_lib.samples.blocks import block_length, statistics

#: Degrees of freedom of a spectrum at the least: the reciprocal of what has one or two is now and
#: then a hundred times too large, and whitening amplifies what little there is.
FREEDOM = 24.0
#: Share of the mean spectrum below which a stop band is not followed where samples are drawn or
#: lines are looked for.
STOP_BAND_DEPTH = 1e-5
#: Share of the spectrum at the most that is taken for rounding.
ROUNDED = 0.99


def trend(x: Array, m: int) -> np.ndarray:
    """The slow part of a record: straight lines between the means of blocks of `m` samples."""
    k = len(x) // m
    means = x[: k * m].reshape(k, m).mean(axis=1)
    centre = (np.arange(len(means)) + 0.5) * m - 0.5
    t = np.arange(len(x))
    out = np.interp(t, centre, means)
    if len(means) > 1:  # beyond the outer centres the line goes on
        for part, i, j in ((t < centre[0], 0, 1), (t > centre[-1], -1, -2)):
            out[part] = means[i] + (means[i] - means[j]) / (centre[i] - centre[j]) * (
                t[part] - centre[i]
            )
    return out


class Smooth:
    """A smooth spectrum of the samples, read off the record itself with lines cut down.

    Above one cycle per two blocks it is the binned periodogram; below it the lowest of these bins.
    """

    def __init__(self, x: Array, fs: float, *, floor: float = 0.0) -> None:
        self.fs, self.n = fs, len(x)
        self.m = block_length(self.n, fs)
        stats = statistics(x, fs)
        self.layout, self.count, mean = stats.layout, stats.count, stats.mean_power
        # a line lifts a few ordinates of its band: cap the ordinates at what their band's quiet
        # mean allows
        k, quick = self.layout.slow, stats.stretches[1]
        edges = quick.edges - quick.edges[0]
        cap = 12.0 * np.minimum(mean, _neighbours(mean))[k:]
        power = quick.coefficients[quick.edges[0] - 1 : quick.edges[-1] - 1] ** 2 / quick.times
        power = np.minimum(power, np.repeat(cap, np.diff(edges)))
        mean = np.concatenate([mean[:k], np.add.reduceat(power, edges[:-1]) / np.diff(edges)])
        mean[k:] = _pooled(mean[k:], self.count[k:])
        quiet = np.median(mean[k : k + 10]) if len(mean) > k + 10 else mean[k:].mean()
        self.level = np.concatenate([np.full(k, quiet), mean[k:]]) + floor
        # with the slow end as it is, falling with frequency, for filling gaps in
        slow_end = (
            np.convolve(np.pad(mean[:k], 1, mode="edge"), np.ones(3) / 3, "valid")
            if k > 2
            else mean[:k]
        )
        self.full = (
            np.concatenate(
                [np.maximum.accumulate(np.maximum(slow_end, quiet)[::-1])[::-1], mean[k:]]
            )
            + floor
        )
        self._cache: dict[int, np.ndarray] = {}
        self._heard: np.ndarray | None = None

    def above(self, rounding: Array | float) -> Smooth:
        """The same to whiten by, so that a band counts by its share of what is not `rounding` (a
        density in the bands): behind a filter that is all there is, and it has no part in what
        becomes of the noise.
        """
        share = 1.0 - np.clip(rounding / self.level, 0.0, ROUNDED)
        out = copy(self)
        out._cache, out._heard = {}, (share / np.max(share)) ** 2
        return out

    def slow_too(self, size: int) -> np.ndarray:
        """As `on`, with the slow end of the record's own spectrum and further down into a stop
        band: what is drawn must not fill it.
        """
        return np.maximum(self.between(self.full, size), STOP_BAND_DEPTH * np.mean(self.on(size)))

    def on(self, size: int) -> np.ndarray:
        """The spectrum, unit^2/Hz, at the ordinates of a real transform of `size` points."""
        if size not in self._cache:
            s = self.between(self.level, size)
            # below a thousandth of the mean there is nothing but the arithmetic of a filter's stop
            # band
            floored = np.maximum(s, 1e-3 * np.mean(s))
            if self._heard is not None:
                floored /= self.between(self._heard, size)
            self._cache[size] = floored
        return self._cache[size]

    def between(self, values: Array, size: int) -> np.ndarray:
        """`values` in the bins at the ordinates of a real transform of `size` points."""
        f, own = np.arange(size // 2 + 1) * self.fs / size, self.layout.frequency
        return np.exp(np.interp(np.log(np.maximum(f, own[0])), np.log(own), np.log(values)))

    def stop_band(self, size: int) -> np.ndarray:
        """Share of its power that whitening leaves at each ordinate: 1, and less in a filter's
        stop band.
        """
        return self.between(self.level, size) / self.on(size)

    @property
    def independent(self) -> float:
        """Independent samples of the whitened record per sample: fewer than one where a filter's
        stop band is left out.
        """
        left = self.stop_band(2048)
        return float(np.mean(left) ** 2 / np.mean(left**2))

    @property
    def traces(self) -> float:
        """Samples that one which is thrown off makes surprising: the sum of the squares of the
        surprises' autocorrelation.
        """
        inverse = 1.0 / self.on(4096)
        return float(np.mean(inverse**2) / np.mean(inverse) ** 2)

    @property
    def sample_variance(self) -> float:
        """Variance of a sample of the fast part."""
        return float(self.on(2048).mean() * self.fs / 2)

    @property
    def conditional_variance(self) -> float:
        """Variance of a sample when all others are known."""
        return float(self.fs / 2 / np.mean(1.0 / self.on(2048)))


def _pooled(mean: Array, nu: Array) -> np.ndarray:
    """The bins' means (k,), those of less than `FREEDOM` degrees of freedom `nu` with as many
    neighbours on either side as it takes.
    """
    total, freedom = (np.concatenate([[0.0], np.cumsum(v)]) for v in (nu * mean, nu))
    out, i = np.array(mean), np.arange(len(mean))
    left = np.flatnonzero(nu < FREEDOM)
    for half in range(1, len(mean)):
        if len(left) == 0:
            break
        a, b = np.maximum(i[left] - half, 0), np.minimum(i[left] + half + 1, len(mean))
        enough = (freedom[b] - freedom[a] >= FREEDOM) | (half == len(mean) - 1)
        here = left[enough]
        out[here] = ((total[b] - total[a]) / (freedom[b] - freedom[a]))[enough]
        left = left[~enough]
    return out


def _neighbours(mean: Array) -> np.ndarray:
    wide = np.pad(mean, 4, mode="edge")
    return np.median(np.lib.stride_tricks.sliding_window_view(wide, 9), axis=1)


def padded_size(n: int) -> int:
    """Length of the transforms of `n` samples: even, quick, and long enough that the ends do not
    meet.
    """
    size = next_fast_len(n + min(n, 4096), real=True)
    while size % 2:
        size = next_fast_len(size + 1, real=True)
    return size


def _filter(x: Array, gain: Array, size: int) -> np.ndarray:
    n = len(x)
    tail = np.linspace(x[-1], x[0], size - n + 2)[
        1:-1
    ]  # a bridge back to the start instead of a jump
    return irfft(rfft(np.concatenate([x, tail])) * gain, size)[:n]


def whitened(x: Array, smooth: Smooth) -> np.ndarray:
    """The fast part of a record as white noise of variance 1 (zero phase)."""
    size, left = padded_size(len(x)), np.mean(smooth.stop_band(2048))
    gain = 1.0 / np.sqrt(left * smooth.on(size) * smooth.fs / 2)
    return _filter(x - trend(x, smooth.m), gain, size)


def surprises(x: Array, smooth: Smooth) -> np.ndarray:
    """How far each sample lies from what all the others foretell, in standard deviations."""
    size = padded_size(len(x))
    inverse = 1.0 / (smooth.on(size) * smooth.fs / 2)
    return _filter(x - trend(x, smooth.m), inverse, size) / np.sqrt(np.mean(inverse))
