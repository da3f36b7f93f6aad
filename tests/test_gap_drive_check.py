"""What `check` finds on a drive against itself."""

import drive_generator as generator
import numpy as np
import pytest

from imu_lib.drive import from_arrays
from imu_lib.health.driven import disagreements

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
