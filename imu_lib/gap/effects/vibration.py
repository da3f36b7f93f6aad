"""Vibration: lines, combs of lines, lines that wander and bands of noise, found over all channels
at once.
"""

from __future__ import annotations

import numpy as np

from imu_lib.gap import narrow_band, shared_band
from imu_lib.gap.behaviour import SWEEPS
from imu_lib.gap.families import grouped, weak_lines
from imu_lib.gap.imputation import first_fill
from imu_lib.gap.innovations import trend
from imu_lib.gap.quieten import quietened
from imu_lib.gap.sources import Source, Transforms, sources
from imu_lib.processes import Sinusoid as Line
from imu_lib.processes import Vibration as Process

from .base import Effect, Finding

#: Seconds that a vibration lasts at the least: shorter is a knock.
SHORTEST = 5.0
#: Fading below which a channel of its own shows a line that wanders; above it may be a resonance
#: that noise drives.
STEADY = 0.5
#: Share of missing samples beyond which what fills them would be taken for a vibration, and samples
#: that are too few to look.
MISSING, LEAST = 0.3, 1000
#: Gain of all channels together, once the surroundings are measured on both sides.
LEAST_GAIN = 25.0
#: Stretches of time and widths in which each frequency is looked at, that are not nearly the same:
#: 32 stretches at the most and six widths, each overlapping the next.
WINDOWS = 100.0
#: Blocks of the record whose means are the slow part that is taken out first.
SLOW = 128
#: Deviations at which samples are clipped before the search, in robust standard deviations.
CLIP = 12.0


