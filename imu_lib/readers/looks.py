"""What numbers look like, whatever their columns are called: a time, gravity, nothing at all."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from imu_lib import units

#: Lengths of gravity: its unit, and counts per g of sensors with 8 to 16 bits.
GRAVITIES = {"m/s^2": units.G, "g": 1.0, "mg": 1000.0, "cm/s^2": 100 * units.G}
COUNTS = (64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384)
NEAR = 0.06  # of gravity: what offsets and a scale factor do
STILL = 0.05  # of its length, by which gravity scatters at rest


def rises(x) -> bool:
    """Whether nine steps in ten are up."""
    step = np.diff(np.asarray(x, dtype=float))
    return bool(len(step) and (step > 0).mean() > 0.9)


def moves(x) -> bool:
    """Whether the numbers are not all the same."""
    x = np.asarray(x, dtype=float)
    return bool(np.nanmax(x) > np.nanmin(x)) if np.isfinite(x).any() else False


def unevenness(x) -> float:
    """Spread of the steps of stamps over their usual length."""
    x = np.asarray(x, dtype=float) if np.asarray(x).dtype.kind in "fiu" else np.empty(0)
    step = np.diff(x - x[0]) if len(x) > 20 else np.empty(0)
    usual = float(np.median(step)) if step.size else 0.0
    if not usual > 0:
        return float("inf")
    low, high = np.quantile(step, (0.1, 0.9))
    return float((high - low) / usual)


def lengths(three: Sequence) -> np.ndarray:
    """Length of the vector of three columns in every row that has all of them."""
    x = np.column_stack([np.asarray(x, dtype=float) for x in three])
    return np.linalg.norm(x[np.isfinite(x).all(axis=1)], axis=1)


def is_gravity(three: Sequence) -> bool:
    """Whether the length of three columns stands still at that of gravity in m/s^2, g or mg."""
    size = lengths(three)
    middle = float(np.median(size)) if size.size else 0.0
    near = any(0.8 < middle / GRAVITIES[u] < 1.25 for u in ("m/s^2", "g", "mg"))
    return near and float(size.std()) < 0.2 * middle


def steadier(first: Sequence, second: Sequence) -> bool:
    """Whether three columns look more like gravity than three others: a length that varies less."""
    spread = []
    for three in (first, second):
        size = lengths(three)
        spread.append(float(size.std() / size.mean()) if size.size and size.mean() > 0 else 1.0)
    return spread[0] < 0.5 * spread[1]


def gravity_said(three: Sequence) -> str:
    """A clause on the unit in which the length of three columns at rest is gravity; empty where
    it is in none, or they are not at rest.
    """
    size = lengths(three)
    middle = float(np.median(size)) if size.size else 0.0
    if not middle > 0 or float(size.std()) > STILL * middle:
        return ""
    fit = [u for u, g in GRAVITIES.items() if abs(middle / g - 1.0) < NEAR]
    fit += [f"counts:{c}" for c in COUNTS if abs(middle / c - 1.0) < NEAR]
    return f" (their length is {middle:.4g}: gravity in {' or '.join(fit)})" if fit else ""
