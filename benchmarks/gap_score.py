"""Score of the gap workflow on records in which effects are hidden.

    python benchmarks/gap_score.py --cases 30 --first 10000 --log cases.jsonl    # goes on from it
    python benchmarks/gap_score.py --cases 2 --simulations 100 --name gap_score_index
    python benchmarks/gap_score.py --kinds step,telegraph --cases 5 --print

Each effect of the catalogue, pairs, none, and effects without a name; with `--simulations` the gap
index before and after as well. The generator (tests/gap_generator.py) shares no code with the
package. A case counts for the naming rate if the hidden effect is detectable: a log-likelihood gain
of 20 or more at its true parameters. Results go to benchmarks/results/gap_score.json with the
command, the date and the seeds. A run that `--minutes` stops keeps its cases in the `--log`; the
same command goes on from there, and the table is that of all cases in the log.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from datetime import date
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests"), str(ROOT / "benchmarks")]

import gap_final  # noqa: E402
import gap_generator as generator  # noqa: E402
import numpy as np  # noqa: E402
from gap_judge import judge, matches, same_spectrum, show, table, wilson  # noqa: E402

from imu_lib.gap import close  # noqa: E402
from imu_lib.model import Model  # noqa: E402
from imu_lib.record import Record  # noqa: E402

RESULTS = ROOT / "benchmarks" / "results"
__all__ = ["RESULTS", "judge", "matches", "plan", "run", "same_spectrum", "table", "wilson"]


def plan(kinds, cases, first):
    """(seed, kind, effects, duration s, rate Hz, channels) of every case; lengths and rates vary,
    one hour at 100 Hz most often.
    """
    out = []
    for k, kind in enumerate(kinds):
        for i in range(cases):
            seed = first + 1000 * k + i
            rng = np.random.default_rng([seed, 5])
            duration, fs = [
                (3600, 100),
                (3600, 100),
                (3600, 100),
                (1800, 100),
                (5400, 50),
                (1800, 200),
            ][int(rng.integers(6))]
            if kind == "pair":
                pool = [e for e in generator.KNOWN]
                effects = list(rng.choice(pool, 2, replace=False))
            elif kind == "none":
                effects = []
            else:
                effects = [kind]
            two = (
                any(e in generator.RECORD for e in effects)
                or kind in ("none", "pair")
                or rng.random() < 0.3
            )
            channels = (
                ("gyro_x", "accel_y")
                if not two
                else ("gyro_x", "gyro_y")
                if rng.random() < 0.5
                else ("gyro_z", "accel_x")
            )
            out.append(
                (
                    seed,
                    kind,
                    effects,
                    float(duration),
                    float(fs),
                    channels[:2] if two else channels[:1],
                )
            )
    return out


def run(case, *, free=False, simulations=0):
    """One case: what was hidden, what was found, in a form that can be stored."""
    seed, kind, effects, duration, fs, channels = case
    made = generator.make(seed, effects, duration=duration, fs=fs, channels=channels)
    record = Record(made.channels, fs, time=made.time, temperature=made.temperature)
    model = None if free else Model.from_json(made.base)
    started = time.perf_counter()
    cpu = time.process_time()
    found = close(record, model, simulations=simulations, jobs=1)
    steps = [
        {
            "channel": c,
            "effect": s.effect,
            "confidence": s.confidence,
            "parameters": s.to_json()["parameters"],
            "intervals": s.to_json()["intervals"],
            "indistinguishable": s.indistinguishable,
            "changes": s.to_json()["changes"],
            "runner_up": s.runner_up["effect"],
            "calibrated": True,
        }
        for c, s in found.steps
    ]
    left = {c: r.result.unexplained for c, r in found.channels.items()}
    left["record"] = found.record_unexplained
    truths = json.loads(json.dumps(made.truths, default=float))
    out = {
        "seed": seed,
        "kind": kind,
        "duration": duration,
        "rate": fs,
        "channels": list(channels),
        "truths": truths,
        "steps": steps,
        "unexplained": left,
        "absorbed": {c: r.result.absorbed for c, r in found.channels.items()},
        "seconds": time.perf_counter() - started,
        "cpu": time.process_time() - cpu,
        "base": {c: [e["process"] for e in made.base[c]] for c in channels},
    }
    out["final"] = gap_final.judged(made, found)
    if simulations:
        out["gap"] = {
            c: [r.before.value, r.after.value, r.held_out] for c, r in found.channels.items()
        }
    out.update(judge(out))
    return out


def merge(names, into):
    """Stored runs put together into one table; they must not share seeds within a kind."""
    runs = [json.loads((RESULTS / f"{name}.json").read_text()) for name in names]
    cases = [c for r in runs for c in r["cases"]]
    seen = [(c["kind"], c["seed"], tuple(c["channels"])) for c in cases]
    if len(set(seen)) < len(seen):
        raise SystemExit("the runs share seeds")
    cases.sort(
        key=lambda c: ["none", *generator.KNOWN, "pair", *generator.UNKNOWN].index(c["kind"])
    )
    rows = table(cases)
    show(rows)
    out = {
        "command": "; ".join(r["command"] for r in runs),
        "date": runs[-1]["date"],
        "first_seed": [r["first_seed"] for r in runs],
        "free_base": runs[0]["free_base"],
        "table": rows,
        "cases": cases,
    }
    (RESULTS / f"{into}.json").write_text(json.dumps(out, indent=None, default=float) + "\n")


def arguments(argv):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--kinds", default=",".join(("none", *generator.KNOWN, "pair", *generator.UNKNOWN))
    )
    parser.add_argument("--cases", type=int, default=30)
    parser.add_argument("--first", type=int, default=10000)
    parser.add_argument("--free", action="store_true")
    parser.add_argument(
        "--print",
        action="store_true",
        dest="shown",
        help="print every case that is not named right; store nothing",
    )
    parser.add_argument("--minutes", type=float, default=1e9, help="stop after this time")
    parser.add_argument(
        "--simulations",
        type=int,
        default=0,
        help="size of the ensembles of the gap index; 0 leaves it out",
    )
    parser.add_argument(
        "--log", help="a file of finished cases, one a line; a run that finds it goes on from there"
    )
    parser.add_argument("--name", default="gap_score")
    parser.add_argument(
        "--part",
        default="0/1",
        metavar="I/K",
        help="run every Kth case from the Ith on, into --log only",
    )
    parser.add_argument(
        "--merge", metavar="NAMES", help="put stored runs together under --name instead of running"
    )
    return parser.parse_args(argv)


def is_good(r):
    """Whether all that is detectable was named, nothing else surely, and an unknown effect said."""
    return (
        r["named"] == r["detectable"]
        and not r["wrong"]
        and not r["false"]
        and (r["said"] or not any(t["effect"] == "unknown" for t in r["truths"]))
    )


def show_case(r):
    """A case that is not named right, in full."""
    print(
        "--",
        r["kind"],
        r["seed"],
        f"{r['duration']:.0f}s {r['rate']:.0f}Hz {r['cpu']:.1f}s cpu",
        r["base"],
    )
    for t in r["truths"]:
        print(
            "     hid  ",
            t["channel"],
            t["effect"],
            t.get("kind", ""),
            f"{t['gain']:.0f}",
            t.get("parameters"),
        )
    for s in r["steps"]:
        values = {
            k: (float(f"{v:.4g}") if isinstance(v, float) else v)
            for k, v in s["parameters"].items()
        }
        print(
            "     found",
            s["channel"],
            s["effect"],
            values,
            f"{s['confidence']:.2f}",
            s["indistinguishable"],
        )
    print("     left ", {k: v for k, v in r["unexplained"].items() if v}, flush=True)


def main(argv=None):
    args = arguments(argv)
    if args.merge:
        return merge(args.merge.split(","), args.name)
    cases = plan(args.kinds.split(","), args.cases, args.first)
    # kinds take turns, so that a run that is stopped early has some of each
    cases.sort(key=lambda c: (c[0] - args.first) % 1000)
    results, started = [], time.time()
    log = Path(args.log) if args.log else None
    if log and log.exists():
        results = [json.loads(line) for line in log.read_text().splitlines()]
    done = {(r["kind"], r["seed"]) for r in results}
    part, parts = map(int, args.part.split("/"))
    cases = cases[part::parts]
    for case in cases:
        if (case[1], case[0]) in done:
            continue
        if time.time() - started > 60 * args.minutes:
            break
        try:
            r = run(case, free=args.free, simulations=args.simulations)
        except Exception as error:
            if args.shown:
                import traceback

                traceback.print_exc()
            print("FAILED", case, repr(error), file=sys.stderr)
            continue
        results.append(r)
        if log:
            with log.open("a") as file:
                file.write(json.dumps(r, default=float) + "\n")
        if args.shown and not is_good(r):
            show_case(r)
    order = {kind: i for i, kind in enumerate(args.kinds.split(","))}
    results.sort(key=lambda r: (order[r["kind"]], r["seed"]))
    rows = table(results)
    show(rows)
    if not args.shown and parts == 1:
        RESULTS.mkdir(exist_ok=True)
        command = " ".join(["python", "benchmarks/gap_score.py", *(argv or sys.argv[1:])])
        out = {
            "command": command,
            "date": date.today().isoformat(),
            "first_seed": args.first,
            "planned": len(cases),
            "free_base": args.free,
            "table": rows,
            "cases": results,
        }
        (RESULTS / f"{args.name}.json").write_text(json.dumps(out, default=float) + "\n")


if __name__ == "__main__":
    main()
