"""How a text file of numbers is laid out: delimiter, decimal mark, comments, preamble, header, row
of units, first line of data.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from imu_lib.errors import InputError
from imu_lib.readers import names
from imu_lib.readers.fields import COMMENTS, STAMPS, decode, fields, kind
from imu_lib.readers.header import header_of, rate_said, units_said

_DATA_MARK = re.compile(
    r"^\s*(?:\*+End_of_Header\*+|@data|endheader|DATA_START|\[data\])\s*$", re.IGNORECASE
)


_BEGINS = re.compile(r"^\s*[+-]?[\d.]")


@dataclass(frozen=True)
class Layout:
    """delimiter None is any white space. header: names or None; units: of a row of units below it.
    first: 0-based line of the first data row; kinds: one of number, date, clock, moment, text,
    empty for each column."""

    delimiter: str | None
    decimal: str
    header: tuple[str, ...] | None
    units: tuple[str, ...] | None
    first: int
    kinds: tuple[str, ...]
    rate: float | None
    encoding: str
    comment: str | None
    said: dict[str, str] = field(default_factory=dict)  # sensor -> unit that a line above states
    rate_said: float | None = None  # Hz, in a line of words

    def split(self, line: str) -> list[str]:
        return fields(line, self.delimiter)


def _candidates(lines: list[str]):
    joined = "\n".join(lines)
    for delimiter in ("\t", ";", ",", "|", None):
        if delimiter is None or delimiter in joined:
            bare = re.sub(
                r"\d{1,2}\.\d{1,2}\.\d{2,4}", "", joined
            )  # 12.03.2020 is no decimal point
            commas = len(re.findall(r"\d,\d", bare))
            points = len(re.findall(r"\d\.\d", bare))
            yield delimiter, "," if delimiter != "," and commas > 2 * points else "."
    if len(re.findall(r'"[+-]?\d+,\d+"', joined)) > len(lines):
        yield ",", ","  # every field in quotes, with a decimal comma inside


def _kinds(line: str, delimiter: str | None, decimal: str) -> tuple[str, ...]:
    return tuple(kind(f, decimal) for f in fields(line, delimiter))


def _is_row(kinds: tuple[str, ...]) -> bool:
    """Whether a line could be a row of data: numbers, and no more text than numbers."""
    numbers = kinds.count("number")
    text = kinds.count("text")
    return numbers > 0 and (text == 0 or (numbers >= 3 and text <= numbers))


def sniff(head: bytes, source: str, *, whole: bool = True) -> Layout:
    """The layout of a text file from its beginning. InputError where it is empty, binary or holds
    no rows of numbers."""
    if not head.strip():
        raise InputError(f"{source} is empty; a table with a row per sample is expected.")
    text, encoding = decode(head, source, whole)
    lines = text.splitlines()
    if not whole:
        lines = lines[:-1]  # the last one may be cut
    comment = next(
        (c for c in COMMENTS if any(line.lstrip().startswith(c) for line in lines)), None
    )
    kept = [
        i for i, line in enumerate(lines) if line.strip() and not line.lstrip().startswith(COMMENTS)
    ]
    marks = [j for j, i in enumerate(kept) if _DATA_MARK.match(lines[i])]
    begins = [j for j in marks if any(_BEGINS.match(lines[i]) for i in kept[j + 1 : j + 4])]
    if begins or marks and marks[-1] + 1 < len(kept):
        # what stands above the mark before the first rows is no row
        kept = kept[(begins[0] if begins else marks[-1]) + 1 :]
    best = _best(lines, kept)
    if best is None:
        where = f" (line {kept[0] + 1}: {lines[kept[0]][:40]!r})" if kept else ""
        raise InputError(
            f"{source} holds no rows of numbers{where}; a table with a row per sample is expected."
        )
    _, delimiter, decimal, start, rows, _ = best
    kinds = _settled(rows[start], rows[start + 1 : start + 200])
    first = kept[start]
    some = [fields(lines[i], delimiter)[0] for i in kept[start : start + 6]]
    header, unit_row, rate = _names(lines, first, delimiter, kinds, some)
    said = units_said(lines[:first]) if unit_row is None else {}
    told = rate_said(lines[:first])
    return Layout(
        delimiter, decimal, header, unit_row, first, kinds, rate, encoding, comment, said, told
    )


def _best(lines, kept):
    """The way to cut the rows that makes most of them equally wide: score, delimiter, decimal mark,
    first row, rows, how many texts it holds. None where none makes rows of numbers.
    """
    best = None
    for delimiter, decimal in _candidates([lines[i] for i in kept[:200]]):
        rows = [_kinds(lines[i], delimiter, decimal) for i in kept[:400]]
        rows = [r if _is_row(r) else None for r in rows]
        widths = [len(r) for r in rows if r]
        if not widths:
            continue
        width = max(set(widths), key=widths.count)
        if delimiter is None and best is not None and not _blanks(lines, kept, best):
            continue  # blanks set apart nothing that the delimiter does not
        # the first run of equally wide rows; `key,3` lines above it are preamble
        start = next(
            (
                j
                for j, r in enumerate(rows)
                if r
                and len(r) == width
                and (j + 1 == len(rows) or rows[j + 1] is None or len(rows[j + 1]) == width)
                and _alike(r, rows[j + 1 : j + 6])
            ),
            None,
        )
        if start is None:
            continue
        texts = rows[start].count("text")
        score = (sum(w == width for w in widths) / len(rows) - 0.05 * texts, width)
        if (
            best is None
            or score[0] > best[0][0] + 0.2
            or (score[0] > best[0][0] - 0.2 and score[1] > best[0][1] and texts <= best[5])
        ):
            best = (score, delimiter, decimal, start, rows, texts)
    return best


def _names(lines, first, delimiter, kinds, some):
    """Header, row of units and rate above the first row, also where the names are one fewer than
    the columns; `some` are the first fields of the first rows.
    """
    header, unit_row, rate = header_of(lines, first, delimiter, len(kinds))
    if header is None and kinds[-1] == "empty":
        # a delimiter behind every row, not behind the names
        header, unit_row, rate = header_of(lines, first, delimiter, len(kinds) - 1)
        header, unit_row = (None if h is None else (*h, "") for h in (header, unit_row))
    if header is None and _counts(some):
        named, unit_row, rate = header_of(lines, first, delimiter, len(kinds) - 1)
        header = None if named is None else ("row", *named)  # R names no column of row numbers
        unit_row = None if unit_row is None else ("", *unit_row)
    return header or _over_two(lines, first, delimiter, kinds), unit_row, rate


def _blanks(lines, kept, best) -> bool:
    """Whether fields of the first row as a delimiter cuts it hold blanks, other than in a date with
    its clock.
    """
    _, delimiter, decimal, start, rows, _ = best
    found = fields(lines[kept[start]], delimiter)
    return len(found) < 4 or any(
        " " in f.strip() and k != "moment" for f, k in zip(found, rows[start])
    )


def _counts(first: list[str]) -> bool:
    """Whether the fields number the rows from 0 or 1."""
    return len(first) > 3 and any(first == [str(k + i) for k in range(len(first))] for i in (0, 1))


def _over_two(lines, first, delimiter, kinds) -> tuple[str, ...] | None:
    """A header in which one name stands over a date and a clock; None where there is none."""
    pairs = (("date", "clock"), ("clock", "date"))
    place = next((i for i in range(len(kinds) - 1) if kinds[i : i + 2] in pairs), None)
    if place is None:
        return None
    short = header_of(lines, first, delimiter, len(kinds) - 1)[0]
    if short is None or names.meaning(short[place]).quantity not in ("time", "date", "clock"):
        return None
    return (*short[: place + 1], *short[place:])


def _alike(row, following) -> bool:
    """Whether the rows below have text where this one has, and numbers where it has: a header that
    holds numbers is no row."""
    there = [r for r in following if r and len(r) == len(row)]
    if not there:
        return True
    for i, k in enumerate(row):
        below = [r[i] for r in there]
        if k == "text" and not any(b in ("text", "empty") for b in below):
            return False
    return True


def _settled(first, rows) -> tuple[str, ...]:
    """The kind of each column from its first rows: an empty field takes the kind of those below,
    and text anywhere in a column of text is text.
    """
    out = list(first)
    for i, k in enumerate(out):
        below = [r[i] for r in rows if r and len(r) == len(first)]
        if k == "empty":
            out[i] = next((b for b in below if b != "empty"), "empty")
        elif k in STAMPS or k == "number":
            others = [b for b in below if b not in (k, "empty")]
            if others and len(others) > 0.3 * len(below):
                out[i] = (
                    "text"
                    if k == "number" or "text" in others
                    else max(set(others), key=others.count)
                )
    return tuple(out)
