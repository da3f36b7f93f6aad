"""Portrait of a noise process: what it knows of itself, over what a realisation shows."""

import numpy as np

from imu_lib.errors import UndefinedFormError
from imu_lib.plots import style


@style.styled
def process_portrait(process, x, fs, *, spectrum=None, curve=None, correlation=None, axes=None):
    """Four panels: realisation, spectral density, Allan deviation, autocovariance; theory over
    estimates.

    Parameters
    ----------
    process : Process or Sum
    x : ndarray, shape (n,)
    fs : float, Hz
    spectrum, curve, correlation
        `spectrum.Spectrum`, `AllanCurve` and `Autocorrelation` of `x`, or None.
    """
    axes = (style.grid(2, 2, size=(9.0, 5.2)) if axes is None else axes).ravel()
    t, shown = style.thin(np.arange(len(x)) / fs, x, points=1500)
    style.axes(axes[0], x="time, s", y="signal").plot(t, shown, color=style.DATA, linewidth=0.6)
    ax = style.axes(axes[1], x="frequency, Hz", y="density, unit²/Hz", log=True)
    if spectrum is not None:
        ax.plot(spectrum.f, spectrum.psd, color=style.DATA, linewidth=0.8, label="estimate")
        _theory(ax, spectrum.f, lambda f: process.psd(f, fs), "spectral density")
    ax = style.axes(axes[2], x="averaging time, s", y="Allan deviation", log=True)
    if curve is not None:
        style.band(ax, curve.tau, curve.low, curve.high, color=style.DATA)
        ax.plot(curve.tau, curve.adev, color=style.DATA, label="estimate")
        _theory(ax, curve.tau, lambda tau: np.sqrt(process.avar(tau, fs)), "Allan deviation")
    ax = style.axes(axes[3], x="lag, s", y="autocovariance")
    if correlation is not None:
        lag, gamma = correlation.lag, correlation.rho * correlation.variance
        style.band(
            ax,
            lag,
            gamma - 2 * correlation.sd * correlation.variance,
            gamma + 2 * correlation.sd * correlation.variance,
            color=style.DATA,
        )
        ax.plot(lag, gamma, color=style.DATA, label="estimate")
        _theory(ax, lag, lambda d: process.autocovariance(d, fs), "autocovariance")
    return axes


def _theory(ax, x, form, what):
    try:
        ax.plot(x, form(x), "--", color=style.TRUTH, label="closed form")
    except UndefinedFormError:
        ax.text(
            0.5, 0.75, f"no {what} exists", transform=ax.transAxes, ha="center", color=style.THEORY
        )
    ax.legend(loc="lower left" if ax.get_yscale() == "log" else "upper right")


@style.styled
def allan_family(tau, deviations, *, ax=None):
    """Closed-form Allan deviations, label -> array, on one set of axes."""
    ax = style.axes(
        ax, x="averaging time, s", y="Allan deviation, amplitudes chosen to be seen", log=True
    )
    for (label, values), line in zip(deviations.items(), ["-", "--", "-.", ":"] * 5, strict=False):
        ax.plot(tau, values, line, label=label)
    top = max(np.max(values) for values in deviations.values())
    ax.set_ylim(top / 1e6, 2 * top)  # a sinusoid's deviation is zero at whole periods
    ax.legend(ncols=3, loc="lower left")
    return ax
