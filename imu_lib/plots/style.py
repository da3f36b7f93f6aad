"""The look that all figures share, and the few things that every plot function needs.

Colours are those of Okabe and Ito, told apart by colour-blind readers; sizes keep an executed
chapter small. A plot function is decorated with `styled`, takes `ax=None`, and returns the axes:

    @style.styled def curve(result, *, ax=None):
        ax = style.axes(ax, x="averaging time, s", y="Allan deviation, deg/h", log=True)
"""

from functools import wraps

import matplotlib.pyplot as plt
import numpy as np

from imu_lib import units

# Choosing a backend also switches interactive display on; done inside `styled` that would be
# undone with the look, and a notebook would show its first figure alone.
plt.switch_backend(plt.get_backend())

BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
YELLOW, BLUE, VERMILION, PURPLE, GREY = "#F0E442", "#0072B2", "#D55E00", "#CC79A7", "#7F7F7F"
CYCLE = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK)

# what a colour means, the same in every chapter
DATA, THEORY, FIT, TRUTH, BAND, PAPER = BLUE, VERMILION, VERMILION, BLACK, GREY, PURPLE
BEFORE, AFTER = VERMILION, GREEN
TERMS = (
    GREEN,
    PURPLE,
    ORANGE,
    SKY,
    GREY,
)  # the terms of a sum, or the lines read off a curve, in turn

SIZE = (7.0, 4.0)  # inches
RC = {
    "figure.figsize": SIZE,
    "figure.dpi": 90,
    "savefig.dpi": 90,
    "figure.constrained_layout.use": True,
    "axes.prop_cycle": plt.cycler(color=CYCLE),
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": "medium",
    "axes.formatter.useoffset": False,
    "grid.color": "#DDDDDD",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.3,
    "lines.markersize": 4,
    "legend.frameon": True,  # white and without an edge: words are read where they cover a curve
    "legend.facecolor": "white",
    "legend.edgecolor": "none",
    "legend.framealpha": 0.8,
    "legend.fontsize": "small",
    "font.size": 10,
    "font.family": "DejaVu Sans",
    "image.cmap": "cividis",
    "svg.hashsalt": "imu_lib",
}


def apply():
    """Set the look for figures that are drawn without a function of this package."""
    plt.rcParams.update(RC)


def styled(function):
    """Decorator: the function draws in the shared look and leaves the caller's settings alone."""

    @wraps(function)
    def drawn(*args, **options):
        with plt.rc_context(RC):
            return function(*args, **options)

    return drawn


def axes(ax=None, *, x="", y="", title="", log=False, size=SIZE):
    """The axes given, or those of a new figure, with labels; `log` makes both scales
    logarithmic.
    """
    if ax is None:
        _, ax = plt.subplots(figsize=size)
    ax.set(xlabel=x, ylabel=y, title=title)
    if log:
        ax.set(xscale="log", yscale="log")
    return ax


@styled
def grid(rows=1, columns=1, *, size=None, sharex=False, sharey=False):
    """Axes of a new figure, ndarray, shape (rows, columns); by default 3.5 x 2.6 inches each, no
    wider than 9.
    """
    size = size or (
        min(9.0, max(SIZE[0], 3.5 * columns)),
        max(SIZE[1], 2.6 * rows) if rows > 1 else 3.2,
    )
    _, found = plt.subplots(
        rows, columns, figsize=size, sharex=sharex, sharey=sharey, squeeze=False
    )
    return found


def band(ax, x, low, high, *, color=BAND, label=None, alpha=0.25):
    """A shaded interval, below the curves."""
    return ax.fill_between(
        x, low, high, color=color, alpha=alpha, linewidth=0, label=label, zorder=1
    )


def lines_read_off(ax, x, reading, channel, height):
    """The lines of a reading over x, thick where the stretch was found, their coefficients in the
    legend.

    `height(line)` gives a line's values at x in the unit of the axes.
    """
    for colour, (symbol, line) in zip(TERMS, reading.used.items(), strict=False):
        factor, unit = units.datasheet(symbol, channel) if channel else (1.0, "")
        value, inside = height(line), (x >= line.start) & (x <= line.stop)
        ax.plot(x, value, ":", color=colour, linewidth=1.0)
        ax.plot(
            x[inside],
            value[inside],
            color=colour,
            linewidth=2.5,
            label=f"{symbol} = {reading[symbol].value / factor:.3g} {unit}",
        )


def channel_colour(channel: str) -> str:
    """Colour of an axis: x, y and z look the same for gyros and accelerometers."""
    return {"x": BLUE, "y": VERMILION, "z": GREEN}.get(channel[-1:], BLACK)


def channel_label(channel: str) -> str:
    """`gyro_x` as a reader sees it: "gyro x"."""
    return channel.replace("accel", "accelerometer").replace("_", " ")


def thin(t, x, *, points=4000):
    """Least and greatest value of each stretch, so that a long record draws as it looks at full
    length.

    Arrays of shape (n,) in, two arrays of at most `points` values out; NaN stretches stay NaN.
    """
    t, x = np.asarray(t), np.asarray(x)
    if len(x) <= points:
        return t, x
    length = -(-len(x) // (points // 2))
    starts = np.arange(0, len(x), length)
    low = np.fmin.reduceat(x, starts)
    high = np.fmax.reduceat(x, starts)
    return np.repeat(t[starts], 2), np.column_stack([low, high]).ravel()


def headless():
    """For commands: draw into files, whatever screen there is."""
    plt.switch_backend("Agg")


def save(ax, path):
    """Write the figure of `ax` to `path` (the same bytes each time) and close it."""
    ax.figure.savefig(path, metadata={"Software": None} if str(path).endswith(".png") else None)
    plt.close(ax.figure)
