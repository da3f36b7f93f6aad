"""A turn that accelerometers and gyros have in common is no misalignment."""

import drive_generator as generator
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from imu_lib.drive import from_arrays
from imu_lib.gap.drive import columns, common_turn, correct, select, vehicle_steps
from imu_lib.gap.drive.problem import Noise
from imu_lib.gap.drive.state import State
from imu_lib.model import Model

MODEL = Model.from_json(generator.MODEL)
BOTH = ("gyro_scale", "accel_misalignment", "gyro_misalignment", "accel_scale")
TURN = Rotation.from_rotvec([-0.023, 0.026, -0.072])


def made(effects=(), **options):
    return from_arrays(generator.make(51007, effects=effects, **options), "turns")


def test_values_in_a_turned_body_say_the_same_of_the_readings():
    rng = np.random.default_rng(5)
    kept = (*BOTH, "gyro_g_sensitivity", "lever_arm", "gyro_bias", "accel_bias")
    theta = np.zeros(len(columns.ALL))
    index = [i for e in kept for i in columns.GROUPS[e]]
    theta[index] = rng.normal(size=len(index)) * columns.PRIOR[index]
    drive = made(duration=30.0).with_(lever_arm=np.array([0.5, -0.2, 1.0]))
    old = correct.corrected(drive, theta)
    new = correct.corrected(
        drive, common_turn.in_body(theta, TURN.as_matrix(), kept, drive.lever_arm)
    )
    for name in ("gyro", "accel"):
        values = TURN.apply(np.array(getattr(new, name)))
        assert values == pytest.approx(getattr(old, name), abs=1e-9)
    assert TURN.apply(np.array(new.lever_arm)) == pytest.approx(old.lever_arm)


def test_a_turn_of_both_sensors_leaves_with_the_one_that_is_not_misaligned():
    matrix = [0.0, -0.023, 0.0, -0.018, 0.0, 0.0]
    drive = made([("gyro_misalignment", {"matrix": matrix})], duration=150.0, kind="bus")
    true = np.zeros(len(columns.ALL))
    true[columns.of("gyro_misalignment")] = matrix
    theta = common_turn.in_body(true, TURN.as_matrix(), BOTH)
    state = State(drive, Noise(MODEL), theta, kept=BOTH)
    state.rebuild()
    said = []
    assert common_turn.taken_out(state, said.append)
    assert said == ["a turn of both sensors taken out: accel is not misaligned"]
    assert "accel_misalignment" not in state.kept
    found = state.theta[columns.of("gyro_misalignment")]
    seen = select.seen(state.reg, state.kept, "gyro_misalignment")[1]
    assert np.all(np.abs(found - matrix) < 3.5 * seen)


def test_a_sensor_that_is_misaligned_keeps_its_name():
    matrix = [0.02, 0.02, 0.02, -0.015, 0.02, -0.015]  # symmetric: no turn has any part in it
    drive = made([("accel_misalignment", {"matrix": matrix})], duration=150.0, kind="bus")
    theta = np.zeros(len(columns.ALL))
    theta[columns.of("accel_misalignment")] = np.array(matrix) + [0.0, 0.004, 0.0, 0.0, -0.004, 0.0]
    state = State(drive, Noise(MODEL), theta, kept=("accel_misalignment",))
    state.rebuild()
    assert not common_turn.taken_out(state, lambda text: None)
    assert state.kept == ("accel_misalignment",)


@pytest.mark.parametrize("beyond", [0.0, 0.4])
def test_the_arm_of_a_file_holds_in_a_case_that_is_turned(beyond):
    given, angles = np.array([0.82, 0.26, -0.35]), np.array([-0.033, 0.04, 0.087])
    turned = angles, np.array([0.021, 0.0045, 0.0045])
    case = Rotation.from_euler("ZYX", angles[::-1])
    arm = case.inv().apply(given + [beyond, 0.0, 0.0]) - given
    found = [
        {"effect": "lever_arm", "parameters": {"arm": list(arm)},
         "intervals": {"arm": [[a - 0.01, a + 0.01] for a in arm]}},
        {"effect": "mounting", "parameters": dict(zip(("roll", "pitch", "yaw"), angles))},
    ]  # fmt: skip
    drive = made(duration=10.0).with_(lever_arm=given)
    notes = vehicle_steps.arm_of_vehicle(found, drive, turned)
    names = [step["effect"] for step in found]
    if beyond:
        assert names == ["lever_arm", "mounting"] and not notes
        assert found[0]["parameters"]["arm"] == pytest.approx(given + [beyond, 0.0, 0.0])
    else:
        assert names == ["mounting"] and "file's lever arm holds" in notes[0]
