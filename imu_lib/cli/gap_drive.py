"""`imu-lib gap DRIVE [--model MODEL]`: what the filter does not know about a drive."""

from __future__ import annotations

import sys

from imu_lib.units import DEG


def asked(args) -> bool:
    """Whether the call names a drive: a GNSS file beside the IMU's, or an archive with fixes."""
    from imu_lib.cli import drives

    return bool(args.gnss) or drives.has_fixes(args.file)


def run(args, model) -> int:
    """The workflow on a drive, its result printed and written."""
    from imu_lib.cli import common, drives
    from imu_lib.gap import drive as gap_drive

    common.refuse_without_effect(args, ("only",), drives.BOTH)
    for flag, given in (("--simulations", args.simulations != 100), ("--jobs", args.jobs)):
        if given:
            print(f"note: {flag} has no effect on a drive.", file=sys.stderr)
    drive = drives.opened(args.file, args)
    heading = None if args.heading is None else args.heading * DEG
    found = gap_drive.close(drive, model, seed=args.seed, heading=heading, say=_say)
    if args.json:
        common.write_json(found.to_json(), args.json)
    if args.out:
        from imu_lib.cli.gap_drive_report import write

        with common.atomic_folder(args.out) as folder:
            found.model.save(folder / "model.json")
            write(found, folder / "report.html")
    if args.json != "-":
        print(text(found))
    return 0


def _say(line):
    if sys.stderr.isatty():
        print(f"\r\x1b[2K{line[:110]}", end="", file=sys.stderr, flush=True)


#: Confidence from which on a rival is named.
NAMED = 1e-3
CONFIDENCE = (
    "A confidence is how often names found as clearly were right on blind drives, a counted share: "
    "what it leaves to 1 is no evidence for the runner-up, whose own confidence stands beside it."
)
#: What a parameter is told in: its unit, or the effect's own; SI angles become degrees.
UNITS = {
    **dict.fromkeys(("offset", "velocity_offset", "correlation_time"), "s"),
    **dict.fromkeys(("roll", "pitch", "yaw", "error"), "deg"),
    **dict.fromkeys(("arm", ("gnss_correlated", "sigma"), ("gnss_outliers", "scale")), "m"),
    ("gyro_bias", "bias"): "deg/s",
    ("accel_bias", "bias"): "m/s^2",
}


def values(step, invisible=()) -> str:
    """Parameters of a step in a line, with their intervals, units and axes; of components that are
    `invisible` on the drive, that they are.
    """
    unseen = {e["parameter"].split()[-1] for e in invisible if e["effect"] == step["effect"]}
    parts = []
    for key, value in step["parameters"].items():
        interval = step["intervals"].get(key)
        unit = _unit(step, key)
        factor = 1.0 / DEG if unit.startswith("deg") else 1.0
        if isinstance(value, list) and interval:
            axes = "xyz" if len(value) == 3 else [""] * len(value)
            named = list(zip(axes, value, interval, strict=True))
            shown = [
                f"{a} {_told(v, ends, factor)}".strip() for a, v, ends in named if a not in unseen
            ]
            if shown and unit:
                shown[-1] += f" {unit}"
            parts += shown + [f"{a} not visible" for a, *_ in named if a in unseen]
            continue
        if isinstance(value, list):
            parts.append(" ".join(f"{v}" for v in value))
        elif isinstance(value, float):
            parts.append(f"{key.replace('_', ' ')} {_told(value, interval, factor)}")
        else:
            parts.append(f"{value}")
            continue
        parts[-1] += f" {unit}" if unit else ""
    return ", ".join(parts)


def _told(value, ends, factor) -> str:
    interval = f" [{ends[0] * factor:.3g}, {ends[1] * factor:.3g}]" if ends else ""
    return f"{value * factor:.4g}{interval}"


def _unit(step, key) -> str:
    if key in ("N", "N_per_speed"):
        of = str(step["parameters"].get("channel", "accel"))
        unit = f"{'rad/s' if of.startswith('gyro') else 'm/s^2'}/sqrt(Hz)"
        return f"{unit} per m/s" if key == "N_per_speed" else unit
    return UNITS.get((step["effect"], key), UNITS.get(key, ""))


