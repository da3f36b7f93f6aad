"""Logs whose lines begin with the name of a message, and say elsewhere what its fields are: flight
logs as text (`FMT` lines), phone logs (`# UncalGyro,...` in the head), NovAtel's sentences.
"""

from __future__ import annotations

import re

from imu_lib.errors import InputError
from imu_lib.readers import names
from imu_lib.readers.lines import Table

#: Fields behind the semicolon of sentences whose maker fixes them. Increments, which NovAtel
#: divides by no interval: x is the right, y the forward axis of the case.
NOVATEL = {
    "CORRIMUDATA": "week time[s] dtheta_x[rad] dtheta_y[rad] dtheta_z[rad] dv_x[m/s] dv_y[m/s] "
    "dv_z[m/s]",
    "CORRIMUDATAS": "week time[s] dtheta_x[rad] dtheta_y[rad] dtheta_z[rad] dv_x[m/s] dv_y[m/s] "
    "dv_z[m/s]",
}
_RAW = ("RAWIMU", "RAWIMUS", "RAWIMUX", "RAWIMUSX")
_NUMBER = re.compile(r"^[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?$")


def unfold(text: str, source: str) -> Table | None:
    """Such a log as a plain table, None where it is none. InputError where its only readings are
    counts whose scale depends on the sensor.
    """
    lines = text.splitlines()
    some = [x for x in lines[:4000] if x.strip()]
    if sum(bool(re.match(r"^[#%][A-Z0-9]{4,}A,", x)) for x in some) > 0.5 * len(some):
        return _novatel(lines, source)
    fields = _fields(lines)
    return _messages(lines, fields) if fields else None


def _novatel(lines: list[str], source: str) -> Table | None:
    rows, places, kinds = [], [], set()
    head = None
    for number, line in enumerate(lines, 1):
        found = re.match(r"^[#%]([A-Z0-9]+)A,[^;]*;([^*]*)", line)
        if not found:
            continue
        kinds.add(found[1])
        if found[1] in NOVATEL:
            names_ = NOVATEL[found[1]].split()
            values = [v.strip() for v in found[2].split(",")]
            if len(values) >= len(names_):
                head = names_
                rows.append(values[: len(names_)])
                places.append(number)
    if len(rows) > 1 and head:
        note = (
            "NovAtel's corrected increments: its filter's biases, gravity and the Earth's rate "
            "are taken out of them, so they are not the sensor's own."
        )
        body = "\n".join("\t".join(r) for r in rows)
        return Table("\t".join(head) + "\n" + body + "\n", places, (note,))
    if kinds & set(_RAW):
        raise InputError(
            f"{source} holds NovAtel's {sorted(kinds & set(_RAW))[0]} sentences: increments in "
            "counts, with -y in the place of y and a scale of the sensor; "
            "write them as a table of time, dtheta_x[rad] .. dv_z[m/s] with the scale of the "
            "sensor's data sheet."
        )
    raise InputError(
        f"{source} holds NovAtel's sentences ({', '.join(sorted(kinds)[:4])}) and none of an IMU; "
        "a log of CORRIMUDATA, or a table, is expected."
    )


def _fields(lines: list[str]) -> dict[str, list[str]]:
    """Message -> names of its fields, where the log says them: in lines `FMT, id, length, NAME,
    types, A,B,C`, or in the comments of its head.
    """
    out: dict[str, list[str]] = {}
    said = [[p.strip() for p in x.lstrip("#% $").split(",")] for x in lines[:400]]
    heads = {p[1]: p[2:] for p in said if p[0] in ("COL", "COLS", "COLUMNS") and len(p) > 4}
    for p in said:  # FlySight: $COL,IMU,time,wx and $UNIT,IMU,s,deg/s above $IMU,0.1,0.2
        if p[0] in ("UNIT", "UNITS") and len(p) > 3 and len(p) - 2 == len(heads.get(p[1], ())):
            heads[p[1]] = [f"{h} [{u}]" if u else h for h, u in zip(heads[p[1]], p[2:])]
    if heads:
        return heads
    tags = {x.split(",")[0].strip() for x in lines[:2000] if not x.startswith(("#", "%"))}
    for line in lines[:2000]:
        parts = [p.strip() for p in line.lstrip("#% ").split(",")]
        if parts[0] == "FMT" and len(parts) > 5:
            out[parts[3]] = parts[5:]
        elif line.startswith(("#", "%")) and parts[0] in tags and len(parts) > 3:
            out.setdefault(parts[0], parts[1:])
    return out


def _messages(lines: list[str], fields: dict[str, list[str]]) -> Table | None:
    """The messages that hold inertial readings side by side, empty where a row has none of a
    field.
    """
    useful = {}
    for tag, heads in fields.items():
        told = [names.meaning(h) for h in heads]
        if sum(m.quantity in names.SIGNALS and bool(m.axis) for m in told) >= 3:
            useful[tag] = heads
    if "IMU" in useful:
        useful = {"IMU": useful["IMU"]}  # others hold the same, or a batch of one sensor
    heads = list(dict.fromkeys(h for names_ in useful.values() for h in names_))
    place = {h: i for i, h in enumerate(heads)}
    rows, places, others = [], [], 0
    for number, line in enumerate(lines, 1):
        parts = [p.strip() for p in line.split(",")]
        names_ = useful.get(parts[0].lstrip("$"))
        if names_ is None or len(parts) != len(names_) + 1 or not _NUMBER.match(parts[1]):
            others += bool(line.strip()) and not line.startswith(("#", "%"))
            continue
        row = [""] * len(heads)
        for name, value in zip(names_, parts[1:]):
            row[place[name]] = value
        rows.append(row)
        places.append(number)
    if len(rows) < 2:
        return None
    note = (
        (f"{others:,} lines of other messages than {' and '.join(useful)} were left out.",)
        if others
        else ()
    )
    body = "\n".join("\t".join(r) for r in rows)
    return Table("\t".join(heads) + "\n" + body + "\n", places, note)
