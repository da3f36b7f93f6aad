"""Spectral lines."""

from __future__ import annotations

import numpy as np
from scipy.fft import rfft
from scipy.ndimage import median_filter

from imu_lib.arrays import Array
from imu_lib.gap.data import Data
from imu_lib.gap.state import MIN_EVIDENCE
from imu_lib.likelihood import tapered
from imu_lib.likelihood.evidence import AMPLITUDE_WIDTH
from imu_lib.processes import Sinusoid as Process
from imu_lib.processes import Sum
from imu_lib.vibrations.mains import hint

from .base import Finding, SignalEffect

#: First ordinate that is searched: slower oscillations are drifts.
FIRST = 32
#: Gain in log-likelihood below which a line is not told however short the record.
LEAST_GAIN = 20.0


def occam(gain: float, n: int) -> float:
    """Log evidence that the freedom of a line costs: its amplitude log-uniform over the width of
    all amplitudes, its phase and its frequency anything, against what is left of each where the
    line has that gain (Cramer and Rao: 1 / snr of the amplitude and of the phase, sqrt(3) / (pi T
    snr) Hz of the frequency, snr^2 twice the gain).
    """
    volume = np.sqrt(2 * np.pi) ** 3 * np.sqrt(3.0) / np.pi * (2.0 * gain) ** -1.5
    return float(np.log(volume / (AMPLITUDE_WIDTH * 2 * np.pi * n / 2)))


def threshold(n: int) -> float:
    """Gain from which on a line is told: its evidence is what any other effect has to add. Noise
    alone reaches it in one of six thousand channels of an hour at 100 Hz (Rice 1944), a third
    oftener where the density around a line is known from its 800 nearest ordinates.
    """
    gain = LEAST_GAIN
    for _ in range(10):  # a change of the gain by one moves the right side by 1.5 / gain
        gain = MIN_EVIDENCE - occam(gain, n)
    return max(gain, LEAST_GAIN)


#: Ordinates of the running median from each ordinate on, the more the higher the frequency, and
#: those to either side of a line over which means are taken.
WIDTHS = {0: 15, 64: 41, 512: 151, 4096: 601}
NEAR, FAR = 30, 400
#: Exponents of the power laws that the spectrum around a line may follow: blue, white, red.
SLOPES = np.linspace(-2.0, 4.0, 31)


def _width(i: int) -> int:
    """Ordinates of the running median at ordinate `i`."""
    return WIDTHS[max(first for first in WIDTHS if first <= i)]


def local_level(power: Array) -> np.ndarray:
    """A level around every ordinate that lines do not lift: running medians, wider the higher the
    frequency.
    """
    n = len(power)
    out = np.empty(n)
    for a, b in zip(WIDTHS, [*list(WIDTHS)[1:], n]):
        if a >= n:
            break
        b, width = min(b, n), WIDTHS[a]
        lo, hi = max(0, a - width), min(n, b + width)
        out[a:b] = median_filter(power[lo:hi], width, mode="reflect")[a - lo : b - lo] / np.log(2)
    return out


