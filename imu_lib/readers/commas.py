"""Commas between the fields and in the numbers alike, as a sheet of a language with decimal commas
saves them: two fields for each name.
"""

from __future__ import annotations

import re

from imu_lib.readers.lines import Table

_NUMBER = r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?"
#: Rows that are looked at before the whole file is.
SOME = 200


def joined(text: str) -> Table | None:
    """Rows of twice as many fields as the header has names, each second one digits: numbers with a
    decimal comma. None where the text is no such table.
    """
    lines = text.splitlines()
    top = next((i for i, r in enumerate(lines[:40]) if re.match(rf"^{_NUMBER},", r)), 0)
    if not top:
        return None
    names = next((r for r in reversed(lines[:top]) if r.strip()), "").strip()
    width = names.count(",") + 1
    row = re.compile(rf"^{_NUMBER}(?:,{_NUMBER}){{{width - 1}}}\s*$")
    some = [r for r in lines[top : top + SOME] if r.strip()]
    if width < 3 or len(some) < 2 or re.search(r"(?<![\w.])\d+\.\d", names):
        return None
    if sum(row.match(r) is not None for r in some) < 0.95 * len(some):
        return None
    kept, places = [], []
    for i, r in enumerate(lines[top:], top + 1):
        if row.match(r):
            kept.append("\t".join(f.replace(",", ".") for f in re.findall(_NUMBER, r)))
            places.append(i)
    notes = (
        "The commas are decimal marks as well as delimiters; each two fields were put together.",
    )
    lost = sum(bool(r.strip()) for r in lines[top:]) - len(kept)
    if lost:
        notes += (f"{lost:,} lines of another shape were left out.",)
    return Table("\t".join(names.split(",")) + "\n" + "\n".join(kept) + "\n", places, notes)
