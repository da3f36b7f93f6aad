"""In what unit are these stamps? The one stated, or the likeliest (`odds`); where two readings
remain, it is asked.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers import spelling
from imu_lib.readers.odds import EPOCH, is_count, mean_step, tenths, usual_rate, weights

ODDS = 15.0  # the best reading must be this much likelier than the next one
OPEN = 0.05  # weight below which no unit is likely
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
