"""IMU data without a hole, as increments; what is missing is bridged by straight lines."""

from dataclasses import dataclass

import numpy as np

NEAR = 31  # samples on either side of a hole that say how long it is
BRIDGE_NOISE = 100.0  # white noise densities are multiplied by this over a bridged hole


@dataclass(frozen=True)
class Stretch:
    """IMU data without a hole. time (n+1,) s: epochs, the first sample being the start; dt (n,),
    dtheta, dvel (n, 3): the intervals.
    """

    time: np.ndarray
    dt: np.ndarray
    dtheta: np.ndarray
    dvel: np.ndarray
    extra_noise: np.ndarray


def bridged(t, readings, rate):
    """Times, readings (n, 6) and factors of the noise with straight lines over missing samples,
    and how many these are.
    """
    noise = np.ones(t.size)
    missing = np.maximum(np.rint(np.diff(t) * rate).astype(int) - 1, 0)
    missing[np.diff(t) < 1.5 / rate] = 0
    if missing.any():
        missing = np.minimum(missing, _lost(t, rate))
    if not missing.any():
        return t, readings, noise, 0
    parts = missing + 1
    within = np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts)
    whole = np.append(
        np.repeat(t[:-1], parts) + within * np.repeat(np.diff(t) / parts, parts), t[-1]
    )
    noise = np.append(np.repeat(np.where(missing > 0, BRIDGE_NOISE, 1.0), parts), 1.0)
    readings = np.column_stack([np.interp(whole, t, column) for column in readings.T])
    return whole, readings, noise, int(missing.sum())


def _lost(t, rate):
    """How many samples are lost after each (n-1,), by the stamps of several on either side: jitter
    of single stamps is no loss.
    """
    ahead = t * rate - np.arange(t.size)
    padded = np.pad(ahead, NEAR - 1, mode="reflect" if t.size > NEAR else "edge")
    middle = np.median(np.lib.stride_tricks.sliding_window_view(padded, NEAR), axis=1)
    # window k ends at sample k; that of the samples after k begins NEAR windows later
    return np.maximum(np.rint(middle[NEAR:] - middle[:-NEAR]), 0).astype(int)


def of_readings(t, readings, noise, sampling):
    """The increments of readings (n, 6) at times t (n,)."""
    dt = np.diff(t)
    mean = readings[1:] if sampling == "average" else 0.5 * (readings[1:] + readings[:-1])
    increments = mean * dt[:, None]
    gyro, accel = (np.ascontiguousarray(increments[:, k : k + 3]) for k in (0, 3))
    return Stretch(t, dt, gyro, accel, noise[1:])
