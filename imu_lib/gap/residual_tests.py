"""Is anything left? Tests of the residual against the fitted model, each with a p-value and a
sentence of where.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.fft import idct
from scipy.stats import chi2, kurtosistest

from imu_lib.arrays import Array
from imu_lib.gap.check import Check
from imu_lib.gap.data import Data
from imu_lib.gap.normality import SKEW, distribution, log10_normal
from imu_lib.gap.state import State
from imu_lib.gap.stationarity import resonances, stationarity
from imu_lib.likelihood import tapered
from imu_lib.likelihood.evaluate import with_extra
from imu_lib.processes import Quantization, Sum
from imu_lib.samples.innovations import Smooth

#: log10 p below which a disagreement is reported (family-wise 0.5 % per channel over all tests,
#: benchmarks/gap_null.py).
LIMIT = -5.0
#: Effects on single samples or their level: beside one of these what is left of the distribution
#: speaks against that name, however small it is.
OF_SAMPLES = (
    "heavy_tails",
    "noise_level_change",
    "saturation",
    "spikes",
    "stuck",
    "wandering_level",
)
#: Those of them that may be what makes the distribution uneven: the others leave it as even as it
#: was.
ONE_SIDED = ("saturation", "spikes", "stuck")


def weighed(tests: list[Check], named: list[str]) -> tuple[Check, list[str]]:
    """The worst test of those whose disagreement matters, and what the others see beyond chance, in
    words; `named` are the effects that the channel has.
    """
    strict = any(effect in OF_SAMPLES for effect in named)
    uneven = any(effect in ONE_SIDED for effect in named)
    told = {SKEW: uneven, ROLL_OFF: False}
    small = [c for c in tests if c.size < 1.0 and not told.get(c.domain, strict)]
    worst = min((c for c in tests if c not in small), key=lambda c: c.log_p)
    return worst, [c.where for c in small if c.log_p < LIMIT]


def _log10_chi2(value: float | Array, dof: float | Array) -> Any:
    """log10 of the two-sided p-value of chi-square values, far into the tails."""
    upper, lower = chi2.logsf(value, dof), chi2.logcdf(value, dof)
    return (np.minimum(upper, lower) + np.log(2)) / np.log(10)


def spectrum(state: State) -> list[Check]:
    """Bins of the spectrum, singly and in runs of 3, 9 and 27, against the model; those where a
    filter rolls off by themselves. The model's own fit error is allowed for.
    """
    layout, count = state.data.layout, state.problem.stats.count
    seen = (count > 0) & (np.arange(len(count)) >= layout.slow)
    f, low_pass = layout.frequency[seen], state.fit.low_pass
    nu, ratio = count[seen], (state.mean_power / state.fit.expected)[seen]
    begins = np.inf if low_pass is None else CORNER * low_pass.cutoff
    ends = min(0.5 * EDGE * state.data.fs, begins)
    out = [_worst(f[f < ends], nu[f < ends], ratio[f < ends])[0]]
    level = state.fit.expected[seen]
    passed = np.median(level[f < begins] if (f < begins).any() else level)
    down = 10 * np.log10(passed / level)
    gone = (f >= begins) & (down > GONE)
    for part in (gone, (f >= begins) & ~gone, (f >= ends) & (f < begins)):
        if not part.any():
            continue
        found, decibel, at = _worst(f[part], nu[part], ratio[part])
        # at the end what is too low is the filter against folding, what is too high is not
        most = FALLS * (decibel < 0.0)
        if ends == begins:  # the deeper the filter takes the noise down, the less its shape matters
            most = np.inf if part is gone else SHAPE * max(1.0, down[part][at] / DEEP)
        out.append(replace(found, domain=ROLL_OFF, size=abs(decibel) / max(most, 1e-9)))
    return out


def _worst(f: Array, nu: Array, ratio: Array) -> tuple[Check, float, int]:
    """The worst of the bins at `f` Hz of `nu` degrees of freedom and their runs, by how many dB,
    and its first bin.
    """
    worst = Check("psd", 0.0, ""), 0.0, 0
    for width in (w for w in (1, 3, 9, 27) if w <= len(f)):
        kernel = np.ones(width)
        dof = np.convolve(nu, kernel, "valid")
        excess = np.convolve(nu * ratio, kernel, "valid")
        # rounding, sampling and windows limit any model spectrum to about a percent
        z = (excess / dof - 1.0) / np.sqrt(2.0 / dof + MODEL**2)
        wilson = dof * (1.0 + z * np.sqrt(2.0 / dof)).clip(1e-6)
        p = _log10_chi2(wilson, dof)
        i = int(np.argmin(p))
        corrected = p[i] + np.log10(len(nu))
        if corrected < worst[0].log_p:
            decibel = float(10 * np.log10(excess[i] / dof[i]))
            where = (
                f"power spectral density between {f[i]:.3g} and "
                f"{f[min(i + width, len(f)) - 1]:.3g} Hz, "
                f"{decibel:+.2g} dB from the fitted model"
            )
            worst = Check("psd", float(corrected), where), decibel, i
    return worst


#: Domain of the bins where a filter rolls off; share of its cutoff from which on it does, and of
#: half the sampling rate from which on what is too low is its end; dB that its shape there may
#: differ from the catalogue's (a ripple, another order), and that such an end may fall.
ROLL_OFF, CORNER, EDGE, SHAPE, FALLS = "roll-off", 0.7, 0.96, 1.5, 6.0
#: dB by which a filter takes the noise down beyond which its shape may differ by more, and where a
#: thousandth is left, of which the shape matters to nobody.
DEEP, GONE = 10.0, 30.0
#: Relative accuracy that is asked of a model spectrum.
MODEL = 0.004


def bias(state: State) -> list[Check]:
    """The slow cosine coefficients over their expectation, and the bias of which they are the
    transform: size, colour, outliers.
    """
    data, fit = state.cleaned, state.fit
    white = 1.0 / np.sqrt(data.stats.slow_ordinates(fit.expected))
    columns, curves = state.assembly.matrix, _curves(data)
    columns = np.zeros((data.orders, 0)) if columns is None else columns
    e = white[:, None] * np.column_stack([data.cosines, columns, curves])
    own = 1 + columns.shape[1]
    r = e[:, 0] - e[:, 1:own] @ fit.beta
    n = len(r)
    out = [
        Check(
            "allan",
            float(_log10_chi2(r @ r, n)),
            "bias over the whole record: its innovations are larger or smaller than the model's",
        )
    ]
    for width in (2, 10, 40, 120):
        if width > n // 2:
            continue
        total = np.convolve(r**2, np.ones(width), "valid")
        lp = _log10_chi2(total, width)
        i = int(np.argmin(lp))
        f = np.array([i + 1, i + width]) / (2 * data.duration)
        decibel = 10 * np.log10(total[i] / width)
        out.append(
            Check(
                "allan",
                float(lp[i] + np.log10(n)),
                f"slow variation with periods of {1 / f[1]:.4g} to {1 / f[0]:.4g} s, "
                f"{decibel:+.2g} dB from the fitted model",
            )
        )
    bare = idct(np.concatenate([[0.0], r]), norm="ortho")  # the bias in time, white
    j = int(np.argmax(np.abs(bare)))
    out.append(
        Check(
            "mean",
            float(log10_normal(bare[j]) + np.log10(n)),
            f"mean of the signal: an unforeseen jump near {(j + 0.5) / n * data.duration:.0f} s",
        )
    )
    # Anscombe and Glynn (1983): normal also where the record has few blocks
    heavy = max(float(kurtosistest(bare).statistic), 0.0)
    out.append(
        Check(
            "mean",
            float(log10_normal(heavy)),
            "mean of the signal: its jumps are not normally distributed",
        )
    )
    if curves.shape[1]:
        out.append(_bent(r, e[:, 1 : own + 1], e[:, own + 1 :], data))
    return out


def _bent(r: Array, known: Array, curves: Array, data: Data) -> Check:
    """The regression on the temperature: what the `curves` explain of `r` beyond what is `known`, a
    straight line on it and the drifts that are there.
    """
    basis, _ = np.linalg.qr(known)
    bent, _ = np.linalg.qr(curves - basis @ (basis.T @ curves))
    gain = float(np.sum((bent.T @ (r - basis @ (basis.T @ r))) ** 2))
    assert data.temperature is not None, "there are no curves without it"
    low, high = data.temperature.min(), data.temperature.max()
    return Check(
        "temperature",
        float(chi2.logsf(gain, curves.shape[1]) / np.log(10)),
        f"regression on the temperature between {low:.1f} and {high:.1f} degC: it is no straight "
        "line",
    )


def _curves(data: Data) -> np.ndarray:
    """Temperature, its square and lines that begin at its quartiles as columns of the regression,
    shape (orders, 5); none where it is not known.
    """
    t = data.grid_temperature
    if t is None or not np.ptp(t) > 0:
        return np.zeros((data.orders, 0))
    u = (t - t.mean()) / np.std(t)
    bends = np.maximum(u - np.quantile(u, [[0.25], [0.5], [0.75]]), 0.0)
    return data.columns(np.column_stack([u, u**2, *bends]))


#: Share of the mean spectrum below which an ordinate holds more leakage than noise.
MIN_SHARE_OF_MEAN = 1e-3
#: Lags of the residual autocorrelation, samples: shorter ones are the spectrum's affair.
MIN_LAG, MAX_LAG = 24, 4000


def residual_autocorrelation(state: State, rest: Array) -> Check:
    """Autocorrelation at long lags of what is left of the samples, `rest`, shape (n,), whitened by
    the model.

    The periodogram over the model's spectrum is exponential about 1 where the model holds, and so
    its transform is normal about zero with a variance that is known. Whitened by its own
    periodogram a short record would be correlated with itself.
    """
    data, layout = state.data, state.data.layout
    size, own = tapered.padded(data.n), layout.frequency
    f = np.arange(1, size // 2) * data.fs / size
    stages = () if state.fit.low_pass is None else (state.fit.low_pass,)
    model = with_extra(
        Sum(tuple(state.fit.terms), stages).psd(f, data.fs), np.interp(f, own, data.extra)
    )
    seen = np.interp(f, own, data.stats.count > 0) > 0.999
    seen &= (f > own[layout.slow]) & (model > MIN_SHARE_OF_MEAN * np.mean(model))
    power = np.abs(tapered.transform(rest)[1 : len(f) + 1]) ** 2 / data.fs
    excess = np.zeros(size // 2 + 1)
    excess[1 : len(f) + 1] = np.where(seen, power / model - 1.0, 0.0)
    lags = np.arange(MIN_LAG, min(MAX_LAG, data.n // 8))
    sd = np.sqrt(2.0 * np.count_nonzero(seen) / tapered.efficiency(data.n)) / size
    z = np.fft.irfft(excess, size)[lags] / sd
    # noise that breathes scatters more at every lag, and has other checks
    z = z / max(1.0, 1.4826 * float(np.median(np.abs(z))))
    j = int(np.argmax(np.abs(z)))
    value = z[j] * sd * size / max(np.count_nonzero(seen) * 2, 1)
    where = (
        f"autocorrelation of the innovations at a lag of {lags[j] / data.fs:.3g} s: {value:+.3g}"
    )
    return Check("autocorrelation", float(log10_normal(z[j]) + np.log10(len(lags))), where)


def _second_order(state: State) -> State:
    """The state with every telegraph as the Gauss-Markov noise of its spectrum: the expected path
    takes out noise around its edges.
    """
    paths = [i for i in state.items if i.signal is not None]
    if not paths:
        return state
    return state.with_items([i for i in state.items if i.signal is None]).holding(
        *(i.process.twin for i in paths)
    )


def checks(
    state: State,
    rest: Array,
    y: Array,
    smooth: Smooth,
    *,
    coarse_steps: bool = False,
    as_noise: Callable[[State], State] = lambda state: state,
) -> list[Check]:
    """All tests; `rest` is what the state leaves of the samples as noise, `y` its fast part,
    whitened by `smooth`. `coarse_steps`: it is rounded so coarsely that it is no longer normal;
    `as_noise` gives a state with the paths that were taken out as noise.
    """
    second = as_noise(_second_order(state))
    slow_checks = bias(state)
    if second is not state:  # of a path that is half seen both descriptions are approximate
        slow_checks = [max(pair, key=lambda c: c.log_p) for pair in zip(slow_checks, bias(second))]
    fs = state.data.fs
    out = [
        *spectrum(second),
        *slow_checks,
        *stationarity(y, fs, smooth, coarse_steps=coarse_steps),
        *resonances(state, y, smooth),
        residual_autocorrelation(state, rest),
    ]
    if not coarse_steps:
        out += distribution(
            y, smooth.independent, rounded=any(isinstance(t, Quantization) for t in state.fit.terms)
        )
    return out
