"""Marks of one set of answers: the name counts as in the score of the gap workflow, then the
parameters.

An effect is *named* when its own name stands under its own channel. Of an effect's mark 60 % are
for the name and 40 % for its parameters, which get the whole share within a tolerance and nothing
from three tolerances on. A wrong name earns nothing, and each name for something that is not there
takes back a fifth of an effect's mark.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from imu_lib.exercise.answers import listed, same_name

NAME_SHARE, FALSE_COST, NONE_FROM = 0.6, 0.2, 3.0
#: Tolerances, relative to the true value; those of times are relative to the record's length.
TOLERANCE = {"frequency": 0.005, "time": 0.02, "time_constant": 0.25, "K": 0.3, "rate": 0.3}
TOLERANCE |= {"N_per_speed": 0.3, "fraction": 0.3}
USUAL = 0.15
#: Parameters of which either sign says the same: the phase, or which of two levels comes first.
EITHER_SIGN = {("sinusoid", "amplitude"), ("telegraph", "amplitude"), ("random_walk", "K")}
VECTOR = 0.25  # of three values together, relative to the length of the true vector


@dataclass(frozen=True)
class Mark:
    """Points of 100, counts as in the score of the workflow, and a sentence for each effect."""

    points: float
    hidden: int
    named: int
    wrong: int
    feedback: tuple[str, ...]


def mark(hidden: Sequence, answers: Mapping, *, length: float, where: str = "the answers") -> Mark:
    """Mark answers against the truth.

    Parameters
    ----------
    hidden : sequence of (channel, effect, parameters)
    answers : mapping
        `{"channels": {channel: [{"effect": ..., "parameters": {...}}]}}`; what `imu-lib gap --json`
        writes is one, too.
    length : float, s
        Of the record.

    Raises
    ------
    InputError
        Where the answers have another form.
    """
    given = listed(answers, where)
    earned, named, feedback, used = 0.0, 0, [], set()
    for channel, effect, parameters in hidden:
        judged = {
            i: _parameters(effect, parameters, told, length)
            for i, (c, e, told) in enumerate(given)
            if i not in used and (c, e) == (channel, effect)
        }
        if not judged:
            there = [e for i, (c, e, _) in enumerate(given) if c == channel and i not in used]
            said = f"you named {', '.join(there)}" if there else "you named nothing there"
            feedback.append(f"{channel}: there was {effect}; {said}.")
            continue
        best = max(judged, key=lambda i: judged[i][0])  # of one that is named twice the nearer
        used.add(best)
        named += 1
        shares, words = judged[best]
        earned += NAME_SHARE + (1.0 - NAME_SHARE) * shares
        feedback.append(f"{channel}: {effect} named; {words}.")
    wrong = [(c, e) for i, (c, e, _) in enumerate(given) if i not in used]
    there = {(c, e) for c, e, _ in hidden}
    feedback += [
        f"{c}: {e} named more often than it was there."
        if (c, e) in there
        else f"{c}: there was no {e}."
        for c, e in wrong
    ]
    earned = max(0.0, earned - FALSE_COST * len(wrong))
    return Mark(100.0 * earned / len(hidden), len(hidden), named, len(wrong), tuple(feedback))


def _parameters(effect: str, true: Mapping, given: Mapping, length: float) -> tuple[float, str]:
    """Share of the parameters' mark, and what to tell the student."""
    shares, words = [], []
    plain = {same_name(name, true) or name: value for name, value in given.items()}
    for name, value in true.items():
        answer = given.get(name, plain.get(name))
        if isinstance(value, str):  # where it acts
            right = isinstance(answer, str) and same_name(answer, [value]) == value
            shares.append(float(right))
            words.append(f"{name} {'right' if right else 'wrong'}, it was {value}")
            continue
        if isinstance(value, Sequence):
            share, said = _vector(name, value, answer)
            shares.append(share)
            words.append(said)
            continue
        if not isinstance(answer, (int, float)) or isinstance(answer, bool):
            shares.append(0.0)
            other = ", ".join(k for k in plain if k not in true)
            said = f" (given: {other})" if other else ""
            words.append(f"{name} is missing{said}, it was {value:.4g}")
            continue
        if (effect, name) in EITHER_SIGN and answer * value < 0:
            answer = -answer
        tolerance = TOLERANCE.get(name, USUAL)
        scale = length if name == "time" else abs(value)
        share, judged = _share(abs(answer - value) / scale / tolerance)
        if not share and _share(abs(answer + value) / scale / tolerance)[0]:
            judged = "wrong in its sign"
        shares.append(share)
        words.append(f"{name} {answer:.4g} {judged}, it was {value:.4g}")
    return sum(shares) / len(shares), "; ".join(words)


def _share(error: float) -> tuple[float, str]:
    """Share of a parameter's mark for an error in tolerances, and the word for it."""
    share = min(1.0, max(0.0, (NONE_FROM - error) / (NONE_FROM - 1.0)))
    return share, "right" if share == 1.0 else "near" if share else "wrong"


def _vector(name: str, value: Sequence, answer) -> tuple[float, str]:
    true = ", ".join(f"{v:.4g}" for v in value)
    numbers = isinstance(answer, Sequence) and not isinstance(answer, str)
    if (
        not numbers
        or len(answer) != len(value)
        or not all(isinstance(a, (int, float)) for a in answer)
    ):
        what = "missing" if answer is None else f"{answer}, no list of {len(value)} numbers"
        return 0.0, f"{name} is {what}; it was {true}"
    length = sum(v**2 for v in value) ** 0.5
    off = sum((a - v) ** 2 for a, v in zip(answer, value)) ** 0.5
    share, judged = _share(off / length / VECTOR)
    return share, f"{name} {judged}, it was {true}"
