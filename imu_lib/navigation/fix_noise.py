"""How large the errors of the fixes are against what is stated, by the filter's own innovations.

Receivers flatter themselves, antennas are rarely surveyed, and stamps are late: a filter that
believes a stated centimetre then rejects good fixes.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.stats import chi2

from imu_lib.drive import Drive

from .preparation import Gnss

#: Errors of a receiver wander slowly, which innovations do not show: no guess is cut by more.
GUESSED = 0.5
MEDIAN = float(chi2.median(3))
ROUNDS = 4


def ratios(innovations):
    """(position, velocity): root of the median squared distance of the offered innovations over
    what it should be; NaN where fewer than 20 were offered.
    """
    out = []
    for part in (slice(0, 3), slice(3, 6)):
        value, covariance = innovations.value[:, part], innovations.covariance[:, part, part]
        good = np.isfinite(value).all(axis=1)
        if good.sum() < 20:
            out.append(np.nan)
            continue
        solved = np.linalg.solve(covariance[good], value[good][:, :, None])[:, :, 0]
        square = np.einsum("fi,fi->f", value[good], solved)
        out.append(float(np.sqrt(np.median(square) / MEDIAN)))
    return tuple(out)


def least(drive: Drive, gnss: Gnss) -> Gnss:
    """The smallest ratios to believe: those of `gnss` where the receiver states standard deviations,
    GUESSED of them where they are our own guess.
    """
    changes = {}
    for part in ("position", "velocity"):
        if getattr(drive, f"gnss_{part}_sd") is None:
            changes[f"{part}_ratio"] = GUESSED * getattr(gnss, f"{part}_ratio")
    return replace(gnss, **changes)


def settled(run, gnss: Gnss, *, rounds=ROUNDS, least: Gnss | None = None):
    """The standard deviations of the fixes changed until their innovations are as large as they say,
    not below the least.

    run : function of a Gnss (its `gate` is off) to a Solution; gnss : to begin with; least : never
    below these ratios (None: those of `gnss`)
    returns : Gnss, the last Solution
    """
    low = gnss if least is None else least
    low = low.position_ratio, low.velocity_ratio
    off = replace(gnss, gate=None)
    solution = run(off)
    for _ in range(rounds):
        now = off.position_ratio, off.velocity_ratio
        wanted = [
            max(floor, old * (1.0 if np.isnan(by) else by))
            for floor, old, by in zip(low, now, ratios(solution.innovations))
        ]
        if all(abs(np.log(new / old)) < 0.05 for new, old in zip(wanted, now)):
            break
        off = replace(off, position_ratio=wanted[0], velocity_ratio=wanted[1])
        if rounds > 1:
            solution = run(off)
    return replace(off, gate=gnss.gate), solution
