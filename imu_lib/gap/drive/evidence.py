"""What is said of steps that do not help, or that the drive cannot tell apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

Step = dict[str, Any]

EVEN = 0.5  # two names that the drive cannot tell
WIDER = 0.05  # of the gap index: what its one printed decimal shows


def share(found: Sequence[Step], ridges: Mapping[tuple[str, str], str]) -> list[str]:
    """Name the two ends of a ridge in each other's steps; what is said of them."""
    out: list[str] = []
    for step in found:
        for (effect, rival), axis in ridges.items():
            if effect != step["effect"]:
                continue
            if rival not in step["indistinguishable"]:
                step["indistinguishable"].append(rival)
            step["confidence"] = min(step["confidence"], EVEN)
            said = (
                f"{' and '.join(sorted((effect, rival)))} {axis} cannot be told apart on this "
                "drive: free, the two would take values that sensors do not have and that make up "
                "for each other; one stands for what they do together."
            )
            out += [said] if said not in out else []
    return out


def widening(found: Sequence[Step]) -> list[str]:
    """What is said of steps that are kept although the gap index widens with them, in a list."""
    wide = [s for s in found if s["gap_after"] > s["gap_before"] + WIDER]
    if not wide:
        return []
    told = ", ".join(f"{s['effect']} ({s['gap_before']:.1f} to {s['gap_after']:.1f})" for s in wide)
    return [
        f"The gap index widens with {told}: kept because the likelihood of the innovations grows, "
        "which decides; the index also counts what such an effect had hidden, and what is left is "
        "no better known."
    ]


def unproven(found: Sequence[Step], ratio: Mapping[str, float]) -> list[str]:
    """What is said where withheld outages do not show that the effects found help, in a list."""
    if not found or not ratio["low"] <= 1.0 <= ratio["high"]:
        return []
    return [
        "What was found makes the innovations righter; that it makes withheld outages better is "
        f"not proven: their errors are {ratio['value']:.2g} times those before "
        f"[{ratio['low']:.2g}, {ratio['high']:.2g}]."
    ]
