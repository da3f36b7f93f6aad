"""The order and signs of the axes, from the fixes' own motion: the readings under every order and
sign are held against what the fixes expect (`fix_motion`).
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import permutations, product

import numpy as np
from scipy.spatial.transform import Rotation

from imu_lib.arrays import Array
from imu_lib.drive import Drive

from .fix_motion import STEP, WIDTH, motion

FORCE_SD, RATE_SD = (
    0.5,
    0.05,
)  # m/s^2 and rad/s by which a real vehicle departs from what is expected
LEANING = 2.5  # m/s^2: a case tilted by 15 degrees
IDENTITY = ("+x", "+y", "+z")
CLEAR = 6.0  # least gain of other axes, after tempering, nats
MIRRORED = 3.0  # nats against left-handed axes: no sensor has them, a wrong sign in a file does
#: What is said of a sensor with all its signs turned (`reversed_sensor`).
REVERSED = {
    "accel": "the accelerometers have all signs turned: they read gravity, and not the specific "
    "force, its opposite; multiply `accel` by -1.",
    "gyro": "the gyros have their signs turned: they turn against the course of the fixes, where "
    "the accelerometers agree with it; multiply `gyro` by -1.",
    "either": "the gyros or the accelerometers have all signs turned, in a case that is turned so "
    "that the drive does not show which: an axis that points up reads +9.8 m/s^2 at rest; "
    "multiply `accel` by -1 where it reads -9.8, and `gyro` by -1 where it reads right.",
    "positions": "the fixes' positions are mirrored: their course turns right where the drive "
    "turned left; latitude and longitude are exchanged, or one has its sign turned (west of "
    "Greenwich and south of the equator they are negative).",
}
#: A mirrored course is that of accelerometers with their signs turned, in a case half turned about
#: its y.
_MIRROR = ("-x", "+y", "-z")

#: Steps by which fixes may be late or early: up to six seconds.
_SHIFTS = sorted((int(s / STEP) for s in np.arange(-6.0, 6.1, 0.4)), key=abs)

Names = tuple[str, ...]
#: Permutation, how sure, runner-up, gain in nats, those that cannot be told apart from it.
Found = tuple[Names, float, Names, float, tuple[Names, ...]]


def of(drive: Drive) -> Found:
    """The order and signs of the axes: (permutation, confidence, runner-up, gain in nats,
    indistinguishable).
    """
    m = motion(drive)
    if m is None or m.moving.sum() < 50:
        return IDENTITY, 0.0, IDENTITY, 0.0, ()
    costs = _costs(m, everything())
    temper = _temper(m, min(costs.values()))
    for permutation in costs:
        if mirrored(permutation):
            costs[permutation] += MIRRORED * temper
    order = sorted(costs, key=costs.get)
    first = order[0]
    if not mirrored(first):  # no case can be turned into its mirror image: that is no rival
        order = [p for p in order if not mirrored(p)]
    second = order[1]
    here = costs[IDENTITY]
    gain = (here - costs[first]) / temper
    if first == IDENTITY or gain < CLEAR:
        return IDENTITY, 0.0, first, gain, ()
    apart = (costs[second] - costs[first]) / temper
    alike = tuple(p for p in order[1:] if (costs[p] - costs[first]) / temper < 3.0)
    return first, float(1.0 / (1.0 + np.exp(-apart))), second, float(gain), alike


def reversed_sensor(drive: Drive) -> str:
    """The sensor, "accel" or "gyro", that with all its signs turned fits the fixes and the other
    one clearly better than both do under any order and sign of the axes; "either" where the
    two do so alike; "" where neither does. "positions" where mirrored ones alone would do the same
    to a case that is not turned.
    """
    m = motion(drive)
    if m is None or m.moving.sum() < 50:
        return ""
    rigid = [p for p in everything() if not mirrored(p)]
    there: dict[str, float] = {}
    axes_then: dict[str, Names] = {}
    for sensor, signs in (("gyro", [-1.0, 1.0]), ("accel", [1.0, -1.0])):
        turned = replace(m, readings=m.readings * np.repeat(signs, 3))
        costs = _costs(turned, rigid, LEANING)
        axes_then[sensor] = min(costs, key=costs.__getitem__)
        there[sensor] = costs[axes_then[sensor]]
    best = min(there, key=lambda sensor: there[sensor])
    here = min(_costs(m, everything(), LEANING).values())
    temper = _temper(m, there[best])
    if (here - there[best]) / temper < CLEAR:
        return ""
    if axes_then["accel"] == _MIRROR:
        return "positions"
    return best if abs(there["gyro"] - there["accel"]) / temper > CLEAR else "either"


def _costs(m, tried, leaning=0.0):
    """{permutation: misfit, nats as if samples were independent, at the best of a few seconds};
    leaning: m/s^2 by which a tilted case or a bias may move each force.
    """
    tried, readings = list(tried), m.readings.copy()
    if (~m.moving).sum() > 50:
        readings[:, :3] -= np.median(readings[:, :3][~m.moving], axis=0)
    placed = {(i, entry) for p in tried for i, entry in enumerate(p)}
    out = dict.fromkeys(tried, np.inf)
    for shift in _SHIFTS:
        seen, felt, weight = _shifted(m, readings, shift)
        # every order and sign is a sum over the file's axes, each at one place with one sign
        alone = {(i, entry): weight * _axis(seen, felt, i, entry, leaning) for i, entry in placed}
        for p in tried:
            out[p] = min(out[p], sum(alone[place] for place in enumerate(p)))
    return out


def _axis(seen, felt, i, entry, leaning=0.0):
    """Misfit of the file's axis i, gyro and accelerometer, where `entry` says that it points."""
    sign, j = (1.0 if entry[0] == "+" else -1.0), "xyz".index(entry[1])
    force = seen[:, 3 + j] - sign * felt[:, 3 + i]
    if leaning and len(force):
        force = force - np.clip(np.median(force), -leaning, leaning)
    return _misfit((seen[:, j] - sign * felt[:, i]) / RATE_SD) + _misfit(force / FORCE_SD)


