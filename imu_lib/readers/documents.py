"""Messages printed as blocks of lines: YAML set apart by `---`, text of protocol buffers in braces,
values that each come with their name and stamp.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator

from imu_lib.readers.lines import NUMBER, Table, as_table

#: A value on its own with its stamp in ms, as boards send it to a plotter: `>gx:1234:0.01`.
PLOTTED = re.compile(rf"^>([^:|]+):(\d+(?:\.\d+)?):({NUMBER})(?:§(\S+?))?(?:\|\w*)?\s*$")
_OPENS = re.compile(r"^\s*([A-Za-z_]\w*)\s*:?\s*\{\s*$")
_FIELD = re.compile(r"^\s*([A-Za-z_]\w*)\s*:\s*(\S.*?)\s*$")
_LEAST = 3  # messages


def unfold(lines: list[str], some: list[str]) -> Table | None:
    """Such a text as a table; None where it is none. `some`: its first lines that are not empty."""
    if sum(line.strip() == "---" for line in some) >= 2:
        return _table(_yaml(lines))
    if sum(bool(PLOTTED.match(line)) for line in some) > 0.9 * len(some):
        return _plotted(lines)
    if sum(bool(_OPENS.match(line)) for line in some) >= _LEAST:
        if all(_OPENS.match(x) or _FIELD.match(x) or x.strip() in ("}", "---") for x in some):
            return _table(_braced(lines), left_out="0")
    return None


def _plotted(lines: list[str]) -> Table | None:
    """Values that each come with their name and stamp: those of one stamp are a row."""
    rows: dict[str, tuple[dict[str, str], int]] = {}
    for number, line in enumerate(lines, 1):
        if m := PLOTTED.match(line):
            name = f"{m[1].strip()} [{m[4]}]" if m[4] else m[1].strip()
            rows.setdefault(m[2], ({"time [ms]": m[2]}, number))[0][name] = m[3]
    return _table(iter(rows.values()))


def _yaml(lines: list[str]) -> Iterator[tuple[dict[str, str], int]]:
    """Messages as `ros2 topic echo` prints them: nested keys become dotted names."""
    row: dict[str, str] = {}
    above: list[tuple[int, str]] = []
    place = 1
    for number, line in enumerate([*lines, "---"], 1):
        if line.strip() == "---":
            if row:
                yield row, place
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


def _braced(lines: list[str]) -> Iterator[tuple[dict[str, str], int]]:
    """Messages in braces, one after the other: a key that comes again begins the next one."""
    row: dict[str, str] = {}
    above: list[str] = []
    seen: set[str] = set()
    place = 1
    for number, line in enumerate(lines, 1):
        if opens := _OPENS.match(line):
            if not above and opens[1] in seen:
                yield row, place
                row, seen, place = {}, set(), number
            if not above:
                seen.add(opens[1])
            above.append(opens[1])
        elif line.strip() == "}":
            above = above[:-1]
        elif (found := _FIELD.match(line)) and re.fullmatch(NUMBER, found[2]):
            row[".".join([*above, found[1]])] = found[2]
    if row:
        yield row, place


def _table(
    messages: Iterator[tuple[dict[str, str], int]], left_out: str | None = None
) -> Table | None:
    """Messages as rows, with the fields that most of them have. One that lacks a field is left
    out, or has `left_out` there: a protocol buffer does not print what is zero.
    """
    rows = list(messages)
    if len(rows) < 2:
        return None
    count = Counter(k for r, _ in rows for k in r)
    keys = [k for k in max((r for r, _ in rows), key=len) if count[k] > 0.5 * len(rows)]
    whole = [
        ([r.get(k, left_out) for k in keys], p)
        for r, p in rows
        if left_out is not None or all(k in r for k in keys)
    ]
    return as_table(keys, whole, len(rows) - len(whole))
