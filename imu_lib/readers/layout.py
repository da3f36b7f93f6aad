"""How a text file of numbers is laid out: delimiter, decimal mark, comments, preamble, header,
first line of data.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from imu_lib.errors import InputError

HEAD = 1 << 18  # bytes looked at
COMMENTS = ("#", "%", "//", "!")
_NUMBER = re.compile(
    r"^[+-]?(?:(?:\d+\.?\d*|\.\d+)(?:[eEdD][+-]?\d+)?|nan|inf|infinity|na|n/a|null)$", re.IGNORECASE
)
_COMMA_NUMBER = re.compile(r"^[+-]?\d+,\d+(?:[eE][+-]?\d+)?$")
_DATE = re.compile(r"^\d{4}[-/.]\d{1,2}[-/.]\d{1,2}$|^\d{1,2}[-/.]\d{1,2}[-/.]\d{4}$")
_CLOCK = re.compile(r"^\d{1,2}:\d{2}(?::\d{2}(?:[.,]\d+)?)?$")
_MOMENT = re.compile(
    r"^\d{4}[-/]\d{1,2}[-/]\d{1,2}[T ]\d{1,2}:\d{2}(?::\d{2}(?:[.,]\d+)?)?\s*(?:Z|[+-]\d{2}:?\d{2})?$"
)
_RATE = re.compile(
    r"^(?:fs|f_s|rate|sampling[ _]?(?:rate|frequency)|sample[ _]?(?:rate|frequency)|frequency|update[ _]?rate)$",
    re.IGNORECASE,
)


@dataclass(frozen=True)
class Layout:
    """delimiter None is any white space. header: names or None. first: 0-based line of the first
    data row; kinds: one of
    number, date, clock, moment, empty for each column."""

    delimiter: str | None
    decimal: str
    header: tuple[str, ...] | None
    first: int
    kinds: tuple[str, ...]
    rate: float | None
    encoding: str
    comment: str | None

    def split(self, line: str) -> list[str]:
        fields = line.split() if self.delimiter is None else line.split(self.delimiter)
        return [f.strip().strip('"') for f in fields]


def kind(field: str, decimal: str = ".") -> str:
    """What a field looks like: number, date, clock, moment, empty or text."""
    if field == "":
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


def _candidates(lines: list[str]):
    joined = "\n".join(lines)
    for delimiter in ("\t", ";", ",", "|", None):
        if delimiter is None or delimiter in joined:
            comma_fields = (
                delimiter != ","
                and bool(re.search(r"\d,\d", joined))
                and not re.search(r"\d\.\d", joined)
            )
            yield delimiter, "," if comma_fields else "."


def _data_lines(lines, delimiter, decimal):
    """For each line its field kinds where it is a row of data, else None."""
    out = []
    for line in lines:
        fields = [
            f.strip().strip('"')
            for f in (line.split() if delimiter is None else line.split(delimiter))
        ]
        kinds = tuple(kind(f, decimal) for f in fields)
        out.append(kinds if "text" not in kinds and "number" in kinds else None)
    return out


def sniff(path) -> Layout:
    """The layout of a text file. InputError where it is empty, binary or holds no rows of numbers."""
    path = Path(path)
    with open(path, "rb") as file:
        head = file.read(HEAD)
    if not head.strip():
        raise InputError(f"{path} is empty; a table with a row per sample is expected.")
    wide = head[:4] in (b"\xff\xfe\0\0", b"\0\0\xfe\xff")  # UTF-32 begins like UTF-16
    encoding = "utf-16" if head[:2] in (b"\xff\xfe", b"\xfe\xff") and not wide else "utf-8-sig"
    if encoding == "utf-8-sig" and (
        b"\0" in head or sum(c < 9 or 13 < c < 32 for c in head[:4096]) > 0.01 * len(head[:4096])
    ):
        if (
            b"\0" in head
            and head[4:].replace(b"\0", b"").isascii()
            and head.count(b"\0") >= 0.45 * len(head)
        ):
            raise InputError(
                f"{path} is text in an encoding of two or four bytes a character; save it as UTF-8."
            )
        raise InputError(
            f"{path} is neither text nor a binary format known here; give .npz, .csv, .txt, .tsv, .parquet, .mat or a ROS bag."
        )
    try:
        text = head.decode(encoding, errors="strict" if len(head) < HEAD else "ignore")
    except UnicodeDecodeError:
        text, encoding = head.decode("latin-1"), "latin-1"
    lines = text.splitlines()
    if len(head) == HEAD:
        lines = lines[:-1]  # the last one may be cut
    comment = next(
        (c for c in COMMENTS if any(line.lstrip().startswith(c) for line in lines)), None
    )
    kept = [
        i for i, line in enumerate(lines) if line.strip() and not line.lstrip().startswith(COMMENTS)
    ]
    best = None
    for delimiter, decimal in _candidates([lines[i] for i in kept[:200]]):
        rows = _data_lines([lines[i] for i in kept[:400]], delimiter, decimal)
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
            ),
            None,
        )
        if start is None:
            continue
        score = (sum(w == width for w in widths) / len(rows), width)
        if (
            best is None
            or score[0] > best[0][0] + 0.2
            or (score[0] > best[0][0] - 0.2 and score[1] > best[0][1])
        ):
            best = (score, delimiter, decimal, start, rows[start])
    if best is None:
        where = f" (line {kept[0] + 1}: {lines[kept[0]][:40]!r})" if kept else ""
        raise InputError(
            f"{path} holds no rows of numbers{where}; a table with a row per sample is expected."
        )
    _, delimiter, decimal, start, kinds = best
    first = kept[start]
    header, rate = _header(lines, first, kept, start, delimiter, len(kinds))
    return Layout(delimiter, decimal, header, first, kinds, rate, encoding, comment)


def _header(lines, first, kept, start, delimiter, width):
    """Column names from the line above the data (a comment line may hold them), and the rate where
    the preamble states one.
    """
    rate, header = None, None
    for i in range(first - 1, -1, -1):
        line = lines[i].strip()
        for c in COMMENTS:
            line = line.removeprefix(c)
        line = line.strip()
        if not line:
            continue
        fields = [
            f.strip().strip('"').strip()
            for f in (line.split() if delimiter is None else line.split(delimiter))
        ]
        if (
            delimiter is None and len(fields) != width
        ):  # `time [s] gyro_x [deg/s]`: blanks also stand before units
            fields = [f.strip() for f in re.findall(r"[^\s\[(]+\s*[\[(][^\])]*[\])]|\S+", line)]
        if (
            header is None
            and i >= first - 3
            and len(fields) in (width, width + 1)
            and not (len(fields) == width + 1 and fields[-1])
            and all(kind(f) in ("text", "empty") for f in fields)
        ):
            header = tuple(fields[:width])
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
    return header, rate
