"""A figure that the reader can zoom and read values from, beside the one that is drawn.

`interactive(plots.allan(curve))` draws as before and stores the curves of the figure as JSON among
the cell's outputs; `book/_static/book.js` draws them with Plotly, one file that the book carries.
Nothing in it changes from one run to the next: no ids, numbers of four digits.
"""

from __future__ import annotations

import html
import json

import numpy as np
from matplotlib.collections import LineCollection, PathCollection, PolyCollection
from matplotlib.colors import to_hex, to_rgb
from matplotlib.container import BarContainer
from matplotlib.patches import Rectangle

from imu_lib.plots import style
from imu_lib.units import ACCEL, GYRO

# of a curve, and of all curves of a figure together: more only make the page heavy
POINTS, ALL_POINTS = 1200, 4000
DASHES = {"-": "solid", "--": "dash", ":": "dot", "-.": "dashdot"}
MARKERS = {"s": "square", "x": "x", "+": "cross", "^": "triangle-up", "v": "triangle-down"}
MARKERS |= {"D": "diamond", "_": "line-ew-open", "|": "line-ns-open"}
#: datasheet unit of an axis -> (factor to SI, SI unit)
SI = {f"{unit}": (factor, si) for table in (ACCEL, GYRO) for factor, unit, si in table.values()}
SI |= {f"({unit})²/Hz": (factor**2, f"({si})²/Hz") for unit, (factor, si) in SI.items()}
SI |= {f"({unit})²": (factor**2, f"({si})²") for unit, (factor, si) in SI.items()}


class Explorable:
    """The curves of a figure as HTML that draws nothing by itself; the page's script does."""

    def __init__(self, figure: dict):
        self.figure = figure

    def __repr__(self):
        return f"{len(self.figure['data'])} curves to zoom and to read values from"

    def _repr_html_(self):
        text = json.dumps(self.figure, ensure_ascii=False, separators=(",", ":"))
        text = text.replace("</", "<\\/")  # would end the script
        return f'<script type="application/json" class="explorable">{text}</script>'


def interactive(axes):
    """Store the figure of `axes` (one or an array) for zooming and hovering; returns `axes`."""
    from IPython.display import display

    panels = [ax for ax in np.ravel(axes) if ax is not None]
    if panels:
        display(Explorable(described(panels[0].figure)))
    return axes


def described(figure) -> dict:
    """Plotly's `data` and `layout` of a matplotlib figure, and what takes each axis to SI."""
    data, layout, si, named = [], {"shapes": [], "annotations": []}, {}, set()
    for number, ax in enumerate(figure.axes, 1):
        key = "" if number == 1 else str(number)
        for which in "xy":
            axis, factor = _axis(ax, which, key)
            layout[f"{which}axis{key}"] = axis
            if factor:
                si[f"{which}axis{key}"] = factor
        ends = [_limits(ax, which) for which in "xy"]
        traces, shapes = _curves(ax, ends)
        for trace in traces:
            trace |= {"xaxis": f"x{key}", "yaxis": f"y{key}"}
            if trace["name"]:
                same = (trace["name"], trace.get("fillcolor") or trace["line"]["color"])
                trace |= {"legendgroup": trace["name"], "showlegend": same not in named}
                named.add(same)
            else:
                trace["showlegend"] = False
        data += traces
        layout["shapes"] += [_placed(shape, key) for shape in shapes]
        layout["annotations"] += _words(ax, key)
    width, height = figure.get_size_inches()
    return {"data": data, "layout": layout, "si": si, "aspect": round(float(height / width), 3)}


def _axis(ax, which, key):
    label = getattr(ax, f"get_{which}label")()
    log = getattr(ax, f"get_{which}scale")() == "log"
    low, high = getattr(ax, f"get_{which}lim")()
    axis = {
        "title": {"text": label},
        "type": "log" if log else "linear",
        "range": _range(*(np.log10([low, high]) if log else (low, high)), log),
        "domain": _domain(ax, which),
        "anchor": f"{'y' if which == 'x' else 'x'}{key}",
    }
    if which == "x" and ax.get_title():
        axis["title"]["text"] = f"{ax.get_title()}: {label}" if label else ax.get_title()
    names = [t.get_text() for t in getattr(ax, f"get_{which}ticklabels")()]
    places = getattr(ax, f"get_{which}ticks")()
    if any(any(c.isalpha() for c in n.replace("mathdefault", "")) for n in names):
        axis |= {"tickvals": [float(p) for p in places], "ticktext": names}
    if which == "y" and ax.get_aspect() != "auto":
        axis["scaleanchor"] = f"x{key}"
    return axis, SI.get(label.rpartition(", ")[2])


def _range(low, high, log):
    """The ends of an axis: five digits, and no more than a ten-thousandth of a decade or of the
    axis, which an end that happens to lie beside zero has many times over.
    """
    places = 4 if log else 4 - int(np.floor(np.log10(abs(high - low) or 1.0)))
    return [round(float(f"{v:.5g}"), places) + 0.0 for v in (low, high)]


def _domain(ax, which):
    """Where a panel lies in the figure, from 0 to 1, with room between panels."""
    spec = ax.get_subplotspec()
    if spec is None:
        return [0.0, 1.0]
    rows, columns = spec.get_gridspec().get_geometry()
    count, span = (columns, spec.colspan) if which == "x" else (rows, spec.rowspan)
    gap = 0.16 if which == "x" else 0.2
    low, high = span.start / count, span.stop / count
    if which == "y":
        low, high = 1.0 - high, 1.0 - low
    room = gap / count
    return [
        round(low + (room / 2 if low else 0.0), 4),
        round(high - (room / 2 if high < 1 else 0.0), 4),
    ]


def _limits(ax, which):
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


def _curves(ax, ends):
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


def _placed(shape, key):
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


def _words(ax, key):
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
