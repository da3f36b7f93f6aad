"""A model fitted to the outages of a drive: it finds the densities that move the position, and
holds on a drive not seen.
"""

import numpy as np
import pytest

from imu_lib.navigation import earth, outages, simulation, trajectory, tuning, turin
from imu_lib.navigation.filter import FilterModel, LooselyCoupled
from imu_lib.navigation.preparation import Gnss

TRUTH = (3e-4, 0.05, 3e-5, 3e-3)  # a module in a car
STANDSTILL = tuple(v / 10 for v in TRUTH)  # what its static record may say
TURN_ON = (3e-3, 0.02)


@pytest.fixture(scope="module")
def drives():
    """Two drives along one path, two hundred seconds each, the second never fitted."""
    whole = turin.drive(1)
    path = trajectory.Trajectory(whole.position, whole.angles, 0.0, 200.0)
    model = tuning.vehicle_model(*TRUTH)
    return [
        simulation.simulate_drive(
            path, model, np.random.default_rng(seed), imu=simulation.ImuErrors(turn_on_sd=TURN_ON)
        )
        for seed in (1, 2)
    ]


def loss(drive, parameters):
    model = (
        parameters
        if isinstance(parameters, FilterModel)
        else FilterModel("given", tuning.vehicle_model(*parameters), turn_on_sd=TURN_ON)
    )
    windows = outages.regular_windows(drive, duration=30.0, every=25.0)
    return tuning.outage_loss(LooselyCoupled(drive, model, gnss=Gnss()), windows)


def test_the_loss_is_the_density_of_the_errors(drives):
    """One window and one time, by hand."""
    window = outages.regular_windows(drives[0], duration=30.0, every=100.0)[:1]
    engine = LooselyCoupled(
        drives[0],
        FilterModel("given", tuning.vehicle_model(*TRUTH), turn_on_sd=TURN_ON),
        gnss=Gnss(),
    )
    solution = engine.solve(moments=[window[0].start])
    moment = solution.moments[0]
    time, position, sd, north_east = engine.coast(moment, 0, 20.0)
    k = int(np.searchsorted(time, moment.time[0] + 20.0 - 1e-6))
    error = np.array(earth.meters(position[k], solution.at(time[k : k + 1])[0])[:2])
    covariance = np.array(
        [[sd[k, 0] ** 2 + 1.0, north_east[k]], [north_east[k], sd[k, 1] ** 2 + 1.0]]
    )
    expected = 0.5 * (
        error @ np.linalg.solve(covariance, error) + np.log(np.linalg.det(2 * np.pi * covariance))
    )
    assert tuning.outage_loss(engine, window, times=(20.0,)) == pytest.approx(expected, rel=1e-9)


def test_a_standstill_model_is_corrected_by_the_outages(drives):
    seen, unseen = drives
    windows = outages.regular_windows(seen, duration=30.0, every=25.0)
    told = []
    tuned = tuning.fit_in_motion(
        [(seen, windows, None)],
        start=STANDSTILL,
        turn_on_sd=TURN_ON,
        evaluations=30,
        progress=told.append,
    )
    assert tuned.evaluations == len(told) <= 32 and tuned.loss == min(told)
    found, standstill, true = (loss(unseen, p) for p in (tuned.model, STANDSTILL, TRUTH))
    # what the outages do not see (a white noise ten times too small beside a walk) costs little,
    # so not the parameters are
    # compared but what they expect of a drive not seen; the truth itself gains all there is to
    # gain
    assert standstill - true > 10.0
    assert standstill - found > 0.5 * (
        standstill - true
    )  # seven outages of one drive are a small sample
