"""Two models, two records of one sensor, or a record and a model, side by side: at every averaging
time and by coefficient.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from joblib import Parallel, delayed

from imu_lib import allan
from imu_lib.estimate import Z95, Estimate
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
    excludes 1 after correction for
    the number of
    averaging times looked at. coefficients: name -> (a, b), an Estimate, a number, or None where
    one has no such term. mean, sd:
    of records."""

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


def compare(
    a: Record | Model,
    b: Record | Model,
    *,
    rate: float | None = None,
    per_decade: int = 2,
    tell=lambda fits, total: fits,
) -> Comparison:
    """Lay two side by side.

    a, b: records at rest or error models. rate: Hz at which two models are sampled (their own,
    else the continuous limit).
    Records contribute their overlapped Allan deviation and its joint fit, models their closed form
    and parameters.
    tell: wraps the running fits, to show progress. ValueError where they have no channel in
    common, InputError where a record is too short.
    """
    common = [c for c in a.channel_names if c in b.channel_names]
    if not common:
        raise ValueError(
            f"`a` and `b` have no channel in common: {', '.join(a.channel_names)} against {', '.join(b.channel_names)}"
        )
    rates = [x.rate for x in (a, b) if x.rate] or [rate]
    fs = max((r for r in rates if r), default=None)
    span = min([x.duration for x in (a, b) if isinstance(x, Record)], default=1e5)
    first = 1.0 / min(r for r in rates if r) if fs else 1e-2
    decades = np.log10(max(span / 6, 2 * first) / first)
    tau = first * 10.0 ** (np.arange(int(decades * per_decade) + 1) / per_decade)
    parts = [x.enough().uniform() if isinstance(x, Record) else x for x in (a, b)]
    jobs = [(x, c) for c in common for x in parts if isinstance(x, Record)]
    workers = min(len(jobs), os.cpu_count() or 1) if sum(x.n for x, _ in jobs) > 100_000 else 1
    fits = Parallel(n_jobs=workers, return_as="generator")(
        delayed(_fit)(x[c], x.rate) for x, c in jobs
    )
    fitted = {(id(x), c): found for (x, c), found in zip(jobs, tell(fits, total=len(jobs)))}
    channels = {c: _channel(c, *parts, tau, rate or fs, fitted) for c in common}
    only = tuple(
        c for x, y in ((a, b), (b, a)) for c in x.channel_names if c not in y.channel_names
    )
    return Comparison(a.name or a.source, b.name or b.source, channels, only)


def _fit(x, fs) -> dict:
    """The coefficients of a channel; none where it is too short for a fit, or never changes: the
    curves stand alone then.
    """
    try:
        return allan.characterise(x, fs)
    except ValueError:
        return {}


def _channel(name, a, b, tau, fs, fitted) -> Channel:
    measured = [_curve(x, name, tau, fs, fitted) for x in (a, b)]
    ca, cb = (m[0] for m in measured)
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
    differs = (log - wider * down > 1e-9) | (log + wider * up < -1e-9)
    return Channel(
        tau,
        ca,
        cb,
        np.exp(log),
        np.exp(log - down),
        np.exp(log + up),
        differs,
        _coefficients(*(m[1] for m in measured)),
        *(
            tuple(float(f(x[name])) if isinstance(x, Record) else None for x in (a, b))
            for f in (np.nanmean, np.nanstd)
        ),
    )


def _curve(x, name, tau, fs, fitted):
    """(Curve at tau, coefficients) of a record or a model."""
    if isinstance(x, Record):
        # a step has to be whole samples: the nearest averaging times of the record's own
        curve = allan.deviation(x[name], x.rate, taus=tau)
        out = np.full((3, len(tau)), np.nan)
        for i, t in enumerate(tau):
            j = curve.at(t)
            if abs(curve.tau[j] / t - 1) < 0.26:
                # slid along a slope of at most one per octave the value changes less than its
                # interval at these few-sample clusters
                out[:, i] = curve.adev[j], curve.low[j], curve.high[j]
        return Curve(*out), {
            k: v for k, v in fitted[id(x), name].items() if isinstance(v, Estimate)
        }
    adev = np.sqrt(np.asarray(x[name].avar(tau, fs), dtype=float))
    parameters, seen = {}, {}
    for process in (*x[name].terms, *x[name].stages):
        for key, value in process.to_json().items():
            if key == "process" or not isinstance(value, (int, float)):
                continue
            label = key if key in ("N", "Q", "B", "K", "R") else f"{process.name}.{key}"
            seen[label] = seen.get(label, 0) + 1
            parameters[label if seen[label] == 1 else f"{label}_{seen[label]}"] = float(value)
    return Curve(adev, adev, adev), parameters


def _coefficients(a: dict, b: dict) -> dict:
    return {k: (a.get(k), b.get(k)) for k in [*a, *(k for k in b if k not in a)]}
