"""Finished cases, one a line of a file of JSON: a run that finds the file goes on from there."""

from __future__ import annotations

import json
from pathlib import Path


class Log:
    """The cases of a file (None: of this run alone), those that it holds already first.

    rows : list of dict
    """

    def __init__(self, path: str | None) -> None:
        self.path = Path(path) if path else None
        there = self.path is not None and self.path.exists()
        self.rows = [json.loads(r) for r in self.path.read_text().splitlines()] if there else []

    def add(self, *rows: dict) -> None:
        """Cases that have ended: they are on disk when it returns."""
        self.rows += rows
        if self.path:
            with self.path.open("a") as handle:
                handle.writelines(json.dumps(row, default=float) + "\n" for row in rows)
