"""Is a record sound? Its clock, its channels, its units, whether the sensor was at rest, its
temperature.

`of_record` and `of_drive` look; nothing is changed. What deserves attention is a sentence in
`findings`.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from imu_lib import timing, units
from imu_lib.drive import Drive
from imu_lib.readers import plausibility
from imu_lib.record import Record

WINDOW = 1.0  # s, the length of the windows in which rest is asked
TURNING = (
    # rad/s of a window's mean off the bias: more than any bias drifts within a record at rest
    0.02
)
TILTING = 0.15  # m/s^2 between neighbouring windows' means: 0.9 deg of tilt
SHAKING = 4.0  # times the scatter of the quietest fifth of the windows


@dataclass(frozen=True)
class Clock:
    """jitter: standard deviation of a stamp about the even grid, s (None without stamps). gaps:
    (start s, duration s, missing
    samples), longest first."""

    samples: int
    rate: float
    duration: float
    stamped: bool
    jitter: float | None
    bursts: bool
    repeats: int
    gaps: tuple[tuple[float, float, int], ...]
    gap_count: int
    missing: int


@dataclass(frozen=True)
class Channel:
    """One channel, SI. resolution: step of the output grid, None where none shows. saturated:
    samples at an end of the range
    where they pile up.
    frozen: samples in runs of one value longer than chance allows; longest_run in samples. noise:
    white-noise coefficient from
    neighbours' differences."""

    mean: float
    sd: float
    low: float
    high: float
    nan: int
    resolution: float | None
    saturated: int
    frozen: int
    longest_run: int
    noise: float


@dataclass(frozen=True)
class Motion:
    """state: at rest, moving, or partly moving. moving_share of the windows; rest_start,
    rest_stop: the longest stretch at rest, s.
    """

    state: str
    moving_share: float
    rest_start: float
    rest_stop: float
    gravity: float | None


@dataclass(frozen=True)
class Health:
    """What `check` says. gnss: of a drive. findings: sentences on what deserves attention; none
    for a sound record.
    """

    name: str
    source: str
    clock: Clock
    channels: dict[str, Channel]
    motion: Motion
    temperature: dict | None
    gnss: dict | None
    notes: tuple[str, ...]
    findings: tuple[str, ...]

    def to_json(self) -> dict:
        return asdict(self)


def of_record(record: Record, *, repeats: int = 0) -> Health:
    """The health of a record; `repeats` is how many time stamps repeated the one before when it
    was read.
    """
    clock = _clock(record, repeats)
    channels = {c: _channel(x, record.rate) for c, x in record.channels.items()}
    motion = _motion(record)
    temperature = _temperature(record)
    return Health(
        record.name,
        record.source,
        clock,
        channels,
        motion,
        temperature,
        None,
        record.notes,
        tuple(_findings(record, clock, channels, motion, temperature)),
    )


def of_drive(drive: Drive) -> Health:
    """The health of a drive: its IMU, its fixes, its reference."""
    imu = of_record(drive.imu())
    step = np.diff(drive.gnss_time)
    usual = float(np.median(step))
    gnss = {
        "fixes": len(drive.gnss_time),
        "rate": 1.0 / usual,
        "from": float(drive.gnss_time[0]),
        "to": float(drive.gnss_time[-1]),
        "gaps": [
            (float(drive.gnss_time[i]), float(step[i]))
            for i in np.argsort(-step)[:5]
            if step[i] > 1.5 * usual
        ],
        "velocity": drive.gnss_velocity is not None,
        "standard_deviations": drive.gnss_position_sd is not None,
        "reference": drive.has_reference,
        "lever_arm": None if drive.lever_arm is None else drive.lever_arm.tolist(),
        "max_speed": None
        if drive.gnss_velocity is None
        else float(np.nanmax(np.linalg.norm(drive.gnss_velocity[:, :2], axis=1))),
    }
    if drive.gnss_fix is not None:
        code, count = np.unique(drive.gnss_fix, return_counts=True)
        gnss["fix_codes"] = {f"{c:g}": int(n) for c, n in zip(code, count)}
    more = []
    if drive.gnss_time[0] > drive.time[-1] or drive.gnss_time[-1] < drive.time[0]:
        more.append("The fixes and the IMU do not overlap in time.")
    if gnss["gaps"]:
        more.append(
            f"{int((step > 1.5 * usual).sum())} gaps between fixes, the longest {float(step.max()):.3g} s."
        )
    if drive.gnss_velocity is None:
        more.append("The fixes have no velocity.")
    # a vehicle moves: that it is not at rest is no finding here
    keep = tuple(f for f in imu.findings if not f.startswith("The sensor"))
    return Health(
        drive.name,
        drive.source,
        imu.clock,
        imu.channels,
        imu.motion,
        imu.temperature,
        gnss,
        drive.notes + imu.notes,
        keep + tuple(more),
    )