def _misfit(z):
    """What differences z, standard deviations, cost: those far out are not let decide, nats."""
    z = np.abs(z)
    return float(np.where(z < 3.0, 0.5 * z**2, 3.0 * z - 4.5).sum())


def _shifted(m, readings, shift):
    """What is expected and what is read so many steps apart where the vehicle moves, (k, 6) each,
    and what a sample then counts.
    """
    n = m.time.size
    a = slice(max(shift, 0), n + min(shift, 0))
    b = slice(max(-shift, 0), n - max(shift, 0))
    keep = m.moving[a]
    return m.expected[a][keep], readings[b][keep], float(m.moving.sum() / max(keep.sum(), 1))


def _temper(m, least):
    """By how much less than independent ones the samples count: smoothed readings repeat themselves
    for WIDTH seconds.
    """
    return WIDTH / STEP * 5.0 * max(1.0, least / max(m.moving.sum() * 3.0, 1.0))


def turn(drive: Drive) -> tuple[Array, float]:
    """How the case is turned in the vehicle, by the fixes' own motion: (roll, pitch, yaw rad, gain
    in nats over a case that is not turned); zeros where the drive does not say.
    """
    m = motion(drive)
    if m is None or m.moving.sum() < 50:
        return np.zeros(3), 0.0
    readings = m.readings.copy()
    if (~m.moving).sum() > 50:
        readings[:, :3] -= np.median(readings[:, :3][~m.moving], axis=0)
    best = None
    for shift in _SHIFTS:
        seen, felt, weight = _shifted(m, readings, shift)
        if len(seen) < 50:
            continue
        # least squares of a rotation between vectors (Wahba 1965; Kabsch 1976)
        to = np.vstack([seen[:, :3] / RATE_SD, seen[:, 3:] / FORCE_SD])
        of = np.vstack([felt[:, :3] / RATE_SD, felt[:, 3:] / FORCE_SD])
        turned, _ = Rotation.align_vectors(to, of)
        felt = np.column_stack([turned.apply(felt[:, :3]), turned.apply(felt[:, 3:])])
        cost = weight * sum(_axis(seen, felt, i, "+" + "xyz"[i]) for i in range(3))
        if best is None or cost < best[0]:
            best = cost, turned
    here = _costs(replace(m, readings=readings), [IDENTITY])[IDENTITY]
    gain = (here - best[0]) / _temper(m, best[0])
    return best[1].as_euler("ZYX")[::-1], float(gain)


def to_body(permutation: Sequence[str]) -> Array:
    """Matrix from the file's axes into the body's: column i is where the file's axis i points."""
    c = np.zeros((3, 3))
    for i, entry in enumerate(permutation):
        c["xyz".index(entry[1]), i] = 1.0 if entry[0] == "+" else -1.0
    return c


def of_matrix(c: Array) -> tuple[str, ...]:
    """The axes whose matrix (`to_body`) is c (3, 3), of noughts and ones with their signs."""
    rows = np.abs(c).argmax(axis=0)
    return tuple(("+" if c[r, i] > 0.0 else "-") + "xyz"[r] for i, r in enumerate(rows))


def nearest(turn: Rotation) -> tuple[tuple[str, ...], float]:
    """The rigid axes nearest to a rotation of the file's axes into the body's, and how far it is
    from them, rad.
    """
    rigid = [p for p in everything() if not mirrored(p)]
    apart = [float((Rotation.from_matrix(to_body(p)).inv() * turn).magnitude()) for p in rigid]
    k = int(np.argmin(apart))
    return rigid[k], apart[k]


def mirrored(permutation: Sequence[str]) -> bool:
    """Whether the axes are left-handed."""
    return bool(np.linalg.det(to_body(permutation)) < 0.0)


def everything() -> Iterator[tuple[str, ...]]:
    """All 48 orders and signs of three axes."""
    for order in permutations("xyz"):
        for signs in product("+-", repeat=3):
            yield tuple(s + a for s, a in zip(signs, order))
