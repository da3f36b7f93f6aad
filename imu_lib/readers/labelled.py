"""Lines in which words stand between the numbers, as serial monitors and sentence loggers write them,
into a plain table.

`14:05:00.000 -> 0.1,0.2`, `aX = -65 | aY = 183`, `a/g: 1 2 3 4 5 6`, `Accel X: 0.1, Y: 0.2, Z: 9.8
m/s^2`, `{"t": 1, "gx": 2}`, `$VNIMU,...*5B`: what the words say becomes the header.
"""

from __future__ import annotations

import re
from collections import Counter

from imu_lib.readers import names
from imu_lib.readers.lines import (
    LOGGERS,
    NUMBER,
    PREFIX,
    Table,
    as_table,
    share,
    stamp_head,
    without_stamp,
)
from imu_lib.readers.sentences import is_sentences, sentences

_LABEL = re.compile(r'"?([^\W\d_][^=:,;|\t\n"]*?)"?\s*(?:[=:]\s*|(?=\[\s*[+-]?[\d.]))')
_VALUE = re.compile(
    rf"\s*[\[({{\"']?\s*({NUMBER})(?:(?=(?:us|ms|ns|s|g|mg|dps|mdps|rad/s|deg/s|m/s)\b)|(?![\w:]))[\"']?"
)
_THREE = re.compile(rf"^\s*([A-Za-z]\w*)\s+({NUMBER})\s+({NUMBER})\s+({NUMBER})(?:\s+(\S+))?\s*$")
#: Labels that name several readings at once.
_GROUPS = {
    "a/g": "accel_x accel_y accel_z gyro_x gyro_y gyro_z",
    "g/a": "gyro_x gyro_y gyro_z accel_x accel_y accel_z",
    "a/g/m": "accel_x accel_y accel_z gyro_x gyro_y gyro_z mag_x mag_y mag_z",
}


