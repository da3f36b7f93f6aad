"""Which model wins: improvements by both definitions, and paired comparisons with confidence
intervals.
"""

from dataclasses import dataclass, fields

import numpy as np
from scipy import stats

#: The two definitions of an improvement.
HOW = ("mean_of_ratios", "ratio_of_sums")


def improvement(better, worse, *, how):
    """Improvement of `better` over `worse`, per cent.

    better, worse : ndarray, shape (n,), errors of the same outages, m
    how : "mean_of_ratios" (every outage counts alike; the 2013 paper's 50.95 %) or "ratio_of_sums"
    (the largest outages decide; its 4.3 %)
    """
    better, worse = np.asarray(better, float), np.asarray(worse, float)
    if how == "mean_of_ratios":
        return 100.0 * float(np.mean(1.0 - better / worse))
    if how == "ratio_of_sums":
        return 100.0 * float(1.0 - better.sum() / worse.sum())
    raise ValueError(f"`how` must be 'mean_of_ratios' or 'ratio_of_sums', not {how!r}")


def improvements(better, worse):
    """`improvement` by both definitions, per cent: {how: float}."""
    return {how: improvement(better, worse, how=how) for how in HOW}


@dataclass(frozen=True)
class Paired:
    """Comparison of two models on the same outages: geometric mean of error ratios with its 95 %
    interval.

    better, than : names; ratio below 1 means `better` has the smaller errors, beyond chance where
    `decided`; wins : share of outages in which it has;
    p : of Wilcoxon's signed-rank test on the log ratios (two-sided); outages, clusters : how many,
    and in how many independent groups
    """

    better: str
    than: str
    ratio: float
    low: float
    high: float
    wins: float
    p: float
    outages: int
    clusters: int

    def __str__(self):
        return (
            f"{self.better} over {self.than}, {self.ratio:.2f} [{self.low:.2f}, {self.high:.2f}], "
            f"ahead in {100 * self.wins:.0f} % of the outages"
        )

    @property
    def decided(self):
        """Whether the interval leaves out 1."""
        return self.high < 1.0 or self.low > 1.0

    def to_json(self):
        return {
            "better": self.better,
            "than": self.than,
            "ratio": self.ratio,
            "low": self.low,
            "high": self.high,
            "wins": self.wins,
            "p": self.p,
            "decided": self.decided,
            "outages": self.outages,
            "clusters": self.clusters,
        }


class Pairs:
    """Comparisons by the two names, in either order: `pairs["18AV", "15AV"]` is a `Paired`.

    comparisons : sequence of Paired, or of what their `to_json` stored
    """

    def __init__(self, comparisons):
        found = [c if isinstance(c, Paired) else _stored(c) for c in comparisons]
        self._by_names = {frozenset((c.better, c.than)): c for c in found}

    def __getitem__(self, names):
        try:
            return self._by_names[frozenset(names)]
        except KeyError:
            raise KeyError(f"no comparison of {' and '.join(map(repr, names))}") from None


def _stored(comparison) -> Paired:
    """A comparison as its `to_json` wrote it."""
    return Paired(**{f.name: comparison[f.name] for f in fields(Paired)})


def paired(first, second, names=("first", "second"), *, clusters=None) -> Paired:
    """Compare errors of the same outages.

    first, second : ndarray, shape (n,), m; clusters : (n,) labels of what is not independent (a
    drive): logs of ratios are then averaged within each first, and the interval is Student's over
    the clusters. The model with the smaller mean log error is named `better`.
    """
    log = np.log(
        np.maximum(np.asarray(first, float), 1e-3) / np.maximum(np.asarray(second, float), 1e-3)
    )
    names = tuple(names)
    if log.mean() > 0.0:
        log, names = -log, names[::-1]
    values = (
        log
        if clusters is None
        else np.array([log[np.asarray(clusters) == c].mean() for c in np.unique(clusters)])
    )
    n, mean = values.size, float(values.mean())
    half = float(stats.t.ppf(0.975, n - 1) * values.std(ddof=1) / np.sqrt(n)) if n > 1 else np.inf
    p = float(stats.wilcoxon(values).pvalue) if n > 5 and np.any(values != 0.0) else 1.0
    with np.errstate(over="ignore"):
        low, high = float(np.exp(mean - half)), float(np.exp(min(mean + half, 700.0)))
    return Paired(*names, float(np.exp(mean)), low, high, float(np.mean(log < 0.0)), p, log.size, n)


def median_interval(values, level=0.95):
    """Median with an exact interval from the order statistics: (median, low, high)."""
    x = np.sort(np.asarray(values, float))
    n = x.size
    k = int(stats.binom.ppf(0.5 * (1.0 - level), n, 0.5))
    return float(np.median(x)), float(x[max(k - 1, 0)]), float(x[min(n - k, n - 1)])
