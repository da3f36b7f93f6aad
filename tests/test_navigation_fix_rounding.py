"""Positions printed with few digits."""

import drive_generator as generator
import numpy as np
import pytest

from imu_lib.drive import from_arrays
from imu_lib.health import fixes
from imu_lib.navigation import earth, fix_rounding, preparation


@pytest.fixture(scope="module")
def drive():
    options = {"duration": 240.0, "rate": 50.0, "position_sd": (0.02, 0.02, 0.04)}
    return from_arrays(generator.make(90, **options), "fine")


def rounded(drive, least):
    """The drive with its latitude, longitude (rad) and height (m) on steps of `least` (3,)."""
    return drive.with_(gnss_position=np.rint(drive.gnss_position / least) * least)


#: printed as: seven decimals of a radian, five of a degree, four of a minute of arc (NMEA)
PRINTED = [(1e-7, 1e-7), (np.radians(1e-5),) * 2, (np.radians(1e-4 / 60.0),) * 2]


@pytest.mark.parametrize("step", PRINTED)
def test_steps_are_those_of_the_last_digit(drive, step):
    found = fix_rounding.steps(rounded(drive, [*step, 0.1]))
    origin = drive.gnss_position[0]
    expected = np.abs(earth.meters(origin + [*step, 0.1], origin))
    assert found == pytest.approx(expected, rel=1e-3)


def test_a_step_that_few_fixes_share_is_found(drive):
    few = drive.with_fixes(slice(None, None, 10))
    assert fix_rounding.steps(rounded(few, [1e-7, 1e-7, 0.5]))[2] == pytest.approx(0.5)


def test_positions_with_all_their_digits_lie_on_no_grid(drive):
    assert not fix_rounding.steps(drive).any()
    assert not fixes.rounded(drive)


def test_the_filter_counts_what_rounding_costs(drive):
    stated = np.full((len(drive.gnss_time), 3), 0.02)
    coarse = rounded(drive, [1e-7, 1e-7, 1.0]).with_(gnss_position_sd=stated)
    found, _ = preparation.fixes_of(coarse, preparation.Gnss())
    # uniform within a step: its square over 12
    steps = fix_rounding.steps(coarse)
    assert found.variance[:, :3] == pytest.approx(
        np.tile(0.02**2 + steps**2 / 12.0, (len(stated), 1))
    )
    error = earth.meters(coarse.gnss_position, drive.gnss_position)
    assert np.mean(error**2, axis=0) == pytest.approx(
        steps**2 / 12.0, rel=0.15
    )  # 1,200 fixes: 3 sd


def test_check_says_that_digits_are_missing(drive):
    (said,) = fixes.rounded(rounded(drive, [1e-7, 1e-7, 0.1]))
    assert said.startswith("The positions step north by 0.64 m and east by 0.")
