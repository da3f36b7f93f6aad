"""The result of the gap workflow as one self-contained HTML page."""

from __future__ import annotations

from imu_lib import report
from imu_lib.gap.sentences import absorbed
from imu_lib.gap.sentences.summary import sentences
from imu_lib.gap.table import describe, on_channel
from imu_lib.plots import gap as plots

COLUMNS = [
    "channel",
    "gap before",
    "gap after",
    "held out before",
    "held out after",
    "found",
    "unexplained",
]
INDEX = (
    "The gap index is the distance of the measurement from an ensemble of simulations over the "
    "median distance that one simulation has from the others: 1 where the measurement differs no "
    "more than simulations do."
)


def write(found, path) -> None:
    """Write the page for a `gap.Report`."""
    names = list(found.channels)
    parts = [
        *(report.paragraph(s) for s in sentences(found)),
        report.paragraph(_about(found)),
        report.table_html(COLUMNS, [_row(found, name) for name in names]),
    ]
    if found.record_steps or found.record_unexplained:
        parts += [report.heading("On the whole record"), *_steps(found.record_steps, "record")]
        if found.record_unexplained:
            parts.append(report.paragraph(f"Unexplained: {found.record_unexplained}."))
    for name in names:
        parts += _channel(found, name)
    if said := absorbed.sentence(found):
        parts.append(report.paragraph(said))
    clean = [n for n in names if on_channel(found, n).startswith("nothing")]
    if clean:
        said = on_channel(found, clean[0]).partition("nothing")[2].lstrip(": ")
        parts.append(report.paragraph(f"Nothing missing in {', '.join(clean)}: {said}."))
    with open(path, "w", encoding="utf-8") as handle:
        handle.write(report.page("Where simulation and measurement disagree", *parts))


def _about(found):
    record = found.record
    name = record.name or record.source or "static record"
    base = "a model fitted to the record itself"
    if found.given:
        base = "a model that was given, its parameters held"
    size = f"{record.duration:.0f} s at {record.rate:.6g} Hz"
    return f"Record: {name}, {size}. Compared with {base}. {INDEX}"


def _channel(found, name):
    """What was found on one channel, what is left, and the measurement against its ensemble."""
    result = found.channels[name].result
    if not result.steps and not result.unexplained and not result.small:
        return []
    parts = [report.heading(name), *_steps(result.steps, name)]
    for text, what in (
        ("Unexplained, no effect of the catalogue accounts for it: ", result.unexplained),
        (
            "Beyond chance, yet too small to matter at three standard deviations: ",
            "; ".join(result.small),
        ),
    ):
        if what:
            parts.append(report.paragraph(f"{text}{what}."))
    for view in getattr(found, "views", None) or (found,):
        seen = view.channels.get(name)
        if seen is not None and seen.before is not None:
            parts += _figures(seen, view.record)
    return parts


def _row(found, name):
    c = found.channels[name]
    number = lambda v: "" if v is None else f"{v:.2f}"  # noqa: E731
    held = c.held_out or {}
    return [
        name,
        number(c.before and c.before.value),
        number(c.after and c.after.value),
        number(held.get("before")),
        number(held.get("after")),
        on_channel(found, name),
        c.result.unexplained or "",
    ]


def _steps(steps, name):
    out = []
    for s in steps:
        lines = [
            f"Where: {s.where}.",
            f"Physical cause: {s.cause}",
            f"Confidence {s.confidence:.3g}; runner-up: {s.runner_up['effect']} "
            f"({s.runner_up['confidence']:.2g}).",
        ]
        for key, (low, high) in _intervals(s):
            lines.append(f"95 % interval of {key}: {low:.4g} to {high:.4g} (SI).")
        if s.indistinguishable:
            lines.append("This record cannot tell it from: " + ", ".join(s.rivals) + ".")
        if s.gap_before is not None:
            lines.append(f"Gap index {s.gap_before:.2f} before it, {s.gap_after:.2f} with it.")
        out += [report.heading(describe(s, name), 3), report.bullets(lines)]
    return out


def _intervals(step):
    """(what, interval) of every parameter; of a vector one for each channel, or for its places."""
    out = []
    for key, interval in step.intervals.items():
        if not isinstance(interval[0], (list, tuple)):
            out.append((key, interval))
            continue
        names = step.parameters.get("channels", ())
        if len(names) != len(interval):
            names = range(1, len(interval) + 1)
        out += [(f"{key} {name}", ends) for name, ends in zip(names, interval, strict=True)]
    return out


def _figures(channel, record):
    """A channel against its ensemble, of the record or of one view of it."""
    n, rate = record.n, record.rate
    at = f" {record.duration / 3600:.3g} h at {rate:.4g} Hz."
    out = []
    for domain, caption in (
        ("psd", "Spectrum: measurement against the bands that hold 95 % of the simulations."),
        ("allan", "Allan deviation, in the same way."),
    ):
        figure = plots.band(channel, domain=domain, rate=rate, n=n)
        out.append(report.figure_html(figure, caption + at))
    caption = "Gap index by domain; 1 is a measurement like any simulation."
    return [*out, report.figure_html(plots.domains(channel), caption)]
