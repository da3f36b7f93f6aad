"""Rows cut off: the last one, and one where a board began anew and wrote its heading again."""

from __future__ import annotations

import re
from collections.abc import Collection

#: How a row of numbers begins.
BEGINS = re.compile(rb"^\s*\"?[+-]?\.?\d")


def torn(rows: list[bytes], again: Collection[int], named: bytes, layout) -> set[int]:
    """Rows cut off right above a heading (`named`) that stands there again with its words, or in
    front of it in one line.
    """
    above = {i - 1 for i in again if i - 1 not in again and i - 1 > layout.first}
    short = {i for i in above if BEGINS.match(rows[i]) and _short(rows[i], layout)}
    return short | {i for i in again if BEGINS.match(rows[i]) and rows[i].strip() != named}


def _short(row: bytes, layout) -> bool:
    text = row.decode(layout.encoding, "replace").strip("\r")
    return len(layout.split(text)) < len(layout.kinds)


def is_cut(tail: list[bytes], layout) -> int:
    """1 where the last line has fewer fields than the rows, and those before it have all."""
    width = [len(layout.split(r.decode(layout.encoding, "replace").strip("\r"))) for r in tail[-4:]]
    full = len(layout.kinds)
    return int(len(width) == 4 and width[-1] < full and width[1:3] == [full] * 2)


def said(cut: Collection[int]) -> tuple[str, ...]:
    """A sentence on the rows that were cut off; empty where none was."""
    if not cut:
        return ()
    first = min(cut)
    return (
        f"Line {first + 1} is cut off and the heading stands behind it again: the logger restarted "
        f"there{f' and {len(cut) - 1} times later' if len(cut) > 1 else ''}; the cut row was left "
        f"out, and `head -n {first}` of the file is the run before.",
    )
