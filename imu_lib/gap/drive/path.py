"""The nominal path of a drive and what is measured along it: the filter run once, cut at its fixes."""

import numpy as np
from scipy.spatial.transform import Rotation

from imu_lib.drive_effects import DriveEffect
from imu_lib.navigation import attitude, earth
from imu_lib.navigation.filter import FilterModel, LooselyCoupled
from imu_lib.navigation.preparation import Gnss

from . import columns, condense
from .measured import at_fixes, fill, span_of
from .problem import Noise, Problem, for_search, turn_on_of

LONGEST = 0.5  # s between nodes
JOLT = 1e6  # times the white noise, about a shock: readings that clip say nothing
LINEAR_STEP = 0.05  # s of one linear step


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
        FilterModel(
            "gap",
            for_search(noise.model),
            turn_on_sd=turn_on,
            flicker="markov",
            effects=_correlated(noise),
        ),
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
                    np.array([b])
                    if b - a <= longest
                    else np.linspace(a, b, int(np.ceil((b - a) / longest)) + 1)[1:]
                    .round()
                    .astype(int)
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
        at = at_fixes(stretch, fix_epoch[mine], bias, span_of(noise, fixes, lever))
        fill(
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


def _correlated(noise: Noise):
    """Correlated errors of the positions, which a path must not follow, as effects to be held."""
    if noise.sigma == 0.0:
        return ()
    parameters = {"sigma": noise.sigma, "correlation_time": max(noise.tau, 1e-2)}
    return (DriveEffect("gnss_correlated", parameters),)


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
    # a single stretch, the usual case, is not copied: its arrays are large
    join = [s[0] if len(s) == 1 else np.concatenate(s) for s in (phi, gain, noise, force, jump)]
    steps = np.concatenate(counts)
    unique, kind = np.unique(steps, return_inverse=True)
    return dict(
        zip(("phi", "gain", "noise", "force", "jump"), join),
        gap=np.concatenate(gap), counts=unique, kind=kind, begins=np.concatenate(begins),
        node_fix=np.concatenate(node_fix), node_end=np.concatenate(node_end), node_speed=np.concatenate(node_speed),
        bias=np.asarray(bias, float),
    )  # fmt: skip
