"""A recorded channel with what the gap workflow found in it: in time, in the spectrum, in the Allan
deviation.
"""

import numpy as np
from scipy.signal import welch

from imu_lib import allan, units
from imu_lib.errors import UndefinedFormError
from imu_lib.plots import style
from imu_lib.plots.record import UNIT
from imu_lib.processes import Sum

#: Segments of the spectrum, and points of the time series and of the spectrum, at the most.
SEGMENT, POINTS, BINS = 8192, 600, 500
#: Lines that are drawn faintly where there are as many.
MANY = 40


@style.styled
def recorded(found, channel, *, axes=None):
    """Three panels of one channel: the samples with the times of vibrations shaded, the spectrum
    with their lines marked, the Allan deviation; the grown model's noise over the latter two, in
    the spectrum dashed with the vibrations whose profile was measured.

    `found` is a `gap.Report`, or what `recorded_curves` made of one.
    """
    if axes is None:
        axes = style.grid(1, 3, size=(10.5, 3.0))
    axes = np.ravel(axes)
    curves = found if isinstance(found, dict) else recorded_curves(found, channel)
    factor, unit = units.datasheet("signal", channel)
    _in_time(axes[0], curves, *UNIT[channel.partition("_")[0]])
    _spectrum(axes[1], curves, factor, unit)
    _deviation(axes[2], curves, factor, unit)
    axes[0].set_title(style.channel_label(channel), loc="left")
    return axes


def recorded_curves(found, channel) -> dict:
    """The curves of the three panels, in lists of four digits: they are a picture of a record where
    that is not at hand. `found` has a `record` and its grown `model`.
    """
    x, fs = np.asarray(found.record.channels[channel], float), found.record.rate
    x = np.interp(np.arange(len(x)), np.flatnonzero(~np.isnan(x)), x[~np.isnan(x)])
    noise = Sum(tuple(t for t in found.model[channel].terms if not t.deterministic))
    for stage in found.model[channel].stages:
        noise = noise + stage if stage.name in ("low_pass", "spikes") else noise
    felt = [p for p in (v.of(channel) for v in found.model.record if v.name == "vibration") if p]
    m = max(1, -(-len(x) // POINTS))
    part = (x[: len(x) // m * m] - x.mean()).reshape(-1, m)
    f, power = _binned(*welch(x, fs, nperseg=min(SEGMENT, len(x) // 4)))
    curve = allan.deviation(x, fs, per_decade=8)
    lines = [v for p in felt for v, s in zip(p.frequencies, p.shape) if s > 0 and v < 0.5 * fs]
    out = {
        "time": (np.arange(len(part)) + 0.5) * m / fs,
        "least": part.min(axis=1),
        "most": part.max(axis=1),
        "mean": part.mean(axis=1),
        "frequency": f,
        "power": power,
        "tau": curve.tau,
        "deviation": curve.adev,
        "lines": np.array(lines),
        "spans": np.array([t for p in felt if p.start is not None for t in (p.start, p.stop)]),
        "model_power": _form(lambda: noise.psd(f, fs)),
        "model_deviation": _form(lambda: np.sqrt(noise.avar(curve.tau, fs))),
    }
    shaken = sum(_density(p, f) for p in felt if p.profile is not None)
    both = out["model_power"].size and np.any(shaken)
    out["shaken_power"] = out["model_power"] + shaken if both else np.zeros(0)
    return {k: [float(f"{v:.4g}") for v in values] for k, values in out.items()}


def _density(p, f):
    """One-sided density of a vibration of one channel at `f` Hz, from its profile."""
    at, density = np.array(p.profile_frequency), np.array(p.profile)
    power = 0.5 * p.amplitude[0] ** 2 * density / np.trapezoid(density, at)
    return np.interp(f, at, power, left=0.0, right=0.0)


def _form(closed):
    """A closed form, or nothing where there is none."""
    try:
        return closed()
    except UndefinedFormError:
        return np.zeros(0)


def _binned(f, power):
    """The spectrum without its mean, in no more than `BINS` bins: the loudest ordinate of each."""
    f, power = f[1:], power[1:]
    k = -(-len(f) // BINS)
    if k < 2:
        return f, power
    first = 200  # the slow end as it is
    at = np.arange(first, len(f) - k + 1, k)
    best = at + np.array([int(np.argmax(power[a : a + k])) for a in at])
    keep = np.r_[np.arange(first), best]
    return f[keep], power[keep]


def _in_time(ax, c, factor, unit):
    least, most, mean = (np.divide(c[name], factor) for name in ("least", "most", "mean"))
    ax.fill_between(c["time"], least, most, color=style.SKY, lw=0)
    ax.plot(c["time"], mean, color=style.BLUE, lw=0.6)
    for start, stop in zip(c["spans"][::2], c["spans"][1::2]):
        ax.axvspan(start, stop, color=style.ORANGE, alpha=0.3, lw=0)
    ax.set_xlabel("time, s")
    ax.set_ylabel(f"signal less its mean, {unit}")


def _spectrum(ax, c, factor, unit):
    for name, colour, width in (("power", style.DATA, 0.7), ("model_power", style.THEORY, 1.2)):
        if c[name]:
            ax.loglog(c["frequency"], np.divide(c[name], factor**2), color=colour, lw=width)
    if c.get("shaken_power"):
        shaken = np.divide(c["shaken_power"], factor**2)
        ax.loglog(c["frequency"], shaken, color=style.THEORY, lw=1.0, ls="--")
    low, high = ax.get_ylim()
    if len(c["lines"]) < MANY:
        for line in c["lines"]:
            ax.axvline(line, color=style.ORANGE, lw=0.6, alpha=0.7, zorder=0)
    else:
        ax.vlines(c["lines"], low, high, color=style.ORANGE, lw=0.6, alpha=0.1, zorder=0)
    ax.set_ylim(low, high)
    ax.set_xlabel("frequency, Hz")
    ax.set_ylabel(f"one-sided density, ({unit})²/Hz")


def _deviation(ax, c, factor, unit):
    ax.loglog(c["tau"], np.divide(c["deviation"], factor), color=style.DATA, marker=".", ls="none")
    if c["model_deviation"]:
        model = np.divide(c["model_deviation"], factor)
        ax.loglog(c["tau"], model, color=style.THEORY, lw=1.2)
    ax.set_xlabel("averaging time, s")
    ax.set_ylabel(f"Allan deviation, {unit}")
