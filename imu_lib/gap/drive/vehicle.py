"""What a vehicle cannot do, asked of the path found: move sideways. The case's mounting, and a
wrong heading at the start.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import Rotation

from imu_lib.arrays import Array
from imu_lib.navigation import axes
from imu_lib.processes import WhiteNoise
from imu_lib.record import CHANNELS
from imu_lib.units import DEG

from . import columns, correct, legs

if TYPE_CHECKING:
    from .problem import Noise, Problem
    from .state import State

FASTER = 1.5  # m/s: what creeps says little, and is weighed by its speed
TURNING = 0.3  # rad/s
ASKEW = 20.0 * DEG  # from the nearest right angles: beyond, a case stands as it stands
SYSTEMATIC = np.array([1.2, 0.25, 0.25]) * np.pi / 180  # roads are not level, tyres slip: rad
TURNED = np.array([5.0, 4.0, 4.0])  # standard deviations from which on a case is turned


def attitude_sd(state: State) -> Array:
    """How well the path knows its attitude, rad (3,): from the filter's own covariance."""
    return np.minimum(np.median(state.problem.attitude_sd, axis=0), 20 * DEG)


def beyond_doubt(turned: tuple[Array, Array]) -> bool:
    """Whether angles of a case are larger than their standard deviations leave to chance."""
    return bool((np.abs(turned[0]) / turned[1] > TURNED).any())


def mounting(problem: Problem, attitude_sd: Array) -> tuple[Array, Array] | None:
    """Roll, pitch, yaw of the case in the vehicle and their standard deviations, rad; None where
    the drive is too slow. attitude_sd (3,): of the path's own attitude.
    """
    path = problem.path
    v = path["velocity"]
    speed = np.linalg.norm(v, axis=1)
    turn = np.gradient(np.unwrap(path["attitude"][:, 2]), path["time"])
    keep = (speed > FASTER) & (np.abs(turn) < TURNING)
    keep &= path["time"] > path["time"][0] + 60.0
    if keep.sum() < 60:
        return None
    c_nb = Rotation.from_euler("ZYX", path["attitude"][keep][:, ::-1])
    case = c_nb.inv().apply(v[keep])
    a = np.column_stack([speed[keep], turn[keep]])
    found = [_robust(a, case[:, k]) for k in range(3)]
    # where the velocity points in the case's axes: its mean, with the turns' share taken out
    forward = np.array([x[0] for x, _ in found])
    forward /= np.linalg.norm(forward)
    case_to_vehicle = _along(forward)
    roll = (c_nb * case_to_vehicle.inv()).as_euler("ZYX")[:, 2]
    # the vehicle's roll is zero on average: what is left is the case's own
    mean = np.arctan2(np.median(np.sin(roll)), np.median(np.cos(roll)))
    case_to_vehicle = Rotation.from_rotvec([mean, 0.0, 0.0]) * case_to_vehicle
    spread = np.array([0.0, found[2][1], found[1][1]])
    sd = np.sqrt(SYSTEMATIC**2 + attitude_sd**2 + spread**2)
    return case_to_vehicle.as_euler("ZYX")[::-1], _of_angles(case_to_vehicle, sd)


def turned_axes(turned: tuple[Array, Array]) -> tuple[str, ...] | None:
    """The axes that a case lies turned by, where it is no case a little askew: a file whose x is
    another axis of the body. None where it is one, or turned by no multiple of a right angle.
    """
    permutation, apart = axes.nearest(Rotation.from_euler("ZYX", turned[0][::-1]))
    return permutation if permutation != axes.IDENTITY and apart < ASKEW else None


def _along(forward: Array) -> Rotation:
    """The rotation that turns unit vector `forward` (3,) to x by yaw and pitch alone."""
    yaw = -np.arctan2(forward[1], forward[0])
    level = Rotation.from_euler("z", yaw).apply(forward)
    pitch = np.arctan2(level[2], level[0])
    return Rotation.from_euler("y", pitch) * Rotation.from_euler("z", yaw)


def _of_angles(turn: Rotation, sd: Array) -> Array:
    """Standard deviations of roll, pitch, yaw from those of small turns about the vehicle's
    axes.
    """
    step, now = 1e-4, turn.as_euler("ZYX")[::-1]
    moved = [(Rotation.from_rotvec(step * u) * turn).as_euler("ZYX")[::-1] for u in np.eye(3)]
    slope = (np.array([m - now for m in moved]) + np.pi) % (2.0 * np.pi) - np.pi
    return np.sqrt(np.sum((slope / step * sd[:, None]) ** 2, axis=0))


