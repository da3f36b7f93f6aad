"""The text of a file before it is a table: what is no text is left out, words between the numbers
become a header, what stands below the rows goes.
"""

from __future__ import annotations

import re

from imu_lib.readers import (
    cells,
    commas,
    encodings,
    fields,
    folded,
    labelled,
    restarts,
    tagged,
    thousands,
)
from imu_lib.readers.restarts import BEGINS

#: A single number in brackets between two delimiters.
_ACCOUNTS = re.compile(rb"(?<=[,;\t])\s*[(](\d[\d.,]*(?:[eE][+-]?\d+)?)[)]\s*(?=[,;\t\r\n])")
FEW = 4  # such numbers that may be anything


class Lines:
    """The text of a file: its bytes, and what a row of the table is called in a message."""

    def __init__(self, data: bytes, source: str):
        self.data, self.source = data, source
        self.places: list[int] | None = None  # lines of the file, where the text was rewritten
        self.notes: tuple[str, ...] = ()
        self.rate: float | None = None

    @classmethod
    def of(cls, data: bytes, source: str) -> Lines:
        """The bytes of a file without what is no text: a card's empty end, colours of a
        terminal.
        """
        wide = data[:2] in (b"\xff\xfe", b"\xfe\xff")
        filled = 0 if wide else len(data) - len(data.rstrip(b"\0"))
        if filled > 1:
            data = data[:-filled]  # a card's file that was made before it was written
        encoding = encodings.of(data, fields.HEAD)
        if encoding:
            data = data.decode(encoding, errors="replace").encode()
        if not wide:
            data = data.replace("\u2212".encode(), b"-")  # a typesetter's minus
            for c in "0123456789.,-+" if b"\xef\xbc" in data[:4096] else "":
                data = data.replace(chr(ord(c) + 0xFEE0).encode(), c.encode())  # full width
        if b"\x1b[" in data[:4096]:
            data = re.sub(rb"\x1b\[[0-9;]*[A-Za-z]", b"", data)
        if re.search(rb"\d\.\d*[dD][+-]\d\d", data[:4096]):  # Fortran's double precision
            data = re.sub(rb"(\d\.\d*)[dD]([+-]\d\d)", rb"\1E\2", data)
        if _ended(data):  # a mark behind every row, which sets no fields apart
            data = re.sub(rb";[ \t]*(?=\r?\n|$)", b"", data)
        if _glued(data):  # %10.5f of Fortran and C, without a blank before a minus
            data = re.sub(rb"(?<=[\d.])(-)(?=[\d.])", rb" \1", data)
        negative = 0 if wide else len(_ACCOUNTS.findall(data[: fields.HEAD]))
        if negative > FEW and not re.search(rb"[(]\s*[+-]", data[: fields.HEAD]):
            data = _ACCOUNTS.sub(rb"-\1", data)
        lines = cls(data, source)
        if negative > FEW:
            lines.notes += ("Numbers in brackets are negative ones, as sheets of accounts write.",)
        if filled > 1:
            lines.notes += (f"{filled:,} empty bytes behind the last line were left out.",)
        if encoding and encoding != "cp1252":
            name = encodings.CANDIDATES[encoding]
            lines.notes += (f"The text was read as {name}: its words are known so.",)
        elif not encoding and encodings.foreign(data, fields.HEAD):
            lines.notes += (
                "The text is no UTF-8 and none of its words tells its encoding: headings beyond "
                "ASCII were not understood; save it as UTF-8 where they name readings.",
            )
        lines._start_and_rate()
        if not wide and b"\0" not in data[: fields.HEAD]:
            lines._without_thousands(thousands.without(lines.data))
        return lines

    def without_thousands(self) -> bool:
        """Leave out marks between thousands of single numbers. Whether there were any."""
        return self._without_thousands(thousands.lone(self.data))

    def _without_thousands(self, found: tuple[bytes, str] | None) -> bool:
        if found is None:
            return False
        self.data, number = found
        self.notes += (f"Marks between thousands were left out, as in {number!r}.",)
        return True

    def _start_and_rate(self) -> None:
        """The start and the rate that stand above the readings, once in every column, as Empatica's
        wristbands write them.
        """
        rows = [r.split(b",") for r in self.data[:600].split(b"\n")[:4]]
        if len(rows) < 4 or len({len(r) for r in rows[:3]}) != 1:
            return
        try:
            start, rate, first = ([float(f) for f in r] for r in rows[:3])
        except ValueError:
            return
        same = all(len(set(r)) == 1 for r in (start, rate))
        if not same or not 9e8 < start[0] < 2.3e9 or not 0 < rate[0] <= 10_000 or first[0] > 9e8:
            return
        self.data = b"\n".join(self.data.split(b"\n")[2:])
        self.places = list(range(3, self.data.count(b"\n") + 4))
        self.rate = rate[0]
        self.notes += (
            f"The two rows above the readings are the start and the rate: {rate[0]:g} Hz.",
        )

    def head(self) -> tuple[bytes, bool]:
        return self.data[: fields.HEAD], len(self.data) <= fields.HEAD

    def unfold(self) -> None:
        """Words between the numbers become a header."""
        head, whole = self.head()
        text, encoding = fields.decode(head, self.source, whole)
        for how in (
            folded.unfold,
            lambda t: tagged.unfold(t, self.source),
            cells.objects,
            labelled.unfold,
            cells.plain,
            commas.joined,
        ):
            if how(text) is None:
                continue
            table = how(self.data.decode(encoding, errors="replace"))
            if table is not None:
                self.data, self.places = table.text.encode(), table.lines
                self.notes += table.notes
                return

    def without_words(self, layout) -> bool:
        """Leave out lines of words between the rows, as a logger's complaints are. Whether there
        were any; how many, and the first, are said.
        """
        if self.places is not None or layout.encoding == "utf-16":
            return False
        rows = self.data.split(b"\n")
        lost = [
            i
            for i in range(layout.first, len(rows))
            if rows[i].strip() and _complaint(rows[i], layout)
        ]
        if not lost or len(lost) > 0.5 * (len(rows) - layout.first):
            return False
        gone = set(lost)
        comment = tuple(c.encode() for c in fields.COMMENTS)
        self.places = [
            i + 1
            for i in range(layout.first, len(rows))
            if i not in gone and rows[i].strip() and not rows[i].lstrip().startswith(comment)
        ]
        self.data = b"\n".join(r for i, r in enumerate(rows) if i not in gone)
        first = rows[lost[0]].decode(layout.encoding, errors="replace").strip()[:40]
        self.notes += (
            f"{len(lost):,} line{'s' * (len(lost) > 1)} of words between the rows "
            f"{'were' if len(lost) > 1 else 'was'} left out (line {lost[0] + 1}: {first!r}); "
            "where each stands for a lost sample and the file has no stamps, the time is short by "
            "them.",
        )
        return True

    def _one_table(self, layout) -> None:
        """Leave out a second table, with a header of its own, that stands below the first."""
        at = self.data.find(b"\n\n") if b"\r\n\r\n" not in self.data else -1
        at = self.data.find(b"\r\n\r\n") if at < 0 else at
        named = {n for n in layout.header or () if n}
        rows = self.data.split(b"\n") if at >= 0 and len(named) > 3 else []
        for i in range(layout.first + 2, len(rows) - 1):
            if rows[i].strip() or BEGINS.match(rows[i + 1]) or not rows[i + 1].strip():
                continue
            heads = []
            for r in rows[i + 1 : i + 7]:
                if BEGINS.match(r) and b"," in r:
                    break
                heads.append([f for f in layout.split(r.decode(layout.encoding, "replace")) if f])
            texts = [h for h in heads if all(fields.kind(f) == "text" for f in h)]
            other = [h for h in texts if len(h) > 2 and set(h) != named]
            if other and not any(set(h) == named for h in heads) and len(heads) < 6:
                said = rows[i + 1].decode(layout.encoding, "replace").strip()[:40]
                self.data = b"\n".join(rows[:i]) + b"\n"
                self.notes += (f"Below line {i + 1} stands another table ({said!r}), left out.",)
                return

    def trim(self, layout) -> bool:
        """Leave out what a logger writes between and below the rows: its header again, and words
        at the end. Whether anything was left out.
        """
        if self.places is not None or layout.encoding == "utf-16":
            return False
        self._one_table(layout)
        tail = self.data[-4096:].rstrip().split(b"\n")
        words = next((k for k, r in enumerate(reversed(tail)) if not _words(r, layout)), 0)
        top = self.data[: fields.HEAD].split(b"\n")[: layout.first]
        heads = [r for r in reversed(top) if r.strip() and not BEGINS.match(r)]
        named = heads[0].strip() if layout.header and heads else b""
        below = sum(len(r) + 1 for r in top)
        cut = 0 if words else restarts.is_cut(tail, layout)
        if not words and not cut and not (named and self.data.find(named, below) >= 0):
            return False
        rows = self.data.rstrip().split(b"\n")
        first = layout.first - _without_remark(rows, layout)
        end = len(rows) - words - cut
        again = {i for i in range(layout.first, end) if named and rows[i].strip().endswith(named)}
        for i in sorted(again):  # with what stands above it: LabVIEW's heading of a block
            while not BEGINS.match(rows[i - 1]):
                i -= 1
                again.add(i)
        torn = restarts.torn(rows, again, named, layout)
        text = [i for i in range(layout.first, len(rows)) if i >= end and rows[i].strip()]
        if not again and not text:
            return False
        keep = [i for i in range(len(rows)) if i < end and i not in again | torn]
        self.data = b"\n".join(rows[i] for i in keep) + b"\n"
        comment = tuple(c.encode() for c in fields.COMMENTS)
        self.places = [
            i + 1
            for i in keep
            if i >= first and rows[i].strip() and not rows[i].lstrip().startswith(comment)
        ]
        if again:
            times = 1 + sum(rows[i].strip().endswith(named) for i in again)
            self.notes += (
                f"The header stands {times} times in the file (line {min(again) + 1} begins the "
                "second): sessions that were appended, or blocks.",
                *restarts.said(torn),
            )
        if cut:
            self.notes += (f"The last line ({len(rows)}) is cut off and was left out.",)
        elif text:
            self.notes += (
                f"{len(text)} line{'s' * (len(text) > 1)} of words at the end were left out.",
            )
        return True


