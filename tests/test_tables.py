"""Tables that chapters print: numbers land in the cells that their names say."""

import json

import numpy as np
import pytest

from imu_lib import tables
from imu_lib.estimate import Estimate
from imu_lib.processes import GaussMarkov, WhiteNoise


def test_held_counts_only_what_has_a_truth():
    fits = {"gyro_x": {"N": Estimate(1.0, 0.9, 1.1), "sigma": Estimate(2.0, 1.9, 2.1), "K": Estimate.absent(1.0)}}
    truth = {"gyro_x": WhiteNoise(N=1.05) + GaussMarkov(sigma=3.0, correlation_time=9.0)}
    assert tables.held(fits, truth) == {("gyro_x", "N"): True, ("gyro_x", "sigma"): False}


def test_driving_density():
    table = tables.gauss_markov({"truth": (2.0, 100.0)})
    assert table.loc["truth", "driving density 2 sigma²/Tc"] == pytest.approx(0.08)


def test_coverage_reads_a_stored_study(tmp_path):
    line = {"draws": 12, "covered": 0.75, "truth_above": 0.25, "not_shown": 0.5}
    study = {"methods": {"a": {"seeds": [1, 2], "pooled_all": 0.8, "pooled": {"N": {**line, "median_ratio": 1.5, "sd_of_log": 0.1}}},
                         "b": {"seeds": [3, 3], "pooled_all": 0.7, "pooled": {"K": line}}}}
    path = tmp_path / "coverage.json"
    path.write_text(json.dumps(study))
    table = tables.coverage(path)
    assert table.loc["a", "N"].tolist() == [2, 0.75, 1.5, 0.1, 0.5]
    assert table.loc[("b", "all"), "covered"] == 0.7 and np.isnan(table.loc[("b", "K"), "median ratio"])
    assert list(tables.coverage(path, ["b"]).index) == [("b", "K"), ("b", "all")]
