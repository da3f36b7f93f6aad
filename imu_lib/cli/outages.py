"""`imu-lib outages DRIVE`: error models compared under GPS outages of a drive."""

from __future__ import annotations

import sys

from imu_lib.cli import common, drives, outages_models, outages_report
from imu_lib.errors import InputError

NAME = "outages"
#: Names of the files in --out DIR.
WRITES = ("result.json", "*.png")
WITHOUT = "--no-velocity leaves the velocities out."
HELP = (
    "GPS outages of a drive: GNSS is withheld over windows and the horizontal error of each error "
    "model is followed. Models: 15AV, 18AV, 18AVWD, 15AR, 27AR of the 2013 paper, made from "
    "--model, from --static, or from the paper's own tables, the bias left at switch-on in a state "
    "of its own where none of theirs keeps it; each with additions, as in 18AV+scale+road: scale, "
    "misalignment, g, time, lever, clock, mounting (estimated along), road, speed, robust."
)


def add_arguments(parser):
    parser.add_argument(
        "drive",
        metavar="DRIVE",
        help="the drive: .npz with IMU and GNSS, or an IMU file with --gnss",
    )
    parser.add_argument(
        "--gnss", metavar="FILE", help="the GNSS solution of the drive (RTKLIB .pos or NMEA)"
    )
    _model_arguments(parser.add_argument_group("the error models"))
    _window_arguments(parser.add_argument_group("the outages"))
    _known_arguments(parser.add_argument_group("what is known of the drive"))
    group = parser.add_argument_group("what is in the IMU's file")
    common.add_reading_arguments(group)
    group.add_argument(
        "--gnss-offset",
        type=common.number,
        metavar="S",
        help="the IMU's time of the first fix, where the clocks are not the same",
    )
    for flag, what in (("--start", "what comes before"), ("--stop", "what comes from here on")):
        group.add_argument(
            flag,
            type=common.from_zero,
            metavar="S",
            help=f"leave out {what}, s from the first sample",
        )
    common.add_json_argument(parser)
    parser.add_argument("--out", metavar="DIR", help="write result.json and figures here")


def _model_arguments(group):
    group.add_argument(
        "--static",
        metavar="FILE",
        help="the same sensor at rest: the models are made from it, and the likelihood's own is "
        "added",
    )
    group.add_argument(
        "--model",
        metavar="MODEL",
        help="an error-model file or preset:NAME: the models are made from it, and it is added "
        "itself; its key `drive` is held by all",
    )
    group.add_argument(
        "--models",
        metavar="NAMES",
        default="15AV,18AV,18AVWD,15AR,27AR",
        help="which of the five, and with which additions (15AV,18AV+scale,...)",
    )
    group.add_argument(
        "--causal",
        action="store_true",
        help="18AVWD de-noises without the future (default: whole record, as the paper)",
    )
    group.add_argument(
        "--gyro-bias",
        type=common.positive,
        metavar="DEG/S",
        help=f"gyro bias left at switch-on, sd (default {outages_models.TURN_ON[0]:g}, or the "
        "model's turn_on)",
    )
    group.add_argument(
        "--accel-bias",
        type=common.positive,
        metavar="MG",
        help=f"accelerometer bias left at switch-on, sd (default {outages_models.TURN_ON[1]:g}, "
        "or the model's turn_on)",
    )


def _window_arguments(group):
    group.add_argument("--windows", metavar="START:DURATION,...", help="the outages, s")
    group.add_argument(
        "--duration",
        type=common.positive,
        metavar="S",
        help="length of regular outages, s (default 30)",
    )
    group.add_argument(
        "--every",
        type=common.positive,
        metavar="S",
        help="one outage each this many s (default: the duration)",
    )


def _known_arguments(group):
    group.add_argument("--no-velocity", action="store_true", help="use GNSS positions alone")
    group.add_argument(
        "--accept", metavar="CODES", help="GNSS fix codes to use, as in 1,4 (default: all)"
    )
    group.add_argument(
        "--heading",
        type=common.number,
        metavar="DEG",
        help="heading at the start, where it is known",
    )
    group.add_argument(
        "--latency",
        type=common.number,
        metavar="S",
        help="how late the fixes are stamped: one stamped t was taken at t - S",
    )
    group.add_argument(
        "--velocity-latency",
        type=common.number,
        metavar="S",
        help="the same of the velocities, where it is another",
    )
    group.add_argument(
        "--lever-arm",
        metavar="X,Y,Z",
        help="from the IMU to the antenna, m forward, right, down (write --lever-arm=-1,0,2 where "
        "it begins with a minus)",
    )
    group.add_argument(
        "--road",
        action="store_true",
        help="the vehicle does not move across its axis (as +road for every model)",
    )
    group.add_argument(
        "--road-sd",
        type=common.positive,
        metavar="M/S",
        help="how far that is believed (default 0.3; implies --road)",
    )
    group.add_argument(
        "--speed",
        action="store_true",
        help="use the wheel speed of the drive's file, in outages too (as +speed)",
    )
    group.add_argument(
        "--scale", action="store_true", help="estimate scale factors (as +scale for every model)"
    )
    group.add_argument(
        "--as-stated",
        action="store_true",
        help="believe the fixes' standard deviations as they are stated, and do not look for a "
        "time error",
    )


