"""Is the stated unit of an accelerometer possible? Gravity tells."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from imu_lib import units
from imu_lib.readers import names
from imu_lib.readers.turning import MOST

GRAVITY = (7.0, 13.0)  # m/s^2; a poor accelerometer is 10 % off, a bumpy ride averages out


NEAR_ONE = 0.03  # of 1 (g): a length that close to one in m/s^2 is gravity in g


OFF_GRAVITY = 0.04  # share by which the specific force at rest may be off gravity without a word
OFF_FAR = 0.12  # and from which a scale factor does not explain it


class Told(NamedTuple):
    """why: a sentence. refused: the unit cannot be; otherwise it is unusual. likely: the unit it
    more likely is, None where none fits. also: other units that fit as well.
    """

    why: str
    refused: bool
    likely: str | None
    also: tuple[str, ...] = ()


def gravity(accel: np.ndarray) -> float | None:
    """Median length of the specific force (n, 3) where it is the length of one vector, None where
    gravity was taken out.
    """
    accel = some(accel)
    if len(accel) < 2:
        return None
    size = np.linalg.norm(accel, axis=1)
    middle = float(np.median(size))
    if middle == 0.0:
        return None
    spread = float(np.quantile(size, 0.75) - np.quantile(size, 0.25)) / middle
    # zero-mean noise has a spread of about 0.6 and a mean vector near 0; a vector that only turns
    # has a small spread
    return middle if np.linalg.norm(accel.mean(axis=0)) > 0.5 * middle or spread < 0.3 else None


def without_gravity(accel: np.ndarray) -> bool:
    """Whether a specific force (n, 3) m/s^2 is that of a device which took gravity out."""
    size = gravity(accel)
    return size is None or size < 0.5


def accel_unit(accel: np.ndarray, unit: str, factor: float) -> Told | None:
    """What is wrong with `accel` (n, k) m/s^2, stated in `unit`; None where nothing is.

    With fewer than three axes the length is a lower bound of gravity: above it nothing can be, and
    a length of one, to a few per cent, is gravity in g.
    """
    axes = accel.shape[1]
    size = gravity(accel) if axes == 3 else _length(accel)
    if size is None:
        return None
    if axes == 3 and GRAVITY[0] < size < GRAVITY[1]:
        return _near_gravity(accel, size)
    if axes < 3 and size < GRAVITY[1]:
        return _of_few_axes(size, unit, size / factor, axes)
    return _far_from_gravity(size, unit, size / factor, axes)


def _near_gravity(accel: np.ndarray, size: float) -> Told | None:
    """A word where a sensor at rest shows less or more than gravity; refused where that is more
    than a scale factor and one axis in g would explain it.
    """
    off = size / units.G - 1.0
    if abs(off) <= OFF_GRAVITY or not _steady(accel):
        return None
    said = (
        f"the specific force at rest is {size:.4g} m/s^2, {abs(100 * off):.2g} % "
        f"{'above' if off > 0 else 'below'} gravity"
    )
    mean = np.median(some(accel), axis=0)
    for axis, i in zip("xyz", range(3)):
        whole = np.linalg.norm(np.where(np.arange(3) == i, mean * units.G, mean))
        if abs(off) > OFF_FAR and abs(whole / units.G - 1.0) < NEAR_ONE:
            return Told(f"{said}, and with its {axis} axis in g it would be gravity", True, None)
    return Told(f"{said}: a scale factor, or offsets", False, None)


def _of_few_axes(size: float, unit: str, read: float, axes: int) -> Told | None:
    """Refused where one or two axes in m/s^2 have the length of gravity in g or mg."""
    near = [
        u
        for u in ("g", "mg")
        if u != unit and abs(read * names.ACCEL_UNITS[u] / units.G - 1.0) < NEAR_ONE
    ]
    if not near or unit != "m/s^2":
        return None
    return Told(
        f"the specific force stated in {unit} has a length of {read:.4g} in its {axes} "
        f"{'axes' if axes > 1 else 'axis'}, which is gravity in {near[0]}; its unit is likely "
        f"{near[0]}",
        True,
        near[0],
    )


def _far_from_gravity(size: float, unit: str, read: float, axes: int) -> Told | None:
    """Refused, with the units in which such a length would be gravity."""
    fit = [
        u
        for u in ("m/s^2", "g", "mg", "cm/s^2", "ft/s^2", "ug", "mm/s^2")
        if (GRAVITY[0] if axes == 3 else 0.5) < read * names.ACCEL_UNITS[u] < GRAVITY[1]
        and u != unit
    ]
    said = f"the specific force stated in {unit} has a median length of {read:.4g}, "
    if fit:
        if axes == 3:  # mg and cm/s^2 are 2 % apart: the nearer one first
            fit.sort(key=lambda u: abs(np.log(read * names.ACCEL_UNITS[u] / units.G)))
        return Told(
            f"{said}that is {size / units.G:.3g} times gravity; its unit is likely "
            f"{' or '.join(fit)}",
            True,
            fit[0],
            tuple(fit[1:]),
        )
    if size < 0.5:
        return None  # what is left when gravity was taken out
    how = (
        f"if these are counts, counts:{read:.5g} (per g) is near"
        if read > 50
        else "check its unit and scale"
    )
    return Told(f"{said}{size / units.G:.3g} times gravity; {how}", True, None)


def _length(accel: np.ndarray) -> float | None:
    """Length of the mean vector of fewer than three axes."""
    x = some(accel)
    return float(np.linalg.norm(np.median(x, axis=0))) if len(x) > 1 else None


def _steady(accel: np.ndarray) -> bool:
    """Whether the specific force keeps its direction and length: the sensor is at rest."""
    x = some(accel)
    parts = np.array_split(x, 20) if len(x) > 200 else [x]
    means = np.array([p.mean(axis=0) for p in parts])
    return bool(np.ptp(means, axis=0).max() < 0.3 and np.median(x.std(axis=0)) < 1.0)


def some(x: np.ndarray) -> np.ndarray:
    """At most MOST rows without NaN, neighbours kept together."""
    x = x[: 2 * MOST]
    return x[~np.isnan(x).any(axis=1)][:MOST]
