"""Draw a record into scratch files: channels, clock, and the pieces of the whole."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.signal import lfilter, sosfilt

from imu_lib.drawing.on_record import LOST, SHARED, lost, shared, wandering
from imu_lib.drawing.stages import level, passed, rounded
from imu_lib.drawing.terms import chunks
from imu_lib.model import Model
from imu_lib.processes import (
    Jitter,
    NoiseLevelChange,
    RateError,
    Sum,
    TimeGaps,
    WanderingLevel,
    WhiteNoise,
    folded,
)
from imu_lib.processes.on_record import clock
from imu_lib.processes.realisation import ON_NOISE, moves_within_steps
from imu_lib.processes.stages import Resolution, Saturation, Spikes, Stuck
from imu_lib.record import CHANNELS
from imu_lib.stream import CHUNK, Scratch, bounds

_STAGES = (*ON_NOISE, Spikes, Saturation, Resolution, Stuck)
#: Where the noise with heavy tails that is drawn behind the filter is kept.
BEHIND = "behind"
_ON_RECORD = (*SHARED, *LOST, RateError, Jitter, TimeGaps)


@dataclass(frozen=True)
class Drawn:
    """A record on disk: channels, and what its clock did.

    Attributes
    ----------
    channels : dict of str to Scratch
    rate : float, Hz
    size : int
        Samples drawn.
    time : ndarray (size,) or None
        Stamps, s; None means even.
    keep : ndarray of bool (size,) or None
        Samples that are in the record; None means all.
    temperature : ndarray (size,) or None
    """

    channels: dict
    rate: float
    size: int
    time: np.ndarray | None
    keep: np.ndarray | None
    temperature: np.ndarray | None

    @property
    def n(self) -> int:
        """Samples in the record."""
        return self.size if self.keep is None else int(self.keep.sum())

    def pieces(self, size=CHUNK):
        """Dicts of `time` (s from the first sample), channels, `temperature`, ndarray (k,) each."""
        for low, high in bounds(self.size, size):
            t = np.arange(low, high) / self.rate if self.time is None else self.time[low:high]
            out = {"time": t - (self.time[0] if self.time is not None else 0.0)}
            out |= {name: x.read(low, high) for name, x in self.channels.items()}
            if self.temperature is not None:
                out["temperature"] = self.temperature[low:high]
            keep = slice(None) if self.keep is None else self.keep[low:high]
            yield {name: x[keep] for name, x in out.items()}


def by_pieces(model: Model) -> bool:
    """Whether all that acts on the model's record is known here; else it is drawn in memory."""
    return all(type(process) in _ON_RECORD for process in model.record)


def draw(
    model: Model, n, fs, rng, *, folder=None, temperature=None, size=CHUNK, progress=None
) -> Drawn:
    """The record that `model.simulate_record(n, fs, rng)` draws, on disk.

    Equal to it to the last digit but for flicker noise, bands of vibration and moving averages,
    whose sums are made in another order (1e-9 of the noise).

    Parameters
    ----------
    model : Model
        One for which `by_pieces` is true.
    n, fs, rng, temperature
        As for `Model.simulate_record`.
    folder : path or None
        Of the scratch files.
    size : int
        Samples of a piece; they do not depend on it.
    progress : callable, optional
        Called with the name of each channel that is done.
    """
    generators = dict(zip((*CHANNELS, "record"), rng.spawn(len(CHANNELS) + 1)))
    pace = next((p for p in model.record if isinstance(p, RateError)), RateError(1.0))
    true = model.with_channels({c: pace.paced(entry) for c, entry in model.channels.items()})
    rate = fs * pace.ratio
    common = shared(true, n, rate, generators["record"], folder)
    channels = {}
    for name in model.channel_names:
        channels[name] = Scratch(n, folder=folder)
        at = 0
        more = {"temperature": temperature, "common": common.pop(name, None)}
        for x in draw_channel(
            true[name], n, rate, generators[name], size=size, folder=folder, **more
        ):
            channels[name].write(at, x)
            at += x.size
        if progress is not None:
            progress(name)
    for process in model.record:
        if isinstance(process, LOST):
            lost(process, channels, n, rate, generators["record"])
    time, keep = clock(model.record, n, fs, rng)
    return Drawn(channels, float(fs), n, time, keep, temperature)


def draw_channel(sum_: Sum, n, fs, rng, *, size=CHUNK, folder=None, temperature=None, common=None):
    """One channel in pieces: what `Sum.simulate` gives at once. `common` is a Scratch or None."""
    if not all(type(stage) in _STAGES for stage in sum_.stages):
        whole = None if common is None else common.read(0, n)
        x = sum_.simulate(n, fs, rng, temperature=temperature, common=whole)
        return (x[low:high] for low, high in bounds(n, size))
    low_pass = sum_.low_pass
    fine = moves_within_steps(sum_, fs)
    steps, before = (1, 0) if low_pass is None else low_pass.grid(fs, fine)
    total, rate = n * steps + before, fs * steps
    start = -before / rate
    if temperature is not None and (steps, before) != (1, 0):
        temperature = _Resampled(temperature, fs, start, rate)
    parts = {}
    for term in sum_.terms:
        if term is sum_.rounding:
            continue
        if term.behind_filter:
            drawn = chunks(term, n, fs, rng, size=size, folder=folder)
            _add(drawn, BEHIND in parts, parts.setdefault(BEHIND, Scratch(n, folder=folder)))
            continue
        tailed = sum_.tails is not None and isinstance(term, WhiteNoise)
        if tailed and low_pass is not None:
            _add_tailed(parts, term, sum_, n, fs, rng, size, folder)
            continue
        part, first = parts.get(term.fast), term.fast not in parts
        if first:
            part = parts[term.fast] = Scratch(total, folder=folder)
        options = {"size": size, "temperature": temperature, "start": start, "folder": folder}
        drawn = chunks(term, total, rate, rng, **options)
        if tailed:
            drawn = _tailed(sum_.tails, drawn, total, term.N * np.sqrt(rate), rng, folder)
        _add(drawn, not first, part)
    return _behind(sum_, parts, n, total, fs, fine, rng, size, common, folder)