def _clock(record: Record, repeats: int) -> Clock:
    gaps = record.gaps()
    jitter = None
    if record.time is not None:
        late = record.times() - record.slots() / record.rate
        # slow drift of the clock is no jitter: the scatter of neighbours' steps about the even
        # ones
        step = np.diff(late)[np.diff(record.slots()) == 1]
        jitter = float(np.std(step) / np.sqrt(2)) if step.size else 0.0
    return Clock(
        record.n,
        record.rate,
        record.duration,
        record.time is not None,
        jitter,
        record.time is not None and timing.in_bursts(record.time),
        repeats,
        tuple(tuple(g) for g in sorted(gaps, key=lambda g: -g.duration)[:10]),
        len(gaps),
        sum(g.missing for g in gaps),
    )


def resolution(x: np.ndarray) -> float | None:
    """Step of the grid that the values of `x` (n,) lie on, None where they lie on none."""
    x = x[:200_000]
    x = x[~np.isnan(x)]
    level, count = np.unique(x, return_counts=True)
    if len(level) < 2 or len(level) > 0.5 * len(x):
        return None
    often = level[count > 2]
    if len(often) > 1 and count[count > 2].sum() > 0.95 * len(x):
        level = often  # a few bridged or spiked samples off the grid are no finer grid
    step = np.diff(level)
    step = step[
        step > 2e-6 * max(abs(level[0]), abs(level[-1]), level[-1] - level[0])
    ]  # levels apart by float32 rounding are one
    if not step.size:
        return None
    unit = float(np.quantile(step, 0.02))
    times = np.rint(step / unit)
    if (np.abs(step / unit - times) < 0.1 * np.maximum(1, 0.1 * times)).mean() < 0.95:
        return None
    return float(step.sum() / times.sum())


def _channel(x: np.ndarray, rate: float) -> Channel:
    good = x[~np.isnan(x)]
    low, high = float(good.min()), float(good.max())
    saturated = 0
    if high > low:
        tiny = 1e-9 * max(abs(low), abs(high))
        for end, inner in ((high, good[good < high - tiny]), (low, good[good > low + tiny])):
            count = int((np.abs(good - end) <= tiny).sum())
            next_one = (inner.max() if end == high else inner.min()) if inner.size else end
            # noise thins out towards its extremes; a clipped signal piles up there
            if (
                inner.size
                and count >= 5
                and count > 2 * int((np.abs(good - next_one) <= tiny).sum())
            ):
                saturated += count
    frozen, longest = _frozen(x)
    return Channel(
        float(good.mean()),
        float(good.std()),
        low,
        high,
        int(np.isnan(x).sum()),
        resolution(x),
        saturated,
        frozen,
        longest,
        plausibility._noise_density(good[:, None], rate) if len(good) > 10 else 0.0,
    )


def _frozen(x: np.ndarray) -> tuple[int, int]:
    """(samples in runs of one value that chance does not make, longest run)."""
    change = np.flatnonzero(np.r_[True, np.diff(x) != 0, True])
    run = np.diff(change)
    longest = int(run.max())
    repeat = 1.0 - (len(run) - 1) / max(1, len(x) - 1)
    if len(run) == 1:
        return len(x), longest
    # longest run that independent samples of this share of repeats are to be expected to make,
    # five times over: coarse steps and
    # slow drift repeat more
    chance = np.log(len(x)) / -np.log(
        min(max(float(np.quantile(run, 0.9) > 1) * repeat, 1e-3), 0.9999)
    )
    least = max(5.0 * chance, 8.0)
    return int(run[run > least].sum()), longest


def windows(record: Record) -> tuple[np.ndarray, np.ndarray, int]:
    """Mean and standard deviation of every channel in windows of WINDOW s, shapes (channels,
    windows), and samples per window.
    """
    block = max(10, int(round(WINDOW * record.rate)))
    n = record.n // block
    if n == 0:
        block, n = record.n, 1
    x = np.stack([c[: n * block].reshape(n, block) for c in record.channels.values()])
    return x.mean(axis=2), x.std(axis=2), block


