"""A drive made ready for the search: its nominal path, condensed, and the innovations under a
hypothesis about noise.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.signal import lfilter

from imu_lib.drive import Drive
from imu_lib.model import Model
from imu_lib.navigation import attitude, earth
from imu_lib.navigation.filter import FilterModel, LooselyCoupled
from imu_lib.navigation.preparation import Gnss
from imu_lib.navigation.states import sensor_states
from imu_lib.processes import Constant, Sum
from imu_lib.record import CHANNELS
from imu_lib.units import DEG

from . import columns, condense

TURN_ON = (0.1 * DEG, 0.05)  # rad/s, m/s^2: biases left at switch-on where the model states none
LONGEST = 0.5  # s between nodes
LINEAR_STEP = 0.05  # s of one linear step
# what the linear filter starts with, so that no alignment is believed: m, m/s, rad
START = np.array([30.0, 30.0, 30.0, 3.0, 3.0, 3.0, 0.06, 0.06, 0.5])


@dataclass(frozen=True)
class Noise:
    """A hypothesis about all that is random.

    model : Model of the six channels; per_speed (6,) growth of the white noise with speed;
    position, velocity : ratio of the fixes' true standard deviation to the stated one; sigma, tau :
    first-order Gauss-Markov error of the positions, m and s; fraction, scale : wild fixes, m
    """

    model: Model
    per_speed: tuple = (0.0,) * 6
    still: tuple = (None,) * 6
    position: float = 1.0
    velocity: float = 1.0
    sigma: float = 0.0
    tau: float = 30.0
    fraction: float = 0.0
    scale: float = 0.0

    def with_(self, **changes):
        return replace(self, **changes)


@dataclass(frozen=True)
class Innovations:
    """Whitened innovations e (f, 6), their variances s, what a parameter does to each (f, 6, P)
    (None where not asked for), the log-likelihood, and which positions are taken for wild (f,).
    """

    e: np.ndarray
    s: np.ndarray
    jac: np.ndarray | None
    log_likelihood: float
    wild: np.ndarray


@dataclass
class Problem:
    """A drive along its nominal path. See `condense.innovations` for the arrays."""

    drive: Drive
    turn_on: tuple
    rate: float
    time: np.ndarray
    use: np.ndarray
    y: np.ndarray
    stated: np.ndarray
    course: np.ndarray
    speed: np.ndarray
    turn: np.ndarray
    ahead: np.ndarray
    aside: np.ndarray
    warmth: np.ndarray
    attitude_sd: np.ndarray
    path: dict
    arrays: dict
    notes: tuple

    def evaluate(self, noise: Noise, *, sens=False, use=None) -> Innovations:
        """Innovations under a hypothesis; use (f, 6) bool: fixes taken (default: all)."""
        a = self.arrays
        sensors = sensor_states(
            with_constants(noise.model), self.rate, turn_on_sd=self.turn_on, flicker="markov"
        )
        output = np.zeros((6, sensors.count))
        for c in range(6):
            part = slice(sensors.first[c], sensors.first[c + 1])
            output[c, part] = sensors.output[part]
        powers, walks = _powers(sensors, a["counts"])
        variance = self.stated * np.repeat([noise.position**2, noise.velocity**2], 3)
        density = np.array(
            [w if n is None else n**2 for w, n in zip(sensors.white, noise.still)]
        )
        e, s, jac, wild = condense.innovations(
            a["begins"], a["phi"], a["gain"], a["noise"], a["force"], a["jump"], a["kind"],
            powers, walks, output, START**2, sensors.initial, density,
            np.asarray(noise.per_speed, float) ** 2, a["node_speed"], a["bias"],
            np.exp(-a["gap"] / max(noise.tau, 1e-3)), noise.sigma, a["node_fix"], self.y,
            a["arm_rows"], variance, self.use if use is None else use, noise.fraction,
            noise.scale, a["d"], sens,
        )  # fmt: skip
        good = np.isfinite(e)
        value = -0.5 * float(np.sum(e[good] ** 2 + np.log(s[good])))
        if noise.fraction > 0.0:
            seen = (self.use if use is None else use)[:, 0]
            share = np.where(wild[seen], noise.fraction, 1.0 - noise.fraction)
            value += float(np.log(share).sum())
        return Innovations(e, s, jac if sens else None, value, wild)


def _powers(sensors, counts):
    """Transition and noise of the sensor states over each number of IMU steps, by doubling."""
    powers, walks = [], []
    m = sensors.count
    for count in counts:
        steps, power, total = int(count), sensors.transition.copy(), sensors.noise.copy()
        out_s, out_q = np.eye(m), np.zeros((m, m))
        while steps:
            if steps & 1:
                out_q = power @ out_q @ power.T + total
                out_s = power @ out_s
            total = power @ total @ power.T + total
            power = power @ power
            steps >>= 1
        powers.append(out_s)
        walks.append(out_q)
    return np.array(powers), np.array(walks)


def turn_on_of(model: Model):
    """Standard deviation of the biases left at switch-on, gyro rad/s and accelerometer m/s^2."""
    given = getattr(model, "turn_on", None) or model.extra.get("turn_on")
    if not given:
        return TURN_ON
    if isinstance(given, dict):
        return float(given.get("gyro", TURN_ON[0])), float(given.get("accel", TURN_ON[1]))
    return tuple(float(v) for v in given)


def with_constants(model: Model) -> Model:
    """The model with a constant on every channel, so that the turn-on bias is one and is not
    forgotten with the correlation time of another process.
    """
    return model.with_channels(
        {
            c: model[c] if any(t.name == "constant" for t in model[c].terms)
            else Sum((*model[c].terms, Constant(0.0)))
            for c in CHANNELS
        }
    )


def build(drive: Drive, noise: Noise, *, heading=None, velocity_shift=0.0, restarts=(), loose=(1.0, 1.0)):
    """Run the filter over a drive (already corrected for what is held), and condense it.

    velocity_shift : s, by which the velocities' stamps are late beyond the positions'; restarts :
    s, times at which all that is known of the motion is forgotten (a shock); loose : by how much
    less than stated positions and velocities are trusted for the path
    """
    gnss = Gnss(position_floor=0.02, velocity_floor=0.005, gate=None if noise.fraction == 0.0 else 1.0 - 1e-9)
    turn_on = turn_on_of(noise.model)
    loose = max(noise.position, 1.0) * loose[0], max(noise.velocity, 1.0) * loose[1]
    spread = replace_sd(drive, *loose)
    engine = LooselyCoupled(
        spread,
        FilterModel("gap", with_constants(noise.model), turn_on_sd=turn_on, flicker="markov"),
        gnss=gnss,
        heading=heading,
        remove_bias=False,
    )
    prepared = engine.prepared
    fixes = prepared.fixes
    _trust_velocities(fixes)
    solution = engine.solve(moments=[])
    rate = prepared.rate
    bias = _bias(engine, solution)
    lever = np.zeros(3) if drive.lever_arm is None else np.asarray(drive.lever_arm, float)
    parts, offset = [], 0
    shape = fixes.time.size
    y, arm_rows = np.zeros((shape, 6)), np.zeros((shape, 3, 3))
    use = np.zeros((shape, 6), bool)
    extra = {k: np.zeros(shape) for k in ("course", "speed", "turn", "ahead", "aside", "warmth")}
    d = np.zeros((shape, 6, len(columns.ALL)))
    path = {"time": [], "position": [], "velocity": [], "attitude": []}
    temperature = drive.temperature
    for number, stretch in enumerate(prepared.stretches):
        inside = (solution.time > stretch.time[0] - 1e-9) & (solution.time <= stretch.time[-1] + 1e-9)
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
        at = _at_fixes(stretch, fix_epoch[mine], bias, quat_of=log)
        _fill(
            mine, fixes, stretch, fix_epoch[mine], at, log, lever, velocity_shift, y, arm_rows, use,
            d, extra, warmth, drive,
        )  # fmt: skip
        node_fix = np.full(node.size, -1)
        node_fix[np.searchsorted(node, fix_epoch[mine])] = mine
        parts.append(
            dict(
                pieces=pieces, node=node, node_fix=node_fix, time=stretch.time[node],
                speed=np.linalg.norm(vel, axis=1),
            )  # fmt: skip
        )
        path["time"].append(stretch.time[node])
        path["position"].append(pos)
        path["velocity"].append(vel)
        path["attitude"].append(attitude.euler(quat))
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


def _trust_velocities(fixes):
    """Use velocities that were left out because noisy positions seemed to contradict them: what
    positions 2 s apart can tell is limited by their own noise.
    """
    bad = np.flatnonzero((fixes.use & 2 == 0) & np.any(fixes.value[:, 3:] != 0.0, axis=1))
    if bad.size < 20:
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

    def at(self, epochs):
        k = np.clip(epochs - self.first, 0, len(self.position) - 1)
        quat = np.array([attitude.quaternion(a) for a in self.angles[k]])
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


def _at_fixes(stretch, epochs, bias, quat_of):
    """Angular rate (body), specific force and acceleration (NED) about epochs, over 0.09 s."""
    rates = stretch.dtheta / stretch.dt[:, None] - bias[:3]
    force = stretch.dvel / stretch.dt[:, None] - bias[3:]
    width = max(2 * int(round(0.04 / np.median(stretch.dt))), 2)
    k = np.clip(epochs, 0, len(rates) - 1)
    # an even window is centred on the boundary between samples k-1 and k, which epoch k is
    w = uniform_filter1d(rates, width, axis=0, origin=0)[k]
    f = uniform_filter1d(force, width, axis=0, origin=0)[k]
    return w, f, force


def _gained(log, stretch, force, when):
    """Velocity gained since the start of the stretch, NED (k, 3) m/s, without the jumps that fixes
    make: to compare velocities of times a little apart.
    """
    if log.gained is None:
        part = slice(log.first, min(log.first + len(log.angles), len(force)))
        c = attitude.matrix(log.angles[: part.stop - part.start])
        f = np.einsum("nij,nj->ni", c, force[part])
        f[:, 2] += earth.gravity(*log.position[0, ::2])
        dt = stretch.dt[part]
        log.gained = stretch.time[part] + dt, np.cumsum(f * dt[:, None], axis=0)
    time, total = log.gained
    return np.column_stack([np.interp(when, time, column) for column in total.T])


def _fill(mine, fixes, stretch, epochs, at, log, lever, shift, y, arm_rows, use, d, extra, warmth, drive):  # fmt: skip
    """Predicted minus measured, its rows and columns, at the fixes of a stretch."""
    w, f, f_all = at
    pos, vel, quat = log.at(epochs)
    c = attitude.matrix(attitude.euler(quat))
    gravity = np.array([earth.gravity(p[0], p[2]) for p in pos])
    acc = np.einsum("nij,nj->ni", c, f)
    acc[:, 2] += gravity
    delay = stretch.time[epochs] - fixes.time[mine]
    arm = np.einsum("nij,j->ni", c, lever)
    spin = np.einsum("nij,nj->ni", c, np.cross(w, lever))
    value = fixes.value[mine]
    back = (vel * delay[:, None]) - 0.5 * acc * delay[:, None] ** 2
    y[mine, :3] = earth.meters(pos, value[:, :3]) + arm - back
    earlier = _gained(log, stretch, f_all, fixes.time[mine] - shift) - _gained(
        log, stretch, f_all, stretch.time[epochs]
    )
    y[mine, 3:] = vel + spin - value[:, 3:] + earlier
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
    out[:, :3, first] = vel
    out[:, 3:, first + 1] = acc
    for i in range(3):
        unit = np.zeros(3)
        unit[i] = 1.0
        out[:, :3, first + 2 + i] = -c[:, :, i]
        out[:, 3:, first + 2 + i] = -np.einsum("nij,nj->ni", c, np.cross(w, unit))
    out[:, :3, columns.INDEX["imu_clock", "scale"]] = -at_time[:, None] * vel
    out[:, 3:, columns.INDEX["imu_clock", "scale"]] = -at_time[:, None] * acc
    for k, tau in enumerate((0.3, 1.0)):
        out[:, 3:, first + 5 + k] = _smoothing_lack(log, at_time, tau)
    span = drive.time[-1] - drive.time[0]
    for k, part in enumerate((1 / 3, 1 / 2, 2 / 3)):
        after = at_time > drive.time[0] + part * span
        for i in range(3):
            out[:, i, first + 7 + 3 * k + i] = -after.astype(float)
    for i in range(3):
        out[:, 3 + i, first + 16 + i] = -1.0
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
    begins, node_fix, node_speed = [], [], []
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
        node_speed.append(part["speed"])
    join = [np.concatenate(s) for s in (phi, gain, noise, force, jump)]
    steps = np.concatenate(counts)
    unique, kind = np.unique(steps, return_inverse=True)
    return dict(
        zip(("phi", "gain", "noise", "force", "jump"), join),
        gap=np.concatenate(gap), counts=unique, kind=kind, begins=np.concatenate(begins),
        node_fix=np.concatenate(node_fix), node_speed=np.concatenate(node_speed),
        bias=np.asarray(bias, float),
    )  # fmt: skip
