"""The filter against closed forms, against the 2013 paper's matrices, and against the truth of
simulated drives.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import block_diag

from imu_lib import preset
from imu_lib.model import Model
from imu_lib.navigation import (
    attitude,
    consistency,
    covariance,
    earth,
    models,
    propagation,
    simulation,
    smoother,
    strapdown,
    trajectory,
    turin,
)
from imu_lib.navigation.filter import FilterModel, LooselyCoupled
from imu_lib.navigation.preparation import Gnss
from imu_lib.navigation.states import sensor_states
from imu_lib.navigation.structures import Pieces, Room
from imu_lib.processes import (
    GaussMarkov,
    RandomWalk,
    WhiteNoise,
)
from imu_lib.record import CHANNELS

PAPER = preset("3dm-gx3-25-2013")
START_SD = np.concatenate([[1.0, 1.0, 2.0], np.full(3, 0.05), np.radians([0.3, 0.3, 2.0])])


@pytest.fixture(scope="module")
def path():
    whole = turin.drive(1)
    return trajectory.Trajectory(whole.position, whole.angles, 0.0, 240.0)


@pytest.fixture(scope="module")
def motion(path):
    return simulation.true_motion(path)


@pytest.fixture(scope="module")
def drive(path, motion):
    return simulation.simulate_drive(path, PAPER, np.random.default_rng(1), motion=motion)


def moving_state():
    p, v, angles = (
        np.array([0.787, 0.134, 240.0]),
        np.array([12.0, -7.0, 0.4]),
        np.array([0.03, -0.05, 2.0]),
    )
    return p, v, angles, np.array([0.02, -0.01, 0.2]), np.array([0.8, 1.5, -9.7])


def test_error_dynamics_are_those_of_the_mechanization():
    """F and G against the difference of two strapdown runs, one of them started (or fed) slightly
    off.
    """
    p, v, angles, rate, force = moving_state()
    dt, steps = 0.01, 5
    q0 = attitude.quaternion(angles)
    f, a, d, room = np.empty((9, 9)), np.empty((9, 9)), np.empty((9, 6)), np.empty((9, 9))

    def end(dp, dv, phi, gyro, accel):
        q = q0.copy()
        attitude.rotate_frame(q, -phi[0], -phi[1], -phi[2])
        n = strapdown.integrate(
            np.arange(steps + 1) * dt,
            np.tile((rate + gyro) * dt, (steps, 1)),
            np.tile((force + accel) * dt, (steps, 1)),
            position=earth.shift(p, dp),
            velocity=v + dv,
            attitude_=attitude.euler(q),
        )
        return n.position[-1], n.velocity[-1], n.attitude[-1]

    zero = np.zeros(3)
    base = end(zero, zero, zero, zero, zero)
    middle_v = v + 0.5 * (base[1] - v)
    middle_c = attitude.matrix(0.5 * (angles + base[2]))
    covariance.fill_dynamics(p, middle_v, middle_c @ force, f)
    covariance.fill_transition(f, middle_c, dt * steps, a, d, room)
    scale = np.concatenate(
        [np.full(3, 10.0), np.full(3, 0.1), np.full(3, 2e-5), np.full(3, 1e-3), np.full(3, 0.01)]
    )
    found = np.empty((9, 15))
    for j in range(15):
        pushed = np.zeros(15)
        pushed[j] = scale[j]
        out = end(*pushed.reshape(5, 3))
        turned = attitude.matrix(base[2]) @ attitude.matrix(out[2]).T
        phi = 0.5 * np.array(
            [turned[2, 1] - turned[1, 2], turned[0, 2] - turned[2, 0], turned[1, 0] - turned[0, 1]]
        )
        found[:, j] = (
            np.concatenate([earth.meters(out[0], base[0]), out[1] - base[1], phi]) / scale[j]
        )
    expected = np.column_stack([a, d])
    change = np.hstack([np.eye(9), np.zeros((9, 6))])
    worst = 0.0
    for i in range(0, 9, 3):
        for j in range(0, 15, 3):
            block = expected[i : i + 3, j : j + 3] - change[i : i + 3, j : j + 3]
            miss = np.linalg.norm(found[i : i + 3, j : j + 3] - expected[i : i + 3, j : j + 3])
            if np.linalg.norm(block) * scale[j] > 1e-11:  # below, differences are rounding
                worst = max(worst, miss / np.linalg.norm(block))
    # held constant over 0.05 s, the coefficients err by about half the turn in it (0.01 rad), more
    # in second-order blocks
    assert worst < 0.03


@pytest.mark.parametrize("model", ["18AV", "27AR", "two"])
def test_propagation_agrees_with_full_van_loan(model):
    """A second of the fast, blockwise propagation against the matrix exponential of the whole
    system.
    """
    rng = np.random.default_rng(4)
    if model == "27AR":
        sensors = sensor_states(models.five(names=("27AR",))["27AR"].model, 100.0)
    elif model == "18AV":
        sensors = sensor_states(PAPER, 100.0, turn_on_sd=(1e-3, 0.05), scale_sd=(0.0, 0.01))
    else:
        sensors = sensor_states(
            Model(
                {
                    c: WhiteNoise(N=1e-3)
                    + GaussMarkov(sigma=1e-3, correlation_time=5.0)
                    + RandomWalk(K=1e-4)
                    for c in CHANNELS
                }
            ),
            100.0,
        )
    p, v, angles, _, force = moving_state()
    dt, steps, m = 0.01, 100, sensors.count
    c = attitude.matrix(angles)
    weight = np.where(sensors.driver >= 0, sensors.output * 0.7, sensors.output)
    root = np.diag(
        np.concatenate(
            [
                np.full(3, 2.0),
                np.full(3, 0.1),
                np.full(3, 0.02),
                np.sqrt(np.diag(sensors.initial)) + 1e-6,
            ]
        )
    )
    mix = rng.standard_normal((9 + m, 9 + m))
    whole = root @ (np.eye(9 + m) + 0.1 * mix @ mix.T / (9 + m)) @ root
    nn, ns, ss = (np.ascontiguousarray(x) for x in (whole[:9, :9], whole[:9, 9:], whole[9:, 9:]))
    f, a, d, room = np.empty((9, 9)), np.empty((9, 9)), np.empty((9, 6)), np.empty((9, 9))
    w = np.empty((9, 9)), np.empty((9, m)), np.empty((6, m)), np.empty((9, 6)), np.empty((m, m))
    covariance.fill_dynamics(p, v, c @ force, f)
    covariance.fill_transition(f, c, dt, a, d, room)
    for _ in range(steps):
        covariance.add_white(nn, c, sensors.white, 0.5 * dt)
        propagation.propagate(Pieces(nn, ns, ss), Room(*w), a, d, weight, sensors.arrays())
        covariance.add_white(nn, c, sensors.white, 0.5 * dt)
    fast = np.block([[nn, ns], [ns.T, ss]])
    # the whole system at once: continuous where every process is; a difference equation (AR) steps
    # at its own rate, held between
    h = np.zeros((6, m))
    for ch in range(6):
        h[ch, sensors.first[ch] : sensors.first[ch + 1]] = weight[
            sensors.first[ch] : sensors.first[ch + 1]
        ]
    g = np.zeros((9, 6))
    g[6:, :3], g[3:6, 3:] = -c, c
    q_nav = g @ np.diag(sensors.white) @ g.T
    exact = whole.copy()
    nav_only, q_step = covariance.van_loan(f, q_nav, dt)
    forced, _ = covariance.van_loan(np.block([[f, g], [np.zeros((6, 15))]]), np.zeros((15, 15)), dt)
    big = np.block([[nav_only, forced[:9, 9:] @ h], [np.zeros((m, 9)), sensors.transition]])
    noise = block_diag(q_step, sensors.noise)
    for _ in range(steps):
        exact = big @ exact @ big.T + noise
    size = np.sqrt(np.diag(exact))
    # second order in the navigation block: (F dt)^3 / 6 is 1e-9 a step; what remains is the
    # trapezium for the white noise
    assert np.max(np.abs(fast - exact) / np.outer(size, size)) < 1e-5


def test_a_true_model_is_consistent(path, motion):
    """Mean NEES and NIS of ten drives inside their 99.7 % bands (a hundred drives:
    benchmarks/filter_consistency.py).
    """
    ends, nis, count = [], 0.0, 0
    for seed in range(10):
        rng = np.random.default_rng(seed)
        drive = simulation.simulate_drive(
            path,
            PAPER,
            rng,
            motion=motion,
            imu=simulation.ImuErrors(turn_on_sd=(1e-4, 0.01), lever_arm=(1.0, 0.3, -1.2)),
        )
        engine = LooselyCoupled(
            drive,
            FilterModel("18AV", PAPER, turn_on_sd=(1e-4, 0.01)),
            remove_bias=False,
            start=consistency.drawn_start(drive, START_SD, rng),
        )
        solution = engine.solve()
        time, value = consistency.nees(solution, drive)
        ends.append(value[[30, 100, 170, -1]])
        nis += solution.nis.sum()
        count += solution.freedom.sum() / 6
    # the four moments of a run are correlated: each has its own band
    assert all(consistency.band(column, 9).inside for column in np.array(ends).T)
    assert abs(nis / count - 6.0) < 3.0 * np.sqrt(12.0 / count)


def test_the_smoother_beats_the_filter_and_knows_it(drive):
    engine = LooselyCoupled(drive, FilterModel("18AV", PAPER))
    solution = engine.solve()
    smoothed = smoother.smooth(engine)
    at = np.searchsorted(drive.reference_time, smoothed.time - 1e-6)
    error = earth.meters(smoothed.position, drive.reference_position[at])
    _, filtered, _ = consistency.errors(solution, drive)
    assert np.sqrt((error[:, :2] ** 2).mean()) < np.sqrt((filtered[:, :2] ** 2).mean())
    velocity = smoothed.velocity - drive.reference_velocity[at]
    assert np.sqrt((velocity**2).mean()) < 0.75 * np.sqrt((filtered[:, 3:6] ** 2).mean())
    assert (
        0.6 < np.sqrt((velocity**2 / smoothed.sd[:, 3:6] ** 2).mean()) < 1.4
    )  # one drive: a few dozen independent errors
    last = np.flatnonzero(smoothed.time == smoothed.time[-1])
    assert np.array_equal(smoothed.position[last], solution.position[-1:])


def test_scale_factor_states_find_a_scale_factor(path, motion):
    true = simulation.ImuErrors(scale_sd=(0.02, 0.0))
    drive = simulation.simulate_drive(
        path, PAPER, np.random.default_rng(5), motion=motion, imu=true
    )
    engine = LooselyCoupled(drive, FilterModel("18AV+scale", PAPER, scale_sd=(0.02, 0.0)))
    solution = engine.solve()
    index = solution.names.index("gyro_scale z")
    rng = np.random.default_rng(5)
    PAPER.simulate(motion[0].size - 1, 100.0, rng)
    truth = rng.standard_normal((3, 6))[1][2] * 0.02
    last = solution.moments[-1]
    assert abs(last.x[-1][index] - truth) < 3.0 * np.sqrt(last.p[-1][9 + index, 9 + index]) < 0.06


@given(
    seed=st.integers(0, 10_000),
    which=st.sampled_from(["15AV", "18AV", "27AR", "scale"]),
    gap=st.booleans(),
    constraint=st.booleans(),
)
@settings(max_examples=15, deadline=None)
def test_the_covariance_stays_symmetric_and_positive_definite(
    path, motion, seed, which, gap, constraint
):
    rng = np.random.default_rng(seed)
    errors = simulation.GnssErrors(
        rate=float(rng.choice([1.0, 5.0])),
        position_sd=tuple(rng.uniform(0.01, 5.0, 3)),
        velocity_sd=tuple(rng.uniform(0.01, 0.5, 3)),
        wild=0.05,
    )
    drive = simulation.simulate_drive(path, PAPER, rng, motion=motion, gnss=errors).slice(
        0.0, 120.0
    )
    model = (
        FilterModel("scale", PAPER, scale_sd=(0.01, 0.01))
        if which == "scale"
        else models.five(names=(which,))[which]
    )
    model = model.with_(turn_on_sd=(1e-3, 0.1), constraint_sd=0.1 if constraint else 0.0)
    engine = LooselyCoupled(drive, model, gnss=Gnss(position_floor=1e-3, velocity_floor=1e-3))
    solution = engine.solve(withhold=[(60.0, 30.0)] if gap else ())
    for p in solution.moments[0].p[::10]:
        assert np.array_equal(p, p.T)
        size = np.sqrt(np.diag(p))
        assert np.all(size > 0.0)
        # as a correlation matrix, so that metres and rad/s count alike; rounding is about (9 + m)
        # eps
        assert np.linalg.eigvalsh(p / np.outer(size, size)).min() > -1e-11
