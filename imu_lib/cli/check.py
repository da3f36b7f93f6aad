"""`imu-lib check FILE`: the health of a record or drive."""

from __future__ import annotations

from dataclasses import replace

from imu_lib.cli import common, drives
from imu_lib.errors import InputError

NAME = "check"
#: Samples above which a record is looked at part by part: faults are looked for in many copies of
#: it.
LONG = 1 << 19
HELP = (
    "Health of a record or drive: rate, duration, gaps, jitter, duplicates, NaN, saturation, "
    "frozen samples, units, rest, temperature."
)


def add_arguments(parser):
    common.add_record_arguments(parser)
    parser.add_argument(
        "--gnss", metavar="FILE", help="the GNSS solution of a drive (RTKLIB .pos or NMEA)"
    )
    common.add_json_argument(parser)


def run(args):
    common.check_writable(args.json)
    health, columns = look(args)
    health = _with_stamps(health, columns)
    told = {"columns": columns, **health.to_json()}
    common.write_json(told, args.json)
    if args.json != "-":
        print(described(columns))
        print(report(health))


def look(args):
    """The health of what the flags name (a drive where the file has GNSS, else a record), and what
    its columns were read as.
    """
    from imu_lib import health, readers

    if args.file and (args.gyro or args.accel):
        raise InputError("Give one FILE, or --gyro FILE and --accel FILE, not both.")
    if args.start is not None and args.stop is not None and args.stop <= args.start:
        raise InputError(f"--stop {args.stop:g} is not after --start {args.start:g}.")
    options = common.record_options(args)
    if args.file and (args.gnss or drives.has_fixes(args.file)):
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


def _with_stamps(health, columns):
    """The health with what the file's columns say of stamps: a record keeps none where they are
    perfectly even.
    """
    if health.clock.stamped or not any("time" in (c.read_as or "").split(", ") for c in columns):
        return health
    return replace(health, clock=replace(health.clock, stamped=True, jitter=0.0))


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


def report(health) -> str:
    """The health as text, in datasheet units."""
    facts = _facts(health)
    width = max(len(k) for k, _ in facts)
    lines = [f"{k.ljust(width)}  {v}" for k, v in facts]
    lines += ["", common.table([_row(n, c) for n, c in health.channels.items()], CHANNEL_COLUMNS)]
    for title, sentences in (("Reading", health.notes), ("Attention", health.findings)):
        if sentences:
            lines += ["", title] + [f"  - {s}" for s in sentences]
    if not health.findings:
        lines += ["", "Nothing to object to."]
    return "\n".join(lines)


def _facts(health):
    """(what, value) of the clock, the motion, the temperature and the fixes."""
    from imu_lib import units

    clock, motion = health.clock, health.motion
    stamps = "perfectly even, or none in the file"
    if clock.stamped:
        stamps = f"jitter {clock.jitter * 1e3:.3g} ms" if clock.jitter else "perfectly even"
        stamps += ", in bursts" if clock.bursts else ""
    gaps = "none"
    if clock.gap_count:
        gaps = f"{clock.gap_count} ({clock.missing:,} samples missing)"
    rest = motion.state
    if motion.state not in ("at rest", "touched", "moved"):
        rest = f"{motion.state}, {100 * motion.moving_share:.3g} % of the seconds"
    facts = [
        ("record", health.source),
        ("samples", f"{clock.samples:,}"),
        ("rate", f"{clock.rate:.6g} Hz"),
        ("duration", _duration(clock.duration)),
        ("time stamps", stamps),
        ("gaps", gaps),
        ("repeated stamps", f"{clock.repeats:,}"),
        ("motion", rest),
    ]
    if motion.gravity is not None:
        force = f"{motion.gravity:.4g} m/s^2, {motion.gravity / units.G:.4g} g"
        facts.append(("specific force", force))
    if health.temperature:
        t = health.temperature
        facts.append(("temperature", f"{t['low']:.4g} to {t['high']:.4g} degC"))
    return facts + (_fixes(health.gnss) if health.gnss else [])


def _fixes(gnss):
    with_velocity = ", with velocity" if gnss["velocity"] else ""
    span = f"{gnss['from']:.4g} to {gnss['to']:.4g} s"
    facts = [
        ("fixes", f"{gnss['fixes']:,} at {gnss['rate']:.4g} Hz, {span}{with_velocity}"),
        ("reference", "yes" if gnss["reference"] else "none"),
    ]
    if "fix_codes" in gnss:
        codes = ", ".join(f"{c}: {n:,}" for c, n in gnss["fix_codes"].items())
        facts.append(("fix codes", codes))
    return facts


CHANNEL_COLUMNS = (
    "channel",
    "unit",
    "mean",
    "sd",
    "step",
    "short-time noise",
    "NaN",
    "clipped",
    "frozen",
)


def _row(name, channel):
    """One channel's line of the table, in deg/s or g."""
    from imu_lib import units

    is_gyro = name.startswith("gyro")
    factor = units.DEG_PER_S if is_gyro else units.G
    noise, unit = units.datasheet("N", name)
    return (
        name,
        "deg/s" if is_gyro else "g",
        f"{channel.mean / factor:.4g}",
        f"{channel.sd / factor:.3g}",
        "-" if channel.resolution is None else f"{channel.resolution / factor:.3g}",
        f"{channel.noise / noise:.3g} {unit}",
        channel.nan,
        channel.saturated,
        channel.frozen,
    )


def _duration(seconds: float) -> str:
    from imu_lib import units

    return f"{seconds:.6g} s" + (f" ({units.duration(seconds)})" if seconds >= 120 else "")
