"""Cells that hold more, or other, than one decimal number: lists of three, numbers with their unit,
hexadecimal counts; and tables with one reading a row under the channel's name.
They are rewritten as a plain table of one number a cell.
"""

from __future__ import annotations

import csv
import io
import re
from collections import Counter

from imu_lib.readers import names
from imu_lib.readers.lines import NUMBER, Table

_LIST = re.compile(rf"^\s*[\[({{]\s*({NUMBER}(?:[\s,;]+{NUMBER})+)\s*[\])}}]\s*$")
#: An object that is printed with its fields: Vector3(x=0.1, y=0.2, z=0.3).
_FIELD = rf"\w+\s*[=:]\s*{NUMBER}"
_OBJECT = re.compile(rf"^[\w./ ]*[({{]\s*({_FIELD}(?:[,;\s]+{_FIELD})*)\s*[)}}]$")
_HEX = re.compile(r"^0[xX]([0-9A-Fa-f]{2,8})$")
_UNIT = re.compile(rf"^({NUMBER})\s*([A-Za-zµ°%][^\d]*(?:[/^²* -]\S*)*)$")
_LABELS = ("field", "channel", "signal", "variable", "channelname", "signalname")
SOME = 60  # rows that are looked at first


def plain(text: str) -> Table | None:
    """A text with such cells as a plain table, None where it has none."""
    sample = text[:40_000]
    if not re.search(
        r"[\[({]\s*(?:\w+[=:]\s*)?[+-]?[\d.]|0x[0-9A-Fa-f]{2}|[\d.]\s?[a-zµ°]", sample
    ):
        return _long(text, sample)
    blank = (" ",) if re.search(r"0x[0-9A-Fa-f]+ +-?0x", sample) else ()
    for delimiter in (";", "\t", "|", ",", *blank):
        head = _rows("\n".join(sample.split("\n")[:SOME]), delimiter)
        width = Counter(len(r) for r, _ in head).most_common(1)[0][0] if head else 0
        if width < 2:
            continue
        body = [r for r, _ in head if len(r) == width][1:]
        how = [_kind([r[i] for r in body]) for i in range(width)]
        if how.count("unit") == 1 and sum(h is not None for h in how) == 1:
            cell = next(r[how.index("unit")] for r in body if r[how.index("unit")])
            if names.unit_of(_UNIT.match(cell)[2]) not in names.TIME_UNITS:
                continue
            return _rewritten(_rows(text, delimiter), width, how)
        if {"list", "object"} & set(how) or sum(h is not None for h in how) > 1:
            return _rewritten(_rows(text, delimiter), width, how)
    return _long(text, sample) or _tuples(text, sample)


def objects(text: str) -> Table | None:
    """A text with objects in quotes that are printed with their fields as a plain table, None where
    it has none.
    """
    quoted = re.search(rf'"[\w./ ]*[({{]\s*{_FIELD}[^"\n]*[)}}]"', text[:8000])
    return plain(text) if quoted else None


def _tuples(text: str, sample: str) -> Table | None:
    """Numbers with brackets and commas around and between them, and nothing else: a plain table."""
    lines = [x for x in sample.splitlines()[:SOME] if x.strip()]
    if len(lines) < 8 or not all(re.search(r"[(\[{]\s*[+-]?[\d.]", x) for x in lines[1:]):
        return None
    rows, places = [], []
    for number, line in enumerate(text.splitlines(), 1):
        found = re.split(r"[\s,;()\[\]{}]+", line.strip("()[]{},; \t"))
        if found != [""] and all(re.fullmatch(NUMBER, f) for f in found):
            rows.append(found)
            places.append(number)
    width = Counter(len(r) for r in rows).most_common(1)[0][0] if rows else 0
    if width < 3 or any(len(r) != width for r in rows) or len(rows) < 0.9 * text.count("\n"):
        return None
    return Table("\n".join("\t".join(r) for r in rows) + "\n", places)


def _rows(text: str, delimiter: str) -> list[tuple[list[str], int]]:
    """(fields, line from 1) of the rows; brackets and quotes hold their delimiters."""
    if delimiter == "," and not re.search(r'"[\[({]', text[:4000]):
        # commas inside brackets set no fields apart
        text = re.sub(r"[\[({][^\])}\n]*[\])}]", lambda m: m[0].replace(",", " "), text)
    out = []
    for number, line in enumerate(text.splitlines(), 1):
        if line.strip() and not line.lstrip().startswith(("#", "%", "//")):
            found = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])
            out.append(([f.strip() for f in found], number))
    return out


def _kind(column: list[str]) -> str | None:
    """What the cells of a column are: list, object, hex, unit; None where plain."""
    there = [c for c in column if c]
    if len(there) < 2:
        return None
    if sum(bool(_LIST.match(c)) for c in there) > 0.9 * len(there):
        return "list"
    for shape, word in ((_OBJECT, "object"), (_HEX, "hex")):
        if sum(bool(shape.match(c)) for c in there) > 0.9 * len(there):
            return word
    units = [m[2] for c in there if (m := _UNIT.match(c)) and names.unit_of(m[2])]
    if len(units) > 0.9 * len(there) and len(set(units)) == 1:
        return "unit"
    return None


