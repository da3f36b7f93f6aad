"""A sensor that travels: its motion would be described as its noise."""

from __future__ import annotations

from imu_lib.faults.motion import windows
from imu_lib.record import Record

#: How the sentence begins, whoever hands it on.
BEGINS = "The sensor moved or was shaken in"


def sentence(record: Record) -> str | None:
    """What is to be known before anything else of a record that was not at rest; else None."""
    seen = windows(dict(record.channels), record.rate, {})
    if not seen.travels:
        return None
    return (
        f"{BEGINS} {100 * seen.restless_share:.2g} % of the seconds: the values hold its motion "
        "besides its noise; `imu-lib check FILE` says when it was at rest."
    )
