"""The first six minutes of the 2013 paper's second drive, its sensor's errors, and how far a
solution is from the truth.
"""

import numpy as np
import pytest

from imu_lib import preset
from imu_lib.navigation import earth, simulation, trajectory, turin

PAPER = preset("3dm-gx3-25-2013")


@pytest.fixture(scope="module", name="path")
def the_path():
    whole = turin.drive(2)
    return trajectory.Trajectory(whole.position, whole.angles, 0.0, 360.0)


@pytest.fixture(scope="module", name="drive")
def the_drive(path):
    return simulation.simulate_drive(
        path, PAPER, np.random.default_rng(20), imu=simulation.ImuErrors(turn_on_sd=(3e-3, 0.02))
    )


def rms(solution, drive):
    """Horizontal RMS error against the drive's reference, m."""
    truth = np.column_stack(
        [np.interp(solution.time, drive.reference_time, c) for c in drive.reference_position.T]
    )
    return float(np.sqrt(np.mean(earth.horizontal(solution.position, truth) ** 2)))
