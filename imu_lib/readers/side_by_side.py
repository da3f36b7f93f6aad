"""Two streams of one sensor on one time base."""

from __future__ import annotations

import numpy as np

from imu_lib import timing
from imu_lib.errors import InputError
from imu_lib.record import Record


def merge(
    gyro: Record,
    gyro_start: float | None,
    accel: Record,
    accel_start: float | None,
    *,
    one_file: bool = False,
) -> Record:
    """Two streams of one sensor on one time base.

    Where both tell a time of one clock they are laid over each other by it, else from their first
    samples. Streams of nearly one rate are paired, each sample with the nearest of the other within
    half a sample, without interpolation, which would smooth the noise; a slower stream stands in
    some of the rows of the faster one, and the others are empty (NaN).
    """
    source = gyro.source if one_file else f"{gyro.source} and {accel.source}"
    shift = 0.0
    both = (("gyro", gyro), ("accelerometer", accel))
    notes = tuple(f"{word}: {n}" for word, one in both for n in one.notes)
    if gyro_start is not None and accel_start is not None:
        shift = accel_start - gyro_start
        if shift >= gyro.duration or -shift >= accel.duration:
            notes += (
                f"The two files do not overlap in time ({accel.source} begins {shift:.6g} s after "
                f"{gyro.source}); they are laid side by side from their first samples, so nothing "
                "common to gyros and accelerometers can be seen.",
            )
            shift = 0.0
    ratio = gyro.rate / accel.rate
    t = {"gyro": gyro.times(), "accel": accel.times() + shift}
    if not 0.98 < ratio < 1.02:
        return _slower(gyro, accel, t, source, notes)
    left, right = _partners(gyro, accel, t, shift, one_file)
    if abs(ratio - 1) > 1e-3:
        notes += (
            f"The gyro has {gyro.rate:.6g} Hz and the accelerometer {accel.rate:.6g} Hz: each "
            "sample goes with the nearest one of the other by its stamp, "
            "within half a sample.",
        )
    if len(left) < 2:
        raise InputError(
            f"{source} have no two samples in common; read them one at a time (--gyro FILE, then "
            "--accel FILE)."
        )
    lost = max(gyro.n, accel.n) - len(left)
    if lost:
        notes += (
            f"{lost:,} samples of the longer stream have no partner in the other and were left "
            "out.",
        )
    apart = float(np.median(t["accel"][right] - t["gyro"][left]))
    if one_file and abs(apart) * gyro.rate > 0.02:
        notes += (
            f"The accelerometer's samples come {abs(apart) * 1e3:.4g} ms "
            f"{'after' if apart > 0 else 'before'} the gyro's with which they are paired.",
        )
    channels = {c: x[left] for c, x in gyro.channels.items()} | {
        c: x[right] for c, x in accel.channels.items()
    }
    even = gyro.time is None and len(left) == left[-1] - left[0] + 1
    time = None if even else t["gyro"][left] - t["gyro"][left[0]]
    temperature = None if gyro.temperature is None else gyro.temperature[left]
    if temperature is None and accel.temperature is not None:
        temperature = accel.temperature[right]
    return Record(channels, gyro.rate, time, temperature, gyro.name, source, notes)


def _partners(gyro, accel, t, shift: float, one_file: bool) -> tuple[np.ndarray, np.ndarray]:
    """Indices of the samples of two streams of nearly one rate that go together."""
    apart = abs(gyro.rate / accel.rate - 1)
    if gyro.time is None and accel.time is None and shift == 0.0 and apart < 1e-9:
        every = np.arange(min(gyro.n, accel.n))
        return every, every
    if shift == 0.0 and not one_file and apart < 1e-3:
        # files whose clocks have nothing in common: their jitter says nothing of each other's
        _, left, right = np.intersect1d(gyro.slots(), accel.slots(), return_indices=True)
        return left, right
    return _pairs(t["gyro"], t["accel"], 0.55 / min(gyro.rate, accel.rate))


