"""Lines in which words stand between the numbers, as serial monitors and sentence loggers write
them, into a plain table.

`14:05:00.000 -> 0.1,0.2`, `aX = -65 | aY = 183`, `a/g: 1 2 3 4 5 6`, `Accel X: 0.1, Y: 0.2, Z: 9.8
m/s^2`, `{"t": 1, "gx": 2}`, `$VNIMU,...*5B`: what the words say becomes the header.
"""

from __future__ import annotations

import re
from collections import Counter

from imu_lib.readers import documents, scan
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


def unfold(text: str) -> Table | None:
    """A labelled text as a plain table; None where the lines are none or are plain already."""
    lines = text.splitlines()
    some = [line for line in lines if line.strip()][:400]
    if len(some) < 2:
        return None
    table = documents.unfold(lines, some)
    if table is not None:
        return table
    middle = [x for x in some[len(some) // 4 :] if re.search(r"\d", x)]
    if not middle:
        return None
    for test, make in ((is_sentences, sentences), (_is_pairs, _pairs), (_is_prefixed, _prefixed)):
        if test(middle):
            table = make(lines)
            if table is not None:
                return table
    return None


def _is_prefixed(lines) -> bool:
    def arrow(line):
        if any(shape.match(line) for shape in LOGGERS.values()):
            return True
        m = PREFIX.match(line)
        if not m or re.match(r"[A-Z]{3,4}[,;\t]", line[m.end() :]):
            return False  # the name of a zone ends a field
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
        found = len(scan.labelled(rest))
        numbers = len(re.findall(rf"(?<![\w.+-]){NUMBER}(?![\w.])", rest))
        return found >= 1 and found >= 0.5 * numbers

    def stamped(line):  # a stamp on a line of its own, perhaps with a temperature
        stamp, rest = without_stamp(line)
        return bool(stamp) and len(re.findall(NUMBER, rest)) < 2 and not scan.labelled(rest)

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


def _pairs(lines) -> Table | None:
    """name = value pairs, all of a sample in one line or spread over several."""
    blocks: list[tuple[dict[str, str], int]] = []
    block: dict[str, str] = {}
    place, alone = 0, None
    for number, line in enumerate(lines, 1):
        stamp, rest = without_stamp(line)
        found = scan.labelled(rest)
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
