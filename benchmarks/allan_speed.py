"""Overlapped Allan deviation of 2.52 million samples at 100 averaging times: ours and allantools',
side by side.

    python benchmarks/allan_speed.py

Both run in this process on the same record and the same averaging times, in turn; the table has
the median and the fastest of the rounds, the ratio of each pair, the largest relative difference
of the results, and the greatest memory that each allocated above its input (tracemalloc, which
sees numpy's arrays).
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import time
import tracemalloc
from importlib import metadata
from pathlib import Path

import allantools
import numpy as np

from imu_lib import allan, preset

RESULT = Path(__file__).parent / "results" / "allan_speed.json"


def peak(call):
    """Greatest memory allocated above what was there before, MiB."""
    tracemalloc.start()
    call()
    top = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return top / 2**20


def timed(call):
    start = time.perf_counter()
    result = call()
    return time.perf_counter() - start, result


def main(arguments=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--hours", type=float, default=7.0)
    options = parser.parse_args(arguments)
    n, fs = round(options.hours * 360_000), 100.0
    x = preset("3dm-gx3-25")["accel_z"].simulate(n, fs, np.random.default_rng(1)) - 9.80665
    tau = allan.cluster_lengths(n, per_decade=40) / fs

    def ours():
        return allan.deviation(x, fs, taus=tau)

    def theirs():
        return allantools.oadev(x, rate=fs, data_type="freq", taus=tau)

    start = time.perf_counter()
    allan.deviation(x[:1000], fs)
    first = time.perf_counter() - start
    curve, reference = ours(), theirs()
    same = np.isin(curve.m, np.rint(reference[0] * fs).astype(int))
    difference = float(np.abs(curve.adev[same] / reference[1] - 1).max())
    pairs = [(timed(ours)[0], timed(theirs)[0]) for _ in range(options.rounds)]
    mine, other = np.array(pairs).T
    result = {
        "command": "python benchmarks/allan_speed.py",
        "date": time.strftime("%Y-%m-%d", time.gmtime()),
        "machine": {
            "processors": os.cpu_count(),
            "load_before": os.getloadavg()[0] if hasattr(os, "getloadavg") else None,
            "system": platform.system(),
            "python": platform.python_version(),
        },
        "versions": {name: metadata.version(name) for name in ("numpy", "numba", "allantools")},
        "samples": n,
        "averaging_times": int(tau.size),
        "imu_lib": {
            "median_s": float(np.median(mine)),
            "fastest_s": float(mine.min()),
            "peak_MiB": peak(ours),
            "first_call_s": first,
        },
        "allantools": {
            "median_s": float(np.median(other)),
            "fastest_s": float(other.min()),
            "peak_MiB": peak(theirs),
        },
        "ratio": {
            "median": float(np.median(other / mine)),
            "lowest": float((other / mine).min()),
            "of_fastest": float(other.min() / mine.min()),
        },
        "largest_relative_difference": difference,
    }
    RESULT.parent.mkdir(exist_ok=True)
    RESULT.write_text(json.dumps(result, indent=1) + "\n")
    print(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
