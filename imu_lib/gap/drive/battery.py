"""Are the innovations those of a right model? A battery of statistics, in physical words.

Whitened innovations of a right filter are independent normal variables of unit variance, whatever
the drive. Copies of the drive, simulated from the hypothesis itself, therefore have white
innovations at the same fixes; the battery of the measurement is held against theirs.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from imu_lib.arrays import Array

if TYPE_CHECKING:
    from .problem import Problem

KINDS = ("position", "velocity")
WAYS = ("along the track", "across the track", "down")
LAGS = (1, 2, 5, 10)
PARTS = 6  # of the drive, for means and sizes
COPIES = 60
#: Least root mean square, m/s^2, rad/s, m/s, of what innovations may follow: of a straight drive
#: the rest is the path's own noise, which is that of the innovations.
LEAST = {"forward acceleration": 0.1, "sideways acceleration": 0.1, "turn rate": 0.01, "speed": 0.5}
SURE = 4.6  # standard deviations beyond which a statistic of about a hundred is no chance


@dataclass(frozen=True)
class Battery:
    """names (k,) of the statistics, z (k,) in standard deviations of the copies, index: distance
    over the copies' median distance, nis: mean squared whitened innovation, whiteness: largest
    correlation from one fix to one of the next.
    """

    names: tuple[str, ...]
    z: np.ndarray
    index: float
    nis: float
    whiteness: float

    @property
    def right(self) -> bool:
        """Whether nothing stands out by more than chance."""
        return abs(self.worst()[1]) <= SURE

    def worst(self) -> tuple[str, float]:
        """What stands out most, in words, and its z."""
        k = int(np.argmax(np.abs(self.z)))
        return self.names[k], float(self.z[k])


def in_track(problem: Problem, e: Array) -> Array:
    """Whitened innovations (f, 6) turned into along, across and down; NaN where not used."""
    c, s = np.cos(problem.course), np.sin(problem.course)
    out = e.copy()
    for k in (0, 3):
        out[:, k] = e[:, k] * c + e[:, k + 1] * s
        out[:, k + 1] = -e[:, k] * s + e[:, k + 1] * c
    return out


def battery(problem: Problem, e: Array, use: Array, rng: np.random.Generator) -> Battery:
    """The battery of innovations e (f, 6) against simulated copies."""
    track = np.where(use, in_track(problem, e), np.nan)
    names, measured = _statistics(problem, track)
    copies = _copies(problem, use, rng)
    mean, sd = copies.mean(axis=0), np.maximum(copies.std(axis=0), 1e-9)
    z = (measured - mean) / sd
    own = np.sqrt(np.mean(((copies - mean) / sd) ** 2, axis=1))
    index = float(np.sqrt(np.mean(z**2)) / np.median(own))
    nis = float(np.nanmean(track**2))
    lags = [abs(m) for n, m in zip(names, measured) if "fixes on" in n]
    return Battery(names, z, index, nis, float(max(lags, default=0.0)))


def _copies(problem: Problem, use: Array, rng: np.random.Generator) -> Array:
    """Statistics of the copies, (COPIES, k); those of a path are drawn once."""
    drawn: dict[bytes, Array] = problem.__dict__.setdefault("copies", {})
    key = use.tobytes()
    if key not in drawn:
        white = (np.where(use, rng.standard_normal(use.shape), np.nan) for _ in range(COPIES))
        drawn[key] = np.array([_statistics(problem, w)[1] for w in white])
    return drawn[key]


def _statistics(problem: Problem, e: Array) -> tuple[tuple[str, ...], Array]:
    """Names and values of the statistics of innovations e (f, 6) in track."""
    names: list[str] = []
    values: list[float] = []
    regressors = {
        "forward acceleration": problem.ahead,
        "sideways acceleration": problem.aside,
        "turn rate": problem.turn,
        "speed": problem.speed,
        "time": problem.time,
    }
    if np.any(problem.warmth):
        regressors["temperature"] = problem.warmth
    for k in range(6):
        x = e[:, k]
        good = np.isfinite(x)
        if good.sum() < 50:
            continue
        what = f"{KINDS[k // 3]} innovations {WAYS[k % 3]}"
        v = x[good]
        names.append(f"{what} have another size than the filter expects")
        values.append(np.log(np.mean(v**2)))
        names.append(f"{what} have outliers")
        values.append(np.log(np.mean(v**4) / np.mean(v**2) ** 2))
        for lag in LAGS:
            if v.size > 3 * lag + 20:
                names.append(f"{what} are alike {lag} fixes on")
                values.append(float(np.mean(v[lag:] * v[:-lag]) / np.mean(v**2)))
        for name, regressor in regressors.items():
            r = regressor[good] - regressor[good].mean()
            size = np.sqrt(np.mean(r**2))
            if size > LEAST.get(name, 1e-9):
                names.append(f"{what} follow the {name}")
                values.append(float(np.mean(v * r) / size))
        for part, piece in enumerate(np.array_split(v, PARTS)):
            t = problem.time[good]
            when = np.array_split(t, PARTS)[part]
            span = f"between {when[0]:.0f} and {when[-1]:.0f} s"
            names.append(f"{what} are off to one side {span}")
            values.append(float(piece.mean()))
            names.append(f"{what} change their size {span}")
            values.append(float(np.log(np.mean(piece**2))))
    return tuple(names), np.array(values)
