"""What counts as named, listed, wrong or false in the score of the gap workflow, and its table."""

from __future__ import annotations

import gap_final
import numpy as np
from statsmodels.stats.proportion import proportion_confint

SURE = 0.9
#: Noises of which two are one of another strength.
SAME = ("flicker", "random_walk", "quantization", "white_noise")
#: Parameters that describe an effect and are not estimated.
DESCRIBES = ("process", "name", "from", "reference", "channels", "taps", "order", "phi")


def matches(step, truth):
    """Whether a step names a truth: the effect in its channel, for a changed parameter also
    which.
    """
    if step["effect"] != truth["effect"] or step["channel"] != truth["channel"]:
        return False
    p = truth.get("parameters", {})
    return truth["effect"] != "parameter_change" or (
        step["parameters"]["process"],
        step["parameters"]["name"],
    ) == (p["process"], p["name"])


def same_spectrum(step, truth):
    """Names for the same thing: a further noise of a family that the base already has is a changed
    parameter.
    """
    if step["channel"] != truth["channel"]:
        return False
    a, b = (step["parameters"].get("process") or step["effect"]), truth["effect"]
    return step["effect"] == "parameter_change" and a == b and b in SAME


def _lists(step, truth):
    """Whether a step of its channel lists a truth: by name, or as the change of the parameter that
    has the same spectrum.
    """
    changed = {(p["process"], p["name"]) for p in step.get("changes", ())}
    if truth["effect"] == "parameter_change" and changed:
        return (truth["parameters"]["process"], truth["parameters"]["name"]) in changed
    alike = truth["effect"] in SAME and truth["effect"] in {process for process, _ in changed}
    return alike or truth["effect"] in step["indistinguishable"]


def judge(r):
    """named (all detectable truths named), listed (named or given as a name that the record cannot
    tell apart), wrong (a name that is not there, with high confidence), false (anything found or
    left unexplained where nothing was hidden), said (an unknown effect answered with
    `unexplained`)."""
    swallowed = {(c, e) for c, names in r.get("absorbed", {}).items() for e in names}
    known = [t for t in r["truths"] if t["effect"] != "unknown" and t["gain"] >= 20]
    # what a free base says that it may have absorbed counts as detectable only where it was named
    # all the same
    known = [
        t
        for t in known
        if (t["channel"], t["effect"]) not in swallowed or any(matches(s, t) for s in r["steps"])
    ]
    weak = [t for t in r["truths"] if t["effect"] != "unknown" and t["gain"] < 20]
    unknown = [t for t in r["truths"] if t["effect"] == "unknown"]
    fits = lambda s, t: matches(s, t) or same_spectrum(s, t)  # noqa: E731
    named = [any(fits(s, t) for s in r["steps"]) for t in known]
    listed = [
        any(fits(s, t) or s["channel"] == t["channel"] and _lists(s, t) for s in r["steps"])
        for t in known
    ]
    extra = [s for s in r["steps"] if not any(fits(s, t) for t in r["truths"])]
    touched = {t["channel"] for t in r["truths"]} | {
        c for t in r["truths"] for c in t.get("parameters", {}).get("channels", [])
    }
    clean = [c for c in r["channels"] if c not in touched]
    false = [
        c for c in clean if any(s["channel"] == c for s in r["steps"]) or r["unexplained"].get(c)
    ]
    return {
        "detectable": len(known),
        "named": int(sum(named)),
        "listed": int(sum(listed)),
        "weak": len(weak),
        "wrong": [s["effect"] for s in extra if s["confidence"] >= SURE],
        "extra": [s["effect"] for s in extra],
        "clean": len(clean),
        "false": len(false),
        "said": bool(unknown)
        and any(
            r["unexplained"].get(t["channel"]) or r["unexplained"].get("record") for t in unknown
        ),
    }


def wilson(k, n):
    """95 % interval of a share (Wilson's); [0, 1] where nothing was counted."""
    low, high = proportion_confint(k, n, method="wilson") if n else (0.0, 1.0)
    return [round(float(low), 4), round(float(high), 4)]


def covered(results):
    """For each parameter kind: (within 10 % or interval covering, interval covering, count) over
    the truths named right.
    """
    ok, cover, count = 0, 0, 0
    for r in results:
        for t in r["truths"]:
            s = next((s for s in r["steps"] if matches(s, t)), None)
            if s is None:
                continue
            for name, value in t["parameters"].items():
                if (
                    name in DESCRIBES
                    or name == "rate"
                    and t["effect"] not in ("telegraph", "spikes")
                ):
                    continue
                got = s["parameters"].get(name)
                if got is None or isinstance(value, str):
                    continue
                low, high = s["intervals"].get(name, [np.nan, np.nan])
                inside = bool(low is not None and low <= value <= high)
                count += 1
                cover += inside
                ok += inside or abs(got / value - 1) <= 0.1
    return ok, cover, count


def table(results):
    """Rates by kind."""
    rows = []
    for kind in dict.fromkeys(r["kind"] for r in results):
        part = [r for r in results if r["kind"] == kind]
        judged = (
            [r for r in part if r["detectable"] and not r["weak"]]
            if kind == "pair"
            else [r for r in part if r["detectable"]]
        )
        named = sum(r["named"] == r["detectable"] for r in judged)
        ok, cover, count = covered(part)
        clean, false = sum(r["clean"] for r in part), sum(r["false"] for r in part)
        unknown = [r for r in part if any(t["effect"] == "unknown" for t in r["truths"])]
        rows.append(
            {
                "kind": kind,
                "cases": len(part),
                "detectable": len(judged),
                "named": named,
                "listed": sum(r["listed"] == r["detectable"] for r in judged),
                "named_interval": wilson(named, len(judged)),
                "wrong": sum(bool(r["wrong"]) for r in part),
                "missed": sum(r["named"] < r["detectable"] and not r["extra"] for r in judged),
                "clean_channels": clean,
                "false": false,
                "unexplained": sum(r["said"] for r in unknown),
                "unknown": len(unknown),
                "parameters": count,
                "within": ok,
                "covering": cover,
                "seconds": round(float(np.median([r["seconds"] for r in part])), 2),
                **gap_final.row(part),
            }
        )
    return rows


def _of(row, name):
    return f"{row[name]}/{row['final']}" if "final" in row else ""


def show(rows):
    print(
        f"{'kind':<20}{'cases':>6}{'detect.':>8}{'named':>7}{'listed':>7}{'95 %':>16}{'wrong':>7}{'false':>9}{'unexpl.':>9}"
        f"{'param ok':>10}{'cover':>8}{'s':>7}   final model: "
        f"{'kinds':>8}{'spectrum':>10}{'covering':>10}"
    )
    for r in rows:
        print(
            f"{r['kind']:<20}{r['cases']:>6}{r['detectable']:>8}{r['named']:>7}{r['listed']:>7}{str(r['named_interval']):>16}{r['wrong']:>7}"
            f"{str(r['false']) + '/' + str(r['clean_channels']):>9}{str(r['unexplained']) + '/' + str(r['unknown']):>9}"
            f"{str(r['within']) + '/' + str(r['parameters']):>10}{r['covering']:>8}{r['seconds']:>7}"
            f"{'':>16}{_of(r, 'final_kinds'):>8}{_of(r, 'final_spectrum'):>10}"
            f"{'/'.join(map(str, r.get('final_parameters', []))):>10}"
        )
