"""It was not warm yet: a temperature that still settles."""

from __future__ import annotations

import numpy as np

from imu_lib.faults.finding import Finding, seconds
from imu_lib.record import Record

#: degC that the temperature must move, and share of it that must come in the first half.
MOVES, EARLY = 1.0, 0.65
#: Blocks of the record that are looked at.
BLOCKS = 60


def find(record: Record) -> list[Finding]:
    """A warm-up that the record's temperature shows; none where it has none."""
    t = record.temperature
    if t is None or record.n < 10 * BLOCKS:
        return []
    k = record.n // BLOCKS
    with np.errstate(invalid="ignore"):
        means = np.nanmean(t[: k * BLOCKS].reshape(BLOCKS, k), axis=1)
    if not np.isfinite(means).all():
        return []
    total = means[-5:].mean() - means[0]
    if abs(total) < MOVES:
        return []
    done = (means - means[0]) / total
    # it goes one way, fast at first
    if done[BLOCKS // 2] < EARLY or np.mean(np.diff(done) > -0.02) < 0.8 or done.max() > 1.3:
        return []
    at = int(np.argmax(done > 0.9))
    time = record.times()
    stop = float(time[min(at * k, record.n - 1)])
    return [
        Finding(
            "warm_up",
            (),
            0.0,
            stop,
            {"amplitude": float(-total), "time_constant": stop / np.log(10.0)},
            {"degrees": float(total)},
            f"The sensor still {'warms' if total > 0 else 'cools'} by {abs(total):.3g} degC; nine "
            f"tenths of it are over at {seconds(stop)} s.",
            "Biases follow the temperature: for the noise alone, start there.",
        )
    ]
