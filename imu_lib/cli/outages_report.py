"""The outage comparison as text."""

from __future__ import annotations

from imu_lib.cli import common

FEW = 12  # outages up to which each has a line


def text(study, drive) -> str:
    """Errors of each model, what its filter says of itself, pairs, notes."""
    import numpy as np

    against = study.scored_against
    truth = "the drive's reference" if against == "reference" else "the full-GNSS solution"
    errors = {name: study.errors(name, against=against) for name in study.models}
    count = len(study.windows)
    parts = [
        f"{drive.name or 'drive'}: {count} outage{'' if count == 1 else 's'}; maximum horizontal "
        f"error in m against {truth}"
    ]
    if len(study.windows) <= FEW:
        rows = [
            [
                str(i + 1),
                f"{w.start:.0f}",
                f"{w.duration:.0f}",
                f"{3.6 * w.mean_speed:.1f}",
                *(_metres(errors[m][i]) for m in errors),
            ]
            for i, w in enumerate(study.windows)
        ]
        parts.append(common.table(rows, ["outage", "start s", "for s", "km/h", *study.models]))
    rows = []
    for name, m in study.models.items():
        e = errors[name][np.isfinite(errors[name])]
        rows.append(
            [
                name,
                f"{m.states - len(m.added)}{f' + {len(m.added)}' if m.added else ''}",
                *(_metres(f(e)) if e.size else "-" for f in (np.median, np.mean, np.max)),
                _metres(np.median([s[-1] for s in m.sigma])),
                f"{m.over_predicted(against):.2g}",
                f"{m.nis:.2g}",
                f"{100.0 * max(m.rejected.values()):.2g} %",
            ]
        )
    header = ["model", "states", "median", "mean", "worst"]
    header += ["predicted sigma", "error/predicted", "NIS", "rejected"]
    parts.append(common.table(rows, header))
    estimated = _estimated(study)
    if estimated:
        parts.append(estimated)
    pairs = study.paired(against=against)
    if pairs:
        rows = [
            [
                f"{p.better} against {p.than}",
                f"{p.ratio:.3g} [{p.low:.3g}, {p.high:.3g}]",
                f"{100 * p.wins:.0f} %",
                "yes" if p.decided else "no",
            ]
            for p in pairs
        ]
        parts.append(common.table(rows, ["pair", "ratio of errors [95 %]", "wins", "decided"]))
    return "\n\n".join(parts) + "".join(
        f"{'' if i else chr(10)}\nnote: {note}" for i, note in enumerate(study.notes)
    )


def _metres(value):
    return "-" if value != value else f"{value:.4g}"


def _estimated(study):
    """What the models estimated along, at the end of the drive."""
    rows = []
    for name in study.models:
        for state, of in study.estimates(name).items():
            rows.append([name, state, f"{of['value']:.4g}", f"{of['sd']:.2g}"])
    return common.table(rows, ["model", "estimated along (SI)", "value", "sd"]) if rows else ""
