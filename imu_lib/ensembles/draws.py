"""Realisations that models share, so that two of them differ by the model and not by luck."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from imu_lib.arrays import Array
from imu_lib.processes import HeavyTails, LowPass, Process, Sum, WhiteNoise, folded

#: Memory of a process, s, from which on it is drawn before a filter.
PASSES = 10.0


class Draws:
    """The realisations of one simulation: each process is drawn once at amplitude 1 and serves
    every model that has it.

    The second process of a kind in a model has a draw of its own; a process of that kind with
    another time constant is made of the same normal numbers.
    """

    def __init__(
        self, seed: Sequence[int] | int, n: int, fs: float, temperature: Array | None = None
    ) -> None:
        self.seed, self.n, self.fs, self.temperature = list(np.atleast_1d(seed)), n, fs, temperature
        self.t = np.arange(n) / fs
        self._made: dict[tuple[Process, int, LowPass | None, str | None], Array] = {}

    def rng(self, name: str, count: int = 0) -> np.random.Generator:
        """The generator of what is called `name`, the same at every call."""
        return np.random.default_rng([*self.seed, count, *name.encode()])

    def terms(
        self,
        terms: Iterable[Process],
        low_pass: LowPass | None = None,
        tails: HeavyTails | None = None,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Sums of the slow and of the quick processes behind the filter, shapes (n,)."""
        slow, quick = np.zeros(self.n), np.zeros(self.n)
        seen: dict[str, int] = {}
        for term in terms:
            count = seen[term.name] = seen.get(term.name, -1) + 1
            if getattr(term, "rounded", None):  # the sum rounds its integral
                continue
            if term.deterministic:
                slow += term.mean(self.t, self.temperature)
                continue
            amplitude = next(p.name for p in term.parameters if p.kind == "amplitude")
            unit = term.with_(**{amplitude: 1.0})
            part = quick if term.fast else slow
            if tails is not None and isinstance(term, WhiteNoise) and not term.behind_filter:
                bare, sd = self.unit(unit, count, None), float(np.sqrt(self.fs))
                one = tails.given(bare, sd, self.rng("tails"))
                one = one if low_pass is None else _behind(one, low_pass, self.fs)
            else:
                one = self.unit(unit, count, low_pass)
            part += getattr(term, amplitude) * one
        return slow, quick

    def unit(
        self, process: Process, count: int, low_pass: LowPass | None, name: str | None = None
    ) -> np.ndarray:
        """A process of amplitude 1, the one that is drawn as number `count` of its `name`, behind
        the filter, shape (n,).
        """
        key = (process, count, low_pass, name)
        if key not in self._made:
            rng = self.rng(name or process.name, count)
            if low_pass is None:
                out = process.simulate(self.n, self.fs, rng)
            elif process.memory > PASSES or not process.gaussian:
                out = through(self.unit(process, count, None), low_pass, self.fs)
            else:
                out = behind(process, low_pass, self.n, self.fs, rng)
            self._made[key] = out
        return self._made[key]


def through(x: Array, low_pass: LowPass, fs: float) -> np.ndarray:
    """Noise whose power lies far below the rate at which the filter runs, behind the filter but
    for its delay, shape (n,).
    """
    n = len(x)
    line = np.linspace(x[0], x[-1], n)  # the ends meet without a jump
    size = next_fast_len(n, real=True)
    z = rfft(x - line, size)
    return irfft(z * np.sqrt(low_pass.gain(np.arange(len(z)) * fs / size, fs)), size)[:n] + line


def _behind(x: Array, low_pass: LowPass, fs: float) -> np.ndarray:
    """White samples behind the filter, the last of them before the first, shape (n,)."""
    reach = len(folded.response(low_pass, fs)) // 2
    return folded.behind(np.pad(x, reach, mode="wrap"), low_pass, fs)


def _even(n: int) -> int:
    """Samples, `n` or more and even, that transform fast."""
    size = next_fast_len(n, real=True)
    return size + size % 2


def _ordinates(size: int, fs: float) -> np.ndarray:
    """Hz, the first in the place of zero, where red spectra have no value."""
    return np.maximum(np.arange(size // 2 + 1), 1) * fs / size


@lru_cache(maxsize=32)
def _amplitudes(unit: Process, low_pass: LowPass, size: int, fs: float) -> np.ndarray:
    """Root of the folded spectrum of a process behind a filter at the ordinates of `size` samples,
    times the root of size / 4 fs.
    """
    return np.sqrt(Sum((unit,), (low_pass,)).psd(_ordinates(size, fs), fs) * fs * size / 4)


def behind(
    unit: Process, low_pass: LowPass, n: int, fs: float, rng: np.random.Generator
) -> np.ndarray:
    """A stationary process of short memory behind a filter that runs at its own rate, from the
    folded spectrum, shape (n,).
    """
    size = _even(n + 4096)
    z = rng.standard_normal(size + 2).view(complex) * _amplitudes(unit, low_pass, size, fs)
    z[0] = z[0].real * np.sqrt(2.0)
    z[-1] = z[-1].real * np.sqrt(2.0)
    return irfft(z, size)[:n]
