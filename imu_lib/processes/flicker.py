"""Flicker noise: bias instability."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft
from scipy.special import digamma

from imu_lib.arrays import Array, ArrayLike

from .base import FREE, Parameter, Process
from .sampled import avar_from_semivariogram, cluster_size

#: Flat Allan variance over B^2, 2 ln2 / pi = 0.664^2 (IEEE Std 952-1997, Annex C.1.2).
FLAT = 2.0 * np.log(2.0) / np.pi


@dataclass(frozen=True)
class Flicker(Process):
    """Bias instability: noise with two-sided density B^2 / (2 pi f).

    Its samples are the half-integrated white noise of Kasdin (1995), (1 - z^-1)^(-1/2) w with
    standard deviation B: density B^2 dt / (2 sin(pi f dt)), which is the same at low frequency. The
    increments over d samples then have the variance (2 B^2 / pi) (digamma(d + 1/2) - digamma(1/2)),
    and the Allan variance tends to (2 ln2 / pi) B^2, the square of 0.664 B.

    Parameters
    ----------
    B : float, signal unit
    """

    B: float = FREE
    name: ClassVar[str] = "flicker"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("B", "amplitude", "bias instability, signal unit"),
    )

    @property
    def memory(self) -> float:
        return math.inf

    def psd(self, f: ArrayLike, fs: float | None = None) -> Array:
        self._require()
        f = np.asarray(f, dtype=float)
        with np.errstate(divide="ignore"):
            if fs is None:
                return self.B**2 / (np.pi * f)
            return self.B**2 / (fs * np.sin(np.pi * f / fs))

    def avar(self, tau: ArrayLike, fs: float | None = None) -> Array:
        self._require()
        tau = np.asarray(tau, dtype=float)
        if fs is None:
            return np.full(tau.shape, FLAT * self.B**2)
        return self.B**2 * _avar_of_unit(cluster_size(tau, fs))

    def semivariogram(self, d: ArrayLike) -> Array:
        """E (x_{k+d} - x_k)^2 / 2 of samples `d` apart, unit^2, shape of `d`."""
        self._require()
        return self.B**2 / np.pi * (digamma(np.asarray(d) + 0.5) - digamma(0.5))

    def simulate(
        self,
        n: int,
        fs: float,
        rng: np.random.Generator,
        *,
        temperature: Array | None = None,
        start: float = 0.0,
    ) -> Array:
        # The increments are stationary, so their circulant embedding is an exact draw.
        self._require()
        half = next_fast_len(max(n, 2), real=True)
        size = 2 * half
        noise = rng.standard_normal(half + 1) + 1j * rng.standard_normal(half + 1)
        noise[0] = noise[0].real * np.sqrt(2.0)
        noise[-1] = noise[-1].real * np.sqrt(2.0)
        y = irfft(noise * _amplitudes(half), size)[:n]
        y[:1] = 0.0
        return self.B * np.cumsum(y, out=y)


@lru_cache(maxsize=4)
def _amplitudes(half: int) -> Array:
    """Amplitudes of the circulant embedding of the increments for B = 1, shape (half + 1,); kept
    for the next draw.
    """
    d = np.arange(half + 1)
    r = -1.0 / (np.pi * (d * d - 0.25))
    out = np.sqrt(np.maximum(rfft(np.concatenate([r, r[-2:0:-1]])).real, 0.0) * half)
    out.setflags(write=False)
    return out


def _avar_of_unit(m: Array) -> Array:
    """Exact Allan variance of samples for B = 1; beyond 1024 samples the limit with its 1/m^2
    term.
    """
    flat = np.atleast_1d(m)
    out = np.empty(flat.shape)
    longest = int(min(flat.max(initial=1.0), 1024))
    s = (digamma(np.arange(2 * longest) + 0.5) - digamma(0.5)) / np.pi
    edge = (avar_from_semivariogram(s, longest) - FLAT) * longest**2
    for i, size in enumerate(flat):
        out[i] = avar_from_semivariogram(s, int(size)) if size <= 1024 else FLAT + edge / size**2
    return out.reshape(np.shape(m))
