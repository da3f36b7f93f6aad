"""How sure a name is beside something that is left without one: as often as such names were right
in the blind scores, by what is left. Power that is left at a line speaks against the line; of
samples that are thrown off it says nothing.
"""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from imu_lib.gap.effects import SPECTRAL
from imu_lib.gap.effects.parameter_change import ParameterChange

if TYPE_CHECKING:
    from imu_lib.gap.channel import ChannelResult

#: What is left, by how its sentence begins; all else is of the spectrum.
SAMPLES, LEVEL = ("distribution of",), ("variance of the innovations", "spectrum between")
BAND = re.compile(r"between ([\d.e+-]+) and ([\d.e+-]+) Hz")
#: Lines of a channel from which on they are what something else draws, and the share of its
#: frequency within which what is left is of a line's own make.
MANY, NEAR = 4, 0.1
#: Findings of an effect beside what was left of a kind in the blind scores, and those of them that
#: were right; "any" are those put into recorded signals, of which the kind is not stored. Counted
#: from benchmarks/results by gap_reliability; tests/test_gap_confidence.py counts again.
COUNTED: dict[tuple[str, str], tuple[int, int]] = {
    ("autoregressive", "level"): (51, 0),
    ("autoregressive", "samples"): (1, 0),
    ("autoregressive", "spectrum"): (61, 0),
    ("gauss_markov", "any"): (1, 0),
    ("gauss_markov_2", "any"): (1, 0),
    ("gauss_markov_2", "level"): (1, 0),
    ("gauss_markov_2", "samples"): (2, 0),
    ("gauss_markov_2", "spectrum"): (41, 0),
    ("heavy_tails", "any"): (1, 0),
    ("low_pass", "any"): (1, 1),
    ("low_pass", "level"): (5, 1),
    ("low_pass", "samples"): (1, 1),
    ("low_pass", "spectrum"): (3, 2),
    ("noise_level_change", "any"): (1, 0),
    ("noise_level_change", "level"): (6, 0),
    ("noise_level_change", "samples"): (2, 0),
    ("noise_level_change", "spectrum"): (3, 1),
    ("parameter_change", "level"): (64, 0),
    ("parameter_change", "samples"): (76, 0),
    ("parameter_change", "spectrum"): (14, 0),
    ("quantization", "any"): (1, 0),
    ("quantization", "level"): (16, 0),
    ("quantization", "samples"): (3, 0),
    ("quantization", "spectrum"): (13, 1),
    ("ramp", "any"): (1, 1),
    ("resolution", "samples"): (59, 1),
    ("resolution", "spectrum"): (1, 0),
    ("saturation", "samples"): (3, 0),
    ("sinusoid", "any"): (1, 0),
    ("sinusoid", "line"): (420, 0),
    ("spikes", "any"): (1, 1),
    ("spikes", "samples"): (121, 1),
    ("step", "any"): (1, 1),
    ("stuck", "any"): (1, 0),
    ("stuck", "samples"): (21, 0),
    ("temperature", "any"): (2, 2),
    ("wandering_level", "any"): (2, 2),
    ("warm_up", "any"): (2, 2),
    ("warm_up", "level"): (1, 0),
}
#: Effects that may stand for noise which channels have in common.
NOISES = (*(e.name for e in SPECTRAL), ParameterChange.name)
#: Findings below which a share is no more than even.
FEW = 5


def kinds(effect: str, parameters: dict[str, Any], sentence: str, lines: int) -> tuple[str, ...]:
    """What the clauses of a `sentence` on what is left are to a finding, one of `lines` lines in
    its channel where it is one: "samples", "level", "spectrum", or "line" where it is of the line's
    own make.
    """
    return tuple(
        dict.fromkeys(_kind(effect, parameters, text, lines) for text in sentence.split("; "))
    )


def _kind(effect: str, parameters: dict[str, Any], text: str, lines: int) -> str:
    if text.startswith(SAMPLES):
        return "samples"
    if effect == "sinusoid" and (lines >= MANY or _at(parameters.get("frequency", 0.0), text)):
        return "line"
    return "level" if text.startswith(LEVEL) else "spectrum"


def _at(frequency: float, text: str) -> bool:
    """Whether what is left is beside a line."""
    band = BAND.search(text)
    if band is None:
        return f"beside {frequency:.5g} Hz" in text
    low, high = float(band[1]), float(band[2])
    return low * (1.0 - NEAR) <= frequency <= high * (1.0 + NEAR)


def most_sure(effect: str, parameters: dict[str, Any], sentence: str, lines: int = 1) -> float:
    """Share of right names among findings of that effect beside what the `sentence` tells."""
    return min(share(effect, kind) for kind in kinds(effect, parameters, sentence, lines))


def on_record(results: dict[str, ChannelResult], left: str | None) -> dict[str, ChannelResult]:
    """Results by channel in which a noise is no surer than beside what is `left` on the record
    where that is of its channel, too.
    """
    if not left:
        return results
    out = dict(results)
    for name, result in results.items():
        if name in left:
            steps = [
                s.capped(most_sure(s.effect, s.parameters, left)) if s.effect in NOISES else s
                for s in result.steps
            ]
            out[name] = replace(result, steps=steps)
    return out


def share(effect: str, kind: str) -> float:
    """Laplace's rule of succession, no more than even where few were counted. A noise starts from
    what noises of its name came to beside anything: others draw the same smooth spectrum.
    """
    counts = [COUNTED.get((effect, of), (0, 0)) for of in (kind, "any")]
    found, right = (sum(n) for n in zip(*counts))
    prior = 0.5
    if effect in NOISES:
        every = [n for (name, _), n in COUNTED.items() if name == effect]
        prior = (sum(k for _, k in every) + 1) / (sum(n for n, _ in every) + 2)
    value = (right + 2 * prior) / (found + 2)
    return value if found >= FEW else min(value, 0.5)
