"""What the surroundings did to a record, as a sentence."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from imu_lib import words
from imu_lib.gap.effects.wandering_level import in_short
from imu_lib.gap.sentences import signals
from imu_lib.vibrations.entries import FOREST
from imu_lib.vibrations.mains import hint, of_mains

if TYPE_CHECKING:
    from imu_lib.gap.found import Report
    from imu_lib.gap.steps import Step

#: Confidence from which on a finding is told as one.
SURE = 0.9


def settled(steps: list[tuple[str, Step]], names: Iterable[str]) -> list[tuple[str, Step]]:
    """(channel or "record", step) of the effects of these names that are sure or the record's."""
    return [
        (where, s)
        for where, s in steps
        if s.effect in names and (s.confidence >= SURE or where == "record")
    ]


def environment(found: Report, seen: list[tuple[str, Step]], more: str) -> str:
    """What shook the sensor, warmed it and moved its noise; `more` where others tell of it, too."""
    parts = []
    shaken: dict[Any, list[Step]] = {}
    for _, step in sorted(settled(seen, ("vibration",)), key=lambda item: -(item[1].gain or 0.0)):
        p = step.parameters
        shaken.setdefault((p["frequency"], tuple(p["channels"])), []).append(step)
    rate = found.record.rate
    parts += [_shook(episodes, rate) for episodes in list(shaken.values())[:3]]
    if len(shaken) > 3:
        parts.append(f"{len(shaken) - 3} weaker vibrations beside")
    for effect, text in (
        ("temperature", "the temperature moves {}"),
        ("warm_up", "{} warmed up"),
    ):
        on = [w for w, _ in settled(seen, (effect,))]
        if on:
            parts.append(text.format(words.channels(on)))
    louder: dict[str, list[str]] = {}
    for where, step in settled(seen, ("noise_level_change", "wandering_level")):
        louder.setdefault(_louder(step), []).append(where)
    parts += [f"{text} on {words.channels(on)}" for text, on in louder.items()]
    if not parts:
        if signals.relevant(found.steps):
            return ""
        return f"Of the environment it shows nothing{more}."
    return f"Of the environment: {'; '.join(parts)}."


def _louder(step: Step) -> str:
    """What the noise level does."""
    p = step.parameters
    if "time" in p and not p.get("duration"):
        return f"the noise changed its level at {p['time']:.0f} s"
    return in_short(step.where)


def _shook(steps: list[Step], rate: float) -> str:
    """One vibration, with all the times at which it was there, in a record at `rate` Hz."""
    episodes = [s.parameters for s in steps]
    p, how = episodes[0], steps[0].evidence
    what = f"at {p['frequency']:.4g} Hz"
    half = p["bandwidth"] / 2
    if p.get("lines") and len(p["lines"]) > FOREST:
        low, high = min(p["lines"]), max(p["lines"])
        return (
            f"a forest of lines from {low:.2g} to {high:.3g} Hz, products of clocks, is on "
            f"{words.channels(p['channels'])}"
        )
    if p["harmonics"] > 1:
        what += f" ({lines_of(p)} lines)"
    elif p["bandwidth"] > 0.1 * p["frequency"]:
        what = f"at {p['frequency'] - half:.3g} to {p['frequency'] + half:.3g} Hz"
    if hums(p):
        return f"the hum of the mains, {what}, is on {words.channels(p['channels'])}"
    times = sorted((e["from"], e["to"]) for e in episodes if e.get("from") is not None)
    when = words.listed([f"from {a:.0f} to {b:.0f} s" for a, b in times]) if times else ""
    where = f"{' ' + when if when else ''} on {words.channels(p['channels'])}"
    steady = not times and not p.get("lines") and p["bandwidth"] <= 0.01 * p["frequency"]
    how = "; ".join(filter(None, (how, hint(p["frequency"], rate) if steady else "")))
    if coupled(p):
        return f"a line {what}{where} couples into the electronics{', ' + how if how else ''}"
    return f"it shook {what}{where}{', ' + how if how else ''}"


def lines_of(p: dict[str, Any]) -> int:
    """Number of lines that a vibration has: not all multiples need be there."""
    return sum(r > 0 for r in p.get("ratios") or ()) or int(p["harmonics"])


def coupled(p: dict[str, Any]) -> bool:
    """Whether a steady line at the frequency of the mains is on gyros alone, or accelerometers
    alone: what shakes shakes both.
    """
    if p.get("from") is not None or p.get("lines") or p["bandwidth"] > 0.01 * p["frequency"]:
        return False
    one_kind = len({c[0] for c in p["channels"]}) == 1
    return hums(p) or one_kind and of_mains(p["frequency"], 2)


def hums(p: dict[str, Any]) -> bool:
    """Whether a vibration is the hum of the mains."""
    return not p.get("lines") and of_mains(p["frequency"], p["harmonics"])
