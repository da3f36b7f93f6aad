"""Axes of one sensor that state units of their own: each is read in its own."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from imu_lib.readers import names
from imu_lib.readers.meaning import WORD
from imu_lib.readers.raw import Raw
from imu_lib.readers.streams import PAIR


def one_each(raw: Raw, flags: Mapping[str, str | None]) -> None:
    """Bring axes that state different units, all of them known, to one, with a word, where their
    noise is more alike in these units than in one: otherwise the headings contradict each other,
    which is refused. What the call says of a sensor's unit goes for all of its axes.
    """
    for kind, families in PAIR.items():
        for family in families:
            there = raw.axes(family)
            said = {c: raw.units[c] for c in there}
            known = names.UNITS[family]
            if (
                flags.get(kind)
                or len(set(said.values())) < 2
                or not set(said.values()) <= set(known)
            ):
                continue
            factors = [known[said[c]] for c in there]
            noise = [_noise(raw.columns[c]) for c in there]
            if _spread([n * f for n, f in zip(noise, factors)]) >= _spread(noise):
                continue
            first = said[there[0]]
            for c in there[1:]:
                factor = known[said[c]] / known[first]
                raw.columns[c] = np.asarray(raw.columns[c], dtype=float) * factor
                raw.units[c] = first
            each = ", ".join(f"`{raw.headings[c]}` {said[c]}" for c in there)
            word = WORD[kind]
            raw.notes += (
                f"The axes of the {word} state different units ({each}); each was read in its own.",
            )


def _noise(x) -> float:
    """Mean size of the steps from sample to sample."""
    step = np.abs(np.diff(np.asarray(x, dtype=float)))
    step = step[np.isfinite(step)]
    return float(step.mean()) if step.size else 0.0


def _spread(noise: list[float]) -> float:
    """The largest over the least."""
    return max(noise) / min(noise) if min(noise) > 0 else float("inf")
