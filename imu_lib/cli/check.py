"""`imu-lib check FILE`: the health of a record or drive."""

from __future__ import annotations

from pathlib import Path

from imu_lib.cli import common, drives
from imu_lib.errors import InputError

NAME = "check"
#: Samples above which a record is looked at part by part: faults are looked for in many copies of it.
LONG = 1 << 19
HELP = "Health of a record or drive: rate, duration, gaps, jitter, duplicates, NaN, saturation, frozen samples, units, rest, temperature."


def add_arguments(parser):
    common.add_record_arguments(parser)
    parser.add_argument(
        "--gnss", metavar="FILE", help="the GNSS solution of a drive (RTKLIB .pos or NMEA)"
    )
    common.add_json_argument(parser)


def run(args):
    common.check_writable(args.json)
    health, columns = look(args)
    told = {"columns": columns, **health.to_json()}
    common.write_json(told, args.json)
    if args.json != "-":
        print(described(columns))
        print(report(health))


def look(args):
    """The health of what the flags name (a drive where the file has GNSS, else a record), and what its
    columns were read as.
    """
    from imu_lib import health, readers

    if args.file and (args.gyro or args.accel):
        raise InputError("Give one FILE, or --gyro FILE and --accel FILE, not both.")
    if args.start is not None and args.stop is not None and args.stop <= args.start:
        raise InputError(f"--stop {args.stop:g} is not after --start {args.start:g}.")
    options = common.record_options(args)
    if args.file and (args.gnss or _has_gnss(args.file)):
        common.refuse_without_effect(args, ("only",), drives.BOTH)
        found = health.of_drive(readers.read_drive(args.file, gnss=args.gnss, **options))
        return found, readers.read_raw(args.file, columns=args.columns, topic=args.topic).described
    if args.file and not getattr(args, "only", None):
        if (long := common.open_on_disk(args, least=LONG)) is not None:
            bar = common.progress(about="check", total=100)
            done = [0]

            def step(share):
                bar.update(round(100 * share) - done[0])
                done[0] = round(100 * share)

            found = health.of_long(long, progress=step)
            bar.close()
            return found, list(long.described)
    found = readers.read(args.file, lenient=True, **options)
    return health.of_record(found.record, repeats=found.repeats), list(found.columns)


def described(columns) -> str:
    """What each column was read as, in which unit, on what evidence; those that are not used, with
    the reason. Columns that are not used for one reason stand in one line.
    """
    rows, last = [], None
    for c in columns:
        reason = None if c.read_as else c.evidence
        if reason and last is not None and last[0] == reason:
            last[1].append(c.name)
            continue
        last = (reason, [c.name]) if reason else None
        rows.append((c, last[1] if last else [c.name]))
    if not rows:
        return ""
    table = [
        (
            names[0] if len(names) == 1 else f"{names[0]} .. {names[-1]}",
            c.read_as or "not used",
            c.unit or "",
            c.evidence,
        )
        for c, names in rows
    ]
    head = ("column", "read as", "unit", "evidence")
    widths = [max(len(r[i]) for r in (head, *table)) for i in range(3)]
    lines = [
        "  ".join([*(r[i].ljust(widths[i]) for i in range(3)), r[3]]).rstrip()
        for r in (head, tuple("-" * w for w in (*widths, 8)), *table)
    ]
    return "\n".join(lines) + "\n"


def _has_gnss(path) -> bool:
    import zipfile

    if not Path(path).is_file() or not zipfile.is_zipfile(path):
        return False
    try:
        with zipfile.ZipFile(path) as archive:
            return "gnss_position.npy" in archive.namelist()
    except zipfile.BadZipFile:
        return False


def report(health) -> str:
    """The health as text, in datasheet units."""
    from imu_lib import units

    clock, motion = health.clock, health.motion
    stamps = (
        "perfectly even, or none in the file"
        if not clock.stamped
        else f"jitter {clock.jitter * 1e3:.3g} ms" + (", in bursts" if clock.bursts else "")
    )
    rest = (
        motion.state
        if motion.state in ("at rest", "touched", "moved")
        else f"{motion.state}, {100 * motion.moving_share:.3g} % of the seconds"
    )
    facts = [
        ("record", health.source),
        ("samples", f"{clock.samples:,}"),
        ("rate", f"{clock.rate:.6g} Hz"),
        ("duration", _duration(clock.duration)),
        ("time stamps", stamps),
        (
            "gaps",
            f"{clock.gap_count} ({clock.missing:,} samples missing)" if clock.gap_count else "none",
        ),
        ("repeated stamps", f"{clock.repeats:,}"),
        ("motion", rest),
    ]
    if motion.gravity is not None:
        facts.append(
            ("specific force", f"{motion.gravity:.4g} m/s^2, {motion.gravity / units.G:.4g} g")
        )
    if health.temperature:
        t = health.temperature
        facts.append(("temperature", f"{t['low']:.4g} to {t['high']:.4g} degC"))
    if health.gnss:
        g = health.gnss
        facts += [
            (
                "fixes",
                f"{g['fixes']:,} at {g['rate']:.4g} Hz, {g['from']:.4g} to {g['to']:.4g} s"
                + (", with velocity" if g["velocity"] else ""),
            ),
            ("reference", "yes" if g["reference"] else "none"),
        ]
        if "fix_codes" in g:
            facts.append(("fix codes", ", ".join(f"{c}: {n:,}" for c, n in g["fix_codes"].items())))
    width = max(len(k) for k, _ in facts)
    lines = [f"{k.ljust(width)}  {v}" for k, v in facts]
    rows = []
    for name, c in health.channels.items():
        factor = units.DEG_PER_S if name.startswith("gyro") else units.G
        noise, unit = units.datasheet("N", name)
        grid = "-" if c.resolution is None else f"{c.resolution / factor:.3g}"
        rows.append(
            (
                name,
                "deg/s" if name.startswith("gyro") else "g",
                f"{c.mean / factor:.4g}",
                f"{c.sd / factor:.3g}",
                grid,
                f"{c.noise / noise:.3g} {unit}",
                c.nan,
                c.saturated,
                c.frozen,
            )
        )
    lines += [
        "",
        common.table(
            rows,
            (
                "channel",
                "unit",
                "mean",
                "sd",
                "step",
                "short-time noise",
                "NaN",
                "clipped",
                "frozen",
            ),
        ),
    ]
    for title, sentences in (("Reading", health.notes), ("Attention", health.findings)):
        if sentences:
            lines += ["", title] + [f"  - {s}" for s in sentences]
    if not health.findings:
        lines += ["", "Nothing to object to."]
    return "\n".join(lines)


def _duration(seconds: float) -> str:
    from imu_lib import units

    return f"{seconds:.6g} s" + (f" ({units.duration(seconds)})" if seconds >= 120 else "")