class Sinusoid(SignalEffect):
    name = "sinusoid"
    order = 60
    cause = "Vibration, mains hum, a clock or a switching supply that couples in."
    domain = "lines"

    def strongest(self, data: Data, level: Array) -> tuple[float, float]:
        """Frequencies (Hz) and power over level of the strongest lines, on a grid twice as fine as
        the ordinates.
        """
        n, size = data.n, 2 * tapered.padded(data.n)
        z = rfft(tapered.taper(n) * (data.x - tapered.bridge(data.x)), size)
        ratio = np.abs(z) ** 2 * (2.0 / n / data.fs) / np.repeat(level, 2)[: len(z)]
        ratio[: 2 * FIRST] = 0.0
        ratio[-16:] = 0.0
        i = int(np.argmax(ratio))
        return i * data.fs / size, float(ratio[i])

    def refine(self, data: Data, f: float) -> tuple[Process, Array]:
        """Least-squares sinusoid near `f` Hz: amplitude, frequency, phase and the fitted signal."""
        fs, n = data.fs, data.n
        x = data.x - tapered.bridge(data.x)
        w = tapered.taper(n)
        t = np.arange(n)
        size = tapered.padded(n)
        width = 0.4 * fs / size
        # demodulate into ~256 pieces around the trial frequency, then work on those
        pieces = min(n, 512)
        m = n // pieces
        base = (
            (x * w * np.exp(-2j * np.pi * f / fs * t))[: pieces * m].reshape(pieces, m).sum(axis=1)
        )
        middle = (np.arange(pieces) + 0.5) * m / fs
        offsets = np.linspace(-width, width, 61)
        for _ in range(3):
            power = np.abs(np.exp(-2j * np.pi * np.outer(offsets, middle)) @ base) ** 2
            j = int(np.argmax(power))
            step = offsets[1] - offsets[0]
            offsets = np.linspace(offsets[j] - step, offsets[j] + step, 61)
        f = f + offsets[30]
        e = 2 * np.pi * f / fs * t
        a = np.column_stack([np.sin(e), np.cos(e)]) * w[:, None]
        coef, *_ = np.linalg.lstsq(a.T @ a, a.T @ (x * w), rcond=None)
        amplitude = float(np.hypot(*coef))
        phase = float(np.arctan2(coef[1], coef[0]))
        return Process(amplitude=amplitude, frequency=float(f), phase=phase), amplitude * np.sin(
            e + phase
        )

    def doubt(self, data: Data, process: Process, level: Array) -> str | None:
        """Why the line is not one steady sinusoid, or None: power left beside it, or an amplitude
        that changes.
        """
        size = tapered.padded(data.n)
        i = int(round(process.frequency * size / data.fs))
        z2 = np.abs(data.z) ** 2 / data.fs
        reach = 40
        lo, hi = max(1, i - reach), min(len(z2), i + reach + 1)
        ratio = z2[lo:hi] / level[lo:hi]
        near = np.abs(np.arange(lo, hi) - i) <= 6
        if ratio.max() > 16 or ratio[near].sum() > near.sum() + 6 * np.sqrt(near.sum()):
            return (
                f"power spectral density beside {process.frequency:.5g} Hz: what is left is no "
                "steady sinusoid"
            )
        return None

    def foreseen(self, finding: Finding, given: Sum | None, data: Data) -> bool:
        # a phase that is given is a drift of the model, and has been taken out
        terms = () if given is None else given.terms
        known = [t.frequency for t in terms if isinstance(t, Process) and t.phase is None]
        return any(abs(f - finding.process.frequency) < 2 / data.duration for f in known)

    def find(
        self, data: Data, *, most: int = 6, least: float | None = None
    ) -> tuple[list[tuple[Finding, Array]], Data]:
        """All lines of a gain of `least` (the `threshold` of the record where not given), strongest
        first: list of (Finding, signal) and the data without them.
        """
        found: list[tuple[Finding, Array]] = []
        least = threshold(data.n) if least is None else least
        level = local_level(np.abs(data.z) ** 2 / data.fs)
        for _ in range(most):
            f, ratio = self.strongest(data, level)
            if ratio < 0.6 * least:
                break
            process, signal = self.refine(data, f)
            size = tapered.padded(data.n)
            i = min(int(round(f * size / data.fs)), len(level) - 1)
            clean = data.minus(signal)
            density = _density(data, i, level[i])
            gain = process.amplitude**2 * data.n / (2 * data.fs * density)
            if gain < least:
                break
            decibel = 10 * np.log10(ratio)
            sd_a = np.sqrt(density * data.fs / data.n)
            snr = process.amplitude / sd_a
            sd_f = np.sqrt(3) / (np.pi * data.duration * snr)
            item = Finding(
                self,
                process,
                float(gain),
                f"power spectral density at {process.frequency:.6g} Hz, {decibel:.0f} dB above "
                f"the simulated level{_perhaps_mains(process.frequency, data.fs)}",
                {
                    "amplitude": [process.amplitude - 1.96 * sd_a, process.amplitude + 1.96 * sd_a],
                    "frequency": [process.frequency - 1.96 * sd_f, process.frequency + 1.96 * sd_f],
                    "phase": [process.phase - 3.92 / snr, process.phase + 3.92 / snr],
                },
            )
            item.places = np.exp(-occam(gain, data.n))
            item.doubt = self.doubt(clean, process, level)
            near = any(
                abs(other.process.frequency - process.frequency) < 20 * data.fs / size
                for other, _ in found
            )
            if near:
                for other, _ in found:
                    if abs(other.process.frequency - process.frequency) < 20 * data.fs / size:
                        other.doubt = (
                            other.doubt
                            or f"power spectral density around {process.frequency:.5g} Hz: "
                            "several lines beside one another"
                        )
                data = clean
                continue
            found.append((item, signal))
            data = clean
        _harmonics(found)
        return found, data


