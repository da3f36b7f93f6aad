"""Six axes of seven hours through `characterise`: wall time, and where the time goes on one axis.

python benchmarks/characterise_speed.py --workers 2
"""

from __future__ import annotations

import argparse
import json
import os
import time
from pathlib import Path

from imu_lib import allan, autocorrelation, autoregressive, datasets, likelihood, spectrum
from imu_lib.characterise import characterise, fitted

RESULT = Path(__file__).parent / "results" / "characterise_speed.json"


def parts(x, fs):
    """Processor time of each method on one axis, s, everything compiled before."""
    methods = {
        "Allan variance": lambda: (allan.deviation(x, fs), allan.characterise(x, fs)),
        "spectrum": lambda: spectrum.characterise(x, fs),
        "autocorrelation": lambda: autocorrelation.characterise(x, fs),
        "autoregressive": lambda: autoregressive.characterise(x, fs),
        "likelihood": lambda: fitted(
            likelihood.Statistics.of(x, fs, exclude_lines=True), x.var(), fs, None, []
        ),
    }
    stats = likelihood.Statistics.of(x, fs)
    model = likelihood.CANDIDATES["white + Gauss-Markov + walk"]
    fit = likelihood.fit(stats, None, model)
    methods |= {
        "of it: statistics": lambda: likelihood.Statistics.of(x, fs),
        "of it: one fit with intervals": lambda: likelihood.fit(stats, None, model),
        "of it: one likelihood": lambda: likelihood.log_likelihood(stats, fit.model),
    }
    out = {}
    for name, run in methods.items():
        run()
        start = time.process_time()
        run()
        out[name] = time.process_time() - start
    return out


def main(arguments=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, default=RESULT)
    options = parser.parse_args(arguments)
    record = datasets.twin()
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else None
    start = time.perf_counter()
    characterise(record, workers=options.workers)
    wall = time.perf_counter() - start
    table = parts(record["accel_x"], record.rate)
    options.out.parent.mkdir(exist_ok=True)
    options.out.write_text(
        json.dumps(
            {
                "command": f"python benchmarks/characterise_speed.py --workers {options.workers}",
                "date": time.strftime("%Y-%m-%d", time.gmtime()),
                "cores": os.cpu_count(),
                "load_before": load,
                "samples": record.n,
                "channels": len(record.channel_names),
                "wall_s": round(wall, 2),
                "processor_s_per_axis": {k: round(v, 4) for k, v in table.items()},
            },
            indent=1,
        )
        + "\n"
    )
    print(f"{wall:.1f} s wall, {options.workers} workers, load before {load}")
    for name, seconds in table.items():
        print(f"  {name:30s} {seconds:.4f} s")


if __name__ == "__main__":
    main()
