"""Figures of autoregressive models: order, residuals, poles."""

import numpy as np

from imu_lib.plots import style


@style.styled
def residual_variance(choices, *, unit=("", 1.0), ax=None):
    """Residual variance against order for each of `choices` (label -> OrderChoice or list of
    them), knee marked.
    """
    name, factor = unit
    ax = style.axes(ax, x="order", y=f"residual variance{', (' + name + ')²' if name else ''}")
    for label, group in choices.items():
        group = group if isinstance(group, list) else [group]
        colour = style.channel_colour(label)
        mean = np.mean([c.residual_variance for c in group], axis=0) / factor**2
        for c in group[: 0 if len(group) == 1 else None]:
            ax.plot(c.residual_variance / factor**2, color=colour, linewidth=0.5, alpha=0.5)
        ax.plot(mean, "o-", color=colour, label=style.channel_label(label))
        k = int(np.median([c.orders["knee"] for c in group]))
        ax.plot(k, mean[k], "s", color=colour, markersize=10, markerfacecolor="none")
    ax.plot([], [], "s", color=style.BLACK, markersize=9, markerfacecolor="none", label="knee")
    ax.legend()
    return ax


@style.styled
def order_criteria(choice, *, ax=None):
    """The four criteria above their minimum, in nats over the whole record, so that they share an
    axis.
    """
    ax = style.axes(ax, x="order", y="above the minimum, nats")
    curves = {
        "SBC": choice.sbc * choice.n / 2,
        "MDL": choice.mdl,
        "AIC": choice.aic / 2,
        "FPE": choice.n / 2 * np.log(choice.fpe),
    }
    for (label, values), marker in zip(curves.items(), ("s", "o", "v", "x"), strict=True):
        values = values - values.min()
        ax.plot(
            np.maximum(values, 0.05),
            marker=marker,
            label=f"{label}: {choice.orders[label.lower()]}",
        )
    ax.set_yscale("log")
    ax.xaxis.get_major_locator().set_params(integer=True)
    ax.legend(title="picks")
    return ax


@style.styled
def order_by_length(hours, orders, *, ax=None):
    """Order picked by each criterion (label -> orders) against the length of record, h."""
    ax = style.axes(ax, x="record, h", y="order")
    for (label, picked), marker in zip(orders.items(), ("s", "v", "o", "D"), strict=False):
        ax.plot(hours, picked, marker=marker, label=label)
    ax.set_xscale("log")
    ax.legend()
    return ax


@style.styled
def residual_autocorrelation(tests, *, fs=None, axes=None):
    """Autocorrelation of residuals with the 95 % band of white noise; `tests` is label ->
    Whiteness, a panel each with a scale of its own.
    """
    if axes is None:
        axes = style.grid(1, len(tests), size=(9.0 if len(tests) > 1 else 7.0, 3.2))[0]
    for ax, (label, test) in zip(axes, tests.items(), strict=True):
        lag = np.arange(1, test.rho.size + 1) / (fs or 1)
        ax.vlines(lag, 0, test.rho, color=style.DATA, linewidth=1.5)
        ax.axhspan(-test.band, test.band, color=style.BAND, alpha=0.3, linewidth=0)
        ax.axhline(0, color=style.BLACK, linewidth=0.6)
        ax.set(title=style.channel_label(label), xlabel="lag, s" if fs else "lag, samples")
    axes[0].set_ylabel("residual autocorrelation")
    return axes


@style.styled
def poles(models, *, window=((0.5, 1.1), (-0.3, 0.3)), ax=None):
    """Poles of each of `models` (label -> complex array) and the unit circle near z = 1."""
    ax = style.axes(ax, x="real part", y="imaginary part", size=(6.0, 5.0))
    angle = np.linspace(-np.pi, np.pi, 721)
    ax.plot(np.cos(angle), np.sin(angle), color=style.BLACK, linewidth=0.8)
    for (label, roots), marker in zip(models.items(), "xo+sv^*D", strict=False):
        ax.plot(
            np.real(roots),
            np.imag(roots),
            marker,
            label=label,
            markerfacecolor="none",
            markersize=7,
        )
    ax.set(xlim=window[0], ylim=window[1])
    ax.legend(loc="lower left")
    return ax
