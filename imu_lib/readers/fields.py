"""One field of a text table: what it looks like, what means no reading, and how a line is cut."""

from __future__ import annotations

import csv
import re

from imu_lib.errors import InputError
from imu_lib.readers import calendar

HEAD = 1 << 18  # bytes looked at


COMMENTS = ("#", "%", "//", "!")


_NUMBER = re.compile(
    r"^[+-]?(?:(?:\d+\.?\d*|\.\d+)(?:[eEdD][+-]?\d+)?|nan|inf|infinity|na|n/a|null)$", re.IGNORECASE
)


#: A date with its clock in digits alone, to a part of a second.
_DIGITS = re.compile(
    r"^(?:19|20)\d\d(?:0[1-9]|1[0-2])[0-3]\d(?:[01]\d|2[0-3])[0-5]\d[0-5]\d(?:[.,]\d{1,9}|\d{3}|"
    r"\d{6})?$"
)
_COMMA_NUMBER = re.compile(r"^[+-]?(?:\d+,\d*|,\d+)(?:[eE][+-]?\d+)?$")


_D = (
    r"(?:\d{4}[-/.]\d{1,2}[-/.]\d{1,2}\.?|\d{1,2}[-/.]\d{1,2}[-/.]\d{4}\.?|"
    r"\d{4}年\d{1,2}月\d{1,2}日|\d{2}[-/.]\d{2}[-/.]\d{2}|\d{1,2}[-/ ][A-Za-z]{3}[-/ ]\d{4})"
)


_C = (
    r"(?:\d{1,2}:\d{2}(?::\d{2}(?:[.,:;]\d+)?)?|\d{1,2}:\d{1,2}:\d{1,2}(?:[.,:;]\d+)?|"
    r"\d{1,3}:\d{2}[.,]\d+)(?:\s*[AaPp]\.?[Mm]\.?)?"
)


_DATE = re.compile(rf"^{_D}$")


_CLOCK = re.compile(rf"^{_C}$")


_MOMENT = re.compile(rf"^{_D}(?:[T_]|,? +){_C}\s*(?:Z|{calendar.ZONES}|[+-]\d{{2}}:?\d{{2}})?$")


#: No reading.
NULLS = (
    "-", "--", "---", "*", "?", "#N/A", "#VALUE!", "#NUM!", "#DIV/0!", "#REF!", "None", "none", "NODATA", "NULL", "-nan", "+nan", "-NaN",
    "nan(ind)", "-nan(ind)", "1.#QNAN", "-1.#QNAN", "1.#IND", "-1.#IND", "<NA>", "n.a.", "NaT", "missing",
)  # fmt: skip


STAMPS = ("date", "clock", "moment")
#: What a spreadsheet makes of 9.81 or 2.1: a month with a year or a day.
MONTH = re.compile(
    r"^(?:\d{1,2}[. -]+)?(?:jan|feb|mar|mrz|m\u00e4r|apr|ma[iy]|jun|jul|aug|sep|o[ck]t|nov|de[cz])[a-z]*\.?"
    r"(?:[ -]\d{2,4})?$",
    re.IGNORECASE,
)


def fields(line: str, delimiter: str | None) -> list[str]:
    """The fields of a line; a delimiter inside quotes is no delimiter."""
    if delimiter is None:
        return [f.strip().strip('"') for f in line.split()]
    if '"' in line and line.count('"') % 2 == 0:
        found = next(
            csv.reader(
                [line.rstrip("\r\n").replace("\r", " ")], delimiter=delimiter, skipinitialspace=True
            ),
            [],
        )
        return [f.strip().strip('"') for f in found]
    return [f.strip().strip('"') for f in line.split(delimiter)]


def kind(field: str, decimal: str = ".") -> str:
    """What a field looks like: number, date, clock, moment, empty or text."""
    if field == "" or field in NULLS:
        return "empty"
    if len(field) > 13 and _DIGITS.match(field):
        return "moment"
    if _NUMBER.match(field) or (decimal == "," and _COMMA_NUMBER.match(field)):
        return "number"
    if len(field) > 14 and calendar.usual(field):
        return "moment"
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
            and all(c in b"\t\n\r" or 32 <= c < 127 for c in head[4:].replace(b"\0", b""))
            and head.count(b"\0") >= 0.45 * len(head)
        ):
            raise InputError(
                f"{source} is text in an encoding of two or four bytes a character; save it as "
                "UTF-8."
            )
        raise InputError(
            f"{source} is neither text nor a binary format known here; give .npz, .csv, .txt, "
            ".tsv, .parquet, .mat or a ROS bag."
        )
    try:
        return head.decode(encoding, errors="strict" if whole else "ignore"), encoding
    except UnicodeDecodeError:
        return head.decode("latin-1"), "latin-1"
