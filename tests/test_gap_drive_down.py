"""Errors of the fixes that have another size down than across the ground, where one is stated."""

import drive_generator as generator
import numpy as np
import pytest

from imu_lib import gap
from imu_lib.drive import from_arrays
from imu_lib.drive_effects import DriveEffect
from imu_lib.model import Model
from imu_lib.navigation import preparation
from imu_lib.navigation.held import Held

MODEL = Model.from_json(generator.MODEL)


@pytest.fixture(scope="module")
def found():
    # a receiver that states one accuracy of the velocity, and smooths what is down
    options = {"duration": 150.0, "rate": 50.0, "velocity_sd": (0.1, 0.1, 0.01)}
    drive = from_arrays(generator.make(7301, **options), "one size")
    stated = np.full_like(drive.gnss_velocity, 0.1)
    return gap.close(drive.with_(gnss_velocity_sd=stated), MODEL, judge=False)


def test_the_size_down_is_found_and_is_no_name(found):
    assert not found.steps and found.unexplained is None
    (note,) = (n for n in found.notes if "velocities down" in n)
    assert "where those across the ground are 1 times" in note
    # 750 fixes: 2.6 %, and what the filter's own share of the innovations leaves
    assert found.state.noise.velocity_down == pytest.approx(0.1, rel=0.12)
    assert found.state.noise.position_down is None


def test_the_model_file_holds_it(found):
    held = Held.of(Model.from_json(found.model.to_json()).drive)
    gnss = held.gnss(preparation.Gnss())
    assert gnss.velocity_down_ratio == found.state.noise.velocity_down
    fixes, _ = preparation.fixes_of(found.drive, gnss)
    own = found.state.noise.velocity_down
    expected = np.maximum(0.1 * np.array([1.0, 1.0, own]), gnss.velocity_floor)
    assert np.sqrt(fixes.variance[0, 3:]) == pytest.approx(expected)


def test_another_ratio_of_all_leaves_what_is_down_to_its_own():
    both = [("velocity", 2.0), ("velocity_down", 0.5)]
    held = Held.of([DriveEffect("gnss_noise", {"ratio": r, "of": of}) for of, r in both])
    gnss = held.gnss(preparation.Gnss())
    assert (gnss.velocity_ratio, gnss.velocity_down_ratio) == (2.0, 0.5)
    assert gnss.position_down_ratio is None
