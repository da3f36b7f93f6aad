"""How often does the likelihood choose the sum of processes that made the record?

    python benchmarks/model_choice.py --draws 60 --jobs 2

Each truth of `TRUTHS` (datasheet-like values of a MEMS gyro) is drawn for two and for seven hours;
the choice between `likelihood.CANDIDATES` is made by BIC and by AIC. Counted: the truth chosen, a
simpler or a different sum chosen, the truth rejected by its own goodness-of-fit p-value at 5 %,
and that of the sum chosen. A truth whose terms the record can't show is no mistake of the
criterion, so the median log-likelihood that the truth gains over the best wrong candidate with
fewer parameters stands beside it.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

import numpy as np
from scipy.stats import beta

from imu_lib import likelihood, scheduler
from imu_lib.processes import Flicker, GaussMarkov, RandomWalk, Sum, WhiteNoise
from imu_lib.units import DEG_PER_HOUR, DEG_PER_HOUR_1_5, DEG_PER_SQRT_HOUR

RESULT = Path(__file__).parent / "results" / "model_choice.json"
RATE = 100.0
N = WhiteNoise(0.5 * DEG_PER_SQRT_HOUR)
TRUTHS = {
    "white": N + Sum(),
    "white + walk": N + RandomWalk(10 * DEG_PER_HOUR_1_5),
    "white + flicker": N + Flicker(8 * DEG_PER_HOUR),
    "white + flicker + walk": N + Flicker(8 * DEG_PER_HOUR) + RandomWalk(25 * DEG_PER_HOUR_1_5),
    "white + Gauss-Markov": N + GaussMarkov(10 * DEG_PER_HOUR, 200.0),
    "white + Gauss-Markov + walk": N
    + GaussMarkov(12 * DEG_PER_HOUR, 60.0)
    + RandomWalk(15 * DEG_PER_HOUR_1_5),
    "white + 2 Gauss-Markov": N
    + GaussMarkov(15 * DEG_PER_HOUR, 15.0)
    + GaussMarkov(12 * DEG_PER_HOUR, 600.0),
}


def one(name, hours, seed):
    """One draw: the two choices, the p-values, what the truth gains."""
    x = TRUTHS[name].simulate(
        round(hours * 3600 * RATE), RATE, np.random.default_rng([seed, list(TRUTHS).index(name)])
    )
    stats = likelihood.Statistics.of(x, RATE)
    choice = likelihood.choose(stats, None, estimates=False)
    fits = choice.fits
    aic = min(fits, key=lambda k: fits[k].aic)
    simpler = [f.loglike for k, f in fits.items() if k != name and f.free <= fits[name].free]
    return {
        "bic": choice.name,
        "aic": aic,
        "p_true": fits[name].p_value,
        "p_chosen": choice.p_value,
        "weight": choice.weights[choice.name],
        "gain": fits[name].loglike - max(simpler) if simpler else None,
    }


def interval(hits, draws):
    """Clopper-Pearson 95 % interval of a share."""
    low = beta.ppf(0.025, hits, draws - hits + 1) if hits else 0.0
    high = beta.ppf(0.975, hits + 1, draws - hits) if hits < draws else 1.0
    return float(low), float(high)


def summary(rows, name):
    """Counts of one truth and record length."""
    right = sum(r["bic"] == name for r in rows)
    # the criterion's own claim: how often it is right when its weight says 95 % or more
    sure = [r for r in rows if r["weight"] >= 0.95]
    return {
        "draws": len(rows),
        "right": right / len(rows),
        "interval": interval(right, len(rows)),
        "right_by_aic": float(np.mean([r["aic"] == name for r in rows])),
        "chosen": {
            k: sum(r["bic"] == k for r in rows) for k in dict.fromkeys(r["bic"] for r in rows)
        },
        "sure": len(sure),
        "wrong_when_sure": sum(r["bic"] != name for r in sure),
        "truth_rejected": float(np.mean([r["p_true"] < 0.05 for r in rows])),
        "chosen_rejected": float(np.mean([r["p_chosen"] < 0.05 for r in rows])),
        "median_gain": float(np.median([r["gain"] for r in rows]))
        if rows[0]["gain"] is not None
        else None,
    }


def main(arguments=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--draws", type=int, default=60)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--scheduler", help="address of a Dask cluster, instead of --jobs")
    parser.add_argument("--out", type=Path, default=RESULT)
    options = parser.parse_args(arguments)
    start = time.time()
    table = {}
    for hours in (2.0, 7.0):
        tasks = [(name, hours, seed) for name in TRUTHS for seed in range(1, options.draws + 1)]
        rows = scheduler.every(one, tasks, workers=options.jobs, address=options.scheduler)
        table[f"{hours:g} h"] = {
            name: summary([r for r, t in zip(rows, tasks) if t[0] == name], name) for name in TRUTHS
        }
    options.out.parent.mkdir(exist_ok=True)
    options.out.write_text(
        json.dumps(
            {
                "command": f"python benchmarks/model_choice.py --draws {options.draws}",
                "rate": RATE,
                "date": time.strftime("%Y-%m-%d", time.gmtime()),
                "truths": {k: v.to_json() for k, v in TRUTHS.items()},
                "table": table,
            },
            indent=1,
        )
        + "\n"
    )
    for hours, entries in table.items():
        print(hours)
        for name, row in entries.items():
            print(
                f"  {name:30s} right {row['right']:.2f} [{row['interval'][0]:.2f}, "
                f"{row['interval'][1]:.2f}] AIC {row['right_by_aic']:.2f}  gain "
                f"{row['median_gain'] or 0:7.1f}  truth rejected {row['truth_rejected']:.2f}  "
                f"{row['wrong_when_sure']}/{row['sure']} wrong when sure  {row['chosen']}"
            )
    print(f"{time.time() - start:.0f} s")


if __name__ == "__main__":
    main()
