"""What a given model has and the record has not: told, and left out of what is grown.

An effect that adds power can be missing only where the record has clearly less power than the
effect alone would put there; what is too weak to be told either way stays in the model.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.stats import norm

from imu_lib.arrays import Array
from imu_lib.gap.coherence import Cross
from imu_lib.gap.effects.base import Finding
from imu_lib.gap.effects.jitter import Jitter, is_even
from imu_lib.gap.effects.time_gaps import TimeGaps
from imu_lib.gap.shared_noise import let_through
from imu_lib.model import Model
from imu_lib.processes import CommonMode, Process, Sinusoid, Spikes, Sum, Vibration
from imu_lib.record import Record
from imu_lib.samples.imputation import first_fill
from imu_lib.units import si_unit

#: Share of the power that an effect would put into the record below which it is not there.
THERE = 0.25
#: Share of that power in the bins that are looked at, bins that leakage spreads a line over, and
#: draws of the effect.
MAIN, LEAKS, DRAWS = 0.9, 5, 8
#: Standard deviations that an estimate of noise in common is allowed, and share of its density
#: below which it is not there.
SURE, HALF = 3.0, 0.5
#: Deviations of the noise from which on a sample is a spike, and such spikes that have to be due.
FAR, DUE = 6.0, 20.0
#: Frequencies within this share of each other are of one vibration, whatever its amplitude.
ONE = 0.02
#: What `faults` finds by the same name.
HAPPENED = ("dropout", "disturbance", "tilt")


@dataclass(frozen=True)
class Absent:
    """A process of the given model that the record does not have on `channels` (none: it acts on
    the clock), `why` in words; `term` where it is a channel's own.
    """

    process: Process
    channels: tuple[str, ...]
    why: str
    term: bool = False

    def to_json(self) -> dict[str, Any]:
        entry = self.process.to_json()
        effect = entry.pop("process", self.process.name)
        return {
            "effect": effect,
            "parameters": entry,
            "channels": list(self.channels),
            "level": "channel" if self.term else "record",
            "why": self.why,
        }


def of_faults(model: Model, findings: Iterable[Any], record: Record) -> list[Absent]:
    """Faults of the data and of the clock that the model holds and nothing was found of."""
    kinds, out = {f.kind for f in findings}, []
    for p in model.record:
        clock = next((e for e in (TimeGaps(), Jitter()) if e.name == p.name), None)
        gone = p.name in HAPPENED and p.name not in kinds
        if clock is not None:
            found = clock.detect(record)
            gone = "burst" not in kinds and (found is None or is_even(found, record.rate))
        if gone:
            channels = tuple(c for c in getattr(p, "channels", ()) if c in record)
            out.append(Absent(p, channels, "nothing of it was found"))
    return out


def of_vibrations(
    model: Model, found: list[Finding], raw: dict[str, Array], fs: float
) -> list[Absent]:
    """Vibrations of the model that the record has not, or has not on all of their channels."""
    out = []
    for p in model.record:
        if not isinstance(p, Vibration) or any(one(f, p) and f.held for f in found):
            continue
        here = tuple(c for c in p.channels if c in raw)
        if any(one(f, p) for f in found):
            out.append(Absent(p, here, "the record has another one there, which is named"))
            continue
        shares = {c: _share(_of_channel(p, c), raw[c], fs) for c in here}
        gone = tuple(c for c, share in shares.items() if share < THERE)
        own = {c: np.sqrt(shares[c]) * p.amplitude[p.channels.index(c)] for c in gone}
        if gone:
            least = ", ".join(f"{own[c]:.2g} {si_unit('amplitude', c)} on {c}" for c in gone)
            out.append(Absent(p, gone, f"at {p.frequency:.4g} Hz its amplitude is below {least}"))
    return out


def one(found: Finding, held: Vibration) -> bool:
    """Whether a finding is a vibration of the given model, be it of another amplitude or of a
    frequency that the other one's wanders to.
    """
    p = found.process
    slack = max(held.bandwidth, p.bandwidth, ONE * held.frequency)
    near = abs(p.frequency - held.frequency) < slack
    near |= _wanders_to(p, held.frequency) or _wanders_to(held, p.frequency)
    return near and bool(set(p.channels) & set(held.channels))


def _wanders_to(p: Vibration, frequency: float) -> bool:
    """Whether the measured profile of a vibration holds a frequency, Hz."""
    at = p.profile_frequency
    return at is not None and min(at) <= frequency <= max(at)


def _of_channel(p: Vibration, name: str) -> Callable[[int, float, np.random.Generator], Array]:
    own = p.of(name)
    assert own is not None
    return lambda n, fs, rng: own.on(n, fs, rng)[name]


def of_lines(model: Model, raw: dict[str, Array], fs: float) -> list[Absent]:
    """Lines of unknown phase of single channels that these have not: those of a known one are
    found as their opposite.
    """
    out = []
    for name, x in raw.items():
        for t in model[name].terms if name in model else ():
            if not isinstance(t, Sinusoid) or t.phase is not None:
                continue
            behind = tuple(s for s in (model[name].low_pass,) if s is not None)
            share = _share(Sum((t,), behind).simulate, x, fs)
            if share < THERE:
                least = np.sqrt(share) * t.amplitude
                unit = si_unit("amplitude", name)
                why = f"at {t.frequency:.4g} Hz its amplitude is below {least:.2g} {unit}"
                out.append(Absent(t, (name,), why, term=True))
    return out


def of_spikes(model: Model, raw: dict[str, Array], fs: float) -> list[Absent]:
    """Spikes of single channels of which far too few are there."""
    out = []
    for name, x in raw.items():
        p = model[name].find("spikes") if name in model else None
        if not isinstance(p, Spikes):
            continue
        apart = x[1:-1] - 0.5 * (x[:-2] + x[2:])
        apart = apart[~np.isnan(apart)]
        sd = 1.4826 * np.median(np.abs(apart - np.median(apart)))
        due = p.rate * len(x) / fs * 2 * norm.sf(FAR * sd / max(p.scale, 1e-300))
        seen = int(np.sum(np.abs(apart) > FAR * sd))
        if due > DUE and seen < THERE * due:
            why = f"{due:.0f} single samples would stand out, {seen} do"
            out.append(Absent(p, (name,), why, term=True))
    return out


def of_common(model: Model, seen: Cross, fs: float) -> list[Absent]:
    """Noise in common of the model that the channels have not, of which `seen` are the
    cross-spectra.
    """
    held = [p for p in model.record if isinstance(p, CommonMode)]
    held, out = [p for p in held if set(p.channels) & set(seen.names)], []
    quick = slice(0, max(len(seen.f) // 4, 1))  # where filters let all through
    count, level, total = seen.count[quick], seen.level[quick], seen.count[quick].sum()
    mean = np.einsum("b,bij->ij", count / total, seen.matrix[quick]).real
    power = (count / total) @ level
    for p in held:
        at = [i for i, c in enumerate(seen.names) if c in p.channels]
        pairs = [(i, j) for i in at for j in at if i < j]
        if pairs:
            weight = np.array([2 * total / (power[i] * power[j]) for i, j in pairs])
            shared = np.array([mean[i, j] for i, j in pairs])
            most = (weight @ shared) / weight.sum() + SURE / np.sqrt(weight.sum())
        else:  # no other has it: it cannot be more than the noise of the channel
            most = float(power[at[0]] * (1 + SURE / np.sqrt(total)))
        fall = min(_passed(model, seen.names[i], seen.f[quick], fs) for i in at)
        due = 2 * p.N**2 * (fall if p.filtered else 1.0)
        if most < HALF * due:
            names = tuple(seen.names[i] for i in at)
            N = np.sqrt(max(most, 0.0) / due) * p.N
            out.append(Absent(p, names, f"its N is below {N:.2g}, not {p.N:.2g}"))
    return out


def _passed(model: Model, name: str, f: Array, fs: float) -> float:
    """Share of white noise that the filter of a channel lets through at the frequencies `f`."""
    low_pass = model[name].low_pass if name in model else None
    return 1.0 if low_pass is None else float(np.mean(let_through(low_pass, f, fs)))


def _share(draw: Callable[[int, float, np.random.Generator], Array], x: Array, fs: float) -> float:
    """Power of the samples `x` (NaN where one is missing) where an effect has most of its own,
    over what it would put there; infinite where it would put nothing.
    """
    n, rng = len(x), np.random.default_rng(0)
    window = np.hanning(n)

    def power(y: Array) -> np.ndarray:
        bins = np.abs(np.fft.rfft(window * (y - y.mean()))) ** 2
        return np.asarray(uniform_filter1d(bins, LEAKS))

    expected = np.mean([power(draw(n, fs, rng)) for _ in range(DRAWS)], axis=0)
    if not expected.sum() > 0:
        return np.inf
    order = np.argsort(expected)[::-1]
    main = order[: 1 + np.searchsorted(np.cumsum(expected[order]), MAIN * expected.sum())]
    measured = power(first_fill(x, np.isnan(x)))
    return float(measured[main].sum() / expected[main].sum())


def without(model: Model, gone: Iterable[Absent], found: Iterable[Finding] = ()) -> Model:
    """The model less what is absent; its vibrations that were found are those that were found."""
    gone, found = list(gone), [f for f in found if f.held]
    record: list[Process] = []
    taken: list[Finding] = []
    for p in model.record:
        off = next((a for a in gone if not a.term and a.process is p), None)
        own = [f for f in found if isinstance(p, Vibration) and one(f, p)]
        if own:
            record += [f.process for f in own if not any(f is t for t in taken)]
            taken += own
        elif off is None:
            record.append(p)
        elif isinstance(p, Vibration):
            left = [(c, a) for c, a in zip(p.channels, p.amplitude) if c not in off.channels]
            if left:
                names, amplitude = zip(*left)
                record.append(p.with_(channels=names, amplitude=amplitude))
    channels = {n: _less(n, model[n], gone) for n in model.channel_names}
    return replace(model, channels=channels, record=tuple(record))


def _less(name: str, own: Sum, gone: list[Absent]) -> Sum:
    off = [a.process for a in gone if a.term and name in a.channels]
    if not off:
        return own
    terms = tuple(t for t in own.terms if not any(t is p for p in off))
    return Sum(terms, tuple(s for s in own.stages if not any(s is p for p in off)))


def elsewhere(model: Model, channels: Iterable[str]) -> tuple[Model, str | None]:
    """The model without what acts only on channels that the record lacks, and a sentence on it."""
    kept, off, names = [], [], set(channels)
    for p in model.record:
        on = getattr(p, "channels", ())
        if on and not set(on) & names:
            off.append(f"{p.name.replace('_', ' ')} on {', '.join(on)}")
        else:
            kept.append(p)
    if not off:
        return model, None
    said = f"The given model's {'; '.join(off)}: left out, the record has no such channel."
    return replace(model, record=tuple(kept)), said
