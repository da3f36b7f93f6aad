"""What shakes the sensor as an entry of the model: a family of lines, a band, a forest of lines;
each with its gain, its bands and a sentence of where it shows.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from imu_lib import words
from imu_lib.arrays import Array
from imu_lib.processes import Vibration as Process
from imu_lib.timing import folded
from imu_lib.vibrations.behaviour import SWEEPS
from imu_lib.vibrations.coherent_band import Band
from imu_lib.vibrations.families import weak_lines
from imu_lib.vibrations.forest import Forest
from imu_lib.vibrations.multiples import order_of
from imu_lib.vibrations.patterns import Line, alike, factors, faint, noise_of
from imu_lib.vibrations.sources import Source, examined
from imu_lib.vibrations.transforms import Transforms

#: Lines beyond which a sentence says how many there are.
FOREST = 40


@dataclass
class Shake:
    """A vibration that was found.

    `bands` are (low, high) in Hz, which hold all of it; `signal` what it puts into each channel,
    where that is known already; `doubt` why it is no vibration, in a sentence.
    """

    process: Process
    gain: float
    where: str
    intervals: dict[str, Any]
    bands: list[tuple[float, float]] = field(default_factory=list)
    signal: dict[str, Array] = field(default_factory=dict)
    doubt: str = ""
    #: Whether its frequency goes from one end of its band to the other.
    sweeps: bool = False


def of_family(
    f0: float, family: list[Source], transforms: Transforms, shortest: float
) -> list[Shake]:
    """A family of sources, multiples of `f0` Hz where that is not 0: one shake for each pattern of
    channels that its lines have, and for each episode of `shortest` s or more.
    """
    lines: list[Line] = [(order_of(s, f0, transforms) if f0 else s.frequency, s) for s in family]
    weak = weak_lines(f0, family, transforms) if f0 else {}
    lines += [(k, faint(k, v, f0, family, transforms)) for k, v in weak.items()]
    names = [n for n in transforms.names if any(n in s.amplitude for _, s in lines)]
    parts = alike(lines, names, transforms)
    if len(parts) == 1:
        return _of_lines(f0, lines, transforms, shortest)
    out = []
    for part in parts:
        more = _of_lines(f0, part, transforms, shortest)
        if len(part) == 1:
            ((order, s),) = part
            if s not in family:  # what it is by itself, and on whom
                s = examined(s.place, set(s.channels), transforms)
            more = _of_lines(0.0, [(s.frequency, s)], transforms, shortest)
        for shake in more:
            shake.where += _of_cause(f0, [order for order, _ in part])
        out += more
    return out


def _of_cause(f0: float, orders: list[float]) -> str:
    """Words for a part of a family whose other lines are felt otherwise."""
    if not f0:
        return "; the other lines of the same cause are felt by the channels in another ratio"
    if orders == [1]:
        return "; its multiples are felt by the channels in another ratio"
    times = words.listed([f"{order:.0f}" for order in orders])
    return f"; {times} times {f0:.5g} Hz, which the channels feel in another ratio"


def _of_lines(f0: float, lines: list[Line], transforms: Transforms, shortest: float) -> list[Shake]:
    """Lines that all channels feel in one ratio: one shake an episode."""
    order, best = max(lines, key=lambda line: line[1].gain)
    order = order if f0 else 1.0
    lines = sorted(lines, key=lambda line: line[0])
    family = [s for _, s in lines]
    names = [n for n in transforms.names if any(n in s.amplitude for s in family)]
    matrix = np.array([[s.amplitude.get(n, 0.0) for s in family] for n in names])
    strength, ratios = factors(matrix, noise_of(lines, names, transforms))
    process = Process(
        frequency=float(f0 or best.frequency),
        amplitude=tuple(float(v) for v in strength),
        bandwidth=float(best.bandwidth / order),
        channels=tuple(names),
        **_lines(f0, [k for k, _ in lines], ratios),
        **_wander(best),
    )
    spread = 1.96 * max(best.frequency_sd / order, 1e-9)
    intervals: dict[str, Any] = {
        "frequency": [process.frequency - spread, process.frequency + spread]
    }
    intervals["amplitude"] = [
        [max(0.0, a - 1.96 * _sd(family, n)), a + 1.96 * _sd(family, n)]
        for n, a in zip(names, process.amplitude)
    ]
    bands = _merged([(s.place.low, s.place.high) for s in family])
    gain, out = float(sum(s.gain for s in family)), []
    spans = [v for v in best.spans if len(best.spans) < 2 or v[1] - v[0] >= shortest]
    total = sum(stop - start for start, stop in spans)
    times: list[tuple[float | None, float | None]] = [*spans] or [(None, None)]
    for start, stop in times:
        one = process.with_(start=start, stop=stop)
        share = 1.0 if start is None or stop is None else (stop - start) / total
        text = where(one, best.strength, transforms.duration, transforms.fs)
        swept = best.strange == SWEEPS
        if swept:
            text += f"; {SWEEPS} between {best.place.low:.4g} and {best.place.high:.4g} Hz"
        out.append(Shake(one, gain * share, text, intervals, bands, sweeps=swept))
    return out


def _wander(s: Source) -> dict[str, Any]:
    """Fields of a process whose amplitude wanders."""
    return {} if s.wander is None else {"wander": s.wander[0], "wander_time": s.wander[1]}


def _lines(f0: float, keys: list[float], ratios: Array) -> dict[str, Any]:
    """Fields of a process of several lines."""
    if len(keys) == 1 and (not f0 or keys == [1]):
        return {}
    count = int(max(keys)) if f0 else len(keys)
    table = np.zeros(count)
    for i, k in enumerate(keys):
        table[int(k) - 1 if f0 else i] = ratios[i]
    more = {"harmonics": count, "ratios": tuple(float(v) for v in table)}
    return more if f0 else {**more, "lines": tuple(float(k) for k in keys)}


def of_band(band: Band) -> Shake:
    """Noise that channels share in a band."""
    process = Process(
        frequency=0.5 * (band.low + band.high),
        amplitude=tuple(band.amplitude.values()),
        bandwidth=band.high - band.low,
        channels=tuple(band.amplitude),
    )
    return Shake(
        process,
        band.gain,
        f"coherence between {_names(process.channels)} from {band.low:.3g} to {band.high:.3g} Hz: "
        f"{band.coherence:.2g} there and none elsewhere",
        {"frequency": [band.low, band.high]},
        [band.reach],
    )


def of_tone(source: Source, transforms: Transforms) -> Shake:
    """A tone of one channel that behaves as no vibration does: what it is, without a name."""
    alone = replace(source, spans=())
    (shake,) = of_family(0.0, [alone], transforms, 0.0)
    (name,) = source.channels
    if source.strange == SWEEPS:
        shake.doubt = (
            f"a tone of this channel alone, {10 * np.log10(1 + source.strength):.0f} dB above the "
            f"noise: {SWEEPS} between {source.place.low:.4g} and {source.place.high:.4g} Hz; no "
            "effect of the catalogue does that"
        )
        return shake
    when = loudest(transforms, name, shake.bands[0])
    shake.doubt = (
        f"a tone at {source.frequency:.4g} Hz, {10 * np.log10(1 + source.strength):.0f} dB above "
        f"the noise: {source.strange}, most of it is there from {when[0]:.0f} to {when[1]:.0f} s; "
        "no effect of the catalogue does that"
    )
    return shake


def loudest(transforms: Transforms, name: str, band: tuple[float, float]) -> tuple[float, float]:
    """From when to when (s) the middle two thirds of the power of a band on a channel came."""
    z = transforms.zoom(name, *transforms.ordinates(*band))
    power = np.maximum(np.abs(z) ** 2 - 1.0, 0.0)
    share = np.cumsum(power) / max(power.sum(), 1e-300)
    low, high = np.interp([1 / 6, 5 / 6], share, (np.arange(len(z)) + 0.5) / len(z))
    return float(low * transforms.duration), float(high * transforms.duration)


def of_forest(found: Forest, signal: dict[str, Array], duration: float) -> Shake:
    """A forest of lines with what it puts into its channels."""
    order = np.argsort(found.frequencies)
    lines, matrix = found.frequencies[order], found.amplitude[:, order]
    strength, ratios = factors(matrix, np.ones(len(matrix)))
    process = Process(
        frequency=float(found.frequencies[0]),
        amplitude=tuple(float(v) for v in strength),
        channels=found.channels,
        harmonics=len(lines),
        ratios=tuple(float(v) for v in ratios),
        lines=tuple(float(v) for v in lines),
    )
    strongest = (
        f", of which the model has the {len(lines)} strongest" if found.count > len(lines) else ""
    )
    text = (
        f"power spectral density: {found.count} lines between {lines.min():.3g} and "
        f"{lines.max():.3g} Hz on {_names(found.channels)}, all the time from 0 to "
        f"{duration:.0f} s: products of two clocks{strongest}"
    )
    spread = 0.5 / duration
    return Shake(
        process,
        found.gain,
        text,
        {"frequency": [process.frequency - spread, process.frequency + spread]},
        signal=signal,
    )


def where(process: Process, strength: float, duration: float, fs: float) -> str:
    """Where it shows, in a sentence; `duration` s at `fs` Hz."""
    lines = process.frequencies
    decibel = f", {10 * np.log10(1 + strength):.0f} dB above the noise"
    if process.harmonics == 1:
        what = f"power spectral density at {process.frequency:.5g} Hz{decibel}"
    elif process.lines is not None:
        what = (
            f"power spectral density: {process.harmonics} lines between {lines.min():.4g} and "
            f"{lines.max():.4g} Hz{decibel}"
        )
    else:
        count = np.count_nonzero(process.shape)
        what = f"power spectral density at {count} multiples of {process.frequency:.5g} Hz{decibel}"
        beyond = lines[(process.shape > 0) & (lines > 0.5 * fs)]
        if len(beyond):
            what += (
                f", of which the sampling folds {words.listed([f'{f:.4g}' for f in beyond])} Hz to "
                f"{words.listed([f'{folded(f, fs):.4g}' for f in beyond])} Hz"
            )
    if process.bandwidth > 0 and process.harmonics == 1:
        what += f", {process.bandwidth:.2g} Hz wide"
    if process.wander:
        size, time = process.wander, process.wander_time
        what += f", its amplitude wanders by {100 * size:.2g} % over {time:.2g} s"
    what += f", on {_names(process.channels)}"
    if process.start is not None:
        what += f", from {process.start:.0f} to {process.stop:.0f} s"
    else:
        what += f", all the time from 0 to {duration:.0f} s"
    return what


def _names(channels: tuple[str, ...]) -> str:
    return ", ".join(channels)


def _sd(family: list[Source], name: str) -> float:
    """Standard deviation of a channel's amplitude, from its best line."""
    return min((s.sd[name] for s in family if name in s.sd), default=0.0)


def _merged(bands: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Bands in order, those that meet joined."""
    out: list[tuple[float, float]] = []
    for low, high in sorted(bands):
        if out and low <= out[-1][1]:
            out[-1] = (out[-1][0], max(high, out[-1][1]))
        else:
            out.append((low, high))
    return out