def _add(drawn, more, part):
    """Pieces into a Scratch, to what is there where `more` is set."""
    at = 0
    for x in drawn:
        part.write(at, part.read(at, at + x.size) + x if more else x)
        at += x.size


def _tailed(tails, pieces, total, sd, rng, folder):
    """White noise of standard deviation `sd` with heavy tails: its samples are all drawn before
    their scales.
    """
    held, at = Scratch(total, folder=folder), 0
    for x in pieces:
        held.write(at, x)
        at += x.size
    for low, high in bounds(total):
        yield tails.given(held.read(low, high), sd, rng)


def _add_tailed(parts, term, sum_, n, fs, rng, size, folder):
    """White noise with heavy tails behind a filter, at the record's rate."""
    first = BEHIND not in parts
    part = parts.setdefault(BEHIND, Scratch(n, folder=folder))
    reach, at = len(folded.response(sum_.low_pass, fs)) - 1, 0
    drawn = chunks(term, n + reach, fs, rng, size=size)
    known = np.zeros(0)
    for x in _tailed(sum_.tails, drawn, n + reach, term.N * np.sqrt(fs), rng, folder):
        known = np.concatenate([known, x])
        if len(known) > reach:
            y = folded.behind(known, sum_.low_pass, fs)
            part.write(at, y if first else part.read(at, at + y.size) + y)
            at, known = at + y.size, known[len(known) - reach :]


def _behind(sum_, parts, n, total, fs, fine, rng, size, common, folder):
    def read(fast):
        part = parts.get(fast)
        for low, high in bounds(total, size):
            yield np.zeros(high - low) if part is None else part.read(low, high)

    slow, quick = read(False), read(True)
    if sum_.low_pass is not None:
        slow, quick = (_filtered(sum_.low_pass, x, fs, n, size, fine) for x in (slow, quick))
    if BEHIND in parts:
        quick = _added(quick, parts[BEHIND])
    levels = [
        wandering(s, n, fs, rng, size, folder) if isinstance(s, WanderingLevel) else s
        for s in sum_.stages
        if isinstance(s, (NoiseLevelChange, WanderingLevel))
    ]
    x = _joined(levels, slow, quick, fs, common)
    chain = [(s.place, partial(passed, s)) for s in sum_.stages if not isinstance(s, ON_NOISE)]
    if sum_.rounding is not None:
        rounding = sum_.rounding
        chain.append((Resolution.place - 0.5, lambda x, fs, rng, n: rounded(rounding, x, fs, rng)))
    for _, act in sorted(chain, key=lambda link: link[0]):
        x = act(x, fs, rng, n)
    return x


def _added(pieces, more):
    """The pieces with what a Scratch has in their places."""
    at = 0
    for x in pieces:
        yield x + more.read(at, at + x.size)
        at += x.size


def _joined(levels, slow, quick, fs, common):
    """The sum in pieces; `levels` act on the quick noise: stages, or factors on disk."""
    at = 0
    for a, b in zip(slow, quick, strict=True):
        for change in levels:
            drawn = isinstance(change, Scratch)
            b = b * (change.read(at, at + b.size) if drawn else level(change, b.size, fs, at))
        x = a + b
        if common is not None:
            x = x + common.read(at, at + x.size)
        at += x.size
        yield x


def _filtered(low_pass, pieces, fs, n, size, fine):
    """`LowPass.run` by pieces, put together again to `size` samples each."""
    steps, before = low_pass.grid(fs, fine)
    state, first, at, given = None, None, 0, 0
    waiting = []
    for x in pieces:
        if first is None:
            first = 0.0 if low_pass.taps is not None else x[0]
        if low_pass.taps is not None:
            width = before + 1
            known = np.zeros(width - 1) if state is None else state
            y = lfilter(low_pass.window(before), [1.0], np.concatenate([known, x]))[width - 1 :]
            state = np.concatenate([known, x])[x.size :]
        elif low_pass.smoothing:
            b = low_pass._memory(steps * fs)
            y, state = lfilter(
                [1.0 - b], [1.0, -b], x - first, zi=np.zeros(1) if state is None else state
            )
        else:
            sos = low_pass._sos(steps * fs)
            y, state = sosfilt(
                sos, x - first, zi=np.zeros((len(sos), 2)) if state is None else state
            )
        offset = (before - at) % steps if at > before else before - at
        at += x.size
        waiting.append(y[offset::steps] + first if offset < x.size else y[:0])
        while sum(map(len, waiting)) >= size or (at >= n * steps + before and given < n):
            ready = np.concatenate(waiting)
            out, waiting = ready[: min(size, n - given)], [ready[min(size, n - given) :]]
            given += out.size
            yield out
            if given >= n:
                return


class _Resampled:
    """Temperature on the filter's grid, by slices."""

    def __init__(self, values, fs, start, rate):
        self.values, self.fs, self.start, self.rate = values, fs, start, rate

    def __getitem__(self, part):
        at = self.start + np.arange(part.start, part.stop) / self.rate
        low = max(int(at[0] * self.fs) - 2, 0)
        high = min(int(at[-1] * self.fs) + 3, len(self.values))
        return np.interp(at, np.arange(low, high) / self.fs, self.values[low:high])