def unfold(text: str) -> Table | None:
    """A labelled text as a plain table; None where the lines are none or are plain already."""
    lines = text.splitlines()
    some = [line for line in lines if line.strip()][:400]
    if len(some) < 2:
        return None
    if sum(line.strip() == "---" for line in some) >= 2:
        return _documents(lines)
    if share(some, _PLOTTED.match) > 0.9:
        return _plotted(lines)
    middle = [x for x in some[len(some) // 4 :] if re.search(r"\d", x)]
    if not middle:
        return None
    for test, make in ((is_sentences, sentences), (_is_pairs, _pairs), (_is_prefixed, _prefixed)):
        if test(middle):
            table = make(lines)
            if table is not None:
                return table
    return None


#: A value on its own with its stamp in ms, as boards send it to a plotter: `>gx:1234:0.01`.
_PLOTTED = re.compile(rf"^>([^:|]+):(\d+(?:\.\d+)?):({NUMBER})(?:§(\S+?))?(?:\|\w*)?\s*$")


def _plotted(lines) -> Table | None:
    """Values that each come with their name and stamp: those of one stamp are a row."""
    rows: dict[str, tuple[dict[str, str], int]] = {}
    for number, line in enumerate(lines, 1):
        if m := _PLOTTED.match(line):
            name = f"{m[1].strip()} [{m[4]}]" if m[4] else m[1].strip()
            rows.setdefault(m[2], ({"time [ms]": m[2]}, number))[0][name] = m[3]
    if len(rows) < 2:
        return None
    keys = Counter(tuple(r) for r, _ in rows.values()).most_common(1)[0][0]
    kept = [([r[k] for k in keys], p) for r, p in rows.values() if set(keys) <= set(r)]
    return as_table(list(keys), kept, len(rows) - len(kept))


def _documents(lines) -> Table | None:
    """YAML documents set apart by `---`, as `ros2 topic echo` prints messages: nested keys become
    dotted names."""
    rows: list[tuple[dict[str, str], int]] = []
    row: dict[str, str] = {}
    above: list[tuple[int, str]] = []
    place = 1
    for number, line in enumerate([*lines, "---"], 1):
        if line.strip() == "---":
            if row:
                rows.append((row, place))
            row, above, place = {}, [], number + 1
            continue
        found = re.match(r"^(\s*)([A-Za-z_]\w*):\s*(.*)$", line)
        if not found:
            continue
        depth = len(found[1])
        above = [a for a in above if a[0] < depth]
        if found[3] == "":
            above.append((depth, found[2]))
        elif re.fullmatch(NUMBER, found[3]):
            row[".".join([*(k for _, k in above), found[2]])] = found[3]
    if len(rows) < 2:
        return None
    keys = Counter(tuple(r) for r, _ in rows).most_common(1)[0][0]
    kept = [([r[k] for k in keys], p) for r, p in rows if set(keys) <= set(r)]
    return as_table(list(keys), kept, len(rows) - len(kept))


def _is_prefixed(lines) -> bool:
    def arrow(line):
        if any(shape.match(line) for shape in LOGGERS.values()):
            return True
        m = PREFIX.match(line)
        if not m:
            return False
        apart = "," in line[m.end() :] and line[m.end() - 1] == " " and "-" in m[1]
        tokens = line[m.end() :].split()
        if len(tokens) > 2 and all(
            re.fullmatch(r"[+-]?\d+(?:,\d+)?(?:[eE][+-]?\d+)?", t) for t in tokens
        ):
            return False  # decimal commas, with blanks between the numbers
        return bool(m[2] in ("->", "=>", ">") or line.lstrip()[0] in "[(" or apart)

    return share(lines, arrow) > 0.6


def _is_pairs(lines) -> bool:
    def labelled(line):
        rest = without_stamp(line)[1]
        found = len(_scan(rest))
        numbers = len(re.findall(rf"(?<![\w.+-]){NUMBER}(?![\w.])", rest))
        return found >= 1 and found >= 0.5 * numbers

    def stamped(line):  # a stamp on a line of its own, perhaps with a temperature
        stamp, rest = without_stamp(line)
        return bool(stamp) and len(re.findall(NUMBER, rest)) < 2 and not _scan(rest)

    rest = [line for line in lines if not stamped(line)]
    return len(rest) > 0.5 * len(lines) and share(rest, labelled) > 0.8


def _prefixed(lines) -> Table | None:
    """A clock and an arrow before the values."""
    rows, places = [], []
    tokens = None
    for number, line in enumerate(lines, 1):
        stamp, rest = without_stamp(line)
        found = re.findall(rf"(?<![\w.])({NUMBER})(?![\w.:])", rest)
        if not stamp or not found:
            continue
        rows.append([stamp, *found])
        places.append(number)
    if len(rows) < 2:
        return None
    tokens = Counter(len(r) for r in rows).most_common(1)[0][0]
    kept = [(r, p) for r, p in zip(rows, places) if len(r) == tokens]
    lost = len(rows) - len(kept)
    header = None
    for line in lines[: kept[0][1] - 1]:
        words = [w.strip() for w in re.split(r"[,;\t]", without_stamp(line)[1].strip())]
        if len(words) == tokens - 1 and all(re.match(r"[^\W\d]", w) for w in words):
            header = [stamp_head(lines[kept[0][1] - 1]), *words]
    return as_table(header, kept, lost)


def _scan(line: str) -> list[tuple[str, str]]:
    """(label, value) of each labelled number of a line; a label before several numbers is numbered
    by axes, a bare Y or Z belongs to the sensor named before it, and a unit after a value belongs
    to every value of its label.
    """
    if not re.search(r"[=:\[]", line):  # gx 0.1 gy 0.2
        pairs = re.findall(rf"([^\W\d]\w*)[ \t]+({NUMBER})(?![\w.])", line)
        three = _THREE.match(line)  # accel 0.1 0.2 9.8 m/s/s
        if three and names.meaning(f"{three[1]} x").quantity:
            unit = f" [{three[5]}]" if three[5] and names.unit_of(three[5]) else ""
            return [(f"{three[1]} {a}{unit}", three[i]) for i, a in enumerate("xyz", 2)]
        return [tuple(p) for p in pairs] if len(pairs) > 2 else []
    out: list[list[str]] = []
    at, sensor = 0, ""
    while True:
        label = _LABEL.search(line, at)
        if not label:
            break
        name = " ".join(label[1].split()).strip("{}[]()<>,;| ")
        name = name.rpartition("(")[2] if ")" not in label[1] else name  # IMU(GyroX: 0.1
        if line.lstrip().startswith("<"):
            name = name.split()[-1]  # an attribute of an element
        at = label.end()
        values = []
        while value := _VALUE.match(line, at):
            values.append(value[1])
            at = value.end()
            follow = re.match(r"\s*[,;/\t ]\s*(?=\s*[+-]?[\d.])", line[at:])
            if not follow:
                break
            at += follow.end()
        if not values:
            if re.fullmatch(r"[A-Za-z][\w ]*", name) and label[0].rstrip().endswith(":"):
                sensor = name  # Gyro: x=0.1 y=0.2 z=0.3
            continue
        unit = ""
        word = re.match(
            r"\s*[\])}]?\s*([A-Za-z°µ][\w°/^²*-]*(?:\s?s\^?-?[12])?)(?!\s*\w*\s*[=:])", line[at:]
        )
        abuts = re.match(r"[\])}]?([A-Za-zµ°][^\s,;=:]*)(?=\s|$)", line[at:])
        if abuts and names.unit_of(abuts[1]) and not (word and names.unit_of(word[1])):
            word = abuts  # 12us a=...: what touches the number is its unit
        if word and names.unit_of(word[1]):
            unit = f" [{word[1]}]"
            at += word.end()
        bare = re.fullmatch(r"[xyzXYZ]", name)
        if bare and sensor:
            name = f"{sensor} {name}"
        else:
            split = re.match(r"^(.*\S)[ _]+[xX]$", name)
            sensor = split[1] if split else ""
        if len(values) == 1:
            out.append([name + unit, values[0], sensor])
        else:
            group = _GROUPS.get(name.lower(), "").split()
            axes = (
                [f"{name} {a}" for a in "xyz"]
                if len(values) == 3
                else [f"{name} #{i + 1}" for i in range(len(values))]
            )
            heads = group if len(group) == len(values) else axes
            out.extend([h + unit, v, name] for h, v in zip(heads, values))
        if unit and sensor:  # the unit after Z is that of X and Y too
            for entry in out:
                if entry[2] == sensor and "[" not in entry[0]:
                    entry[0] += unit
    return [(a, b) for a, b, _ in out]


def _pairs(lines) -> Table | None:
    """name = value pairs, all of a sample in one line or spread over several."""
    blocks: list[tuple[dict[str, str], int]] = []
    block: dict[str, str] = {}
    place, alone = 0, None
    for number, line in enumerate(lines, 1):
        stamp, rest = without_stamp(line)
        found = _scan(rest)
        if not found:
            alone = (stamp, line) if stamp else alone  # a stamp on a line of its own
            continue
        if found[0][0] in block:
            blocks.append((block, place))
            block = {}
        if not block:
            place = number
            if not stamp and alone:
                stamp, line = alone
            if stamp:
                block[stamp_head(line)] = stamp
            alone = None
        block.update(found)
    if block:
        blocks.append((block, place))
    if len(blocks) < 2:
        return None
    shape = Counter(tuple(b) for b, _ in blocks).most_common(1)[0]
    keys = shape[0]
    if len(keys) < 2 or shape[1] < 0.5 * len(blocks):
        return None
    kept = [([b[k] for k in keys], p) for b, p in blocks if set(keys) <= set(b)]
    return as_table(list(keys), kept, len(blocks) - len(kept))
