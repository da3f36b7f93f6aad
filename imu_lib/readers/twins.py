"""Two accelerometers or gyros side by side under names of equal standing: the one with gravity in
it is the accelerometer, and which was taken is said.
"""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

from imu_lib.readers import lexicon, names
from imu_lib.readers.meaning import WORD, Meaning
from imu_lib.readers.raw import Raw

# times longer, in whatever units, is a mean specific force with gravity than one from which it was
# taken
APART = 5.0


def with_gravity(told: list[Meaning], headings, load: Callable) -> list[Meaning]:
    """Of two triples of accelerometer columns of one rank the one that holds gravity, where the
    other holds none; as they are where that does not tell.
    """
    there = [i for i, m in enumerate(told) if m.quantity == "accel" and m.axis in ("x", "y", "z")]
    best = min((told[i].rank for i in there), default=0)
    there = [i for i in there if told[i].rank == best and headings[i].kind == "number"]
    axes = {a: [i for i in there if told[i].axis == a] for a in "xyz"}
    if any(len(i) != 2 for i in axes.values()):
        return told
    triples = [tuple(axes[a][k] for a in "xyz") for k in (0, 1)]
    values = load(there)
    length = []
    for triple in triples:
        x = np.column_stack([np.asarray(values[i], dtype=float) for i in triple])
        length.append(float(np.linalg.norm(np.nanmedian(x, axis=0))))
    units = [told[t[0]].unit for t in triples]
    factor = [9.8 if u == "g" else 1.0 for u in units]
    for keep, leave in ((0, 1), (1, 0)):
        apart = min(length[keep] * f for f in (1.0, factor[keep]))
        if apart > APART * max(length[leave] * f for f in (1.0, 9.8)):
            out = list(told)
            for i in triples[leave]:
                name = headings[triples[keep][0]].name
                out[i] = Meaning(why=f"an acceleration without gravity; `{name}` has it")
            return out
    return told


def add_gravity(raw: Raw, told: list[Meaning], headings, values, load: Callable) -> None:
    """Gravity as a device computed it added to the acceleration from which it took it, where the
    file has no other accelerometer: the sum is the specific force that was measured.
    """
    force = {m.axis: i for i, m in enumerate(told) if m.quantity == "accel" and m.axis}
    if set(force) != set("xyz") or not all(names.free(headings[i].name) for i in force.values()):
        return
    gravity = {}
    for i, (m, h) in enumerate(zip(told, headings)):
        if m.why == lexicon.NOT["gravity"] and h.kind == "number":
            along = names.meaning(re.sub(r"gravit(?:y|ation)|grav", " acc ", h.name, flags=re.I))
            unit = names.unit_of(h.unit or "") or along.unit
            if along.axis in force and unit == told[force[along.axis]].unit:
                gravity.setdefault(along.axis, i)
    if set(gravity) != set("xyz"):
        return
    more = load(list(gravity.values()))
    for axis, i in force.items():
        values[i] = np.asarray(values[i], dtype=float) + np.asarray(
            more[gravity[axis]], dtype=float
        )
    raw.notes += (
        f"`{headings[gravity['x']].name}` and its other axes were added to "
        f"`{headings[force['x']].name}`, from which they had been taken: the sum is the "
        "specific force.",
    )


def say(raw: Raw, second: dict[str, tuple[int, int]], headings) -> None:
    """A word on each kind of which one column was taken and another left: kind -> (taken, left)."""
    for kind, (taken, left) in second.items():
        raw.notes += (
            f"`{headings[taken].name}` was taken as the {WORD[kind]}, `{headings[left].name}` "
            "beside it was not; --columns names columns by position where the other is meant.",
        )
