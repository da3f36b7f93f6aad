"""Marks that set thousands apart: 1.001,32 and 1'001.32, and 16'384 of a count."""

from __future__ import annotations

import re
from collections import Counter

from imu_lib.readers.fields import fields

#: Marks that no number has for its decimals: an apostrophe, blanks that hold a number together.
PLAIN = ("'", "\u2019", "\u00a0", "\u202f", "\u2009", " ")
#: The decimal mark beside a mark of thousands that may be one itself.
OTHER = {",": ".", ".": ","}
SOME = 1 << 15  # bytes at either end of a text that are looked at
FEW = 5  # numbers with and without a mark from which a lone mark tells


def without(data: bytes) -> tuple[bytes, str] | None:
    """A text without the marks between its thousands, and a number that had them; None where it
    has none.

    A column tells: its numbers have groups of three digits behind each mark, and a second mark,
    decimals behind the last one, or none below a thousand. Where a column shows the mark before
    decimals, it sets no thousands apart anywhere.
    """
    some = data[:SOME].split(b"\n")[: None if len(data) <= SOME else -1]
    some += data[max(SOME, len(data) - SOME) :].split(b"\n")[1:]
    lines = [r.decode("utf-8", "replace").strip("\r") for r in some if r.strip()]
    for delimiter in (";", "\t", "|", ","):
        found = [fields(x, delimiter) for x in lines if delimiter in x]
        width = Counter(map(len, found)).most_common(1)[0][0] if found else 0
        table = [r for r in found if len(r) == width]
        if width < 2 or len(table) < 0.8 * len(lines):
            continue
        for mark in (*OTHER, *PLAIN):
            said = [_says(column, mark) for column in zip(*table)]
            if True in said and False not in said:
                return _taken_out(data, mark, delimiter)
    return None


def lone(data: bytes) -> tuple[bytes, str] | None:
    """The same of a text in which single numbers have marks, each with decimals behind them."""
    for mark, decimal in (*OTHER.items(), ("'", ".")):
        shape = rb"(?:(?<=[;\t|\n\"])|^)" + _number(mark) + re.escape(decimal.encode())
        if re.search(shape + rb"\d+(?=[;\t|\r\n\"]|$)", data):
            return _taken_out(data, mark, ";")
    return None


def _says(column, mark: str) -> bool | None:
    """Whether the mark sets thousands apart in a column; None where the column does not say."""
    cells = [c for c in column if re.match(r"[+-]?\d", c)]
    marked = [c for c in cells if mark in c]
    if not marked:
        return None
    m, d = re.escape(mark), re.escape(OTHER.get(mark, "")) or "[.,]"
    grouped = re.compile(rf"[+-]?[1-9]\d{{0,2}}((?:{m}\d{{3}})+)({d}\d+)?")
    found = [grouped.fullmatch(c) for c in marked]
    if not all(found):
        number = rf"[+-]?\d*{m}\d+(?:[eE][+-]?\d+)?"
        decimal = mark in OTHER and all(re.fullmatch(number, c) for c in marked)
        return False if decimal else None
    small = [c for c in cells if re.fullmatch(rf"[+-]?\d{{1,3}}(?:{d}\d+)?", c)]
    if len(small) + len(marked) < len(cells):
        return None  # a thousand stands there without a mark
    if mark in PLAIN or any(f and (f[2] or f[1].count(mark) > 1) for f in found):
        return True
    return True if min(len(marked), len(small)) >= FEW else None


def _number(mark: str) -> bytes:
    return rb"([+-]?[1-9]\d{0,2}(?:" + re.escape(mark.encode()) + rb"\d{3})+)"


def _taken_out(data: bytes, mark: str, delimiter: str) -> tuple[bytes, str] | None:
    """The text with the mark out of every such number between two delimiters or quotes."""
    edge = re.escape(b';\t|"\r\n' + (delimiter.encode() if delimiter != mark else b""))
    behind = edge + re.escape(OTHER.get(mark, ".,").encode())
    before, after = rb"(?:(?<=[" + edge + rb"])|^)", rb"(?=[" + behind + rb"]|$)"
    shape = re.compile(before + _number(mark) + after)
    found = shape.search(data)
    if found is None:
        return None
    sign = mark.encode()
    return shape.sub(lambda m: m[0].replace(sign, b""), data), found[0].decode()
