"""Where simulation and measurement disagree: find it, name it, add it, show that the gap shrinks,
go on.

    found = gap.close(record, model)        # or gap.close(record): the base is fitted first
    found.steps                             # what is missing, by channel, with parameters, intervals, confidence
    found.model                             # the model that holds it

The order of the work: what the electronics did to single samples, changes of the noise level,
lines;
then all noises and drifts of the catalogue compete on one likelihood (`engine`), one is added at a
time (`rounds`), and what is left is tested (`verdict`). `ensemble` measures the gap before and
after.
"""

from __future__ import annotations

from .effects import CATALOGUE
from .ensemble import Index
from .found import ChannelReport, Report
from .loop import close
from .steps import Step

__all__ = ["CATALOGUE", "ChannelReport", "Index", "Report", "Step", "close"]
