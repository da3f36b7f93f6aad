"""A clean channel and what the likelihood needs of it."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np

from imu_lib.arrays import Array
from imu_lib.likelihood import tapered
from imu_lib.likelihood.layout import Layout
from imu_lib.likelihood.statistics import Statistics, cosines
from imu_lib.samples.blocks import block_length, statistics

#: Gain in log-likelihood below which a screened candidate is not fitted.
SCREEN = 4.0
#: Points to a block on which a drift is evaluated.
FINE = 4


class Data:
    """A clean, evenly sampled channel.

    Parameters
    ----------
    x : ndarray, shape (n,)
    fs : float, Hz
    white : float
        Variance that the electronics add to every sample (rounding), unit^2.
    extra : ndarray, optional
        One-sided density that the electronics add in the bands, where it is not 2 white / fs.
    blind : ndarray of bool, optional
        Bands that tell nothing: the stop band of a filter, where samples that were filled in are
        stronger than the signal.
    missing : ndarray of bool, shape (n,), optional
        Samples that were filled in: they tell nothing of when something happened.
    """

    def __init__(
        self,
        x: Array,
        fs: float,
        *,
        white: float = 0.0,
        temperature: Array | None = None,
        extra: Array | None = None,
        blind: Array | None = None,
        missing: Array | None = None,
    ) -> None:
        self.x, self.fs, self.white, self.blind = x, float(fs), white, blind
        self.missing = missing
        self.n = len(x)
        self.m = block_length(self.n, self.fs)
        self.duration = self.n / self.fs
        self.temperature = temperature
        self._extra = extra
        self._kept: dict[Any, Any] = {}

    def minus(self, signal: Array) -> Data:
        """The channel without a deterministic signal."""
        out = Data(
            self.x - signal,
            self.fs,
            white=self.white,
            temperature=self.temperature,
            extra=self._extra,
            blind=self.blind,
            missing=self.missing,
        )
        out._kept = self._kept
        return out

    def below(self, frequency: float) -> Data:
        """The channel with what is above a frequency in Hz left out."""
        out = Data(self.x, self.fs, white=self.white, temperature=self.temperature)
        out._kept = self._kept
        out._extra, above = self._extra, self.layout.frequency >= frequency
        out.blind = above if self.blind is None else above | self.blind
        out.__dict__["z"] = self.z
        return out

    def part(self, x: Array, rows: slice) -> Data:
        """The samples `x` of some of the rows, with the electronics of the whole."""
        warmth = None if self.temperature is None else self.temperature[rows]
        out = Data(x, self.fs, white=self.white, temperature=warmth)
        bands, own = out.layout.frequency, self.layout.frequency
        if self._extra is not None:
            out._extra = np.interp(bands, own, self.extra)
        if self.blind is not None:
            out.blind = np.interp(bands, own, self.blind.astype(float)) > 0
            del out.__dict__["stats"]  # these were with the blind bands
        return out

    # -- what it says ----------------------------------------------------------------------------
    @cached_property
    def stats(self) -> Statistics:
        """The statistics, with the blind bands left out."""
        stats = statistics(self.x, self.fs)
        return stats if self.blind is None else stats.without(self.blind)

    @property
    def layout(self) -> Layout:
        """Its bands."""
        return self.stats.layout

    @cached_property
    def extra(self) -> Array:
        """Density that the electronics add in the bands, shape (b,)."""
        if self._extra is not None:
            return self._extra
        return np.full(len(self.layout.frequency), 2.0 * self.white / self.fs)

    @cached_property
    def z(self) -> Array:
        """Transform of the tapered record."""
        return tapered.transform(self.x)

    def once(self, key: Any, make: Callable[[], Any]) -> Any:
        """What `make()` gives, made once for this channel whatever is taken out of it."""
        if key not in self._kept:
            self._kept[key] = make()
        return self._kept[key]

    # -- drifts ----------------------------------------------------------------------------------
    @property
    def orders(self) -> int:
        """Cosine coefficients in which drifts are heard."""
        return len(self.stats.stretches[0].coefficients)

    @property
    def cosines(self) -> Array:
        """These coefficients of the record, shape (orders,)."""
        return self.stats.stretches[0].coefficients

    @property
    def slow_sd(self) -> float:
        """Standard deviation of the part of the record that these coefficients are."""
        return float(np.sqrt(np.sum(self.cosines**2) * self.fs / (2 * self.n)))

    @cached_property
    def _cells(self) -> Array:
        count = min(self.n, FINE * (self.n // self.m))
        return np.rint(np.linspace(0, self.n, count + 1)).astype(int)

    @cached_property
    def grid_time(self) -> Array:
        """Times in s at which drifts are evaluated: the middles of equal parts of the record."""
        count = len(self._cells) - 1
        return ((np.arange(count) + 0.5) * self.n / count - 0.5) / self.fs

    @cached_property
    def grid_temperature(self) -> Array | None:
        """Mean temperature in these parts, or None."""
        if self.temperature is None:
            return None
        return np.add.reduceat(self.temperature, self._cells[:-1]) / np.diff(self._cells)

    def columns(self, values: Array) -> np.ndarray:
        """Cosine coefficients, shape (orders, q), of drifts (parts, q) given on the grid."""
        scale = np.sqrt(self.n / len(values))
        return cosines(values, self.fs)[: self.orders] * scale
