"""What a name may say, before its neighbours and values are asked."""

from __future__ import annotations

from dataclasses import dataclass

UNKNOWN = "its name is not known here"


SIGNALS = ("gyro", "accel", "dtheta", "dv")
#: What a kind of reading is called in a sentence, and its increments.
WORD = {"gyro": "gyro", "dtheta": "gyro", "accel": "accelerometer", "dv": "accelerometer"}
INCREMENT = {"gyro": "dtheta", "accel": "dv"}


@dataclass(frozen=True)
class Meaning:
    """What a name says.

    quantity: gyro, accel, dtheta, dv, time, date, clock, counter, temperature or None. axis: x, y,
    z, a digit as a string, or None. unit: canonical, or as spelled where it is not known. rank: 0
    for what such a name usually heads, higher for a stand-in (arrival time, an uncalibrated
    reading). part: sec, nsec, year, hour ... of a stamp in several columns. why: the words that
    told, or why the column is not used.
    """

    quantity: str | None = None
    axis: str | None = None
    unit: str | None = None
    rank: int = 1
    part: str | None = None
    why: str = "its name says nothing that is known here"
    group: str = ""

    @property
    def canonical(self) -> str | None:
        if self.quantity in SIGNALS and self.axis:
            return f"{self.quantity}_{self.axis}"
        return self.quantity
