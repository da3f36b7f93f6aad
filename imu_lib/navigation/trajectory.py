"""True motion: splines of position and attitude, and from them the exact readings of error-free
sensors.

Rate and specific force are analytic functions of the splines; their integrals over a sampling
interval are taken by
Gauss-Legendre quadrature, so that the increments are exact to rounding at any rate (Groves 2013,
Eqs. 5.14, 5.53).
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline, make_lsq_spline

from . import attitude, earth
from .strapdown import Navigation

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)


@dataclass(frozen=True)
class Trajectory:
    """Motion between `start` and `stop` (s): quintic splines of latitude, longitude, height and of
    roll, pitch, yaw.
    """

    position: BSpline
    angles: BSpline
    start: float
    stop: float

    def sample(self, time):
        """The true Navigation (position, velocity, attitude) at `time`, ndarray, shape (n,), s."""
        time = np.asarray(time, float)
        angles = self.angles(time)
        return Navigation(
            time,
            self.position(time),
            self._velocity(time)[0],
            np.column_stack([angles[:, 0], angles[:, 1], attitude.wrap(angles[:, 2])]),
        )

    def _velocity(self, time):
        """NED velocity and its derivative in the navigation frame, (n, 3) each."""
        p, d1, d2 = self.position(time), self.position(time, 1), self.position(time, 2)
        sin, cos = np.sin(p[:, 0]), np.cos(p[:, 0])
        w = 1.0 - earth.ECCENTRICITY2 * sin**2
        transverse = earth.SEMI_MAJOR / np.sqrt(w)
        meridian = transverse * (1.0 - earth.ECCENTRICITY2) / w
        slope = (
            earth.ECCENTRICITY2 * sin * cos / w
        )  # d ln(transverse) / d latitude; three times that for the meridian
        north, east = d1[:, 0] * (meridian + p[:, 2]), d1[:, 1] * (transverse + p[:, 2]) * cos
        north_rate = d2[:, 0] * (meridian + p[:, 2]) + d1[:, 0] * (
            3.0 * slope * meridian * d1[:, 0] + d1[:, 2]
        )
        east_rate = (
            d2[:, 1] * (transverse + p[:, 2]) * cos
            + d1[:, 1] * cos * (slope * transverse * d1[:, 0] + d1[:, 2])
            - d1[:, 1] * (transverse + p[:, 2]) * sin * d1[:, 0]
        )
        return np.column_stack([north, east, -d1[:, 2]]), np.column_stack(
            [north_rate, east_rate, -d2[:, 2]]
        )

    def rates(self, time):
        """Point values of what perfect sensors feel: angular rate rad/s and specific force m/s^2,
        body frame, (n, 3) each.
        """
        time = np.asarray(time, float)
        p, d1, angles, turn = (
            self.position(time),
            self.position(time, 1),
            self.angles(time),
            self.angles(time, 1),
        )
        velocity, acceleration = self._velocity(time)
        sin, cos = np.sin(p[:, 0]), np.cos(p[:, 0])
        ie = earth.RATE * np.column_stack([cos, np.zeros_like(cos), -sin])
        en = np.column_stack([d1[:, 1] * cos, -d1[:, 0], -d1[:, 1] * sin])
        gravity = np.zeros_like(velocity)
        gravity[:, 2] = (
            [earth.gravity(a, h) for a, h in zip(p[:, 0], p[:, 2])]
            if time.size < 64
            else _gravity(p)
        )
        force = acceleration + np.cross(2.0 * ie + en, velocity) - gravity
        to_body = np.swapaxes(attitude.matrix(angles), -1, -2)
        roll, pitch = angles[:, 0], angles[:, 1]
        body = np.column_stack(
            [
                turn[:, 0] - turn[:, 2] * np.sin(pitch),
                turn[:, 1] * np.cos(roll) + turn[:, 2] * np.sin(roll) * np.cos(pitch),
                -turn[:, 1] * np.sin(roll) + turn[:, 2] * np.cos(roll) * np.cos(pitch),
            ]
        )
        return body + np.einsum("nij,nj->ni", to_body, ie + en), np.einsum(
            "nij,nj->ni", to_body, force
        )

    def increments(self, time):
        """Exact integrals of rate and specific force over the intervals of `time`.

        time : ndarray, shape (n+1,), s
        returns : (dtheta, dvel), ndarray, shape (n, 3), rad and m/s, in the turning body frame
        """
        time = np.asarray(time, float)
        half, middle = 0.5 * np.diff(time), 0.5 * (time[1:] + time[:-1])
        dtheta, dvel = np.zeros((half.size, 3)), np.zeros((half.size, 3))
        for node, weight in zip(_NODES, _WEIGHTS):
            rate, force = self.rates(middle + node * half)
            dtheta += (weight * half)[:, None] * rate
            dvel += (weight * half)[:, None] * force
        return dtheta, dvel


def _gravity(p):
    s2 = np.sin(p[:, 0]) ** 2
    surface = (
        earth.GRAVITY_EQUATOR
        * (1.0 + earth.GRAVITY_FORMULA * s2)
        / np.sqrt(1.0 - earth.ECCENTRICITY2 * s2)
    )
    first = (
        2.0 / earth.SEMI_MAJOR * (1.0 + earth.FLATTENING * (1.0 - 2.0 * s2) + earth._CENTRIFUGAL)
    )
    return surface * (1.0 - first * p[:, 2] + 3.0 * p[:, 2] ** 2 / earth.SEMI_MAJOR**2)


def from_points(time, ned, origin, *, angles=None):
    """A trajectory through points.

    time : ndarray, shape (k,), s, increasing, at least 6 points
    ned : ndarray, shape (k, 3), north-east-down metres from `origin`
    origin : latitude rad, longitude rad, height m
    angles : ndarray, shape (k, 3), roll, pitch, unwrapped yaw; None for a car (nose along the
    path, held at standstill, level but for the slope)
    """
    time, ned = np.asarray(time, float), np.asarray(ned, float)
    if time.size < 6 or np.any(np.diff(time) <= 0.0):
        raise ValueError("`time` must be increasing with at least 6 points")
    if angles is None:
        angles = course_angles(time, ned)
    return Trajectory(
        make_interp_spline(time, earth.shift(np.asarray(origin, float), ned), k=5),
        make_interp_spline(time, angles, k=5),
        time[0],
        time[-1],
    )


def course_angles(time, ned, *, slowest=0.5):
    """Roll (zero), pitch and yaw of a car on a path: along the velocity where faster than
    `slowest` m/s, interpolated where slower.

    returns : ndarray, shape (k, 3), rad, yaw unwrapped
    """
    velocity = make_interp_spline(time, ned, k=3)(time, 1)
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    moving = np.flatnonzero(speed > slowest)
    if moving.size < 2:
        return np.zeros((time.size, 3))
    yaw = np.interp(
        time, time[moving], np.unwrap(np.arctan2(velocity[moving, 1], velocity[moving, 0]))
    )
    pitch = np.interp(time, time[moving], np.arctan2(-velocity[moving, 2], speed[moving]))
    return np.column_stack([np.zeros_like(yaw), pitch, yaw])


def from_waypoints(
    waypoints,
    *,
    origin=(0.787, 0.134, 240.0),
    speed=14.0,
    acceleration=1.5,
    lateral=2.5,
    corner=12.0,
    standstill=20.0,
):
    """A car driven through waypoints, from rest to rest.

    waypoints : ndarray, shape (k, 2) or (k, 3), north, east (, down) m from `origin`
    speed : m/s, of the straights; acceleration : m/s^2, of starting and braking; lateral : m/s^2,
    the most in a corner
    corner : m, length over which a corner is rounded; standstill : s, at rest before and after
    """
    points = np.asarray(waypoints, float)
    if points.ndim != 2 or points.shape[0] < 2 or points.shape[1] not in (2, 3):
        raise ValueError(
            f"`waypoints` must have shape (k, 2) or (k, 3) with k of at least 2; got {points.shape}"
        )
    points = np.column_stack([points, np.zeros((len(points), 3 - points.shape[1]))])
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    if np.any(np.diff(along) <= 0.0):
        raise ValueError("`waypoints` must not repeat a point")
    s = np.arange(0.0, along[-1] + 0.5, 0.5)
    width = max(int(corner / 0.5), 3)
    path = np.column_stack([np.interp(s, along, points[:, i]) for i in range(3)])
    kernel = np.hanning(width + 2)[1:-1] / np.hanning(width + 2).sum()
    padded = np.vstack(
        [2 * path[0] - path[width:0:-1], path, 2 * path[-1] - path[-2 : -width - 2 : -1]]
    )
    path = np.column_stack([np.convolve(column, kernel, mode="same") for column in padded.T])[
        width:-width
    ]
    fastest = _fastest(path, speed, lateral, acceleration)
    arrival = standstill + np.concatenate([[0.0], np.cumsum(1.0 / (fastest[1:] + fastest[:-1]))])
    time = np.arange(0.0, arrival[-1] + 2 * standstill, 0.5)
    distance = np.interp(time, arrival, s)
    smooth = np.hanning(9)[1:-1] / np.hanning(9).sum()
    distance = np.convolve(np.pad(distance, 3, mode="edge"), smooth, mode="valid")
    return from_points(
        time, np.column_stack([np.interp(distance, s, path[:, i]) for i in range(3)]), origin
    )


def _fastest(path, speed, lateral, acceleration):
    """Speed along a path (n, 3) with a point every half metre, m/s, from rest to rest."""
    d1 = np.gradient(path, 0.5, axis=0)
    d2 = np.gradient(d1, 0.5, axis=0)
    curvature = (
        np.abs(d1[:, 0] * d2[:, 1] - d1[:, 1] * d2[:, 0])
        / np.maximum(np.hypot(d1[:, 0], d1[:, 1]), 1e-6) ** 3
    )
    fastest = np.minimum(speed, np.sqrt(lateral / np.maximum(curvature, 1e-6)))
    fastest[0] = fastest[-1] = 0.05
    # what starting and braking allow, forwards and backwards
    for order in (range(1, len(path)), range(len(path) - 2, -1, -1)):
        for i in order:
            before = i - 1 if order.step > 0 else i + 1
            fastest[i] = min(fastest[i], np.sqrt(fastest[before] ** 2 + acceleration))
    return fastest


def from_navigation(navigation, *, knot_spacing=0.5, angles="course"):
    """The trajectory of a recorded reference: least-squares splines with a knot every
    `knot_spacing` s.

    navigation : Navigation (or anything with time, position, attitude)
    angles : "course" (nose along the path: what to take where the recorded yaw drifts) or
    "recorded"
    """
    time, position = np.asarray(navigation.time, float), np.asarray(navigation.position, float)
    keep = np.concatenate([[True], np.diff(time) > 0.0])
    time, position = time[keep], position[keep]
    knots = np.arange(time[0] + knot_spacing, time[-1] - knot_spacing, knot_spacing)
    index = np.searchsorted(time, knots)
    knots = knots[
        np.concatenate([np.diff(index) > 2, [True]])
    ]  # no knot where the recording has a hole
    knots = np.concatenate([[time[0]] * 6, knots, [time[-1]] * 6])
    path = make_lsq_spline(time, position, knots, k=5)
    grid = np.arange(time[0], time[-1], knot_spacing)
    if angles == "course":
        turned = course_angles(grid, earth.meters(path(grid), position[0]), slowest=2.0)
    elif angles == "recorded":
        recorded = np.unwrap(np.asarray(navigation.attitude, float)[keep], axis=0)
        turned = np.column_stack([np.interp(grid, time, column) for column in recorded.T])
    else:
        raise ValueError(f"`angles` must be 'course' or 'recorded', not {angles!r}")
    return Trajectory(path, make_interp_spline(grid, turned, k=5), grid[0], grid[-1])
