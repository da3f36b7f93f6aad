"""Coverage of the Gauss-Markov intervals that the autocorrelation gives, against reading off and
plain least squares.

    python benchmarks/autocorrelation_coverage.py [--reps 300]

Writes benchmarks/results/autocorrelation_coverage.json: for each known process the share of 95 %
intervals of sigma and Tc that hold the truth, the bias, the scatter against the stated width, and
the same for the curve read at 1/e.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from datetime import date
from importlib.metadata import version
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402

from imu_lib import autocorrelation, scheduler  # noqa: E402
from imu_lib.processes import GaussMarkov, RandomWalk, WhiteNoise  # noqa: E402

#: name -> (process and company, rate Hz, duration s)
CASES = {
    "alone, 200 Tc": (GaussMarkov(1.0, 10.0) + WhiteNoise(0.0), 2.0, 2000.0),
    "alone, 50 Tc": (GaussMarkov(1.0, 10.0) + WhiteNoise(0.0), 2.0, 500.0),
    "white noise of a gyro, 200 Tc": (GaussMarkov(1.0, 100.0) + WhiteNoise(2.24), 1.0, 20_000.0),
    "white noise of a gyro, 50 Tc": (GaussMarkov(1.0, 100.0) + WhiteNoise(2.24), 1.0, 5000.0),
    "white noise and a walk": (
        GaussMarkov(1.0, 4.0) + WhiteNoise(0.6) + RandomWalk(0.1),
        2.0,
        6000.0,
    ),
    "white noise alone": (WhiteNoise(1.0) + WhiteNoise(0.0), 2.0, 5000.0),
}


def one(model, fs, duration, seed):
    x = model.simulate(int(fs * duration), fs, np.random.default_rng(seed))
    fit = autocorrelation.fit_gauss_markov(x, fs)
    read = autocorrelation.read_off(autocorrelation.autocorrelation(x, fs, max_lag=duration / 10))
    return fit.sigma, fit.correlation_time, read


def summary(model, rows):
    truth = next((p for p in model if p.name == "gauss_markov"), None)
    shown = [r for r in rows if r[0].shown]
    out = {"shown": len(shown) / len(rows)}
    if truth is None:
        return out
    for i, (name, value) in enumerate(
        (("sigma", truth.sigma), ("correlation_time", truth.correlation_time))
    ):
        logs = np.log([r[i].value / value for r in shown])
        out[name] = {
            "coverage": float(np.mean([r[i].covers(value) for r in rows])),
            "median_ratio": float(np.exp(np.median(logs))),
            "scatter": float(np.std(logs)),
            "stated": float(np.median([np.log(r[i].high / r[i].low) / 3.92 for r in shown])),
            "read_off_median_ratio": float(np.nanmedian([r[2][i] for r in rows]) / value),
        }
    return out


def main(argv=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--reps", type=int, default=300)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--scheduler", help="address of a Dask cluster, instead of --jobs")
    args = parser.parse_args(argv)
    table = {}
    for k, (name, case) in enumerate(CASES.items()):
        tasks = [(*case, [20_131, k, i]) for i in range(args.reps)]
        rows = scheduler.every(one, tasks, workers=args.jobs, address=args.scheduler)
        table[name] = summary(case[0], rows)
        print(name, json.dumps(table[name]), flush=True)
    result = {
        "command": f"python benchmarks/autocorrelation_coverage.py --reps {args.reps}",
        "date": date.today().isoformat(),
        "seeds": f"[20131, case, 0..{args.reps - 1}]",
        "versions": {p: version(p) for p in ("numpy", "scipy")},
        "cases": table,
    }
    path = ROOT / "benchmarks" / "results" / "autocorrelation_coverage.json"
    path.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
