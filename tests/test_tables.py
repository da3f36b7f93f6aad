"""Tables that chapters print: numbers land in the cells that their names say."""

import json
from types import SimpleNamespace

import numpy as np

from imu_lib import published, tables
from imu_lib.estimate import Estimate
from imu_lib.gap.table import describe
from imu_lib.processes import GaussMarkov, WhiteNoise


def test_held_counts_only_what_has_a_truth():
    fits = {
        "gyro_x": {
            "N": Estimate(1.0, 0.9, 1.1),
            "sigma": Estimate(2.0, 1.9, 2.1),
            "K": Estimate.absent(1.0),
        }
    }
    truth = {"gyro_x": WhiteNoise(N=1.05) + GaussMarkov(sigma=3.0, correlation_time=9.0)}
    assert tables.held(fits, truth) == {("gyro_x", "N"): True, ("gyro_x", "sigma"): False}


def test_driving_density():
    truth = WhiteNoise(N=1.0) + GaussMarkov(sigma=2.0, correlation_time=100.0)
    reading = SimpleNamespace(
        flat=Estimate(1.0, 0.9, 1.1),
        correlation_time=Estimate(50.0, 1.0, 99.0),
        sigma=Estimate(1.5, 1.0, 2.0),
        peak_correlation_time=Estimate.absent(1.0),
    )
    table = tables.gauss_markov(
        truth,
        reading,
        {"sigma": Estimate(2.1, 2.0, 2.2), "correlation_time": Estimate(90.0, 50.0, 200.0)},
    )
    assert table["driving density 2 sigma²/Tc"].round(3).fillna(-1).tolist() == [
        0.08,
        0.04,
        -1,
        0.098,
    ]


def test_flat_parts_say_where_there_is_none():
    readings = {"gyro_x": SimpleNamespace(correlation_time=Estimate.absent(9.0))}
    table = tables.flat_parts(
        {"gyro_x": np.array([0.0, 2.0])}, readings, {"gyro_x": (490.9, 0.0055)}
    )
    assert table.loc["gyro_x"].tolist() == ["none found", "1", "490.9", "0.0055"]


def test_an_estimate_prints_itself_with_its_interval():
    assert f"{Estimate(1.23456, 1.0, 2.0):.3f}" == "1.235 [1.000, 2.000]"
    assert f"{Estimate.absent(5.92e-4)}" == "< 0.000592"


def test_coverage_reads_a_stored_study(tmp_path):
    line = {"draws": 12, "covered": 0.75, "truth_above": 0.25, "not_shown": 0.5}
    study = {
        "methods": {
            "a": {
                "seeds": [1, 2],
                "pooled_all": 0.8,
                "pooled": {"N": {**line, "median_ratio": 1.5, "sd_of_log": 0.1}},
            },
            "b": {"seeds": [3, 3], "pooled_all": 0.7, "pooled": {"K": line}},
        }
    }
    path = tmp_path / "coverage.json"
    path.write_text(json.dumps(study))
    table = tables.coverage(path)
    assert table.loc["a", "N"].tolist() == [2, 0.75, 1.5, 0.1, 0.5]
    assert table.loc[("b", "all"), "covered"] == 0.7 and np.isnan(
        table.loc[("b", "K"), "median ratio"]
    )
    assert list(tables.coverage(path, ["b"]).index) == [("b", "K"), ("b", "all")]


def test_medians_stand_under_their_titles():
    entry = {
        "a": {"median": [1.26, 1.0, 1.5], "predicted": 2.04},
        "b": {"median": [3.0, 2.0, 4.0], "predicted": 5.0},
    }
    table = tables.medians({"30 s": entry, "60 s": {"a": entry["b"]}}, predicted="30 s")
    assert table.loc["a"].tolist() == ["1.3 [1.0, 1.5]", "3.0 [2.0, 4.0]", "2.0"]
    assert tables.medians({"30 s": entry}, digits=0).loc["b", "30 s"] == "3 [2, 4]"


def test_outages_of_two_drives_are_numbered_on():
    def study(count, offset):
        return SimpleNamespace(
            models={"18AV": None},
            errors=lambda name, what: np.arange(count) + offset + (100.0 if what == "max" else 0.0),
        )

    table = tables.outage_errors([study(3, 1), study(4, 4)])
    assert (
        len(table) == 14
        and table.loc["2, 60 s, mean", "18AV"] == "2 (14.1)"
        and table.loc["7, 60 s, max", "18AV"] == "107 (96.3)"
    )
    levels = tables.level_errors({"0": np.arange(7.0)})
    assert levels.loc["6*, 103 km/h"].tolist() == [232.54, 232.74, 217.28, 5.0]


def test_repeated_runs_stand_beside_the_papers():
    mean, deviation = published.accel_runs_2008()
    table = tables.repeatability({"bias_mg": np.array([[1.0, 2.0], [3.0, 2.0]])}, mean, deviation)
    assert table.loc["bias_mg x"].tolist()[0] == "2.000" and table.loc[
        "bias_mg x", "St.D."
    ].startswith("1.414 [0.631, ")
    assert table.loc["bias_mg y"].tolist()[2:] == ["2.4233", "1.1304"]


def test_calibration_coverage_reads_a_stored_study():
    entry = {"coverage_percent": 94.6, "median_half_width": 0.000374}
    table = tables.calibration_coverage({"results": {"12 poses, gyroscopes, scale factor": entry}})
    assert table["12 poses"].to_dict() == {
        "gyroscopes, scale factor": "95 %",
        "gyroscopes, half width": "0.037 %",
    }


def test_noise_in_common_has_the_unit_of_its_channels():
    def told(*channels):
        return describe(
            SimpleNamespace(
                effect="common_mode", parameters={"N": 1e-4, "channels": list(channels)}
            ),
            "record",
        )

    assert told("gyro_x", "gyro_y") == "common_mode  N 0.3438 deg/sqrt(h), channels gyro_x, gyro_y"
    assert (
        told("accel_x", "accel_z") == "common_mode  N 0.006 m/s/sqrt(h), channels accel_x, accel_z"
    )
    assert told("gyro_x", "accel_z") == "common_mode  N 0.0001 SI, channels gyro_x, accel_z"