def _rewritten(rows, width: int, how: list[str | None]) -> Table | None:
    """The table with one plain number a cell, lists as columns of their own."""
    rows = [r for r in rows if len(r[0]) == width]
    heads = []
    while rows and not any(_numeric(f) for f in rows[0][0]):
        heads.append(rows.pop(0)[0])
    if len(rows) < 2:
        return None
    first = rows[0][0]
    size = [
        len(_cell(c, h, 0) or [""]) if h in ("list", "object") else 1 for c, h in zip(first, how)
    ]
    out, places, lost = [], [], 0
    for fields, line in rows:
        flat: list[str] = []
        for cell, h, k in zip(fields, how, size):
            new = _cell(cell, h, k)
            if new is None:
                break
            flat += new
        else:
            out.append(flat)
            places.append(line)
            continue
        lost += 1
    if len(out) < 2:
        return None
    notes: tuple[str, ...] = ()
    if "hex" in how:
        notes += ("Hexadecimal cells were read as whole numbers with a sign (two's complement).",)
    if lost:
        notes += (f"{lost:,} lines of another shape were left out.",)
    text = "\n".join("\t".join(r) for r in out) + "\n"
    for line_ in reversed(heads):
        names_: list[str] = []
        for name, cell, h, k in zip(line_, first, how, size):
            unit = f" [{_UNIT.match(cell)[2]}]" if h == "unit" and _UNIT.match(cell) else ""
            axes = "xyz" if k == 3 else [f"#{i + 1}" for i in range(k)]
            axes = re.findall(r"(\w+)\s*[=:]", cell) if h == "object" else axes
            names_ += [f"{name} {a}" for a in axes] if k > 1 else [name + unit]
        text = "\t".join(n.replace("\t", " ") for n in names_) + "\n" + text
    return Table(text, places, notes)


def _numeric(cell: str) -> bool:
    return bool(re.match(rf"^\"?{NUMBER}", cell) or _LIST.match(cell) or _HEX.match(cell))


def _cell(cell: str, how: str | None, size: int) -> list[str] | None:
    """The numbers of a cell; None where it is of another shape."""
    if how is None or cell == "":
        return [cell] * size
    if how in ("list", "object"):
        m = (_LIST if how == "list" else _OBJECT).match(cell)
        inner = re.sub(r"\w+\s*[=:]", " ", m[1]) if m and how == "object" else m[1] if m else ""
        found = re.sub("[,;]", " ", inner).split()
        return found if len(found) == size or not size else None
    if how == "hex":
        m = _HEX.match(cell)
        if not m:
            return None
        bits = 4 * len(m[1])
        value = int(m[1], 16)
        return [str(value - (1 << bits) if value >> (bits - 1) else value)]
    m = _UNIT.match(cell)
    return [m[1]] if m else None


def _long(text: str, sample: str) -> Table | None:
    """A table of (time, channel, value), a row for each reading, with a column for each channel;
    None where it is none.
    """
    lines = [x for x in sample.splitlines() if x.strip() and not x.startswith(("#", "%"))]
    if len(lines) < 8:
        return None
    delimiter = next((d for d in ("\t", ";", ",") if d in lines[0] and d in lines[-2]), None)
    if delimiter is None:
        return None
    head = [h.strip().strip('"').lstrip("_") for h in lines[0].split(delimiter)]
    body = [[f.strip().strip('"') for f in x.split(delimiter)] for x in lines[1:-1]]
    if not 3 <= len(head) <= 12 or any(len(r) != len(head) for r in body[:SOME]):
        return None
    label = next(
        (
            i
            for i, h in enumerate(head)
            if _channels({r[i] for r in body[:SOME]}) >= (1 if h.lower() in _LABELS else 3)
        ),
        None,
    )
    value = next(
        (i for i, h in enumerate(head) if re.fullmatch(r"(?i)values?|val|reading|data|wert|y", h)),
        None,
    )
    stamp = next(
        (
            i
            for i, h in enumerate(head)
            if i not in (label, value)
            and names.meaning(h).quantity in ("time", "date", "clock", "counter")
        ),
        None,
    )
    if label is None or value is None or stamp is None:
        return None
    import pandas as pd

    try:
        frame = pd.read_csv(
            io.StringIO(text), sep=delimiter, dtype=str, comment="#", skipinitialspace=True
        )
    except (pd.errors.ParserError, ValueError):
        return None
    if len(frame.columns) != len(head):
        return None
    frame.columns = range(len(head))
    frame = frame.dropna(subset=[stamp, label, value])
    frame["order"] = pd.factorize(frame[stamp])[0]
    if frame.duplicated(["order", label]).any():
        return None
    wide = frame.pivot(index="order", columns=label, values=value)
    stamps = frame.drop_duplicates("order").set_index("order")[stamp]
    table = wide.assign(**{"\0": stamps}).fillna("")
    columns = ["\0", *[c for c in table.columns if c != "\0"]]
    rows = "\n".join("\t".join(r) for r in table[columns].itertuples(index=False, name=None))
    heads = "\t".join([head[stamp], *(str(c).strip() for c in columns[1:])])
    places = [int(i) + 2 for i in frame.drop_duplicates("order").index]
    return Table(
        f"{heads}\n{rows}\n", places, ("One reading a row: each channel became a column.",)
    )


def _channels(labels: set[str]) -> int:
    """How many of the labels name a channel of an inertial sensor."""
    if len(labels) > 40:
        return 0
    found = [names.meaning(x) for x in labels if re.match(r"[^\W\d]", x)]
    return sum(1 for m in found if m.quantity in names.SIGNALS and m.axis)
