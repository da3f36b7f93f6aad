"""Is anything left? Tests of the residual against the fitted model, each with a p-value and a
sentence of where.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2, norm

from imu_lib.gap import fast, slow
from imu_lib.gap.effects.noise_level_change import unsteady
from imu_lib.gap.engine import measured
from imu_lib.processes import Sum

#: log10 p below which a disagreement is reported (family-wise 0.5 % per channel over all tests,
#: benchmarks/gap_null.py).
LIMIT = -5.0


@dataclass(frozen=True)
class Check:
    """One test: the domain, log10 of its p-value (already corrected for the places it looked at),
    where it disagrees.
    """

    domain: str
    log_p: float
    where: str


def _log10_chi2(value, dof):
    """log10 of the two-sided p-value of chi-square values, far into the tails."""
    upper, lower = chi2.logsf(value, dof), chi2.logcdf(value, dof)
    return (np.minimum(upper, lower) + np.log(2)) / np.log(10)


def _log10_normal(z):
    return (norm.logsf(np.abs(z)) + np.log(2)) / np.log(10)


def spectrum(state) -> Check:
    """Bins of the spectrum, singly and in runs of 3, 9 and 27, against the model; the model's own
    fit error is allowed for.
    """
    s, _ = state.likelihood.shapes(state.fit.vector)
    layout = state.data.layout
    seen = state.likelihood.nu > 0
    nu, ratio = state.likelihood.nu[seen], (state.likelihood.power / s)[seen]
    f = layout.f[layout.slow :][seen]
    worst = Check("psd", 0.0, "")
    for width in (1, 3, 9, 27):
        kernel = np.ones(width)
        dof = np.convolve(nu, kernel, "valid")
        excess = np.convolve(nu * ratio, kernel, "valid")
        # rounding, sampling and windows limit any model spectrum to about a percent
        z = (excess / dof - 1.0) / np.sqrt(2.0 / dof + MODEL**2)
        wilson = dof * (1.0 + z * np.sqrt(2.0 / dof)).clip(1e-6)
        p = _log10_chi2(wilson, dof)
        i = int(np.argmin(p))
        corrected = p[i] + np.log10(len(nu))
        if corrected < worst.log_p:
            decibel = 10 * np.log10(excess[i] / dof[i])
            worst = Check(
                "psd",
                float(corrected),
                f"power spectral density between {f[i]:.3g} and {f[min(i + width, len(f)) - 1]:.3g} Hz, "
                f"{decibel:+.2g} dB from the fitted model",
            )
    return worst


#: Relative accuracy that is asked of a model spectrum.
MODEL = 0.004


def bias(state) -> list[Check]:
    """The whitened block differences: size, colour, outliers."""
    data = state.cleaned
    _, c = state.likelihood.shapes(state.fit.vector)
    columns = (
        np.zeros((data.k, 0)) if state.likelihood.columns is None else state.likelihood.columns
    )
    curves = _curves(data)
    _, e = slow.whiten(c, np.column_stack([data.d, columns, curves]))
    own = 1 + columns.shape[1]
    r = e[:, 0] - e[:, 1:own] @ state.fit.beta
    n = len(r)
    out = [
        Check(
            "allan",
            float(_log10_chi2(r @ r, n)),
            "bias over the whole record: its innovations are larger or smaller than the model's",
        )
    ]
    p = np.abs(np.fft.rfft(r))[1:] ** 2 / n
    for width in (1, 5, 20, 60):
        if width > len(p) // 2:
            continue
        total = np.convolve(2 * p, np.ones(width), "valid")
        lp = _log10_chi2(total, 2 * width)
        i = int(np.argmin(lp))
        f = np.array([i + 1, i + width]) / n * data.fs / data.m
        decibel = 10 * np.log10(total[i] / (2 * width))
        out.append(
            Check(
                "allan",
                float(lp[i] + np.log10(len(p))),
                f"slow variation with periods of {1 / f[1]:.4g} to {1 / f[0]:.4g} s, "
                f"{decibel:+.2g} dB from the fitted model",
            )
        )
    j = int(np.argmax(np.abs(r)))
    out.append(
        Check(
            "mean",
            float(_log10_normal(r[j]) + np.log10(n)),
            f"mean of the signal: an unforeseen jump near {data.block_time[j + 1]:.0f} s",
        )
    )
    k4 = np.mean((r / r.std()) ** 4) - 3
    out.append(
        Check(
            "mean",
            float(_log10_normal(max(k4, 0) / np.sqrt(24 / n) * 0.7)),
            "mean of the signal: its jumps from block to block are not normally distributed",
        )
    )
    if curves.shape[1]:
        # beyond what a straight line on the temperature, and the drifts that are there, explain
        known, _ = np.linalg.qr(e[:, 1 : own + 1])
        bent = e[:, own + 1 :] - known @ (known.T @ e[:, own + 1 :])
        basis, _ = np.linalg.qr(bent)
        left = r - known @ (known.T @ r)
        gain = float(np.sum((basis.T @ left) ** 2))
        out.append(
            Check(
                "temperature",
                float(chi2.logsf(gain, curves.shape[1] - 1) / np.log(10)),
                f"regression on the temperature between {data.temperature.min():.1f} and {data.temperature.max():.1f} degC: it is no straight line",
            )
        )
    return out


def _curves(data) -> np.ndarray:
    """Temperature, its square and lines that begin at its quartiles as columns of the regression,
    shape (differences, 5); none
    where it is not known."""
    t = data.block_temperature
    if t is None or not np.ptp(t) > 0:
        return np.zeros((data.k, 0))
    u = (t - t.mean()) / np.std(t)
    return np.diff(
        np.column_stack([u, u**2, *np.maximum(u - np.quantile(u, [[0.25], [0.5], [0.75]]), 0.0)]),
        axis=0,
    )


def distribution(y, independent: float = 1.0, *, rounded: bool = False) -> list[Check]:
    """Skewness and excess of the whitened fast noise, a share of whose samples is `independent`."""
    n = len(y) * independent
    u = (y - y.mean()) / y.std()
    skew, excess = np.mean(u**3), np.mean(u**4) - 3
    if rounded:  # differenced rounding errors are flatter than normal ones
        excess = max(excess, 0.0)
    return [
        Check(
            "distribution",
            float(_log10_normal(skew / np.sqrt(6 / n))),
            f"distribution of the innovations: skewness {skew:+.3g}",
        ),
        Check(
            "distribution",
            float(_log10_normal(excess / np.sqrt(24 / n))),
            f"distribution of the innovations: excess kurtosis {excess:+.3g}",
        ),
    ]


def stationarity(y, fs, smooth, *, coarse_steps: bool = False) -> list[Check]:
    """Variance at several scales, as a whole and in bands of frequency outside the stop band of a
    filter.
    """
    out = []
    # the powers of all bands move together where a few levels of the output make the energy of a
    # block scatter
    excess = max(float(np.mean(y**4) / np.mean(y**2) ** 2) - 3.0, 0.0) if coarse_steps else 0.0
    found = unsteady(y, fs, smooth.independent)
    if found is not None:
        out.append(Check("stationarity", float(found[0] + np.log10(8)), found[1]))
    m = 256
    k = len(y) // m
    if k >= 32:
        edges = np.unique(np.round(np.geomspace(3, m // 2, 9)).astype(int))
        passed = smooth.stop_band(m)
        # outside of what is little but leakage from elsewhere
        bands = [(a, b) for a, b in zip(edges[:-1], edges[1:]) if passed[a:b].mean() >= 0.9]
        out += _levels(_block_powers(y, m), fs, bands, (4, 32), excess)
    return out


def _block_powers(y, m):
    """Periodograms of successive blocks of `m` samples (even) under a sine window, shape (blocks,
    m / 2 + 1).
    """
    k = len(y) // m
    window = np.sin(np.pi * (np.arange(m) + 0.5) / m)
    return np.abs(np.fft.rfft(y[: k * m].reshape(k, m) * window, axis=1)) ** 2


def _levels(power, fs, bands, joins, excess=0.0) -> list[Check]:
    """Whether bands (first and last ordinate of the blocks' `power`) keep their level over `joins`
    blocks, singly and all in all.
    """
    k, m = len(power), 2 * (power.shape[1] - 1)
    out = []
    for join in joins:
        g, total = k // join, 0.0
        if g < 8:
            continue
        span = f"its level changes over {join * m / fs:.3g} s"
        for a, b in bands:
            e = power[: g * join, a:b].sum(axis=1).reshape(g, join).mean(axis=1)
            # neighbouring ordinates of a sine window overlap: their share of independent ones is
            # about 0.6
            free = 2.0 * (b - a) * join * (1.0 if b - a == 1 else 0.62)
            z2 = np.sum((e / e.mean() - 1) ** 2) / (2 / free + excess / (m * join))
            total += z2
            lp = chi2.logsf(z2, g - 1) / np.log(10) + np.log10(2 * (len(bands) + 1))
            out.append(
                Check(
                    "stationarity",
                    float(lp),
                    f"spectrum between {a * fs / m:.3g} and {b * fs / m:.3g} Hz: {span}",
                )
            )
        if len(bands) > 1:
            # the overlap ties neighbouring bands of few ordinates to one another
            lp = chi2.logsf(total / 1.3, len(bands) * (g - 1) / 1.3) / np.log(10) + np.log10(2)
            out.append(
                Check(
                    "stationarity",
                    float(lp),
                    f"spectrum between {bands[0][0] * fs / m:.3g} and {bands[-1][1] * fs / m:.3g} Hz: {span}",
                )
            )
    return out


#: log10 of how much likelier than other disagreements a tone that wanders is where a resonance was
#: found.
DOUBTFUL = 1.5


def resonances(state, y) -> list[Check]:
    """Whether a noise that was added at a place in the spectrum is there all the time and all over
    its width: a tone that
    wanders or sweeps fills the same place on average."""
    found = [t for t in state.fit.terms[len(state.base) :] if t.name == "autoregressive"]
    if not found:
        return []
    out, layout, fs = [], state.data.layout, state.data.fs
    whole = measured(fast.spectrum(state.fit.terms, None, layout, fs), state.data.extra)
    for term in found:
        share = (term.psd(layout.f, fs) / whole)[layout.slow :]
        on = layout.nodes[layout.slow :][share > 0.5 * share.max()]
        low, high = on.min(), on.max()
        m = int(2 ** np.floor(np.log2(min(32 * fs / max(high - low, 1e-3 * fs), len(y) / 32))))
        k = len(y) // m
        edges = np.unique(
            np.round(np.linspace(low * m / fs, max(high * m / fs, low * m / fs + 1), 9)).astype(int)
        )
        joins = sorted({max(1, k // g) for g in (8, 32, 128)})
        power = _block_powers(y, m)
        for bands in ([(edges[0], edges[-1])], [*zip(edges[:-1], edges[1:])]):
            out += [replace(c, log_p=c.log_p - DOUBTFUL) for c in _levels(power, fs, bands, joins)]
    return out


#: Share of the mean spectrum below which an ordinate holds more leakage than noise.
MIN_SHARE_OF_MEAN = 1e-3
#: Lags of the residual autocorrelation, samples: shorter ones are the spectrum's affair.
MIN_LAG, MAX_LAG = 24, 4000


def residual_autocorrelation(state, rest) -> Check:
    """Autocorrelation at long lags of what is left of the samples, `rest`, shape (n,), whitened by
    the model.

    The periodogram over the model's spectrum is exponential about 1 where the model holds, and so
    its transform is normal about zero with a variance that is known. Whitened by its own
    periodogram a short record would be correlated with itself.
    """
    data, layout = state.data, state.data.layout
    size = fast.padded(data.n)
    f = np.arange(1, size // 2) * data.fs / size
    stages = () if state.fit.low_pass is None else (state.fit.low_pass,)
    model = measured(
        Sum(tuple(state.fit.terms), stages).psd(f, data.fs), np.interp(f, layout.f, data.extra)
    )
    seen = np.interp(f, layout.f, layout.nu > 0) > 0.999
    seen &= (f > layout.f[layout.slow]) & (model > MIN_SHARE_OF_MEAN * np.mean(model))
    power = np.abs(fast.transform(rest)[1 : len(f) + 1]) ** 2 / data.fs
    excess = np.zeros(size // 2 + 1)
    excess[1 : len(f) + 1] = np.where(seen, power / model - 1.0, 0.0)
    lags = np.arange(MIN_LAG, min(MAX_LAG, data.n // 8))
    sd = np.sqrt(2.0 * np.count_nonzero(seen) / fast.efficiency(data.n)) / size
    z = np.fft.irfft(excess, size)[lags] / sd
    # noise that breathes scatters more at every lag, and has other checks
    z = z / max(1.0, 1.4826 * float(np.median(np.abs(z))))
    j = int(np.argmax(np.abs(z)))
    value = z[j] * sd * size / max(np.count_nonzero(seen) * 2, 1)
    where = (
        f"autocorrelation of the innovations at a lag of {lags[j] / data.fs:.3g} s: {value:+.3g}"
    )
    return Check("autocorrelation", float(_log10_normal(z[j]) + np.log10(len(lags))), where)


def _second_order(state):
    """The state with every telegraph as the Gauss-Markov noise of its spectrum: the expected path
    takes out noise around its edges.
    """
    paths = [i for i in state.items if i.signal is not None]
    if not paths:
        return state
    return state.with_items([i for i in state.items if i.signal is None]).holding(
        *(i.process.twin for i in paths)
    )


def checks(state, rest, y, smooth, *, coarse_steps: bool = False) -> list[Check]:
    """All tests; `rest` is what the state leaves of the samples as noise, `y` its fast part,
    whitened by `smooth`.
    `coarse_steps`: the output is rounded so
    coarsely that its distribution is no longer normal."""
    second = _second_order(state)
    slow_checks = bias(state)
    if second is not state:  # of a path that is half seen both descriptions are approximate
        slow_checks = [max(pair, key=lambda c: c.log_p) for pair in zip(slow_checks, bias(second))]
    fs = state.data.fs
    out = [
        spectrum(second),
        *slow_checks,
        *stationarity(y, fs, smooth, coarse_steps=coarse_steps),
        *resonances(state, y),
        residual_autocorrelation(state, rest),
    ]
    if not coarse_steps:
        out += distribution(
            y, smooth.independent, rounded=any(t.name == "quantization" for t in state.fit.terms)
        )
    return out
