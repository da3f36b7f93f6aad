"""The gap on a drive: effects hidden in drives made by code that shares nothing with the filter."""

import json

import drive_generator as generator
import numpy as np
import pytest

from imu_lib.drive import from_arrays
from imu_lib.gap import drive as gap_drive
from imu_lib.gap.drive import admission, columns, path, problem, regression, select
from imu_lib.model import Model
from imu_lib.navigation import axes, earth, fix_motion, lateness, strapdown

MODEL = Model.from_json(generator.MODEL)


def made(seed, effects=(), **options):
    return from_arrays(generator.make(seed, effects=effects, **{"duration": 240.0, **options}), "x")


def innovations(drive, theta=None):
    noise = problem.Noise(MODEL)
    found = path.build(drive, noise)
    return found, found.evaluate(noise, sens=True)


def test_generator_and_strapdown_agree():
    # two constructions of the same motion, one Earth-centred, one in north-east-down
    drive = made(1, noiseless=True, turn_on=(0.0, 0.0), duration=120.0)
    dt = np.diff(drive.time)[:, None]
    path = strapdown.integrate(
        drive.time,
        drive.gyro[1:] * dt,
        drive.accel[1:] * dt,
        position=drive.reference_position[0],
        velocity=drive.reference_velocity[0],
        attitude_=drive.reference_attitude[0],
    )
    every = slice(0, None, 10)
    n = drive.reference_position.shape[0]
    apart = earth.meters(path.position[every][:n], drive.reference_position)
    assert np.abs(apart).max() < 0.01  # m, over two minutes


def test_innovations_of_a_right_model_are_white():
    found, result = innovations(made(3))
    e = result.e[found.use]
    # mean of chi-square variables of one degree of freedom: sd sqrt(2 / count)
    assert abs(np.mean(e**2) - 1.0) < 4.0 * np.sqrt(2.0 / e.size)
    for k in range(6):
        v = result.e[:, k]
        assert abs(np.mean(v[1:] * v[:-1])) < 4.0 / np.sqrt(v.size)
    reg = regression.of(found, result, np.zeros(len(columns.ALL)), found.use)
    assert select.best(reg, list(columns.GROUPS))[0] == ()


def test_sensitivity_is_the_derivative_of_the_innovations():
    # the same path, the parameter put into the readings and taken out by the regression
    arm = {"arm": [1.2, -0.5, -0.8]}
    found, result = innovations(made(4, [("lever_arm", arm)]))
    reg = regression.of(found, result, np.zeros(len(columns.ALL)), found.use)
    value, cov, gain = reg.solve(columns.of("lever_arm"))
    assert gain > 100.0
    sd = np.sqrt(np.diag(cov))
    assert np.all(np.abs(value - arm["arm"])[:2] < 4.0 * sd[:2] + 0.02)


@pytest.mark.parametrize(
    "permutation", [("+y", "-x", "+z"), ("-x", "-y", "+z"), ("+y", "+x", "-z"), ("+z", "+x", "+y")]
)
def test_axes_are_found(permutation):
    drive = made(5, [("axes", {"permutation": permutation})], gnss_rate=2.0)
    assert axes.of(drive)[0] == permutation


def test_late_fixes_are_found():
    drive = made(6, [("gnss_time_offset", {"offset": 3.0})], gnss_rate=1.0, velocity=False)
    assert lateness.late(drive)[0] == pytest.approx(3.0, abs=0.3)


def test_the_match_of_turns_moves_with_the_stamps():
    # positions and velocities with lags of their own, as receivers have them
    own = {"offset": -0.19, "velocity_offset": -0.05}
    drive = made(8, [("gnss_time_offset", own)], position_sd=(0.03,) * 3, velocity_sd=(0.05,) * 3)
    here = lateness.best_match(drive)[0]
    assert here == pytest.approx(-0.05, abs=0.1)  # that of the velocities
    for shift in (-0.3, 0.3, 0.7):
        moved = drive.with_(gnss_time=np.asarray(drive.gnss_time) + shift)
        assert lateness.best_match(moved)[0] - here == pytest.approx(shift, abs=0.02)


def test_velocities_of_another_solution_do_not_hide_the_axes():
    drive = made(9, [("axes", {"permutation": ("+y", "-x", "+z")})], gnss_rate=2.0)
    velocity = np.array(drive.gnss_velocity)
    velocity[1::2, :2] *= -1.0  # as of a receiver that gives two solutions in turn
    mixed = drive.with_(gnss_velocity=velocity)
    assert axes.of(mixed)[0] == ("+y", "-x", "+z")
    notes = []
    assert admission.one_solution(drive, notes) is drive and not notes
    assert admission.one_solution(mixed, notes).gnss_velocity is None
    assert "velocities" in notes[0]


def test_wild_positions_do_not_cost_the_velocities():
    # each wild position contradicts the velocities beside it: of a recorded drive at 10 Hz with one
    # in twenty positions alone were left, and no time offset nor heading was right on them
    wild = ("gnss_outliers", {"fraction": 0.06, "scale": 44.0})
    drive = made(33, [wild], duration=120.0, gnss_rate=10.0, position_sd=(0.3, 0.3, 0.5))
    assert np.mean(fix_motion.contradicted(drive)) > admission.CONTRADICTED  # what the test needs
    notes = []
    assert admission.one_solution(drive, notes) is drive and not notes


def test_two_effects_are_found_named_and_added(tmp_path):
    drive = made(
        7, [("gnss_time_offset", {"offset": 0.2}), ("accel_scale", {"scale": [0.03, 0.0, 0.0]})],
        duration=240.0,
    )  # fmt: skip
    found = gap_drive.close(drive, MODEL)
    names = {s["effect"] for s in found.steps}
    assert names == {"gnss_time_offset", "accel_scale"}
    offset = next(s for s in found.steps if s["effect"] == "gnss_time_offset")
    assert offset["parameters"]["offset"] == pytest.approx(0.2, abs=0.02)
    assert found.after.index < found.before.index
    assert found.unexplained is None
    result = found.to_json()["drive"]
    json.dumps(result)
    assert (
        result["outages"]["median_max_error"]["after"]
        < result["outages"]["median_max_error"]["before"]
    )
    path = tmp_path / "model.json"
    found.model.save(path)
    assert {e.name for e in Model.load(path).drive} == names
