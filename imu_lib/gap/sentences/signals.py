"""What was found in the signals and is told nowhere else in the verdict, as a sentence."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

from imu_lib.gap.sentences.data_faults import FAULTS, JUMPS, TOUCHED
from imu_lib.gap.sentences.parameters import describe

if TYPE_CHECKING:
    from imu_lib.gap.steps import Step

#: Confidence from which on a finding has its place in the verdict.
LEAST = 0.5
#: Findings of one effect that are told one by one.
SHOWN = 3
#: What an effect is to the reader; the others go by their name.
MEANING = {
    "ramp": "a ramp (the mean drifts)",
    "warm_up": "a warm-up",
    "gauss_markov": "a Gauss-Markov process",
    "gauss_markov_2": "a Gauss-Markov process of second order",
    "random_walk": "a random walk",
    "parameter_change": "a parameter change",
    "autoregressive": "autoregressive noise",
    "common_mode": "noise in common",
}
#: Effects of the environment, told with it where they are sure.
SURROUNDINGS = ("vibration", "temperature", "warm_up", "wandering_level", "noise_level_change")


#: Change of the standard deviation of the sum of its channels from which on noise in common has its
#: place in the verdict.
MOVED = 0.05


def relevant(steps: list[tuple[str, Step]]) -> list[tuple[str, Step]]:
    """(channel or "record", step) of `steps` that a verdict has to tell."""
    return [(w, s) for w, s in steps if s.confidence >= LEAST and not _faint(s)]


def _faint(step: Step) -> bool:
    """Whether it is noise in common that moves the sum of its channels by next to nothing: of k
    channels that share `share` of their power its variance grows by (k - 1) times that.
    """
    p = step.parameters
    share = p.get("share")
    return share is not None and (len(p["channels"]) - 1) * share < (1 + MOVED) ** 2 - 1


def sentence(
    steps: list[tuple[str, Step]], sure: float, of_sensor: Collection[tuple[str, str]] = ()
) -> str:
    """The sentence about what is told nowhere else; `of_sensor` are the (channel, effect) that the
    sensor's own sentence has; what is less than `sure` is told as likely.
    """
    by_effect: dict[tuple[str, bool], list[tuple[str, Step]]] = {}
    for where, s in relevant(steps):
        settled = s.confidence >= sure or where == "record"
        elsewhere = s.effect in (*FAULTS, *JUMPS, *TOUCHED) or (where, s.effect) in of_sensor
        if elsewhere or (s.effect in SURROUNDINGS and settled):
            continue
        by_effect.setdefault((s.effect, settled), []).append((where, s))
    parts = [_effect(effect, found, settled) for (effect, settled), found in by_effect.items()]
    return f"In the signals: {'; '.join(parts)}." if parts else ""


def _effect(effect: str, found: list[tuple[str, Step]], settled: bool) -> str:
    name = MEANING.get(effect, effect.replace("_", " "))
    seen = [_seen(where, s) for where, s in found[:SHOWN]]
    if len(found) > SHOWN:
        seen.append(f"on {len(found) - SHOWN} more of the kind")
    rivals = [n.replace("_", " ") for _, s in found for n in s.indistinguishable]
    text = f"{'' if settled else 'likely '}{name} {', '.join(seen)}"
    if not settled and rivals:
        text += f", or {' or '.join(dict.fromkeys(rivals))}"
    return text


def _seen(where: str, s: Step) -> str:
    """Place and parameters."""
    parameters = " ".join(describe(s, where).split()).removeprefix(s.effect).strip()
    place = "" if where == "record" else f"on {where} "
    return f"{place}({parameters})"
