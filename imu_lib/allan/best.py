"""One coefficient of each kind from a record's Allan curve, by the joint fit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from imu_lib.allan.confidence import interval
from imu_lib.allan.deviation import AllanCurve, deviation
from imu_lib.allan.fit import AllanFit, fit_best
from imu_lib.allan.flat import flat_time
from imu_lib.allan.read_off import FLAT
from imu_lib.arrays import Array
from imu_lib.estimate import Estimate
from imu_lib.processes import (
    Flicker,
    GaussMarkov,
    Quantization,
    Ramp,
    RandomWalk,
    Stage,
    Sum,
    WhiteNoise,
)

_FAST, _SLOW = Quantization() + WhiteNoise(), RandomWalk() + Ramp()
#: Relative error of a model's Allan variance that is allowed, taken in turn.
DISCREPANCIES = (0.0, 0.01, 0.03, 0.1, 0.3)
#: What is tried, in this order: the standard's five terms, a Gauss-Markov process for the flicker,
#: both.
TEMPLATES = (
    _FAST + Flicker() + _SLOW,
    _FAST + GaussMarkov() + _SLOW,
    _FAST + Flicker() + GaussMarkov() + _SLOW,
)


def short_filter(curve: AllanCurve) -> float | None:
    """Averaging time, s, from which an on-chip filter no longer shapes the curve; None where there
    is none to see.

    White noise falls as 1/tau from the first sample on; a filtered one begins flatter. Where the
    curve begins flatter than tau^-0.85 and then turns to -0.6 or steeper within 64 samples, that
    turn is the filter's length.
    """
    octaves = [i for i in range(curve.m.size) if 2 * curve.m[i] in curve.m and curve.m[i] <= 64]
    slopes = np.array(
        [
            np.log2(curve.avar[np.searchsorted(curve.m, 2 * curve.m[i])] / curve.avar[i])
            for i in octaves
        ]
    )
    if (
        slopes.size < 3
        or curve.m[octaves[0]] > 1
        or slopes[0] < -0.85
        or not (slopes <= -0.6).any()
    ):
        return None
    turn = int(np.argmax(slopes <= -0.6))
    return float(curve.tau[octaves[turn]]) if slopes[turn:].min() < slopes[0] - 0.05 else None


def fit_any(
    curve: AllanCurve, *, templates: Sequence[Sum] = TEMPLATES, stages: Sequence[Stage] = ()
) -> AllanFit:
    """The best of the usual sums by criterion, an on-chip filter allowed for: an AllanFit.

    `stages` (a known low-pass filter) enter every sum; without them the curve is used from where
    it looks unfiltered.
    """
    start = None if stages else short_filter(curve)
    sums = [Sum(t.terms, tuple(stages)) for t in templates]
    return fit_best(
        curve,
        sums,
        shortest=start or 0.0,
        filtered=start is not None,
        enough=np.inf,
        discrepancies=DISCREPANCIES,
    )


def characterise(x: Array, fs: float, *, stages: Sequence[Stage] = ()) -> dict[str, Estimate]:
    """N, B, K, Q, R of a record by a joint fit to its Allan curve.

    B is the flat level over 0.664, of flicker or of a Gauss-Markov process where that makes the
    curve flat. Where no sum describes the curve within its scatter, the model itself is granted an
    error (`DISCREPANCIES`), which widens the intervals.

    Parameters
    ----------
    x : array_like, shape (n,)
        Samples; values that are not finite are missing.
    fs : float
        Sampling rate, Hz.
    stages : sequence of Stage
        A low-pass filter that is known, complete.

    Returns
    -------
    dict of str to Estimate
    """
    curve = deviation(x, fs)
    if curve.tau[-1] * fs < 0.05 * curve.samples:  # scattered gaps leave no whole long cluster
        curve = deviation(x, fs, present=0.8)
    return from_curve(curve, stages=stages)


def from_curve(curve: AllanCurve, *, stages: Sequence[Stage] = ()) -> dict[str, Estimate]:
    """`characterise` on a curve that is there."""
    best = fit_any(curve, stages=stages)
    out = {symbol: best[symbol] for symbol in ("N", "K", "Q", "R")}
    bump = "sigma" in best.parameters and best["sigma"].shown
    if bump and _is_flat(best):
        out["B"] = best.flat.scaled(1 / FLAT)
    elif "B" in best.parameters and best["B"].shown:
        out["B"] = best["B"]
    else:
        out["B"] = Estimate.absent(
            float(np.nanmin(interval(curve.adev, curve.edf, level=0.9)[1])) / FLAT
        )
    return {symbol: out[symbol] for symbol in ("N", "B", "K", "Q", "R")}


def _is_flat(found: AllanFit) -> bool:
    """Whether the fitted deviation really has a flat part at the process's bump: slope below 0.15
    either way.
    """
    tau = flat_time(found.model, found.tau[0], found.tau[-1]) * np.array([0.9, 1.1])
    return abs(0.5 * np.diff(np.log(found.model.avar(tau)))[0] / np.log(1.1 / 0.9)) < 0.15
