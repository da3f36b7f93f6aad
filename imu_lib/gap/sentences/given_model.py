"""What a given model holds, told beside what was found: an event of another day that this record
does not have comes back as its opposite, and what the record does have is no finding.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from imu_lib import words
from imu_lib.gap.absent import Absent
from imu_lib.gap.steps import Step
from imu_lib.processes import Process, Vibration

if TYPE_CHECKING:
    from imu_lib.gap.found import Report

#: Nearness to the opposite of what is given: of the amplitudes, as a share; of the times, in shares
#: of the record.
ALIKE, NEAR = 0.25, 0.02
#: What is no cause of its own: noises and electronics, which the sensor's sentence tells.
OF_SENSOR = (
    "constant", "white_noise", "quantization", "flicker", "random_walk", "gauss_markov",
    "gauss_markov_2", "autoregressive", "low_pass", "resolution", "common_mode",
)  # fmt: skip


def absent(found: Report) -> list[tuple[str, Step]]:
    """(channel, step) of what was found and only takes back what the given model holds."""
    if not found.given:
        return []
    return [
        (name, s)
        for name, c in found.channels.items()
        for s in c.result.steps
        if any(_takes_back(s, t, found.record.duration) for t in c.result.base.terms)
    ]


def _takes_back(step: Step, term: Any, duration: float) -> bool:
    amplitude = getattr(term, "amplitude", None)
    if term.name != step.effect or not term.deterministic or not amplitude:
        return False
    p = step.parameters
    change = p.get("amplitude", 0.0) / amplitude
    if "frequency" in p:  # its phase says that it is the opposite
        turn = np.cos(p.get("phase", 0.0) - (getattr(term, "phase", None) or 0.0))
        return (
            turn < 0
            and abs(change - 1) < ALIKE
            and abs(p["frequency"] - term.frequency) * duration < 2
        )
    apart = abs(p["time"] - term.time) if "time" in p else 0.0
    return abs(change + 1) < ALIKE and apart < NEAR * duration


def sentence(found: Report, gone: list[tuple[str, Step]]) -> str:
    """The sentence on what the given model holds: what this record has not, and what it has."""
    if not found.given:
        return ""
    taken = {(name, s.effect) for name, s in gone}
    taken |= {(name, a.process.name) for a in found.absent if a.term for name in a.channels}
    lacks = [f"{_words(s.effect)} on {name}" for name, s in gone]
    lacks += [_lacking(a) for a in found.absent]
    holds = [
        f"{_words(t.name)} on {name}"
        for name, c in found.channels.items()
        for t in (*c.result.base.terms, *c.result.base.stages)
        if t.name not in OF_SENSOR and (name, t.name) not in taken
    ]
    holds += [_words(p.name) for p in _seen(found) if p.name not in OF_SENSOR]
    parts = []
    if lacks:
        parts.append(f"the record does not have the given model's {', '.join(lacks)}")
    if holds:
        parts.append(f"the given model already holds {', '.join(dict.fromkeys(holds))}")
    text = "; ".join(parts)
    return f"{text[:1].upper()}{text[1:]}." if text else ""


def _lacking(a: Absent) -> str:
    on = f" on {words.names(a.channels)}" if a.channels else ""
    return f"{_words(a.process.name)}{on} ({a.why})"


def _seen(found: Report) -> list[Process]:
    """What the given model has on the record, without what is absent and without vibrations that
    are too weak to be told there.
    """
    untold = [a.process for a in found.absent]
    untold += [p for p in found.model.record if isinstance(p, Vibration)]
    return [p for p in found.base.record if p not in untold]


def _words(name: str) -> str:
    return name.replace("_", " ")
