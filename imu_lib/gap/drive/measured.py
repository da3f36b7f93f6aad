"""What is measured along a path: predicted minus measured at the fixes of a stretch, and what each
parameter does to it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from imu_lib.arrays import Array
from imu_lib.gap.drive.legs import Leg
from imu_lib.navigation import attitude, earth
from imu_lib.processes import WhiteNoise
from imu_lib.record import CHANNELS

from . import columns

if TYPE_CHECKING:
    from imu_lib.gap.drive.problem import Noise
    from imu_lib.navigation.preparation import Fixes
    from imu_lib.navigation.stretch import Stretch

SETTLED = 3.0  # times its median standard deviation: from here on a heading is known
SMOOTH = 0.08  # s over which readings about a fix are averaged


def at_fixes(
    stretch: Stretch, epochs: Array, bias: Array, span: float
) -> tuple[Array, Array, Array, Array]:
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


def span_of(noise: Noise, fixes: Fixes, lever: Array) -> float:
    """Time over which turn rates are averaged, s: two samples, unless the gyros' own noise would
    then move an antenna by more than a share of the velocities' standard deviation.
    """
    velocity = fixes.use & 2 > 0
    if not velocity.any():
        return SMOOTH
    sd = float(np.median(np.sqrt(fixes.variance[velocity, 3:])))
    density = max(
        (t.N for c in CHANNELS[:3] for t in noise.model[c].terms if isinstance(t, WhiteNoise)),
        default=0.0,
    )
    least = 0.3 * sd / max(float(np.linalg.norm(lever)), 1.0)
    return min((density / least) ** 2, SMOOTH)


def _gained(leg: Leg, force: Array) -> tuple[Array, Array]:
    """Velocity gained since the start of a leg, NED, without the jumps that fixes make: (time
    (k,), (k, 3) m/s).
    """
    stretch = leg.stretch
    part = slice(leg.first, min(leg.first + len(leg.angles), len(force)))
    c = attitude.matrix(leg.angles[: part.stop - part.start])
    f = np.einsum("nij,nj->ni", c, force[part])
    f[:, 2] += earth.gravity(*leg.position[0, ::2])
    dt = stretch.dt[part]
    return stretch.time[part] + dt, np.cumsum(f * dt[:, None], axis=0)


@dataclass
class Measured:
    """Of each fix: y, use (f, 6) predicted minus measured and whether it is taken; arm_rows (f, 3,
    3) rows of the attitude error; d (f, 6, columns.IN_FIXES) what parameters do to y; along:
    course, speed, turn rate, accelerations and temperature.
    """

    y: np.ndarray
    use: np.ndarray
    arm_rows: np.ndarray
    d: np.ndarray
    along: dict[str, Array]

    @classmethod
    def empty(cls, count: int) -> Measured:
        names = ("course", "speed", "turn", "ahead", "aside", "warmth")
        return cls(
            np.zeros((count, 6)),
            np.zeros((count, 6), bool),
            np.zeros((count, 3, 3)),
            np.zeros((count, 6, len(columns.IN_FIXES))),
            {k: np.zeros(count) for k in names},
        )

    def fill(
        self,
        leg: Leg,
        fixes: Fixes,
        at: tuple[Array, Array, Array, Array],
        lever: Array,
        time: Array,
    ) -> None:
        """At the fixes of a leg; at: of `at_fixes`; time: the drive's, s."""
        w, turning, f, f_all = at
        stretch, epochs, rows = leg.stretch, leg.epochs, leg.fixes
        now = leg.at(epochs)
        c_now = attitude.matrix(attitude.euler(now.quaternion))
        # columns are what was known before the fix: its own noise in them would look like an effect
        before = np.maximum(epochs - 1, leg.first)
        old = leg.at(before)
        step = np.where(epochs > before, stretch.dt[before], 0.0)[:, None]
        c = attitude.matrix(attitude.euler(old.quaternion))
        c = c @ Rotation.from_rotvec(w * step).as_matrix()
        acc = np.einsum("nij,nj->ni", c, f)
        acc[:, 2] += [earth.gravity(p[0], p[2]) for p in now.position]
        delay = (stretch.time[epochs] - fixes.time[rows])[:, None]
        arm, spin = _of_arm(c_now, w, lever)
        value = fixes.value[rows]
        back = now.velocity * delay - 0.5 * acc * delay**2
        self.y[rows, :3] = earth.meters(now.position, value[:, :3]) + arm - back
        self.y[rows, 3:] = now.velocity + spin - value[:, 3:] - acc * delay
        bits = fixes.use[rows]
        self.use[rows, :3] = ((bits & 1) > 0)[:, None]
        self.use[rows, 3:] = ((bits & 2) > 0)[:, None]
        self.arm_rows[rows] = _across(arm)
        about = np.cross(w, np.cross(w, lever)) + np.cross(turning, lever)
        antenna = acc + np.einsum("nij,nj->ni", c, about)
        slow = _smoothing(leg, f_all, fixes.time[rows]), acc
        _columns(self.d[rows], fixes.time[rows], (old.velocity + acc * step, antenna), slow, time)
        sd = leg.sd[np.clip(epochs - leg.first, 0, len(leg.sd) - 1), 2]
        _arm_columns(self.d[rows], _settled(c, c_now, sd), w)
        course = np.arctan2(now.velocity[:, 1], now.velocity[:, 0])
        speed = np.hypot(now.velocity[:, 0], now.velocity[:, 1])
        found = {
            "course": course,
            "speed": speed,
            "turn": w[:, 2],
            "ahead": acc[:, 0] * np.cos(course) + acc[:, 1] * np.sin(course),
            # of the turn: the force aside errs by the roll, as the innovations do
            "aside": speed * np.einsum("ni,ni->n", c[:, 2], w),
            "warmth": leg.drifts[np.clip(epochs, 0, len(leg.drifts) - 1), 0],
        }
        for name, values in found.items():
            self.along[name][rows] = values

    def displace(self, after: Array) -> None:
        """Enter what a displacement of some fixes (f,) does to them, if any: in the place of those
        after a part of the drive, which would be the same once more.
        """
        if not after.any():
            return
        for effect in columns.DISPLACED_AFTER.values():
            self.d[:, :, [columns.IN_FIXES.index(k) for k in columns.of(effect)]] = 0.0
        for i, k in enumerate(columns.of(columns.MOVED)):
            self.d[:, i, columns.IN_FIXES.index(k)] = -1.0 * after