class Vibration(Effect):
    name = "vibration"
    cause = "Something shakes the sensor or couples into its electronics: a fan, a motor, a building, a switching supply."
    domain = "lines"
    level = "record"
    order = 30

    def candidates(self, view) -> list[Finding]:
        """Everything that shakes: one finding a cause, with the signal that it puts into each of
        its channels.
        """
        fs, given = view.fs, view.model
        lost = np.mean([np.isnan(x).mean() for x in view.raw.values()])
        if lost > MISSING or len(next(iter(view.raw.values()))) < LEAST:
            return []
        filled = {name: first_fill(x, np.isnan(x)) for name, x in view.raw.items()}
        block = max(int(2 * fs), len(next(iter(filled.values()))) // SLOW)
        quick = {name: fast_part(x, block) for name, x in filled.items()}
        quick = {name: x for name, x in quick.items() if x is not None}
        if not quick:
            return []
        transforms = Transforms(quick, fs)
        least = 3.0 * fs / block
        places = {name: narrow_band.places(x, fs, least=least) for name, x in quick.items()}
        found = [s for s in sources(places, transforms) if self._is_one(s, given, transforms)]
        # where the largest gain is looked for: frequencies, channels, stretches and widths
        looked_at = transforms.n * len(transforms.names) * WINDOWS
        swept = {c for s in found if s.strange == SWEEPS for c in s.channels}
        families = [
            (f0, family)
            for f0, family in grouped(found, transforms)
            if self._is_vibration(family, swept)
        ]
        out = [f for f0, family in families for f in self._findings(f0, family, transforms)]
        bands = shared_band.bands(quick, fs, [p.process for p in out])
        out += [self._of_band(band, transforms) for band in bands]
        rng = np.random.default_rng(len(next(iter(quick.values()))))
        for item in out:
            item.places, item.signal = looked_at, {}
            for name in item.process.channels:
                calm = quietened(
                    filled[name],
                    fs,
                    item.bands,
                    rng,
                    start=item.process.start or 0.0,
                    stop=item.process.stop,
                )
                item.signal[name] = filled[name] - calm
                filled[name] = calm
            item.held = any(_alike(item.process, p) for p in _held(given))
        return out

    @staticmethod
    def _is_one(s: Source, given, transforms) -> bool:
        if s.gain < LEAST_GAIN or s.bandwidth > 0.1 * s.frequency and s.strength < 0.5:
            return False
        if not s.whole and s.stop - s.start < SHORTEST:
            return False
        if given is None:
            return True
        foreseen = {
            c
            for c in s.channels
            if c in given
            for t in given[c].terms
            if isinstance(t, Line) and abs(t.frequency - s.frequency) < 2 / transforms.duration
        }
        return not set(s.channels) <= foreseen

    @staticmethod
    def _is_vibration(family, swept) -> bool:
        """Whether a family of sources is a vibration: on several channels, for a time, or a line
        that wanders. A steady line of one channel is a sinusoid, a band of normal noise a
        resonance, and a periodic signal of one channel, a tone that sweeps or one that rises and
        falls has no name. On channels over which a tone has `swept`, pieces of its way are none.
        """
        if len({c for s in family for c in s.channels}) > 1:
            return True
        s = family[0]
        if len(family) > 1 or s.strange or not s.whole and swept & set(s.channels):
            return False
        return not s.whole or 0 < s.bandwidth < 0.1 * s.frequency and s.fading < STEADY

    @classmethod
    def _findings(cls, f0: float, family, transforms) -> list[Finding]:
        """One finding an episode."""
        first = cls._finding(f0, family, transforms)
        spans = max(family, key=lambda s: s.gain).spans
        if len(spans) < 2:
            return [first]
        total, out = sum(stop - start for start, stop in spans), []
        strength = max(family, key=lambda s: s.gain).strength
        for start, stop in spans:
            if stop - start < SHORTEST:
                continue
            process = first.process.with_(start=start, stop=stop)
            one = Finding(
                VIBRATION,
                process,
                first.gain * (stop - start) / total,
                where(process, strength, transforms.duration),
                first.intervals,
            )
            one.bands = first.bands
            out.append(one)
        return out

    @staticmethod
    def _finding(f0: float, family, transforms) -> Finding:
        weak = weak_lines(f0, family, transforms) if f0 else {}
        best = max(family, key=lambda s: s.gain)
        amplitudes = {}
        for s in family:
            key = int(round(s.frequency / f0)) if f0 else s.frequency
            amplitudes[key] = s.amplitude
        amplitudes.update(weak)
        keys = sorted(amplitudes)
        names = [n for n in transforms.names if any(n in s.amplitude for s in family)]
        matrix = np.array([[amplitudes[k].get(n, 0.0) for k in keys] for n in names])
        strength, ratios = _factors(matrix)
        more, start, stop = {}, best.start, best.stop
        if len(keys) > 1 or f0 and keys != [1]:
            count = max(keys) if f0 else len(keys)
            table = np.zeros(count)
            for i, k in enumerate(keys):
                table[k - 1 if f0 else i] = ratios[i]
            more = {"harmonics": int(count), "ratios": tuple(float(v) for v in table)}
            if not f0:
                more["lines"] = tuple(float(k) for k in keys)
        process = Process(
            frequency=float(f0 or best.frequency),
            amplitude=tuple(float(v) for v in strength),
            bandwidth=float(
                best.bandwidth / max(round(best.frequency / f0), 1) if f0 else best.bandwidth
            ),
            channels=tuple(names),
            start=start,
            stop=stop,
            **more,
        )
        order = max(round(best.frequency / f0), 1) if f0 else 1
        spread = 1.96 * max(best.frequency_sd / order, 1e-9)
        intervals = {"frequency": [process.frequency - spread, process.frequency + spread]}
        intervals["amplitude"] = [
            [max(0.0, a - 1.96 * _sd(family, n)), a + 1.96 * _sd(family, n)]
            for n, a in zip(names, process.amplitude)
        ]
        finding = Finding(
            VIBRATION,
            process,
            float(sum(s.gain for s in family)),
            where(process, best.strength, transforms.duration),
            intervals,
        )
        half = max(1.0 / transforms.duration, 0.5 * process.bandwidth)
        finding.bands = _merged(
            [(s.place.low, s.place.high) for s in family]
            + [(k * f0 - k * half, k * f0 + k * half) for k in weak]
        )
        return finding

    @staticmethod
    def _of_band(band, transforms) -> Finding:
        process = Process(
            frequency=0.5 * (band.low + band.high),
            amplitude=tuple(band.amplitude.values()),
            bandwidth=band.high - band.low,
            channels=tuple(band.amplitude),
        )
        finding = Finding(
            VIBRATION,
            process,
            band.gain,
            f"coherence between {_names(process.channels)} from {band.low:.3g} to {band.high:.3g} Hz: {band.coherence:.2g} there and none elsewhere",
            {"frequency": [band.low, band.high]},
        )
        finding.bands = [band.reach]
        return finding


VIBRATION = Vibration()
EFFECTS = (VIBRATION,)


def fast_part(x, block: int) -> np.ndarray | None:
    """A channel without what is slower than `block` samples, outliers cut down, shape (n,); None
    where most of it is one value.
    """
    x = x - trend(x, block)
    sd = 1.4826 * np.median(np.abs(x))
    return np.clip(x, -CLIP * sd, CLIP * sd) if sd > 0 and np.ptp(x) > 0 else None


def where(process: Process, strength: float, duration: float) -> str:
    """Where it shows, in a sentence."""
    lines = process.frequencies
    decibel = f", {10 * np.log10(1 + strength):.0f} dB above the noise"
    if process.harmonics == 1:
        what = f"power spectral density at {process.frequency:.5g} Hz{decibel}"
    elif process.lines is not None:
        what = f"power spectral density: {process.harmonics} lines between {lines.min():.4g} and {lines.max():.4g} Hz{decibel}"
    else:
        count = np.count_nonzero(process.shape)
        what = f"power spectral density at {count} multiples of {process.frequency:.5g} Hz{decibel}"
    if process.bandwidth > 0 and process.harmonics == 1:
        what += f", {process.bandwidth:.2g} Hz wide"
    what += f", on {_names(process.channels)}"
    if process.start is not None:
        what += f", from {process.start:.0f} to {process.stop:.0f} s"
    else:
        what += f", all the time from 0 to {duration:.0f} s"
    return what


def _names(channels) -> str:
    return ", ".join(channels)


def _factors(matrix):
    """Amplitudes of the channels and of the lines over the strongest whose product is nearest to
    `matrix`, shapes (channels,), (lines,).
    """
    u, s, v = np.linalg.svd(matrix)
    ratios = np.abs(v[0])
    top = ratios.max()
    return np.abs(u[:, 0]) * s[0] * top, ratios / top


def _sd(family, name) -> float:
    """Standard deviation of a channel's amplitude, from its best line."""
    return min((s.sd[name] for s in family if name in s.sd), default=0.0)


def _merged(bands):
    """Bands in order, those that meet joined."""
    out = []
    for low, high in sorted(bands):
        if out and low <= out[-1][1]:
            out[-1] = (out[-1][0], max(high, out[-1][1]))
        else:
            out.append((low, high))
    return out


def _held(given):
    return [] if given is None else [p for p in given.record if isinstance(p, Process)]


def _alike(found: Process, held: Process) -> bool:
    """Whether a vibration of the given model is the one that was found."""
    slack = max(held.bandwidth, found.bandwidth, 0.002 * held.frequency)
    if abs(found.frequency - held.frequency) > slack or not set(found.channels) <= set(
        held.channels
    ):
        return False
    own = dict(zip(held.channels, held.amplitude))
    return all(0.6 * own[c] < a < 1.6 * own[c] for c, a in zip(found.channels, found.amplitude))
