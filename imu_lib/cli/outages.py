"""`imu-lib outages DRIVE`: error models compared under GPS outages of a drive."""

from __future__ import annotations

import sys

from imu_lib.cli import common
from imu_lib.errors import InputError

NAME = "outages"
HELP = (
    "GPS outages of a drive: GNSS is withheld over windows and the horizontal error of each error model is followed. "
    "Models: 15AV, 18AV, 18AVWD, 15AR, 27AR of the 2013 paper, made from --model, from --static, or from the paper's own tables."
)
#: Bias left at switch-on where nobody says: 0.2 deg/s and 20 mg.
TURN_ON = (0.2, 20.0)
#: Least standard deviation believed of a received velocity, m/s: receivers' velocities lag by up
#: to a tenth of a second.
VELOCITY_FLOOR = 0.15


def add_arguments(parser):
    parser.add_argument(
        "drive",
        metavar="DRIVE",
        help="the drive: .npz with IMU and GNSS, or an IMU file with --gnss",
    )
    parser.add_argument(
        "--gnss", metavar="FILE", help="the GNSS solution of the drive (RTKLIB .pos or NMEA)"
    )
    parser.add_argument(
        "--static",
        metavar="FILE",
        help="the same sensor at rest: the models are made from it, and the likelihood's own is added",
    )
    parser.add_argument(
        "--model",
        metavar="MODEL",
        help="an error-model file or preset:NAME: the models are made from it, and it is added itself",
    )
    parser.add_argument(
        "--models",
        metavar="NAMES",
        default="15AV,18AV,18AVWD,15AR,27AR",
        help="which of the five (15AV,18AV,...)",
    )
    parser.add_argument("--windows", metavar="START:DURATION,...", help="the outages, s")
    parser.add_argument(
        "--duration",
        type=common.positive,
        metavar="S",
        help="length of regular outages, s (default 30)",
    )
    parser.add_argument(
        "--every",
        type=common.positive,
        metavar="S",
        help="one outage each this many s (default: the duration)",
    )
    parser.add_argument(
        "--causal",
        action="store_true",
        help="18AVWD de-noises without the future (default: whole record, as the paper)",
    )
    parser.add_argument("--no-velocity", action="store_true", help="use GNSS positions alone")
    parser.add_argument(
        "--accept", metavar="CODES", help="GNSS fix codes to use, as in 1,4 (default: all)"
    )
    parser.add_argument(
        "--heading",
        type=common.number,
        metavar="DEG",
        help="heading at the start, where it is known",
    )
    parser.add_argument(
        "--gyro-bias",
        type=common.positive,
        metavar="DEG/S",
        help=f"gyro bias left at switch-on, sd (default {TURN_ON[0]:g})",
    )
    parser.add_argument(
        "--accel-bias",
        type=common.positive,
        metavar="MG",
        help=f"accelerometer bias left at switch-on, sd (default {TURN_ON[1]:g})",
    )
    common.add_json_argument(parser)
    parser.add_argument("--out", metavar="DIR", help="write result.json and figures here")


def run(args):
    from imu_lib.navigation import outages, preparation
    from imu_lib.readers import read_drive

    if args.windows and (args.duration or args.every):
        raise InputError("Give --windows, or --duration and --every, not both.")
    common.check_writable(args.json)
    common.check_out(args.out)
    names = tuple(n.strip() for n in args.models.split(",") if n.strip())
    if not names:
        raise InputError("--models names none; the models are 15AV, 18AV, 18AVWD, 15AR and 27AR.")
    windows = outages.windows_from(args.windows) if args.windows else None
    drive = read_drive(args.drive, gnss=args.gnss) if args.gnss else read_drive(args.drive)
    for note in drive.notes:
        print(f"note: {note}", file=sys.stderr)
    if windows is None:
        duration = args.duration or 30.0
        windows = outages.regular_windows(drive, duration=duration, every=args.every or duration)
    models = _models(args, names, drive.rate)
    gnss = preparation.Gnss(
        velocity=not args.no_velocity, accept=_codes(args.accept), velocity_floor=VELOCITY_FLOOR
    )
    heading = None if args.heading is None else args.heading * 3.141592653589793 / 180.0
    study = outages.compare(
        drive,
        models,
        windows,
        gnss=gnss,
        heading=heading,
        strict=bool(args.windows),
        progress=sys.stderr.isatty(),
    )
    if args.out:
        with common.atomic_folder(args.out) as folder:
            _write(study, drive, folder)
    common.write_json(study, args.json)
    if args.json != "-":
        _print(study, drive)


