"""In what unit are these stamps? Weighed from all that is known: the unit stated, whole numbers or
not, the rate that results and how usual it is for such sensors, whether the stamp is a plausible
date, how regular the steps are. Where two readings remain, it is asked.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from imu_lib.errors import InputError
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
USUAL = np.array(
    [1, 2, 4, 5, 7.8125, 8, 10, 12.5, 14.9, 15, 15.625, 16, 20, 24, 25, 26, 30, 31.25, 32, 33.3, 40, 48, 50, 51.2, 52, 59.5, 60, 62.5, 64, 66.7, 75, 80, 90,
     100, 102.4, 104, 119, 120, 125, 128, 150, 160, 180, 200, 204.8, 208, 225, 238, 240, 250, 256, 300, 333, 375, 400, 416, 450,
     476, 500, 512, 562.5, 600, 800, 833, 900, 952, 1000, 1024, 1100, 1125, 1200, 1600, 1660, 2000, 2048, 2400, 3200, 3330,
     4000, 4096, 5000, 6400, 6660, 8000, 10000]
)  # fmt: skip
FAST = 2050.0  # Hz
#: Fast rates of accelerometers for vibration, and of a few gyros, that are no round ones.
OUTPUT_RATES = np.array([2660.0, 3330.0, 3332.0, 6400.0, 6660.0, 6664.0, 6667.0, 26_667.0])
ODDS = 15.0  # the best reading must be this much likelier than the next one
EPOCH = (9.0e8, 2.3e9)  # s since 1970: 1998 to 2042
IMPOSSIBLE = 1e-6
OPEN = 0.05  # weight below which no unit is likely
SLOW = 21.0  # Hz; below, even stamps that would be in ms are as often ticks of a shorter clock
UPTIME = 3.2e8  # s, ten years: no device is on for longer, and no record is from before 1980
#: Clocks of a tenth of a microsecond: seconds from their zero to 1970.
TENTHS = {"Windows (since 1601)": 11_644_473_600.0, ".NET (since the year 1)": 62_135_596_800.0}
#: Stamps that a maker's field names: Xsens counts 0.1 ms in its MTi and us in its DOT.
MAKERS = {"sampletimefine": {"ticks:10000": 0.4, "us": 0.4}}


@dataclass(frozen=True)
class Reading:
    """unit: of the stamps, or `counter` where they number the samples. factor: s per unit (None of
    a counter). why: one line. stated: whether the file or the call said it.
    """

    unit: str
    factor: float | None
    why: str
    stated: bool


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


def read(
    stamp: np.ndarray,
    first: float,
    *,
    where: str,
    unit: str | None,
    flag: str | None,
    rate: float | None,
    insisted: bool = False,
    heading: str = "",
    rate_given: bool = True,
) -> Reading:
    """The unit of stamps (n,), which rise from 0; `first` is the first one as the file has it.

    Parameters
    ----------
    where : str
        File and column, for messages.
    unit : str or None
        What the file states.
    flag : str or None
        What the call states (`--time-unit`); it wins.
    rate : float or None
        Hz, where the call or the file states one.

    Raises
    ------
    InputError
        Where two readings remain, or a stated unit cannot be; it names the flag.
    """
    step = mean_step(stamp)

    def hz(u):
        return 1.0 / (step * spelling.stated_time(u))

    if flag:
        return _by_flag(flag, unit)
    of = tenths(stamp, first) if unit in (None, "ticks") and not rate else None
    if of and usual_rate(1e7 / step) > 0.1:
        return Reading(
            "ticks:1e7",
            1e-7,
            f"a date as {of} counts it, in tenths of a microsecond: {1e7 / step:.5g} Hz",
            False,
        )
    if unit == "ticks":
        raise InputError(
            f"{where} counts ticks; give how many there are in a second with --time-unit ticks:HZ "
            f"(they step by {step:.6g})."
        )
    if unit is not None:
        return _stated(stamp, first, where, unit, hz, insisted)
    known = MAKERS.get(heading.replace("_", "").lower())
    likely = weights(stamp, first, known)
    if rate:
        found = _by_rate(stamp, where, likely, rate, hz, step, rate_given)
        if found is not None:
            return found
    return _weighed(stamp, first, where, likely, hz, step)


def _by_flag(flag: str, unit: str | None) -> Reading:
    """What the call says, with a word where the file says another unit."""
    factor = spelling.stated_time(flag)
    alike = unit in (None, "ticks") or unit == spelling.unit_of(flag)
    said = "" if alike else f", though the file states {unit}"
    return Reading(flag, factor, f"--time-unit says {flag}{said}", True)


def _weighed(stamp, first: float, where: str, likely: dict[str, float], hz, step) -> Reading:
    """The likeliest unit; InputError where two remain, or none is likely."""
    order = sorted(likely, key=likely.get, reverse=True)
    best = order[0]
    next_ = likely[order[1]] if len(order) > 1 else 0.0
    if likely[best] < 1e-4 or likely[best] < ODDS * next_ or best == "counter":
        raise InputError(_question(where, stamp, order, likely, hz, step))
    others = [f"in {u} {hz(u):.3g} Hz" for u in order[1:3] if u not in ("counter", "ticks")]
    date = " and a date" if EPOCH[0] < first * spelling.stated_time(best) < EPOCH[1] else ""
    return Reading(
        best,
        spelling.stated_time(best),
        f"no unit stated: read as {best}, which makes {hz(best):.5g} Hz{date}"
        + (f" ({', '.join(others)})" if others else ""),
        False,
    )


def _stated(stamp, first, where, unit, hz, insisted) -> Reading:
    """The unit that the file states, asked about where it makes a rate that no sensor has."""
    if usual_rate(hz(unit)) < 1e-3 and not insisted and len(stamp) > 10:
        likely = likely_unit(stamp, first)
        raise InputError(
            f"{where} states {unit}, which makes {hz(unit):.4g} Hz"
            + (f" (in {likely} it would be {hz(likely):.4g} Hz)" if likely else "")
            + f"; give --time-unit {likely or unit}, or --time-unit {unit} if it is right."
        )
    return Reading(unit, spelling.TIME_UNITS[unit], f"states {unit}: {hz(unit):.5g} Hz", True)


def _by_rate(stamp, where, likely, rate, hz, step, rate_given) -> Reading | None:
    """The unit that makes the rate which the call or the file states; None where a file's
    makes none.
    """
    near = [u for u in likely if u not in ("counter", "ticks") and 0.7 < hz(u) / rate < 1.4]
    if near:
        return Reading(
            near[0],
            spelling.stated_time(near[0]),
            f"no unit stated: read as {near[0]}, which makes {hz(near[0]):.5g} Hz, as the stated "
            "rate",
            False,
        )
    if not rate_given:
        return None
    if is_count(stamp):
        return Reading("counter", None, f"counts the samples; {rate:g} Hz by --rate", False)
    order = sorted((w for u, w in likely.items() if u not in ("counter", "ticks")), reverse=True)
    order += [0.0, 0.0]
    if order[0] < ODDS * order[1] or order[0] < OPEN:  # its unit would be asked for
        ticks = step * rate
        said = f"no unit stated: {ticks:.6g} ticks a second make the {rate:g} Hz of --rate"
        return Reading(f"ticks:{ticks:.10g}", 1.0 / ticks, said, False)
    raise InputError(
        f"{where} steps by {step:.6g}, which makes {rate:g} Hz in no usual unit; give --time-unit "
        f"ticks:{step * rate:.6g} if it counts ticks, "
        "or leave the stamps out with --time-unit none --rate HZ."
    )


def doubt(stamp: np.ndarray, first: float, told: Reading, heading: str) -> tuple[str, ...]:
    """A sentence where a stated unit makes an unusual rate and another one a usual one."""
    rate = 1.0 / (mean_step(stamp) * told.factor)
    other = likely_unit(stamp, first)
    if usual_rate(rate) >= 0.1 or other in (None, told.unit) or len(stamp) < 20:
        return ()
    better = 1.0 / (mean_step(stamp) * spelling.TIME_UNITS[other])
    if usual_rate(better) < 0.9:
        return ()
    return (
        f"`{heading}` states {told.unit}, which makes {rate:.4g} Hz: unusual for such a sensor "
        f"(in {other} it would be {better:.4g} Hz; --time-unit {other}).",
    )


def likely_unit(stamp, first) -> str | None:
    """The unit of time that the stamps look like, None where no unit does."""
    likely = {u: w for u, w in weights(stamp, first).items() if u in spelling.TIME_UNITS}
    best = max(likely, key=likely.get)
    return best if likely[best] > 1e-3 else None


def _question(where, stamp, order, likely, hz, step) -> str:
    """What is asked where two readings remain."""
    told = [u for u in order if likely[u] * ODDS * ODDS > likely[order[0]] and likely[u] > 1e-5]
    readings = []
    for u in told:
        if u == "counter":
            readings.append("as a count of samples it has no rate (--rate HZ)")
        elif u == "ticks":
            tenth = f", {1e4 / step:.4g} Hz with ticks:10000" if usual_rate(1e4 / step) == 1 else ""
            readings.append(
                f"as ticks of a clock it has the ticks' rate (--time-unit ticks:HZ{tenth})"
            )
        else:
            readings.append(f"in {u} it would be {hz(u):.4g} Hz (--time-unit {u})")
    if not readings:
        readings = ["no usual unit gives a rate between 1 and 20000 Hz"]
    return (
        f"{where} does not state the unit of its time, which steps by {step:.6g}: "
        f"{'; '.join(readings)}; say which with --time-unit s, ms, us, ns, min or ticks:HZ, or "
        "give --rate HZ."
    )
