"""Results as tables for the terminal and as self-contained HTML pages."""

import base64
import html
import io
import math

from imu_lib import units

TITLES = {
    "allan": "Allan variance",
    "psd": "spectrum",
    "likelihood": "likelihood",
    "gauss_markov": "autocorrelation",
}
NAMES = {"sigma": "Gauss-Markov sigma", "correlation_time": "correlation time"}
STYLE = (
    "body{font-family:system-ui,sans-serif;max-width:70rem;margin:2rem auto;padding:0 "
    "1rem;line-height:1.45}table{border-collapse:collapse;margin:1rem "
    "0;font-variant-numeric:tabular-nums;display:block;overflow-x:auto}"
    "td,th{white-space:nowrap;padding:.2rem .6rem;border-bottom:1px solid "
    "#ccc;text-align:right}td:first-child,th:first-child{text-align:left}"
    "td.words{white-space:normal;text-align:left;min-width:18rem}"
    "img{max-width:100%}figcaption{color:#444;font-size:.9rem}.note{color:#444}@media "
    "(prefers-color-scheme:dark){body{background:#1b1b1b;color:#ddd}td,th{border-color:#444}"
    "figcaption,.note{color:#aaa}img{background:#fff}}"
)


# -- HTML


def page(title, *parts):
    """A whole HTML page without outside references; `parts` are pieces of HTML in order."""
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">\n<meta name="viewport" '
        f'content="width=device-width,initial-scale=1">\n<title>{html.escape(title)}</title>\n'
        f"<style>{STYLE}</style>"
        f"</head>\n<body>\n<h1>{html.escape(title)}</h1>\n"
        + "\n".join(parts)
        + "\n</body></html>\n"
    )


def heading(text, level=2):
    return f"<h{level}>{html.escape(text)}</h{level}>"


def paragraph(text, *, note=False):
    return f"<p{' class=note' if note else ''}>{html.escape(text)}</p>"


def bullets(items):
    return (
        "<ul>" + "".join(f"<li>{html.escape(str(item))}</li>" for item in items) + "</ul>"
        if items
        else ""
    )


WORDS = 40  # characters from which on a cell is a text, which runs over several lines


def table_html(header, rows):
    """A table; cells are escaped."""
    head = "".join(f"<th>{html.escape(str(cell))}</th>" for cell in header)
    body = "".join("<tr>" + "".join(map(_cell, row)) + "</tr>" for row in rows)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def _cell(cell):
    text = str(cell)
    return f"<td{' class=words' if len(text) > WORDS else ''}>{html.escape(text)}</td>"


def png(ax):
    """The figure of these axes as PNG bytes; the figure is closed."""
    figure = ax.figure
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", metadata={"Software": None})
    from imu_lib.plots.style import plt

    plt.close(figure)
    return buffer.getvalue()


def figure_html(image, caption=""):
    """A PNG (bytes, or axes) inside the page."""
    data = image if isinstance(image, bytes) else png(image)
    text = html.escape(caption)
    return (
        f'<figure><img alt="{text}" src="data:image/png;base64,{base64.b64encode(data).decode()}">'
        f"<figcaption>{text}</figcaption></figure>"
    )


# -- coefficients ---------------------------------------------------------------------------------


def number(value, digits=4):
    """A number to `digits` significant digits, `-` where there is none."""
    return "-" if value is None or not math.isfinite(value) else f"{value:.{digits}g}"


LEAST_P = "1e-9"  # a smaller probability says nothing more


def probability(value):
    """A p-value to two digits; a smaller one than a thousand-millionth says nothing more."""
    tiny = value is not None and value < float(LEAST_P)
    return f"< {LEAST_P}" if tiny else number(value, 2)


def estimate(e, symbol, channel, digits=4):
    """`value [low, high]` in the datasheet unit, `< high` where the record does not show the
    quantity.
    """
    base = symbol.rstrip("0123456789").rstrip("_") if symbol[-1:].isdigit() else symbol
    factor, _ = units.datasheet(base, channel)
    if e.value is None:
        return f"< {number(e.high / factor, 3)}" if math.isfinite(e.high) else "not shown"
    return (
        f"{number(e.value / factor, digits)} [{number(e.low / factor, digits)}, "
        f"{number(e.high / factor, digits)}]"
    )


def unit_name(symbol, channel):
    base = symbol.rstrip("0123456789").rstrip("_") if symbol[-1:].isdigit() else symbol
    return units.datasheet(base, channel)[1]


def rows_of(result, sensor):
    """Rows (coefficient, unit, method, one cell per axis) of a Characterisation for `gyro` or
    `accel`.
    """
    names = [name for name in result.channels if name.startswith(sensor)]
    rows = []
    for method, title in TITLES.items():
        tables = {name: getattr(result[name], method) for name in names}
        symbols = list(dict.fromkeys(symbol for entry in tables.values() for symbol in entry))
        for symbol in symbols:
            cells = [
                estimate(tables[n][symbol], symbol, n) if symbol in tables[n] else "-"
                for n in names
            ]
            base = symbol.split("_2")[0]
            rows.append(
                (
                    NAMES.get(base, base) + symbol[len(base) :].replace("_", " "),
                    unit_name(symbol, names[0]),
                    title,
                    *cells,
                )
            )
    ar = [result[name].autoregressive for name in names]
    rows.append(
        (
            "AR order",
            "",
            "AR model",
            *(str(a["order"]) if a["order"] is not None else "-" for a in ar),
        )
    )
    white = {True: "yes", False: "no", None: "-"}
    rows.append(("AR residuals white", "", "AR model", *(white[a["white"]] for a in ar)))
    rows.append(("sum of processes", "", "likelihood", *(result[n].choice.name for n in names)))
    rows.append(
        (
            "goodness of fit, p",
            "",
            "likelihood",
            *(probability(result[n].choice.p_value) for n in names),
        )
    )
    return [
        "coefficient",
        "unit",
        "method",
        *(n.replace("accel", "accelerometer").replace("_", " ") for n in names),
    ], rows


def sensors(result):
    """`gyro` and `accel`, those that the result has."""
    return [s for s in ("gyro", "accel") if any(name.startswith(s) for name in result.channels)]


def notes_of(result):
    """Sentences on the record and on each channel; the same sentence on several channels is said
    once.
    """
    said = {}
    for name, channel in result.channels.items():
        for note in channel.notes:
            said.setdefault(note, []).append(name.replace("_", " "))
    return [*result.notes, *(f"{', '.join(names)}: {note}" for note, names in said.items())]


def characterisation_page(result, figures=()):
    """The whole result as one page; `figures` are (PNG bytes, caption)."""
    parts = [
        paragraph(
            f"{units.duration(result.duration)} at {result.rate:.6g} Hz. {result.source}".strip()
        )
    ]
    for sensor in sensors(result):
        parts += [
            heading("Gyros" if sensor == "gyro" else "Accelerometers"),
            table_html(*rows_of(result, sensor)),
        ]
    parts.append(
        paragraph(
            "Values with 95 % intervals; < stands before the 95 % upper limit of what the record "
            "does not show. N, B, K, Q, R as in IEEE Std 952 and 1293.",
            note=True,
        )
    )
    notes = notes_of(result)
    parts += [heading("Notes"), bullets(notes)] if notes else []
    parts += [figure_html(image, caption) for image, caption in figures]
    return page(f"Errors of {result.name or 'the record'} at rest", *parts)
