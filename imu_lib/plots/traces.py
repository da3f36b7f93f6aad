"""What an axes of matplotlib holds, as Plotly's traces, shapes and annotations: curves, areas,
bars, lines across and words. Numbers have the digits that can be seen.
"""

import html

import numpy as np
from matplotlib.collections import LineCollection, PathCollection, PolyCollection
from matplotlib.colors import to_hex, to_rgb
from matplotlib.container import BarContainer
from matplotlib.patches import Rectangle

from imu_lib.plots import style

# of a curve, and of all curves of a figure together: more only make the page heavy
POINTS, ALL_POINTS = 1200, 4000
DASHES = {"-": "solid", "--": "dash", ":": "dot", "-.": "dashdot"}
MARKERS = {"s": "square", "x": "x", "+": "cross", "^": "triangle-up", "v": "triangle-down"}
MARKERS |= {"D": "diamond", "_": "line-ew-open", "|": "line-ns-open"}


def limits(ax, which):
    """Whether an axis is logarithmic, and how long it is."""
    log = getattr(ax, f"get_{which}scale")() == "log"
    low, high = getattr(ax, f"get_{which}lim")()
    return log, abs(high - low)


def _rounded(values, log_and_span):
    """Four digits where the axis is logarithmic, a ten-thousandth of the axis where it is
    linear.
    """
    log, span = log_and_span
    values = np.asarray(values, float)
    if log:
        good = np.isfinite(values) & (values > 0)
        return [float(f"{v:.4g}") if g else None for v, g in zip(values, good)]
    places = max(0, 4 - int(np.floor(np.log10(span or 1.0))))
    return [None if not np.isfinite(v) else _short(v, places) for v in values]


def _short(value, places):
    value = round(float(value), places) + 0.0
    return int(value) if value.is_integer() else value


