"""What deserves attention, in sentences: the faults with their times and what they mean, then the
units and the length.
"""

from __future__ import annotations

import numpy as np

from imu_lib import units
from imu_lib.faults.finding import seconds

#: Faults of one kind told one by one; more are summed up.
MOST = 5
#: Samples below which no noise is characterised.
FEW = 100
#: Share by which the specific force at rest may be off gravity.
GRAVITY = 0.03


def sentences(record, clock, channels, motion, temperature, faults):
    """Sentences, in the order of causes: data, clock, what happened, sensor, units, length."""
    yield from _faults(faults)
    if clock.repeats:
        yield f"{clock.repeats:,} time stamps repeat the one before."
    for name, c in channels.items():
        factor, unit = (units.DEG_PER_S, "deg/s") if name.startswith("gyro") else (units.G, "g")
        if c.saturated:
            yield (
                f"{name} piles up at an end of its range ({c.saturated:,} samples at "
                f"{c.low / factor:.4g} or {c.high / factor:.4g} {unit}): clipped."
            )
        if c.resolution and 0 < c.sd < c.resolution:
            yield (
                f"{name} has output steps of {c.resolution / factor:.3g} {unit}, coarser than its "
                f"scatter of {c.sd / factor:.3g} {unit}: rounding hides the noise."
            )
    yield from _motion(record, clock, motion, faults)
    yield from _units(record, channels, motion)
    moves = temperature is not None and temperature["high"] - temperature["low"] > 3
    if moves and not any(f.kind == "warm_up" for f in faults):
        yield (
            f"The temperature moves by {temperature['high'] - temperature['low']:.3g} degC: part "
            "of the drift may follow it."
        )
    if record.n < FEW:
        yield (
            f"The record has {record.n} samples; at least {FEW} are needed to characterise its "
            "noise."
        )
    if clock.duration < 600:
        yield (
            f"The record lasts {clock.duration:.4g} s: bias instability and slower errors need "
            "hours."
        )


def _faults(faults):
    """Each with what it means; the meaning once a kind."""
    kinds: dict[str, list] = {}
    for f in faults:
        kinds.setdefault(f.kind, []).append(f)
    for kind, items in kinds.items():
        shown = items if len(items) <= MOST else _largest(items)
        for i, f in enumerate(shown):
            last = i == len(shown) - 1 and len(shown) == len(items)
            means = f" {f.means}" if f.means and (last or f.means != shown[-1].means) else ""
            yield f.sentence + means
        if len(items) > len(shown):
            rest = [f for f in items if f not in shown]
            total = sum(f.stop - f.start for f in rest)
            yield (
                f"{len(rest)} more of the kind {kind} between {seconds(rest[0].start)} and "
                f"{seconds(rest[-1].stop)} s, {total:.3g} s together (--json lists them). "
                + rest[0].means
            )


def _largest(items):
    """The MOST items that matter most, in the order of time."""

    def size(f):
        return max(
            (v for v in f.evidence.values() if isinstance(v, (int, float))),
            default=f.stop - f.start,
        )

    return sorted(sorted(items, key=size)[-MOST:], key=lambda f: f.start)


def _motion(record, clock, motion, faults):
    if motion.state in ("moving", "partly moving"):
        yield (
            f"The sensor is {motion.state} ({100 * motion.moving_share:.2g} % of the seconds): "
            "noise can be taken from its standstills only."
        )
    elif motion.shaking_share > 0.01:
        yield (
            f"In {100 * motion.shaking_share:.2g} % of the seconds it is shaken harder than in the "
            "quiet ones: a machine, a building; that is no noise of the sensor."
        )
    whole = motion.rest_start <= 0 and motion.rest_stop >= clock.duration - 1e-9
    if not whole:
        yield (
            "The longest stretch with nothing of this in it: "
            f"--start {seconds(motion.rest_start)} --stop {seconds(motion.rest_stop)} "
            f"({units.duration(motion.rest_stop - motion.rest_start)} of "
            f"{units.duration(clock.duration)})."
        )


def _units(record, channels, motion):
    gyros = [c.noise for n, c in channels.items() if n.startswith("gyro") and c.noise > 0]
    accels = [c.noise for n, c in channels.items() if n.startswith("accel") and c.noise > 0]
    whole = all(f"accel_{a}" in record for a in "xyz")
    if motion.gravity is None and accels and whole:
        yield "The accelerometers show no gravity: it was taken out, or the record is simulated."
    if motion.gravity is not None and motion.state in ("at rest", "touched", "moved"):
        off = motion.gravity / units.G - 1
        if abs(off) > GRAVITY:
            yield (
                f"The specific force at rest is {motion.gravity:.4g} m/s^2, {100 * abs(off):.2g} % "
                f"{'above' if off > 0 else 'below'} gravity: a scale factor, a bias, or a unit "
                "that is not what it is said to be (`imu-lib calibrate` tells the first two)."
            )
    if gyros and accels and not 0.3 < np.median(accels) / np.median(gyros) < 250:
        yield (
            f"Gyro and accelerometer noise ({np.median(gyros) / units.DEG_PER_SQRT_HOUR:.2g} "
            f"deg/sqrt(h), {np.median(accels) / units.MPS_PER_SQRT_HOUR:.2g} m/s/sqrt(h)) rarely "
            "go together in one sensor: check both units."
        )
