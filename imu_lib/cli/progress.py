"""Progress on standard error: a bar on a terminal, a line now and then in a file."""

from __future__ import annotations

import sys
import time


class Lines:
    """Progress where standard error is no terminal: a line at the start, one now and then, one at
    the end. It has what is used of tqdm: iteration, `update`, `close`.
    """

    EVERY = 10.0  # s between lines

    def __init__(self, iterable=None, about: str = "", total: int | None = None):
        self.iterable, self.about, self.n = iterable, about or "working", 0
        self.total = total if total is not None else getattr(iterable, "__len__", lambda: None)()
        self.began = self.told = time.monotonic()
        self._tell()

    def _tell(self, end: str = "") -> None:
        of = f" of {self.total:,}" if self.total else ""
        print(f"{self.about}: {self.n:,}{of}{end}", file=sys.stderr, flush=True)
        self.told = time.monotonic()

    def update(self, n: int = 1) -> None:
        self.n += n
        if time.monotonic() - self.told > self.EVERY:
            self._tell()

    def close(self) -> None:
        took = time.monotonic() - self.began
        if self.n and took > 1.0:
            self._tell(f", {took:.0f} s")
        self.n = 0

    def __iter__(self):
        for item in self.iterable:
            yield item
            self.update()
        self.close()


def progress(iterable=None, *, about: str = "", total: int | None = None):
    """Progress on standard error: tqdm's bar on a terminal, a line now and then in a file."""
    from tqdm import tqdm

    if not sys.stderr.isatty():
        return Lines(iterable, about, total)
    return tqdm(iterable, desc=about, total=total, file=sys.stderr, leave=False)


class Share:
    """Progress of what is told as a share; nothing is shown until the first is."""

    def __init__(self, about: str):
        self.about, self.bar, self.done = about, None, 0

    def at(self, share: float) -> None:
        if self.bar is None:
            self.bar = progress(about=self.about, total=100)
        self.bar.update(round(100 * share) - self.done)
        self.done = round(100 * share)

    def close(self) -> None:
        if self.bar is not None:
            self.bar.close()
