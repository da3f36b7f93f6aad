"""True motion of made-up vehicles, without `imu_lib.navigation`: see `drive_generator`."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter1d
from scipy.signal import oaconvolve
from scipy.spatial.transform import Rotation

A, F, OMEGA = 6378137.0, 1 / 298.257223563, 7.292115e-5
E2 = F * (2 - F)
FINE = 400.0  # Hz, of the grid on which motion is built


@dataclass
class Motion:
    """True motion on the fine grid."""

    t: np.ndarray
    lla: np.ndarray
    velocity: np.ndarray
    attitude: Rotation
    euler: np.ndarray
    gyro: np.ndarray
    accel: np.ndarray


def smoothed(x, sd):
    """`gaussian_filter1d`, of kernels of thousands of samples, by the Fourier transform."""
    half = int(4.0 * sd + 0.5)
    kernel = np.exp(-0.5 * (np.arange(-half, half + 1) / sd) ** 2)
    return oaconvolve(np.pad(x, half, mode="symmetric"), kernel / kernel.sum(), mode="valid")


def commands(kind, t, rng):
    """Speed m/s, course rad, slope rad on the grid: "town" excites, "motorway" little, "straight"
    never turns, "bus" stands often and long, "tractor" creeps and turns about, "motorcycle" is quick.
    """
    n = t.size

    def steps(low, high, shortest, longest, values=None):
        out, k = np.empty(n), 0
        while k < n:
            m = int(rng.uniform(shortest, longest) * FINE)
            out[k : k + m] = rng.uniform(low, high) if values is None else rng.choice(values)
            k += m
        return out

    if kind == "town":
        speed = steps(4.0, 17.0, 8.0, 25.0)
        stops = steps(0, 1, 6.0, 14.0, [0, 0, 0, 0, 1]) > 0
        speed[stops] = 0.0
        turn = steps(0, 0, 3.0, 7.0, [0, 0, 0, 0.25, -0.25, 0.12, -0.12, 0.4, -0.4])
    elif kind == "motorway":
        speed = steps(26.0, 34.0, 20.0, 60.0)
        turn = steps(-0.02, 0.02, 10.0, 30.0)
    elif kind == "bus":
        speed = steps(6.0, 13.0, 12.0, 30.0)
        speed[steps(0, 1, 15.0, 40.0, [0, 0, 1]) > 0] = 0.0
        turn = steps(0, 0, 5.0, 10.0, [0, 0, 0, 0, 0.15, -0.15, 0.2, -0.2])
    elif kind == "tractor":
        speed = steps(1.5, 5.0, 20.0, 60.0)
        turn = steps(0, 0, 6.0, 12.0, [0, 0, 0, 0.25, -0.25])
    elif kind == "motorcycle":
        speed = steps(8.0, 28.0, 5.0, 15.0)
        turn = steps(0, 0, 3.0, 8.0, [0, 0, 0.15, -0.15, 0.25, -0.25])
    else:
        speed = steps(10.0, 25.0, 15.0, 40.0)
        turn = np.zeros(n)
    standing = t < 20.0
    speed[standing], turn[standing] = 0.0, 0.0
    speed = smoothed(speed, 2.2 * FINE)
    speed = np.maximum(speed - 0.02, 0.0)
    speed = gaussian_filter1d(speed, 0.2 * FINE)
    turn = smoothed(turn, 0.8 * FINE) * np.minimum(speed / 5.0, 1.0)
    slope = smoothed(steps(-0.04, 0.04, 10.0, 40.0), 4.0 * FINE)
    course = rng.uniform(-np.pi, np.pi) + np.cumsum(turn) / FINE
    return speed, course, slope


def radii(lat):
    w = 1 - E2 * np.sin(lat) ** 2
    return A * (1 - E2) / w**1.5, A / np.sqrt(w)


def ned_to_ecef(lat, lon):
    """Rotation matrices (n, 3, 3)."""
    sl, cl, so, co = np.sin(lat), np.cos(lat), np.sin(lon), np.cos(lon)
    z = np.zeros_like(lat)
    return np.stack(
        [
            np.stack([-sl * co, -so, -cl * co], -1),
            np.stack([-sl * so, co, -cl * so], -1),
            np.stack([cl, z, -sl], -1),
        ],
        -2,
    )


def plumb(lat, h):
    """Normal gravity, m/s^2 (Somigliana, second order in height)."""
    s2 = np.sin(lat) ** 2
    g0 = 9.7803253359 * (1 + 1.931852652458e-3 * s2) / np.sqrt(1 - E2 * s2)
    m = OMEGA**2 * A**3 * (1 - F) / 3.986004418e14
    return g0 * (1 - 2 / A * (1 + F * (1 - 2 * s2) + m) * h + 3 * h**2 / A**2)


@lru_cache(maxsize=4)
def drawn(seed, kind, duration, rough=0.0, slip=0.0):
    """The motion that a seed draws first, and the state of its generator after that: many tests put
    one effect after the other into the same motion.
    """
    rng = np.random.default_rng(seed)
    return motion(kind, duration, rng, rough=rough, slip=slip), rng.bit_generator.state


def motion(kind, duration, rng, origin=(0.84, 0.15, 300.0), rough=0.0, slip=0.0):
    """A vehicle's motion: nose along the path, a little roll in curves.

    rough : rad, sd of roll and pitch on the springs; slip : rad per m/s^2 across
    """
    t = np.arange(int((duration + 2.0) * FINE)) / FINE
    speed, course, slope = commands(kind, t, rng)
    v = np.stack(
        [
            speed * np.cos(slope) * np.cos(course),
            speed * np.cos(slope) * np.sin(course),
            -speed * np.sin(slope),
        ],
        -1,
    )

    def total(x):
        return np.concatenate([[0.0], np.cumsum(0.5 * (x[1:] + x[:-1])) / FINE])

    h = origin[2] + total(-v[:, 2])
    lat = origin[0] + total(v[:, 0]) / (radii(origin[0])[0] + origin[2])
    for _ in range(3):
        lat = origin[0] + total(v[:, 0] / (radii(lat)[0] + h))
    lon = origin[1] + total(v[:, 1] / ((radii(lat)[1] + h) * np.cos(lat)))
    lateral = speed * np.gradient(course, t)
    lean = 1.0 / 9.8 if kind == "motorcycle" else -0.004  # into the curve, or out of it
    roll = np.arctan(lean * gaussian_filter1d(lateral, 0.3 * FINE))
    pitch = slope + 0.0
    if rough:  # the body on its springs; the path of its centre stays
        for angle in (roll, pitch):
            shaken = gaussian_filter1d(rng.standard_normal(t.size), 0.08 * FINE)
            angle += rough * (0.3 + speed / 15.0) * shaken / np.std(shaken)
    yaw = course
    if slip:  # the nose points into the curve's inside by as much as the tyres slip
        yaw = course - slip * smoothed(lateral, 0.5 * FINE)
    euler = np.stack([roll, pitch, yaw], -1)
    c_nb = Rotation.from_euler("ZYX", euler[:, ::-1])
    c_en = ned_to_ecef(lat, lon)
    v_e = np.einsum("nij,nj->ni", c_en, v)
    a_e = CubicSpline(t, v_e)(t, 1)
    w = np.array([0.0, 0.0, OMEGA])
    g_e = c_en[:, :, 2] * plumb(lat, h)[:, None]  # gravity holds the centrifugal part already
    f_e = a_e + 2 * np.cross(w, v_e) - g_e
    c_eb = Rotation.from_matrix(c_en) * c_nb
    accel = c_eb.inv().apply(f_e)
    spin = Rotation.from_rotvec(t[:, None] * w)  # Earth-fixed axes seen from inertial ones
    c_ib = spin * c_eb
    gyro = np.vstack([(c_ib[:-1].inv() * c_ib[1:]).as_rotvec() * FINE, np.zeros(3)])
    return Motion(t, np.stack([lat, lon, h], -1), v, c_nb, euler, gyro, accel)