def text(found) -> str:
    """The result as text."""
    lines = ["" if not sys.stderr.isatty() else "\r"]
    base = "a model that was given" if found.given else "noise fitted to the drive itself"
    lines.append(f"{found.drive.name or 'drive'}, compared with {base}.")
    if not found.steps:
        lines.append("Nothing is missing that the innovations would show.")
    for step in found.steps:
        lines.append(
            f"{step['effect']}: {values(step, found.invisible)}\n    {_lines(step)}\n"
            f"    confidence {step['confidence']:.3g}{runner_up(step)}; "
            f"log-likelihood gain {step['log_likelihood_gain']:.0f}; {gap(step)}"
        )
        if step["indistinguishable"]:
            lines.append(
                "    this drive cannot tell it from " + ", ".join(step["indistinguishable"])
            )
    if found.steps:
        lines.append(CONFIDENCE)
    lines.append(
        f"innovations: mean square {found.before.nis:.2f} before, {found.after.nis:.2f} after (1 "
        f"in a right filter); largest correlation between fixes {found.before.whiteness:.2f} and "
        f"{found.after.whiteness:.2f}"
    )
    if found.outages is not None:
        lines.append(_outages(found.outages))
    if found.invisible:
        lines.append("not visible on this drive: " + ", ".join(_unseen(found.invisible)))
    lines.append(f"unexplained: {found.unexplained or 'nothing'}")
    lines += [f"note: {n}" for n in found.notes]
    return "\n".join(lines)


def runner_up(step) -> str:
    """What of the step's rivals is to be named, with its own confidence; none below NAMED."""
    rival = step["runner_up"]
    if rival["confidence"] < NAMED:
        return f", no rival above {NAMED:g}"
    return f", runner-up {rival['effect']} ({rival['confidence']:.2g})"


def gap(step, digits=1) -> str:
    """The gap index before and with a step; of turned axes, that there is none before."""
    if step["effect"] == "axes":
        return f"gap {step['gap_after']:.{digits}f} with the axes turned"
    return f"gap {step['gap_before']:.{digits}f} to {step['gap_after']:.{digits}f}"


def _lines(step):
    return "\n    ".join(t for t in (sentence(step), step["where"]) if t)


def _unseen(invisible):
    """Effects with those of their components that the drive does not show."""
    parts = {}
    for entry in invisible:
        parts.setdefault(entry["effect"], []).append(entry["parameter"].split()[-1])
    return [f"{effect} ({' '.join(parts[effect])})" for effect in sorted(parts)]


def sentence(step) -> str | None:
    """Who is late, and in which direction, of effects whose sign alone does not say it; None of the
    others.
    """
    p = step["parameters"]
    if step["effect"] == "gnss_time_offset":
        if "velocity_offset" in p:
            return f"{_when('positions', p['offset'])}, {_when('velocities', p['velocity_offset'])}"
        taken = "before" if p["offset"] > 0 else "after"
        return (
            f"{_when('fixes', p['offset'])} against the IMU: what is stamped t was taken {taken} t"
        )
    if step["effect"] == "imu_clock":
        return (
            f"the IMU's clock runs {'fast' if p['scale'] > 0 else 'slow'} against GNSS time, "
            f"by {abs(p['scale']) * 1e6:.4g} parts in a million"
        )
    if step["effect"] == "gnss_noise":
        than = "larger" if p["ratio"] > 1.0 else "smaller"
        return f"errors of the {p['of']} are {than} than stated, {p['ratio']:.3g} times"
    if step["effect"] == "heading":
        return (
            f"the heading given points {abs(p['error']) / DEG:.3g} deg to the "
            f"{'right' if p['error'] > 0 else 'left'} of the true one"
        )
    return None


def _when(what, offset) -> str:
    return f"the {what} are stamped {abs(offset):.3g} s {'late' if offset > 0 else 'early'}"


def _outages(result) -> str:
    medians, ratio = result.medians(), result.ratio()
    line = (
        f"outages of {result.duration:.0f} s that the search has not seen ({len(result.windows)}): "
    )
    if ratio is None and "before" in medians:
        return (
            line
            + f"error {medians['before']:.3g} m before, {medians['after']:.3g} m after; "
            + f"{len(result.windows)} are too few for an interval of their ratio"
        )
    if ratio is None:
        return (
            line + f"median error {medians['after']:.3g} m after; before, the filter does not run"
        )
    return (
        line
        + f"median error {medians['before']:.3g} m before, {medians['after']:.3g} m after; ratio "
        + f"{ratio['value']:.2g} [{ratio['low']:.2g}, {ratio['high']:.2g}]"
    )
