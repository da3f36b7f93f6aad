"""How large the errors of the fixes are against what is stated, by the filter's own innovations.

Receivers flatter themselves, antennas are rarely surveyed, and stamps are late: a filter that
believes a stated centimetre then rejects good fixes. What is missing is added to the stated
variances, so that it counts most where the receiver promises most.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.stats import chi2

from imu_lib.drive import Drive

from .preparation import Gnss

#: Share of the innovations that must lie within what the filter expects of that share: errors of
#: receivers have tails, and the innovation test is there for the rest.
SHARE = 0.9
LIMIT = float(chi2.ppf(SHARE, 3))
MEDIAN = float(chi2.median(3))
ROUNDS = 4
#: Where nothing is stated our own guess may be made smaller, but not by more than this: errors of a
#: receiver wander slowly, which innovations do not show.
GUESSED = 0.5
FIELDS = ("position_ratio", "velocity_ratio", "position_extra", "velocity_extra")


def missing_variance(innovations, part, least):
    """Variance (m^2 or (m/s)^2) to be added on each axis, not below `least`, for SHARE of the
    squared distances to lie within LIMIT; 0 where fewer than 20 were offered. part : slice
    """
    value, covariance = innovations.value[:, part], innovations.covariance[:, part, part]
    good = np.isfinite(value).all(axis=1)
    if good.sum() < 20:
        return 0.0
    # in the axes of each covariance an added variance only adds to the three eigenvalues
    size, axes = np.linalg.eigh(covariance[good])
    square = np.einsum("fij,fi->fj", axes, value[good]) ** 2

    def beyond(extra):
        return np.quantile((square / np.maximum(size + extra, 1e-12)).sum(axis=1), SHARE) > LIMIT

    if not beyond(least):
        return least
    low, high = least, max(float(np.quantile(square.sum(axis=1), SHARE)), least + 1e-6)
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if beyond(middle) else (low, middle)
    return high


def guess_ratio(innovations, part):
    """Root of the median squared distance over what it should be; 1 where there are too few."""
    value, covariance = innovations.value[:, part], innovations.covariance[:, part, part]
    good = np.isfinite(value).all(axis=1)
    if good.sum() < 20:
        return 1.0
    solved = np.linalg.solve(covariance[good], value[good][:, :, None])[:, :, 0]
    return float(np.sqrt(np.median(np.einsum("fi,fi->f", value[good], solved)) / MEDIAN))


def changed(drive: Drive, gnss: Gnss, least: Gnss, innovations) -> Gnss:
    """How fixes are to be taken for their innovations to be as large as they say."""
    changes = {}
    for name, part in (("position", slice(0, 3)), ("velocity", slice(3, 6))):
        stated = getattr(drive, f"gnss_{name}_sd")
        if stated is None or not np.isfinite(stated).any():
            ratio = getattr(gnss, f"{name}_ratio") * guess_ratio(innovations, part)
            changes[f"{name}_ratio"] = max(ratio, GUESSED * getattr(least, f"{name}_ratio"))
        else:
            now, low = getattr(gnss, f"{name}_extra") ** 2, getattr(least, f"{name}_extra") ** 2
            more = missing_variance(innovations, part, low - now)
            changes[f"{name}_extra"] = float(np.sqrt(max(now + more, low)))
    return replace(gnss, **changes)


def settled(run, drive: Drive, gnss: Gnss, *, start: Gnss | None = None, rounds=ROUNDS):
    """The standard deviations of the fixes, changed until their innovations are as large as they
    say; stated ones are never made smaller.

    run : function of a Gnss (its `gate` is off) to a Solution; gnss : as given; start : where to
    begin (None: there)
    returns : Gnss, the last Solution
    """
    now = replace(gnss if start is None else start, gate=None)
    solution = run(now)
    for count in range(rounds):
        new = changed(drive, now, gnss, solution.innovations)
        pairs = [(getattr(new, k), getattr(now, k)) for k in FIELDS]
        if all(abs(a - b) < 0.05 * max(a, b, 0.02) for a, b in pairs):
            break
        now = new
        if count + 1 < rounds or rounds > 1:
            solution = run(now)
    return replace(now, gate=gnss.gate), solution
