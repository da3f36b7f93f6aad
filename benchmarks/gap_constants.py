"""What sets three constants of the competition: how much more a fit gains than its screening
promises (`rounds.MOST_OF_SCREENED`), how often a noise that is not there enters a free base
(`base_fit.PER_NOISE`), and how evidences of rivals scatter beyond what they say (`state.TEMPER`).

    python benchmarks/gap_constants.py --cases 1 --first 9600000

The first runs through the score's kinds on records of ten minutes and looks at every candidate that
is fitted, however little it promises beside what a round needs; the second draws records of white
noise, and of white noise and a walk, and counts the families that a free base would take at several
prices of a noise; the third is the slope of right names on the stored weights
(benchmarks/gap_reliability.py). The table goes to benchmarks/results/gap_constants.json.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from datetime import date
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests"), str(ROOT / "benchmarks")]

import gap_generator as generator  # noqa: E402
import gap_hidden as hidden  # noqa: E402
import numpy as np  # noqa: E402
from gap_score import RESULTS, wilson  # noqa: E402

from imu_lib.gap import base_fit, reliability, rounds  # noqa: E402
from imu_lib.gap.channel import analyse  # noqa: E402
from imu_lib.gap.data import SCREEN, Data  # noqa: E402
from imu_lib.gap.state import TEMPER  # noqa: E402
from imu_lib.processes import RandomWalk, Sum, WhiteNoise, from_json  # noqa: E402

#: Rate, Hz, and length, s, of the records here.
RATE, SPAN = 100.0, 600.0
#: Prices of a noise in a free base that are tried.
PRICES = (0.0, 0.5, 1.0, 2.0, 3.0)


def screened(cases: int, first: int) -> dict:
    """Gain over what the screening promised, of every candidate that was fitted."""
    ratios, fitted = [], rounds._weighed

    def weighed(item, trial, state):
        out = fitted(item, trial, state)
        if item.at is None and item.signal is None:
            ratios.append(out.gain / (item.screen + SCREEN))
        return out

    most, rounds.MOST_OF_SCREENED = rounds.MOST_OF_SCREENED, np.inf
    rounds._weighed = weighed
    try:
        for k, kind in enumerate(("none", *hidden.SPECTRAL, *hidden.DRIFTS, "low_pass")):
            for i in range(cases):
                effects = () if kind == "none" else (kind,)
                seed = first + 100 * k + i
                made = generator.make(seed, effects, duration=SPAN, fs=RATE, channels=("gyro_x",))
                base = Sum.of(from_json(e) for e in made.base["gyro_x"])
                x, warm = made.channels["gyro_x"], made.temperature
                analyse("gyro_x", x, RATE, base, temperature=warm)
    finally:
        rounds._weighed, rounds.MOST_OF_SCREENED = fitted, most
    ratios = np.array(ratios)
    return {
        "candidates": len(ratios),
        "quantiles": {q: round(float(np.quantile(ratios, q)), 3) for q in (0.5, 0.9, 0.99, 0.999)},
        "beyond": int(np.sum(ratios > most)),
    }


def priced(records: int, first: int) -> list[dict]:
    """How often a free base takes more noises than there are, at each price of a noise."""
    out = []
    for name, true in (("white", ()), ("white and walk", (RandomWalk(K=3e-5),))):
        more = dict.fromkeys(PRICES, 0)
        model = Sum((WhiteNoise(N=1e-3), *true))
        for i in range(records):
            rng = np.random.default_rng(first + i)
            data = Data(model.simulate(int(SPAN * RATE), RATE, rng), RATE)
            states = base_fit._families(data, ())
            for price in PRICES:
                best = max(states, key=lambda s: s.evidence - price * len(s.base))
                more[price] += len(best.base) > len(model.terms)
        out += [
            {"noise": name, "price": p, "records": records, "more": k, "share": wilson(k, records)}
            for p, k in more.items()
        ]
    return out


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=1, help="of each kind, for the screening")
    parser.add_argument("--records", type=int, default=60, help="for the price of a noise")
    parser.add_argument("--first", type=int, default=9600000)
    args = parser.parse_args(argv)
    out = {
        "command": " ".join(["python", "benchmarks/gap_constants.py", *(argv or sys.argv[1:])]),
        "date": date.today().isoformat(),
        "screened": screened(args.cases, args.first),
        "price_of_a_noise": priced(args.records, args.first + 50_000),
        "effective_temper": round(TEMPER / reliability.SLOPE, 2),
    }
    print(json.dumps(out, indent=1))
    (RESULTS / "gap_constants.json").write_text(json.dumps(out, indent=1) + "\n")


if __name__ == "__main__":
    main()
