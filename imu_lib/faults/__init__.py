"""What is wrong with the data of a record, and what happened to the sensor while it was made.

    findings = faults.find(record)       # drop-outs, copies, clock, knocks, tilts, restarts
    faults.longest_stretch(record, findings)   # (start, stop) in s
    faults.sound(record, findings).record      # masked and cut: what an estimator may be given

Each detector is a file; each finding carries its kind, its times, its parameters under the names of
the error-model file, the figures it rests on, and a sentence.
"""

from __future__ import annotations

from .clock import find as of_clock
from .finding import BREAKS, TOLD, Finding
from .search import find
from .soundness import Sound, breaks, longest_stretch, sound

__all__ = [
    "BREAKS",
    "TOLD",
    "Finding",
    "Sound",
    "breaks",
    "find",
    "longest_stretch",
    "of_clock",
    "sound",
]