def _thinned(ax, x, y, log_x):
    lines = sum(len(panel.get_lines()) for panel in ax.figure.axes)
    points = max(100, min(POINTS, ALL_POINTS // lines))
    if len(x) <= points:
        return x, y
    if log_x:
        keep = np.unique(np.geomspace(1, len(x), points).astype(int)) - 1
        return x[keep], y[keep]
    if np.any(np.diff(x) < 0):  # a track, not a function of x
        keep = np.unique(np.linspace(0, len(x) - 1, points).astype(int))
        return x[keep], y[keep]
    return style.thin(x, y, points=points)


def _trace(ax, ends, x, y, *, name="", colour="#000000", width=1.3, mode="lines", **more):
    return {
        "type": "scatter",
        "mode": mode,
        "name": "" if name.startswith("_") else name,
        "x": _rounded(x, ends[0]),
        "y": _rounded(y, ends[1]),
        "line": {"color": colour, "width": round(1.3 * float(width), 2)},
        **more,
    }


def curves(ax, ends):
    """Traces and shapes of what an axes holds, in the order in which it is laid over each other."""
    traces, shapes = [], []
    for collection in ax.collections:
        traces += _collection(ax, ends, collection)
    for bars in [c for c in ax.containers if isinstance(c, BarContainer)]:
        traces.append(_bars(ax, ends, bars))
    inside = {id(p) for c in ax.containers if isinstance(c, BarContainer) for p in c}
    for patch in ax.patches:
        if isinstance(patch, Rectangle) and id(patch) not in inside:
            (x, y), (w, h) = patch.get_xy(), (patch.get_width(), patch.get_height())
            shapes.append((ax, patch, [x, x + w], [y, y + h], patch.get_facecolor()))
    for line in ax.get_lines():
        x, y = (np.asarray(v, float) for v in line.get_data(orig=False))
        if not all(line.get_transform().contains_branch_seperately(ax.transData)):
            shapes.append((ax, line, x[[0, -1]], y[[0, -1]], line.get_color()))
            continue
        marker, drawn = line.get_marker(), line.get_linestyle() not in ("None", "", " ")
        marked = marker not in ("None", "", " ", None)
        x, y = _thinned(ax, x, y, ends[0][0])
        mode = "+".join(["lines"] * drawn + ["markers"] * marked) or "lines"
        trace = _trace(
            ax,
            ends,
            x,
            y,
            name=str(line.get_label()),
            colour=to_hex(line.get_color()),
            width=line.get_linewidth(),
            mode=mode,
        )
        if drawn:
            trace["line"]["dash"] = DASHES.get(line.get_linestyle(), "solid")
        if marked:
            size = 4 if marker == "." else round(1.4 * float(line.get_markersize()), 1)
            trace["marker"] = {"symbol": MARKERS.get(marker, "circle"), "size": size}
            trace["marker"]["color"] = trace["line"]["color"]
        traces.append(trace)
    return traces, shapes


def _collection(ax, ends, collection):
    name = str(collection.get_label())
    if isinstance(collection, PathCollection):
        x, y = np.asarray(collection.get_offsets(), float).T
        colour = to_hex(collection.get_facecolor()[0])
        return [_trace(ax, ends, x, y, name=name, colour=colour, mode="markers")]
    if isinstance(collection, LineCollection):
        parts = [np.vstack([s, [[np.nan, np.nan]]]) for s in collection.get_segments()]
        if not parts:
            return []
        x, y = np.vstack(parts).T
        colour = to_hex(collection.get_edgecolor()[0])
        return [_trace(ax, ends, x, y, name=name, colour=colour, hoverinfo="skip")]
    if isinstance(collection, PolyCollection):
        return [_area(ax, ends, path, collection, name) for path in collection.get_paths()]
    return []


def _area(ax, ends, path, collection, name):
    x, y = np.asarray(path.vertices, float).T
    for values, (log, _), which in zip((x, y), ends, "xy"):
        if log:  # what reaches zero ends at the edge of the figure
            np.maximum(values, getattr(ax, f"get_{which}lim")()[0], out=values)
    red, green, blue = (round(255 * c) for c in to_rgb(collection.get_facecolor()[0]))
    alpha = round(float(collection.get_facecolor()[0][-1]), 3)
    trace = _trace(ax, ends, x, y, name=name, width=0, fill="toself", hoverinfo="skip")
    return trace | {"fillcolor": f"rgba({red},{green},{blue},{alpha})"}


def _bars(ax, ends, bars):
    flat = bars.orientation == "horizontal"
    size = [b.get_width() if flat else b.get_height() for b in bars]
    place = [
        b.get_y() + b.get_height() / 2 if flat else b.get_x() + b.get_width() / 2 for b in bars
    ]
    x, y = (size, place) if flat else (place, size)
    colour = to_hex(bars[0].get_facecolor())
    trace = _trace(ax, ends, x, y, name=str(bars.get_label()), colour=colour)
    for key in ("mode", "line"):
        trace.pop(key)
    wide = bars[0].get_height() if flat else bars[0].get_width()
    return trace | {
        "type": "bar",
        "orientation": "h" if flat else "v",
        "width": round(float(wide), 3),
        "line": {"color": colour},
        "marker": {"color": colour},
    }


def placed(shape, key):
    """A line or a rectangle across the axes, as Plotly places it."""
    ax, artist, x, y, colour = shape
    in_x, in_y = artist.get_transform().contains_branch_seperately(ax.transData)
    placed = {
        "type": "rect" if isinstance(artist, Rectangle) else "line",
        "xref": f"x{key}" if in_x else f"x{key} domain",
        "yref": f"y{key}" if in_y else f"y{key} domain",
        **{
            name: float(f"{v:.5g}")
            for name, v in zip(("x0", "x1", "y0", "y1"), [*x, *y], strict=True)
        },
        "line": {"color": to_hex(colour), "width": 0 if isinstance(artist, Rectangle) else 1},
    }
    if isinstance(artist, Rectangle):
        placed |= {"fillcolor": to_hex(colour), "opacity": round(float(colour[-1]), 3)}
        placed["layer"] = "below"
    return placed


def words(ax, key):
    """Text at a place of the data."""
    return [
        {
            "text": html.escape(text.get_text()),
            "x": float(f"{place[0]:.5g}"),
            "y": float(f"{place[1]:.5g}"),
            "xref": f"x{key}",
            "yref": f"y{key}",
            "showarrow": False,
            "xshift": 8,
            "yshift": 8,
        }
        for text in ax.texts
        for place in [getattr(text, "xy", text.get_position())]
        if text.get_text() and all(isinstance(p, (int, float, np.number)) for p in place)
    ]
