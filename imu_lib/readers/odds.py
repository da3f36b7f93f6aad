"""How likely each unit of a stamp is, by whole numbers or not, the rate that results and how usual
it is for such sensors, whether the stamp is a plausible date, how regular the steps are.
"""

from __future__ import annotations

import numpy as np

from imu_lib.readers import spelling

#: How often a unit that nobody states is this one, for whole numbers and for fractions.
WHOLE = {"ms": 0.4, "us": 0.4, "ns": 0.3, "s": 0.05}
FRACTION = {"s": 1.0, "ms": 0.05, "us": 0.03, "ns": 0.003, "min": 0.015, "h": 0.003, "day": 0.003}
#: Limits of the resulting rate (Hz) and how usual a rate between them is for an inertial sensor.
RATES = (
    (0.0, 0.5, 1e-4), (0.5, 2.0, 0.02), (2.0, 8.0, 0.3), (8.0, 2050.0, 1.0), (2050.0, 5100.0, 0.2),
    (5100.0, 10_100.0, 0.03), (10_100.0, 41_000.0, 2e-3))  # fmt: skip
#: Output rates of data sheets and of loggers' timers; others come from a tick that is no decimal
#: part of a second, or from a free-running loop.
USUAL = np.array([
    1, 2, 4, 5, 7.8125, 8, 10, 12.5, 14.9, 15, 15.625, 16, 20, 24, 25, 26, 30, 31.25, 32,
    33.3, 40, 48, 50, 51.2, 52, 59.5, 60, 62.5, 64, 66.7, 75, 80, 90, 100, 102.4, 104,
    119, 120, 125, 128, 150, 160, 180, 200, 204.8, 208, 225, 238, 240, 250, 256, 300, 333,
    375, 400, 416, 450, 476, 500, 512, 562.5, 600, 800, 833, 900, 952, 1000, 1024, 1100,
    1125, 1200, 1600, 1660, 2000, 2048, 2400, 3200, 3330, 4000, 4096, 5000, 6400, 6660,
    8000, 10000,
])  # fmt: skip
FAST = 2050.0  # Hz
#: Fast rates of accelerometers for vibration, and of a few gyros, that are no round ones.
OUTPUT_RATES = np.array([2660.0, 3330.0, 3332.0, 6400.0, 6660.0, 6664.0, 6667.0, 26_667.0])
EPOCH = (9.0e8, 2.3e9)  # s since 1970: 1998 to 2042
IMPOSSIBLE = 1e-6
SLOW = 21.0  # Hz; below, even stamps that would be in ms are as often ticks of a shorter clock
UPTIME = 3.2e8  # s, ten years: no device is on for longer, and no record is from before 1980
#: Clocks of a tenth of a microsecond: seconds from their zero to 1970.
TENTHS = {"Windows (since 1601)": 11_644_473_600.0, ".NET (since the year 1)": 62_135_596_800.0}


def usual_rate(rate: float) -> float:
    """How usual a sampling rate (Hz) is, 1 for an ordinary one."""
    for low, high, weight in RATES:
        if low <= rate < high:
            return weight
    return IMPOSSIBLE


def mean_step(stamp: np.ndarray) -> float:
    """The usual interval of rising stamps, in their own unit: over many samples, so that a coarse
    clock averages out, and the median of those, so that gaps do not count.
    """
    lag = max(1, min(200, max(min(20, len(stamp) // 3), len(stamp) // 8)))
    over = stamp[lag:] - stamp[:-lag]
    step = float(np.median(over)) / lag
    return step if step > 0 else float(stamp[-1] - stamp[0]) / (len(stamp) - 1)


def is_count(stamp: np.ndarray) -> bool:
    """Whether the stamps number the samples: whole, and nearly every step is one."""
    step = np.diff(stamp)
    return bool((stamp == np.rint(stamp)).all() and (step == 1).mean() > 0.97)


def _odd_in_seconds(step: float) -> bool:
    """Whether a step is no decimal part of a second to six digits."""
    scaled = step * 1e6
    return abs(scaled - round(scaled)) > 1e-3 * max(1.0, scaled * 1e-3)


def _other_date(seconds: float) -> bool:
    """Whether seconds are of 1998 to 2042, from GPS's zero (1980), a Mac's (1904 or 2001) or a
    sheet's.
    """
    return any(
        EPOCH[0] < seconds + zero < EPOCH[1] for zero in (315_964_800, -2_082_844_800, 978_307_200)
    )


def tenths(stamp: np.ndarray, first: float) -> str | None:
    """The clock of a tenth of a microsecond that whole stamps are of, None where they are of
    none.
    """
    if first < 1e17:
        return None
    return next((n for n, z in TENTHS.items() if EPOCH[0] < first * 1e-7 - z < EPOCH[1]), None)


def weights(
    stamp: np.ndarray, first: float, known: dict[str, float] | None = None
) -> dict[str, float]:
    """How likely each unit is for stamps (n,) from 0 on whose first one was `first`; `known` are
    the units that such a name has, where a maker's field names it.
    """
    step = mean_step(stamp)
    whole = bool((stamp == np.rint(stamp)).all() and first == np.rint(first))
    spread = np.quantile(np.diff(stamp), (0.25, 0.75))
    regular = spread[1] - spread[0] < 0.02 * step
    out = {}
    for unit, prior in (known or (WHOLE if whole else FRACTION)).items():
        seconds = spelling.stated_time(unit)
        rate = 1.0 / (step * seconds)
        odd = regular and whole and np.abs(USUAL / rate - 1.0).min() > 0.015
        date = EPOCH[0] < first * seconds < EPOCH[1]
        if unit == "day":
            date = 36_000 < first < 56_000 or 729_000 < first < 748_000
        out[unit] = prior * usual_rate(rate) * (20.0 if date else 1.0) * (0.3 if odd else 1.0)
        if unit == "s" and rate > FAST and np.abs(OUTPUT_RATES / rate - 1.0).min() < 2e-3:
            out[unit] *= 20.0  # a fast rate that a data sheet has
        if whole and not date and first * seconds > UPTIME and not _other_date(first * seconds):
            out[unit] *= 1e-3  # neither a date nor a time since a device was switched on
    if known:
        return out
    if "min" in out and regular and _odd_in_seconds(step):
        # a rate that is round in minutes, and no decimal part of a second: 600 Hz, or 10 Hz in
        # minutes
        rate = 1.0 / (60.0 * step)
        if np.abs(USUAL / rate - 1.0).min() < 1e-3:
            out["min"] *= 20.0
    best = max(out, key=out.get)
    if whole and is_count(stamp):
        out["counter"] = 0.5 if first in (0.0, 1.0) else 0.01
    elif whole and regular and best == "ms" and 1e3 / step < SLOW:
        out["ticks"] = 0.05  # of 0.1 ms, with which a sensor's 100 Hz is 100 too
    elif whole and regular and best != "s":
        rate = 1.0 / (step * spelling.TIME_UNITS[best])
        if np.abs(USUAL / rate - 1.0).min() > 0.015 and step > 20:
            out["ticks"] = 0.05
    return out
