"""The lines above the rows of a text table: names, a row of units, a stated rate."""

from __future__ import annotations

import re

from imu_lib.readers import names
from imu_lib.readers.fields import COMMENTS, fields, kind
from imu_lib.readers.spelling import unwrapped

_RATE = re.compile(
    r"^(?:fs|f_s|rate|sampling[ _]?(?:rate|frequency)|sample[ _]?(?:rate|frequency)|frequency|"
    r"update[ _]?rate|output[ _]?(?:data[ _]?)?rate|odr)$",
    re.IGNORECASE,
)


#: What a row of units says of columns that are no inertial readings.
_OTHER_UNIT = re.compile(
    r"^[\[(]?(?:no[_ ]?units?|unitless|none|n/?a|m?v|%|k?pa|h?pa|m?bar|mb|[mun]?t|m?gauss|lux|"
    r"bool|enum|hz|m|km|id)[\])]?$", re.IGNORECASE
)  # fmt: skip


#: How a date or a clock is written, in the place of a unit: yyyy/mm/dd hh:mm:ss.000.
_FORM = re.compile(
    r"^[\[(]?(?:[ymd]{1,4}[-/.][ymd]{1,4}[-/.][ymd]{1,4})?[T ]*(?:h{1,2}:m{1,2}:s{1,2}(?:[.,:]\w+)?)?[\])]?$", re.IGNORECASE
)  # fmt: skip


_STEP = re.compile(
    r"^(?:dt|ts|delta_?[tx]|sampl(?:e|ing)[ _]?(?:time|period|interval))\s*[:=,;\t "
    r"]\s*(\d*\.?\d+(?:[eE][+-]?\d+)?)\s*\[?\(?(s|ms|us)?\)?\]?$",
    re.IGNORECASE,
)


_AT = re.compile(
    r"(?<![^\W_])(?:at|rate|frequency|sampled|sampling|"
    r"odr)\b[^\d,;]{0,12}?(\d+(?:\.\d+)?)\s*(?:Hz|S/s|samples/s)\b",
    re.IGNORECASE,
)
_SENSORS = {
    "gyro": re.compile(r"\b(?:gyro\w*|angular (?:rate|velocity)s?|rates?)\b", re.IGNORECASE),
    "accel": re.compile(r"\b(?:acc\w*|specific forces?)\b", re.IGNORECASE),
}


_OTHER_RATE = re.compile(
    r"filter|cut|band|pass|lpf|noise|vibrat|camera|gps|gnss|mag", re.IGNORECASE
)


def rate_said(lines) -> float | None:
    """The rate that a line of words states, Hz; None where none does, or several do."""
    found = {
        float(m[1])
        for line in lines[-40:]
        if (m := _AT.search(line)) and not _OTHER_RATE.search(line[: m.end()])
    }
    return found.pop() if len(found) == 1 else None


def units_said(lines) -> dict[str, str]:
    """Units that a line of words states for a sensor, as in `gyro in deg/s, accel in g`."""
    out: dict[str, str] = {}
    for line in lines[-40:]:
        line = line.strip("#%/! \t\r\n")
        listed = re.match(r"^units?\s*[:=]\s*", line, re.IGNORECASE)  # units: accel g, gyro deg/s
        between = r"\s" if listed else r"\bin\b|:|=|\bunits?\b"
        for part in re.split(r"[,;]|\band\b", line[listed.end() if listed else 0 :]):
            said = re.match(
                rf"^\s*(.{{3,40}}?)\s*(?:{between})[\s:=]*[\[(]?\s*([^\s\])]+(?: per \w+)?)\s*"
                r"[\])]?\.?\s*$",
                part,
            )
            for sensor, word in _SENSORS.items():
                if said and word.search(said[1]) and names.unit_of(said[2]) in names.UNITS[sensor]:
                    out.setdefault(sensor, names.unit_of(said[2]))
    return out


def legend(lines) -> dict[str, str]:
    """Number -> sensor, where lines above the table say what a number stands for: `0 =
    Accelerometer`, `Accelerometer = 0 | Gyroscope = 1`.
    """
    found = {}
    for line in lines[-60:]:
        for part in re.split(r"[|,;]", line.strip()):
            if said := re.match(r"^\W*(\d{1,3})\s*(?:[=:]|-+>?)\s*([A-Za-z][\w -]*?)\W*$", part):
                found[said[1]] = said[2]
            elif said := re.match(r"^.*?([A-Za-z][\w -]*?)\s*[=:]\s*(\d{1,3})\W*$", part):
                found[said[2]] = said[1]
    kinds = {names.meaning(f"{word} x").quantity for word in found.values()}
    return found if kinds & {"gyro", "accel"} else {}


