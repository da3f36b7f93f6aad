"""Two drives shaped on the Turin tests of the 2013 paper, and what its tables print for them.

The paper gives length (17.3 and 15.05 min), the outages' durations and mean speeds (its Tables 6,
9 and 10) and which of them turn; the streets and the order of the outages within a drive are ours.
Each outage is driven at its printed mean speed.
"""

from dataclasses import dataclass

import numpy as np

from imu_lib.published import DURATIONS_TABLE6_2013_S, OUTAGES_2013

from . import trajectory

ORIGIN = (np.radians(45.07), np.radians(7.66), 240.0)  # Turin
KMH = 1.0 / 3.6


@dataclass(frozen=True)
class Outage:
    """An outage: label, drive (1, 2), start s (ours), duration s, mean speed km/h, kind ("turn" or
    "straight"; of Table 6, ours).
    """

    label: str
    drive: int
    start: float
    duration: float
    speed: float
    kind: str


# starts within the drives are ours; labels 1 to 7 are Tables 9 and 10, 1* to 7* are Table 6 (which
# drive each belongs to is not printed)
_PLACES = (
    (1, 180.0, "turn"),
    (1, 420.0, "straight"),
    (1, 720.0, "turn"),
    (2, 150.0, "turn"),
    (2, 300.0, "turn"),
    (2, 450.0, "straight"),
    (2, 700.0, "straight"),
)
_PLACES_TABLE_6 = (
    (1, 270.0, "turn"),
    (1, 340.0, "straight"),
    (1, 560.0, "turn"),
    (1, 640.0, "turn"),
    (1, 860.0, "straight"),
    (2, 560.0, "straight"),
    (2, 800.0, "straight"),
)
OUTAGES = tuple(
    Outage(str(p.number), place[0], place[1], p.duration_s, p.speed_km_h, place[2])
    for p, place in zip(OUTAGES_2013, _PLACES)
)
OUTAGES_TABLE_6 = tuple(
    Outage(f"{p.number}*", place[0], place[1], duration, p.speed_table6_km_h, place[2])
    for p, place, duration in zip(OUTAGES_2013, _PLACES_TABLE_6, DURATIONS_TABLE6_2013_S)
)
# Table 7: levels of decomposition by channel; "three levels" is one less on the y and z axes
# (section 5.6)
LEVELS_TABLE_7 = {"accel_x": 7, "accel_y": 6, "accel_z": 6, "gyro_x": 7, "gyro_y": 7, "gyro_z": 7}
LEVELS_THREE = {"accel_x": 3, "accel_y": 2, "accel_z": 2, "gyro_x": 3, "gyro_y": 2, "gyro_z": 2}
DURATION = {1: 17.3 * 60.0, 2: 15.05 * 60.0}


def outages_of(drive, *, table_6=False):
    """The outages of a drive (1 or 2)."""
    return tuple(o for o in (OUTAGES_TABLE_6 if table_6 else OUTAGES) if o.drive == drive)


def windows(drive, *, table_6=False):
    """The same as (start s, duration s), for `outages.compare`."""
    return tuple((o.start, o.duration) for o in outages_of(drive, table_6=table_6))


def drive(number) -> trajectory.Trajectory:
    """The path of drive 1 or 2: half a minute at rest, then town streets; drive 2 has a stretch of
    motorway.
    """
    if number not in (1, 2):
        raise ValueError(f"`number` must be 1 or 2, not {number!r}")
    rng = np.random.default_rng(2013 + number)
    duration, dt = DURATION[number], 0.5
    time = np.arange(0.0, duration + 10.0, dt)
    speed, turns = _town(rng, duration), []
    for o in sorted(
        (o for o in OUTAGES + OUTAGES_TABLE_6 if o.drive == number), key=lambda o: o.start
    ):
        # around the outage the driver is already at its speed, so that its mean is the printed one
        speed = [(t, v) for t, v in speed if not o.start - 6.0 < t < o.start + o.duration + 6.0]
        wobble = 0.06 * o.speed * KMH
        speed += [(o.start - 4.0, o.speed * KMH)] + [
            (o.start + q * o.duration, o.speed * KMH + s * wobble)
            for q, s in ((0.0, 0.0), (0.25, 1.0), (0.5, 0.0), (0.75, -1.0), (1.0, 0.0))
        ]
        if o.kind == "turn":
            turns.append((o.start + 0.5 * o.duration, rng.choice([-1.0, 1.0]) * np.pi / 2))
    speed = np.array(sorted(speed))
    v = np.interp(time, speed[:, 0], speed[:, 1])
    v = np.convolve(
        np.pad(v, 4, mode="edge"), np.hanning(11)[1:-1] / np.hanning(11).sum(), mode="valid"
    )
    taken = np.array(
        [
            [o.start - 4.0, o.start + o.duration + 4.0]
            for o in OUTAGES + OUTAGES_TABLE_6
            if o.drive == number
        ]
    )
    at = 45.0
    while at < duration - 30.0:  # street corners between the outages, where the car is slow enough
        if (
            not ((at > taken[:, 0] - 5.0) & (at < taken[:, 1] + 5.0)).any()
            and np.interp(at, time, v) < 15.0
        ):
            turns.append((at, rng.choice([-1.0, 1.0, 0.5, -0.5]) * np.pi / 2))
        at += rng.uniform(18.0, 40.0)
    yaw = rng.uniform(-np.pi, np.pi) + 0.02 * np.sin(2.0 * np.pi * time / 47.0) * np.minimum(
        v / 10.0, 1.0
    )
    for when, angle in turns:  # a quarter turn takes 4 s, longer when fast
        length = max(4.0, abs(angle) * np.interp(when, time, v) / 1.8)  # at most 3.4 m/s^2 across
        q = np.clip((time - when) / length + 0.5, 0.0, 1.0)
        yaw = yaw + angle * q**3 * (10.0 - 15.0 * q + 6.0 * q * q)
    slope = 0.015 * np.sin(2.0 * np.pi * time / 131.0 + number) * np.minimum(v / 5.0, 1.0)
    rate = np.column_stack(
        [v * np.cos(yaw) * np.cos(slope), v * np.sin(yaw) * np.cos(slope), -v * np.sin(slope)]
    )
    ned = np.vstack([np.zeros(3), np.cumsum(0.5 * (rate[1:] + rate[:-1]) * dt, axis=0)])
    # braking nods, cornering rolls the body by a degree or two
    push = np.convolve(np.gradient(v, dt), np.ones(3) / 3.0, mode="same")
    lean = np.convolve(v * np.gradient(yaw, dt), np.ones(3) / 3.0, mode="same")
    angles = np.column_stack([-0.008 * lean, slope + 0.006 * push, yaw])
    path = trajectory.from_points(time, ned, ORIGIN, angles=angles)
    return trajectory.Trajectory(path.position, path.angles, 0.0, duration)


def _town(rng, duration):
    """Speeds (s, m/s) of town traffic: at rest for half a minute, then between stops and 55
    km/h.
    """
    points, at = [(0.0, 0.0), (32.0, 0.0)], 42.0
    while at < duration - 25.0:
        if rng.random() < 0.25:
            points += [(at, 0.0), (at + rng.uniform(4.0, 12.0), 0.0)]
            at = points[-1][0] + 8.0
        points.append((at, rng.uniform(25.0, 55.0) * KMH))
        at += rng.uniform(8.0, 25.0)
    return points + [(duration - 15.0, 0.0), (duration + 20.0, 0.0)]
