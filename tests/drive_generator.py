"""Drives with known faults, made without `imu_lib.navigation`: what the gap workflow is tried on.

A car is steered by commands of speed, turn rate and slope; its motion is differentiated in the
Earth-centred frame, where the navigation package works in north-east-down. Errors are drawn here
too, effect by effect, from the definitions of the file format alone.
"""

import numpy as np
from drive_motion import FINE, drawn, radii
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

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
    rough=0.0,
    slip=0.0,
    imu_gap=0.0,
    tunnels=0,
    stated=True,
    held_sd=1.0,
):
    """Arrays of a drive, for effects [(name, parameters)] and unknown ones by name (see below).

    imu_gap : s without readings in mid-drive; tunnels : stretches of 15 s without fixes; stated :
    whether the standard deviations of the fixes are in the file; held_sd : factor by which they
    wander between good and bad sky, said by the file as it goes
    """
    m, after = drawn(seed, kind, duration, rough, slip)
    rng = np.random.default_rng()
    rng.bit_generator.state = after
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
    psd, vsd = np.tile(position_sd, (q, 1)), np.tile(velocity_sd, (q, 1))
    if held_sd > 1.0:
        sky = np.exp(gauss_markov(q, 1 / gnss_rate, np.log(held_sd), 40.0, rng))[:, None]
        psd, vsd = psd * sky, vsd * sky
    ratio = {"position": 1.0, "velocity": 1.0}
    for name, e in effects:
        if name == "gnss_noise":
            ratio[e["of"]] = e["ratio"]
    error = rng.standard_normal((q, 3)) * psd * ratio["position"] * (not noiseless)
    v_error = rng.standard_normal((q, 3)) * vsd * ratio["velocity"] * (not noiseless)
    if "velocity_correlated" in unknown:
        v_error += np.stack([gauss_markov(q, 1 / gnss_rate, 0.2, 4.0, rng) for _ in "ned"], -1)
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
        reference_time=(t - start)[sub],
        reference_position=np.stack([np.interp(t, m.t, c) for c in m.lla.T], -1)[sub],
        reference_velocity=np.stack([np.interp(t, m.t, c) for c in m.velocity.T], -1)[sub],
        reference_attitude=angles,
        lever_arm=np.zeros(3),
    )
    if stated:
        arrays["gnss_position_sd"] = psd
    if velocity:
        arrays["gnss_velocity"] = vel + v_error
        if stated:
            arrays["gnss_velocity_sd"] = vsd
    if temperature:
        arrays["temperature"] = warmth
    return with_holes(arrays, imu_gap, tunnels, rng)


def with_holes(arrays, imu_gap, tunnels, rng):
    """The arrays without some readings, and without the fixes of a few stretches."""
    end = arrays["time"][-1]
    if imu_gap:
        begin = rng.uniform(0.4, 0.7) * end
        keep = (arrays["time"] < begin) | (arrays["time"] > begin + imu_gap)
        for key in ("time", "gyro", "accel", "temperature"):
            if key in arrays:
                arrays[key] = arrays[key][keep]
    for begin in rng.uniform(0.3, 0.9, tunnels) * end:
        keep = (arrays["gnss_time"] < begin) | (arrays["gnss_time"] > begin + 15.0)
        for key in [k for k in arrays if k.startswith("gnss_")]:
            arrays[key] = arrays[key][keep]
    return arrays
