"""What the workflow found: a report for each channel and one for the record."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from imu_lib.ensembles import ensemble
from imu_lib.gap.absent import Absent
from imu_lib.gap.channel import ChannelResult
from imu_lib.gap.sentences.summary import sentences
from imu_lib.gap.steps import Step
from imu_lib.long_record.record import LongRecord
from imu_lib.model import Model
from imu_lib.record import Record


@dataclass(frozen=True)
class ChannelReport:
    """A channel's result with its gap: whole, held out, by domain."""

    result: ChannelResult
    before: ensemble.Index | None = None
    after: ensemble.Index | None = None
    held_out: dict[str, float] | None = None
    batteries: dict[str, Any] = field(default_factory=dict)

    def to_json(self) -> dict[str, Any]:
        r = self.result
        by_domain = {}
        if self.before is not None and self.after is not None:
            by_domain = {
                d: {"before": round(v, 3), "after": round(self.after.domains[d], 3)}
                for d, v in self.before.domains.items()
            }
        before, after = (
            None if index is None else round(index.value, 4) for index in (self.before, self.after)
        )
        return {
            "gap_before": before,
            "gap_after": after,
            "gap_held_out": self.held_out,
            "gap_by_domain": by_domain,
            "steps": [s.to_json() for s in r.steps],
            "absorbed": list(r.absorbed),
            "unexplained": r.unexplained,
            "small_departures": list(r.small),
        }


@dataclass(frozen=True)
class Report:
    """What the workflow found: a report for each channel, the record's own steps, the model it
    started from and the grown one.
    """

    channels: dict[str, ChannelReport]
    record_steps: list[Step]
    record_unexplained: str | None
    base: Model
    model: Model
    record: Record | LongRecord
    seconds: float
    given: bool
    notes: tuple[str, ...] = ()
    #: The stretch of the record that was looked at, s from its first sample; None: all of it.
    stretch: tuple[float, float] | None = None
    #: The other stretches without a tilt, a restart or a long hole, s, the longest first.
    others: tuple[tuple[float, float], ...] = ()
    #: Length of the whole record, s; None: that of the stretch.
    whole: float | None = None
    #: Effects that nothing in the record tells of: {"effect", "parameter", "why"} each.
    invisible: tuple[dict[str, str], ...] = ()
    #: What the given model has and the record has not; the grown model is without it.
    absent: tuple[Absent, ...] = ()
    #: Where the file has no number, in sentences.
    lost: tuple[str, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """The contract's object."""
        return {
            "channels": {name: c.to_json() for name, c in self.channels.items()},
            "record": {
                "steps": [s.to_json() for s in self.record_steps],
                "unexplained": self.record_unexplained,
                "notes": list(self.notes),
                "invisible": list(self.invisible),
                "absent": [a.to_json() for a in self.absent],
            },
            "verdict": sentences(self),
            "seconds": round(self.seconds, 2),
        }

    @property
    def steps(self) -> list[tuple[str, Step]]:
        """(channel or "record", step) of everything found."""
        return [(name, s) for name, c in self.channels.items() for s in c.result.steps] + [
            ("record", s) for s in self.record_steps
        ]
