"""Vibration that several channels feel: a line, a comb of lines, a line that wanders, a band."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from scipy.fft import irfft, next_fast_len
from scipy.special import ndtr

from imu_lib.arrays import Array
from imu_lib.errors import InputError
from imu_lib.timing import folded

from .base import FREE, Parameter, Process
from .gauss_markov import GaussMarkov

#: Bandwidth as a share of the frequency up to which a vibration is a line of steady amplitude
#: whose phase diffuses; beyond it is a band of normal noise.
LINE = 0.1
#: Steady lines from which on they are put together in one transform, and its length over that of
#: the record: each line then stands within a sixteenth of 1 / duration of its place.
MANY, FINER, LONGEST = 40, 8, 2**25
#: How long a line stays about one frequency of its `profile`, in 1 / bandwidth.
STAYS = 2.0


@dataclass(frozen=True)
class Vibration(Process):
    """One vibration, felt by `channels` each with its own amplitude and phase.

    A line of steady `amplitude` at `frequency` and at its whole multiples up to `harmonics` times
    it. With a `bandwidth` (full width at half of the power) the phase diffuses, which makes the
    line a Lorentzian one of that width (Lax 1967, Eq. 5.30) and h^2 times it at the h-th multiple;
    wider than a tenth of the frequency it is a band of normal noise, flat in the middle. Lines
    above half the sampling rate are folded.

    With a `profile`, measured, it is neither: of a line the frequency wanders, slowly, and each
    frequency has its share of the time (the spectrum of a slow frequency modulation is the
    distribution of the frequency, Woodward's theorem); a band is normal noise of that density.

    Parameters
    ----------
    frequency : float, Hz
    amplitude : sequence of float, one a channel, unit of the channel
        Of the sinusoid; of a band the square root of twice its variance.
    bandwidth : float, Hz
    harmonics : int
        Number of lines.
    channels : sequence of str
    start, stop : float, s from the first sample, optional; `from` and `to` in a file
        When it is there; from the first and to the last sample where not given.
    ratios : sequence of float, one a line, optional
        Amplitudes of the lines over that of the strongest; the same for all channels. Where not
        given, 1 / h.
    lines : sequence of float, Hz, optional
        Frequencies of the lines where they are no multiples of `frequency`.
    wander : float, optional
        Standard deviation of the logarithm of the amplitude, a Gauss-Markov process; steady where
        not given. `amplitude` is that of the same mean power.
    wander_time : float, s, optional
        Its correlation time.
    profile_frequency, profile : sequences of float, optional
        Frequencies in Hz and the density there over the largest, of a vibration of one line;
        straight lines between, nothing outside.
    """

    frequency: float = FREE
    amplitude: tuple[float, ...] = ()
    bandwidth: float = 0.0
    harmonics: int = 1
    channels: tuple[str, ...] = ()
    start: float | None = None
    stop: float | None = None
    ratios: tuple[float, ...] | None = None
    lines: tuple[float, ...] | None = None
    wander: float | None = None
    wander_time: float | None = None
    profile_frequency: tuple[float, ...] | None = None
    profile: tuple[float, ...] | None = None
    name: ClassVar[str] = "vibration"
    keys: ClassVar[dict[str, str]] = {"from": "start", "to": "stop"}
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("frequency", "frequency", "of the first line, Hz"),
        Parameter("bandwidth", "amplitude", "full width at half of the power, Hz"),
        Parameter("harmonics", "count", "number of lines"),
        Parameter("start", "other", "from, s", optional=True),
        Parameter("stop", "other", "to, s", optional=True),
        Parameter("wander", "other", "sd of the logarithm of its amplitude", optional=True),
        Parameter("wander_time", "time", "over which the amplitude wanders, s", optional=True),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if isinstance(self.channels, str) or not all(isinstance(c, str) for c in self.channels):
            raise InputError("process vibration: `channels` must be a list of channel names")
        object.__setattr__(self, "channels", tuple(self.channels))
        amplitude = np.atleast_1d(np.asarray(self.amplitude, dtype=object)).tolist()
        if len(amplitude) == 1 and len(self.channels) > 1:
            amplitude = amplitude * len(self.channels)
        object.__setattr__(self, "amplitude", _numbers("amplitude", amplitude, len(self.channels)))
        if (self.wander is None) != (self.wander_time is None):
            raise InputError(
                "process vibration: `wander` needs its `wander_time` in s, and the other way round"
            )
        if self.harmonics is not None and self.harmonics < 1:
            raise InputError("process vibration: `harmonics` counts the lines, 1 or more")
        for each in ("ratios", "lines"):
            values = getattr(self, each)
            if values is not None:
                object.__setattr__(self, each, _numbers(each, values, self.harmonics))
        self._check_profile()

    def _check_profile(self) -> None:
        if self.profile is None and self.profile_frequency is None:
            return
        if self.profile is None or self.profile_frequency is None or self.harmonics != 1:
            raise InputError(
                "process vibration: `profile` is the density of one line at `profile_frequency`"
            )
        f = _numbers("profile_frequency", self.profile_frequency, len(self.profile))
        density = _numbers("profile", self.profile, len(self.profile))
        if len(f) < 2 or np.min(np.diff(f)) <= 0 or max(density) <= 0:
            raise InputError(
                "process vibration: `profile_frequency` must rise, and `profile` be above zero"
            )
        object.__setattr__(self, "profile_frequency", f)
        object.__setattr__(self, "profile", density)

    def to_json(self) -> dict[str, Any]:
        entry = {**super().to_json(), "amplitude": list(self.amplitude)}
        entry["channels"] = list(self.channels)
        for each in ("ratios", "lines", "profile_frequency", "profile"):
            if getattr(self, each) is not None:
                entry[each] = list(getattr(self, each))
        for key, field in self.keys.items():
            if field in entry:
                entry[key] = entry.pop(field)
        return entry

    @property
    def complete(self) -> bool:
        return self.frequency is not None and bool(self.channels)

    @property
    def shape(self) -> Array:
        """Amplitudes of the lines over that of the strongest, shape (harmonics,)."""
        if self.ratios is None:
            return 1.0 / np.arange(1, self.harmonics + 1)
        return np.array(self.ratios)

    @property
    def frequencies(self) -> Array:
        """Frequencies of the lines, Hz, shape (harmonics,)."""
        if self.lines is not None:
            return np.array(self.lines)
        return self.frequency * np.arange(1, self.harmonics + 1)

    @property
    def band(self) -> bool:
        """Whether it is a band of noise rather than a line."""
        return self.bandwidth > LINE * self.frequency

    def active(self, n: int, fs: float) -> Array:
        """When it is there: bool, shape (n,)."""
        t = np.arange(n) / fs
        out = np.ones(n, dtype=bool)
        if self.start is not None:
            out &= t >= self.start - 1e-9
        if self.stop is not None:
            out &= t <= self.stop + 1e-9
        return out

    def of(self, channel: str) -> Vibration | None:
        """The same vibration on one of its channels alone, or None where that does not feel it."""
        if channel not in self.channels:
            return None
        own = self.amplitude[self.channels.index(channel)]
        return self.with_(channels=(channel,), amplitude=(own,))

    def analytic(self, n: int, fs: float, rng: np.random.Generator) -> list[Array]:
        """One draw of each line as a complex signal of amplitude 1, shape (n,) each."""
        self._require()
        if self.band:
            return [self._noise(n, fs, f, rng) for f in self.frequencies]
        turns = np.arange(n) / fs
        if self.profile is not None:
            return [np.exp(2j * np.pi * (np.cumsum(self._wandering(n, fs, rng)) / fs))]
        if self.bandwidth > 0:  # time runs unevenly, so that all lines wander together
            step = np.sqrt(self.bandwidth / (2 * np.pi * fs)) / self.frequency
            turns = turns + np.cumsum(rng.standard_normal(n)) * step
        return [np.exp(2j * np.pi * (f * turns + rng.random())) for f in self.frequencies]

    def _noise(self, n: int, fs: float, at: float, rng: np.random.Generator) -> Array:
        """Analytic normal noise of the band around `at` Hz, mean square 1."""
        f = np.fft.fftfreq(n, 1 / fs)
        if self.profile is None or self.profile_frequency is None:
            u = (np.abs(f) - at) / (0.5 * self.bandwidth * at / self.frequency)
            gain = np.where(f > 0, 1.0 / np.sqrt(1.0 + u**8), 0.0)
        else:
            density = np.interp(f, self.profile_frequency, self.profile, left=0.0, right=0.0)
            gain = np.where(f > 0, np.sqrt(density), 0.0)
        gain *= np.sqrt(n / np.sum(gain**2)) if gain.any() else 0.0
        z = (rng.standard_normal(n) + 1j * rng.standard_normal(n)) * np.sqrt(0.5)
        return np.fft.ifft(z * gain) * np.sqrt(n)

    def _wandering(self, n: int, fs: float, rng: np.random.Generator) -> Array:
        """A draw of the frequency of a line, Hz, shape (n,), that has its `profile`."""
        assert self.profile_frequency is not None and self.profile is not None
        fine = np.linspace(self.profile_frequency[0], self.profile_frequency[-1], 1024)
        density = np.interp(fine, self.profile_frequency, self.profile)
        share = np.cumsum(density)
        level = GaussMarkov(sigma=1.0, correlation_time=STAYS / self.bandwidth)
        return np.interp(ndtr(level.simulate(n, fs, rng)), share / share[-1], fine)

    @property
    def forest(self) -> bool:
        """Whether it is so many steady lines that they are drawn in one transform."""
        return self.harmonics > MANY and self.bandwidth == 0

    def _lines_at_once(self, n: int, fs: float, rng: np.random.Generator) -> dict[str, Array]:
        """As `on`, of a forest of steady lines."""
        self._require()
        finer = int(np.clip(LONGEST // n, 1, FINER))
        size = next_fast_len(finer * n, real=True)
        loud, active = self.loudness(n, fs, rng), self.active(n, fs)
        # lines above half the rate are folded
        seen = folded(self.frequencies, fs)
        at = np.minimum(np.rint(seen / fs * size).astype(int), size // 2)
        out = {}
        for channel, amplitude in zip(self.channels, self.amplitude):
            z = np.zeros(size // 2 + 1, complex)
            np.add.at(z, at, self.shape * np.exp(2j * np.pi * rng.random(len(at))))
            x = irfft(z, size)[:n] * (size / 2)
            out[channel] = amplitude * np.where(active, loud * x, 0.0)
        return out

    def on(self, n: int, fs: float, rng: np.random.Generator) -> dict[str, Array]:
        """What each of its channels gets of one draw: name -> ndarray, shape (n,)."""
        if self.forest:
            return self._lines_at_once(n, fs, rng)
        lines, active, shape = self.analytic(n, fs, rng), self.active(n, fs), self.shape
        loud = self.loudness(n, fs, rng)
        out = {}
        for channel, amplitude in zip(self.channels, self.amplitude):
            turn = np.exp(2j * np.pi * rng.random(len(lines)))
            x = sum(r * (z * e).real for r, z, e in zip(shape, lines, turn))
            out[channel] = amplitude * np.where(active, loud * x, 0.0)
        return out

    def loudness(self, n: int, fs: float, rng: np.random.Generator) -> Array | float:
        """One draw of the amplitude over its root mean square, shape (n,); 1 where it is steady."""
        if self.wander is None or self.wander_time is None:
            return 1.0
        level = GaussMarkov(sigma=self.wander, correlation_time=self.wander_time)
        return np.exp(level.simulate(n, fs, rng) - self.wander**2)


def _numbers(name: str, values: Any, count: int) -> tuple[float, ...]:
    try:
        out = tuple(float(v) for v in values)
    except (TypeError, ValueError):
        raise InputError(f"process vibration: `{name}` must be a list of numbers") from None
    if len(out) != count or not np.all(np.isfinite(out)) or min(out, default=0.0) < 0:
        raise InputError(
            f"process vibration: `{name}` must be {count} numbers, none below zero, not {out}"
        )
    return out
