"""Counts of a register with a sign that were written without it: 65535 for -1."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from imu_lib.readers import spelling
from imu_lib.readers.gravity import GRAVITY
from imu_lib.readers.meaning import WORD
from imu_lib.readers.raw import Raw
from imu_lib.readers.streams import kind_of

BITS = (16, 24, 32)
NEAR = 0.25  # of the range: both ends are in use, and the middle is not


def signed(raw: Raw, units: Mapping[str, str | None]) -> None:
    """Give such columns their sign, with a word.

    They are whole numbers below 2^16 (2^24, 2^32). What tells is a column that leaps between both
    ends of that range, gyros that stand near its ends, or a specific force (`units` as the call
    states them, counts:C) that is gravity with the sign and not without.
    """
    counts = [k for k in ("gyro", "accel") if _counts(raw, k, units.get(k))]
    found = {k: _bits(raw, k) for k in counts}
    sure = {k for k, bits in found.items() if bits and _tells(raw, k, bits, units.get(k))}
    if not sure:
        return
    for kind, bits in found.items():
        if bits is None:
            continue
        for c in [c for c in raw.columns if kind_of(c) == kind]:
            x = np.asarray(raw.columns[c])
            raw.columns[c] = np.where(x >= 2.0 ** (bits - 1), x - 2.0**bits, x)
        word = WORD[kind]
        raw.notes += (
            f"The counts of the {word} are above 0 and reach into the upper half of 2^{bits}: they "
            f"were read with a sign (two's complement of {bits} bits).",
        )


def _counts(raw: Raw, kind: str, flag: str | None) -> bool:
    """Whether neither the file nor the call states another unit than counts."""
    said = {raw.units.get(c) for c in raw.columns if kind_of(c) == kind}
    return said <= {None, "counts"} and (flag or "counts").lower().startswith("counts")


def _bits(raw: Raw, kind: str) -> int | None:
    """Bits of the register that the columns of a kind fill; None where they are no such counts."""
    columns = [np.asarray(x) for c, x in raw.columns.items() if kind_of(c) == kind]
    if not columns or any(not _whole(x) for x in columns):
        return None
    top = max(float(np.nanmax(x)) for x in columns)
    return next((b for b in BITS if 2.0 ** (b - 1) <= top < 2.0**b), None)


def _tells(raw: Raw, kind: str, bits: int, accel_unit: str | None) -> bool:
    columns = [np.asarray(x) for c, x in raw.columns.items() if kind_of(c) == kind]
    size = 2.0**bits
    if any(_leaps(x, size) for x in columns):
        return True
    if kind == "gyro":
        ends = [((x < NEAR * size) | (x >= (1 - NEAR) * size)).mean() > 0.999 for x in columns]
        return all(ends)
    if accel_unit is None or not accel_unit.lower().startswith("counts:"):
        return False
    factor, zero, _ = spelling.stated(accel_unit, "accel")
    middle = np.array([np.nanmedian(x) for x in columns])
    with_sign = np.where(middle >= size / 2, middle - size, middle)
    plain, turned = (np.linalg.norm(x - zero) * factor for x in (middle, with_sign))
    return bool(GRAVITY[0] < turned < GRAVITY[1] and not GRAVITY[0] < plain < GRAVITY[1])


def _whole(x: np.ndarray) -> bool:
    if x.dtype.kind not in "fiu" or not len(x):
        return False
    good = x[np.isfinite(x)] if x.dtype.kind == "f" else x
    return bool(len(good) and good.min() >= 0 and (good == np.rint(good)).all())


def _leaps(x: np.ndarray, size: float) -> bool:
    low, high = (x < NEAR * size).mean(), (x >= (1 - NEAR) * size).mean()
    return bool(low + high > 0.999 and min(low, high) * len(x) >= 3)
