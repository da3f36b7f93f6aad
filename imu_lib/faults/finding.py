"""What a detector says: which fault, where, how large, from what evidence, and what it means."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

#: Kinds that end a sound stretch. All others are masked within one, or only told.
BREAKS = ("disturbance", "tilt", "restart", "gap")
#: Kinds that an engineer wants to be told of but that are no fault of the data.
TOLD = ("time_grid", "jitter", "warm_up", "rate", "burst")


@dataclass(frozen=True, eq=False)
class Finding:
    """One fault or disturbance.

    Attributes
    ----------
    kind : str
        `dropout`, `held`, `stuck`, `constant`, `gap`, `burst`, `time_grid`, `jitter`,
        `disturbance`, `tilt`, `restart`, `warm_up`, `rate`, `copied` or `dead_zone`.
    channels : tuple of str
    start, stop : float
        First moment touched and the first sound one after the last, s from the first sample.
    parameters : dict
        Under the names of the error-model file, SI.
    evidence : dict
        The figures that it rests on (name -> number).
    sentence : str
        What it is, with its times.
    means : str
        What it does to what follows.
    rows : ndarray, shape (k,), int
        Samples touched; empty where no sample is wrong.
    """

    kind: str
    channels: tuple[str, ...]
    start: float
    stop: float
    parameters: dict[str, Any]
    evidence: dict[str, Any]
    sentence: str
    means: str = ""
    rows: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64), repr=False)

    def to_json(self) -> dict[str, Any]:
        """All but the rows, of which the number is told."""
        return {
            "kind": self.kind,
            "channels": list(self.channels),
            "start": self.start,
            "stop": self.stop,
            "parameters": self.parameters,
            "evidence": self.evidence,
            "samples": len(self.rows),
            "sentence": self.sentence,
            "means": self.means,
        }


def named(channels: tuple[str, ...]) -> str:
    """Channels in words: `all channels`, `gyros`, `accelerometers`, or their names."""
    got = set(channels)
    gyros, accels = ({f"{kind}_{a}" for a in "xyz"} for kind in ("gyro", "accel"))
    if got == gyros | accels:
        return "all channels"
    if got == gyros:
        return "the gyros"
    if got == accels:
        return "the accelerometers"
    return ", ".join(channels)


def seconds(t: float) -> str:
    """A moment as `--start` takes it back: milliseconds are kept."""
    return f"{t:.3f}".rstrip("0").rstrip(".") if abs(t) < 1e5 else f"{t:.7g}"
