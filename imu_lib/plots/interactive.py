"""A figure that the reader can zoom and read values from, beside the one that is drawn.

`interactive(plots.allan(curve))` draws as before and stores the curves of the figure as JSON among
the cell's outputs; `book/_static/book.js` draws them with Plotly, one file that the book carries.
Nothing in it changes from one run to the next: no ids, numbers of four digits.
"""

from __future__ import annotations

import json

import numpy as np

from imu_lib.plots import traces
from imu_lib.units import ACCEL, GYRO

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
        ends = [traces.limits(ax, which) for which in "xy"]
        found, shapes = traces.curves(ax, ends)
        for trace in found:
            trace |= {"xaxis": f"x{key}", "yaxis": f"y{key}"}
            if trace["name"]:
                same = (trace["name"], trace.get("fillcolor") or trace["line"]["color"])
                trace |= {"legendgroup": trace["name"], "showlegend": same not in named}
                named.add(same)
            else:
                trace["showlegend"] = False
        data += found
        layout["shapes"] += [traces.placed(shape, key) for shape in shapes]
        layout["annotations"] += traces.words(ax, key)
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
