"""How a text file of numbers is laid out: delimiter, decimal mark, comments, preamble, header, row of
units, first line of data.
"""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass

from imu_lib.errors import InputError
from imu_lib.readers import names

HEAD = 1 << 18  # bytes looked at
COMMENTS = ("#", "%", "//", "!")
_NUMBER = re.compile(
    r"^[+-]?(?:(?:\d+\.?\d*|\.\d+)(?:[eEdD][+-]?\d+)?|nan|inf|infinity|na|n/a|null)$", re.IGNORECASE
)
_COMMA_NUMBER = re.compile(r"^[+-]?(?:\d+,\d*|,\d+)(?:[eE][+-]?\d+)?$")
_D = r"(?:\d{4}[-/.]\d{1,2}[-/.]\d{1,2}\.?|\d{1,2}[-/.]\d{1,2}[-/.]\d{4}\.?|\d{4}年\d{1,2}月\d{1,2}日|\d{1,2}[-/ ][A-Za-z]{3}[-/ ]\d{4})"
_C = r"(?:\d{1,2}:\d{2}(?::\d{2}(?:[.,:]\d+)?)?|\d{1,3}:\d{2}[.,]\d+)(?:\s*[AaPp]\.?[Mm]\.?)?"
_DATE = re.compile(rf"^{_D}$")
_CLOCK = re.compile(rf"^{_C}$")
_MOMENT = re.compile(rf"^{_D}(?:[T_]|,? +){_C}\s*(?:Z|UTC|GMT|[+-]\d{{2}}:?\d{{2}})?$")
_RATE = re.compile(
    r"^(?:fs|f_s|rate|sampling[ _]?(?:rate|frequency)|sample[ _]?(?:rate|frequency)|frequency|update[ _]?rate|output[ _]?(?:data[ _]?)?rate|odr)$",
    re.IGNORECASE,
)
NULLS = ("-", "--", "---", "*", "?", "#N/A", "#VALUE!", "None", "NODATA", "NULL")  # no reading
STAMPS = ("date", "clock", "moment")


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

    def split(self, line: str) -> list[str]:
        return fields(line, self.delimiter)


def fields(line: str, delimiter: str | None) -> list[str]:
    """The fields of a line; a delimiter inside quotes is no delimiter."""
    if delimiter is None:
        return [f.strip().strip('"') for f in line.split()]
    if '"' in line and line.count('"') % 2 == 0:
        found = next(
            csv.reader([line.rstrip("\r\n")], delimiter=delimiter, skipinitialspace=True), []
        )
        return [f.strip().strip('"') for f in found]
    return [f.strip().strip('"') for f in line.split(delimiter)]


def kind(field: str, decimal: str = ".") -> str:
    """What a field looks like: number, date, clock, moment, empty or text."""
    if field == "" or field in NULLS:
        return "empty"
    if _NUMBER.match(field) or (decimal == "," and _COMMA_NUMBER.match(field)):
        return "number"
    return (
        "date"
        if _DATE.match(field)
        else "clock"
        if _CLOCK.match(field)
        else "moment"
        if _MOMENT.match(field)
        else "text"
    )


def decode(head: bytes, source: str, whole: bool) -> tuple[str, str]:
    """The text of a file's beginning and its encoding. InputError where it is no text."""
    wide = head[:4] in (b"\xff\xfe\0\0", b"\0\0\xfe\xff")  # UTF-32 begins like UTF-16
    encoding = "utf-16" if head[:2] in (b"\xff\xfe", b"\xfe\xff") and not wide else "utf-8-sig"
    if encoding == "utf-8-sig" and (
        b"\0" in head
        or sum(c < 9 or 13 < c < 32 and c != 27 for c in head[:4096]) > 0.01 * len(head[:4096])
    ):
        if (
            b"\0" in head
            and head[4:].replace(b"\0", b"").isascii()
            and head.count(b"\0") >= 0.45 * len(head)
        ):
            raise InputError(
                f"{source} is text in an encoding of two or four bytes a character; save it as UTF-8."
            )
        raise InputError(
            f"{source} is neither text nor a binary format known here; give .npz, .csv, .txt, .tsv, .parquet, .mat or a ROS bag."
        )
    try:
        return head.decode(encoding, errors="strict" if whole else "ignore"), encoding
    except UnicodeDecodeError:
        return head.decode("latin-1"), "latin-1"


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
    best = None
    for delimiter, decimal in _candidates([lines[i] for i in kept[:200]]):
        rows = [_kinds(lines[i], delimiter, decimal) for i in kept[:400]]
        rows = [r if _is_row(r) else None for r in rows]
        widths = [len(r) for r in rows if r]
        if not widths:
            continue
        width = max(set(widths), key=widths.count)
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
    if best is None:
        where = f" (line {kept[0] + 1}: {lines[kept[0]][:40]!r})" if kept else ""
        raise InputError(
            f"{source} holds no rows of numbers{where}; a table with a row per sample is expected."
        )
    _, delimiter, decimal, start, rows, _ = best
    kinds = _settled(rows[start], rows[start + 1 : start + 200])
    first = kept[start]
    header, unit_row, rate = _header(lines, first, delimiter, len(kinds))
    if header is None:
        header = _over_two(lines, first, delimiter, kinds)
    return Layout(delimiter, decimal, header, unit_row, first, kinds, rate, encoding, comment)


