"""One effect put into a stretch of a recorded signal, with the log-likelihood that it gains.

Nothing here is shared with the package. How much an effect gains is reckoned against the spectrum
of the stretch as it was recorded, its own drifts included: what is in it already hides what is put
in.
"""

from __future__ import annotations

import numpy as np
from gap_noises import strength
from scipy.fft import dct
from scipy.ndimage import gaussian_filter1d
from scipy.signal import lfilter

G = 9.80665
#: Effects that are put in at a drawn gain, and those of the samples, which have a gain of their
#: own.
SHAPES = ("sinusoid", "vibration", "step", "ramp", "warm_up", "temperature")
NOISES = ("random_walk", "gauss_markov", "flicker", "quantization", "telegraph")
SAMPLES = (
    "spikes",
    "stuck",
    "saturation",
    "resolution",
    "noise_level_change",
    "wandering_level",
    "heavy_tails",
    "low_pass",
)
RECORD = ("common_mode", "dropout", "disturbance", "tilt", "time_gaps", "rate_error")
EFFECTS = (*SHAPES, *NOISES, *SAMPLES, *RECORD)
#: Names under which each may come back, where a record of some minutes cannot tell them apart.
NAMES = {
    "vibration": ("vibration",),
    "random_walk": ("random_walk", "gauss_markov", "flicker"),
    "gauss_markov": ("gauss_markov", "gauss_markov_2", "flicker"),
    "flicker": ("flicker", "gauss_markov", "random_walk"),
    "stuck": ("stuck", "held"),
    "noise_level_change": ("noise_level_change", "wandering_level"),
}
#: Gain from which on an effect counts.
DETECTABLE = 20.0


class Stretch:
    """A channel as recorded: its spectrum after differences, which no drift leaks into."""

    def __init__(self, x, fs):
        self.x, self.fs, self.n = np.array(x, float), fs, len(x)
        d = np.diff(self.x - self.x.mean())
        d = np.clip(d, *(np.median(d) + np.array([-8, 8]) * (np.std(d) + 1e-30)))
        power = np.abs(np.fft.rfft(d * np.hanning(len(d)) * np.sqrt(8 / 3)))[1:] ** 2 * 2
        power /= fs * len(d)
        k = np.arange(1, len(power) + 1)
        turn = 4 * np.sin(np.pi * k / len(d)) ** 2
        # level over constant shares of the frequency, by the mean
        edges = np.unique(np.r_[0, np.geomspace(12, len(power), 60).astype(int)])
        level = [np.mean(power[a:b] / turn[a:b]) for a, b in zip(edges[:-1], edges[1:])]
        middle = [np.sqrt((a + 1) * b) for a, b in zip(edges[:-1], edges[1:])]
        log = np.interp(np.log(k), np.log(middle), np.log(level))
        self.turn, self.density = turn, np.exp(gaussian_filter1d(log, 3)) * turn
        self.fast = np.median(np.abs(d - np.median(d))) / 0.954 or np.std(d) / np.sqrt(2)
        self.sd = np.std(self.x)
        u = np.unique(self.x)
        self.unit = float(np.diff(u).min()) if len(u) < len(self.x) / 2 else None

    def of_shape(self, signal) -> float:
        """Gain of a signal (n,) that is known but for its size."""
        z = dct(signal, norm="ortho")[1:]  # half cycles: a ramp has no other ones
        f = np.arange(1, self.n) * self.fs / (2 * self.n)
        at = np.arange(1, len(self.density) + 1) * self.fs / (self.n - 1)
        density = np.exp(np.interp(np.log(f), np.log(at), np.log(self.density / self.turn)))
        return float(np.sum(z**2 / density) / self.fs)

    def of_noise(self, psd) -> float:
        """Gain of noise of a one-sided density `psd(f)`."""
        f = np.arange(1, len(self.density) + 1) * self.fs / (self.n - 1)
        r = psd(f) * self.turn / self.density
        return float(np.sum(r - np.log1p(r)))

    def plus(self, signal, rng):
        """The stretch with a signal (n,), rounded as it is; before it was rounded a sample lay
        anywhere within its step, else what is less than half a step would be lost.
        """
        if self.unit is None:
            return self.x + signal
        return self.digits(self.x + self.unit * rng.uniform(-0.5, 0.5, self.n) + signal)

    def digits(self, x):
        """Rounded as the stretch is."""
        return x if self.unit is None else np.rint(x / self.unit) * self.unit


