"""Labelled numbers of one line: `gx=0.1`, `Gyro: x: 1 y: 2`, `accelerometer=Vector3D(x=0.1,
...)`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from imu_lib.readers import names
from imu_lib.readers.lines import NUMBER

_LABEL = re.compile(r'"?([^\W\d_][^=:,;|\t\n"]*?)"?\s*(?:[=:]\s*|(?=\[\s*[+-]?[\d.]))')
_VALUE = re.compile(
    rf"\s*[\[({{\"']?\s*({NUMBER})(?:(?=(?:us|ms|ns|s|g|mg|dps|mdps|rad/s|deg/s|m/s)\b)|"
    r"(?![\w:]))[\"']?"
)
_THREE = re.compile(rf"^\s*([A-Za-z]\w*)\s+({NUMBER})\s+({NUMBER})\s+({NUMBER})(?:\s+(\S+))?\s*$")
_MORE = re.compile(r"\s*[,;/\t ]\s*(?=\s*[+-]?[\d.])")
#: A unit behind a value, a blank or a bracket between them, or touching it; and one that says so.
_UNIT = re.compile(r"\s*[\])}]?\s*([A-Za-z°µ][\w°/^²*-]*(?:\s?s\^?-?[12])?)(?!\s*\w*\s*[=:])")
_ABUTS = re.compile(r"[\])}]?([A-Za-zµ°][^\s,;=:]*)(?=\s|$)")
_SAID = re.compile(r"[\s,;]*units?\s*[:=]\s*([^\s,;]+)", re.IGNORECASE)
#: Whose line it is, where several sensors print one each: `IMU2: GyX = 1`.
_TAG = re.compile(
    r"^\s*[\[<(]?((?:imu|mpu|sensor|dev|device|node|unit)[ _#-]?\d{1,2})[\]>)]?\s*[:|"
    r">]\s*(?=[A-Za-z])",
    re.IGNORECASE,
)
#: What opens behind a label: an object that is printed with its fields.
_OBJECT = re.compile(r"\s*(?:[A-Za-z_]\w*\s*\(|[({\[])\s*(?=[A-Za-z_]\w*\s*[=:])")
#: Labels that name several readings at once, and those of one sketch that nobody else uses.
_GROUPS = {
    "a/g": "accel_x accel_y accel_z gyro_x gyro_y gyro_z",
    "g/a": "gyro_x gyro_y gyro_z accel_x accel_y accel_z",
    "a/g/m": "accel_x accel_y accel_z gyro_x gyro_y gyro_z mag_x mag_y mag_z",
    **{f"a-{k}": "accel_x accel_y accel_z" for k in "cr"},  # Razor: calibrated, raw
    **{f"g-{k}": "gyro_x gyro_y gyro_z" for k in "cr"},
    **{f"m-{k}": "mag_x mag_y mag_z" for k in "cr"},
    "ypr": "yaw pitch roll",
}


@dataclass
class _Found:
    """entries: [label, value, sensor] of each number; sensor: named last, of bare letters."""

    entries: list[list[str]] = field(default_factory=list)
    sensor: str = ""
    tag: str = ""  # the number of the sensor that the line is of


def labelled(line: str) -> list[tuple[str, str]]:
    """(label, value) of each labelled number of a line; a label before several numbers is numbered
    by axes, a bare Y or Z belongs to the sensor named before it, and a unit after a value belongs
    to every value of its label.
    """
    if not re.search(r"[=:\[]", line):
        return _unmarked(line)
    found = _Found()
    tag = _TAG.match(line)
    found.tag = f"{tag[1]} " if tag else ""
    of_element = line.lstrip().startswith("<")
    at = 0
    while label := _LABEL.search(line, at):
        name = _name(label[1], of_element)
        at = label.end()
        values, at = _values(line, at)
        if values:
            unit, at = _unit(line, at)
            _take(found, name, values, unit)
            continue
        if opened := _OBJECT.match(line, at):
            found.sensor = name
            at = opened.end()
        elif re.fullmatch(r"[A-Za-z][\w ]*(?:\[[^\]]*\])?", name) and label[0].rstrip().endswith(
            ":"
        ):
            found.sensor = name  # Gyro: x=0.1 y=0.2 z=0.3
    return [(found.tag + a, b) for a, b, _ in found.entries]


def _unmarked(line: str) -> list[tuple[str, str]]:
    """Labels and numbers with blanks alone between them: gx 0.1 gy 0.2, accel 0.1 0.2 9.8 m/s/s."""
    three = _THREE.match(line)
    if three and names.meaning(f"{three[1]} x").quantity:
        unit = f" [{three[5]}]" if three[5] and names.unit_of(three[5]) else ""
        return [(f"{three[1]} {a}{unit}", three[i]) for i, a in enumerate("xyz", 2)]
    pairs = re.findall(rf"([^\W\d]\w*)[ \t]+({NUMBER})(?![\w.])", line)
    return [tuple(p) for p in pairs] if len(pairs) > 2 else []


def _name(label: str, of_element: bool) -> str:
    name = " ".join(label.split()).strip("{}()<>,;| ")
    if name.count("[") != name.count("]"):
        name = name.strip("[] ")
    name = name.rpartition("(")[2] if ")" not in label else name  # IMU(GyroX: 0.1
    return name.split()[-1] if of_element else name  # an attribute of an element


def _values(line: str, at: int) -> tuple[list[str], int]:
    """The numbers that follow a label, and where they end."""
    values = []
    while value := _VALUE.match(line, at):
        values.append(value[1])
        at = value.end()
        follow = _MORE.match(line, at)
        if not follow:
            break
        at = follow.end()
    return values, at


def _unit(line: str, at: int) -> tuple[str, int]:
    """The unit that stands behind a value, in brackets, and where it ends; empty where none
    does.
    """
    said = _SAID.match(line, at)
    if said and names.unit_of(said[1]):
        return f" [{said[1]}]", said.end()
    word, abuts = _UNIT.match(line, at), _ABUTS.match(line, at)
    if abuts and names.unit_of(abuts[1]) and not (word and names.unit_of(word[1])):
        word = abuts  # 12us a=...: what touches the number is its unit
    if word and names.unit_of(word[1]):
        return f" [{word[1]}]", word.end()
    return "", at


def _take(found: _Found, name: str, values: list[str], unit: str) -> None:
    """The values of one label, with the names that they have; the unit behind Z is that of X
    and Y.
    """
    if re.fullmatch(r"[xyzXYZ]", name) and found.sensor:
        name = f"{found.sensor} {name}"
    elif re.fullmatch(r"values?|data|readings?", name) and found.sensor:
        name = found.sensor  # LSM6DSO Accelerometer : values [0.1, 0.2, 9.8]
    else:
        split = re.match(r"^(.*\S)[ _]+[xX]$", name)
        found.sensor = split[1] if split else ""
    if len(values) == 1:
        found.entries.append([name + unit, values[0], found.sensor])
    else:
        heads = _GROUPS.get(name.lower().split()[-1] if name else "", "").split()
        if len(heads) != len(values):
            axes = "xyz" if len(values) == 3 else [f"#{i + 1}" for i in range(len(values))]
            heads = [f"{name} {a}" for a in axes]
        found.entries.extend([h + unit, v, name] for h, v in zip(heads, values))
    if unit and found.sensor:
        for entry in found.entries:
            if entry[2] == found.sensor and "[" not in entry[0]:
                entry[0] += unit