def _over_two(lines, first, delimiter, kinds) -> tuple[str, ...] | None:
    """A header in which one name stands over a date and a clock; None where there is none."""
    pairs = (("date", "clock"), ("clock", "date"))
    place = next((i for i in range(len(kinds) - 1) if kinds[i : i + 2] in pairs), None)
    if place is None:
        return None
    short = _header(lines, first, delimiter, len(kinds) - 1)[0]
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


def _header(lines, first, delimiter, width):
    """Column names from the line above the data (a comment line may hold them), the row of units
    where there is one, and the rate where the preamble states one.
    """
    rate, header, unit_row, above = None, None, None, None
    for i in range(first - 1, -1, -1):
        line = lines[i].strip(" \r\n")
        for c in COMMENTS:
            line = line.removeprefix(c)
        line = line.strip(" \r\n")
        if not line.strip():
            continue
        names_ = _fit(line, delimiter, width)
        if names_ and header is None and i >= first - 4:
            if unit_row is None and _all_units(names_):
                unit_row = tuple(names_)
                continue
            header = tuple(names_)
            continue
        if names_ and header is not None and above is None and i >= first - 5:
            above = names_
            continue
        pair = re.match(
            r"^(.*?)\s*[:=,;\t ]\s*([+-]?[\d.]+(?:[eE][+-]?\d+)?)\s*(Hz)?$", line.rstrip(",;")
        )
        if pair and _RATE.match(
            re.sub(r"\s*[\[(]\s*Hz\s*[\])]", "", pair[1], flags=re.IGNORECASE).strip(" :=,;\t")
        ):
            rate = float(pair[2])
    if header and delimiter is None and len(header) != width:
        header = None
    if header and above:
        header = _two_lines(above, header)
    if header is None and unit_row is not None:
        header, unit_row = unit_row, None
    return header, unit_row, rate


def _fit(line: str, delimiter: str | None, width: int) -> list[str] | None:
    """The fields of a heading line where they are as many as the columns, else None."""
    found = fields(line, delimiter)
    if delimiter is None and len(found) != width:
        # `time [s] gyro_x [deg/s]`: blanks also stand before units
        found = [f.strip() for f in re.findall(r"[^\s\[(]+\s*[\[(][^\])]*[\])]|\S+", line)]
    if len(found) != width and delimiter not in (",", None) and line.count(",") == width - 1:
        found = fields(line, ",")
    if len(found) != width and delimiter not in (";", None) and line.count(";") == width - 1:
        found = fields(line, ";")
    if len(found) != width and delimiter is None and line.count(",") >= width - 1:
        found = fields(line, ",")
    if len(found) == width + 1 and not found[-1]:
        found = found[:width]
    if (
        len(found) == width - 1
        and found
        and delimiter is not None
        and line.rstrip().endswith(delimiter)
    ):
        found = [*found, ""]
    if len(found) != width or not all(
        kind(f) in ("text", "empty") or re.fullmatch(r"\d", f) for f in found
    ):
        return None
    if not any(kind(f) == "text" for f in found):
        return None
    return found


def _all_units(found: list[str]) -> bool:
    """Whether a line under the names is a row of units: most fields spell one, and none names a
    reading.
    """
    said = [f for f in found if f.strip() not in ("", "-")]
    known = [f for f in said if names.unit_of(f) is not None]
    others = [f for f in said if names.unit_of(f) is None]
    return (
        len(known) >= max(2, 0.5 * len(said))
        and all(len(f) <= 12 for f in others)
        and not any(names.meaning(f).axis for f in said)
    )


def _two_lines(above: list[str], header: tuple[str, ...]) -> tuple[str, ...]:
    """A header in two lines (the sensor above, x, y, z below) as one; the sensor stands over its
    first axis only or over each.
    """
    bare = sum(re.fullmatch(r"[xyz123]", h.strip().lower()) is not None for h in header)
    if bare < 3:
        return header
    out, last = [], ""
    for top, name in zip(above, header):
        last = top.strip() or last
        is_axis = re.fullmatch(r"[xyz123]", name.strip().lower())
        out.append(f"{last} {name}".strip() if is_axis else name)
    return tuple(out)