def run(args):
    from imu_lib.navigation import outages, variants

    if args.windows and (args.duration or args.every):
        raise InputError("Give --windows, or --duration and --every, not both.")
    if args.start is not None and args.stop is not None and args.stop <= args.start:
        raise InputError(f"--stop {args.stop:g} is not after --start {args.start:g}.")
    if args.no_velocity:
        common.refuse_without_effect(
            args, ("velocity_latency",), "--no-velocity leaves these out; leave one of the two out."
        )
    common.check_writable(args.json)
    common.check_out(args.out)
    names = tuple(n.strip() for n in args.models.split(",") if n.strip())
    if not names:
        raise InputError("--models names none; the models are 15AV, 18AV, 18AVWD, 15AR and 27AR.")
    for name in names:
        variants.split(name)
    windows = outages.windows_from(args.windows) if args.windows else None
    arm = outages_models.arm(args.lever_arm)
    drive = drives.opened(args.drive, args)
    _refuse_late(args, drive)
    if windows is not None:
        windows = outages.measured(drive, windows)  # what cannot be is said before the work
    else:
        duration = args.duration or 30.0
        windows = outages.regular_windows(drive, duration=duration, every=args.every or duration)
    models = outages_models.models(args, names, drive, arm)
    heading = None if args.heading is None else args.heading * 3.141592653589793 / 180.0
    said = _frames(drive, models, velocity=not args.no_velocity)
    gnss, notes = _fixes(args, drive, models, heading)
    notes = (*said, *notes)
    study = outages.compare(
        drive,
        models,
        windows,
        gnss=gnss,
        heading=heading,
        strict=bool(args.windows),
        progress=lambda models: common.progress(models, about="models"),
        notes=notes,
    )
    if args.out:
        with common.atomic_folder(args.out) as folder:
            _write(study, drive, folder)
    common.write_json(study, args.json)
    if args.json != "-":
        print(outages_report.text(study, drive))


def _refuse_late(args, drive):
    """InputError where a lateness that the call gives leaves no fix beside the IMU."""
    for flag, late in (("--latency", args.latency), ("--velocity-latency", args.velocity_latency)):
        if late is not None and abs(late) > drive.time[-1]:
            raise InputError(
                f"{flag} {late:g} moves the fixes out of the drive, which lasts "
                f"{drive.time[-1]:.1f} s; give seconds, and --gnss-offset where the clocks differ."
            )


def _frames(drive, models, velocity):
    """What is to be said of axes and signs, beyond what the models hold of them; InputError where
    no filter can use the fixes as they are. velocity : of the fixes, whether it is used.
    """
    import numpy as np
    from scipy.spatial.transform import Rotation

    from imu_lib.health.driven import frames
    from imu_lib.navigation import fix_frames, unfit

    if not velocity:
        drive = drive.without_velocity()
    if unit := fix_frames.other_unit(drive):
        raise InputError(f"{drive.called}: {unit} {WITHOUT}")
    try:
        unfit.refuse(drive)
    except InputError as error:
        told = fix_frames.wrong_velocities(drive)
        raise InputError(
            f"{error} {WITHOUT}" if told and told in str(error) else str(error)
        ) from None
    held = next(iter(models.values())).held
    held_drive = held.drive(drive)
    offset = held.value("gnss_time_offset", "offset", 0.0)
    held_drive = held_drive.with_(gnss_time=np.asarray(drive.gnss_time) - offset)
    if held.mounting is not None:
        turn = Rotation.from_euler("ZYX", held.mounting[::-1])
        held_drive = held_drive.with_(
            gyro=turn.apply(np.array(held_drive.gyro)), accel=turn.apply(np.array(held_drive.accel))
        )
    return frames(held_drive)[0]


def _codes(text):
    if text is None:
        return None
    try:
        return tuple(float(c) for c in text.split(","))
    except ValueError:
        raise InputError(f"--accept: {text!r} is not a list of fix codes, as in 1,4.") from None


def _fixes(args, drive, models, heading):
    """How fixes are taken, and what is to be said of them: their standard deviations as large as
    the innovations of the first model ask, and an error of their time.
    """
    from imu_lib.navigation import preparation, time_error

    gnss = preparation.Gnss(velocity=not args.no_velocity, accept=_codes(args.accept))
    if gnss.accept and drive.gnss_fix is None:
        print(f"note: --accept has no effect: {drive.called} has no gnss_fix.", file=sys.stderr)
    if args.as_stated:
        return gnss, ()
    model = next((m for n, m in models.items() if n.startswith("18AV") and m.levels is None), None)
    model = (model or next(iter(models.values()))).with_(
        free={}, constraint_sd=0.0, speed=None, levels=None
    )
    print("weighing the fixes ...", file=sys.stderr)
    found = time_error.time_error(drive, model, gnss=gnss, heading=heading)
    return found.gnss, found.notes()


def _write(study, drive, folder):
    from imu_lib import plots, report

    common.write_json(study, folder / "result.json")
    for name, draw in (
        ("map", lambda: plots.outage_map(study, drive)),
        ("growth", lambda: plots.outage_growth(study, 0)),
        ("fan", lambda: plots.outage_fan(study)),
        ("errors", lambda: plots.outage_errors(study)),
    ):
        (folder / f"{name}.png").write_bytes(report.png(draw()))
