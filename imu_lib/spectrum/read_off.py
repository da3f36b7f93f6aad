"""Reading N, B, K and Q off the slopes of a power spectral density, with intervals."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import stats

from imu_lib.estimate import Estimate
from imu_lib.slopes import Segment, rising, segments
from imu_lib.spectrum.density import average, welch

#: Symbol -> slope of the one-sided density in log-log (2013 Fig. 5; IEEE Std 952-1997, Annex C).
LINES = {"K": -2.0, "B": -1.0, "N": 0.0, "Q": 2.0}


def coefficient(symbol, level, fs):
    """Coefficient from the line's one-sided density at 1 Hz, `level` in unit^2/Hz.

    N: 2 N^2; B: B^2 / (pi f); K: 2 K^2 / (2 pi f)^2; Q: 2 Q^2 (2 pi f)^2 / fs.
    """
    return {
        "N": np.sqrt(level / 2),
        "B": np.sqrt(np.pi * level),
        "K": 2 * np.pi * np.sqrt(level / 2),
        "Q": np.sqrt(level * fs / 2) / (2 * np.pi),
    }[symbol]


@dataclass(frozen=True)
class Reading:
    """What the slopes of a spectrum say.

    Attributes
    ----------
    coefficients : dict of str to Estimate
        Q, N, B, K; one without a stretch of its slope has no value and an upper limit.
    segments : tuple of Segment
        All straight stretches of the density, in order of frequency.
    used : dict of str to Segment
        The stretch that each coefficient was read from.
    """

    coefficients: dict
    segments: tuple[Segment, ...]
    used: dict

    def __getitem__(self, symbol) -> Estimate:
        return self.coefficients[symbol]


def read_off(spectrum, *, least=0.4, highest=None):
    """Lines of slope 2, 0, -1 and -2 through the stretches of an averaged spectrum that have these
    slopes.

    The stretches are found, not drawn: see `imu_lib.slopes`. Only stretches in an order of rising
    slope are read, of several of one slope the longest; the interval joins the line's degrees of
    freedom and its scatter. No line is forced where there is no stretch: the coefficient is then
    at most what the density leaves room for.

    Parameters
    ----------
    spectrum : Spectrum
        As `average` gives it.
    least : float
        Shortest stretch, decades.
    highest : float or None
        Highest frequency to use, Hz; 0.4 fs by default, below the folding at half the rate.

    Returns
    -------
    Reading
    """
    ok = (spectrum.f <= (highest or 0.4 * spectrum.fs)) & (spectrum.psd > 0)
    f, psd, dof = spectrum.f[ok], spectrum.psd[ok], spectrum.dof[ok]
    # the densities of samples are powers of sin(pi f / fs), not of f: with this the lines are
    # straight up to fs / 2
    g = spectrum.fs / np.pi * np.sin(np.pi * f / spectrum.fs)
    found = tuple(
        replace(s, start=float(f[s.first]), stop=float(f[s.last]))
        for s in segments(g, psd, np.sqrt(2 / dof), LINES.values(), least=least, floor=0.06)
    )
    chain = rising(found)
    upper = psd * dof / stats.chi2.ppf(0.05, dof)
    coefficients, used = {}, {}
    for symbol in ("Q", "N", "B", "K"):
        slope = LINES[symbol]
        mine = [s for s in chain if s.slope == slope]
        if mine:
            used[symbol] = line = max(mine, key=lambda s: s.decades)
            points = slice(line.first, line.last + 1)
            variance = 2 / dof[points].sum() + line.scatter**2 / (line.last - line.first + 1)
            level, nu = 10**line.intercept, 2 / variance
            ends = (level * nu / stats.chi2.ppf(q, nu) for q in (0.975, 0.025))
            coefficients[symbol] = Estimate(
                *(float(coefficient(symbol, v, spectrum.fs)) for v in (level, *ends))
            )
        else:
            coefficients[symbol] = Estimate.absent(
                coefficient(symbol, np.min(upper / g**slope), spectrum.fs)
            )
    return Reading(coefficients, found, used)


def characterise(x, fs):
    """N, B, K, Q read off the averaged spectrum of a record, dict of str to Estimate."""
    x = np.asarray(x, dtype=float)
    reading = read_off(average(welch(x, fs)))
    return {symbol: reading[symbol] for symbol in ("N", "B", "K", "Q")}
