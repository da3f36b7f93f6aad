"""What is hidden in a record: an effect put into the samples of a channel, into what comes out of
it, or into a whole record, with the log-likelihood that it gains. Plain numpy, nothing of imu_lib.
"""

from __future__ import annotations

from itertools import accumulate

import numpy as np
from gap_noises import base_psd, gain_drift, gain_line, gain_spectral, noise, spectrum, strength

SPECTRAL = (
    "quantization",
    "flicker",
    "random_walk",
    "gauss_markov",
    "gauss_markov_2",
    "autoregressive",
)
DRIFTS = ("ramp", "warm_up", "temperature", "step", "sinusoid", "slow_sinusoid", "telegraph")
STAGES = ("low_pass", "noise_level_change", "spikes", "saturation", "resolution", "stuck")
CHANGES = ("change_N", "change_sigma")
RECORD = ("common_mode", "time_gaps", "jitter")
KNOWN = SPECTRAL + DRIFTS + STAGES + CHANGES + RECORD


def hide(effect, x, base, fs, rng, temperature, gain=None, rounded=False):
    """Adds `effect` to the samples; returns (samples, truth)."""
    n = len(x)
    f = np.arange(1, n // 2 + 1) * fs / n
    s0 = base_psd(base, f, fs)
    t = np.arange(n) / fs
    white = base[0]["N"] * np.sqrt(fs)
    target = gain or 10 ** rng.uniform(np.log10(15), 3)
    duration = n / fs
    truth = {"effect": effect, "gain": target}
    if effect in ("change_N", "change_sigma"):
        i = (
            0
            if effect == "change_N"
            else next((i for i, e in enumerate(base) if e["process"] == "gauss_markov"), 0)
        )
        name = "N" if base[i]["process"] == "white_noise" else "sigma"
        entry = base[i]
        own = spectrum(entry, f, fs)
        c = strength(lambda c: gain_spectral(s0, own * c), target)
        truth.update(
            effect="parameter_change",
            parameters={
                "process": entry["process"],
                "name": name,
                "from": entry[name],
                "to": entry[name] * np.sqrt(1 + c),
            },
        )
        more = {**entry, name: entry[name] * np.sqrt(c)}
        return x + noise(more, n, fs, rng), {
            **truth,
            "noise": more,
            "seen": lambda around: gain_spectral(base_psd(around, f, fs), own * c),
        }
    if effect in SPECTRAL:
        entry = {"process": effect}
        if effect in ("gauss_markov", "gauss_markov_2"):
            entry["correlation_time"] = 10 ** rng.uniform(-0.5, np.log10(duration / 12))
        if effect == "autoregressive":
            r, w = rng.uniform(0.85, 0.97), rng.uniform(0.1, 0.8) * np.pi
            entry["phi"] = (
                [2 * r * np.cos(w), -r * r] if rng.random() < 0.75 else [-rng.uniform(0.3, 0.9)]
            )
            entry["rate"] = fs
        name = {"quantization": "Q", "flicker": "B", "random_walk": "K"}.get(effect, "sigma")
        shape = spectrum({**entry, name: 1.0}, f, fs)
        entry[name] = strength(lambda a: gain_spectral(s0, a * a * shape), target)
        truth["parameters"] = entry
        own = entry[name] ** 2 * shape
        if (
            effect == "quantization" and rounded
        ):  # the angle is rounded, and its increments are read out
            step = np.sqrt(12) * entry["Q"]
            angle = np.concatenate([[0.0], np.cumsum(x) / fs]) + rng.uniform(0, step)
            return np.diff(np.round(angle / step)) * step * fs, {
                **truth,
                "noise": entry,
                "seen": lambda around: gain_spectral(base_psd(around, f, fs), own),
            }
        return x + noise(entry, n, fs, rng), {
            **truth,
            "noise": entry,
            "seen": lambda around: gain_spectral(base_psd(around, f, fs), own),
        }
    if effect == "telegraph":
        entry = {"process": "telegraph", "rate": 10 ** rng.uniform(np.log10(8 / duration), -0.7)}
        shape = spectrum({**entry, "amplitude": 1.0}, f, fs)
        entry["amplitude"] = strength(lambda a: gain_spectral(s0, a * a * shape), 3 * target)
        truth["parameters"] = entry
        own = entry["amplitude"] ** 2 * shape
        return x + noise(entry, n, fs, rng), {
            **truth,
            "noise": entry,
            "seen": lambda around: gain_spectral(base_psd(around, f, fs), own) / 3,
        }
    if effect in DRIFTS:
        p = {}
        if effect == "ramp":
            d, name = t, "R"
        elif effect == "warm_up":
            p["time_constant"] = duration * 10 ** rng.uniform(-1.7, -0.7)
            d, name = np.exp(-t / p["time_constant"]), "amplitude"
        elif effect == "temperature":
            d, name = temperature - 25.0, "slope"
            p["reference"] = 25.0
        elif effect == "slow_sinusoid":
            p["frequency"] = rng.uniform(3.5, 31) / duration
            d, name = (
                np.sin(2 * np.pi * p["frequency"] * t + rng.uniform(0, 2 * np.pi)),
                "amplitude",
            )
            truth["effect"] = "sinusoid"
        elif effect == "step":
            p["time"] = duration * rng.uniform(0.1, 0.9)
            d, name = (t >= p["time"]).astype(float), "amplitude"
        else:
            p["frequency"] = 10 ** rng.uniform(-1.5, np.log10(0.47 * fs))
            d, name = (
                np.sin(2 * np.pi * p["frequency"] * t + rng.uniform(0, 2 * np.pi)),
                "amplitude",
            )

        def one(around):
            if effect == "sinusoid":
                return gain_line(d, base_psd(around, f, fs), fs)
            return gain_drift(d, around, fs)

        a = np.sqrt(target / one(base))
        sign = -1 if truth["effect"] != "sinusoid" and rng.random() < 0.5 else 1
        p[name] = a * sign
        truth["parameters"] = p
        return x + a * sign * d, {**truth, "seen": lambda around: a * a * one(around)}
    return _stage(effect, x, fs, rng, truth, white, target)


def _stage(effect, x, fs, rng, truth, white, target):
    n, mean, duration = len(x), x.mean(), len(x) / fs
    truth["gain"] = 1e3
    if effect == "low_pass":
        make = rng.choice(["average", "average", "butterworth", "butterworth", "smoothing"])
        if make == "average":
            taps = int(rng.integers(2, 13))
            y = np.convolve(
                np.concatenate([np.full(taps - 1, x[0]), x]), np.full(taps, 1 / taps), "valid"
            )
            truth["parameters"] = {"taps": taps}
        elif make == "butterworth":
            cutoff, order = fs * rng.uniform(0.06, 0.4), int(rng.integers(1, 5))
            h = 1 / np.sqrt(
                1
                + (np.tan(np.pi * np.arange(n // 2 + 1) / n) / np.tan(np.pi * cutoff / fs))
                ** (2 * order)
            )
            y = np.fft.irfft(np.fft.rfft(x - mean) * h, n) + mean
            truth["parameters"] = {"order": order, "cutoff": cutoff}
        else:  # y_k = y_{k-1} + a (x_k - y_{k-1})
            a = rng.uniform(0.2, 0.8)
            y = np.array([*accumulate(x, lambda last, new: last + a * (new - last))])
            turn = 1 - a**2 / (
                2 * (1 - a)
            )  # cosine of the angle at which |1 - (1 - a) e^{-iw}|^2 = 2 a^2
            truth["parameters"] = (
                {"cutoff": fs / (2 * np.pi) * np.arccos(turn)} if turn > -1 else {}
            )
        return y, truth
    if effect == "noise_level_change":
        t0 = duration * rng.uniform(0.15, 0.85)
        m = int((duration - t0) * fs)
        ratio = np.exp(np.sign(rng.random() - 0.5) * np.sqrt(2 * target / min(m, n - m)))
        y = x.copy()
        w = rng.standard_normal(n) * white
        noise = np.where(np.arange(n) < n - m, 0.0, np.sqrt(max(ratio**2 - 1, 0)) * w)
        if ratio < 1:  # the base's white part is shrunk: keep the slow part, scale the rest
            k = int(fs)
            slow = np.convolve(
                np.pad(x, k, mode="edge"), np.full(2 * k + 1, 1 / (2 * k + 1)), "valid"
            )
            y[n - m :] = slow[n - m :] + ratio * (x - slow)[n - m :]
        truth.update(gain=target, parameters={"ratio": ratio, "time": (n - m) / fs})
        return y + noise, truth
    if effect == "spikes":
        rate, scale = 10 ** rng.uniform(-2.3, 0), white * rng.uniform(6, 30)
        hit = rng.random(n) < rate / fs
        truth.update(parameters={"rate": rate, "scale": scale}, gain=float(hit.sum()) * 5)
        return x + hit * rng.standard_normal(n) * scale, truth
    if effect == "saturation":
        limit = np.quantile(np.abs(x), 1 - 10 ** rng.uniform(-4, -1.3))
        truth["parameters"] = {"limit": limit}
        return np.clip(x, -limit, limit), truth
    if effect == "resolution":
        lsb = white * 10 ** rng.uniform(-0.7, 0.5)
        truth.update(
            parameters={"lsb": lsb}, noise={"process": "white_noise", "N": lsb / np.sqrt(12 * fs)}
        )
        return np.round(x / lsb) * lsb, truth
    fraction, length, y = 10 ** rng.uniform(-3, -1.5), int(rng.integers(5, 60)), x.copy()
    for start in np.flatnonzero(rng.random(n) < fraction / length):
        y[start : start + length + 1] = y[start]
    truth["parameters"] = {"fraction": fraction, "length": length}
    return y, truth


def hide_record(effect, case, rng):
    x, fs = case.channels, case.fs
    n = len(next(iter(x.values())))
    if effect == "common_mode":
        k = int(rng.integers(2, len(x) + 1)) if len(x) > 2 else 2
        names = sorted(rng.choice(list(x), k, replace=False), key=list(x).index)
        N = np.sqrt(np.prod([case.base[c][0]["N"] for c in names]) ** (1 / k)) ** 2 * rng.uniform(
            0.15, 0.6
        )
        w = rng.standard_normal(n) * N * np.sqrt(fs)
        for c in names:
            x[c] = x[c] + w
        rho = [N**2 / (N**2 + case.base[c][0]["N"] ** 2) for c in names]
        p = {"N": N, "channels": [str(c) for c in names]}
        case.truths.append(
            {
                "effect": effect,
                "channel": "record",
                "parameters": p,
                "gain": n / 2 * rho[0] * rho[1],
                "noise": {"process": "white_noise", "N": N},
            }
        )
    elif effect == "time_gaps":
        fraction = 10 ** rng.uniform(-3, -1.5)
        keep = np.ones(n, bool)
        while keep.mean() > 1 - fraction:
            start = rng.integers(1, n - 500)
            keep[start : start + rng.integers(1, 400)] = False
        case.time = np.flatnonzero(keep) / fs
        for c in x:
            x[c] = x[c][keep]
        if case.temperature is not None:
            case.temperature = case.temperature[keep]
        case.truths.append(
            {
                "effect": effect,
                "channel": "record",
                "parameters": {"fraction": 1 - keep.mean()},
                "gain": 1e3,
            }
        )
    else:
        sd = 10 ** rng.uniform(-2, -0.9) / fs
        time = np.arange(n) / fs + np.clip(rng.standard_normal(n), -4, 4) * sd
        case.time = time - time[0]
        case.truths.append(
            {"effect": effect, "channel": "record", "parameters": {"sd": sd}, "gain": 1e3}
        )
