"""Two models, two records of one sensor, or a record and a model, side by side: at every averaging
time and by coefficient.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from imu_lib import allan, passes, scheduler
from imu_lib.estimate import Z95, Estimate
from imu_lib.long_record import LongRecord
from imu_lib.model import Model
from imu_lib.record import Record


@dataclass(frozen=True)
class Curve:
    """Allan deviation at common averaging times with its 95 % interval; a model's interval is a
    point.
    """

    adev: np.ndarray
    low: np.ndarray
    high: np.ndarray


@dataclass(frozen=True)
class Channel:
    """One channel of both. ratio: a over b with its 95 % interval; differs: whether the interval
    excludes 1 after correction for the number of averaging times looked at. coefficients: name ->
    (a, b), an Estimate, a number, or None where one has no such term. mean, sd: of records."""

    tau: np.ndarray
    a: Curve
    b: Curve
    ratio: np.ndarray
    low: np.ndarray
    high: np.ndarray
    differs: np.ndarray
    coefficients: Mapping[str, tuple]
    mean: tuple[float | None, float | None]
    sd: tuple[float | None, float | None]

    def to_json(self) -> dict:
        keys = ("tau", "ratio", "low", "high", "differs", "mean", "sd")
        return {k: getattr(self, k) for k in keys} | {
            "adev": {"a": self.a.adev, "b": self.b.adev},
            "coefficients": {k: {"a": v[0], "b": v[1]} for k, v in self.coefficients.items()},
        }


@dataclass(frozen=True)
class Comparison:
    """a, b: what was compared. channels: those that both have. only: the channels that one alone
    has.
    """

    a: str
    b: str
    channels: Mapping[str, Channel]
    only: tuple[str, ...]

    def to_json(self) -> dict:
        return {"a": self.a, "b": self.b, "only": self.only, "channels": dict(self.channels)}


@dataclass(frozen=True)
class Side:
    """What one of the two says of a channel: its curve at the common averaging times, its
    coefficients, mean and standard deviation of a record.
    """

    curve: Curve
    coefficients: Mapping[str, object]
    mean: float | None = None
    sd: float | None = None


def compare(
    a: Record | LongRecord | Model,
    b: Record | LongRecord | Model,
    *,
    rate: float | None = None,
    per_decade: int = 2,
    tell=lambda fits, total: fits,
) -> Comparison:
    """Lay two side by side.

    Records contribute their overlapped Allan deviation and its joint fit, models their closed form
    and parameters. A record on disk is read by pieces, of its longest part without a gap, and is
    never held.

    Parameters
    ----------
    a, b : Record, LongRecord or Model
        Records at rest, or error models.
    rate : float, optional
        Hz at which two models are sampled; their own, else the continuous limit.
    per_decade : int
        Averaging times.
    tell : callable
        Wraps the running fits, to show progress.

    Raises
    ------
    ValueError
        Where they have no channel in common.
    InputError
        Where a record is too short.
    """
    common = [c for c in a.channel_names if c in b.channel_names]
    if not common:
        raise ValueError(
            f"`a` and `b` have no channel in common: {', '.join(a.channel_names)} against "
            f"{', '.join(b.channel_names)}"
        )
    rates = [x.rate for x in (a, b) if x.rate] or [rate]
    fs = max((r for r in rates if r), default=None)
    span = min([_span(x) for x in (a, b) if not isinstance(x, Model)], default=1e5)
    first = 1.0 / min(r for r in rates if r) if fs else 1e-2
    decades = np.log10(max(span / 6, 2 * first) / first)
    tau = first * 10.0 ** (np.arange(int(decades * per_decade) + 1) / per_decade)
    parts = [x.enough().uniform() if isinstance(x, Record) else x for x in (a, b)]
    jobs = [(i, c) for c in common for i, x in enumerate(parts) if not isinstance(x, Model)]
    tasks = [(_task(parts[i], c), c, tau, i) for i, c in jobs]
    many = sum(parts[i].n for i, _ in jobs) > 100_000
    workers = min(len(jobs), scheduler.cores()) if many else 1
    sides = {}
    if jobs:
        for i, c, side in tell(scheduler.shared(_side, tasks, workers), total=len(jobs)):
            sides[i, c] = side
    for i, x in enumerate(parts):
        if isinstance(x, Model):
            sides |= {(i, c): _of_model(x[c], tau, rate or fs) for c in common}
    channels = {c: _channel(tau, sides[0, c], sides[1, c]) for c in common}
    only = tuple(
        c for x, y in ((a, b), (b, a)) for c in x.channel_names if c not in y.channel_names
    )
    return Comparison(a.name or a.source, b.name or b.source, channels, only)


def _span(x) -> float:
    """Seconds of a record that its averaging times may come from."""
    return x.longest / x.rate if isinstance(x, LongRecord) else x.duration


def _task(x, channel):
    """What a process needs of a record for one channel."""
    return x if isinstance(x, LongRecord) else Record({channel: x[channel]}, x.rate)


def _side(x, channel, tau, place) -> tuple[int, str, Side]:
    """One channel of a record."""
    if isinstance(x, LongRecord):
        whole = passes.over(x.pieces(channel, x.continuous()), x.longest, x.rate)
        curve, mean, sd = whole.allan(), whole.mean, float(np.sqrt(max(whole.variance, 0.0)))
        coefficients = _asked(allan.from_curve, curve)
    else:
        y = x[channel]
        curve = allan.deviation(y, x.rate, taus=tau)
        mean, sd = float(np.nanmean(y)), float(np.nanstd(y))
        coefficients = _asked(allan.characterise, y, x.rate)
    return place, channel, Side(_at(curve, tau), coefficients, mean, sd)


def _asked(method, *args) -> dict:
    """The coefficients of a channel; none where it is too short for a fit, or never changes: the
    curves stand alone then.
    """
    try:
        return {k: v for k, v in method(*args).items() if isinstance(v, Estimate)}
    except ValueError:
        return {}


def _at(curve, tau) -> Curve:
    """The nearest averaging times of a record's own, which have to be whole samples."""
    out = np.full((3, len(tau)), np.nan)
    for i, t in enumerate(tau):
        j = curve.at(t)
        if abs(curve.tau[j] / t - 1) < 0.26:
            # slid along a slope of at most one per octave the value changes less than its
            # interval at these few-sample clusters
            out[:, i] = curve.adev[j], curve.low[j], curve.high[j]
    return Curve(*out)