def _density(data: Data, i: int, level: float) -> float:
    """Density of the noise at a line: the mean over a third of its frequency, and where the
    spectrum has a peak or an edge what the near ordinates and the running median have more, beyond
    a standard deviation of their own.
    """
    wide = _around(data, i, level, max(NEAR, min(FAR, i // 3)))
    near = _around(data, i, level, NEAR) * (1.0 - 1.0 / np.sqrt(2 * NEAR))
    return max(wide, near, level * (1.0 - 1.0 / (np.log(2) * np.sqrt(_width(i)))))


def _around(data: Data, i: int, level: float, reach: int) -> float:
    """Density at a line of the power law that is likeliest for the ordinates around it, half to
    twice its frequency at the most: beside a walk their mean is that of the slowest. The line's own
    are left out, other lines cut down to 12 times the level.
    """
    low, high = max(i - reach, i // 2), min(i + reach + 1, 2 * i, len(data.z))
    at = np.concatenate([np.arange(max(1, low), i - 2), np.arange(i + 3, high)])
    octaves = np.log(at / i)
    flat = np.exp(SLOPES[:, None] * octaves)
    power = np.minimum(flat * np.abs(data.z[at]) ** 2 / data.fs, 12.0 * level)
    density = power.mean(axis=1)
    loglike = -np.log(density) + SLOPES * octaves.mean()
    return float(density[int(np.argmax(loglike))])


def _perhaps_mains(frequency: float, fs: float) -> str:
    """Words for a line where the sampling folds the mains to."""
    told = hint(frequency, fs)
    return f" ({told})" if told else ""


def _harmonics(found: list[tuple[Finding, Array]]) -> None:
    """Lines at whole multiples of one frequency are one periodic signal that is not a sinusoid; so
    are three of whole hertz.
    """
    beats = [
        item
        for item, _ in found
        if item.process.frequency > 0.5
        and abs(item.process.frequency - round(item.process.frequency)) < 3e-3
    ]
    for item in beats if len(beats) >= 3 else ():
        item.doubt = (
            item.doubt
            or f"power spectral density at {item.process.frequency:.4g} Hz and other whole hertz: "
            "something that happens once a second"
        )
    for item, _ in found:
        for other, _ in found:
            if other is item:
                continue
            ratio = other.process.frequency / item.process.frequency
            whole = round(ratio)
            if 2 <= whole <= 12 and abs(ratio - whole) * item.process.frequency < 3e-3:
                text = (
                    f"power spectral density at {item.process.frequency:.5g} Hz and {whole} "
                    "times that: a periodic signal that is no sinusoid"
                )
                item.doubt = item.doubt or text
                other.doubt = other.doubt or text


EFFECTS = (Sinusoid(),)
