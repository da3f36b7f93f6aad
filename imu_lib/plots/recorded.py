"""A recorded channel with what the gap workflow found in it: in time, in the spectrum, in the Allan
deviation.
"""

import numpy as np
from scipy.signal import welch

from imu_lib import allan
from imu_lib.errors import UndefinedFormError
from imu_lib.plots import style
from imu_lib.processes import Sum

#: Segments of the spectrum, and points of the time series, at the most.
SEGMENT, POINTS = 8192, 3000
#: Lines that are drawn faintly where there are as many.
MANY = 40


@style.styled
def recorded(found, channel, *, axes=None):
    """Three panels of one channel of a `gap.Report` (or of anything with its `record` and grown
    `model`): the samples with the times of vibrations
    shaded, the spectrum with their lines marked, the Allan deviation; the grown model's noise over
    the latter two.
    """
    if axes is None:
        axes = style.grid(1, 3, size=(10.5, 3.0))
    axes = np.ravel(axes)
    x, fs = np.asarray(found.record.channels[channel], float), found.record.rate
    x = np.interp(np.arange(len(x)), np.flatnonzero(~np.isnan(x)), x[~np.isnan(x)])
    noise = Sum(tuple(t for t in found.model[channel].terms if not t.deterministic))
    for stage in found.model[channel].stages:
        noise = noise + stage if stage.name in ("low_pass", "spikes") else noise
    felt = [p for p in (v.of(channel) for v in found.model.record if v.name == "vibration") if p]
    _in_time(axes[0], x, fs, felt)
    _spectrum(axes[1], x, fs, noise, felt)
    _deviation(axes[2], x, fs, noise)
    axes[0].set_title(channel, loc="left")
    return axes


def _in_time(ax, x, fs, felt):
    m = max(1, len(x) // POINTS)
    k = len(x) // m
    part = (x[: k * m] - x.mean()).reshape(k, m)
    t = (np.arange(k) + 0.5) * m / fs
    ax.fill_between(t, part.min(axis=1), part.max(axis=1), color=style.SKY, lw=0)
    ax.plot(t, part.mean(axis=1), color=style.BLUE, lw=0.6)
    for p in felt:
        if p.start is not None:
            ax.axvspan(p.start, p.stop, color=style.ORANGE, alpha=0.3, lw=0)
    ax.set_xlabel("time, s")
    ax.set_ylabel("signal less its mean, SI")


def _spectrum(ax, x, fs, noise, felt):
    f, power = welch(x, fs, nperseg=min(SEGMENT, len(x) // 4))
    ax.loglog(f[1:], power[1:], color=style.DATA, lw=0.7)
    try:
        ax.loglog(f[1:], noise.psd(f[1:], fs), color=style.THEORY, lw=1.2)
    except UndefinedFormError:
        pass
    low, high = ax.get_ylim()
    for p in felt:
        lines = [f for f, strength in zip(p.frequencies, p.shape) if strength > 0 and f < fs / 2]
        faint = 0.7 if len(lines) < MANY else 0.1
        ax.vlines(lines, low, high, color=style.ORANGE, lw=0.6, alpha=faint, zorder=0)
    ax.set_ylim(low, high)
    ax.set_xlabel("frequency, Hz")
    ax.set_ylabel("one-sided PSD, SI/Hz")


def _deviation(ax, x, fs, noise):
    curve = allan.deviation(x, fs, per_decade=8)
    ax.loglog(curve.tau, curve.adev, color=style.DATA, marker=".", ls="none")
    try:
        ax.loglog(curve.tau, np.sqrt(noise.avar(curve.tau, fs)), color=style.THEORY, lw=1.2)
    except UndefinedFormError:
        pass
    ax.set_xlabel("averaging time, s")
    ax.set_ylabel("Allan deviation, SI")
