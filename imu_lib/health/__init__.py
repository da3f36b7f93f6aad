"""Is a record sound? Its data, its clock, its channels, its units, whether the sensor was at rest,
its temperature.

`of_record` and `of_drive` look; nothing is changed. What deserves attention is a sentence in
`findings`; `faults` has each fault with its times and parameters.
"""

from __future__ import annotations

from .channels import resolution
from .drive import of_drive
from .long import of_long
from .record import of_record
from .result import Channel, Clock, Health, Motion

__all__ = ["Channel", "Clock", "Health", "Motion", "of_drive", "of_long", "of_record", "resolution"]
