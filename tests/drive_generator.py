"""Drives with known faults, made without `imu_lib.navigation`: what the gap workflow is tried on.

A car is steered by commands of speed, turn rate and slope; its motion is differentiated in the
Earth-centred frame, where the navigation package works in north-east-down. Errors are drawn here
too, effect by effect, from the definitions of the file format alone.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter1d
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

A, F, OMEGA = 6378137.0, 1 / 298.257223563, 7.292115e-5
E2 = F * (2 - F)
FINE = 400.0  # Hz, of the grid on which motion is built
DEG = np.pi / 180

MODEL = {
    "name": "drive generator",
    **{
        f"gyro_{a}": [
            {"process": "white_noise", "N": 8e-5},
            {"process": "gauss_markov", "sigma": 1e-4, "correlation_time": 300.0},
        ]
        for a in "xyz"
    },
    **{
        f"accel_{a}": [
            {"process": "white_noise", "N": 1.5e-3},
            {"process": "gauss_markov", "sigma": 4e-3, "correlation_time": 300.0},
        ]
        for a in "xyz"
    },
}


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


def commands(kind, t, rng):
    """Speed m/s, course rad, slope rad on the grid: "town" excites, "motorway" little, "straight"
    never turns.
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
    else:
        speed = steps(10.0, 25.0, 15.0, 40.0)
        turn = np.zeros(n)
    standing = t < 20.0
    speed[standing], turn[standing] = 0.0, 0.0
    speed = gaussian_filter1d(speed, 2.2 * FINE)
    speed = np.maximum(speed - 0.02, 0.0)
    speed = gaussian_filter1d(speed, 0.2 * FINE)
    turn = gaussian_filter1d(turn, 0.8 * FINE) * np.minimum(speed / 5.0, 1.0)
    slope = gaussian_filter1d(steps(-0.04, 0.04, 10.0, 40.0), 4.0 * FINE)
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


def motion(kind, duration, rng, origin=(0.84, 0.15, 300.0)):
    """A car's motion: nose along the path, a little roll in curves."""
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
    euler = np.stack([-0.004 * gaussian_filter1d(lateral, 0.3 * FINE), slope, course], -1)
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


def imu_means(m, rate, clock=0.0):
    """Stamps (true time of interval ends) and means of rate and specific force over intervals."""
    k = int(FINE / rate)
    n = (m.t.size - 1) // k - 1
    gyro = m.gyro[: n * k].reshape(n, k, 3).mean(1)
    inner = m.accel[: n * k + 1]
    trapezoid = 0.5 * (inner[1:] + inner[:-1])
    accel = trapezoid.reshape(n, k, 3).mean(1)
    return m.t[k : (n + 1) * k : k][:n], gyro, accel


def gauss_markov(n, dt, sigma, tau, rng):
    phi = np.exp(-dt / tau)
    w = rng.standard_normal(n) * sigma * np.sqrt(1 - phi**2)
    w[0] = sigma * rng.standard_normal()
    return lfilter([1.0], [1.0, -phi], w)


def noise(entries, n, rate, rng):
    """Sum of the processes that MODEL uses, at `rate`."""
    out = np.zeros(n)
    for e in entries:
        kind = e["process"]
        if kind == "white_noise":
            out += e["N"] * np.sqrt(rate) * rng.standard_normal(n)
        elif kind == "gauss_markov":
            out += gauss_markov(n, 1 / rate, e["sigma"], e["correlation_time"], rng)
        elif kind == "random_walk":
            out += np.cumsum(e["K"] / np.sqrt(rate) * rng.standard_normal(n))
    return out


def matrix6(values):
    xy, xz, yx, yz, zx, zy = values
    return np.array([[0, xy, xz], [yx, 0, yz], [zx, zy, 0]])