def _channel(tau, a: Side, b: Side) -> Channel:
    ca, cb = a.curve, b.curve
    good = np.isfinite(ca.adev) & np.isfinite(cb.adev) & (ca.adev > 0) & (cb.adev > 0)
    tau = tau[good]
    ca, cb = (Curve(c.adev[good], c.low[good], c.high[good]) for c in (ca, cb))
    # the two are independent: their logarithmic half widths add in quadrature
    up = np.hypot(np.log(ca.high / ca.adev), np.log(cb.adev / cb.low))
    down = np.hypot(np.log(ca.adev / ca.low), np.log(cb.high / cb.adev))
    log = np.log(ca.adev / cb.adev)
    from scipy.stats import norm

    # as many questions as averaging times: Bonferroni's correction keeps the false alarms of a
    # channel at 5 %
    wider = norm.ppf(1 - 0.025 / max(1, len(tau))) / Z95
    return Channel(
        tau,
        ca,
        cb,
        np.exp(log),
        np.exp(log - down),
        np.exp(log + up),
        (log - wider * down > 1e-9) | (log + wider * up < -1e-9),
        _coefficients(a.coefficients, b.coefficients),
        (a.mean, b.mean),
        (a.sd, b.sd),
    )


def _of_model(entry, tau, fs) -> Side:
    """One channel of a model."""
    adev = np.sqrt(np.asarray(entry.avar(tau, fs), dtype=float))
    parameters, seen = {}, {}
    for process in (*entry.terms, *entry.stages):
        for key, value in process.to_json().items():
            if key == "process" or not isinstance(value, (int, float)):
                continue
            label = key if key in ("N", "Q", "B", "K", "R") else f"{process.name}.{key}"
            seen[label] = seen.get(label, 0) + 1
            parameters[label if seen[label] == 1 else f"{label}_{seen[label]}"] = float(value)
    return Side(Curve(adev, adev, adev), parameters)


def _coefficients(a: dict, b: dict) -> dict:
    return {k: (a.get(k), b.get(k)) for k in [*a, *(k for k in b if k not in a)]}