def put(effect, channels, fs, target, rng, temperature=None):
    """(channels, those it is on, gain, what was put in) with the effect in `target`."""
    if effect in RECORD:
        return _on_record(effect, channels, fs, rng)
    s = Stretch(channels[target], fs)
    want = 10 ** rng.uniform(1.5, 3.5)
    if effect == "vibration":
        return _shaken(channels, fs, rng, want)
    if effect in SHAPES:
        signal, told = _shape(effect, s, rng, temperature)
        signal = signal * np.sqrt(want / s.of_shape(signal)) * rng.choice([-1, 1])
        x, gain = s.plus(signal, rng), want
        told["peak"] = float(np.ptp(signal))
    elif effect in NOISES:
        x, gain, told = _noise(effect, s, rng, want)
    else:
        x, gain, told = _samples(effect, s, rng)
    return {**channels, target: s.digits(x)}, [target], gain, told


def _shape(effect, s, rng, temperature):
    t = np.arange(s.n) / s.fs
    span = t[-1]
    if effect == "sinusoid":
        f = rng.uniform(0.02, 0.45) * s.fs
        return np.sin(2 * np.pi * f * t + rng.uniform(0, 6)), {"frequency": f}
    if effect == "step":
        at = rng.uniform(0.15, 0.85) * span
        return (t > at) * 1.0, {"time": at}
    if effect == "ramp":
        return t / span, {}
    if effect == "warm_up":
        tau = rng.uniform(0.03, 0.15) * span
        return np.exp(-t / tau), {"time_constant": tau}
    return temperature - temperature[0], {}


def _noise(effect, s, rng, want):
    n, fs = s.n, s.fs
    span = n / fs
    if effect == "random_walk":
        unit = np.cumsum(rng.standard_normal(n)) / np.sqrt(fs)
        told, psd = {}, lambda f: 2 / (2 * np.sin(np.pi * f / fs) * fs) ** 2
    elif effect == "flicker":
        f = np.arange(1, n + 1) * fs / (2 * n)
        z = rng.standard_normal((n, 2)) @ [1, 1j] * np.sqrt(1 / (np.pi * f) * 2 * n * fs / 4)
        unit, told, psd = np.fft.irfft(np.r_[0, z], 2 * n)[:n], {}, lambda f: 1 / (np.pi * f)
    elif effect == "quantization":
        unit = np.diff(rng.uniform(-0.5, 0.5, n + 1)) * np.sqrt(12) * fs
        told, psd = {}, lambda f: 2 * (2 * np.sin(np.pi * f / fs) * fs) ** 2 / fs
    elif effect == "gauss_markov":
        tau = 10 ** rng.uniform(np.log10(max(20 / fs, 0.3)), np.log10(span / 15))
        pole = np.exp(-1 / (fs * tau))
        unit = lfilter([np.sqrt(1 - pole**2)], [1, -pole], rng.standard_normal(2 * n))[n:]
        told, psd = {"correlation_time": tau}, _lorentz(pole, 1.0, fs)
    else:
        rate = 10 ** rng.uniform(np.log10(8 / span), np.log10(max(0.1, 9 / span)))
        unit = (np.cumsum(rng.random(n) < rate / fs) % 2) - 0.5
        told, psd = {"rate": rate}, _lorentz(np.exp(-2 * rate / fs), 0.25, fs)
    if effect == "telegraph" and rng.random() < 0.4:
        a = s.fast * rng.uniform(3, 15)  # to be seen by eye
    else:
        a = strength(lambda a: s.of_noise(lambda f: a * a * psd(f)), want)
    gain = s.of_noise(lambda f: a * a * psd(f))
    return s.plus(a * unit, rng), gain, {**told, "amplitude": a, "over_fast": a / s.fast}


def _lorentz(pole, variance, fs):
    return lambda f: (
        2 * variance * (1 - pole**2) / fs / np.abs(1 - pole * np.exp(-2j * np.pi * f / fs)) ** 2
    )


