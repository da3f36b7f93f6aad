"""Whether the noise that is left keeps its level, as a whole and in bands of frequency."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.stats import chi2

from imu_lib.arrays import Array
from imu_lib.gap.check import Check
from imu_lib.gap.effects.noise_level_change import unsteady
from imu_lib.gap.state import State
from imu_lib.likelihood.evaluate import with_extra
from imu_lib.samples.innovations import Smooth

#: Share of a band that whitening leaves from which on it tells of the noise.
HEARD = 0.9
#: Streams that may take turns.
TURNS = (2, 3, 4)


def stationarity(y: Array, fs: float, smooth: Smooth, *, coarse_steps: bool = False) -> list[Check]:
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
    out += _alternates(y, smooth.independent)
    m = 256
    k = len(y) // m
    if k >= 32:
        edges = np.unique(np.round(np.geomspace(3, m // 2, 9)).astype(int))
        bands = _heard([*zip(edges[:-1], edges[1:])], smooth, m)
        out += _levels(_block_powers(y, m), fs, bands, (4, 32), excess)
    return out


def _heard(bands: list[tuple[int, int]], smooth: Smooth, m: int) -> list[tuple[int, int]]:
    """The bands outside of what is little but leakage from elsewhere, or rounding."""
    passed = smooth.stop_band(m)
    return [(a, b) for a, b in bands if passed[a:b].mean() >= HEARD]


def _alternates(y: Array, independent: float) -> list[Check]:
    """Whether every second, third or fourth sample is as loud as the others: of streams that take
    turns in one column each has a noise of its own.
    """
    square = y**2
    kurtosis = max(float(np.mean(square**2) / np.mean(square) ** 2) - 1.0, 0.5)
    out = []
    for turns in TURNS:
        k = len(y) // turns
        level = square[: k * turns].reshape(k, turns).mean(axis=0)
        z = (level / level.mean() - 1.0) * np.sqrt(k * independent / kurtosis)
        log_p = chi2.logsf(float(np.sum(z**2)), turns - 1) / np.log(10)
        loud = float(np.sqrt(level.max() / level.min()))
        text = (
            f"variance of the innovations: one sample in {turns} is {loud:.3g} times as loud as "
            "another, as of streams that take turns in one column"
        )
        out.append(Check("stationarity", float(log_p + np.log10(len(TURNS))), text))
    return out


def _block_powers(y: Array, m: int) -> Array:
    """Periodograms of successive blocks of `m` samples (even) under a sine window, shape (blocks,
    m / 2 + 1).
    """
    k = len(y) // m
    window = np.sin(np.pi * (np.arange(m) + 0.5) / m)
    return np.abs(np.fft.rfft(y[: k * m].reshape(k, m) * window, axis=1)) ** 2


def _independent(ordinates: int) -> float:
    """Independent ordinates among neighbours under a sine window, whose square has a first Fourier
    coefficient of half its mean: the powers of neighbours have the correlation 1/4.
    """
    return ordinates / (1.0 + 0.5 * (1.0 - 1.0 / ordinates))


def _levels(
    power: Array,
    fs: float,
    bands: list[tuple[int, int]],
    joins: list[int] | tuple[int, int],
    excess: float = 0.0,
) -> list[Check]:
    """Whether bands (first and last ordinate of the blocks' `power`) keep their level over `joins`
    blocks, singly and all in all.

    The squared deviations of one band scatter more than those of normal numbers by 6 over the
    degrees of freedom of its energies, those of all bands by the correlation of neighbours, too:
    their sum is a scaled chi-square of the same mean and variance (Satterthwaite 1946).
    """
    k, m = len(power), 2 * (power.shape[1] - 1)
    out = []
    for join in joins:
        g, total, scatter = k // join, 0.0, 0.0
        if g < 8:
            continue
        span = f"its level changes over {join * m / fs:.3g} s"
        for a, b in bands:
            e = power[: g * join, a:b].sum(axis=1).reshape(g, join).mean(axis=1)
            free = 2.0 * join * _independent(b - a)
            z2 = np.sum((e / e.mean() - 1) ** 2) / (2 / free + excess / (m * join))
            wide = 1.0 + 6.0 / free
            total, scatter = total + z2, scatter + wide
            lp = chi2.logsf(z2 / wide, (g - 1) / wide) / np.log(10)
            out.append(
                Check(
                    "stationarity",
                    float(lp + np.log10(2 * (len(bands) + 1))),
                    f"spectrum between {a * fs / m:.3g} and {b * fs / m:.3g} Hz: {span}",
                )
            )
        if len(bands) > 1:
            for (a, b), (_, end) in zip(bands[:-1], bands[1:]):
                # one pair of neighbours, of correlation 1/4, among the sums of two bands
                rho2 = _independent(b - a) * _independent(end - b) / (4 * (b - a) * (end - b)) ** 2
                scatter += 2.0 * rho2
            wide = scatter / len(bands)
            lp = chi2.logsf(total / wide, len(bands) * (g - 1) / wide) / np.log(10)
            out.append(
                Check(
                    "stationarity",
                    float(lp + np.log10(2)),
                    f"spectrum between {bands[0][0] * fs / m:.3g} and {bands[-1][1] * fs / m:.3g} "
                    f"Hz: {span}",
                )
            )
    return out


#: log10 of how much likelier than other disagreements a tone that wanders is where a resonance was
#: found.
DOUBTFUL = 1.5


def resonances(state: State, y: Array, smooth: Smooth) -> list[Check]:
    """Whether a noise that was added at a place in the spectrum is there all the time and all over
    its width: a tone that wanders or sweeps fills the same place on average."""
    places = [state.assembly.place(c) for c in state.items if c.effect.local]
    found = [state.fit.terms[at] for at in places]
    if not found:
        return []
    out, layout, fs = [], state.data.layout, state.data.fs
    whole = with_extra(layout.spectrum(state.fit.terms), state.data.extra)
    for term in found:
        share = (term.psd(layout.frequency, fs) / whole)[layout.slow :]
        on = layout.slow + np.flatnonzero(share > 0.5 * share.max())
        low = layout.frequency[on[0]] - layout.half[on[0]]
        high = layout.frequency[on[-1]] + layout.half[on[-1]]
        m = int(2 ** np.floor(np.log2(min(32 * fs / max(high - low, 1e-3 * fs), len(y) / 32))))
        k = len(y) // m
        edges = np.unique(
            np.round(np.linspace(low * m / fs, max(high * m / fs, low * m / fs + 1), 9)).astype(int)
        )
        joins = sorted({max(1, k // g) for g in (8, 32, 128)})
        power = _block_powers(y, m)
        narrow = _heard([*zip(edges[:-1], edges[1:])], smooth, m)
        if not narrow:
            continue
        for bands in ([(narrow[0][0], narrow[-1][1])], narrow):
            out += [replace(c, log_p=c.log_p - DOUBTFUL) for c in _levels(power, fs, bands, joins)]
    return out
