"""What the name of a file or a folder says of a record: its sensor, its date."""

from __future__ import annotations

import re
from datetime import date

#: A year, month and day, or day, month and year parted by dots, that stands by itself in a name.
_DATE = re.compile(
    r"(?:^|[_\-. T])(?:(?P<y>(?:19|20)\d\d)(?P<sep>[-._]?)(?P<m>[01]\d)(?P=sep)(?P<d>[0-3]\d)"
    r"|(?P<d2>[0-3]\d)\.(?P<m2>[01]\d)\.(?P<y2>(?:19|20)\d\d))(?=$|[_\-. T])"
)
#: What may follow the date of a record that is one of several: a time, a number, a letter.
_RUN = re.compile(
    r"(?i)(run|rep|meas|no|nr|v|#|\()?[ _-]?\d{1,6}z?\)?|\d\d[-:.]\d\d([-:.]\d\d)?|[a-z]"
)


def dated(name: str) -> tuple[str, str, str]:
    """(what stands before the date, the date as YYYY-MM-DD or empty, what stands behind it)."""
    for match in _DATE.finditer(name):
        found = match.groupdict()
        day = [found[key] or found[f"{key}2"] for key in ("y", "m", "d")]
        if when := a_date("-".join(day)):
            before, after = name[: match.start()], name[match.end() :]
            return before.strip("_-. T"), when, after.strip("_-. T")
    return name, "", ""


def a_date(text: str) -> str:
    """A date as YYYY-MM-DD, from that form, with a time behind it, or from 10.01.2026; empty where
    the text is no day of the calendar.
    """
    text = re.sub(r"[T ]\d\d?:\d\d.*$", "", text.strip())
    if match := re.fullmatch(r"(\d\d?)\.(\d\d?)\.(\d{4})", text):
        text = f"{match[3]}-{int(match[2]):02d}-{int(match[1]):02d}"
    if match := re.fullmatch(r"(\d{4})(\d\d)(\d\d)|(\d{4})/(\d\d)/(\d\d)", text):
        text = "-".join(part for part in match.groups() if part)
    try:
        return date.fromisoformat(text).isoformat()
    except ValueError:
        return ""


def sensor_and_date(stem: str) -> tuple[str, str]:
    """Sensor and date that a file's name tells: what stands before the date; what follows it is
    part of the name unless it is a time, a number or a letter (`unit12_2024-05-01_2`).
    """
    before, when, after = dated(stem)
    if before and after and not _RUN.fullmatch(after):
        return f"{before}_{after}", when
    return before or after, when
