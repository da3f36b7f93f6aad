"""What `check` finds on a drive against itself."""

import drive_generator as generator
import numpy as np
import pytest

from imu_lib.drive import from_arrays
from imu_lib.errors import InputError
from imu_lib.gap.drive import admission, left
from imu_lib.health.driven import disagreements
from imu_lib.navigation import gross

RIGHT = generator.make(21, duration=200.0)


def said(**changes):
    return " ".join(disagreements(from_arrays({**RIGHT, **changes}, "x")))


def test_a_right_drive_says_nothing():
    assert said() == ""


@pytest.mark.parametrize(
    ("word", "changes"),
    [
        ("late", {"gnss_time": RIGHT["gnss_time"] + 2.0}),
        ("forward, right, down", {k: RIGHT[k][:, [1, 0, 2]] * [1, -1, 1] for k in ("gyro", "accel")}),
        ("deg/s", {"gyro": RIGHT["gyro"] * 180 / np.pi}),
        ("all signs turned", {"accel": -RIGHT["accel"]}),
        ("Gravity", {"accel": RIGHT["accel"] * 0.96}),
        ("east, north, up", {"gnss_velocity": RIGHT["gnss_velocity"][:, [1, 0, 2]] * [1, 1, -1]}),
        ("too small", {"gnss_position_sd": RIGHT["gnss_position_sd"] * 0.1}),
        ("jumps", {"reference_position": RIGHT["reference_position"]
                   + np.where(np.arange(len(RIGHT["reference_time"])) == 700, 2e-5, 0.0)[:, None]}),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said(word, changes):
    assert word in said(**changes)


@pytest.mark.parametrize("late", [2.0, -1.5])
def test_the_flag_for_late_fixes_undoes_the_delay(late):
    """`outages --latency S` takes a fix stamped t at t - S: late stamps ask for a positive S."""
    words = said(gnss_time=RIGHT["gnss_time"] + late).split("--latency ")[1]
    assert abs(float(words.split(",")[0]) - late) < 0.2


def test_units_and_signs_are_asked_for_and_not_explained():
    drive = from_arrays(generator.make(9, duration=240.0), "x")
    admission.check(drive)
    upside = np.array([1.0, 1.0, -1.0])
    for word, changes in {
        "--gyro-unit deg/s": {"gyro": np.degrees(drive.gyro)},
        "--accel-unit g": {"accel": drive.accel / 9.81},
        "third column": {"gnss_velocity": drive.gnss_velocity * upside},
    }.items():
        with pytest.raises(InputError, match=word):
            admission.check(drive.with_(**changes))


def test_fixes_are_found_that_are_most_of_a_minute_late():
    drive = from_arrays(generator.make(9, duration=240.0), "x")
    late, likeness, _ = gross.best_match(drive.with_(gnss_time=drive.gnss_time + 40.0))
    assert abs(late - 40.0) < 0.2 and likeness > 0.7


def test_a_noise_that_no_sensor_has_is_said():
    parameters = {"channel": "gyro_x", "process": "white_noise", "name": "N", "from": 1e-4}
    found = [{"effect": "bias_model", "parameters": {**parameters, "to": 2e-3}}]
    assert left.absurd(found) is None
    found[0]["parameters"]["to"] = 2e-2
    assert "200 times" in left.absurd(found)