def _across(arm: Array) -> Array:
    """[arm x] of (n, 3), (n, 3, 3)."""
    out = np.zeros((len(arm), 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        out[:, i, k], out[:, i, j] = arm[:, j], -arm[:, k]
    return out


def _columns(
    out: Array,
    when: Array,
    moving: tuple[Array, Array],
    slow: tuple[Array, Array],
    time: Array,
) -> None:
    """What parameters do to fixes at times `when`, into out (n, 6, columns.IN_FIXES).

    moving : velocity of the sensor and acceleration of the
    antenna; slow : what smoothing takes from a velocity, and acceleration; time : the drive's, s
    """
    place = {of: k for k, of in enumerate(columns.IN_FIXES)}

    def column(effect: str, number: int = 0) -> int:
        return place[columns.of(effect)[number]]

    velocity, antenna = moving
    out[:, :3, column("gnss_time_offset", 0)] = velocity
    out[:, 3:, column("gnss_time_offset", 1)] = antenna
    k = column("imu_clock")
    out[:, :3, k] = -when[:, None] * velocity
    out[:, 3:, k] = -when[:, None] * antenna
    lacks, acc = slow
    for i, tau in enumerate(columns.SMOOTHED):
        # its delay is the velocity's time offset, which the filter knows
        out[:, 3:, column("other: receiver's velocity is smoothed", i)] = lacks[i] - tau * acc
    for part, share in columns.DISPLACED.items():
        after = when > time[0] + share * (time[-1] - time[0])
        for i in range(3):
            out[:, i, column(columns.DISPLACED_AFTER[part], i)] = -1.0 * after
    for i in range(3):
        out[:, 3 + i, column("other: receiver's velocity is offset", i)] = -1.0


def _settled(c: Array, c_now: Array, sd: Array) -> Array:
    """Attitudes c (n, 3, 3) before fixes as they turn out once the heading is known: of a car that
    stands it is found when it drives off, and an arm that swung with the guesses until then would
    seem to have moved the antenna. c_now : after the fixes; sd (n,) of their headings, rad
    """
    known = sd < SETTLED * np.median(sd)
    end = int(np.argmax(known)) if known.any() else len(sd)
    jumps = np.einsum("nij,nkj->nik", c_now[:end], c[:end])
    later = np.zeros((len(c), 3))
    later[:end, 2] = np.cumsum(0.5 * (jumps[:, 1, 0] - jumps[:, 0, 1])[::-1])[::-1]
    return np.asarray(Rotation.from_rotvec(later).as_matrix() @ c)


def _of_arm(c: Array, w: Array, arm: Array) -> tuple[Array, Array]:
    """Place and velocity of the end of an arm (3,) against the sensor's, (n, 3) each; c, w :
    attitude and turn rate.
    """
    spin = np.einsum("nij,nj->ni", c, np.cross(w, arm))
    return np.einsum("nij,j->ni", c, arm), spin


def _arm_columns(out: Array, c: Array, w: Array) -> None:
    """What a lever arm does to fixes, into out (n, 6, columns.IN_FIXES); c, w : attitude and turn
    rate there.
    """
    for k, unit in zip(columns.of("lever_arm"), np.eye(3)):
        place = columns.IN_FIXES.index(k)
        out[:, :3, place], out[:, 3:, place] = (-v for v in _of_arm(c, w, unit))


def _smoothing(leg: Leg, force: Array, when: Array) -> Array:
    """Velocity minus its first-order low-passes, (columns.SMOOTHED, n, 3): from the IMU alone,
    since a velocity that holds the fixes' own noise would seem to explain it.
    """
    time, total = _gained(leg, force)
    step, out = float(np.median(np.diff(time))), []
    for tau in columns.SMOOTHED:
        keep = np.exp(-step / tau)
        slow = lfilter([1.0 - keep], [1.0, -keep], total, axis=0, zi=keep * total[:1])[0]
        out.append(np.column_stack([np.interp(when, time, x) for x in (total - slow).T]))
    return np.array(out)
