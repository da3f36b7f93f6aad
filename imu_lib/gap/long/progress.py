"""What is told of the search of a long record while it goes on."""

from __future__ import annotations

from imu_lib.gap import loop


class Told:
    """Progress over the stages, in hundredths."""

    def __init__(self, progress: loop.Progress | None) -> None:
        self.progress = progress

    def at(self, done: int, text: str) -> None:
        if self.progress is not None:
            self.progress(done, 100, text)

    def of(self, stage: str, first: int, share: int, done: int, total: int, text: str) -> None:
        self.at(first + round(share * done / total), f"{stage}: {text}")
