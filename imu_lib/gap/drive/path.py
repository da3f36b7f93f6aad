"""The nominal path of a drive and what is measured along it: the filter run once, cut at its
fixes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from imu_lib.arrays import Array
from imu_lib.drive import Drive
from imu_lib.drive_effects import DriveEffect
from imu_lib.navigation import earth, fix_faults, fix_rounding
from imu_lib.navigation.filter import FilterModel, LooselyCoupled
from imu_lib.navigation.preparation import Fixes, Gnss
from imu_lib.navigation.solution import Solution
from imu_lib.navigation.stretch import Stretch
from imu_lib.processes import WhiteNoise
from imu_lib.record import CHANNELS

from . import condense
from .legs import Leg
from .measured import Measured, at_fixes, span_of
from .problem import Noise, Problem, for_search, turn_on_of

JOLT = 1e6  # times the white noise, about a shock: readings that clip say nothing
# rad/s and m/s^2 per sqrt(Hz): no more than that, or the path has no attitude afterwards
MOST_JOLT = np.repeat([0.1, 5.0], 3)
GATE = 1.0 - 1e-9  # probability that a right fix passes
LINEAR_STEP = 0.05  # s of one linear step
# standard deviations of fixes, m and m/s: the best of a receiver, and what a path follows
BEST = (0.001, 0.001)
FOLLOWED = np.repeat([0.02, 0.005], 3)


def build(
    drive: Drive,
    noise: Noise,
    *,
    heading: float | None = None,
    velocity_shift: float = 0.0,
    restarts: Sequence[float] = (),
    loose: Sequence[float] | Array = (1.0, 1.0),
    step_at: float = np.inf,
    moved_at: float = np.inf,
    steps: Sequence[float] | Array = (0.0, 0.0, 0.0),
) -> Problem:
    """Run the filter over a drive (already corrected for what is held), and condense it.

    velocity_shift : s, by which the velocities' stamps are late beyond the positions'; restarts :
    s, times at which all that is known of the motion is forgotten (a shock); loose : by how much
    less than stated positions and velocities are trusted for the path; step_at : s, from where on
    biases may be others; moved_at : s, from where on fixes may be displaced; steps : m, that the
    file rounds positions to
    """
    turn_on = turn_on_of(noise.model)
    factors = max(noise.position, 1.0) * loose[0], max(noise.velocity, 1.0) * loose[1]
    tame, wild = _tame(drive, noise)
    # a gate that is passed once by a wild fix may shut out the right ones: it is for the small ones
    gate = GATE if wild.mean() < 0.5 * noise.fraction else None
    gnss = Gnss(
        position_floor=BEST[0],
        velocity_floor=BEST[1],
        gate=gate,
        velocity_latency=-velocity_shift if velocity_shift else None,
        position_steps=tuple(steps),
    )
    engine = _engine(replace_sd(tame, *factors), noise, turn_on, heading, gnss)
    prepared = engine.prepared
    fixes = prepared.fixes
    rounding = fix_rounding.variance(np.asarray(steps))
    stated = (fixes.variance - rounding) / np.repeat(np.square(factors), 3)
    fixes.variance[:] = np.maximum(fixes.variance, FOLLOWED**2)
    _trust_velocities(fixes, split=bool(velocity_shift))
    _jolted(prepared.stretches, restarts, noise)
    end = min(float(drive.time[-1]), float(fixes.time[-1])) - 1.0
    solution = _without(fixes, drive, wild, lambda: engine.solve(moments=[end]))
    bias = _bias(engine, solution)
    cut = (Leg.of(drive, s, solution, fixes, step_at) for s in prepared.stretches)
    legs = [leg for leg in cut if leg is not None]
    lever = np.zeros(3) if drive.lever_arm is None else np.asarray(drive.lever_arm, float)
    measured = Measured.empty(fixes.time.size)
    span = span_of(noise, fixes, lever)
    for leg in legs:
        measured.fill(leg, fixes, at_fixes(leg.stretch, leg.epochs, bias, span), lever, drive.time)
    measured.displace(fixes.time > moved_at)
    nodes = [leg.at_nodes() for leg in legs]
    path = {k: np.concatenate([n[k] for n in nodes]) for k in nodes[0]}
    arrays = condense.joined(legs, bias, max(int(round(LINEAR_STEP * prepared.rate)), 1))
    arrays["node_time"] = path["time"]
    begins = np.searchsorted(path["time"], restarts)
    arrays["begins"][begins[begins < path["time"].size]] = True
    arrays |= {"arm_rows": measured.arm_rows, "d": measured.d}
    along = measured.along
    return Problem(
        drive=drive, attitude_sd=solution.sd[len(solution.sd) // 3 :: 50, 6:9], turn_on=turn_on,
        rate=prepared.rate, time=fixes.time, use=measured.use, y=measured.y,
        stated=stated, rounding=rounding, course=along["course"], speed=along["speed"],
        turn=along["turn"], ahead=along["ahead"], aside=along["aside"], warmth=along["warmth"],
        path=path, arrays=arrays, notes=solution.notes,
    )  # fmt: skip


def _tame(drive: Drive, noise: Noise) -> tuple[Drive, Array]:
    """(the drive with fixes that lie far off put between their neighbours, which of its fixes
    these are): no path, and no heading at its start, is found from them.
    """
    position = np.array(drive.gnss_position, float)
    if noise.fraction == 0.0:
        return drive, np.zeros(len(position), bool)
    wild = fix_faults.far_off(np.asarray(drive.gnss_time), position)
    if not wild.any():
        return drive, wild
    rest = np.flatnonzero(np.isfinite(position).all(axis=1) & ~wild)
    for k in range(3):
        position[wild, k] = np.interp(
            drive.gnss_time[wild], drive.gnss_time[rest], position[rest, k]
        )
    return drive.with_(gnss_position=position), wild


def _without(fixes: Fixes, drive: Drive, wild: Array, solve: Callable[[], Solution]) -> Solution:
    """A solution that does not use the wild fixes of a drive; `fixes` then has them as they are."""
    time, position = np.asarray(drive.gnss_time)[wild], np.asarray(drive.gnss_position)[wild]
    rows = np.searchsorted(fixes.time, time - 1e-6)
    here = rows < fixes.time.size
    here[here] = np.abs(fixes.time[rows[here]] - time[here]) < 1e-6
    rows, used = rows[here], fixes.use.copy()
    fixes.use[rows] &= ~1
    solution = solve()
    fixes.use[:] = used
    fixes.value[rows, :3] = position[here]
    return solution


def _engine(
    drive: Drive,
    noise: Noise,
    turn_on: tuple[float, float],
    heading: float | None,
    gnss: Gnss,
) -> LooselyCoupled:
    """The filter that makes the path."""
    model = FilterModel(
        "gap",
        for_search(noise.model),
        turn_on_sd=turn_on,
        flicker="markov",
        effects=(*_correlated(noise), *_vibrations(noise)),
    )
    return LooselyCoupled(
        drive, model, gnss=gnss, heading=heading, remove_bias=False, coarse=LINEAR_STEP
    )


def _jolted(stretches: Sequence[Stretch], restarts: Sequence[float], noise: Noise) -> None:
    """Make the readings about shocks say nothing."""
    terms = [noise.model[c].terms for c in CHANNELS]
    density = np.array([sum(t.N**2 for t in p if isinstance(t, WhiteNoise)) for p in terms])
    jolt = max(min(JOLT, float(np.min(MOST_JOLT**2 / np.maximum(density, 1e-30)))), 1.0)
    for stretch in stretches:
        for when in restarts:
            near = (stretch.time[:-1] > when - 0.3) & (stretch.time[:-1] < when + 0.3)
            stretch.extra_noise[near] = jolt


def _trust_velocities(fixes: Fixes, split: bool = False) -> None:
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


def _correlated(noise: Noise) -> tuple[DriveEffect, ...]:
    """Correlated errors of the positions, which a path must not follow, as effects to be held."""
    if noise.sigma == 0.0:
        return ()
    parameters = {"sigma": noise.sigma, "correlation_time": max(noise.tau, 1e-2)}
    return (DriveEffect("gnss_correlated", parameters),)


def _vibrations(noise: Noise) -> Iterator[DriveEffect]:
    """White noise that follows the speed: without it a path believes its attitude too much."""
    for channel, growth, still in zip(CHANNELS, noise.per_speed, noise.still):
        if growth > 0.0:
            density = sum(t.N**2 for t in noise.model[channel].terms if isinstance(t, WhiteNoise))
            level = density**0.5 if still is None else still
            parameters = {"channel": channel, "N": level, "N_per_speed": growth}
            yield DriveEffect("vibration", parameters)


def replace_sd(drive: Drive, position: float, velocity: float) -> Drive:
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


def _bias(engine: LooselyCoupled, solution: Solution) -> Array:
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
