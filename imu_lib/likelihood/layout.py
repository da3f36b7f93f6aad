"""Which ordinates of a record lie in which band, and what a spectrum makes of them.

Records of one length and rate have one `Layout`: it knows the frequencies at which a spectrum has
to be evaluated, the means over the bands, and remembers each process of strength 1, so that a fit
that moves amplitudes alone evaluates no spectrum at all.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from imu_lib.arrays import Array
from imu_lib.processes import LowPass, Process, Quantization, WhiteNoise

from .kernel import weights

WIDTH = 1 / 40
#: Where the low coefficients end, per stretch.
SINGLES = 40
#: From this share of the rate on a filter may bend the density within a band: three Gauss-Legendre
#: points there.
BENT_FROM = 1 / 50
#: Shapes that a layout remembers, and filters with their images.
SHAPES, FILTERS = 4000, 64
#: Correlation time in units of 1 / cutoff from which on the images that a filter folds onto the
#: grid lie below a millionth of a process.
SLOW_BESIDE_FILTER = 20.0


@dataclass(frozen=True)
class Stretch:
    """One gap-free stretch: `n` samples from `start` (index into the record); its ordinates as
    roots of their power, shape (n-1,), of which only those of `edges` are asked for.

    An ordinate may stand for `times` degrees of freedom: the root of a sum of so many squares. Of
    `tapered` ones the p-th of `n` lies at p fs / 2n, too, but hears nothing of far frequencies,
    and its phase is not kept.
    """

    start: int
    n: int
    coefficients: Array = field(repr=False)
    edges: Any = field(repr=False)
    dropped: Any = field(repr=False, default_factory=lambda: np.zeros(0, int))
    times: float = 1.0
    tapered: bool = False

    @property
    def count(self) -> Array:
        """Coefficients in each band that count, shape (b,)."""
        out = np.searchsorted(self.dropped + 1, self.edges)
        return np.diff(self.edges - out).astype(float) * self.times

    @property
    def singles(self) -> int:
        """Coefficients from the first on whose expectation is an integral over the spectrum."""
        return 0 if self.tapered else min(SINGLES, self.n // 4)

    def sums(self, values: Array) -> Array:
        """Sum `values` (n-1, ...) over the bands -> (b, ...)."""
        return np.add.reduceat(values[: self.edges[-1] - 1], self.edges[:-1] - 1, axis=0)

    @property
    def key(self) -> tuple[Any, ...]:
        """What its expectations hang on."""
        return self.n, self.times, self.tapered, np.asarray(self.edges, np.int64).tobytes()


def edges_of(n: int, fs: float, band: tuple[float, float] | None, width: float) -> Any:
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


def amplitude_of(process: Process) -> str:
    """Name of the parameter that a noise scales with, empty where it has none."""
    return next((p.name for p in process.parameters if p.kind == "amplitude"), "")


def of_strength_one(process: Process) -> tuple[Process, float]:
    """(process of amplitude 1, squared amplitude)."""
    name = amplitude_of(process)
    amplitude = getattr(process, name) if name else 1.0
    if amplitude == 1.0:
        return process, 1.0
    unit = copy(process)  # valid as it is: not checked again, a hundred thousand times
    object.__setattr__(unit, name, 1.0)
    return unit, amplitude**2


class Images:
    """What a low-pass filter run above the sampling rate folds onto the grid: `Sum.psd`, with the
    gains kept.
    """

    def __init__(self, low_pass: LowPass, grid: Array, fs: float):
        ratio = low_pass.ratio(fs)
        self.rate = ratio * fs
        at = np.mod(grid + fs * np.arange(ratio)[:, None], self.rate)
        self.at = np.minimum(at, self.rate - at)
        self.gain = low_pass.gain(self.at.ravel(), fs).reshape(self.at.shape)
        self.cutoff = low_pass.cutoff or fs / 4

    def psd(self, term: Process) -> Array:
        """One-sided density of the term behind the filter, (g,).

        The images of a process that is slow against the filter lie below a millionth of it and are
        left out.
        """
        if term.memory * self.cutoff > SLOW_BESIDE_FILTER:
            return self.gain[0] * term.psd(self.at[0], self.rate)
        return np.einsum("kg,kg->g", self.gain, term.psd(self.at, self.rate))


class Layout:
    """The bands of stretches at one rate.

    Attributes
    ----------
    rate : float, Hz
    frequency : ndarray, shape (b,)
        Middle of each band, Hz.
    half : ndarray, shape (b,)
        Half of its width, Hz.
    slow : int
        Bands of cosine coefficients, which come first; the others are tapered.
    grid : ndarray, shape (g,)
        Where a spectrum is evaluated for `collapse`, Hz.
    """

    def __init__(self, rate: float, stretches: tuple[Stretch, ...]):
        self.rate = float(rate)
        middle = [(s.edges[:-1] + s.edges[1:] - 1) / 2 * rate / (2 * s.n) for s in stretches]
        self.frequency = np.concatenate(middle)
        self.half = np.concatenate([np.diff(s.edges) * rate / (4 * s.n) for s in stretches])
        self.slow = sum(len(s.edges) - 1 for s in stretches if not s.tapered)
        size = np.concatenate([np.diff(s.edges) * s.times for s in stretches])
        self._bent = np.flatnonzero((self.frequency > BENT_FROM * rate) & (size > 3))
        self._parts = [(s.n, s.singles, np.array(s.edges), s.tapered) for s in stretches]
        side = np.sqrt(0.6) * self.half[self._bent]
        at = self.frequency[self._bent]
        nodes = [
            np.minimum(weights(s.singles)[0] * rate / s.n, rate / 2) for s in stretches if s.singles
        ]
        self.grid = np.concatenate([self.frequency, at - side, at + side, *nodes])
        self._shapes: dict[Any, Array] = {}
        self._images: dict[LowPass, Images] = {}

    def collapse(self, density: Array, *, bands: bool = True) -> Array:
        """Expected mean ordinate of each band, (..., b), from a one-sided density on `grid`, (...,
        g).
        """
        b = len(self.frequency)
        expected = np.array(density[..., :b])
        bent, k = self._bent, len(self._bent)
        if bands:  # the mean over a bent band
            expected[..., bent] = (
                8 * expected[..., bent]
                + 5 * density[..., b : b + k]
                + 5 * density[..., b + k : b + 2 * k]
            ) / 18
        at, node = 0, b + 2 * k
        for _, singles, edges, _ in self._parts:
            if singles:
                u, matrix = weights(singles)
                first = int(np.searchsorted(edges[:-1], singles, side="right"))
                low = edges[:first] - 1
                expected[..., at : at + first] = density[..., node : node + len(u)] @ matrix[low].T
                node += len(u)
            at += len(edges) - 1
        return expected

    def ends(self, term: Process, low_pass: LowPass | None = None) -> Array | float:
        """What the two ends of a finite record add to quantization: 8 Q^2 fs / n cos^2, which its
        f^2 leaves out, and of that what a filter lets through.

        Exact for the samples, so it stands in for what the kernel, made for red spectra, gives the
        first coefficients.
        """
        if not isinstance(term, Quantization):
            return 0.0
        n = np.concatenate(
            [np.full(len(edges) - 1, np.inf if t else n) for n, _, edges, t in self._parts]
        )
        psd = self._behind(term, low_pass)
        passed = self._behind(WhiteNoise(N=1.0), None if term.behind_filter else low_pass)
        share = float(self.half @ passed[: len(n)] / (2.0 * self.half.sum()))
        ends = 8 * term.Q**2 * self.rate / n * np.cos(np.pi * self.frequency / self.rate) ** 2
        return share * ends + psd[: len(n)] - self.collapse(psd, bands=False)

    def _behind(self, term: Process, low_pass: LowPass | None) -> Array:
        """One-sided density on the grid of a process behind the filter, (g,)."""
        if low_pass is None or term.behind_filter:
            return term.psd(self.grid, self.rate)
        return self.images(low_pass).psd(term)

    def shape(self, process: Process, low_pass: LowPass | None = None) -> Array:
        """Expected density of a process behind the filter, (b,), not to be written to."""
        key = process, low_pass
        if key not in self._shapes:
            if len(self._shapes) > SHAPES:
                self._shapes.clear()
            out = self.collapse(self._behind(process, low_pass)) + self.ends(process, low_pass)
            out.setflags(write=False)
            self._shapes[key] = out
        return self._shapes[key]

    def images(self, low_pass: LowPass) -> Images:
        """The images of the grid behind a filter."""
        if low_pass not in self._images:
            if len(self._images) > FILTERS:
                self._images.clear()
            self._images[low_pass] = Images(low_pass, self.grid, self.rate)
        return self._images[low_pass]

    def spectrum(self, terms: Any, low_pass: LowPass | None = None) -> Array:
        """Expected density of a sum of processes behind the filter, (b,)."""
        out = np.zeros(len(self.frequency))
        for term in terms:
            unit, square = of_strength_one(term)
            out += square * self.shape(unit, low_pass)
        return out


_LAYOUTS: dict[Any, Layout] = {}


def layout_of(rate: float, stretches: tuple[Stretch, ...]) -> Layout:
    """The layout of stretches, one object for all that are alike."""
    key = float(rate), *(s.key for s in stretches)
    if key not in _LAYOUTS:
        while len(_LAYOUTS) >= 8:
            _LAYOUTS.pop(next(iter(_LAYOUTS)), None)
        _LAYOUTS[key] = Layout(rate, stretches)
    return _LAYOUTS[key]
