"""Does gravity turn as fast as the gyros say?"""

from __future__ import annotations

import numpy as np


def turning(gyro, accel, rate):
    """(slope of measured gravity's turning on the gyro's, whether the record turned), None where
    it cannot be asked.
    """
    if accel is None or gyro.shape[1] != 3 or accel.shape[1] != 3:
        return None
    block = max(1, int(round(rate * 0.1)))
    n = min(len(gyro), 40 * MOST) // block
    if n < 10:
        return None
    a = accel[: n * block].reshape(n, block, 3).mean(axis=1)
    w = gyro[: n * block].reshape(n, block, 3).mean(axis=1)
    size = np.linalg.norm(a, axis=1, keepdims=True)
    good = np.isfinite(a).all(axis=1) & np.isfinite(w).all(axis=1) & (size[:, 0] > 0)
    if good.sum() < 10:
        return None
    unit_vector = np.where(good[:, None], a / np.where(size > 0, size, 1.0), 0.0)
    dt = block / rate
    turned = (unit_vector[2:] - unit_vector[:-2]) / (2 * dt)  # body axes: d(a)/dt = -w x a
    w = w - np.median(w[good], axis=0)
    smooth = (w[:-2] + 2 * w[1:-1] + w[2:]) / 4  # the rate over the span of the difference
    said = -np.cross(np.where(np.isfinite(smooth), smooth, 0.0), unit_vector[1:-1])
    use = (
        good[2:]
        & good[:-2]
        & good[1:-1]
        & (np.linalg.norm(turned, axis=1) > 0.1)
        & (np.linalg.norm(turned, axis=1) < 3.0)
    )
    if use.sum() < 8:
        return 0.0, False
    x, y = said[use].ravel(), turned[use].ravel()
    if (x @ x) == 0:
        return 0.0, False
    r = float(x @ y / np.sqrt((x @ x) * (y @ y)))
    return float(x @ y / (x @ x)), abs(r) > 0.8


MOST = 200_000  # samples looked at