def _motion(record: Record) -> Motion:
    mean, sd, block = windows(record)
    n = mean.shape[1]
    known = np.isfinite(mean).all(axis=0)
    moving = np.zeros(n, dtype=bool)
    for row, name in enumerate(record.channels):
        m, s = mean[row], sd[row]
        if not known.any():
            break
        quiet = float(np.quantile(s[known], 0.2))
        step = 0.0 if (r := resolution(record.channels[name])) is None else r
        moving |= known & (s > SHAKING * quiet + step)
        if name.startswith("gyro"):
            still = known & (s <= np.quantile(s[known], 0.5))
            moving |= known & (
                np.abs(m - np.median(m[still])) > max(TURNING, 5 * quiet / np.sqrt(block))
            )
        else:
            jump = np.r_[0.0, np.abs(np.diff(m))]
            moving |= known & (np.nan_to_num(jump) > max(TILTING, 6 * quiet / np.sqrt(block)))
    share = float(moving[known].mean()) if known.any() else 0.0
    # a single window out of hundreds is a knock on the table, not a drive
    state = "at rest" if share <= 0.01 else "moving" if share > 0.5 else "partly moving"
    low, high = timing.longest_run(~moving & known, np.array([], dtype=int))
    accel = record["accel"] if all(f"accel_{a}" in record for a in "xyz") else None
    return Motion(
        state,
        share,
        low * block / record.rate,
        high * block / record.rate,
        None if accel is None else plausibility.gravity(accel),
    )


def _temperature(record: Record) -> dict | None:
    t = record.temperature
    if t is None:
        return None
    return {
        "low": float(np.nanmin(t)),
        "high": float(np.nanmax(t)),
        "first": float(t[0]),
        "last": float(t[-1]),
    }


def _findings(record, clock, channels, motion, temperature):
    """Sentences, most consequential first."""
    nan = sum(c.nan for c in channels.values())
    if clock.gap_count:
        longest = clock.gaps[0]
        yield (
            f"{clock.gap_count} gap{'s' if clock.gap_count > 1 else ''} in the time stamps, {clock.missing:,} samples missing; "
            f"the longest lasts {longest[1]:.4g} "
            f"s from {longest[0]:.6g} s on."
        )
    if nan:
        worst = max(channels, key=lambda c: channels[c].nan)
        yield f"{nan:,} values are missing (NaN), most in {worst} ({channels[worst].nan:,})."
    if clock.repeats:
        yield f"{clock.repeats:,} time stamps repeat the one before."
    if clock.bursts:
        yield f"The host stamped the samples in bursts; losses shorter than its delays (about {3 * clock.jitter:.2g} s) cannot be seen."
    elif clock.jitter is not None and clock.jitter * clock.rate > 0.1:
        yield f"The stamps jitter by {clock.jitter * 1e3:.3g} ms, {100 * clock.jitter * clock.rate:.2g} % of the sampling interval."
    for name, c in channels.items():
        if c.saturated:
            yield f"{name} piles up at an end of its range ({c.saturated:,} samples at {c.low:.4g} or {c.high:.4g}): clipped."
        if c.frozen:
            yield f"{name} repeats one value for up to {c.longest_run:,} samples ({c.frozen:,} in such runs): frozen output."
        if c.resolution and c.sd < c.resolution:
            factor, unit = (units.DEG_PER_S, "deg/s") if name.startswith("gyro") else (units.G, "g")
            yield (
                f"{name} has output steps of {c.resolution / factor:.3g} {unit}, coarser than its scatter of "
                f"{c.sd / factor:.3g} {unit}: rounding hides the noise."
            )
    if motion.state != "at rest":
        yield (
            f"The sensor is {motion.state} ({100 * motion.moving_share:.2g} % of the seconds); the longest stretch at rest runs from "
            f"{motion.rest_start:.6g} to {motion.rest_stop:.6g} s (--start, --stop)."
        )
    gyros = [c.noise for n, c in channels.items() if n.startswith("gyro") and c.noise > 0]
    accels = [c.noise for n, c in channels.items() if n.startswith("accel") and c.noise > 0]
    if motion.gravity is None and accels and all(f"accel_{a}" in record for a in "xyz"):
        yield "The accelerometers show no gravity: it was taken out, or the record is simulated."
    if gyros and accels and not 0.3 < np.median(accels) / np.median(gyros) < 250:
        yield (
            f"Gyro and accelerometer noise ({np.median(gyros) / units.DEG_PER_SQRT_HOUR:.2g} deg/sqrt(h), "
            f"{np.median(accels) / units.MPS_PER_SQRT_HOUR:.2g} m/s/sqrt(h)) "
            "rarely go together in one sensor: check both units."
        )
    if temperature and temperature["high"] - temperature["low"] > 3:
        yield f"The temperature moves by {temperature['high'] - temperature['low']:.3g} degC: part of the drift may follow it."
    if clock.duration < 600:
        yield f"The record lasts {clock.duration:.4g} s: bias instability and slower errors need hours."
