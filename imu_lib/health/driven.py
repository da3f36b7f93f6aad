"""What a drive says against itself: fixes, readings and reference held beside each other."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from imu_lib.drive import Drive
from imu_lib.health import fixes
from imu_lib.navigation import axes, earth, fix_faults, fix_frames, fix_motion, lateness, turns
from imu_lib.units import DEG

LATE = 0.25  # s
STEADY = 0.3  # s by which two halves of a drive may be late apart
HEAVY = 0.015  # of gravity: three standard deviations of a bias at switch-on
JUMP = 10.0  # m
TURNED = 20.0 * DEG  # a case that leans, or stands askew, by less is an ordinary one
FAR = 10.0  # m of a reference from the fixes


def disagreements(drive: Drive) -> list[str]:
    """Sentences, each with its remedy: wrong axes or units, late fixes, wrong gravity, a reference
    that jumps or lies elsewhere, standard deviations that are not true, velocities in another
    frame: without these the rest is looked at.
    """
    out, right = _put_right(drive)
    if right is None:
        return out
    clocks, late = _clocks(right), lateness.late(right)
    out += clocks or _time(right, late)
    return out + _turns(right, late[0]) + _weight(right) + _reference(drive) + fixes.scatter(right)


def frames(drive: Drive) -> tuple[list[str], Drive | None]:
    """What is said of axes, signs and clocks, and the drive with its axes put right; None where
    that cannot be done.
    """
    out, right = _put_right(drive)
    return out if right is None else out + _clocks(right), right


def _put_right(drive):
    out, drive = fixes.velocities(drive)
    if fix_frames.positions_swapped(drive):
        return [fixes.sentence(fix_frames.unusable(drive))], None
    held = fix_faults.held(drive)
    out += fixes.jumps(drive) + fixes.held(drive, held) + fixes.heights(drive)
    out += fixes.exact(drive)
    out += fixes.rounded(drive)
    drive = drive.with_fixes(~held)
    seen = turns.in_time(drive)
    if sensor := axes.reversed_sensor(seen):
        out.append(fixes.sentence(axes.REVERSED[sensor]))
        if sensor in ("either", "positions"):
            return out, None
        drive, seen = (d.with_(**{sensor: -getattr(d, sensor)}) for d in (drive, seen))
    permutation, _, _, gain, _ = axes.of(seen)
    if permutation != axes.IDENTITY:
        c = axes.to_body(permutation)
        drive, seen = (d.with_(gyro=d.gyro @ c.T, accel=d.accel @ c.T) for d in (drive, seen))
        out.append(
            "The axes are not forward, right, down: the fixes' accelerations and turns fit when x, "
            f"y, z of the file point along the body's {', '.join(permutation)} ({gain:.0f} nats); "
            "`imu-lib gap` on this drive with --out DIR writes a model file that holds it, for "
            "--model."
        )
    return out + _turned(seen), drive


def _turned(drive):
    angles, gain = axes.turn(drive)
    size = float(Rotation.from_euler("ZYX", angles[::-1]).magnitude())
    if size < TURNED or gain < axes.CLEAR:
        return []
    roll, pitch, yaw = angles / DEG
    return [
        f"The sensor's case is turned in the vehicle, by about roll {roll:.0f}, pitch {pitch:.0f}, "
        f"yaw {yaw:.0f} deg ({gain:.0f} nats): a filter that takes its x for forward starts with a "
        "wrong heading; `imu-lib gap` on this drive with --out DIR writes a model file that holds "
        "the mounting, for --model."
    ]


def _clocks(drive):
    halves = lateness.of_halves(drive)
    if halves is None or abs(halves[1] - halves[0]) < STEADY:
        return []
    return [
        f"The fixes are {_late(halves[0])} in the first half of the drive and {_late(halves[1])} "
        "in the second: one of the clocks jumps or "
        "drifts; cut the drive where it does (--start, --stop)."
    ]


def _time(drive, late):
    offset, likeness = late
    if abs(offset) < LATE:
        return []
    flags = f"--latency {offset:.1f}"
    if drive.gnss_velocity is not None:
        alone, sure = lateness.late(drive.without_velocity())
        if sure > 0.5 and abs(alone - offset) > LATE:
            flags = f"--latency {alone:.1f} --velocity-latency {offset:.1f}"
    return [
        f"The fixes are {_late(offset)} against the IMU (turns and accelerations agree best there, "
        f"correlation {likeness:.2f}): give `imu-lib outages` {flags}, or let `imu-lib gap` find "
        "it to the hundredth."
    ]


def _late(offset):
    return f"about {abs(offset):.1f} s {'late' if offset > 0 else 'early'}"


def _turns(drive, late):
    m = fix_motion.motion(drive)
    if m is None or m.moving.sum() < 200 or np.std(m.expected[m.moving, 2]) < 0.02:
        return []
    steps = int(round(late / fix_motion.STEP))
    expected, felt = np.roll(m.expected[:, 2], -steps)[m.moving], m.readings[m.moving, 2]
    if not fix_motion.changes(felt) or np.corrcoef(expected, felt)[0, 1] < 0.7:
        return []
    slope = float(np.std(felt) / np.std(expected))
    for factor, unit in ((1.0 / DEG, "deg/s"), (DEG, "rad/s twice converted")):
        if 0.7 < slope / factor < 1.4:
            return [
                f"The gyros turn {slope:.3g} times as fast as the fixes' course: they are in "
                f"{unit}, not rad/s; multiply them by {1 / factor:.4g}."
            ]
    return []


def _weight(drive):
    position = np.asarray(drive.gnss_position)
    good = np.isfinite(position).all(axis=1)
    g = earth.gravity(*position[good][0, ::2])
    width = max(int(drive.rate), 2)
    count = drive.time.size // width
    if count < 10:
        return []
    cut = slice(0, count * width)
    blocks = drive.accel[cut].reshape(count, width, 3)
    scatter = blocks.std(axis=1).sum(axis=1) + 10.0 * drive.gyro[cut].reshape(count, width, 3).std(
        axis=1
    ).sum(axis=1)
    still = np.argsort(scatter)[: max(count // 20, 5)]
    readings = blocks[still].mean(axis=1)
    size = float(np.median(np.linalg.norm(readings, axis=1)))
    if abs(size / g - 1.0) < HEAVY:
        return []
    down = np.median(readings, axis=0)
    axis = int(np.argmax(np.abs(down)))
    bias = np.sign(down[axis]) * (size - g)  # added to what the file has on that axis
    return [
        f"Gravity reads {size:.3f} m/s^2 in the quietest seconds, {g:.3f} is true there: a scale "
        f"factor of {size / g - 1:+.3f} or a bias of {bias:+.2f} m/s^2 on the accelerometer's "
        f"{'xyz'[axis]}; `imu-lib gap` tells which, where the drive can."
    ]


def _reference(drive):
    if not drive.has_reference:
        return []
    out = []
    time = np.asarray(drive.reference_time)
    moved = earth.horizontal(drive.reference_position[1:], drive.reference_position[:-1])
    step = np.diff(time)
    speed = np.median(moved / step) + 60.0
    jumps = np.flatnonzero(moved > JUMP + speed * step)
    if jumps.size:
        k = jumps[np.argmax(moved[jumps])]
        out.append(
            f"The reference jumps {jumps.size} times, by {moved[k]:.0f} m at {time[k]:.1f} s: "
            "errors against it there are its own; score against the full-GNSS solution."
        )
    at = np.column_stack(
        [np.interp(drive.gnss_time, time, c) for c in np.asarray(drive.reference_position).T]
    )
    inside = (drive.gnss_time >= time[0]) & (drive.gnss_time <= time[-1])
    inside &= np.isfinite(drive.gnss_position).all(axis=1)
    if inside.sum() > 20:
        apart = float(np.median(earth.horizontal(drive.gnss_position[inside], at[inside])))
        if apart > FAR:
            out.append(
                f"The reference lies {apart:.0f} m from the fixes in the median: one of the two "
                "is in another frame, or late."
            )
    return out