def _robust(a: Array, b: Array) -> tuple[Array, float]:
    """Least squares with what lies far out left out: (values, standard error of the first)."""
    keep = np.ones(b.size, bool)
    for _ in range(5):
        x = np.linalg.lstsq(a[keep], b[keep], rcond=None)[0]
        left = b - a @ x
        size = 1.48 * np.median(np.abs(left[keep])) + 1e-6
        keep = np.abs(left) < 3.0 * size
    independent = max(keep.sum() / 40.0, 1.0)
    return x, float(size / np.sqrt(independent) / np.mean(a[keep, 0]))


def _white(noise: Noise, channel: str) -> list[WhiteNoise]:
    """The white noises of a channel, one of nothing among them."""
    return [WhiteNoise(0.0), *(t for t in noise.model[channel].terms if isinstance(t, WhiteNoise))]


CARRIED = 90.0  # s over which the gyros carry a heading back to the start
ENDING = 60.0  # s
DRIFT = 2e-4  # rad/s that the gyros' bias may still be off


def drifting(state: State) -> Array:
    """Errors of the gyros that follow temperature and speed, or step, as far as they are held,
    rad/s (n, 3), about those of the drive's end, which a path's bias holds.
    """
    drive, path = state.problem.drive, state.problem.path
    out = np.zeros_like(drive.gyro)
    speed = np.interp(drive.time, path["time"], np.linalg.norm(path["velocity"][:, :2], axis=1))
    warmth, late = legs.drifts(drive, drive.time, state.stepped).T
    for effect, follows in (("temperature", warmth), ("speed", speed), (columns.STEP, late)):
        name = effect if effect == columns.STEP else f"other: biases follow the {effect}"
        out += follows[:, None] * correct.value(state.other, name)[:3]
    return np.asarray(out - out[drive.time > drive.time[-1] - ENDING].mean(axis=0))


def heading_error(state: State, given: float, mount: Array) -> tuple[float, float] | None:
    """Given heading at the first sample minus the path's own, in the vehicle's axes, and its
    standard deviation, rad; None where the drive has a hole there.
    """
    problem, noise = state.problem, state.noise
    found = heading_since(problem, problem.drive.time[0], mount, drifting(state))
    if found is None:
        return None
    yaw, sd = found
    density = max(n.N for c in CHANNELS[:3] for n in _white(noise, c))
    growth = max(noise.per_speed[:3]) * float(np.sqrt(np.mean(problem.speed**2)))
    sd = float(np.hypot(sd, np.hypot(density, growth) * np.sqrt(CARRIED)))
    return float((given - yaw + np.pi) % (2 * np.pi) - np.pi), sd


def heading_since(
    problem: Problem,
    since: float,
    mount: Sequence[float] | Array = (0.0, 0.0, 0.0),
    drift: Array | None = None,
) -> tuple[float, float] | None:
    """The path's heading at time `since`, in the vehicle's axes, and its standard deviation, rad: a
    later one carried back by the gyros, their errors `drift` (n, 3) taken out. None where the drive
    has a hole there.
    """
    path, drive = problem.path, problem.drive
    node = int(np.searchsorted(path["time"], path["time"][0] + CARRIED))
    if node >= path["time"].size:
        return None
    until = path["time"][node]
    part = (drive.time > since) & (drive.time <= until)
    step = np.diff(drive.time, prepend=drive.time[0])[part]
    if not step.size or step.max() > 1.0:
        return None
    rates = drive.gyro if drift is None else drive.gyro - drift
    turns = (rates[part] - problem.arrays["bias"][:3]) * step[:, None]
    turned = Rotation.from_rotvec(turns)
    while len(turned) > 1:  # the product in order, two by two
        if len(turned) % 2:
            turned = Rotation.concatenate([turned, Rotation.identity(1)])
        turned = turned[0::2] * turned[1::2]
    c = Rotation.from_euler("ZYX", path["attitude"][node][::-1]) * turned[0].inv()
    yaw = (c * Rotation.from_euler("ZYX", np.asarray(mount)[::-1]).inv()).as_euler("ZYX")[0]
    return float(yaw), float(np.hypot(path["attitude_sd"][node, 2], DRIFT * (until - since)))
