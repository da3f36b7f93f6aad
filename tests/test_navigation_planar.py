"""The planar filters of the 2008 paper and the update-interval study."""

import numpy as np
import pytest

import imu_lib as imu
from imu_lib.navigation import planar, planar_loop
from imu_lib.navigation import update_interval as ui
from imu_lib.processes import Autoregressive, Constant, GaussMarkov, WhiteNoise
from imu_lib.units import DEG

DT = 0.05


def test_random_constants_give_eq_15():
    models = {c: Constant(0.01) for c in planar.SENSORS}
    model = planar.sensors(models, DT)
    p, an, ae = 0.7, 1.3, -0.4
    printed = np.eye(8)
    printed[0, 2] = printed[1, 3] = printed[4, 7] = DT
    printed[2, 4:7] = -ae * DT, np.cos(p) * DT, -np.sin(p) * DT
    printed[3, 4:7] = an * DT, np.sin(p) * DT, np.cos(p) * DT
    assert model.states == 8
    assert np.allclose(planar.transition(p, (an, ae), model, order=1), printed, atol=1e-15)
    assert np.allclose(
        planar.transition(p, (an, ae), model), printed, atol=DT**2
    )  # second order differs by dt^2 / 2


def test_ar4_gives_eq_16():
    """Section 5's 14 states; the paper writes the AR coefficients with the other sign; its yaw
    state has a zero row.
    """
    au, av = (0.42, 0.23, 0.14, 0.10), (0.38, 0.25, 0.15, 0.11)
    models = {
        "accel_x": Autoregressive(au, 0.01, 1 / DT),
        "accel_y": Autoregressive(av, 0.01, 1 / DT),
        "gyro_z": WhiteNoise(1e-3),
    }
    model = planar.sensors(models, DT, white_state=True)
    p, an, ae = -0.3, 0.5, 0.9
    printed = np.zeros((14, 14))
    printed[:5, :5] = np.eye(5)
    printed[0, 2] = printed[1, 3] = printed[4, 13] = DT
    printed[2, [4, 5, 9]] = -ae * DT, np.cos(p) * DT, -np.sin(p) * DT
    printed[3, [4, 5, 9]] = an * DT, np.sin(p) * DT, np.cos(p) * DT
    for at, phi in ((5, au), (9, av)):
        printed[at, at : at + 4] = phi
        printed[[at + 1, at + 2, at + 3], [at, at + 1, at + 2]] = 1
    assert model.states == 14 and planar.sensors(models, DT).states == 13
    assert np.allclose(planar.transition(p, (an, ae), model, order=1), printed, atol=1e-15)


def consistent_runs(rng, runs=20):
    drive = ui.parking_lot(duration=300.0)
    entry = WhiteNoise(1e-3) + GaussMarkov(0.1, 20.0)
    models = {"accel_x": entry, "accel_y": entry, "gyro_z": WhiteNoise(3e-4)}
    model = imu.Model(models, rate=20.0)
    sd = np.array([1.0, 1.0, 0.1, 0.1, 0.02])
    readings, n = np.empty((runs, len(drive.inputs), 3)), len(drive.inputs)
    for k in range(runs):
        noise = model.simulate(n, 20.0, rng)
        readings[k] = drive.inputs + np.column_stack([noise[c] for c in planar.SENSORS])
    start = drive.start + rng.normal(size=(runs, 5)) * sd
    fixes = drive.position + rng.normal(size=(runs, n, 2)) * [2.0, 4.0]
    return drive, models, readings, fixes, start, sd


@pytest.mark.parametrize("interval", [1, 20])
def test_filter_is_consistent_when_its_model_is_true(interval):
    """Mean NEES of two positions is 2; 20 runs of 300 s hold at least 20 x 5 independent values,
    so 4 standard deviations are 4 x 2 / sqrt(100) = 0.8."""
    drive, models, readings, fixes, start, sd = consistent_runs(np.random.default_rng(interval))
    every = 20 * interval
    found = planar.run(
        readings,
        fixes[:, every - 1 :: every],
        planar.sensors(models, DT),
        every=every,
        start=start,
        start_sd=sd,
        gnss_sd=(2.0, 4.0),
        truth=drive.position,
    )
    assert abs(found.nees.mean() - 2.0) < 0.8
    assert (found.sd > 0).all()