def make(
    seed,
    *,
    kind="town",
    duration=600.0,
    rate=100.0,
    gnss_rate=5.0,
    velocity=True,
    effects=(),
    unknown=(),
    position_sd=(0.8, 0.8, 1.5),
    velocity_sd=(0.06, 0.06, 0.09),
    turn_on=(0.1 * DEG, 0.05),
    temperature=True,
    moving_start=False,
    noiseless=False,
):
    """Arrays of a drive, for effects [(name, parameters)] and unknown ones by name (see below)."""
    rng = np.random.default_rng(seed)
    m = motion(kind, duration, rng)
    found = dict(effects)
    scale_clock = found.get("imu_clock", {}).get("scale", 0.0)
    t, gyro, accel = imu_means(m, rate)
    if moving_start:
        keep = t > 35.0
        t, gyro, accel = t[keep], gyro[keep], accel[keep]
    start, n = t[0], t.size
    at = np.clip((t * FINE).astype(int), 0, m.t.size - 1)
    speed = np.linalg.norm(m.velocity[at], axis=1)
    warmth = 20.0 + 15.0 * (1 - np.exp(-(t - start) / 200.0))
    out_g, out_a = gyro.copy(), accel.copy()
    if "mounting" in found:
        e = found["mounting"]
        c = Rotation.from_euler("ZYX", [e["yaw"], e["pitch"], e["roll"]])
        out_g, out_a = c.inv().apply(out_g), c.inv().apply(out_a)
    f, w = out_a.copy(), out_g.copy()
    for name, true, out in (("accel", f, out_a), ("gyro", w, out_g)):
        if f"{name}_scale" in found:
            out += true * np.asarray(found[f"{name}_scale"]["scale"])
        if f"{name}_misalignment" in found:
            out += true @ matrix6(found[f"{name}_misalignment"]["matrix"]).T
    if "gyro_g_sensitivity" in found:
        out_g += f @ np.reshape(found["gyro_g_sensitivity"]["matrix"], (3, 3)).T
    bias_g = np.asarray(
        found.get("gyro_bias", {}).get("bias", turn_on[0] * rng.standard_normal(3)), float
    )
    bias_a = np.asarray(
        found.get("accel_bias", {}).get("bias", turn_on[1] * rng.standard_normal(3)), float
    )
    model = {k: [dict(p) for p in v] if isinstance(v, list) else v for k, v in MODEL.items()}
    for name, e in effects:
        if name == "bias_model":
            for p in model[e["channel"]]:
                if p["process"] == e["process"]:
                    p[e["name"]] = e["to"]
    if not noiseless:
        out_g += bias_g
        out_a += bias_a
        for i, a in enumerate("xyz"):
            out_g[:, i] += noise(model[f"gyro_{a}"], n, rate, rng)
            out_a[:, i] += noise(model[f"accel_{a}"], n, rate, rng)
    if "vibration" in found:
        e = found["vibration"]
        out = out_g if e["channel"].startswith("gyro") else out_a
        # the model's own white noise stays; what is added fills up to N^2 + (N_per_speed v)^2
        held = next(p["N"] for p in MODEL[e["channel"]] if p["process"] == "white_noise")
        extra = np.sqrt(np.maximum(e["N"] ** 2 - held**2 + (e["N_per_speed"] * speed) ** 2, 0.0))
        out[:, "xyz".index(e["channel"][-1])] += extra * np.sqrt(rate) * rng.standard_normal(n)
    if "temperature_bias" in unknown:
        out_g[:, 2] += 2.5e-4 * (warmth - 27.5)
        out_g[:, 1] -= 1.5e-4 * (warmth - 27.5)
    if "pothole" in unknown:
        when = int(0.6 * n)
        span = int(0.12 * rate)
        out_a[when : when + span] += np.array([25.0, 12.0, -40.0])
        out_g[when : when + span] += np.array([0.9, 0.5, 0.3])
    # -- fixes
    first = start if moving_start else 0.0
    stamps = np.arange(np.ceil(first * gnss_rate + 0.5) / gnss_rate, t[-1] - 1e-9, 1 / gnss_rate)
    offset = found.get("gnss_time_offset", {}).get("offset", 0.0)
    v_offset = found.get("gnss_time_offset", {}).get("velocity_offset", offset)
    arm = np.asarray(found.get("lever_arm", {}).get("arm", np.zeros(3)), float)

    def truth(when):
        when = np.clip(when, 0.0, m.t[-1])
        pos = np.stack([np.interp(when, m.t, c) for c in m.lla.T], -1)
        k = np.clip((when * FINE).astype(int), 0, m.t.size - 1)
        c, spin = m.attitude[k], m.gyro[k]
        moved = c.apply(np.tile(arm, (k.size, 1)))
        rm, rn = radii(pos[:, 0])
        pos[:, 0] += moved[:, 0] / (rm + pos[:, 2])
        pos[:, 1] += moved[:, 1] / ((rn + pos[:, 2]) * np.cos(pos[:, 0]))
        pos[:, 2] -= moved[:, 2]
        vel = np.stack([np.interp(when, m.t, c) for c in m.velocity.T], -1)
        return pos, vel + c.apply(np.cross(spin, arm))

    pos, vel = truth(stamps - offset)[0], truth(stamps - v_offset)[1]
    if "velocity_low_pass" in unknown:
        tau = 0.5
        alpha = 1 - np.exp(-1 / (FINE * tau))
        slow = lfilter([alpha], [1, alpha - 1], m.velocity, axis=0)
        vel = np.stack([np.interp(stamps, m.t, c) for c in slow.T], -1)
    q = stamps.size
    psd, vsd = np.array(position_sd), np.array(velocity_sd)
    ratio = {"position": 1.0, "velocity": 1.0}
    for name, e in effects:
        if name == "gnss_noise":
            ratio[e["of"]] = e["ratio"]
    error = rng.standard_normal((q, 3)) * psd * ratio["position"] * (not noiseless)
    v_error = rng.standard_normal((q, 3)) * vsd * ratio["velocity"] * (not noiseless)
    if "gnss_correlated" in found:
        e = found["gnss_correlated"]
        error += np.stack(
            [gauss_markov(q, 1 / gnss_rate, e["sigma"], e["correlation_time"], rng) for _ in "ned"],
            -1,
        )
    if "gnss_outliers" in found:
        e = found["gnss_outliers"]
        wild = rng.random(q) < e["fraction"]
        error[wild] += rng.standard_normal((wild.sum(), 3)) * e["scale"]
    if "second_half_offset" in unknown:
        error[stamps > 0.5 * (start + t[-1])] += np.array([4.0, -5.0, 3.0])
    rm, rn = radii(pos[:, 0])
    fixes = pos + np.stack(
        [
            error[:, 0] / (rm + pos[:, 2]),
            error[:, 1] / ((rn + pos[:, 2]) * np.cos(pos[:, 0])),
            -error[:, 2],
        ],
        -1,
    )
    if "axes" in found:
        turn = np.zeros((3, 3))
        for i, p in enumerate(found["axes"]["permutation"]):
            turn[i, "xyz".index(p[1])] = 1.0 if p[0] == "+" else -1.0
        out_g, out_a = out_g @ turn.T, out_a @ turn.T
    sub = slice(None, None, max(int(rate / 10), 1))
    yaw = m.euler[at][:, 2]
    angles = np.stack([*m.euler[at].T[:2], (yaw + np.pi) % (2 * np.pi) - np.pi], -1)[sub].copy()
    if "heading" in found:
        angles[0, 2] += found["heading"]["error"]
    arrays = dict(
        time=(t - start) * (1 + scale_clock),
        gyro=out_g,
        accel=out_a,
        gnss_time=stamps - start,
        gnss_position=fixes,
        gnss_position_sd=np.tile(psd, (q, 1)),
        reference_time=(t - start)[sub],
        reference_position=np.stack([np.interp(t, m.t, c) for c in m.lla.T], -1)[sub],
        reference_velocity=np.stack([np.interp(t, m.t, c) for c in m.velocity.T], -1)[sub],
        reference_attitude=angles,
        lever_arm=np.zeros(3),
    )
    if velocity:
        arrays |= dict(gnss_velocity=vel + v_error, gnss_velocity_sd=np.tile(vsd, (q, 1)))
    if temperature:
        arrays["temperature"] = warmth
    return arrays
