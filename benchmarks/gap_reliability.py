"""Is a confidence a frequency? Right names among the findings of the stored scores, by confidence.

    python benchmarks/gap_reliability.py

Counts every finding of the stored tables gap_score, gap_score_free, gap_score_pairs and
gap_injected: its confidence, and whether what it names had been hidden in that channel. Findings
beside something that was left unexplained, slopes beside a filter, and names whose weight among
their rivals was stored, are counted with the confidence that `gap/reliability.py` gives them now. The
table goes to benchmarks/results/gap_reliability.json.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from datetime import date
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests"), str(ROOT / "benchmarks")]

import numpy as np  # noqa: E402
from gap_score import RESULTS, matches, same_spectrum, wilson  # noqa: E402

from imu_lib.gap import left_beside, reliability  # noqa: E402
from imu_lib.gap.effects import COMPETITORS  # noqa: E402
from imu_lib.gap.effects.competitor import SLOPE_BESIDE_FILTER  # noqa: E402

SCORES = ("gap_score", "gap_score_free", "gap_score_pairs")
#: Names of the record, which nothing that is left on a channel speaks against, and what comes with
#: what was put in: who tilts a sensor touches it.
OF_RECORD = (
    "common_mode",
    "disturbance",
    "dropout",
    "jitter",
    "rate_error",
    "tilt",
    "time_gaps",
    "vibration",
)
SEEN_AS = {"disturbance": ("tilt",)}
#: Noises that are strongest near half the sampling rate, and the confidence at the most that they
#: had beside a filter when the tables were stored.
SLOPED, FORMER = ("autoregressive", "quantization"), 0.8
#: Names that compete with rivals.
RIVALS = {e.name for e in COMPETITORS}
#: Bounds of the bins of confidence.
BINS = (0.0, 0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 0.97, 0.995, 1.0 + 1e-9)


def findings(strict=True):
    """(effect, stored confidence, right, what is left unexplained beside it, table) of every
    finding; what is left are the kinds of `gap.left_beside`, none where nothing is, ("any",) where
    the kind is not stored.

    Where an effect was put into a recorded signal, a new name in place of one that is gone counts
    as wrong, though nobody knows which of the two was; without `strict` it is left out.
    """
    for name in SCORES:
        for case in json.loads((RESULTS / f"{name}.json").read_text())["cases"]:
            for s in case["steps"]:
                right = any(matches(s, t) or same_spectrum(s, t) for t in case["truths"])
                told = case["unexplained"].get(s["channel"])
                left = _kinds(s, told, case["steps"]) if told else ()
                sure = s["confidence"]
                if s["effect"] in RIVALS and not s.get("calibrated"):
                    sure = reliability.calibrated(sure)
                if s["effect"] in SLOPED and s["confidence"] == FORMER:  # beside a filter
                    sure = min(sure, SLOPE_BESIDE_FILTER)
                yield s["effect"], sure, right, left, name
    path = RESULTS / "gap_injected.json"
    for case in json.loads(path.read_text())["cases"] if path.exists() else ():
        told = set()
        for _, effect, sure, right, left, instead in case.get("fresh", ()):
            if instead and not strict:
                continue
            left = ("any",) if left else ()
            if effect in OF_RECORD:  # one finding, whatever channels it is on
                right = right or case["effect"] in SEEN_AS.get(effect, ())
                left = ()
                if effect in told:
                    continue
                told.add(effect)
            if effect in SLOPED and sure == FORMER:  # beside a filter
                sure = min(sure, SLOPE_BESIDE_FILTER)
            yield effect, sure, right, left, "gap_injected"


def _kinds(step, told, steps):
    """What is told to be left in a channel is to one of its steps."""
    lines = sum(s["channel"] == step["channel"] and s["effect"] == "sinusoid" for s in steps)
    return left_beside.kinds(step["effect"], step["parameters"], told, lines)


def beside_unexplained() -> dict:
    """(effect, kind of what is left) -> (findings beside it, right ones)."""
    found, right = Counter(), Counter()
    for effect, _, good, left, _ in findings():
        for kind in left:
            found[effect, kind] += 1
            right[effect, kind] += good
    return {e: (found[e], right[e]) for e in sorted(found)}


def as_told(sure, effect, left) -> float:
    """A confidence as the workflow tells it now beside what is left."""
    return min([sure, *(left_beside.share(effect, kind) for kind in left)])


def table(rows) -> list[dict]:
    """Share of right names by confidence."""
    sure, right = (np.array([r[k] for r in rows], float) for k in (0, 1))
    out = []
    for low, high in zip(BINS[:-1], BINS[1:]):
        part = (sure >= low) & (sure < high)
        if part.any():
            k, n = int(right[part].sum()), int(part.sum())
            out.append(
                {
                    "from": low,
                    "to": min(high, 1.0),
                    "findings": n,
                    "confidence": round(float(sure[part].mean()), 4),
                    "right": round(k / n, 4),
                    "interval": wilson(k, n),
                }
            )
    return out


def main():
    rows = {}
    for strict in (True, False):
        rows[strict] = [
            (as_told(sure, effect, left), right)
            for effect, sure, right, left, _ in findings(strict)
        ]
    found = {
        "command": "python benchmarks/gap_reliability.py",
        "date": date.today().isoformat(),
        "tables": [*SCORES, "gap_injected"],
        "table": table(rows[True]),
        "without_names_in_place_of_others": table(rows[False]),
        "beside_unexplained": {" ".join(k): v for k, v in beside_unexplained().items()},
    }
    (RESULTS / "gap_reliability.json").write_text(json.dumps(found, indent=1) + "\n")
    for line in [*found["table"], "", *found["without_names_in_place_of_others"]]:
        print(line)
    print(found["beside_unexplained"])


if __name__ == "__main__":
    main()
