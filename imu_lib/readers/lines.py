"""Lines of a log with a stamp before them, and the plain table that they become."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"


PREFIX = re.compile(
    r"^\s*[\[(]?\s*((?:\d{4}[-/.]\d{1,2}[-/.]\d{1,2}[T "
    r"]\s*)?\d{1,2}:\d{2}:\d{2}(?!\.\d+,\d{3}\])(?:[.,]\d+)?(?:\s*[AP]M)?)\s*[\])]?\s*(->|=>|>|\||"
    r":)?\s*",
    re.IGNORECASE,
)


#: Stamps that loggers of systems put before a line, by the heading that says what they are.
LOGGERS = {
    "time [ms]": re.compile(r"^\s*[IWDEV] \((\d+)\) [\w.-]+:\s*"),  # ESP-IDF
    # ROS
    "time [s]": re.compile(r"^\s*\[\s*(?:DEBUG|INFO|WARN|"
                           r"ERROR)\s*\]\s*\[(\d+\.\d+)\](?:\s*\[[\w./-]+\])?:\s*"),
    # Android
    "clock": re.compile(r"^\s*(?:\d{4}-)?\d{2}-\d{2}\s+(\d{2}:\d{2}:\d{2}[.,]\d+)\s+\d+\s+\d+\s+[VDIWEF]\s+[^:]{1,40}:\s*"),
    # Zephyr
    "clock ": re.compile(r"^\s*\[(\d{2}:\d{2}:\d{2}\.\d{3},\d{3})\]\s*(?:<\w+>\s*)?(?:[\w.-]+:\s*)?"),
    "clock  ": re.compile(r"^\s*\[\w{3} \w{3} +\d{1,2} (\d{2}:\d{2}:\d{2}(?:\.\d+)?) \d{4}\]\s*"),
    # a kernel's messages
    "time [s]  ": re.compile(r"^\s*\[\s*(\d+\.\d{3,9})\]\s*(?:[\w.-]+:\s*)?"),
    "time [s]   ": re.compile(r"^\s*(\d+\.\d+) ?s(?:ec)?\s*[:,]\s+"),
    "time [ms] ": re.compile(r"^\s*(\d+) ?ms\s*[:,]\s+"),
    "time [s] ": re.compile(r"^\s*\((\d{9,10}\.\d+)\)\s+"),  # candump and the like
}  # fmt: skip


@dataclass(frozen=True)
class Table:
    """text: a plain table with its header, tab-separated. lines: the line of the file, from 1, of
    each row. notes: what was left out."""

    text: str
    lines: list[int]
    notes: tuple[str, ...] = ()


def share(lines: Sequence[str], test: Callable[[str], object]) -> float:
    return sum(1 for line in lines if test(line)) / len(lines)


def without_stamp(line: str) -> tuple[str, str]:
    m = PREFIX.match(line)
    if m:
        return m[1].strip(), line[m.end() :]
    for shape in LOGGERS.values():
        if m := shape.match(line):
            return m[1].replace(",", "") if "." in m[1] else m[1], line[m.end() :]
    return "", line


def stamp_head(line: str) -> str:
    """What the stamp before a line is called: a clock, or the time of a logger that counts."""
    if PREFIX.match(line):
        return "clock"
    return next((head for head, shape in LOGGERS.items() if shape.match(line)), "clock")


def as_table(
    header: Sequence[str] | None, kept: Sequence[tuple[list[str], int]], lost: int
) -> Table | None:
    if len(kept) < 2:
        return None
    text = "\n".join("\t".join(r) for r, _ in kept) + "\n"
    if header:
        text = "\t".join(h.replace("\t", " ") for h in header) + "\n" + text
    notes = (f"{lost:,} lines of another shape were left out.",) if lost else ()
    return Table(text, [p for _, p in kept], notes)