def test_filter_equals_a_dense_one():
    """The same recursion with full matrices and Joseph's update; only rounding differs."""
    drive, models, readings, fixes, start, sd = consistent_runs(np.random.default_rng(3), runs=1)
    model, n, every = planar.sensors(models, DT), 400, 40
    found = planar.run(
        readings[:, :n],
        fixes[:, every - 1 : n : every],
        model,
        every=every,
        start=start,
        start_sd=sd,
        gnss_sd=(2.0, 4.0),
    )
    x, b = start[0].copy(), np.zeros(2)
    p = np.diag([*sd**2, 0.01, 0.01])
    for k in range(n):
        u, v, w = readings[0, k] - model.output @ b
        middle = x[4] + 0.5 * w * DT
        an, ae = planar_loop.mechanize(x, u, v, w, DT)
        phi = planar.transition(middle, (an, ae), model)
        q = np.zeros((7, 7))
        c, s = np.cos(middle), np.sin(middle)
        turn = np.array([[c, -s], [s, c]])
        q[2:4, 2:4] = turn @ np.diag(model.direct[:2]) @ turn.T * DT
        q[4, 4] = model.direct[2] * DT
        q[5:, 5:] = model.noise
        p, b = phi @ p @ phi.T + q, model.transition @ b
        if (k + 1) % every == 0:
            h, r = np.eye(2, 7), np.diag([4.0, 16.0])
            gain = p @ h.T @ np.linalg.inv(h @ p @ h.T + r)
            correction = gain @ (x[:2] - fixes[0, k])
            x, b = x - correction[:5], b + correction[5:]
            left = np.eye(7) - gain @ h
            p = left @ p @ left.T + gain @ r @ gain.T
        assert np.allclose(found.position[0, k], x[:2], atol=1e-6)
        assert np.allclose(found.sd[0, k], np.sqrt(np.diag(p)[:2]), rtol=1e-6)


def test_drive_is_what_the_paper_describes():
    drive = ui.parking_lot()
    moving = drive.speed[drive.time > 30]
    assert drive.time[-1] == pytest.approx(600.0)
    assert moving.min() * 3.6 == pytest.approx(10, abs=0.1) and moving.max() * 3.6 <= 30.001
    assert np.abs(drive.inputs[:, 2]).max() > 10 * DEG
    assert drive.state[-1, 4] - drive.start[4] == pytest.approx(
        2 * np.pi, abs=1e-6
    )  # five right turns, one left


def test_fit_of_static_records_follows_the_spectrum_that_matters():
    """AR(4) sees more of the slow noise than GM(1): the truth at low frequency lies above both."""
    model = imu.preset("rga300ca")
    fitted = ui.fit_static(model, np.random.default_rng(1), hours=2.0, records=2)
    f = np.array([0.01])
    true, ar, gm = (
        m.psd(f, 20.0)[0] for m in (model["accel_x"], fitted.ar["accel_x"], fitted.gm["accel_x"])
    )
    assert gm < ar < true
    # the total variance is met by both: sampling scatter of two hours at 20 Hz is below 1 %
    assert fitted.ar["accel_x"].autocovariance(0.0) == pytest.approx(
        model["accel_x"].autocovariance(0.0, 20.0), rel=0.03
    )
    assert fitted.gm["accel_x"].sigma ** 2 == pytest.approx(
        model["accel_x"].autocovariance(0.0, 20.0), rel=0.03
    )


def test_study_pairs_the_runs():
    drive, model, rng = (
        ui.parking_lot(duration=120.0),
        imu.preset("rga300ca"),
        np.random.default_rng(2),
    )
    fitted = ui.fit_static(model, rng, hours=1.0, records=1)
    scenario = ui.Scenario(tilt=0.6 * DEG)
    runs = ui.simulate(drive, model, rng, runs=6, scenario=scenario)
    models = {"AR(4)": fitted.ar, "slow": ui.with_slow_state(fitted.ar, 0.1, 20.0)}
    found = ui.study(drive, runs, models, intervals=(10,), scenario=scenario)[10]
    ratio = ui.paired(found["slow"].horizontal, found["AR(4)"].horizontal)
    assert ratio.high < 1  # a state that lasts carries the tilt, an AR(4) does not
    assert found["slow"].pooled[2] == pytest.approx(np.sqrt(np.mean(found["slow"].horizontal ** 2)))


def test_paired_interval_covers():
    """400 sets of ten log-normal ratios: exact t interval, three standard deviations of the
    proportion are 3.3 %.
    """
    rng = np.random.default_rng(5)
    hits = [
        ui.paired(np.exp(rng.normal(0.1, 0.3, 10)), np.ones(10)).covers(np.exp(0.1))
        for _ in range(400)
    ]
    assert 0.917 < np.mean(hits) < 0.983


def test_wrong_arguments_are_named():
    with pytest.raises(ValueError, match="`readings`"):
        planar.run(
            np.zeros((5, 3)),
            np.zeros((1, 1, 2)),
            planar.sensors({c: WhiteNoise(1.0) for c in planar.SENSORS}, DT),
            every=1,
            start=np.zeros((1, 5)),
            start_sd=np.ones(5),
            gnss_sd=(1, 1),
        )
