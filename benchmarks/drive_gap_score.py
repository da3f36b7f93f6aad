"""Score of the gap workflow on drives in which effects are hidden.

    python benchmarks/drive_gap_score.py --cases 3 --first 5000 --log drives.jsonl    # resumes
    python benchmarks/drive_gap_score.py --kinds none,pair --cases 5 --print
    python benchmarks/drive_gap_score.py --cases 3 --minutes 20 --free     # without an error model

The generator (tests/drive_generator.py) shares no code with the navigation package. A single effect
counts for the naming rate if it is detectable: the innovations' log-likelihood gained by the true
effect at its true parameters is 20 or more. Two drives of three are strange: other vehicles, rough
roads, turned cases, gaps, tunnels, centimetre fixes, a sky that changes, 200 Hz. With --outages,
errors in withheld outages under the model found are held against those under the true one. --free
gives the search no error model. Results go to benchmarks/results/NAME.json (--store): all that the
log holds, of one call or of many, drives without an error model apart under `without_model`.
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
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from drive_gap_cases import KINDS, KNOWN, ROOT, UNKNOWN, case
from statsmodels.stats.proportion import proportion_confint

from imu_lib.gap.drive import columns, reliability

RESULTS = ROOT / "benchmarks" / "results"
SURE, DETECTABLE = 0.9, 20.0
BINS = (0.0, 0.5, 0.8, 0.9, 0.99, 1.0)  # of the confidence


def rate(hits, count):
    if not count:
        return None
    low, high = proportion_confint(hits, count, method="beta")
    return {"share": hits / count, "low": float(low), "high": float(high), "of": count}


def true_names(row):
    """What is in a drive."""
    return {e for e, _ in (*row["effects"], *row.get("beside", ()))}


def score(rows):
    """The table: rates with exact 95 % intervals."""
    out = {"single": {}, "nulls": None, "pairs": None, "unknown": {}}
    single = [r for r in rows if r["kind"] in KNOWN]
    seen = [r for r in single if r["gain"] is None or r["gain"] >= DETECTABLE]
    names = lambda r: [s["effect"] for s in r["steps"]]  # noqa: E731
    right = [r for r in seen if r["kind"] in names(r)]
    out["named"] = rate(len(right), len(seen))
    out["detectable"] = rate(len(seen), len(single))
    sure = [
        r
        for r in single
        if any(s["effect"] not in true_names(r) and s["confidence"] >= SURE for s in r["steps"])
    ]
    out["wrong_and_sure"] = rate(len(sure), len(single))
    for kind in KNOWN:
        mine = [r for r in seen if r["kind"] == kind]
        out["single"][kind] = rate(sum(kind in names(r) for r in mine), len(mine))
    nulls = [r for r in rows if r["kind"] == "none"]
    out["nulls"] = rate(sum(bool(set(names(r)) - true_names(r)) for r in nulls), len(nulls))
    pairs = [r for r in rows if r["kind"] == "pair"]
    out["pairs"] = rate(
        sum({e for e, _ in r["effects"]} <= set(names(r)) for r in pairs), len(pairs)
    )
    for kind in UNKNOWN:
        mine = [r for r in rows if r["kind"] == kind]
        out["unknown"][kind] = rate(sum(r["unexplained"] is not None for r in mine), len(mine))
    out["names"] = names_by_class(rows)
    shown = {k: covered([r for r in right if r["kind"] == k], unseen=False) for k in KNOWN}
    out["coverage_of_visible"] = rate(*np.sum([p[:2] for p in shown.values()], axis=0).tolist())
    pairs_of = {k: covered([r for r in right if r["kind"] == k]) for k in KNOWN}
    out["coverage"] = rate(*np.sum([p[:2] for p in pairs_of.values()], axis=0).tolist())
    out["coverage_by_effect"] = {k: rate(*p[:2]) for k, p in pairs_of.items() if p[1]}
    out["within_tenth_or_interval"] = rate(
        *np.sum([p[1:] for p in pairs_of.values()], axis=0)[::-1].tolist()
    )
    out["beside_unexplained"] = frequency(rows, beside=True)
    out["confidence"] = frequency(rows, beside=False)
    judged = [r["outages"] for r in rows if r.get("outages")]
    if judged:
        ratios = [o["after"] / max(o["true"], 1e-3) for o in judged]
        out["outage_after_over_true"] = {
            "median": float(np.median(ratios)), "quantile_90": float(np.quantile(ratios, 0.9)),
            "of": len(ratios),
            "within_tenth": rate(int(np.sum(np.array(ratios) < 1.1)), len(ratios)),
        }  # fmt: skip
    out["seconds"] = float(np.median([r["seconds"] for r in rows])) if rows else None
    return out


def frequency(rows, beside):
    """Names by confidence: how many were found and how many are right, on drives on which something
    was left unexplained, or on the others.
    """
    found = [
        (s["confidence"], s["effect"] in true_names(r))
        for r in rows
        if (r["unexplained"] is not None) == beside
        for s in r["steps"]
    ]
    out = {"found": len(found), "right": sum(hit for _, hit in found), "bins": []}
    for low, high in zip(BINS[:-1], BINS[1:]):
        part = [(c, hit) for c, hit in found if low <= c < high]
        if part:
            mean = float(np.mean([c for c, _ in part]))
            hits = sum(hit for _, hit in part)
            out["bins"].append({"said": mean, "found": len(part), "right": hits})
    return out


def names_by_class(rows):
    """{class of `reliability`: {effect: [found, right]}} of all names: what sets their
    confidence.
    """
    out = {k: {} for k in reliability.COUNTED}
    for r in rows:
        for s in r["steps"]:
            mine = out[
                reliability.kind(
                    s["weight"], reliability.left(r["unexplained"], r.get("right", False))
                )
            ]
            count = mine.setdefault(s["effect"], [0, 0])
            count[0] += 1
            count[1] += s["effect"] in true_names(r)
    return {k: dict(sorted(v.items())) for k, v in out.items()}


def covered(rows, unseen=True):
    """(values inside their interval, values, inside or within a tenth) of rightly named effects;
    unseen: with the components whose interval is what the upper limit leaves.
    """
    inside, total, near = 0, 0, 0
    for r in rows:
        for s in r["steps"]:
            for key, pairs in s["intervals"].items() if s["effect"] == r["kind"] else ():
                truth = r["effects"][0][1].get(key)
                if key == "velocity_offset" and truth is None:
                    truth = r["effects"][0][1]["offset"]
                if truth is None:
                    continue
                values = np.ravel(s["parameters"][key])
                hidden = set() if unseen else {p for e, p in r["unseen"] if e == s["effect"]}
                parts = [columns.ALL[i].component for i in columns.of(s["effect"])]
                listed = [k == key or k.startswith(f"{key} ") for k in parts]
                names = [k for k, mine in zip(parts, listed) if mine] or [key]
                both = np.reshape(pairs, (-1, 2))
                for name, t, v, (low, high) in zip(names, np.ravel(truth), values, both):
                    if name in hidden:
                        continue
                    hit = bool(low <= t <= high)
                    inside, total = inside + hit, total + 1
                    near += hit or abs(v - t) <= 0.1 * abs(t)
    return inside, total, near


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=2)
    parser.add_argument("--first", type=int, default=5000)
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--log", default="drive_gap_cases.jsonl")
    parser.add_argument("--store", default="drive_gap_score", metavar="NAME")
    parser.add_argument("--outages", action="store_true")
    parser.add_argument("--free", action="store_true", help="without an error model")
    parser.add_argument(
        "--minutes", type=float, default=float("inf"), help="then no drive is begun"
    )
    parser.add_argument("--print", action="store_true", dest="show")
    args = parser.parse_args()
    log = Path(args.log)
    rows = [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []
    done = {(r["kind"], r["seed"], r["given"]) for r in rows}
    kinds = [k for k in args.kinds.split(",") if not (args.free and k == "bias_model")]
    own = ("--log", "--store", "--minutes", "--print")
    words = [
        w for a, w in zip(["", *sys.argv[1:]], sys.argv[1:]) if w not in own and a not in own[:3]
    ]
    call, end = (
        " ".join(["python benchmarks/drive_gap_score.py", *words]),
        time.monotonic() + 60.0 * args.minutes,
    )
    for i in range(args.cases):
        for kind in kinds:
            seed = args.first + 1000 * KINDS.index(kind) + i
            if (kind, seed, not args.free) in done or time.monotonic() > end:
                continue
            row = case(kind, seed, args.outages, given=not args.free) | {"call": call}
            rows.append(row)
            with open(log, "a", encoding="utf-8") as handle:
                handle.write(json.dumps(row) + "\n")
            if args.show:
                print(
                    kind, seed, row["gain"], row["effects"], "->", row["steps"], row["unexplained"]
                )
    free = [r for r in rows if not r["given"]]
    result = score([r for r in rows if r["given"]]) | {
        "without_model": score(free) if free else None
    }
    result |= {
        "command": "; ".join(dict.fromkeys(r["call"] for r in rows)),
        "date": date.today().isoformat(), "cases": len(rows),
    }  # fmt: skip
    print(json.dumps(result, indent=1))
    if not args.show:
        (RESULTS / f"{args.store}.json").write_text(
            json.dumps(result, indent=1) + "\n", encoding="utf-8"
        )


if __name__ == "__main__":
    main()
