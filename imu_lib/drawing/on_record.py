"""What acts on several channels, by pieces: the numbers that `Model.simulate` adds at once.

`shared` adds noise in common, vibrations, knocks and tilts into one scratch file a channel, in the
order in which they ask the generator; `lost` puts drop-outs into the channels that are drawn.
"""

from __future__ import annotations

from functools import singledispatch

import numpy as np

from imu_lib.drawing.terms import chunks
from imu_lib.processes import CommonMode, Disturbance, Dropout, Tilt, Vibration
from imu_lib.stream import CHUNK, Scratch, bounds, inverse

#: All that is known here, clocks aside.
SHARED, LOST = (CommonMode, Vibration, Disturbance, Tilt), (Dropout,)


def shared(model, n, fs, rng, folder) -> dict[str, Scratch]:
    """What the record puts into its channels: name -> `n` samples on disk."""
    out: dict[str, Scratch] = {}

    def add(channel, pieces, at=0):
        if channel not in model.channels:
            for _ in pieces:  # what it draws counts, too
                pass
            return
        fresh = channel not in out
        held = out.setdefault(channel, Scratch(n, folder=folder))
        for x in pieces:
            held.write(at, x if fresh else held.read(at, at + x.size) + x)
            at += x.size

    for process in model.record:
        if type(process) in SHARED:
            _parts(process, model, n, fs, rng, folder, add)
    return out


@singledispatch
def _parts(process, model, n, fs, rng, folder, add):
    raise TypeError(f"{process.name} is not drawn by pieces")


@_parts.register(CommonMode)
def _(process, model, n, fs, rng, folder, add):
    filters = {c: model[c].low_pass for c in process.channels if c in model.channels}
    if process.filtered and any(filters.values()):
        for channel, x in process.on(filters, n, fs, rng).items():
            add(channel, (x[low:high] for low, high in bounds(n)))
        return
    if not filters:
        process.on(filters, n, fs, rng)
        return
    white = Scratch(n, folder=folder)
    bare = process.with_(channels=())
    for low, high in bounds(n):
        white.write(low, bare.simulate(high - low, fs, rng))
    for channel in filters:
        add(channel, (white.read(low, high) for low, high in bounds(n)))


@_parts.register(Vibration)
def _(process, model, n, fs, rng, folder, add):
    process._require()
    # one draw for all lines
    whole = process.wander is not None or process.profile is not None or process.forest
    whole |= process.band and (n % 2 or n <= CHUNK)  # the transform over the disk is even
    if whole:
        for channel, x in process.on(n, fs, rng).items():
            add(channel, (x[low:high] for low, high in bounds(n)))
        return
    drawn = _bands if process.band else _lines
    shape, lines = process.shape, drawn(process, n, fs, rng, folder)
    for channel, amplitude in zip(process.channels, process.amplitude):
        turn = np.exp(2j * np.pi * rng.random(len(shape)))
        add(channel, _felt(process, lines, shape, turn, amplitude, n, fs))


def _felt(process, lines, shape, turn, amplitude, n, fs):
    """What one channel feels, in pieces; `lines(turn)` gives the real lines, turned, in pieces."""
    for (low, high), parts in zip(bounds(n), lines(turn), strict=True):
        x = sum(r * part for r, part in zip(shape, parts))
        t = np.arange(low, high) / fs
        on = np.ones(high - low, dtype=bool)
        if process.start is not None:
            on &= t >= process.start - 1e-9
        if process.stop is not None:
            on &= t <= process.stop + 1e-9
        yield amplitude * np.where(on, x, 0.0)


def _lines(process, n, fs, rng, folder):
    wander = None
    if process.bandwidth > 0:  # time runs unevenly, so that all lines wander together
        step = np.sqrt(process.bandwidth / (2 * np.pi * fs)) / process.frequency
        wander, last = Scratch(n, folder=folder), 0.0
        for low, high in bounds(n):
            w = rng.standard_normal(high - low)
            w[0] += last
            np.cumsum(w, out=w)
            last = w[-1]
            wander.write(low, w * step)
    phase = [rng.random() for _ in process.frequencies]

    def turned(turn):
        for low, high in bounds(n):
            turns = np.arange(low, high) / fs
            if wander is not None:
                turns = turns + wander.read(low, high)
            yield [
                (np.exp(2j * np.pi * (f * turns + u)) * e).real
                for f, u, e in zip(process.frequencies, phase, turn)
            ]

    return turned


