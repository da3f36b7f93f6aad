"""Whether the findings on a case are what was put in, at its time, and nothing else."""

from __future__ import annotations

import numpy as np
from fault_generator import CHANNELS

#: What is told but no fault: it may be there or not.
TOLD = ("time_grid", "jitter", "warm_up", "rate", "burst", "gap")
#: What a fault may bring with it: a touch that tilted, a tilt that was felt, copies of long runs.
ALSO = {
    "disturbance": ("tilt",),
    "tilt": ("disturbance",),
    "restart": (),
    "held": (),
    "dropout": (),
    "stuck": (),
}


def judge(case, findings):
    """(found, kinds found that are not there) of a case; found is None for a sound one."""
    truth = case.truth
    kind = truth.get("finding")
    own = [f for f in findings if f.kind == kind]
    wrong = [
        f.kind
        for f in findings
        if f.kind != kind and f.kind not in TOLD and f.kind not in ALSO.get(kind, ())
    ]
    if kind is None:
        return None, wrong
    check = {
        "dropout": _rows,
        "stuck": _rows,
        "held": _rate,
        "rate": _rate,
        "burst": _burst,
        "time_grid": _step,
    }.get(kind, _events)
    return bool(check(case, truth, own)), wrong


def _rows(case, truth, own):
    """Four of five rows, on the channels, and few others."""
    got = np.zeros((len(CHANNELS), len(case.x)), bool)
    for f in own:
        for c in f.channels:
            got[CHANNELS.index(c), f.rows] = True
    want = np.zeros_like(got)
    want[np.ix_(truth["channels"], truth["rows"])] = True
    return (got & want).sum() >= 0.8 * (got | want).sum()


def _rate(case, truth, own):
    if "channels" in truth:
        members = {CHANNELS[c] for c in truth["channels"]}
        own = [f for f in own if set(f.channels) == members]
    return any(abs(f.parameters["rate"] / truth["rate"] - 1) < 0.03 for f in own)


def _burst(case, truth, own):
    return any(
        abs(f.parameters["rate"] / truth["rate"] - 1) < 0.03
        and f.parameters["size"] == truth["size"]
        for f in own
    )


def _step(case, truth, own):
    return any(abs(f.parameters["step"] / truth["step"] - 1) < 1e-6 for f in own)


def _events(case, truth, own):
    """Every event at its time, and no other of the kind."""
    left = list(own)
    for event in truth["events"]:
        slack = max(1.0, 4 / case.rate, 0.5 * event["duration"])
        low, high = event["time"] - slack, event["time"] + event["duration"] + slack
        near = [f for f in left if low <= f.start <= high or f.start <= low and f.stop >= low]
        if not near:
            return False
        left = [f for f in left if f not in near]
        if "angle" in truth and not any(_turned(f, truth["angle"]) for f in near):
            return False
    return not [f for f in left if f.kind not in ("gap",)]


def _turned(finding, angle):
    """By that angle within 30 %; about the vertical only the gyros see."""
    return abs(np.linalg.norm(finding.parameters["angles"]) / angle - 1) < 0.3