def header_of(lines, first, delimiter, width):
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
        if delimiter != ";":
            line = line.lstrip("; ")
        line = re.sub(r"^(?:columns|fields|header|format)\s*[:=]\s*", "", line, flags=re.IGNORECASE)
        listed = re.match(r"^units?\s*[:=]\s*(.*)$", line, re.IGNORECASE)
        if listed and unit_row is None:
            found = [f for d in (delimiter, ",", ";") if len(f := fields(listed[1], d)) == width]
            if found and _all_units(found[0]):
                unit_row = tuple(found[0])
                continue
        lab = re.match(r"^Y_Unit_Label[\t,;](.*)$", line)
        if lab:  # LabVIEW: a unit for each channel, none for the abscissa before them
            found = fields(lab[1].rstrip("\t,; "), lab[0][12])  # a blank for the comments
            if unit_row is None and len(found) in (width - 1, width - 2):
                unit_row = ("", *found, *[""] * (width - 1 - len(found)))
            continue
        names_ = _fit(line, delimiter, width)
        if names_ and sum(f != "" for f in names_) > 2 and len(set(names_) - {""}) == 1:
            continue  # how each column was sampled
        if names_ and header is None and _remarks(names_, lines[max(0, i - 3) : i], delimiter):
            continue  # whose sensor each column is, under names and units
        if names_ and header is None and i >= first - 4:
            if unit_row is None and _all_units(names_):
                unit_row = tuple(names_)
                continue
            header = tuple(names_)
            continue
        if names_ and header is not None and above is None and i >= first - 5:
            above = names_
            continue
        step = _STEP.match(line)
        if step and float(step[1]) > 0 and (step[2] or float(step[1]) < 0.5):
            rate = 1.0 / (float(step[1]) * {"ms": 1e-3, "us": 1e-6}.get(step[2], 1.0))
        pair = re.match(
            r"^(.*?)\s*[:=,;\t ]\s*([+-]?[\d.]+(?:[eE][+-]?\d+)?)\s*(Hz)?$", line.rstrip(",;")
        )
        if pair and _RATE.match(
            re.sub(r"\s*[\[(]\s*Hz\s*[\])]", "", pair[1], flags=re.IGNORECASE).strip(" :=,;\t")
        ):
            rate = float(pair[2])
    if header and (levels := _levels(lines[:first], delimiter, header)):
        return *levels, rate
    if header and unit_row is None:
        unit_row = _listed(lines[:first], width)
    if header and delimiter is None and len(header) != width:
        header = None
    if header and above:
        header = _two_lines(above, header)
    if header is None and unit_row is not None:
        header, unit_row = unit_row, None
    return header, unit_row, rate


def _levels(lines, delimiter, header):
    """Names and units of a header in several rows, the last of which names the index alone, as
    pandas writes columns of several levels; None where it is no such header.
    """
    if not header[0] or any(header[1:]):
        return None
    fits = [_fit(line.strip(" \r\n"), delimiter, len(header)) for line in lines]
    at = max(i for i, row in enumerate(fits) if row == list(header))
    rows: list[list[str]] = []
    while at and (row := fits[at - 1]) is not None:
        rows.insert(0, row)
        at -= 1
    units = next((row for row in rows if _all_units(row[1:])), None)
    named = [row for row in rows if row is not units]
    joined = (" ".join(r[i] for r in named if r[i] != "-").strip() for i in range(1, len(header)))
    told = (header[0], *joined)
    return (told, units and ("", *units[1:])) if named else None


def _listed(lines, width: int) -> tuple[str, ...] | None:
    """Units that stand one below the other under `[channel units]`, as a VBOX writes those of the
    last channels.
    """
    above = [line.strip().lower() for line in lines]
    if "[channel units]" not in above:
        return None
    found: list[str] = []
    for line in lines[above.index("[channel units]") + 1 :]:
        if not line.strip() or line.lstrip().startswith("["):
            break
        found.append(line.strip())
    fits = 0 < len(found) <= width
    return ("",) * (width - len(found)) + tuple(found) if fits else None


def _remarks(row: list[str], above: list[str], delimiter) -> bool:
    """Whether a row says nothing that is known, and one of those above it names readings."""
    if any(names.meaning(f).axis for f in row if f) or _all_units(row):
        return False
    better = [_fit(line.strip(" \r\n"), delimiter, len(row)) for line in above]
    return any(
        sum(names.meaning(f).axis is not None for f in found if f) >= 3 for found in better if found
    )


def _fit(line: str, delimiter: str | None, width: int) -> list[str] | None:
    """The fields of a heading line where they are as many as the columns, else None."""
    found = fields(line, delimiter)
    if delimiter is None and len(found) != width:
        # `time [s] gyro_x [deg/s]`: blanks also stand before units
        found = [f.strip() for f in re.findall(r"[^\s\[(]+\s*[\[(][^\])]*[\])]|\S+", line)]
    if delimiter is None and len(found) != width:
        found = [f.strip() for f in re.split(r"\s{2,}|\t", line.strip()) if f.strip()]
    if len(found) != width and delimiter not in (",", None) and line.count(",") == width - 1:
        found = fields(line, ",")
    if len(found) != width and delimiter not in (";", None) and line.count(";") == width - 1:
        found = fields(line, ";")
    if len(found) != width and delimiter is None and line.count(",") >= width - 1:
        found = fields(line, ",")
    if len(found) != width and delimiter == "\t" and "\t" not in line.strip():
        found = line.split()  # names with blanks between them, over tabs
    if len(found) == width + 1 and (
        not found[-1] or (found[0], found[-1]) == ("X_Value", "Comment")
    ):
        found = found[:width]  # LabVIEW names a column of comments that is seldom there
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
    known = [
        f for f in said if names.unit_of(f) is not None or _OTHER_UNIT.match(f) or _FORM.match(f)
    ]
    others = [f for f in said if f not in known]
    return (
        len(known) >= max(2, 0.5 * len(said))
        and all(len(f) <= 16 for f in others)
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
        if not is_axis and top.strip() and names.unit_of(name):
            name = f"{top.strip()} [{unwrapped(name)}]"
        out.append(f"{last} {name}".strip() if is_axis else name or top.strip())
    return tuple(out)
