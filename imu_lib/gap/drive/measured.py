"""What is measured along a path: predicted minus measured at the fixes of a stretch, and what each
parameter does to it.
"""

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from imu_lib.navigation import attitude, earth
from imu_lib.record import CHANNELS

from . import columns

SMOOTH = 0.08  # s over which readings about a fix are averaged


def at_fixes(stretch, epochs, bias, span):
    """Angular rate (body) about epochs over `span` s, its derivative and specific force (body) over
    0.08 s; specific force of all samples.
    """
    rates = stretch.dtheta / stretch.dt[:, None] - bias[:3]
    force = stretch.dvel / stretch.dt[:, None] - bias[3:]
    step = float(np.median(stretch.dt))
    half = max(int(round(0.5 * SMOOTH / step)), 1)
    k = np.clip(epochs, 0, len(rates) - 1)
    # an even window is centred on the boundary between samples k-1 and k, which epoch k is
    narrow = 2 * max(int(round(0.5 * span / step)), 1)
    w = uniform_filter1d(rates, narrow, axis=0, origin=0)[k]
    f = uniform_filter1d(force, 2 * half, axis=0, origin=0)[k]
    mean = uniform_filter1d(rates, half, axis=0)
    near = np.clip(k[:, None] + np.array([-half, half]) // 2, 0, len(rates) - 1)
    turning = (mean[near[:, 1]] - mean[near[:, 0]]) / (np.diff(near) * step + 1e-9)
    return w, turning, f, force


def span_of(noise, fixes, lever):
    """Time over which turn rates are averaged, s: two samples, unless the gyros' own noise would
    then move an antenna by more than a share of the velocities' standard deviation.
    """
    velocity = fixes.use & 2 > 0
    if not velocity.any():
        return SMOOTH
    sd = float(np.median(np.sqrt(fixes.variance[velocity, 3:])))
    density = max(
        (t.N for c in CHANNELS[:3] for t in noise.model[c].terms if t.name == "white_noise"),
        default=0.0,
    )
    least = 0.3 * sd / max(float(np.linalg.norm(lever)), 1.0)
    return min((density / least) ** 2, SMOOTH)


def _gained(log, stretch, force):
    """Velocity gained since the start of the stretch, NED, without the jumps that fixes make:
    (time, (k, 3) m/s) into the log.
    """
    part = slice(log.first, min(log.first + len(log.angles), len(force)))
    c = attitude.matrix(log.angles[: part.stop - part.start])
    f = np.einsum("nij,nj->ni", c, force[part])
    f[:, 2] += earth.gravity(*log.position[0, ::2])
    dt = stretch.dt[part]
    log.gained = stretch.time[part] + dt, np.cumsum(f * dt[:, None], axis=0)


def fill(mine, fixes, stretch, epochs, at, log, lever, y, arm_rows, use, d, extra, warmth, drive):  # fmt: skip
    """Predicted minus measured, its rows and columns, at the fixes of a stretch."""
    w, turning, f, f_all = at
    pos, vel, quat = log.at(epochs)
    # columns are what was known before the fix: its own noise in them would look like an effect
    before = np.maximum(epochs - 1, log.first)
    _, vel_before, quat_before = log.at(before)
    step = np.where(epochs > before, stretch.dt[before], 0.0)[:, None]
    turned = Rotation.from_rotvec(w * step).as_matrix()
    c, now = (
        attitude.matrix(attitude.euler(quat_before)) @ turned,
        attitude.matrix(attitude.euler(quat)),
    )
    gravity = np.array([earth.gravity(p[0], p[2]) for p in pos])
    acc = np.einsum("nij,nj->ni", c, f)
    acc[:, 2] += gravity
    delay = stretch.time[epochs] - fixes.time[mine]
    vel_before = vel_before + acc * step
    arm = np.einsum("nij,j->ni", now, lever)
    spin = np.einsum("nij,nj->ni", now, np.cross(w, lever))
    value = fixes.value[mine]
    back = (vel * delay[:, None]) - 0.5 * acc * delay[:, None] ** 2
    y[mine, :3] = earth.meters(pos, value[:, :3]) + arm - back
    _gained(log, stretch, f_all)
    y[mine, 3:] = vel + spin - value[:, 3:] - acc * delay[:, None]
    bits = fixes.use[mine]
    use[mine, :3] = ((bits & 1) > 0)[:, None]
    use[mine, 3:] = ((bits & 2) > 0)[:, None]
    zero = np.zeros(mine.size)
    # attitude rows of C arm, [arm x]
    arm_rows[mine] = np.stack(
        [
            np.stack([zero, -arm[:, 2], arm[:, 1]], -1),
            np.stack([arm[:, 2], zero, -arm[:, 0]], -1),
            np.stack([-arm[:, 1], arm[:, 0], zero], -1),
        ],
        -2,
    )
    at_time = fixes.time[mine]
    out = d[mine]
    first = len(columns.IMU)
    out[:, :3, first] = vel_before
    about = np.cross(w, np.cross(w, lever)) + np.cross(turning, lever)
    gained = acc + np.einsum("nij,nj->ni", c, about)  # of the antenna
    out[:, 3:, first + 1] = gained
    for i in range(3):
        unit = np.zeros(3)
        unit[i] = 1.0
        out[:, :3, first + 2 + i] = -c[:, :, i]
        out[:, 3:, first + 2 + i] = -np.einsum("nij,nj->ni", c, np.cross(w, unit))
    out[:, :3, columns.INDEX["imu_clock", "scale"]] = -at_time[:, None] * vel_before
    out[:, 3:, columns.INDEX["imu_clock", "scale"]] = -at_time[:, None] * gained
    smooth = columns.of("other: receiver's velocity is smoothed")
    for k, tau in zip(smooth, columns.SMOOTHED):
        # its delay is the velocity's time offset, which the filter knows
        out[:, 3:, k] = _smoothing_lack(log, at_time, tau) - tau * acc
    span = drive.time[-1] - drive.time[0]
    for k, part in enumerate((1 / 3, 1 / 2, 2 / 3)):
        after = at_time > drive.time[0] + part * span
        for i in range(3):
            out[:, i, smooth[-1] + 1 + 3 * k + i] = -after.astype(float)
    for i in range(3):
        out[:, 3 + i, smooth[-1] + 10 + i] = -1.0
    d[mine] = out
    speed = np.hypot(vel[:, 0], vel[:, 1])
    course = np.arctan2(vel[:, 1], vel[:, 0])
    extra["course"][mine], extra["speed"][mine], extra["turn"][mine] = course, speed, w[:, 2]
    extra["ahead"][mine] = acc[:, 0] * np.cos(course) + acc[:, 1] * np.sin(course)
    extra["aside"][mine] = -acc[:, 0] * np.sin(course) + acc[:, 1] * np.cos(course)
    extra["warmth"][mine] = warmth[np.clip(epochs, 0, warmth.size - 1)]


def _smoothing_lack(log, when, tau):
    """Velocity minus its first-order low-pass, (k, 3): from the IMU alone, since a velocity that
    holds the fixes' own noise would seem to explain it.
    """
    time, total = log.gained
    step = float(np.median(np.diff(time)))
    keep = np.exp(-step / tau)
    slow = lfilter([1.0 - keep], [1.0, -keep], total, axis=0, zi=keep * total[:1])[0]
    return np.column_stack([np.interp(when, time, column) for column in (total - slow).T])
