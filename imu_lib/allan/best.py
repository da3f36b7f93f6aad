"""One coefficient of each kind from a record's Allan curve, by the joint fit."""

from __future__ import annotations

import numpy as np

from imu_lib.allan.deviation import deviation
from imu_lib.allan.fit import fit_best
from imu_lib.allan.read_off import FLAT
from imu_lib.estimate import Estimate
from imu_lib.processes import Flicker, GaussMarkov, Quantization, Ramp, RandomWalk, Sum, WhiteNoise

_FAST, _SLOW = Quantization() + WhiteNoise(), RandomWalk() + Ramp()
#: What is tried, in this order: the standard's five terms, a Gauss-Markov process for the flicker, both.
TEMPLATES = (_FAST + Flicker() + _SLOW, _FAST + GaussMarkov() + _SLOW, _FAST + Flicker() + GaussMarkov() + _SLOW)


def short_filter(curve):
    """Averaging time, s, from which an on-chip filter no longer shapes the curve; None where there is none to see.

    White noise falls as 1/tau from the first sample on; a filtered one begins flatter. Where the curve begins flatter
    than tau^-0.85 and then turns to -0.6 or steeper within 64 samples, that turn is the filter's length.
    """
    octaves = [i for i in range(curve.m.size) if 2 * curve.m[i] in curve.m and curve.m[i] <= 64]
    slopes = np.array([np.log2(curve.avar[np.searchsorted(curve.m, 2 * curve.m[i])] / curve.avar[i]) for i in octaves])
    if slopes.size < 3 or curve.m[octaves[0]] > 1 or slopes[0] < -0.85 or not (slopes <= -0.6).any():
        return None
    turn = int(np.argmax(slopes <= -0.6))
    return float(curve.tau[octaves[turn]]) if slopes[turn:].min() < slopes[0] - 0.05 else None


def fit_any(curve, *, templates=TEMPLATES, stages=()):
    """The best of the usual sums by criterion, an on-chip filter allowed for: an AllanFit.

    `stages` (a known low-pass filter) enter every sum; without them the curve is used from where it looks unfiltered.
    """
    if stages:
        return fit_best(curve, [Sum(t.terms, tuple(stages)) for t in templates], enough=np.inf)
    start = short_filter(curve)
    return fit_best(curve, templates, shortest=start or 0.0, filtered=start is not None, enough=np.inf)


def characterise(x, fs, *, stages=()):
    """N, B, K, Q, R of a record by a joint fit to its Allan curve.

    B is the flat level over 0.664, of flicker or of whatever makes the curve flat. Where even the best sum does not
    describe the curve, the intervals are widened by the root of misfit over degrees of freedom.

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
    best = fit_any(curve, stages=stages)
    out = {symbol: best[symbol] for symbol in ("N", "K", "Q", "R")}
    if "B" in best.parameters and best["B"].shown:
        out["B"] = best["B"]
    elif "sigma" in best.parameters and best["sigma"].shown:
        out["B"] = best.flat.scaled(1 / FLAT)
    else:
        out["B"] = best.parameters.get("B") or Estimate.absent(best.flat.high / FLAT)
    widen = max(1.0, best.misfit / best.dof) ** 0.5
    return {symbol: _widened(out[symbol], widen) for symbol in ("N", "B", "K", "Q", "R")}


def _widened(estimate, factor):
    if not estimate.shown or factor == 1.0:
        return Estimate(estimate.value, estimate.low, estimate.high * (1.0 if estimate.shown else factor))
    return Estimate(estimate.value, estimate.value * (estimate.low / estimate.value) ** factor,
                    estimate.value * (estimate.high / estimate.value) ** factor)
