"""A whole record, compressed once into some hundred numbers that are nearly independent.

The record is taken through one discrete cosine transform (DCT-II). Its coefficients c_p, p = 1 ..
n-1, leave the
mean out (turn-on bias, gravity, Earth rate: a nuisance), and they diagonalise the covariance of
the noises that make
up an error model: exactly for white noise and for the random walk (the differences of both have
tridiagonal
covariances, whose eigenvectors are sines), nearly for flicker and Gauss-Markov. In units of a
one-sided density,

    I_p = 2 c_p^2 / fs,    E I_p = S(p fs / 2n)  (`kernel` for the first ones),    I_p / E I_p ~ chi-square, 1 dof.

The slow end is kept coefficient by coefficient; from `1/WIDTH` on, neighbours are summed over
bands of relative width
`WIDTH`, in which the density is a constant: seven hours at 100 Hz become about 450 numbers, and
nothing is lost that a
smooth spectrum could show. Slow and fast need no seam: they are one orthogonal transform.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.fft import dct
from scipy.special import ndtri

from .kernel import weights

WIDTH = 1 / 40
LINE_TAIL = 1e-9
#: Where the low coefficients end, per stretch.
SINGLES = 40
#: From this share of the rate on a filter may bend the density within a band: three Gauss-Legendre
#: points there.
BENT = 1 / 50


@dataclass(frozen=True)
class Stretch:
    """One gap-free stretch: `n` samples from `start` (index into the record); its coefficients,
    shape (n-1,), of which only those of `edges` are asked for.

    A coefficient may stand for `times` degrees of freedom: the root of a sum of so many squares.
    """

    start: int
    n: int
    coefficients: np.ndarray = field(repr=False)
    edges: np.ndarray = field(repr=False)
    dropped: np.ndarray = field(repr=False, default_factory=lambda: np.zeros(0, int))
    times: float = 1.0

    @property
    def count(self):
        """Coefficients in each band that count, shape (b,)."""
        out = np.searchsorted(self.dropped + 1, self.edges)
        return np.diff(self.edges - out).astype(float) * self.times

    def sums(self, values):
        """Sum `values` (n-1, ...) over the bands -> (b, ...)."""
        return np.add.reduceat(values[: self.edges[-1] - 1], self.edges[:-1] - 1, axis=0)


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

    rate: float
    frequency: np.ndarray = field(repr=False)
    count: np.ndarray = field(repr=False)
    power: np.ndarray = field(repr=False)
    stretches: tuple = field(repr=False)
    mean: float = 0.0
    lines: tuple = ()
    grid: np.ndarray = field(repr=False, default=None)

    @classmethod
    def of(cls, x, fs, *, band=None, exclude_lines=False, width=WIDTH):
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
            vibration), and list
            them in `lines`.
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
            coefficients = dct(part - part.mean(), norm="ortho")[1:] * np.sqrt(2 / fs)
            if not coefficients.any():
                raise ValueError("`x` is constant: there is no noise to fit")
            stretch = Stretch(start, len(part), coefficients, _edges(len(part), fs, band, width))
            if exclude_lines:
                stretch, found = _without_lines(stretch, fs)
                lines += found
            stretches.append(stretch)
            start += len(part)
        return cls._assemble(fs, tuple(stretches), sum(map(np.sum, parts)) / start, lines)

    @classmethod
    def _assemble(cls, fs, stretches, mean=0.0, lines=()):
        frequency, count, power, nodes = [], [], [], []
        for s in stretches:
            middle = (s.edges[:-1] + s.edges[1:] - 1) / 2
            frequency.append(middle * fs / (2 * s.n))
            count.append(s.count)
            power.append(s.sums(s.coefficients**2))
            nodes.append(np.minimum(weights(_singles(s))[0] * fs / s.n, fs / 2))
        frequency = np.concatenate(frequency)
        half = np.concatenate([np.diff(s.edges) * fs / (4 * s.n) for s in stretches])
        bent = (frequency > BENT * fs) & (np.concatenate(count) > 3)
        side = np.sqrt(0.6) * half[bent]
        grid = np.concatenate([frequency, frequency[bent] - side, frequency[bent] + side, *nodes])
        return cls(
            float(fs),
            frequency,
            np.concatenate(count),
            np.concatenate(power),
            stretches,
            float(mean),
            tuple(sorted(lines, key=lambda line: -line[1])),
            grid,
        )

    @property
    def n(self):
        """Samples in all stretches."""
        return sum(s.n for s in self.stretches)

    @property
    def duration(self):
        """Length of the longest stretch, s."""
        return max(s.n for s in self.stretches) / self.rate

    def collapse(self, density, *, bands=True):
        """Expected mean ordinate of each band, (..., b), from a one-sided density on `grid`, (...,
        g).
        """
        b = len(self.frequency)
        expected = np.array(density[..., :b])
        bent = np.flatnonzero((self.frequency > BENT * self.rate) & (self.count > 3))
        k = len(bent)
        if bands:  # the mean over a bent band
            expected[..., bent] = (
                8 * expected[..., bent]
                + 5 * density[..., b : b + k]
                + 5 * density[..., b + k : b + 2 * k]
            ) / 18
        at, node = 0, b + 2 * k
        for s in self.stretches:
            k = _singles(s)
            first = int(np.searchsorted(s.edges[:-1], k, side="right"))
            u, matrix = weights(k)
            low = s.edges[:first] - 1
            if first:
                expected[..., at : at + first] = density[..., node : node + len(u)] @ matrix[low].T
            at += len(s.edges) - 1
            node += len(u)
        return expected

    def between(self, low, high):
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
        return Statistics._assemble(self.rate, tuple(parts), self.mean, self.lines)

    def subtract(self, mean):
        """The statistics of x - mean, `mean` (n,) over all samples in order."""
        mean = np.asarray(mean, dtype=float)
        if mean.shape != (self.n,):
            raise ValueError(f"`mean` must have shape ({self.n},), got {mean.shape}")
        moved = tuple(
            replace(s, coefficients=s.coefficients - self._transform(mean, s))
            for s in self.stretches
        )
        return Statistics._assemble(self.rate, moved, self.mean - mean.mean(), self.lines)

    def regressors(self, columns):
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

    def _transform(self, values, s):
        part = values[s.start : s.start + s.n]
        shape = dct(part - part.mean(), norm="ortho")[1:] * np.sqrt(2 / self.rate)
        shape[s.dropped] = 0.0
        return shape


@dataclass(frozen=True)
class Regressors:
    """Per band: `gram` (b, q, q) and `cross` (b, q) of q mean shapes with each other and with the
    record.
    """

    gram: np.ndarray = field(repr=False)
    cross: np.ndarray = field(repr=False)

    def solve(self, expected):
        """Amplitudes (q,) by generalised least squares under `expected` (b,), and their covariance
        (q, q).
        """
        information = np.einsum("bij,b->ij", self.gram, 1 / expected)
        covariance = np.linalg.pinv(information, hermitian=True)
        return covariance @ (self.cross.T @ (1 / expected)), covariance

    def remaining(self, power, amplitudes):
        """Power per band once the shapes are taken out."""
        gone = 2 * self.cross @ amplitudes - np.einsum(
            "bij,i,j->b", self.gram, amplitudes, amplitudes
        )
        return np.maximum(power - gone, 0.0)


def _singles(s):
    return min(SINGLES, s.n // 4)


def _edges(n, fs, band, width):
    """First index of each band and one past the last: single up to 1/width, then geometric."""
    low, high = 1, n
    if band is not None:
        low = max(1, int(np.ceil(band[0] * 2 * n / fs)))
        high = min(n, int(np.floor(band[1] * 2 * n / fs)) + 1)
    if high - low < 4:
        raise ValueError(f"`band` {band} leaves fewer than four coefficients of {n} samples")
    edges = np.arange(1, min(n, int(1 / width) + 1) + 1)
    tail = n / (1 + width) ** np.arange(int(np.log(n / edges[-1]) / np.log1p(width)) + 1)
    edges = np.unique(np.concatenate([edges, np.rint(tail[tail > edges[-1]]).astype(int), [n]]))
    return np.unique(np.concatenate([[low], edges[(edges > low) & (edges < high)], [high]]))


def _without_lines(s, fs):
    """The stretch without the ordinates beyond the LINE_TAIL point of their band's median level,
    and the lines.
    """
    limit = ndtri(LINE_TAIL / 2) ** 2
    ordinates = s.coefficients**2
    top = np.maximum.reduceat(ordinates[: s.edges[-1] - 1], s.edges[:-1] - 1)
    dropped, lines = [], []
    for b in np.flatnonzero((s.count >= 12) & (top > limit / 3 * s.sums(ordinates) / s.count)):
        inside = ordinates[s.edges[b] - 1 : s.edges[b + 1] - 1]
        out = np.flatnonzero(inside > limit * np.median(inside) / 0.454936)
        if len(out) and len(out) < len(inside) / 4:
            dropped.append(s.edges[b] - 1 + out)
            # neighbours are one line; ordinates 2 c^2/fs sum to the mean square times 2 n/fs
            for group in np.split(out, np.flatnonzero(np.diff(out) > 3) + 1):
                peak = s.edges[b] + group[np.argmax(inside[group])]
                lines.append(
                    (peak * fs / (2 * s.n), float(np.sqrt(inside[group].sum() * fs / 2 / s.n)))
                )
    if not dropped:
        return s, []
    dropped = np.concatenate(dropped)
    kept = s.coefficients.copy()
    kept[dropped] = 0.0
    return replace(s, coefficients=kept, dropped=dropped), lines