def _samples(effect, s, rng):
    x, n, fs = s.x.copy(), s.n, s.fs
    slow = gaussian_filter1d(x, 0.5 * fs)
    fast = x - slow
    if effect == "spikes":
        hit = rng.random(n) < rng.uniform(20, 200) / n
        scale = rng.uniform(8, 30)
        x[hit] += scale * s.fast * rng.standard_normal(hit.sum())
        return x, 5.0 * hit.sum(), {"count": int(hit.sum()), "scale": scale}
    if effect == "stuck":
        length = int(rng.integers(8, 60))
        for k in rng.integers(0, n - 2 * length, int(rng.integers(4, 15))):
            x[k : k + length] = x[k]
        return x, 1e3, {"length": length}
    if effect == "saturation":
        share = 10 ** rng.uniform(-2.5, -1.4)
        edge = np.quantile(x, 1 - share)
        moved = np.count_nonzero(x > edge)  # on a coarse grid there may be none
        return np.minimum(x, edge), 1.0 * moved, {"share": share}
    if effect == "resolution":
        s.unit = (s.unit or 0.0) * 4 if s.unit and s.unit > 0.7 * s.fast else 1.5 * s.fast
        return x, 1e3, {"lsb": s.unit}
    if effect == "low_pass":
        taps = int(rng.integers(3, 9))
        return lfilter(np.ones(taps) / taps, [1], x - x[0]) + x[0], 1e3, {"taps": taps}
    if effect == "noise_level_change":
        k = int(rng.uniform(0.2, 0.8) * n)
        m = min(k, n - k)
        want = 10 ** rng.uniform(1.7, 3)
        ratio = np.exp(np.sqrt(2 * want / m) * rng.choice([-1, 1]))
        x[k:] = slow[k:] + ratio * fast[k:]
        return x, want, {"ratio": ratio, "time": k / fs}
    if effect == "wandering_level":
        sd, tau = rng.uniform(0.2, 0.5), n / fs / rng.uniform(20, 80)
        pole = np.exp(-1 / (fs * tau))
        g = lfilter([np.sqrt(1 - pole**2)], [1, -pole], rng.standard_normal(2 * n))[n:]
        return slow + fast * np.exp(sd * g), n * sd**2, {"sd": sd, "correlation_time": tau}
    freedom = rng.uniform(3.2, 6)
    scale = np.sqrt((freedom - 2) / rng.chisquare(freedom, n))
    return slow + fast * scale, n * 0.1 / freedom, {"freedom": freedom}


def _shaken(channels, fs, rng, want):
    n = len(next(iter(channels.values())))
    t = np.arange(n) / fs
    f, lines = rng.uniform(0.06, 0.4) * fs, 1
    if f < 0.16 * fs and rng.random() < 0.5:
        lines = 3
    bend = rng.uniform(0, 0.5) * np.sin(t / rng.uniform(5, 30))
    when = (
        (t >= 0) if rng.random() < 0.5 else (t > 0.2 * t[-1]) & (t < rng.uniform(0.5, 0.9) * t[-1])
    )
    names = list(channels)
    on = names[: max(2, int(rng.integers(2, len(names) + 1)))] if len(names) > 1 else names
    out, gain = dict(channels), 0.0
    for c in on:
        s = Stretch(channels[c], fs)
        signal = when * sum(
            np.sin(2 * np.pi * h * (f * t + bend) + rng.uniform(0, 6)) / h
            for h in range(1, lines + 1)
        )
        signal = signal * np.sqrt(want / s.of_shape(signal))
        gain += want
        out[c] = s.plus(signal, rng)
    told = {"frequency": f, "harmonics": lines, "whole": bool(when.all())}
    return out, on, gain, told


