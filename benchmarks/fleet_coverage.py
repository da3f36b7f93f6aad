"""How often a fleet's intervals hold what its table was drawn from: typical value, scatter from
unit to unit apart from the estimates' error, the worst of 95 %, drift over dates, sensor against
day.

Tables are drawn here, with nothing of the estimators: the units' logarithms are normal, or of
Student's t with 4 degrees of freedom, which no question assumes.

python benchmarks/fleet_coverage.py --runs 400
"""

from __future__ import annotations

import argparse
import json
import time
import warnings
from pathlib import Path

import numpy as np
import pandas as pd

from imu_lib import fleet
from imu_lib.fleet.spread import of_units

RESULT = Path(__file__).parent / "results" / "fleet_coverage.json"
SCATTER, DAY, GROWTH = 0.2, 0.1, 0.1
ASKED = ("gyro_x", "likelihood", "N")


def truths(rng, units, kind):
    """Logarithms of the units' true values, standard deviation SCATTER."""
    if kind == "normal":
        return SCATTER * rng.standard_normal(units)
    return SCATTER * rng.standard_t(4, units) / np.sqrt(2.0)


def worst(kind):
    """Logarithm that 95 % of all units stay below."""
    from scipy import stats

    if kind == "normal":
        return SCATTER * stats.norm.ppf(0.95)
    return SCATTER * stats.t.ppf(0.95, 4) / np.sqrt(2.0)


def of_one_date(rng, units, kind):
    y, s = truths(rng, units, kind), rng.uniform(0.02, 0.3, units)
    value = y + s * rng.standard_normal(units)
    found = of_units(*(np.exp(value + k * 1.959964 * s) for k in (0, -1, 1)))
    return {
        "typical": found.typical.covers(1.0),
        "scatter": found.scatter.covers(SCATTER),
        "worst of 95 %": found.worst > np.exp(worst(kind)),
    }


def of_dates(rng, units, kind):
    rows = []
    for unit, true in enumerate(truths(rng, units, kind)):
        for year in range(4):
            s = rng.uniform(0.02, 0.1)
            y = true + DAY * rng.standard_normal() + s * rng.standard_normal() + GROWTH * year
            rows.append(
                dict.fromkeys(fleet.rows.COLUMNS)
                | {"sensor": f"u{unit}", "date": f"{2020 + year}-06-01"}
                | dict(zip(("channel", "method", "coefficient"), ASKED))
                | dict(zip(("value", "low", "high"), np.exp([y, y - 1.96 * s, y + 1.96 * s])))
            )
    table = pd.DataFrame(rows)
    change = fleet.drift(table, *ASKED)
    still = table.copy()
    years = np.tile(np.arange(4), units)
    for name in ("value", "low", "high"):
        still[name] = still[name] * np.exp(-GROWTH * years)
    two = fleet.sensor_and_day(still, *ASKED)
    return {
        "drift": change.covers(GROWTH),
        "sensor": two["sensor"].covers(SCATTER),
        "day": two["day"].covers(DAY),
    }


def counted(task, units, kind, runs, seed):
    """(question, units, kind of scatter, runs, held)."""
    held: dict = {}
    for run in range(runs):
        for name, ok in task(np.random.default_rng([seed, run]), units, kind).items():
            held[name] = held.get(name, 0) + bool(ok)
    return [
        {"question": name, "units": units, "scatter": kind, "runs": runs, "held": n}
        for name, n in held.items()
    ]


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=400)
    parser.add_argument("--units", type=int, nargs="*", default=[5, 15, 50])
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=RESULT)
    options = parser.parse_args(arguments)
    warnings.simplefilter("ignore", RuntimeWarning)
    rows = []
    for units in options.units:
        for kind in ("normal", "student"):
            rows += counted(of_one_date, units, kind, options.runs, options.seed)
            rows += counted(of_dates, units, kind, options.runs, options.seed)
            for row in rows[-6:]:
                print(row, row["held"] / row["runs"], flush=True)
            told = {
                "command": f"python benchmarks/fleet_coverage.py --runs {options.runs} "
                f"--units {' '.join(map(str, options.units))} --seed {options.seed}",
                "date": time.strftime("%Y-%m-%d"),
                "table": rows,
            }
            options.out.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
