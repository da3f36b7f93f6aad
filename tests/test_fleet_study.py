"""Monte-Carlo over a fleet's scheduler: the same numbers however many workers."""

import numpy as np
import pytest

from imu_lib import InputError, fleet
from imu_lib.model import Model
from imu_lib.navigation import trajectory
from imu_lib.presets import preset

MODEL = Model.from_json({"gyro_x": [{"process": "white_noise", "N": 1e-4}]})


def _number(rng, scale):
    return scale * rng.standard_normal()


def test_runs_depend_on_the_seed_alone():
    one = fleet.monte_carlo(_number, 5, 2.0, seed=3, workers=1)
    two = fleet.monte_carlo(_number, 5, 2.0, seed=3, workers=2)
    assert one == two and len(set(one)) == 5
    assert one != fleet.monte_carlo(_number, 5, 2.0, seed=4, workers=1)


def test_coverage_of_white_noise():
    found = fleet.coverage(MODEL, runs=12, hours=0.01, rate=50.0, workers=1)
    row = found.set_index("coefficient").loc["N"]
    assert row.runs == 12 and row.held >= 9  # 95 %: fewer has a chance of one in five hundred
    assert row.low < row.share <= row.high


def test_drives_of_a_fleet():
    """The table has every drive and window; drives differ by their draws."""
    way = np.array([[0.0, 0.0, 0.0], [400.0, 0.0, 0.0], [400.0, 300.0, 0.0], [800.0, 300.0, 0.0]])
    path = trajectory.from_waypoints(way)
    model = preset("3dm-gx3-25-2013")
    window = ((0.6 * (path.stop - path.start), 10.0),)
    found = fleet.drives(path, model, {"own": model}, window, runs=2, seed=1, workers=1)
    assert list(found.columns) == ["run", "filter", "window", "error"]
    assert len(found) == 2 and found.error.between(0.01, 200.0).all()
    assert found.error.nunique() == 2
    with pytest.raises(InputError):
        fleet.drives(path, model, {"own": model}, ((1e6, 10.0),), runs=1, workers=1)


def test_what_uses_joblib_itself_goes_on_after_a_run():
    """The gap workflow after a long record was characterised: two pools, one after the other."""
    from joblib import Parallel, delayed

    from imu_lib import scheduler

    found = list(scheduler.shared(abs, [(-1,), (-2,), (-3,)], 2))
    assert sorted(found) == [1, 2, 3]
    assert Parallel(n_jobs=2)(delayed(abs)(-x) for x in (4, 5)) == [4, 5]
    assert dict(scheduler.run(abs, [(-6,), (-7,)], workers=2)) == {0: 6, 1: 7}
    assert Parallel(n_jobs=2)(delayed(abs)(-x) for x in (8, 9)) == [8, 9]
