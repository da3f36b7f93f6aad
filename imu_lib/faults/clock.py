"""What the time stamps tell: holes, bursts, the clock's own grain, jitter, a rate off its
nominal.
"""

from __future__ import annotations

import numpy as np

from imu_lib import timing
from imu_lib.faults.finding import Finding, seconds
from imu_lib.record import Record

#: A hole longer than this many seconds, and than this many samples, ends a sound stretch.
LONG_HOLE, LONG_SAMPLES = 1.0, 20
#: Holes told one by one; the rest is summed up.
MOST_TOLD = 5
#: Share of a sampling interval from which on grain and jitter of the stamps are told.
GRAIN, JITTER = 0.05, 0.1
#: Blocks of the stamps in which their distance is looked at, on each side of a change at the least;
#: share by which it changes, and scatter over which it is clear.
CLOCK_BLOCKS, LEVEL, LEAST_CHANGE, CLEAR = 200, 10, 2e-3, 8.0
#: Largest deviation from a usual output data rate that is an oscillator's, and the least told.
OSCILLATOR, LEAST_OFF = 0.03, 2e-3


def find(record: Record) -> list[Finding]:
    """Findings on the clock of a record; none where it has no stamps."""
    if record.time is None:
        return []
    time = record.times()
    regular = timing.bursts(time)
    found = [] if regular is None else [_burst(regular, time)]
    found += _gaps(record, regular) + _begun_anew(record, time)
    grain = grain_of(time)
    interval = 1.0 / record.rate
    if grain is not None and grain > GRAIN * interval:
        found.append(_grain(grain, time, record.rate))
    elif regular is None:
        found += _jitter(record, time)
    if regular is None:
        changed = rate_change(time)
        found += _rate(record, time) if changed is None else [_changed(changed, time)]
    return found


def _burst(regular: timing.Bursts, time) -> Finding:
    share = regular.size / (regular.rate * regular.period)
    return Finding(
        "burst",
        (),
        float(time[0]),
        float(time[-1]),
        {"size": regular.size, "rate": regular.rate, "period": regular.period},
        {"share_recorded": share},
        f"The rows come in bursts of {regular.size} at {regular.rate:.4g} Hz, "
        f"{1 / regular.period:.3g} bursts a second.",
        f"Of the samples at {regular.rate:.4g} Hz, {100 * share:.3g} % are there; the rest is "
        "missing, not jitter. Slow errors are seen as ever, lines above half the rate of the "
        "bursts only within them.",
    )


def _gaps(record: Record, regular) -> list[Finding]:
    gaps = record.gaps()
    if regular is not None:  # what lies between two bursts is no hole
        gaps = tuple(g for g in gaps if g.duration > 1.6 * regular.period)
    gaps = sorted(gaps, key=lambda g: -g.duration)
    found = []
    for gap in gaps[:MOST_TOLD]:
        found.append(
            Finding(
                "gap",
                (),
                gap.start,
                gap.start + gap.duration,
                {"missing": gap.missing},
                {"duration": gap.duration},
                f"{gap.missing:,} sample{'s are' if gap.missing > 1 else ' is'} missing from "
                f"{seconds(gap.start)} s on, for {gap.duration:.4g} s.",
                "A hole ends a stretch: what drifted or turned within it is not known."
                if long_hole(gap.duration, gap.missing)
                else "Short holes are bridged where a method needs it.",
            )
        )
    if len(gaps) > MOST_TOLD:
        rest = gaps[MOST_TOLD:]
        found.append(
            Finding(
                "gap",
                (),
                min(g.start for g in rest),
                max(g.start + g.duration for g in rest),
                {"missing": sum(g.missing for g in rest), "gaps": len(rest)},
                {"duration": rest[0].duration},
                f"{len(rest):,} more gaps, {sum(g.missing for g in rest):,} samples, the longest "
                f"{rest[0].duration:.4g} s.",
                "Short holes are bridged where a method needs it.",
            )
        )
    return found


def _begun_anew(record: Record, time) -> list[Finding]:
    return [
        Finding(
            "gap",
            (),
            float(time[k - 1]),
            float(time[k]),
            {"begun_anew": True},
            {},
            f"The logger began anew at {seconds(float(time[k]))} s of what was read; how long it "
            "paused before is not known.",
            "A stretch ends there: what drifted or turned in the pause is not known.",
        )
        for k in record.seams
    ]


def long_hole(duration: float, missing: int) -> bool:
    """Whether a hole of `duration` s and `missing` samples ends a sound stretch."""
    return duration > LONG_HOLE and missing > LONG_SAMPLES


def holes(record: Record) -> list[tuple[float, float]]:
    """Start and stop of every hole that ends a sound stretch, s."""
    if record.time is None:
        return []
    time = record.times()
    return sorted(
        [(g.start, g.start + g.duration) for g in record.gaps() if long_hole(g.duration, g.missing)]
        + [(float(time[k - 1]), float(time[k])) for k in record.seams]
    )


