"""Cells in quotes that go over several lines, as a message of ROS prints itself: "x:
0.1<newline>y: 0.2". They become columns of their own.
"""

from __future__ import annotations

import csv
import io
import re
from collections import Counter

from imu_lib.readers.lines import NUMBER, Table

_LINE = re.compile(rf"^\s*([A-Za-z_]\w*)\s*[:=]\s*({NUMBER}|nan)\s*$")


def unfold(text: str) -> Table | None:
    """Such a table as a plain one, None where it is none."""
    if not re.search(rf'"\s*[A-Za-z_]\w*\s*[:=]\s*{NUMBER}\s*\n', text[:8000]):
        return None
    rows: list[list[str]] = []
    places: list[int] = []
    reader = csv.reader(io.StringIO(text))
    place = 1
    for row in reader:
        if row:
            rows.append(row)
            places.append(place)
        place = reader.line_num + 1
    if len(rows) < 3:
        return None
    width = Counter(len(r) for r in rows).most_common(1)[0][0]
    heads, body = rows[0], [(r, p) for r, p in zip(rows[1:], places[1:]) if len(r) == width]
    if len(heads) != width or not body:
        return None
    parts = [_parts(cell) for cell in body[0][0]]
    out_heads = []
    for head, part in zip(heads, parts):
        out_heads += [head] if part is None else [f"{head}.{k}" for k in part]
    out, kept = [], []
    for row, line in body:
        flat: list[str] = []
        for cell, part in zip(row, parts):
            found = _parts(cell)
            if part is None:
                flat.append(" ".join(cell.split()))
            elif found is not None and list(found) == list(part):
                flat += found.values()
            else:
                break
        else:
            out.append("\t".join(flat))
            kept.append(line)
    if len(out) < 2:
        return None
    lost = len(rows) - 1 - len(out)
    notes = (f"{lost:,} rows of another shape were left out.",) if lost else ()
    return Table("\t".join(out_heads) + "\n" + "\n".join(out) + "\n", kept, notes)


def _parts(cell: str) -> dict[str, str] | None:
    """Names and numbers of a cell's lines, None where it holds no such lines."""
    lines = [x for x in cell.splitlines() if x.strip()]
    found = [_LINE.match(x) for x in lines]
    if len(lines) < 2 or not all(found):
        return None
    return {m[1]: m[2] for m in found if m}
