"""What is wrong with the data, and what happened to the sensor, as a sentence."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from imu_lib.faults.rhythm import PASSED, WALKED
from imu_lib.faults.tilt import angle_in_words
from imu_lib.gap.fault_masking import BURSTS
from imu_lib.gap.knock_jumps import WITH

if TYPE_CHECKING:
    from imu_lib.gap.steps import Step

#: Effects that are the data's faults, and those of something that happened.
FAULTS = ("dropout", "held", "time_gaps", "jitter", "rate_error", "stuck", "spikes", "saturation")
LOST = ("dropout", "time_gaps")
TOUCHED = ("disturbance", "tilt")
JUMPS = ("step", "telegraph")
#: Confidence below which a name is not told at all (the table has it), and how many doubtful ones
#: are.
LEAST, DOUBTS = 0.1, 3
#: Effects of single moments, and how these end the sentence of where they are.
TIMED = ("spikes", "stuck", "saturation", "telegraph")
WHEN = re.compile(r", (?:the largest at|at|from) [\d., andto]+ s$")
#: m/s^2.
GRAVITY = 9.80665
#: Times and parts that are told.
TIMES, PARTS = 5, 5
#: Seconds within which jumps are one event.
APART = 2.0


def _amount(p: dict[str, Any], key: str) -> str:
    return f"{100 * p[key]:.2g} %"


def _or_tilted(found: list[tuple[str, Step]]) -> str:
    """What jumps of accelerometers may be as well, where the geometry allows it."""
    if not all("tilt" in s.indistinguishable for _, s in found):
        return ""
    change = np.linalg.norm([s.parameters["amplitude"] for _, s in found])
    return f" (or it was tilted by {1e3 * change / GRAVITY:.2g} mrad)"


#: Effect -> words from its parameters and " on CHANNEL".
WORDS: dict[str, Callable[[dict[str, Any], str], str]] = {
    "jitter": lambda p, on: f"the time stamps scatter by {1e3 * p['sd']:.2g} ms",
    "rate_error": lambda p, on: (
        f"the clock is off: the true rate is {p['ratio']:.5g} of the stated"
    ),
    "saturation": lambda p, on: f"samples are clipped{on}",
    "stuck": lambda p, on: f"{_amount(p, 'fraction')} of the samples are frozen{on}",
    "spikes": lambda p, on: f"single samples are thrown off{on}, {60 * p['rate']:.2g} a minute",
    "step": lambda p, on: (
        f"the level changed{on}"
        + (
            f" from {p['time']:.0f} to {p['time'] + p['duration']:.0f} s"
            if p.get("duration")
            else f" at {p['time']:.0f} s"
        )
    ),
    "telegraph": lambda p, on: (
        f"the level jumps to and fro between two values{on}, {60 * p['rate']:.2g} times a minute"
    ),
}


def _lost(s: Step) -> str:
    """Rows that are missing or drop-outs: the first clause of where they are."""
    if s.evidence == BURSTS or s.effect == "dropout" and ": drop-outs" in s.where:
        text = s.where.partition(". ")[0].partition(": drop-outs")[0]
        text = text[:1].lower() + text[1:]
        return text.rstrip(".") if s.evidence == BURSTS else f"drop-outs: {text}"
    if s.where.endswith("frozen output."):
        return s.where.partition(", up to ")[0] + ": frozen output"
    what = "samples are missing" if s.effect == "time_gaps" else "rows are drop-outs"
    return f"{_amount(s.parameters, 'fraction')} of the {what}"


def sentence(
    steps: list[tuple[str, Step]],
    sure: float,
    left_out: Sequence[str] = (),
    *,
    named: bool = False,
) -> str:
    """The sentence about `steps`, (channel or "record", step) of everything found; what is less
    than `sure` is in doubt; `left_out` are sentences on channels that tell nothing. `named`: other
    sentences tell of findings, so that it is not said that nothing is wrong.
    """
    parts, doubtful = [text.rstrip(".") for text in left_out], []
    jumps, rest = _jumps(steps, sure)
    parts += jumps
    for where, s in rest:
        on = "" if where == "record" else f" on {where}"
        words = WORDS.get(s.effect)
        plain = f"{s.effect.replace('_', ' ')}{on}"
        if s.effect in LOST:
            parts.append(_lost(s))
        elif s.confidence >= sure or where == "record" and s.effect != "rate_error":
            parts.append(plain if words is None else words(s.parameters, on) + _when(s))
        elif s.confidence >= LEAST:
            doubtful.append(plain + _otherwise(s))
    parts += _touched([s for _, s in steps if s.effect in TOUCHED])
    parts = list(dict.fromkeys(parts))
    if len(parts) > PARTS:
        parts = [*parts[:PARTS], f"and {len(parts) - PARTS} more of the kind in the table"]
    doubtful = list(dict.fromkeys(doubtful))
    if len(doubtful) > DOUBTS:
        doubtful = [*doubtful[:DOUBTS], f"{len(doubtful) - DOUBTS} more in the table"]
    if doubtful:
        parts.append(f"in doubt: {', '.join(doubtful)}")
    if not parts:
        sound = "no drop-outs, no frozen or clipped samples"
        if not named:
            return f"Nothing is wrong with the data themselves: {sound}, nobody touched it."
        still = "" if any(_may_have_moved(s) for _, s in steps) else "; nobody touched it"
        return f"{sound[:1].upper()}{sound[1:]}{still}."
    text = "; ".join(parts)
    return f"{text[:1].upper()}{text[1:]}."


def _when(s: Step) -> str:
    """When samples were thrown off, frozen or clipped, or two levels took turns, in words."""
    told = WHEN.search(s.where)
    return told[0] if told and s.effect in TIMED else ""


def _otherwise(s: Step) -> str:
    """What two levels may be as well, with the times of their flips."""
    if s.effect not in JUMPS or "step" not in s.indistinguishable:
        return ""
    return f" (or so many steps{_when(s)})"


def _may_have_moved(s: Step) -> bool:
    """Whether a tilt is another name of a step."""
    return "tilt" in s.indistinguishable


def _jumps(steps: list[tuple[str, Step]], sure: float) -> tuple[list[str], list[tuple[str, Step]]]:
    """Sentences about sure jumps, those of one moment as one, and the other faults and jumps."""
    named = [(w, s) for w, s in steps if s.effect in (*FAULTS, *JUMPS)]
    at: dict[float, list[tuple[str, Step]]] = {}
    for where, s in named:
        if s.effect == "step" and s.confidence >= sure and not s.parameters.get("duration"):
            moment = next((t for t in at if abs(t - s.parameters["time"]) < APART), None)
            at.setdefault(s.parameters["time"] if moment is None else moment, []).append((where, s))
    parts = []
    for time, found in at.items():
        on = [where for where, _ in found]
        listed = on[0] if len(on) == 1 else f"{', '.join(on[:-1])} and {on[-1]}"
        knocked = " with the knock there" if all(WITH in s.where for _, s in found) else ""
        parts.append(f"the level jumped on {listed} at {time:.0f} s{knocked}{_or_tilted(found)}")
    told = [s for found in at.values() for _, s in found]
    return parts, [(w, s) for w, s in named if not any(s is t for t in told)]


def _touched(steps: list[Step]) -> list[str]:
    """When it was touched, and when and by how much it was tilted."""
    parts = []
    tilts = sorted((s for s in steps if s.effect == "tilt"), key=lambda s: s.parameters["time"])
    shakes = [s for s in steps if s.effect == "disturbance"]
    for how, who in ((WALKED, "somebody walked by"), (PASSED, "something that passed shook it")):
        some = [s.parameters for s in shakes if how in s.where]
        shakes = [s for s in shakes if how not in s.where]
        when = [f"from {p['start']:.0f} to {p['start'] + p['duration']:.0f} s" for p in some]
        if when:
            parts.append(f"{who} {', '.join(when[:TIMES])}")
    knocks = sorted(s.parameters["start"] for s in shakes)
    if knocks:
        parts.append(f"it was touched or shaken at {_times(knocks)} s")
    parts += [
        text.format(at=_times([s.parameters["time"] for s in some]), by=_sizes(some))
        for text, some in (
            (
                "it was moved at {at} s (tilted by {by})",
                [s for s in tilts if not s.indistinguishable],
            ),
            (
                "it may have been moved at {at} s (tilted by {by}, or these levels jumped)",
                [s for s in tilts if s.indistinguishable],
            ),
        )
        if some
    ]
    return parts


def _sizes(tilts: list[Step]) -> str:
    """The angles of tilts in words."""
    sizes = [float(np.linalg.norm(s.parameters["angles"])) for s in tilts]
    least, most = angle_in_words(min(sizes)), angle_in_words(max(sizes))
    return least if least == most else f"{least} to {most}"


def _times(at: list[float]) -> str:
    shown = ", ".join(f"{t:.0f}" for t in at[:TIMES])
    return shown + (f" and {len(at) - TIMES} more times" if len(at) > TIMES else "")
