"""A fleet of sensors: every record characterised once, one table, and what the table answers.

`entries(folder)` lists the records, `characterise(entries, out)` makes the table, `load(out)` opens
it; `spread`, `outliers`, `drift`, `steps`, `sensor_and_day` and `shares` ask it, `summary` asks all
of them and makes the fleet's error model, `draw` a unit of that.
"""

from imu_lib.fleet.dates import Drift, drift, sensor_and_day, without_drift
from imu_lib.fleet.ledger import Ledger, load
from imu_lib.fleet.manifest import Entry, entries
from imu_lib.fleet.outlying import outliers, steps
from imu_lib.fleet.questions import by_date, by_sensor, coefficients, shares, spread
from imu_lib.fleet.spread import Spread
from imu_lib.fleet.study import coverage, drives, monte_carlo, simulate
from imu_lib.fleet.summary import Summary, draw, fleet_model, summary
from imu_lib.fleet.work import characterise

__all__ = [
    "simulate",
    "monte_carlo",
    "drives",
    "coverage",
    "Drift",
    "Entry",
    "Ledger",
    "Spread",
    "Summary",
    "by_date",
    "by_sensor",
    "characterise",
    "coefficients",
    "draw",
    "drift",
    "entries",
    "fleet_model",
    "load",
    "outliers",
    "sensor_and_day",
    "shares",
    "spread",
    "steps",
    "summary",
    "without_drift",
]