def _pairs(a: np.ndarray, b: np.ndarray, most: float) -> tuple[np.ndarray, np.ndarray]:
    """Indices of the samples of two rising time series that are each other's nearest, at most
    `most` s apart.
    """
    # where one comes a fixed part of a sample after the other, that part is taken out first: half a
    # sample apart, the nearest one would be a matter of rounding
    step = float(np.median(np.diff(a)))
    phase = np.exp(
        2j * np.pi * (b[np.clip(np.searchsorted(b, a), 0, len(b) - 1)] - a) / step
    ).mean()
    apart = float(np.angle(phase)) / (2 * np.pi) * step if abs(phase) > 0.9 else 0.0
    apart = abs(apart) if abs(abs(apart) - 0.5 * step) < 0.02 * step else apart
    b = b - apart
    to_b = _nearest(a, b)
    to_a = _nearest(b, a)
    left = np.arange(len(a))
    mutual = (to_a[to_b] == left) & (np.abs(b[to_b] - a) <= most)
    return left[mutual], to_b[mutual]


def _nearest(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    at = np.clip(np.searchsorted(b, a), 1, len(b) - 1)
    return at - (a - b[at - 1] < b[at] - a)


def _slower(gyro, accel, t, source, notes) -> Record:
    """The slower stream in the rows of the faster one."""
    fast, slow = (gyro, accel) if gyro.rate > accel.rate else (accel, gyro)
    key = ("gyro", "accel") if fast is gyro else ("accel", "gyro")
    at, of = _pairs(t[key[0]], t[key[1]], 0.55 / fast.rate)
    if len(at) < 20:
        raise InputError(
            f"{source}: the gyro has {gyro.rate:.6g} Hz and the accelerometer {accel.rate:.6g} Hz, "
            "and their stamps do not meet; read them one at a time with --only gyro and --only "
            "accel."
        )
    channels = dict(fast.channels)
    for c, x in slow.channels.items():
        channels[c] = np.full(fast.n, np.nan)
        channels[c][at] = x[of]
    word = {"gyro": "gyro", "accel": "accelerometer"}[key[1]]
    notes += (
        f"The {word} comes at {slow.rate:.6g} Hz in rows of {fast.rate:.6g} Hz: its samples stand "
        f"in {len(at):,} of {fast.n:,} rows, the others are empty; "
        f"--only {key[1]} reads it at its own rate.",
    )
    return Record(channels, fast.rate, fast.time, fast.temperature, fast.name, source, notes)


def slow_kind(record: Record) -> str | None:
    """The kind (gyro or accel) whose samples stand only in some rows of a record because it comes
    at a lower rate, None where there is none.
    """
    share = {}
    for kind in ("gyro", "accel"):
        axes = [x for c, x in record.channels.items() if c.startswith(kind)]
        if not axes:
            return None
        empty = np.logical_and.reduce([np.isnan(x) for x in axes])
        rows = np.flatnonzero(~empty)
        share[kind] = empty.mean()
        if share[kind] > 0.3 and len(rows) > 20:
            step = np.diff(rows)
            if (np.abs(step - np.median(step)) <= 1).mean() > 0.9:
                return kind
    return None


def own_rates(record: Record) -> dict[str, Record]:
    """Gyro and accelerometer of a record in which one comes at a lower rate, each at its own."""
    slow = slow_kind(record)
    if slow is None:
        return {}
    out = {}
    for kind in ("gyro", "accel"):
        channels = {c: x for c, x in record.channels.items() if c.startswith(kind)}
        rows = np.arange(record.n)
        if kind == slow:
            rows = np.flatnonzero(~np.logical_and.reduce([np.isnan(x) for x in channels.values()]))
        t = record.times()[rows]
        rate = record.rate if kind != slow else timing.measured_rate(t)
        even = np.abs((t - t[0]) * rate - np.arange(len(t))).max() < 1e-2
        out[kind] = Record(
            {c: x[rows] for c, x in channels.items()},
            rate,
            None if even else t - t[0],
            None if record.temperature is None else record.temperature[rows],
            record.name,
            record.source,
            record.notes,
        )
    return out