def _codes(text):
    if text is None:
        return None
    try:
        return tuple(float(c) for c in text.split(","))
    except ValueError:
        raise InputError(f"--accept: {text!r} is not a list of fix codes, as in 1,4.") from None


def _models(args, names, rate):
    """The filter models by name: the five asked for, and what --static or --model adds."""
    from imu_lib.model import Model
    from imu_lib.navigation import models
    from imu_lib.navigation.filter import FilterModel
    from imu_lib.units import DEG, MILLI_G

    gyro = TURN_ON[0] if args.gyro_bias is None else args.gyro_bias
    accel = TURN_ON[1] if args.accel_bias is None else args.accel_bias
    options = {"turn_on_sd": (gyro * DEG, accel * MILLI_G)}
    base, static, more = None, None, {}
    if args.model:
        base = Model.load(args.model)
        more[base.name or "given"] = FilterModel(
            base.name or "given", base, flicker="markov", **options
        )
    if args.static:
        from imu_lib.characterise import characterise
        from imu_lib.readers import read_record

        static = read_record(args.static)
        print("characterising the static record ...", file=sys.stderr)
        try:
            found = characterise(static).model
        except ValueError as error:
            raise InputError(f"{args.static} can't be characterised: {error}") from None
        more["likelihood"] = FilterModel("likelihood", found, flicker="markov", **options)
        base = base or models.read_off(static, rate)
    if base is None:
        print(
            "note: no --static and no --model: the models are those of the 2013 paper's 3DM-GX3-25, not of this sensor.",
            file=sys.stderr,
        )
    made = models.five(base, static=static, rate=rate, names=names, causal=args.causal, **options)
    return {**made, **{name: m for name, m in more.items() if name not in made}}


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


def _print(study, drive):
    against = "reference" if "reference" in study.against else "full_gnss"
    truth = "the drive's reference" if against == "reference" else "the full-GNSS solution"
    print(
        f"{drive.name or 'drive'}: {len(study.windows)} outages; maximum horizontal error in m against {truth}\n"
    )
    few = len(study.windows) <= 12
    header = ["outage", "start s", "for s", "km/h", *study.models]
    errors = {name: study.errors(name, against=against) for name in study.models}
    if few:
        rows = [
            [
                str(i + 1),
                f"{w.start:.0f}",
                f"{w.duration:.0f}",
                f"{3.6 * w.mean_speed:.1f}",
                *(f"{errors[m][i]:.4g}" for m in errors),
            ]
            for i, w in enumerate(study.windows)
        ]
        print(common.table(rows, header), end="\n\n")
    import numpy as np

    rows = [
        [
            name,
            str(m.states),
            f"{np.median(errors[name]):.4g}",
            f"{np.mean(errors[name]):.4g}",
            f"{np.max(errors[name]):.4g}",
            f"{np.median([s[-1] for s in m.sigma]):.4g}",
        ]
        for name, m in study.models.items()
    ]
    print(
        common.table(rows, ["model", "states", "median", "mean", "worst", "predicted sigma"]),
        end="\n\n",
    )
    if len(study.windows) > 1 and len(study.models) > 1:
        rows = [
            [
                f"{p.better} against {p.than}",
                f"{p.ratio:.3g} [{p.low:.3g}, {p.high:.3g}]",
                f"{100 * p.wins:.0f} %",
                "yes" if p.decided else "no",
            ]
            for p in study.paired(against=against)
        ]
        print(common.table(rows, ["pair", "ratio of errors [95 %]", "wins", "decided"]))
    for note in study.notes:
        print(f"note: {note}")
