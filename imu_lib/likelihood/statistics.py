"""A whole record, compressed once into some hundred numbers that are nearly independent.

The record is taken through one discrete cosine transform (DCT-II). Its coefficients c_p, p = 1 ..
n-1, leave the mean out (turn-on bias, gravity, Earth rate: a nuisance), and they diagonalise the
covariance of the noises that make up an error model: exactly for white noise and for the random
walk (the differences of both have tridiagonal covariances, whose eigenvectors are sines), nearly
for flicker and Gauss-Markov. In units of a one-sided density,

    I_p = 2 c_p^2 / fs,    E I_p = S(p fs / 2n)  (`kernel` for the first ones),    I_p / E I_p ~
    chi-square, 1 dof.

The slow end is kept coefficient by coefficient; from `1/WIDTH` on, neighbours are summed over bands
of relative width `WIDTH`, in which the density is a constant: seven hours at 100 Hz become about
450 numbers, and nothing is lost that a smooth spectrum could show. Slow and fast need no seam: they
are one orthogonal transform (`Statistics.of`). Where a filter may be, the bare transform would fill
its stop band with what it lets through, some 1/n of it: `Statistics.split` takes the fast end from
a tapered periodogram, in the same units and the same formula.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from scipy.fft import dct, idct

from imu_lib.arrays import Array

from . import tapered
from .layout import WIDTH, Layout, Stretch, edges_of, layout_of
from .lines import without_lines
from .regressors import Regressors

#: Part of the way to the seam from which on the slow end fades into the fast one.
FADED = 0.5


@dataclass(frozen=True)
class Statistics:
    """The compressed record: what `log_likelihood` and `fit` work on.

    Attributes
    ----------
    rate : float, Hz
    frequency : ndarray, shape (b,)
        Middle of each band, Hz.
    count : ndarray, shape (b,)
        Independent ordinates summed in it (degrees of freedom).
    power : ndarray, shape (b,)
        Their sum, unit^2/Hz; `power / count` estimates the one-sided density.
    stretches : tuple of Stretch
    mean : float
        Mean of the record, which the other numbers leave out.
    lines : tuple of (float, float)
        Frequency and rms amplitude of the spectral lines that were left out (`exclude_lines`).
    """

    layout: Layout = field(repr=False)
    count: Array = field(repr=False)
    power: Array = field(repr=False)
    stretches: tuple[Stretch, ...] = field(repr=False)
    mean: float = 0.0
    lines: tuple[tuple[float, float], ...] = ()

    @classmethod
    def of(
        cls,
        x: Any,
        fs: float,
        *,
        band: tuple[float, float] | None = None,
        exclude_lines: bool = False,
        width: float = WIDTH,
    ) -> Self:
        """Compress a channel.

        Parameters
        ----------
        x : ndarray, shape (n,), or a list of such
            The channel, without NaN; a list holds the stretches between gaps (each with its own
            mean).
        fs : float
            Rate, Hz.
        band : (float, float), optional
            Keep only the frequencies between these, Hz (for a filter of unknown shape at the upper
            end).
        exclude_lines : bool
            Leave out single ordinates that stand out of their band as one in 1e9 would (mains,
            vibration), and list them in `lines`.
        width : float
            Relative width of a band.

        Raises
        ------
        ValueError
            If `x` is too short (8 samples), not finite, or constant.
        """
        if not (np.isfinite(fs) and fs > 0):
            raise ValueError(f"`fs` must be a positive rate in Hz, got {fs!r}")
        parts = list(x) if isinstance(x, (list, tuple)) else [x]
        stretches, start, lines = [], 0, []
        for part in parts:
            part = np.asarray(part, dtype=float)
            if part.ndim != 1 or len(part) < 8:
                raise ValueError(
                    f"`x` must hold at least 8 samples in one dimension, got shape {part.shape}"
                )
            if not np.isfinite(part).all():
                raise ValueError(
                    "`x` has samples that are not finite: pass the stretches between them as a list"
                )
            coefficients = cosines(part, fs)
            if not coefficients.any():
                raise ValueError("`x` is constant: there is no noise to fit")
            stretch = Stretch(start, len(part), coefficients, edges_of(len(part), fs, band, width))
            if exclude_lines:
                stretch, found = without_lines(stretch, fs)
                lines += found
            stretches.append(stretch)
            start += len(part)
        return cls.assembled(fs, tuple(stretches), sum(map(np.sum, parts)) / start, lines)

    @classmethod
    def split(cls, x: Array, fs: float, seam: float, *, width: float = WIDTH) -> Self:
        """Compress a channel whose spectrum may be steep, as behind a filter.

        Below `seam` Hz the cosine coefficients count, which hear the drifts and the walks; above
        it the ordinates of a tapered periodogram (`tapered`), which an untapered transform of a
        short record would fill with what the filter lets through.

        Parameters
        ----------
        x : ndarray, shape (n,)
        fs : float, Hz
        seam : float, Hz
        """
        n = len(x)
        edges = edges_of(n, fs, (0.0, seam), width)
        coefficients = dct(x - np.mean(x), norm="ortho")
        kept = coefficients[1 : edges[-1]] * np.sqrt(2 / fs)
        slow = Stretch(0, n, kept, edges)
        # what is slow has gone where the taper, short as it is, would let it into the bands above
        p = np.arange(edges[-1])
        coefficients[: edges[-1]] *= np.clip((p / edges[-1] - FADED) / (1 - FADED), 0.0, 1.0)
        fast = tapered.stretch(idct(coefficients, norm="ortho"), fs, seam, width=width)
        return cls.assembled(fs, (slow, fast), float(np.mean(x)))

    @classmethod
    def assembled(
        cls, fs: float, stretches: tuple[Stretch, ...], mean: float = 0.0, lines: Any = ()
    ) -> Self:
        """From stretches and the lines that were left out of them."""
        return cls(
            layout_of(fs, stretches),
            np.concatenate([s.count for s in stretches]),
            np.concatenate([s.sums(s.coefficients**2) for s in stretches]),
            stretches,
            float(mean),
            tuple(sorted(lines, key=lambda line: -line[1])),
        )

    @property
    def rate(self) -> float:
        """Hz."""
        return self.layout.rate

    @property
    def frequency(self) -> Array:
        """Middle of each band, Hz, shape (b,)."""
        return self.layout.frequency

    @property
    def grid(self) -> Array:
        """Where a spectrum is evaluated for `collapse`, Hz."""
        return self.layout.grid

    @property
    def mean_power(self) -> Array:
        """Mean ordinate of each band, an estimate of the density, unit^2/Hz, shape (b,)."""
        return self.power / np.maximum(self.count, 1e-300)

    @property
    def n(self) -> int:
        """Samples in all stretches."""
        return sum(s.n for s in self.stretches)

    @property
    def duration(self) -> float:
        """Length of the longest stretch, s."""
        return max(s.n for s in self.stretches) / self.rate

    def collapse(self, density: Array, *, bands: bool = True) -> Array:
        """Expected mean ordinate of each band; see `Layout.collapse`."""
        return self.layout.collapse(density, bands=bands)

    def without(self, bands: Any) -> Self:
        """The statistics with the ordinates of some bands, a mask (b,), left out."""
        return replace(
            self, count=np.where(bands, 0.0, self.count), power=np.where(bands, 0.0, self.power)
        )

    def with_fast(self, other: Statistics) -> Self:
        """The statistics with the tapered bands of others of the same layout."""
        k = self.layout.slow
        power = np.concatenate([self.power[:k], other.power[k:]])
        return replace(self, power=np.where(self.count > 0, power, 0.0))

    def slow_ordinates(self, values: Array) -> Array:
        """`values` of the slow bands, (b,), at each cosine coefficient of the record, (p,)."""
        sizes = np.diff(self.stretches[0].edges)
        return np.repeat(values[: len(sizes)], sizes)

    def between(self, low: float, high: float) -> Statistics:
        """The statistics of the bands that lie between two frequencies, Hz."""
        parts = []
        for s in self.stretches:
            step = self.rate / (2 * s.n)
            keep = s.edges[(s.edges * step >= low) & ((s.edges - 1) * step <= high)]
            if len(keep) >= 5:
                parts.append(replace(s, edges=keep))
        if not parts:
            raise ValueError(
                f"`low` and `high` leave fewer than four bands between {low:g} and {high:g} Hz"
            )
        return Statistics.assembled(self.rate, tuple(parts), self.mean, self.lines)

    def subtract(self, mean: Array) -> Statistics:
        """The statistics of x - mean, `mean` (n,) over all samples in order."""
        mean = np.asarray(mean, dtype=float)
        if mean.shape != (self.n,):
            raise ValueError(f"`mean` must have shape ({self.n},), got {mean.shape}")
        moved = tuple(
            replace(s, coefficients=s.coefficients - self._transform(mean, s))
            for s in self.stretches
        )
        return Statistics.assembled(self.rate, moved, self.mean - mean.mean(), self.lines)

    def regressors(self, columns: Array) -> Regressors:
        """Cross-products of mean shapes with the record, `columns` (n, q): what a fit of their
        amplitudes needs.
        """
        columns = np.asarray(columns, dtype=float)
        columns = columns[:, None] if columns.ndim == 1 else columns
        if columns.shape[0] != self.n:
            raise ValueError(f"`columns` must have {self.n} rows, got {columns.shape[0]}")
        gram, cross = [], []
        for s in self.stretches:
            shape = np.stack([self._transform(c, s) for c in columns.T], axis=1)
            gram.append(s.sums(shape[:, :, None] * shape[:, None, :]))
            cross.append(s.sums(shape * s.coefficients[:, None]))
        return Regressors(np.concatenate(gram), np.concatenate(cross))

    def regressors_of(self, shapes: Array) -> Regressors:
        """As `regressors`, of shapes that are given by the cosine coefficients that count, (p, q),
        and that reach into no other bands.
        """
        s, rest = self.stretches[0], len(self.power) - (len(self.stretches[0].edges) - 1)
        own = s.coefficients[: len(shapes), None]
        at, q = s.edges[:-1] - 1, shapes.shape[1]
        seen = (self.count[: len(at)] > 0).astype(float)[:, None]
        gram = np.add.reduceat(shapes[:, :, None] * shapes[:, None, :], at, axis=0)
        gram, cross = gram * seen[:, :, None], np.add.reduceat(shapes * own, at, axis=0) * seen
        return Regressors(
            np.concatenate([gram, np.zeros((rest, q, q))]),
            np.concatenate([cross, np.zeros((rest, q))]),
        )

    def _transform(self, values: Array, s: Stretch) -> Array:
        if s.tapered:
            raise ValueError("a tapered stretch keeps no phases: compress the difference instead")
        part = values[s.start : s.start + s.n]
        shape = cosines(part, self.rate)
        shape[s.dropped] = 0.0
        return shape


def cosines(x: Array, fs: float) -> Array:
    """Cosine coefficients 1 .. n-1 of a stretch (or columns), their squares in units of a one-sided
    density.
    """
    return dct(x - x.mean(axis=0), norm="ortho", axis=0)[1:] * np.sqrt(2 / fs)
