"""The mains in a spectrum: at its own frequency, and where the sampling folds it and its multiples
to.
"""

from __future__ import annotations

import numpy as np

from imu_lib.timing import folded

#: Frequencies of the mains, Hz, and share by which they (EN 50160: 1 % in 99.5 % of a year, in
#: minutes a tenth of that) and the clock of a record may be off.
MAINS, MAINS_OFF = (50.0, 60.0), 5e-3
#: The same for a line alone, which has nothing but its frequency to say what it is; multiples that
#: are strong enough to stand alone, and Hz below which what is folded is a drift.
ALONE_OFF, ALONE, SLOWEST = 2e-3, (1, 2, 3), 0.5


def of_mains(frequency: float, harmonics: int) -> bool:
    """Whether a family of lines is the hum of the mains."""
    return harmonics > 1 and any(abs(frequency / f - 1) < MAINS_OFF for f in MAINS)


def unfolded(seen: float, fs: float) -> float | None:
    """The frequency of the mains that samples at `fs` Hz show as a line at `seen` Hz; None where
    they would show it elsewhere.
    """
    for f in MAINS:
        if abs(folded(f, fs) - seen) < MAINS_OFF * f:
            turns = fs * np.round(f / fs)
            return float(min((turns + seen, turns - seen), key=lambda v: abs(v - f)))
    return None


def hint(seen: float, fs: float) -> str:
    """Which multiple of the mains folds to a line at `seen` Hz, in words; nothing where none
    does.
    """
    for k in ALONE:
        for f in MAINS:
            at = folded(k * f, fs)
            if k * f > 0.5 * fs and at > SLOWEST and abs(at - seen) < ALONE_OFF * k * f:
                what = "the mains" if k == 1 else f"{k} times the mains"
                return f"{k * f:.0f} Hz, {what}, folds to there at {fs:.4g} samples a second"
    return ""