def grain_of(time: np.ndarray) -> float | None:
    """Step of the clock that the stamps are multiples of, s; None where it is finer than a
    five-hundredth of their usual distance.
    """
    step = np.diff(time)[:100_000]
    usual = float(np.median(step))
    if usual <= 0:
        return None
    for power in range(0, -7, -1):
        for mantissa in (5.0, 2.0, 1.0):
            grain = mantissa * 10.0**power
            if grain > 2.2 * usual:
                continue
            if grain < usual / 500:
                return None
            if np.mean(np.abs(step / grain - np.rint(step / grain)) < 1e-3) > 0.999:
                # steps that are all alike are an even grid and tell no grain
                kinds, count = np.unique(np.rint(step / grain), return_counts=True)
                return grain if (count > 0.002 * len(step)).sum() > 1 else None
    return None


def _grain(grain, time, rate) -> Finding:
    return Finding(
        "time_grid",
        (),
        float(time[0]),
        float(time[-1]),
        {"step": grain},
        {"share_of_interval": grain * rate},
        f"The stamps are whole multiples of {grain * 1e3:.4g} ms, "
        f"{100 * grain * rate:.3g} % of the sampling interval.",
        "Their unevenness is the clock's grain, not jitter of the samples; the rate is taken from "
        "all of them together.",
    )


def _jitter(record: Record, time) -> list[Finding]:
    sd = jitter_of(record)
    if sd is None or sd * record.rate < JITTER:
        return []
    host = timing.in_bursts(record.time)
    return [
        Finding(
            "jitter",
            (),
            float(time[0]),
            float(time[-1]),
            {"sd": sd},
            {"share_of_interval": sd * record.rate},
            f"The host stamped the samples in bursts; losses shorter than its delays (about "
            f"{3 * sd:.2g} s) cannot be seen."
            if host
            else f"The stamps jitter by {sd * 1e3:.3g} ms, {100 * sd * record.rate:.2g} % of the "
            "sampling interval.",
            "The samples are taken as even at the mean rate.",
        )
    ]


def jitter_of(record: Record) -> float | None:
    """Standard deviation of a stamp about the even grid, s; None without stamps."""
    if record.time is None:
        return None
    slots = record.slots()
    late = record.times() - slots / record.rate
    # slow drift of the clock is no jitter: the scatter of neighbours' steps about the even ones
    step = np.diff(late)[np.diff(slots) == 1]
    return float(np.std(step) / np.sqrt(2)) if step.size else 0.0


def rate_change(time: np.ndarray) -> tuple[float, float, float] | None:
    """(s of the moment, Hz before, Hz after) where the distance of the stamps `time`, shape (n,),
    changes once for good; None where it keeps, or wanders.
    """
    size = len(time) // CLOCK_BLOCKS
    if size < 8:
        return None
    step = np.diff(time)[: size * CLOCK_BLOCKS]
    step = np.median(step[: len(step) // size * size].reshape(-1, size), axis=1)
    k = np.arange(LEVEL, len(step) - LEVEL)
    total = np.cumsum(step)
    before, after = total[k - 1] / k, (total[-1] - total[k - 1]) / (len(step) - k)
    best = int(np.argmax((before - after) ** 2 * k * (len(step) - k)))
    at = k[best]
    a, b = (float(np.median(part)) for part in (step[:at], step[at:]))
    rest = np.r_[step[:at] - a, step[at:] - b]
    usual = 1.4826 * float(np.median(np.abs(rest)))
    if min(a, b) <= 0 or abs(a / b - 1) < LEAST_CHANGE or abs(a - b) < CLEAR * usual:
        return None
    if np.mean(np.abs(rest) > 0.5 * abs(a - b)) > 0.05:
        return None
    return float(time[at * size]), 1.0 / a, 1.0 / b


def _changed(found: tuple[float, float, float], time: np.ndarray) -> Finding:
    at, before, after = found
    return Finding(
        "rate",
        (),
        at,
        float(time[-1]),
        {"rate": after, "nominal": before, "ratio": after / before},
        {"before": before, "after": after},
        f"The rate changes at {seconds(at)} s from {before:.5g} to {after:.5g} Hz.",
        "No one rate holds for the whole record: look at its parts by themselves (--start, "
        "--stop).",
    )


def _rate(record: Record, time) -> list[Finding]:
    """The rate that the stamps tell against the nearest that makers offer."""
    usual = [r for r in timing.USUAL_RATES if r >= 10.0]
    near = min(usual, key=lambda r: abs(r / record.rate - 1))
    ratio = record.rate / near
    span = time[-1] - time[0]
    if not LEAST_OFF < abs(ratio - 1) < OSCILLATOR or span * abs(ratio - 1) < 0.05:
        return []
    return [
        Finding(
            "rate",
            (),
            float(time[0]),
            float(time[-1]),
            {"rate": record.rate, "nominal": near, "ratio": ratio},
            {"seconds_off": span * abs(ratio - 1)},
            f"The stamps tell {record.rate:.6g} Hz, {100 * abs(ratio - 1):.2g} % "
            f"{'above' if ratio > 1 else 'below'} the {near:g} Hz that such sensors are set to.",
            "The rate of the stamps is used; a nominal one would be off by as much in every "
            "frequency and time.",
        )
    ]
