"""Stamps and counters that fall: wrapped, out of order, or set back."""

from __future__ import annotations

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers.raw import Raw
from imu_lib.readers.spelling import TIME_UNITS

#: Where a counter of stamps begins anew: bits of a register, the same in ms and s, a week, a day.
WRAPS = {
    1e3: "a thousand", 1e6: "a million", 1e9: "a thousand million",
    2.0**8: "8 bits", 2.0**16: "16 bits", 2.0**24: "24 bits", 2.0**32: "32 bits",
    2.0**32 / 1e3: "32 bits of a thousandth", 2.0**32 / 1e6: "32 bits of a millionth",
    604_800.0: "a week", 604_800e3: "a week", 86_400.0: "a day", 86_400e3: "a day",
}  # fmt: skip
NEAR = 20  # samples within which a row out of order is followed by the one it left out


def rising(raw: Raw, stamp: np.ndarray, where: str) -> tuple[np.ndarray, np.ndarray]:
    """Stamps that never fall, and the order of the rows.

    A counter that wraps is unwrapped; messages of a bag that overtook each other are put in place;
    a clock that was set back (or a logger that began anew) goes on by one interval. Anything else
    is refused.
    """
    order = np.arange(len(stamp))
    step = np.diff(stamp)
    falls = np.flatnonzero(step < 0) + 1
    if not falls.size:
        return stamp, order
    if (step <= 0).all() and not raw.contract:
        newest_first(raw)
        return stamp[::-1], order[::-1]
    _refuse_intervals(raw, stamp, len(falls) / len(step), where)
    ups = step[step > 0]
    usual = float(np.median(ups)) if ups.size else 0.0
    unwrapped = _unwrapped(raw, stamp, falls, usual)
    if unwrapped is not None:
        return unwrapped, order
    if raw.received:
        sorted_ = np.argsort(stamp, kind="stable")
        moved = np.abs(sorted_ - order)
        if moved.max() <= NEAR:
            raw.notes += (
                f"{int((np.diff(sorted_) < 0).sum()):,} messages were out of order and put in "
                "place by their stamps.",
            )
            return stamp[sorted_], sorted_
    if not raw.contract and (sorted_ := _swapped(stamp, usual)) is not None:
        raw.notes += (
            f"Rows were out of order at {falls.size:,} place{'s' * (falls.size > 1)} and put back "
            "by their stamps, between which none is missing then.",
        )
        return stamp[sorted_], sorted_
    back = [i for i in falls if _set_back(stamp, i)]
    if len(back) != falls.size or falls.size > max(3, len(stamp) // 500):
        row = int(next((i for i in falls if i not in back), falls[0]))
        raise InputError(
            f"{where}, {raw.line(row)}: the time falls from {stamp[row - 1]:.15g} to "
            f"{stamp[row]:.15g}; sort the rows by time, "
            "or leave the stamps out with --time-unit none --rate HZ, which keeps the rows in the "
            "order of the file."
        )
    raw.set_back = tuple(
        (int(i), float(stamp[i] - stamp[i - 1] - usual)) for i in falls
    )  # told when the unit is known
    stamp = stamp.copy()
    for i in falls:
        shift = stamp[i - 1] + usual - stamp[i]
        stamp[i:] += int(round(shift)) if stamp.dtype.kind == "i" else shift
    return stamp, order


def _unwrapped(raw: Raw, stamp: np.ndarray, falls: np.ndarray, usual: float) -> np.ndarray | None:
    """Stamps of a counter that began anew at every fall; None where they are none of a register."""
    top = float(stamp.max())
    for wrap, name in sorted(WRAPS.items()):
        low = wrap / 2 if stamp.min() < 0 else 0.0  # a register with a sign begins at its least
        if top + low >= wrap or stamp.min() < -low or top < 0.5 * wrap - 0.1 * low:
            continue
        if low and (top < 0.8 * low or "bits" not in name):
            continue
        if wrap in (1e3, 1e6, 1e9) and not (falls.size > 2 and top > 0.9 * wrap):
            continue  # a fraction of a second, of which the seconds are elsewhere
        after = stamp[falls] - stamp[falls - 1] + wrap
        if ((after > 0) & (after < 60 * usual)).all():
            turn = int(wrap) if stamp.dtype.kind == "i" and wrap == int(wrap) else wrap
            times = f"{falls.size} time{'s' * (falls.size > 1)}"
            raw.notes += (
                f"The stamps wrap at {wrap:.10g} ({name}), {times}; they were unwrapped.",
            )
            add = np.zeros(len(stamp), dtype=type(turn))
            add[falls] = turn
            return stamp + np.cumsum(add)
    return None


def _swapped(stamp: np.ndarray, usual: float) -> np.ndarray | None:
    """The order of rows by their stamps, where neighbours changed places and each fits into a gap
    of one interval that it left; None where a clock may have been set back.
    """
    order = np.argsort(stamp, kind="stable")
    if np.abs(order - np.arange(len(stamp))).max() > NEAR:
        return None
    step = np.diff(stamp[order]) / usual if usual > 0 else np.zeros(1)
    some = step[step > 0]  # what was delivered twice has one stamp
    if not len(some) or len(some) < 0.95 * len(step):
        return None
    return order if 0.7 < some.min() and some.max() < 1.3 else None


def _refuse_intervals(raw: Raw, stamp: np.ndarray, fall: float, where: str) -> None:
    """InputError where values that fall as often as they rise are about one length: durations."""
    mean = float(stamp.mean())
    if fall < 0.2 or stamp.min() <= 0 or float(stamp.std()) > 0.5 * mean:
        return
    per = TIME_UNITS.get(raw.units["time"] or "")
    told = (
        f" --rate {1.0 / (mean * per):.4g}, if each row came so long after the one before"
        if per
        else " --rate HZ"
    )
    raise InputError(
        f"{where}: its values do not rise; they are durations of about {mean:.4g}, no stamps; "
        f"leave them out with --time-unit none{told}."
    )


def newest_first(raw: Raw) -> None:
    """Say that the rows are read from the last to the first."""
    line, last = raw.line, raw.rows() - 1
    raw.line = lambda row: line(max(last - row, 0))
    raw.notes += ("The newest row stands first; the rows were put in the order of time.",)


def _set_back(stamp: np.ndarray, i: int) -> bool:
    """Whether the clock was set back at row i: it rises before and after, and does not jump
    forward again at once.
    """
    fall = float(stamp[i - 1] - stamp[i])
    after = np.diff(stamp[i : i + NEAR + 1])
    before = np.diff(stamp[max(0, i - NEAR) : i])
    if len(after) < 2 or len(before) < 2:
        return False
    usual = float(np.median(np.r_[before, after]))
    return bool(
        (after >= 0).all()
        and (before >= 0).all()
        and usual > 0
        and after.max() < max(0.5 * fall, 1.5 * usual)
    )


def counted(raw: Raw, canonical: str, rate: float) -> np.ndarray:
    """Seconds of samples that are numbered; a counter of few bits is unwrapped."""
    number = np.asarray(raw.columns[canonical])
    if not np.isfinite(number.astype(float)).all():
        return np.arange(raw.rows()) / rate
    number = np.rint(number).astype(np.int64)
    step = np.diff(number)
    if (step < 0).any():
        top = int(number.max()) + 1
        wrap = next((w for w in (100, 256, 1000, 10_000, 65_536, 2**24, 2**32) if w >= top), None)
        if wrap is None or (step < 0).sum() > 2 + len(step) * 2 // max(wrap // 2, 1):
            return np.arange(raw.rows()) / rate
        number = number + np.cumsum(np.r_[0, step < 0]) * wrap
    if (np.diff(number) < 0).any() or not is_one(number):
        return np.arange(raw.rows()) / rate
    return (number - number[0]) / rate


def is_one(number: np.ndarray) -> bool:
    return bool(np.median(np.diff(number)) == 1)
