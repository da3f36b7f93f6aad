"""The result of the gap workflow on a drive as one self-contained HTML page."""

from __future__ import annotations

from imu_lib import plots, report
from imu_lib.cli.gap_drive import CONFIDENCE, gap, runner_up, sentence, values

INDEX = (
    "The gap index is the distance of the innovations' statistics from those of simulated copies "
    "over the median distance that one copy has from the others: 1 in a right filter."
)
MAP = (
    "The way driven; colour is the size of the innovations that are left, black the withheld "
    "windows."
)
INNOVATIONS = (
    "Innovations before and after; a right filter keeps 95 % of them between the dashed lines."
)


def write(found, path) -> None:
    """Write the page for a `gap.drive.DriveReport`."""
    parts = [report.paragraph(_about(found)), _indices(found)]
    for step in found.steps:
        parts += _step(step, found.invisible)
    if found.steps:
        parts.append(report.paragraph(CONFIDENCE))
    else:
        parts.append(report.paragraph("Nothing is missing that the innovations would show."))
    left = "Nothing is left unexplained."
    if found.unexplained:
        left = f"Unexplained, no effect of the catalogue accounts for it: {found.unexplained}."
    parts += [
        report.paragraph(left),
        report.heading("The drive"),
        report.figure_html(report.png(plots.drive_gap_map(found)), MAP),
        report.figure_html(report.png(plots.drive_gap_innovations(found).ravel()[0]), INNOVATIONS),
    ]
    parts += _outages(found) + _invisible(found)
    if found.notes:
        parts += [report.heading("Notes"), report.bullets(found.notes)]
    with open(path, "w", encoding="utf-8") as handle:
        handle.write(report.page("What does the filter not know about this drive?", *parts))


def _about(found):
    drive = found.drive
    base = "an error model that was given" if found.given else "noise fitted to the drive itself"
    name = drive.name or drive.source or "drive"
    size = f"{drive.duration:.0f} s, IMU at {drive.rate:.4g} Hz, {len(drive.gnss_time)} fixes"
    return f"Drive: {name}, {size}. Compared with {base}. {INDEX}"


def _indices(found):
    before, after = found.before, found.after
    rows = [
        ["gap index", f"{before.index:.2f}", f"{after.index:.2f}"],
        ["mean square of innovations", f"{before.nis:.2f}", f"{after.nis:.2f}"],
        [
            "largest correlation between fixes",
            f"{before.whiteness:.2f}",
            f"{after.whiteness:.2f}",
        ],
    ]
    return report.table_html(["", "before", "after"], rows)


def _step(step, invisible):
    """What was found, in words, with its evidence."""
    lines = [
        f"Where: {step['where']}.",
        f"Physical cause: {step['cause']}",
        f"Confidence {step['confidence']:.3g}{runner_up(step)}.",
        f"Log-likelihood gained {step['log_likelihood_gain']:.1f}; {gap(step, 2)}.",
    ]
    if said := sentence(step):
        lines.insert(0, f"{said[0].upper()}{said[1:]}.")
    if step["indistinguishable"]:
        others = ", ".join(step["indistinguishable"])
        lines.append(f"This drive cannot tell it from: {others}.")
    title = report.heading(f"{step['effect']}: {values(step, invisible)}", 3)
    return [title, report.bullets(lines)]


def _outages(found):
    if found.outages is None:
        return [report.paragraph("No window of the drive could be withheld for an outage.")]
    medians, ratio = found.outages.medians(), found.outages.ratio()
    rows = [[n, f"{medians[n]:.3g}" if n in medians else ""] for n in ("before", "after")]
    parts = [
        report.heading("Outages that the search has not seen"),
        report.table_html(["model", "median of the largest error, m"], rows),
    ]
    if ratio:
        parts.append(
            report.paragraph(
                f"After over before: {ratio['value']:.2g} [{ratio['low']:.2g}, "
                f"{ratio['high']:.2g}], {len(found.outages.windows)} windows of "
                f"{found.outages.duration:.0f} s, paired."
            )
        )
    study, against = found.outages.study, found.outages.against
    fans = {name: plots.outage_fan(study, name=name, against=against) for name in study.models}
    top = max(ax.get_ylim()[1] for ax in fans.values())
    for name, ax in fans.items():
        ax.set_ylim(0.0, top)  # one scale, so that the two are seen to differ
        caption = (
            f"Errors in all outages, {name}, with the radius that the filter expects to hold 95 % "
            "of them."
        )
        parts.append(report.figure_html(ax, caption))
    return parts


def _invisible(found):
    if not found.invisible:
        return []
    alike = {}  # components of one effect that are not seen for one reason
    for entry in found.invisible:
        name, _, component = entry["parameter"].partition(" ")
        limit = f"{component} {entry['upper_limit']:.3g}".strip()
        alike.setdefault((entry["effect"], name, entry["why"]), []).append(limit)
    rows = [[effect, name, ", ".join(limits), why] for (effect, name, why), limits in alike.items()]
    return [
        report.heading("Not visible on this drive"),
        report.table_html(["effect", "parameter", "upper limit (SI)", "why"], rows),
    ]
