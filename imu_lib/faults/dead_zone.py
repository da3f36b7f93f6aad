"""A dead zone: small values come out as one, as a threshold in a driver or a filter makes it."""

from __future__ import annotations

import numpy as np

from imu_lib import timing
from imu_lib.faults.finding import Finding, named

#: Share of the samples at one value, times that of the next most frequent one, and share of the
#: samples on either side of it; visits to it at the least.
SHARE, TIMES, SIDE, VISITS = 0.05, 8.0, 0.03, 20


def find(channels: dict[str, np.ndarray], time: np.ndarray) -> list[Finding]:
    """Channels in which one value in the middle of the distribution is far more frequent than any
    other; alike ones are one finding.
    """
    found: dict[float, list[tuple[str, float, np.ndarray]]] = {}
    for name, x in channels.items():
        at = value(x)
        if at is not None:
            rows = np.flatnonzero(x == at)
            found.setdefault(at, []).append((name, len(rows) / max(1, np.sum(~np.isnan(x))), rows))
    return [_finding(at, some, time) for at, some in found.items()]


def value(x: np.ndarray) -> float | None:
    """The value of the dead zone of a channel, shape (n,), or None.

    A signal comes to its dead zone and leaves it again and again; one value that stands once, for
    however long, is frozen output.
    """
    good = x[~np.isnan(x)]
    if len(good) < 1000:
        return None
    values, count = np.unique(good, return_counts=True)
    if len(values) < 8:
        return None
    order = np.argsort(count)
    at, share = values[order[-1]] + 0.0, count[order[-1]] / len(good)
    sides = min(np.mean(good < at), np.mean(good > at))
    alone = share * len(good) > TIMES * count[order[-2]]
    if not (share > SHARE and alone and sides > SIDE):
        return None
    start, stop = timing.runs(good == at)
    visits = stop - start
    spread = (visits.sum() - visits.max()) / len(good)
    return float(at) if len(visits) >= VISITS and spread > SHARE else None


def _finding(at: float, some: list, time: np.ndarray) -> Finding:
    names = tuple(name for name, _, _ in some)
    shares = [share for _, share, _ in some]
    much = f"{100 * min(shares):.2g}"
    if max(shares) > 1.1 * min(shares):
        much += f" to {100 * max(shares):.2g}"
    return Finding(
        "dead_zone",
        names,
        float(time[0]),
        float(time[-1]),
        {"value": at, "fraction": float(np.mean(shares)), "channels": list(names)},
        {"share": float(max(shares))},
        f"{much} % of the samples of {named(names)} are exactly {at:.4g}, between values on both "
        "sides that are not on a grid.",
        "A dead zone (a threshold in the sensor, the driver or a filter swallows what is small, "
        "and the noise with it), or samples of single channels that are lost and written so. The "
        "noise of these channels is not what the figures say; look for the threshold and switch it "
        "off.",
    )
