"""Missing samples."""

from __future__ import annotations

import numpy as np

from imu_lib import timing
from imu_lib.processes import TimeGaps as Process
from imu_lib.record import Record

from .base import Effect, Finding


class TimeGaps(Effect):
    name = "time_gaps"
    cause = (
        "Samples are lost between the sensor and the file: a full buffer, a busy host, a "
        "broken transmission."
    )
    domain = "timing"

    def detect(self, record: Record) -> Finding | None:
        slots = record.slots()
        holes = np.diff(slots) - 1
        holes = holes[holes > 0]
        empty = np.all([np.isnan(x) for x in record.channels.values()], axis=0)
        start, stop = timing.runs(empty)
        holes = np.concatenate([holes, stop - start])
        missing = int(holes.sum())
        if missing == 0:
            return None
        total = int(slots[-1]) + 1
        fraction = missing / total
        spread = 1.96 * np.sqrt(np.sum(holes.astype(float) ** 2)) / missing
        return Finding(
            self,
            Process(fraction=fraction, length=int(max(1, np.median(holes)))),
            None,
            f"timing: {len(holes)} gaps, {missing} of {total} samples missing, the longest gap "
            f"{int(holes.max())} samples",
            {
                "fraction": [fraction * max(0.0, 1 - spread), fraction * (1 + spread)],
                "length": [float(holes.min()), float(holes.max())],
            },
        )
