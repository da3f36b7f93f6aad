"""Slips of the pen in long words of a heading: Timpstemp, Acelerometer, gyroscoope."""

from __future__ import annotations

import re

#: Words long enough that another one is hardly meant where two letters differ.
WORDS = (
    "timestamp", "accelerometer", "acceleration", "gyroscope", "temperature", "angularvelocity", "angular", "velocity", "seconds",
    "milliseconds", "microseconds", "nanoseconds",
)  # fmt: skip


def misspelled(key: str) -> str | None:
    """A key (words set apart by `_`) with its misspelled words put right, None where none is."""
    tokens = key.split("_")
    right = [_word(t) for t in tokens]
    return "_".join(right) if right != tokens else None


def _word(token: str) -> str:
    if len(token) < 7 or not re.fullmatch("[a-z]+", token) or token in WORDS:
        return token
    near = [w for w in WORDS if _distance(token, w) <= (2 if len(w) > 8 else 1)]
    return near[0] if len(near) == 1 else token


def _distance(a: str, b: str) -> int:
    """Letters to change, add, leave out, or exchange with the next one."""
    if abs(len(a) - len(b)) > 2:
        return 3
    before: list[int] = []
    row = list(range(len(b) + 1))
    for i, x in enumerate(a, 1):
        new = [i]
        for j, y in enumerate(b, 1):
            cost = min(row[j] + 1, new[j - 1] + 1, row[j - 1] + (x != y))
            if before and j > 1 and x == b[j - 2] and a[i - 2] == y:
                cost = min(cost, before[j - 2] + 1)
            new.append(cost)
        before, row = row, new
    return row[-1]