def _without_remark(rows: list[bytes], layout) -> int:
    """1 where the row above the first was one with a remark behind it, as LabVIEW puts it there,
    which is taken off; else 0.
    """
    at = layout.first - 1
    found = layout.split(rows[at].decode(layout.encoding, "replace").strip("\r")) if at > 0 else []
    full = len(layout.kinds)
    if len(found) != full + 1 or fields.kind(found[-1]) != "text" or not BEGINS.match(rows[at]):
        return 0
    rows[at] = (layout.delimiter or " ").join(found[:-1]).encode()
    return 1


def _ended(data: bytes) -> bool:
    """Whether the rows of a table with commas end with a semicolon each."""
    rows = [r.strip() for r in data[:8192].split(b"\n")[:-1] if r.strip()][1:40]
    ended = [r.endswith(b";") and r.count(b";") == 1 and r.count(b",") > 1 for r in rows]
    return len(rows) > 3 and sum(ended) > 0.9 * len(rows)


def _words(line: bytes, layout) -> bool:
    """Whether a line below the rows is words: a remark, or statistics under a name of their own."""
    text = line.decode(layout.encoding, errors="replace").strip()
    if not text:
        return True
    found = layout.split(text)
    first = next((i for i, f in enumerate(found) if f), 0)
    if 2 * len(found) < len(layout.kinds) and not any(
        fields.kind(f, layout.decimal) == "number" for f in found
    ):
        return True
    other = first >= len(layout.kinds) or layout.kinds[first] not in ("text", "empty")
    return (
        other
        and fields.kind(found[first], layout.decimal) == "text"
        and re.search(r"[^\W\d_]{3}", found[first]) is not None
    )


def _complaint(line: bytes, layout) -> bool:
    """Whether a line between the rows is words and no part of a row."""
    text = line.decode(layout.encoding, errors="replace").strip()
    found = [f for f in layout.split(text) if f]
    if len(found) >= len(layout.kinds) and layout.delimiter is not None:
        return False
    numbers = sum(fields.kind(f, layout.decimal) == "number" for f in found)
    return numbers < 2 and re.search(r"[^\W\d_]{3}", text) is not None


def _glued(data: bytes) -> bool:
    """Whether numbers of a fixed width touch each other where one is negative."""
    rows = [r for r in data[:8192].split(b"\n")[8:-1] if r.strip()][:40]
    found = [len(re.findall(rb"\d\.\d+-\d", r)) for r in rows]
    if len(rows) < 4 or sum(map(bool, found)) < 2:
        return False
    if any(re.search(rb"[A-Za-z:,;]", r) for r in rows):
        return False
    apart = [len(re.sub(rb"(?<=[\d.])-(?=[\d.])", b" -", r).split()) for r in rows]
    return len(set(apart)) == 1