def _on_record(effect, channels, fs, rng):
    names, n = list(channels), len(next(iter(channels.values())))
    out = {c: np.array(x) for c, x in channels.items()}
    own = {c: Stretch(x, fs) for c, x in channels.items()}
    if effect == "dropout":
        if rng.random() < 0.5:
            hit = rng.random(n) < 10 ** rng.uniform(-3, -1.7)
        else:
            hit = np.arange(n) % int(rng.integers(20, 200)) == 7
        if rng.random() < 0.6:
            return {c: np.where(hit, 0.0, x) for c, x in out.items()}, names, 1e3, {"value": 0}
        rows = np.arange(n) - (hit & (np.arange(n) > 0))
        # rows that equal the one before in all channels by chance hide copies
        alike = np.all([np.diff(x) == 0 for x in out.values()], axis=0)
        chance, copies = alike.sum() + 1.0, float(np.sum(hit[1:] & ~alike))
        gain = (chance + copies) * np.log1p(copies / chance) - copies
        return {c: x[rows] for c, x in out.items()}, names, min(gain, 1e3), {"held": copies}
    if effect == "time_gaps":
        keep = np.ones(n, bool)
        for k in rng.integers(n // 20, n - n // 20, int(rng.integers(2, 8))):
            keep[k : k + int(rng.integers(5, 150))] = False
        return (
            {"time": np.flatnonzero(keep) / fs} | {c: x[keep] for c, x in out.items()},
            names,
            1e3,
            {},
        )
    if effect == "common_mode":
        w = rng.standard_normal(n) * rng.uniform(0.5, 1.2)
        kind = names[0].split("_")[0]
        on = [c for c in names if c.startswith(kind)]
        size = np.median([own[c].fast for c in on])
        for c in on:
            out[c] = own[c].plus(size * w, rng)
        return out, on, 1e3, {}
    if effect == "rate_error":
        return (*_clocked(out, own, fs, rng), {"ratio": float(np.exp(rng.uniform(-0.03, 0.03)))})
    if effect == "disturbance":
        told = []
        for _ in range(int(rng.integers(1, 4))):
            m = max(4, int(rng.uniform(0.05, 0.8) * fs))
            at, u = int(rng.uniform(0.05, 0.9) * n), np.arange(m) / m
            f = rng.uniform(1.5, max(2, min(m / 4, 10)))
            for c in names:
                peak = own[c].fast * 10 ** rng.uniform(1.2, 2.2)
                out[c][at : at + m] += (
                    peak * np.exp(-4 * u) * np.sin(2 * np.pi * f * u + rng.uniform(0, 6))
                )
            told.append(at / fs)
        return {c: own[c].digits(x) for c, x in out.items()}, names, 1e3, {"times": told}
    return (*_tilted(out, own, fs, rng), {})


def _clocked(out, own, fs, rng):
    """Steady lines of two or three causes, whose frequencies a model knows: a wrong clock
    moves all.
    """
    t, gain = np.arange(len(next(iter(out.values())))) / fs, 0.0
    for f in rng.uniform(0.06, 0.44, int(rng.integers(2, 4))) * fs:
        c = str(rng.choice(list(out)))
        line, want = np.sin(2 * np.pi * f * t + rng.uniform(0, 6)), 10 ** rng.uniform(2.0, 3.5)
        line *= np.sqrt(want / own[c].of_shape(line))
        out[c], gain = own[c].plus(line + out[c] - own[c].x, rng), gain + want
    return out, list(out), gain


def _tilted(out, own, fs, rng):
    """The unit turned by a few milliradians to some degrees about a level axis."""
    n = len(next(iter(out.values())))
    m, at = max(2, int(rng.uniform(0.4, 2.0) * fs)), int(rng.uniform(0.25, 0.75) * n)
    force = np.array([np.median(out[f"accel_{a}"]) for a in "xyz"])
    axis = np.cross(force, rng.standard_normal(3))
    axis /= np.linalg.norm(axis)
    noisy = max(
        20 * max(own[f"gyro_{a}"].fast for a in "xyz") * np.sqrt(m) / fs,
        3 * max(own[f"accel_{a}"].fast for a in "xyz") / G,
        6 * max(own[f"accel_{a}"].sd for a in "xyz") / G,
    )
    angle = noisy * rng.uniform(1, 6)
    done = 0.5 - 0.5 * np.cos(np.pi * np.clip((np.arange(n) - at) / m, 0, 1))
    for i, a in enumerate("xyz"):
        g, f = own[f"gyro_{a}"], own[f"accel_{a}"]
        out[f"gyro_{a}"] = g.plus(angle * axis[i] * np.gradient(done) * fs, rng)
        out[f"accel_{a}"] = f.plus(angle * np.cross(force, axis)[i] * done, rng)
    return out, list(out), 1e3
