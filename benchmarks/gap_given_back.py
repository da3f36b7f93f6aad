"""The cycle of the gap workflow: the model that it has grown, given back with a new record of
itself.

    python benchmarks/gap_given_back.py --cases 10 --first 9500000 --log back.jsonl     # resumes
    python benchmarks/gap_given_back.py --kinds telegraph,low_pass --cases 5 --print

Each case of the score (benchmarks/gap_score.py) is grown as there; its grown model draws a new
record in time, by the processes' own recursions (what the workflow fits and what its ensembles draw
come from their spectra), and is given with it. What is then named or left unexplained is a fault:
of the model that was grown, of a form that two parts of the package do not share, or of chance. A
channel that the first pass could not explain in full has no model of its own and is left out. The
table goes to benchmarks/results/gap_given_back.json.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections import Counter
from datetime import date
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests"), str(ROOT / "benchmarks")]

import gap_generator as generator  # noqa: E402
import numpy as np  # noqa: E402
from _log import Log  # noqa: E402
from gap_score import RESULTS, plan, wilson  # noqa: E402

from imu_lib.ensembles import ensemble  # noqa: E402
from imu_lib.gap import close  # noqa: E402
from imu_lib.model import Model  # noqa: E402
from imu_lib.record import Record  # noqa: E402


def run(case, *, free=False) -> dict:
    """One case: what was found first, and what was found in the new record, by channel."""
    seed, kind, effects, duration, fs, channels = case
    made = generator.make(seed, effects, duration=duration, fs=fs, channels=channels)
    record = Record(made.channels, fs, time=made.time, temperature=made.temperature)
    started = time.process_time()
    base = None if free else Model.from_json(made.base)
    first = close(record, base, simulations=0, jobs=1)
    again = drawn(first, made, int(duration * fs), np.random.default_rng([seed, 77]))
    second = close(again, first.model, simulations=0, jobs=1)
    explained = [c for c, r in first.channels.items() if r.result.unexplained is None]
    return {
        "seed": seed,
        "kind": kind,
        "duration": duration,
        "rate": fs,
        "first": {c: [s.effect for w, s in first.steps if w == c] for c in (*channels, "record")},
        "channels": explained,
        "second": {c: [_short(s) for s in second.channels[c].result.steps] for c in explained},
        "left": {c: second.channels[c].result.unexplained for c in explained},
        "record": [_short(s) for s in second.record_steps],
        "record_left": None if first.record_unexplained else second.record_unexplained,
        "model": {c: [p.name for p in first.model[c]] for c in channels},
        "cpu": round(time.process_time() - started, 1),
    }


def drawn(report, made, n: int, rng) -> Record:
    """A new record of `n` samples of the grown model of `report`, on the levels of the case."""
    fs, temperature, channels = made.fs, made.temperature, {}
    t = np.arange(n) / fs
    if temperature is not None and len(temperature) != n:  # samples are missing
        temperature = np.interp(t, made.time, temperature)
    for name, result in report.channels.items():
        entry = report.model[name]
        level = ensemble.behind_mean(entry, result.result.mean, n, fs, temperature)
        channels[name] = ensemble.centred(entry, level, t, temperature)
    model = report.model.with_channels(channels)
    return model.simulate_record(n, fs, rng, temperature=temperature)


def _short(step) -> list:
    gain = None if step.gain is None else round(float(min(step.gain, 1e6)), 1)
    return [step.effect, round(float(step.confidence), 3), gain]


def alarms(row) -> list[str]:
    """The channels of a case in which something was found or left unexplained."""
    out = [c for c in row["channels"] if row["second"][c] or row["left"][c]]
    return out + (["record"] if row["record"] or row["record_left"] else [])


def table(rows) -> list[dict]:
    """Alarms by kind of case, and all in all."""
    out = []
    for kind in [*dict.fromkeys(r["kind"] for r in rows), "all"]:
        part = [r for r in rows if kind in (r["kind"], "all")]
        found = [c for r in part for c in alarms(r) if c != "record"]
        channels = sum(len(r["channels"]) for r in part)
        named = Counter(s[0] for r in part for c in r["channels"] for s in r["second"][c])
        out.append(
            {
                "kind": kind,
                "cases": len(part),
                "channels": channels,
                "alarms": len(found),
                "interval": wilson(len(found), channels),
                "named": dict(named),
                "on_record": sum("record" in alarms(r) for r in part),
            }
        )
    return out


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kinds", default=",".join(("none", *generator.KNOWN, "pair")))
    parser.add_argument("--cases", type=int, default=10)
    parser.add_argument("--first", type=int, default=9500000)
    parser.add_argument("--free", action="store_true", help="no base is given to the first pass")
    parser.add_argument("--minutes", type=float, default=1e9, help="stop after this time")
    parser.add_argument("--log", help="finished cases, one a line; a run that finds it goes on")
    parser.add_argument("--print", action="store_true", dest="shown", help="store nothing")
    args = parser.parse_args(argv)
    cases = plan(args.kinds.split(","), args.cases, args.first)
    cases.sort(key=lambda c: (c[0] - args.first) % 1000)  # kinds take turns
    log = Log(args.log)
    rows = log.rows
    done, started = {(r["kind"], r["seed"]) for r in rows}, time.time()
    for case in cases:
        if (case[1], case[0]) in done:
            continue
        if time.time() - started > 60 * args.minutes:
            break
        log.add(run(case, free=args.free))
        if alarms(rows[-1]):
            print(rows[-1], flush=True)
    for row in table(rows):
        print(row)
    if not args.shown:
        command = " ".join(["python", "benchmarks/gap_given_back.py", *(argv or sys.argv[1:])])
        out = {
            "command": command,
            "date": date.today().isoformat(),
            "free_base": args.free,
            "table": table(rows),
            "alarms": [r for r in rows if alarms(r)],
        }
        (RESULTS / "gap_given_back.json").write_text(
            json.dumps(out, indent=1, default=float) + "\n"
        )


if __name__ == "__main__":
    main()
