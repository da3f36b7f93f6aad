"""Is the clock right? Only a line of known frequency tells: one that the given model has, or the
mains with its multiples. Every frequency and time of a record is off by as much as its clock.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from imu_lib.arrays import Array
from imu_lib.gap.steps import Step, detected
from imu_lib.likelihood.tapered import taper
from imu_lib.model import Model
from imu_lib.processes import Sinusoid, Vibration
from imu_lib.record import Record
from imu_lib.samples.imputation import first_fill
from imu_lib.vibrations.forest import level_of
from imu_lib.vibrations.mains import MAINS

#: Share by which a clock may be off, and by which the mains are (EN 50160: 1 % in 99.5 % of a year,
#: in minutes a tenth of that).
MOST, MAINS_OFF = 0.05, 2e-3
#: Multiples of the mains that are looked for, and how many have to be there.
MULTIPLES, LEAST = 6, 3
#: Power over the surroundings, and that of the known amplitude, from which on a line is there.
STANDS, SHARE = 25.0, 0.3
#: Ordinates about the common ratio in which a line is looked for, and share of the lines foreseen
#: that have to be there.
NEAR, LINES = 2, 0.5
#: Confidence in a rate on which several lines agree; share by which stamps and the rate of a given
#: model differ from which on it is told, at even odds, where no line says which is right: with its
#: temperature a sensor's own clock moves less.
SURE, CLOCKS, EVEN = 0.95, 5e-3, 0.5
CAUSE = (
    "The sampling clock is not what the file says: an oscillator off its nominal, a rate taken "
    "from the data sheet."
)
WHY = (
    f"neither lines of the given model nor {LEAST} multiples of the mains are in the record, which "
    "would tell"
)


@dataclass(frozen=True)
class Pace:
    """The record at its true rate, the step that says so or None, and why nothing tells or None."""

    record: Record
    step: Step | None
    invisible: str | None


def paced(record: Record, model: Model | None) -> Pace:
    """The record at the rate that lines of known frequency tell: of the given model those of two
    causes at the least, for a single machine may run at another speed.
    """
    off = [] if model is None else _of_model(record, model)
    of = "of the given model"
    if not off:
        off, of = _of_mains(record), "of the mains"
    if not off:
        return Pace(record, _of_stamps(record, model), WHY)
    ratio, resolution = float(np.median([r for r, _, _ in off])), min(s for _, s, _ in off)
    if abs(ratio - 1) < max(3 * resolution, MAINS_OFF if of == "of the mains" else 0.0):
        return Pace(record, None, None)
    if np.ptp([r for r, _, _ in off]) > 4 * max(s for _, s, _ in off):
        return Pace(record, None, f"lines {of} do not agree on a rate")
    if of == "of the given model" and len({cause for _, _, cause in off}) < 2:
        one = (
            f"one cause {of} is at {1 / ratio:.5g} of its frequency: the clock or a machine's speed"
        )
        return Pace(record, None, one)
    return Pace(_at(record, ratio), _step(ratio, resolution, len(off), of), None)


def _of_stamps(record: Record, model: Model | None) -> Step | None:
    """A step at even odds where the stamps tell another rate than the given model was made at."""
    if model is None or not model.rate or not CLOCKS < abs(record.rate / model.rate - 1) < MOST:
        return None
    return detected(
        "rate_error",
        {"ratio": record.rate / model.rate},
        f"timing: the record is at {record.rate:.5g} Hz, the given model at {model.rate:.5g} Hz; "
        "no line of known frequency tells which of the two clocks is right",
        EVEN,
        cause=CAUSE,
    )


def _of_model(record: Record, model: Model) -> list[tuple[float, float, int]]:
    """(true rate over the stated one, its resolution, number of the cause) of each line that is
    there, at the one ratio at which most of them are; empty where most are at none.
    """
    known = _known(record, model)
    if not known:
        return []
    spectra = {c: _spectrum(record.channels[c], record) for c in {c for c, _, _, _ in known}}
    common = _common(known, spectra, record)
    found, foreseen = [], 0
    for c, f, a, cause in known:
        r = _ratio(*spectra[c], f, a, record, near=common)
        foreseen += r is not None or _foreseen(*spectra[c], f / common, a, record)
        found += [] if r is None else [(*r, cause)]
    return found if len(found) > LINES * foreseen else []


def _common(
    known: list[tuple[str, float, float, int]],
    spectra: dict[str, tuple[Array, Array]],
    record: Record,
) -> float:
    """The ratio at which the known lines together stand out the most."""
    top = max(f for _, f, _, _ in known)
    step = record.rate / record.n
    trials = 1.0 + np.arange(-MOST, MOST, 0.5 * step / top)
    total = np.zeros(len(trials))
    for c, f, _, _ in known:
        over = spectra[c][0]
        at = np.clip(np.rint(f / trials / step).astype(int), 0, len(over) - 1)
        total += np.log(np.maximum(over[at], 1.0))
    return float(trials[int(np.argmax(total))])


def _foreseen(over: Array, amplitude: Array, f: float, size: float, record: Record) -> bool:
    """Whether a line of that size at `f` Hz would stand out."""
    at = min(int(round(f * record.n / record.rate)), len(over) - 1)
    return bool((size / amplitude[at]) ** 2 * over[at] > 2 * STANDS)


def _at(record: Record, ratio: float) -> Record:
    time = None if record.time is None else record.time / ratio
    return replace(record, rate=record.rate * ratio, time=time)


def _known(record: Record, model: Model) -> list[tuple[str, float, float, int]]:
    """(channel, frequency in Hz, amplitude, number of the cause) of the narrow lines of a model."""
    out = [
        (c, t.frequency, t.amplitude, id(t))
        for c in record.channels
        if c in model
        for t in model[c].terms
        if isinstance(t, Sinusoid)
    ]
    for p in model.record:
        if isinstance(p, Vibration) and p.bandwidth < 1e-4 * p.frequency and p.start is None:
            out += [
                (c, float(f), a * w, id(p))
                for c, a in zip(p.channels, p.amplitude)
                if c in record.channels
                for f, w in zip(p.frequencies, p.shape)
                if w > 0.3
            ]
    return [line for line in out if line[1] > 0.02 * record.rate]


def _spectrum(x: Array, record: Record) -> tuple[Array, Array]:
    """(power over its surroundings, amplitude of a line of that power) at the ordinates."""
    x = first_fill(x, np.isnan(x))
    power = np.abs(np.fft.rfft(taper(len(x)) * (x - np.mean(x)))) ** 2
    return power / level_of(power), 2.0 * np.sqrt(power) / len(x)


def _ratio(
    over: Array, amplitude: Array, f: float, size: float, record: Record, near: float | None = None
) -> tuple[float, float] | None:
    """(true rate over the stated one, its resolution) from one line, or None; `near` a ratio, or
    any.
    """
    step = record.rate / (2 * (len(over) - 1))
    low, high = (int(f / step / (1 + s * MOST)) for s in (1, -1))
    if near is not None:
        low, high = int(f / step / near) - NEAR, int(f / step / near) + NEAR + 2
    high = min(high, len(over) - 3)
    if high - low < 3:
        return None
    at = low + int(np.argmax(over[low:high]))
    if over[at] < STANDS or not SHARE * size < amplitude[at] < size / SHARE:
        return None
    return f / _peak(over, at) / step, 0.5 / at


def _peak(over: Array, at: int) -> float:
    """Place of a maximum between ordinates."""
    left, middle, right = np.log(over[at - 1 : at + 2] + 1e-12)
    return at + 0.5 * (left - right) / min(left - 2 * middle + right, -1e-9)


def _of_mains(record: Record) -> list[tuple[float, float, int]]:
    """As above, of several multiples of the mains in one channel."""
    if LEAST * min(MAINS) > 0.48 * record.rate:
        return []
    for x in record.channels.values():
        over, _ = _spectrum(x, record)
        step = record.rate / (2 * (len(over) - 1))
        for base in MAINS:
            found = []
            for k in range(1, MULTIPLES + 1):
                r = _ratio(over, np.ones(len(over)), k * base, 1.0, record)
                found += [] if r is None or k * base > 0.48 * record.rate else [(r, k)]
            agree = [(*r, k) for r, k in found if abs(r[0] - found[0][0][0]) < 2 * step / base]
            if len(agree) >= LEAST:
                return agree
    return []


def _step(ratio: float, resolution: float, count: int, of: str) -> Step:
    return detected(
        "rate_error",
        {"ratio": ratio},
        f"power spectral density: {count} lines {of} at {1 / ratio:.5g} of the frequency that they "
        "should have; the rate is corrected in what follows",
        SURE,
        intervals={"ratio": [ratio - 2 * resolution, ratio + 2 * resolution]},
        rival="vibration",
        cause=CAUSE,
        evidence=f"{count} lines {of}",
    )
