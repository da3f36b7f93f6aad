"""Vibration: lines, combs of lines, lines that wander and bands of noise, found over all channels
at once.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from imu_lib.arrays import Array
from imu_lib.model import Model
from imu_lib.processes import Sinusoid as Line
from imu_lib.processes import Vibration as Process
from imu_lib.samples.imputation import first_fill
from imu_lib.samples.innovations import trend
from imu_lib.vibrations import coherent_band, excess, forest, narrow_band
from imu_lib.vibrations.band_removal import quietened
from imu_lib.vibrations.behaviour import BREATHES, SWEEPS
from imu_lib.vibrations.building import apart, of_building
from imu_lib.vibrations.entries import Shake, of_band, of_family, of_forest, of_tone
from imu_lib.vibrations.families import folds, grouped
from imu_lib.vibrations.mains import of_mains
from imu_lib.vibrations.skirts import widened
from imu_lib.vibrations.sources import NARROW, Source, sources
from imu_lib.vibrations.sweeps import joined
from imu_lib.vibrations.transforms import Transforms

from .base import Effect, Finding

if TYPE_CHECKING:
    from imu_lib.gap.record_vibrations import RecordView

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
#: Blocks of the record whose means are the slow part that is taken out first, and those where many
#: lines are looked for, the slow ones too.
SLOW, SLOWER = 128, 32
#: Slowest line that is looked for, in cycles a block.
LOWEST = 2.0
#: Amplitude over that of a line in it below which a band is the skirt of the line.
SKIRT = 0.3
#: Share of the power of a channel from which on a band that it shares with others is told.
FAINT = 1e-3
#: Deviations at which samples are clipped before the search, in robust standard deviations.
CLIP = 12.0


class Vibration(Effect):
    name = "vibration"
    cause = (
        "Something shakes the sensor or couples into its electronics: a fan, a motor, a "
        "building, a switching supply."
    )
    domain = "lines"
    level = "record"
    order = 30

    def candidates(self, view: RecordView) -> list[Finding]:
        """Everything that shakes: one finding a cause, with the signal that it puts into each of
        its channels.
        """
        fs, given = view.fs, view.model
        lost = np.mean([np.isnan(x).mean() for x in view.raw.values()])
        if lost > MISSING or len(next(iter(view.raw.values()))) < LEAST:
            return []
        filled = {name: first_fill(x, np.isnan(x)) for name, x in view.raw.items()}
        block = max(int(2 * fs), len(next(iter(filled.values()))) // SLOW)
        quick = _fast_parts(filled, block)
        if not quick:
            return []
        rng = np.random.default_rng(len(next(iter(quick.values()))))
        trees = _felled(filled, fs, rng)
        if trees is not None:
            quick = _fast_parts({name: filled[name] for name in quick}, block)
        shakes = [] if trees is None else [trees]
        transforms = Transforms(quick, fs)
        # where the largest gain is looked for: frequencies, channels, stretches and widths
        looked_at = transforms.n * len(transforms.names) * WINDOWS
        shakes += self._families(quick, transforms, given, LOWEST * fs / block)
        shakes = _with_bands(shakes, quick, fs)
        out = []
        for shake in shakes:
            before = {name: filled[name] for name in shake.process.channels}
            _taken_out(shake, filled, fs, rng)
            if shake.bands:
                shake.process = excess.measured(shake.process, before, filled, fs)
            item = Finding(self, shake.process, shake.gain, shake.where, shake.intervals)
            item.places, item.signal, item.bands = looked_at, shake.signal, shake.bands
            item.doubt = shake.doubt or None
            item.evidence = excess.in_bursts(shake.process, quick, fs)
            item.held = any(_alike(item.process, p) for p in _held(given))
            out.append(item)
        return out

    def _families(
        self, quick: dict[str, Array], transforms: Transforms, given: Model | None, least: float
    ) -> list[Shake]:
        """Lines and families of lines."""
        places = narrow_band.of_all(quick, transforms.fs, least=least)
        found = joined(sources(places, transforms), transforms.duration)
        found = [s for s in found if self._is_one(s, given, transforms)]
        swept = {c for s in found if s.strange == SWEEPS for c in s.channels}
        out: list[Shake] = []
        families = grouped([t for s in found for t in apart(s)], transforms)
        for f0, family in families:
            if len(family) == 1 and folds(family[0], families, transforms):
                continue  # of a periodic signal, which has a cause or none
            if self._is_vibration(family, swept) or self._hums(f0, family):
                out += of_family(f0, family, transforms, SHORTEST)
            elif of_building(family):
                out += of_family(0.0, family, transforms, SHORTEST)
            elif self._is_tone(family, swept):
                out.append(of_tone(family[0], transforms))
        return out

    @staticmethod
    def _is_one(s: Source, given: Model | None, transforms: Transforms) -> bool:
        if s.gain < LEAST_GAIN or s.bandwidth > 0.1 * s.frequency and s.strength < 0.5:
            return False
        if s.start is not None and s.stop is not None and s.stop - s.start < SHORTEST:
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
    def _is_vibration(family: list[Source], swept: set[str]) -> bool:
        """Whether a family of sources is a vibration: on several channels, for a time, or a line
        that wanders. A steady line of one channel is a sinusoid, a band of normal noise
        that is not the same on all its channels a resonance of each, and a periodic signal of one
        channel, a tone that sweeps or one that rises and falls has no name. On channels over which
        a tone has `swept`, pieces of its way are none.
        """
        s = family[0]
        if len({c for s in family for c in s.channels}) > 1:
            return len(family) > 1 or s.coherent or s.fading < STEADY
        if len(family) == 1 and s.wander and s.carried and s.strange == BREATHES:
            return True  # a machine whose load changes: two lines that beat have no such wave
        if len(family) > 1 or s.strange or not s.whole and swept & set(s.channels):
            return False
        return not s.whole or 0 < s.bandwidth < 0.1 * s.frequency and s.fading < STEADY

    @staticmethod
    def _hums(f0: float, family: list[Source]) -> bool:
        """Whether steady lines of one channel are multiples of the mains, which couple into it."""
        return of_mains(f0, len(family)) and all(s.whole and not s.strange for s in family)

    @staticmethod
    def _is_tone(family: list[Source], swept: set[str]) -> bool:
        """Whether it is a tone of one channel whose amplitude rises and falls, or that sweeps."""
        s = family[0]
        if len(family) > 1 or len(s.channels) > 1:
            return False
        if s.strange == SWEEPS:
            return True
        alone = not swept & set(s.channels)
        return alone and s.strange == BREATHES and s.bandwidth < NARROW * s.frequency


VIBRATION = Vibration()
EFFECTS = (VIBRATION,)


def _with_bands(shakes: list[Shake], quick: dict[str, Array], fs: float) -> list[Shake]:
    """Lines and, in place of the wide ones that lie in them, bands that channels share."""
    lines = [
        s.process
        for s in shakes
        if s.bands and (s.sweeps or s.process.bandwidth < NARROW * s.process.frequency)
    ]
    bands = [of_band(band) for band in coherent_band.bands(quick, fs, lines)]
    bands = [b for b in bands if _matters(b.process, quick)]
    bands = [b for b in bands if not any(_skirt(b, s) for s in shakes if s.process in lines)]
    out = [s for s in shakes if s.process in lines or not any(_within(s, b) for b in bands)]
    return out + bands


def _matters(p: Process, quick: dict[str, Array]) -> bool:
    """Whether a band has a share of the power of any of its channels that a figure would show: what
    leaks into the stop band of a filter is alike on all of them.
    """
    return any(excess.loudness(p, c, quick) ** 2 / 2 > FAINT for c in p.channels)


def _skirt(band: Shake, line: Shake) -> bool:
    """Whether a band is what is left around a line that the same channels have: faint beside it on
    all of them. The line's own bands then reach as far.
    """
    ((low, high),) = band.bands
    own = dict(zip(line.process.channels, line.process.amplitude))
    faint = all(
        a < SKIRT * own.get(c, 0.0) for c, a in zip(band.process.channels, band.process.amplitude)
    )
    if not faint or not any(low <= f <= high for f in line.process.frequencies):
        return False
    if line.process.harmonics == 1:  # as far as the band has half of its power
        half = band.process.bandwidth / 2
        low, high = band.process.frequency - half, band.process.frequency + half
        line.bands = [(min(low, line.bands[0][0]), max(high, line.bands[-1][1]))]
    return True


def _within(shake: Shake, band: Shake) -> bool:
    """Whether a wide line is a part of a band that the same channels share."""
    p, ((low, high),) = shake.process, band.bands
    return (
        bool(shake.bands)
        and low <= p.frequency <= high
        and set(p.channels) <= set(band.process.channels)
    )


def _felled(filled: dict[str, Array], fs: float, rng: np.random.Generator) -> Shake | None:
    """A forest of lines, taken out of the channels in place, or None."""
    n = len(next(iter(filled.values())))
    block = max(int(2 * fs), n // SLOWER)
    quick = _fast_parts(filled, block)
    trees = forest.forest(quick, fs, least=LOWEST * fs / block)
    if trees is None:
        return None
    before, signal = {name: filled[name] for name in trees.channels}, {}
    for name in trees.channels:
        signal[name] = quick[name] - forest.felled(quick[name], trees, rng)
        filled[name] = filled[name] - signal[name]
    shake = of_forest(trees, signal, n / fs)
    shake.process = excess.measured(shake.process, before, filled, fs)
    return shake


def _taken_out(shake: Shake, filled: dict[str, Array], fs: float, rng: np.random.Generator) -> None:
    """Take what shakes out of the channels that feel it, in place, where its bands say so."""
    p = shake.process
    start, stop = p.start or 0.0, p.stop
    for name in p.channels if shake.bands else ():
        wander = p.bandwidth > 0 and not p.band and p.lines is None
        bands = (
            widened(filled[name], fs, shake.bands, start=start, stop=stop)
            if wander
            else shake.bands
        )
        calm = quietened(filled[name], fs, bands, rng, start=start, stop=stop)
        shake.signal[name] = filled[name] - calm
        filled[name] = calm


def fast_part(x: Array, block: int) -> np.ndarray | None:
    """A channel without what is slower than `block` samples, outliers cut down, shape (n,); None
    where most of it is one value.
    """
    x = x - trend(x, block)
    sd = 1.4826 * np.median(np.abs(x))
    return np.clip(x, -CLIP * sd, CLIP * sd) if sd > 0 and np.ptp(x) > 0 else None


def _fast_parts(filled: dict[str, Array], block: int) -> dict[str, Array]:
    """The channels that are not mostly one value, without what is slow in them."""
    parts = {name: fast_part(x, block) for name, x in filled.items()}
    return {name: x for name, x in parts.items() if x is not None}


def _held(given: Model | None) -> list[Process]:
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
