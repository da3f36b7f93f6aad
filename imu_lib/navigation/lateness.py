"""By how much the stamps of the fixes are late, from turns and accelerations that the fixes show
and the readings feel (`fix_motion`).
"""

import numpy as np

from imu_lib.drive import Drive

from .fix_motion import STEP, WIDTH, changes, motion

LATEST, FURTHEST = 12.0, 90.0  # s: where a match is looked for, and where else if there is none
MATCHED = 2.0  # nats: chance alone, of one shift, exceeds them once in twenty
SURE_MATCH = 0.7  # correlation that a match further away needs


def late(drive: Drive) -> tuple[float, float]:
    """Time by which the fixes' stamps are late, s, and the correlation there, of turn rates and of
    accelerations; 0 where the drive does not say, or agrees nearly as well as it stands.
    """
    m = motion(drive)
    offset, likeness, here = _match(m)
    if likeness >= here + 0.05 or _gain(m, likeness, here) > MATCHED:
        return offset, likeness
    return 0.0, likeness


def best_match(drive: Drive) -> tuple[float, float, float]:
    """Time by which the fixes are late where their turns and accelerations match those felt best,
    s, the correlation there, and as the stamps stand; 0 where nothing matches. A few hundredths of
    a second are what smoothing does differently to the two.
    """
    return _match(motion(drive))


def _match(m):
    """As `best_match`, of a drive's `fix_motion.Motion` or None."""
    if m is None or m.moving.sum() < 200:
        return 0.0, 0.0, 0.0
    seen = [
        k
        for k, least in ((2, 0.015), (3, 0.15))
        if np.std(m.expected[m.moving, k]) > least and changes(m.readings[m.moving, k])
    ]
    if not seen:
        return 0.0, 0.0, 0.0
    found = None
    for furthest, least in ((LATEST, 0.5), (FURTHEST, SURE_MATCH)):
        if furthest > LATEST and (found is not None or m.time.size * STEP < 2.0 * furthest):
            break
        steps = int(furthest / STEP)
        shifts = np.arange(-steps, steps + 1)
        values = np.array([np.mean([_alike(m, c, k) for c in seen]) for k in shifts])
        k = int(np.argmax(values))
        if values[k] >= least and k not in (0, values.size - 1):
            found = k
            break
    if found is None:
        return 0.0, float(values[k]), float(values[steps])
    left, mid, right = values[k - 1 : k + 2]
    curve = left - 2 * mid + right
    peak = shifts[k] + (0.5 * (left - right) / curve if curve < 0 else 0.0)
    return float(peak * STEP), float(values[k]), float(values[steps])


def _alike(m, column, shift):
    """Correlation of what the fixes say with what was felt `shift` steps before."""
    n = m.time.size
    a = slice(max(shift, 0), n + min(shift, 0))
    b = slice(max(-shift, 0), n - max(shift, 0))
    keep = m.moving[a]
    if keep.sum() < 100:
        return 0.0
    return float(np.corrcoef(m.expected[a, column][keep], m.readings[b, column][keep])[0, 1])


def of_halves(drive: Drive) -> tuple[float, ...] | None:
    """`late` of the first and of the second half of a drive, s; None where one of them does
    not say.
    """
    middle = 0.5 * (drive.time[0] + drive.time[-1])
    out = []
    for before in (True, False):
        kept = (drive.gnss_time < middle) == before
        if kept.sum() < 2:
            return None
        offset, likeness = late(drive.with_fixes(kept))
        if likeness < SURE_MATCH:
            return None
        out.append(offset)
    return tuple(out)


def _gain(m, likeness, here):
    """Nats by which one correlation explains more than another, of samples WIDTH seconds apart."""
    if m is None or not -1.0 < here < likeness < 1.0:
        return 0.0
    left = (1.0 - here**2) / (1.0 - likeness**2)
    return 0.5 * m.moving.sum() * STEP / WIDTH * float(np.log(max(left, 1.0)))
