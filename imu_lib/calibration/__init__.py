"""Calibration: bias, scale factor and cross-coupling of accelerometers and gyroscopes.

- `rest_windows`: when a record is at rest, by method;
- `from_reference`, `ferraris`: poses or rates that are known;
- `from_gravity`, `from_turns`: poses put down by hand, no turntable (Tedaldi et al. 2014);
- `rotation`, `line`, `repeatability`: the laboratory tests of the 2008 paper;
- `calibrate`: a whole record in one call;
- `simulated`: records with known truth.
"""

from . import simulated
from .gyro import from_turns, turns
from .poses import ferraris, from_gravity, from_reference, held_out
from .rest import RestWindows, moving_deviation, rest_windows
from .sections import Section, read_poses
from .table import (
    CALGARY,
    Line,
    Repeatability,
    averages,
    change,
    line,
    repeatability,
    rotation,
    steps,
    values,
)
from .triad import AXES, Triad, triad
from .whole import Calibration, calibrate, calibrate_record

__all__ = [
    "AXES",
    "CALGARY",
    "Calibration",
    "Line",
    "Repeatability",
    "RestWindows",
    "Section",
    "Triad",
    "averages",
    "calibrate",
    "calibrate_record",
    "change",
    "ferraris",
    "from_gravity",
    "from_reference",
    "from_turns",
    "held_out",
    "line",
    "moving_deviation",
    "read_poses",
    "repeatability",
    "rest_windows",
    "rotation",
    "simulated",
    "steps",
    "triad",
    "turns",
    "values",
]