def _bands(process, n, fs, rng, folder):
    """Normal noise of each band: its transform is on disk, and turned before it is transformed."""
    half = n // 2
    spectra = []
    for at in process.frequencies:
        width = 0.5 * process.bandwidth * at / process.frequency
        total = 0.0
        for low, high in bounds(half):
            total += float(np.sum(_gain(low, high, n, fs, at, width) ** 2))
        scale = np.sqrt(n / total) if total > 0 else 0.0
        spectrum = Scratch(half + 1, dtype=complex, folder=folder)
        for unit in (1.0, 1j):  # all the real parts are drawn first
            for low, high in bounds(n):
                z = unit * rng.standard_normal(high - low)
                high = min(high, half)
                if low >= high:
                    continue
                z = z[: high - low] * (_gain(low, high, n, fs, at, width) * scale)
                spectrum.write(low, z if unit == 1.0 else spectrum.read(low, high) + z)
        spectra.append(spectrum)

    def turned(turn):
        whole = [_series(s, e, n, folder) for s, e in zip(spectra, turn)]
        for low, high in bounds(n):
            yield [x.read(low, high) for x in whole]

    return turned


def _gain(low, high, n, fs, at, width):
    f = np.arange(low, high) / (n * (1 / fs))
    return np.where(f > 0, 1.0 / np.sqrt(1.0 + ((f - at) / width) ** 8), 0.0)


def _series(spectrum, turn, n, folder):
    """The real part of a one-sided spectrum's series, turned, on disk."""
    scale = turn * np.sqrt(0.5) * np.sqrt(n) / 2
    turned = Scratch(spectrum.n, dtype=complex, folder=folder)
    for low, high in bounds(spectrum.n):
        turned.write(low, spectrum.read(low, high) * scale)
    out, at = Scratch(n, folder=folder), 0
    for x in inverse(turned, folder=folder):
        out.write(at, x)
        at += x.size
    turned.close()
    return out


@_parts.register(Disturbance)
def _(process, model, n, fs, rng, folder, add):
    size = max(1, int(round(process.duration * fs)))
    first = int(round(process.start * fs))
    shakes = process.with_(start=0.0).on(size, fs, rng)
    low, high = max(first, 0), min(first + size, n)
    for channel, x in shakes.items():
        fill = np.zeros(0) if high <= low else x[low - first : high - first]
        add(channel, _placed(fill, low, n))


def _placed(x, at, n):
    """Zeros with `x` from `at` on, in pieces."""
    for low, high in bounds(n):
        out = np.zeros(high - low)
        a, b = max(low, at), min(high, at + x.size)
        if b > a:
            out[a - low : b - low] = x[a - at : b - at]
        yield out


@_parts.register(Tilt)
def _(process, model, n, fs, rng, folder, add):
    names = [c for c in process.on(2, fs) if c in model.channels]
    for channel in names:
        add(channel, (process.on(b - a, fs, first=a)[channel] for a, b in bounds(n)))


def lost(process, channels, n, fs, rng):
    """Drop-outs in channels on disk (name -> Scratch), `n` samples at `fs` Hz."""
    if process.period is None and not process.at_once:
        process._require()
        gone = np.concatenate([rng.random(b - a) < process.fraction for a, b in bounds(n)])
    else:
        gone = process.rows(n, fs, rng)
    if process.held:
        gone[0] = False
    for i, name in enumerate(process.channels):
        if name not in channels:
            continue
        value = process.value[i] if isinstance(process.value, tuple) else process.value
        last = np.nan if value is None else value
        for low, high in bounds(n):
            x, here = channels[name].read(low, high), gone[low:high]
            if process.held:
                at = np.maximum.accumulate(np.where(here, -1, np.arange(high - low)))
                x = np.where(at < 0, last, x[at])
                last = x[-1]
            else:
                x = np.where(here, last, x)
            channels[name].write(low, x)


def wandering(stage, n, fs, rng, size, folder):
    """A draw of the factor of a noise level that wanders, on disk."""
    from imu_lib.processes import GaussMarkov

    g = GaussMarkov(sigma=stage.sd, correlation_time=stage.correlation_time)
    out, at = Scratch(n, folder=folder), 0
    for x in chunks(g, n, fs, rng, size=size):
        out.write(at, np.exp(x - stage.sd**2))
        at += x.size
    return out
