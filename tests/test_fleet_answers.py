"""What a fleet's summary says: two dates, days in common, steps, outliers, one answer."""

import numpy as np
import pandas as pd
import pytest
from test_fleet import ASKED, fleet_of

from imu_lib import fleet
from imu_lib.fleet.spread import of_units


def _scaled(table, rows, factor):
    columns = ["value", "low", "high"]
    table.loc[rows, columns] = table.loc[rows, columns] * factor
    return table


def _chosen(table):
    """The table with the sum that the likelihood chose in each record."""
    chosen = table.assign(value=np.nan, low=np.nan, high=np.nan)
    return pd.concat([table, chosen.assign(coefficient=None, effect="white", confidence=1.0)])


def test_two_dates_are_a_paired_question():
    rng = np.random.default_rng(5)
    still = [fleet.drift(fleet_of(rng, 6, 2, day=0.1), *ASKED) for _ in range(40)]
    assert sum(d.covers(0.0) for d in still) >= 34  # 38 expected; fewer: one in three hundred
    found = fleet.drift(fleet_of(rng, 14, 2, growth=0.08), *ASKED)
    assert 0.0 < found.low < 0.08 < found.high and (found.dates, found.sensors) == (2, 14)
    said = fleet.summary(_chosen(fleet_of(rng, 14, 2, growth=0.3))).text()
    assert "from 2020-06-01 to 2021-06-01 (14 sensors, each against itself)" in said
    assert "within a sensor" in said and "of two or three dates, what was other" in said


@pytest.mark.parametrize(
    ("units", "days", "dated", "says"),
    [
        (6, 1, True, "all records are of one date, 2020-06-01"),
        (6, 2, False, "no record has a date"),
        (3, 1, True, "all records are of one date"),
    ],
)
def test_why_no_drift_is_stated(units, days, dated, says):
    table = _chosen(fleet_of(np.random.default_rng(0), units, days))
    found = fleet.summary(table if dated else table.assign(date=None))
    assert not found.drifts and says in found.no_drift["gyro_x"]["likelihood N"]
    assert f"no drift is stated: {says}" in found.text()


def test_what_a_day_has_in_common_is_no_drift():
    """Three dates, on one of which all units are louder: not a line in time."""
    rng = np.random.default_rng(6)
    held, told = 0, 0
    for _ in range(40):
        table, common = fleet_of(rng, 10, 3), np.exp(0.15 * rng.standard_normal(3))
        for k in range(3):
            table = _scaled(table, table.date == f"{2020 + k}-06-01", common[k])
        found = fleet.drift(table, *ASKED)
        held, told = held + found.covers(0.0), told + (found.common is not None)
    assert held >= 30 and told >= 30  # of 60, 51 hold; with the units' own scatter alone, 6
    alarms = [fleet.drift(fleet_of(rng, 8, 3), *ASKED).common for _ in range(40)]
    assert sum(a is not None for a in alarms) <= 6  # 5 % each


def test_several_records_of_a_date_do_not_count_as_dates():
    rng = np.random.default_rng(7)
    table = fleet_of(rng, 8, 2, day=0.2, error=0.01)
    again = table.assign(file=table.file + "_again")
    once, twice = (fleet.by_sensor(t) for t in (table, pd.concat([table, again])))
    assert twice.index.equals(once.index)
    # the same day measured again tells nothing of other days
    width = np.log(twice.high / twice.low) / np.log(once.high / once.low)
    assert width.median() == pytest.approx(1.0, abs=0.1)


def test_a_step_over_dates_is_named():
    rng = np.random.default_rng(8)
    alarms = sum(len(fleet.steps(fleet_of(rng, 10, 3), *ASKED)) > 0 for _ in range(20))
    assert alarms < 6  # 1 expected
    table = fleet_of(rng, 10, 3)
    table = _scaled(table, (table.sensor == "u4") & (table.date > "2021-01-01"), 1.6)
    found = fleet.steps(table, *ASKED)
    assert list(found.index) == ["u4"] and found.after.iloc[0] == "2021-06-01"
    assert "step: u4, gyro_x N" in fleet.summary(_chosen(table)).text()


def test_two_outliers_do_not_hide_each_other():
    table = fleet_of(np.random.default_rng(9), 14, 1)
    table = _scaled(table, table.sensor.isin(["u3", "u9"]), 5.0)
    assert set(fleet.outliers(table, *ASKED).index) == {"u3", "u9"}
    found = fleet.summary(_chosen(table))
    key = "gyro_x", "likelihood N"
    every, less = (s[key[0]][key[1]] for s in (found.spreads, found.without_outliers))
    assert every.units == 14 and less.units == 12
    assert less.scatter.covers(0.2) and not every.scatter.covers(0.2)
    assert "the table includes" in found.text() and "u3 and u9" in found.text()


def test_model_and_summary_give_one_answer():
    rng = np.random.default_rng(10)
    table = _chosen(fleet_of(rng, 12, 1))
    some = (table.sensor.isin(["u1", "u2", "u3"])) & table.effect.notna()
    table.loc[some, "effect"] = "white + walk"
    found = fleet.summary(table)
    spread = found.spreads["gyro_x"]["likelihood N"]
    told = found.model.extra["spread"]["gyro_x"]["N"]
    assert found.model["gyro_x"].terms[0].N == spread.typical.value
    assert told == {"scatter": spread.scatter.value, "worst": spread.worst, "units": 12}


def test_remarks():
    table = _chosen(fleet_of(np.random.default_rng(11), 6, 1)).assign(rate=50.0)
    table = table.replace({"sensor": {"u1": "U0"}})
    copied = table[table.sensor == "u2"].assign(sensor="u7", file="copy of u2_0")
    table = pd.concat([table, copied.assign(rate=100.0)])
    said = " ".join(fleet.summary(table).notes)
    assert "u2_0 and copy of u2_0 give the same numbers" in said
    assert "'u0' and 'U0'" in said and "50 Hz (6) and 100 Hz (1)" in said
    assert "Each sensor has one record" in said


def test_units_that_lack_a_process_do_not_make_the_scatter():
    """Two of eleven without it, far below what the others show; and limits that say something."""
    rng = np.random.default_rng(12)
    y = 0.05 * rng.standard_normal(11) + 0.2 * rng.standard_normal(11)
    table = np.exp([y, y - 0.39, y + 0.39])
    table[:, :2] = [[np.nan] * 2, [0.0] * 2, [0.25] * 2]
    found = of_units(*table)
    assert (found.shown, found.units) == (9, 11)
    assert found.typical.covers(1.0) and found.scatter.covers(0.05) and found.worst < 2.0
