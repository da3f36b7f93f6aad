"""WGS-84 Earth: radii, gravity, Earth and transport rate, local offsets.

Position is latitude rad, longitude rad, height m above the ellipsoid; vectors are north-east-down.
The functions of a single epoch are compiled, because the strapdown calls them at every sample.
Source: WGS-84 (NGA.STND.0036) and its closed-form normal gravity (Somigliana), as in Groves 2013,
Eqs. 2.105-2.139.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from imu_lib.arrays import Array, ArrayLike

SEMI_MAJOR = 6378137.0  # m
FLATTENING = 1.0 / 298.257223563
ECCENTRICITY2 = FLATTENING * (2.0 - FLATTENING)
RATE = 7.292115e-5  # rad/s
GRAVITY_EQUATOR = 9.7803253359  # m/s^2
GRAVITY_FORMULA = 1.931852652458e-3  # Somigliana's k
MU = 3.986004418e14  # m^3/s^2
SEMI_MINOR = SEMI_MAJOR * (1.0 - FLATTENING)
_CENTRIFUGAL = RATE**2 * SEMI_MAJOR**2 * SEMI_MINOR / MU


@njit(cache=True, inline="always")
def radii(latitude):
    """Radii of curvature (meridian, transverse), m, at a latitude in rad (Groves 2013, Eqs.
    2.105-2.106).
    """
    s = math.sin(latitude)
    w = 1.0 - ECCENTRICITY2 * s * s
    transverse = SEMI_MAJOR / math.sqrt(w)
    return transverse * (1.0 - ECCENTRICITY2) / w, transverse


@njit(cache=True, inline="always")
def gravity(latitude, height):
    """Normal gravity along the plumb line, m/s^2: Somigliana on the ellipsoid, second order in
    height (Groves 2013, Eqs. 2.134, 2.139).
    """
    s2 = math.sin(latitude) ** 2
    surface = GRAVITY_EQUATOR * (1.0 + GRAVITY_FORMULA * s2) / math.sqrt(1.0 - ECCENTRICITY2 * s2)
    first = 2.0 / SEMI_MAJOR * (1.0 + FLATTENING * (1.0 - 2.0 * s2) + _CENTRIFUGAL)
    return surface * (1.0 - first * height + 3.0 * height**2 / SEMI_MAJOR**2)


def meters(position: ArrayLike, origin: ArrayLike) -> Array:
    """Offsets of `position` from `origin` in north-east-down metres.

    position : ndarray, shape (..., 3), latitude rad, longitude rad, height m
    origin : ndarray, shape (3,) or (..., 3)
    returns : ndarray, shape (..., 3), m

    The arcs are taken at the mean latitude and height, which for offsets of d metres errs by about
    d^3/R^2 (0.02 m over 10 km): right for errors and maps of a drive, not for geodesy.
    """
    position, origin = np.asarray(position, float), np.asarray(origin, float)
    mean = 0.5 * (position + origin)
    s2 = np.sin(mean[..., 0]) ** 2
    transverse = SEMI_MAJOR / np.sqrt(1.0 - ECCENTRICITY2 * s2)
    meridian = transverse * (1.0 - ECCENTRICITY2) / (1.0 - ECCENTRICITY2 * s2)
    d = position - origin
    d_longitude = (d[..., 1] + np.pi) % (2.0 * np.pi) - np.pi
    return np.stack(
        [
            d[..., 0] * (meridian + mean[..., 2]),
            d_longitude * (transverse + mean[..., 2]) * np.cos(mean[..., 0]),
            -d[..., 2],
        ],
        axis=-1,
    )


def shift(origin: ArrayLike, ned: ArrayLike) -> Array:
    """Position reached from `origin` by north-east-down metres: the inverse of `meters`, to the
    same order.

    origin : ndarray, shape (3,) or (n, 3); ned : ndarray, shape (..., 3), m
    returns : ndarray, shape (..., 3)
    """
    origin, ned = np.asarray(origin, float), np.asarray(ned, float)
    out = np.broadcast_to(origin, np.broadcast_shapes(origin.shape, ned.shape)).copy()
    for _ in range(3):  # the radii belong to the mean latitude, which the answer decides
        miss = ned - meters(out, origin)
        s2 = np.sin(out[..., 0]) ** 2
        transverse = SEMI_MAJOR / np.sqrt(1.0 - ECCENTRICITY2 * s2)
        meridian = transverse * (1.0 - ECCENTRICITY2) / (1.0 - ECCENTRICITY2 * s2)
        out = out + np.stack(
            [
                miss[..., 0] / (meridian + out[..., 2]),
                miss[..., 1] / ((transverse + out[..., 2]) * np.cos(out[..., 0])),
                -miss[..., 2],
            ],
            axis=-1,
        )
    return out


def horizontal(position: ArrayLike, reference: ArrayLike) -> Array:
    """Horizontal distance between positions, m: ndarray, shape (...)."""
    d = meters(position, reference)
    return np.hypot(d[..., 0], d[..., 1])
