"""The mechanization against closed forms and against the simulator's exact increments."""

import numpy as np
import pymap3d
import pytest

from imu_lib.navigation import attitude, earth, strapdown, trajectory


def town(minutes, seed):
    """A car zigzagging through a town with slopes, for at least `minutes`."""
    rng = np.random.default_rng(seed)
    count = int(5 * minutes)
    length = rng.uniform(150, 400, count)
    course = np.cumsum(rng.choice([-np.pi / 2, 0.0, np.pi / 2, 0.3, -0.3], count))
    return trajectory.from_waypoints(
        np.column_stack(
            [
                np.cumsum(length * np.cos(course)),
                np.cumsum(length * np.sin(course)),
                np.cumsum(rng.uniform(-8, 8, count)),
            ]
        )
    )


def free(path, time):
    truth = path.sample(time)
    dtheta, dvel = path.increments(time)
    return truth, strapdown.integrate(
        time,
        dtheta,
        dvel,
        position=truth.position[0],
        velocity=truth.velocity[0],
        attitude_=truth.attitude[0],
    )


def test_sixty_minutes_of_exact_increments_come_back_to_the_truth():
    path = town(60, 1)
    truth, navigation = free(path, np.arange(360_001) * 0.01)
    assert (
        np.linalg.norm(earth.meters(navigation.position, truth.position), axis=1).max() < 0.1
    )  # the height diverges by exp(3600 s / 570 s)
    assert (
        np.ptp(truth.attitude[:, 2]) > 3.0 and np.hypot(*truth.velocity[:, :2].T).max() > 10.0
    )  # a drive, not a standstill


def test_error_falls_with_the_square_of_the_interval_or_faster():
    path = town(10, 2)
    misses = []
    for dt in (0.04, 0.02):
        truth, navigation = free(path, np.arange(0.0, 300.0, dt))
        misses.append(np.linalg.norm(earth.meters(navigation.position, truth.position)[-1]))
    assert misses[1] < misses[0] / 4


def test_a_stationary_day_stays_where_it_is():
    dt, latitude = 1.0, np.radians(45.0)
    n = 86_400
    body = attitude.matrix([0.02, -0.03, 1.0])
    rate = body.T @ (earth.RATE * np.array([np.cos(latitude), 0.0, -np.sin(latitude)]))
    force = body.T @ np.array([0.0, 0.0, -earth.gravity(latitude, 0.0)])
    navigation = strapdown.integrate(
        np.arange(n + 1) * dt,
        np.tile(rate * dt, (n, 1)),
        np.tile(force * dt, (n, 1)),
        position=[latitude, 0.1, 0.0],
        velocity=np.zeros(3),
        attitude_=[0.02, -0.03, 1.0],
        hold_height=True,
    )
    offset = earth.meters(navigation.position, navigation.position[0])
    assert (
        np.abs(offset[:, :2]).max() < 0.1
    )  # one-second steps, a hundred times a sensor's interval
    assert np.abs(attitude.wrap(navigation.attitude - navigation.attitude[0])).max() < 1e-7


def test_a_velocity_error_swings_with_the_schuler_period():
    latitude, dt, n = np.radians(45.0), 1.0, 3 * 5064
    rate = earth.RATE * np.array([np.cos(latitude), 0.0, -np.sin(latitude)])
    force = np.array([0.0, 0.0, -earth.gravity(latitude, 0.0)])
    navigation = strapdown.integrate(
        np.arange(n + 1) * dt,
        np.tile(rate * dt, (n, 1)),
        np.tile(force * dt, (n, 1)),
        position=[latitude, 0.0, 0.0],
        velocity=[0.1, 0.0, 0.0],
        attitude_=np.zeros(3),
        hold_height=True,
    )
    # Foucault's precession turns the plane of the swing; in the frame that turns with it the swing
    # is a plain one
    north, east = navigation.velocity[:, 0], navigation.velocity[:, 1]
    inclination = np.exp(-1j * earth.RATE * np.sin(latitude) * navigation.time)
    swing = ((north + 1j * east) * inclination).real
    crossing = navigation.time[1:][np.diff(np.sign(swing)) != 0]
    period = 2.0 * np.diff(crossing).mean()
    meridian, transverse = earth.radii(latitude)
    expected = 2.0 * np.pi * np.sqrt(np.sqrt(meridian * transverse) / earth.gravity(latitude, 0.0))
    # the ellipsoid's two radii differ by 0.35 %
    assert period == pytest.approx(expected, rel=2e-3)


def test_a_great_circle_along_the_equator():
    speed, dt, n = 200.0, 0.1, 36_000
    radius = earth.SEMI_MAJOR
    rate = np.array([earth.RATE + speed / radius, 0.0, 0.0])
    force = np.array(
        [0.0, 0.0, -earth.gravity(0.0, 0.0) + speed * (2.0 * earth.RATE + speed / radius)]
    )
    navigation = strapdown.integrate(
        np.arange(n + 1) * dt,
        np.tile(rate * dt, (n, 1)),
        np.tile(force * dt, (n, 1)),
        position=np.zeros(3),
        velocity=[0.0, speed, 0.0],
        attitude_=np.zeros(3),
        hold_height=True,
    )
    assert navigation.position[-1, 1] == pytest.approx(speed * 3600.0 / radius, abs=1e-9)
    assert (
        abs(navigation.position[-1, 0]) * radius < 1e-3 and abs(navigation.position[-1, 2]) < 1e-3
    )


def test_offsets_agree_with_pymap3d_and_come_back():
    rng = np.random.default_rng(3)
    origin = np.array([0.787, 0.134, 240.0])
    there = earth.shift(origin, rng.uniform(-2000, 2000, (50, 3)))
    north, east, down = pymap3d.geodetic2ned(
        there[:, 0], there[:, 1], there[:, 2], *origin, deg=False
    )
    # pymap3d's frame is one tangent plane: over 2 km the Earth falls away by d^2/2R and height
    # stretches the arcs
    assert np.abs(earth.meters(there, origin) - np.column_stack([north, east, down])).max() < 2.0
    near = earth.shift(origin, rng.uniform(-20, 20, (50, 3)))
    flat = np.column_stack(
        pymap3d.geodetic2ned(near[:, 0], near[:, 1], near[:, 2], *origin, deg=False)
    )
    assert np.abs(earth.meters(near, origin) - flat).max() < 1e-3
    assert (
        np.abs(
            earth.meters(earth.shift(origin, [123.0, -45.0, 6.0]), origin) - [123.0, -45.0, 6.0]
        ).max()
        < 1e-6
    )


def test_euler_angles_and_quaternions_are_one_rotation():
    angles = np.random.default_rng(4).uniform(-1.4, 1.4, (20, 3))
    assert np.abs(attitude.euler(attitude.quaternion(angles)) - angles).max() < 1e-12
    c = np.empty((3, 3))
    attitude.fill_matrix(attitude.quaternion(angles[0]), c)
    assert np.abs(c - attitude.matrix(angles[0])).max() < 1e-14


def test_a_reference_trajectory_is_followed():
    path = town(5, 5)
    truth = path.sample(np.arange(0.0, 250.0, 0.05))
    again = trajectory.from_navigation(truth).sample(truth.time)
    inside = slice(40, -40)
    assert (
        earth.horizontal(again.position, truth.position)[inside].max() < 0.05
    )  # half-second knots round the corners by centimetres
    assert np.abs(again.velocity - truth.velocity)[inside].max() < 0.2
