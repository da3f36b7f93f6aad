"""The nominal path of a drive and what is measured along it: the filter run once, cut at its fixes."""

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from imu_lib.navigation import attitude, earth
from imu_lib.navigation.filter import FilterModel, LooselyCoupled
from imu_lib.navigation.preparation import Gnss
from imu_lib.record import CHANNELS

from . import columns, condense
from .problem import Noise, Problem, for_search, turn_on_of

LONGEST = 0.5  # s between nodes
JOLT = 1e6  # times the white noise, about a shock: readings that clip say nothing
LINEAR_STEP = 0.05  # s of one linear step
SMOOTH = 0.08  # s over which readings about a fix are averaged


def build(drive, noise: Noise, *, heading=None, velocity_shift=0.0, restarts=(), loose=(1.0, 1.0)):
    """Run the filter over a drive (already corrected for what is held), and condense it.

    velocity_shift : s, by which the velocities' stamps are late beyond the positions'; restarts :
    s, times at which all that is known of the motion is forgotten (a shock); loose : by how much
    less than stated positions and velocities are trusted for the path
    """
    gnss = Gnss(
        position_floor=0.02,
        velocity_floor=0.005,
        gate=None if noise.fraction == 0.0 else 1.0 - 1e-9,
        velocity_latency=-velocity_shift if velocity_shift else None,
    )
    turn_on = turn_on_of(noise.model)
    loose = max(noise.position, 1.0) * loose[0], max(noise.velocity, 1.0) * loose[1]
    spread = replace_sd(drive, *loose)
    engine = LooselyCoupled(
        spread,
        FilterModel("gap", for_search(noise.model), turn_on_sd=turn_on, flicker="markov"),
        gnss=gnss,
        heading=heading,
        remove_bias=False,
    )
    prepared = engine.prepared
    fixes = prepared.fixes
    _trust_velocities(fixes, split=bool(velocity_shift))
    for stretch in prepared.stretches:
        for when in restarts:
            near = (stretch.time[:-1] > when - 0.3) & (stretch.time[:-1] < when + 0.3)
            stretch.extra_noise[near] = JOLT
    end = min(float(drive.time[-1]), float(fixes.time[-1])) - 1.0
    solution = engine.solve(moments=[end])
    rate = prepared.rate
    bias = _bias(engine, solution)
    lever = np.zeros(3) if drive.lever_arm is None else np.asarray(drive.lever_arm, float)
    parts = []
    shape = fixes.time.size
    y, arm_rows = np.zeros((shape, 6)), np.zeros((shape, 3, 3))
    use = np.zeros((shape, 6), bool)
    extra = {k: np.zeros(shape) for k in ("course", "speed", "turn", "ahead", "aside", "warmth")}
    d = np.zeros((shape, 6, len(columns.ALL)))
    path = {"time": [], "position": [], "velocity": [], "attitude": [], "attitude_sd": []}
    temperature = drive.temperature
    for stretch in prepared.stretches:
        inside = (solution.time > stretch.time[0] - 1e-9) & (
            solution.time <= stretch.time[-1] + 1e-9
        )
        if inside.sum() < 10:
            continue
        first = int(np.searchsorted(stretch.time, solution.time[inside][0] - 1e-9))
        log = _Log(solution, inside, first)
        fix_epoch = np.searchsorted(stretch.time, fixes.time - 1e-9)
        mine = np.flatnonzero(
            (fix_epoch > first) & (fix_epoch < stretch.time.size) & (fixes.time > stretch.time[0])
        )
        if mine.size < 2:
            continue
        longest = max(int(round(LONGEST * rate)), 1)
        node = np.unique(fix_epoch[mine])
        node = np.unique(
            np.concatenate(
                [[first]]
                + [
                    np.linspace(a, b, int(np.ceil((b - a) / longest)) + 1)[1:].round().astype(int)
                    for a, b in zip(np.concatenate([[first], node[:-1]]), node)
                    if b > a
                ]
            )
        ).astype(np.int64)
        pos, vel, quat = log.at(node)
        middle = 0.5 * (drive.time[0] + drive.time[-1])
        begin_time = stretch.time[:-1]
        warmth = (
            np.zeros(begin_time.size)
            if temperature is None
            else np.interp(begin_time, drive.time, temperature - np.mean(temperature)) / 10.0
        )
        late = (begin_time > middle).astype(float)
        sub = max(int(round(LINEAR_STEP * rate)), 1)
        pieces = condense.intervals(
            node, pos, vel, quat, stretch.dt, stretch.dtheta, stretch.dvel, bias,
            stretch.extra_noise, warmth, late, sub, len(columns.IMU),
        )  # fmt: skip
        at = _at_fixes(stretch, fix_epoch[mine], bias, _span(noise, fixes, lever))
        _fill(
            mine, fixes, stretch, fix_epoch[mine], at, log, lever, y, arm_rows, use,
            d, extra, warmth, drive,
        )  # fmt: skip
        rows = (
            np.searchsorted(fix_epoch[mine], node),
            np.searchsorted(fix_epoch[mine], node, "right"),
        )
        node_fix, node_end = (mine[0] + r for r in rows)
        parts.append(
            dict(
                pieces=pieces,
                node=node,
                node_fix=node_fix,
                node_end=node_end,
                time=stretch.time[node],
                speed=np.linalg.norm(vel, axis=1),
            )  # fmt: skip
        )
        path["time"].append(stretch.time[node])
        path["position"].append(pos)
        path["velocity"].append(vel)
        path["attitude"].append(attitude.euler(quat))
        path["attitude_sd"].append(log.sd[np.clip(node - first, 0, len(log.sd) - 1)])
    arrays = _join(parts, bias)
    node_time = np.concatenate([p["time"] for p in parts])
    arrays["begins"][[k for k in np.searchsorted(node_time, restarts) if k < node_time.size]] = True
    arrays["node_time"] = node_time
    arrays |= {"arm_rows": arm_rows, "d": d}
    return Problem(
        drive=drive, attitude_sd=solution.sd[len(solution.sd) // 3 :: 50, 6:9], turn_on=turn_on, rate=rate, time=fixes.time, use=use, y=y,
        stated=fixes.variance / np.repeat(np.square(loose), 3), **extra,
        path={k: np.concatenate(v) for k, v in path.items()}, arrays=arrays, notes=solution.notes,
    )  # fmt: skip


def _trust_velocities(fixes, split=False):
    """Use velocities that were left out because noisy positions seemed to contradict them: what
    positions 2 s apart can tell is limited by their own noise.
    """
    unused = fixes.use == 0 if split else fixes.use & 2 == 0
    bad = np.flatnonzero(unused & np.any(fixes.value[:, 3:] != 0.0, axis=1))
    if bad.size < 20:
        return
    if split:
        fixes.use[bad] |= 2
        return
    time, value = fixes.time[bad], fixes.value[bad]
    after = np.searchsorted(time, time + 2.0)
    ok = after < time.size
    gap = time[after[ok]] - time[ok]
    moved = earth.meters(value[after[ok], :3], value[ok, :3])[:, :2] / gap[:, None]
    mean = 0.5 * (value[after[ok], 3:5] + value[ok, 3:5])
    apart = np.median(np.linalg.norm(moved - mean, axis=1)[gap < 4.0])
    sd = np.median(np.sqrt(fixes.variance[bad, :2].mean(axis=1)))
    if apart < 1.0 + 2.0 * sd:
        fixes.use[bad] |= 2


def replace_sd(drive, position, velocity):
    """The drive with its fixes' standard deviations multiplied, for the nominal path alone."""
    gnss = Gnss()
    m = len(drive.gnss_time)
    psd = (
        np.tile(gnss.position_sd, (m, 1))
        if drive.gnss_position_sd is None
        else drive.gnss_position_sd
    )
    vsd = (
        np.tile(gnss.velocity_sd, (m, 1))
        if drive.gnss_velocity_sd is None
        else drive.gnss_velocity_sd
    )
    return drive.with_(gnss_position_sd=psd * position, gnss_velocity_sd=vsd * velocity)


class _Log:
    """The filter's solution at epochs of one stretch."""

    def __init__(self, solution, inside, first):
        self.first = first
        self.gained = None
        self.position = solution.position[inside]
        self.velocity = solution.velocity[inside]
        self.angles = solution.attitude[inside]
        self.sd = solution.sd[inside, 6:9]

    def at(self, epochs):
        k = np.clip(epochs - self.first, 0, len(self.position) - 1)
        turned = Rotation.from_euler("ZYX", self.angles[k][:, ::-1])
        quat = turned.as_quat(scalar_first=True)
        return self.position[k].copy(), self.velocity[k].copy(), quat


def _bias(engine, solution):
    """Mean of the channels' errors that the filter estimated, (6,): taken off for the nominal."""
    moment = solution.moments[-1]
    if not moment.time.size:
        return np.zeros(6)
    sensors = engine.sensors
    x = moment.x[-1]
    return np.array(
        [
            x[sensors.first[c] : sensors.first[c + 1]]
            @ sensors.output[sensors.first[c] : sensors.first[c + 1]]
            for c in range(6)
        ]
    )


def _at_fixes(stretch, epochs, bias, span):
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


def _span(noise, fixes, lever):
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


def _fill(mine, fixes, stretch, epochs, at, log, lever, y, arm_rows, use, d, extra, warmth, drive):  # fmt: skip
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


def _join(parts, bias):
    """The stretches one after the other; an interval that leads from one into the next is empty."""
    phi, gain, noise, force, jump, gap, counts = [], [], [], [], [], [], []
    begins, node_fix, node_end, node_speed = [], [], [], []
    for k, part in enumerate(parts):
        pieces = part["pieces"]
        if k:  # a place keeper between stretches
            for store, piece in zip((phi, gain, noise, force, jump), pieces):
                store.append(np.zeros((1, *piece.shape[1:])))
            gap.append([1.0])
            counts.append([1])
        for store, piece in zip((phi, gain, noise, force, jump), pieces):
            store.append(piece)
        gap.append(np.diff(part["time"]))
        counts.append(np.diff(part["node"]))
        flag = np.zeros(part["node"].size, bool)
        flag[0] = True
        begins.append(flag)
        node_fix.append(part["node_fix"])
        node_end.append(part["node_end"])
        node_speed.append(part["speed"])
    join = [np.concatenate(s) for s in (phi, gain, noise, force, jump)]
    steps = np.concatenate(counts)
    unique, kind = np.unique(steps, return_inverse=True)
    return dict(
        zip(("phi", "gain", "noise", "force", "jump"), join),
        gap=np.concatenate(gap), counts=unique, kind=kind, begins=np.concatenate(begins),
        node_fix=np.concatenate(node_fix), node_end=np.concatenate(node_end), node_speed=np.concatenate(node_speed),
        bias=np.asarray(bias, float),
    )  # fmt: skip
