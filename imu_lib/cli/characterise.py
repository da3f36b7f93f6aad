"""`imu-lib characterise FILE`: all methods on all channels of a record at rest."""

from pathlib import Path

from imu_lib.cli import common
from imu_lib.errors import InputError

NAME = "characterise"
#: Names of the files in --out DIR.
WRITES = ("model.json", "result.json", "report.html", "*.png")
HELP = (
    "Allan variance, spectrum, autocorrelation, autoregressive model and likelihood on every "
    "channel of a record at rest: coefficients with 95 % intervals, an error model, figures, "
    "exports."
)


def add_arguments(parser):
    common.add_record_arguments(parser)
    common.add_json_argument(parser)
    parser.add_argument(
        "--out",
        metavar="DIR",
        help="write model.json, result.json, report.html and the figures there",
    )
    parser.add_argument(
        "--export",
        metavar="FORMAT",
        action="append",
        default=[],
        help="kalibr, ros or gnss-ins-sim: the model for another program, in DIR (or here); may "
        "be repeated",
    )
    parser.add_argument(
        "--workers", type=int, metavar="N", help="processes at a time; default one per core"
    )


def run(args):
    from imu_lib import export, units
    from imu_lib.stream import SUMMED

    formats = [form for entry in args.export for form in entry.split(",")]
    for form in formats:
        if form not in export.FORMATS:
            raise InputError(f"--export {form} is not known; there are {', '.join(export.FORMATS)}")
    if args.workers is not None and args.workers < 1:
        raise InputError("--workers must be at least 1")
    common.check_writable(args.json)
    out = None if args.out is None else Path(args.out)
    common.check_out(out)
    for form in formats if out is None else ():
        common.check_writable(export.FORMATS[form][0])
    record = common.open_either(args, one_rate=False, least=SUMMED)

    from imu_lib import report
    from imu_lib.characterise import characterise

    result = _characterised(record, args.workers, characterise)
    if out is not None:
        with common.atomic_folder(out) as folder:
            _write(result, folder, formats, report, export)
    else:
        for form in formats:
            name, content = export.text(result.model, form)
            with common.atomic_path(name) as temporary:
                temporary.write_text(content, encoding="utf-8")
    common.write_json(result, args.json)
    if args.json != "-":
        print(
            f"{result.name or 'record'}: {units.duration(result.duration)} at {result.rate:.6g} "
            "Hz\n"
        )
        _print(result, report, out, formats)
    return 0


def _characterised(record, workers, characterise):
    from imu_lib.characterise import plainly

    names = record.channel_names
    bar = common.progress(about="characterising channels", total=len(names))
    try:
        return characterise(record, workers=workers, progress=lambda name: bar.update(1))
    except ValueError as error:  # the record, not the call: the estimators say what it lacks
        raise InputError(
            f"{record.source or 'The record'} cannot be characterised: {plainly(error)}."
        ) from None
    finally:
        bar.close()


def _write(result, folder, formats, report, export):
    from imu_lib import plots

    result.model.save(folder / "model.json")
    common.write_json(result, folder / "result.json")
    figures = []
    for sensor in report.sensors(result):
        word = "gyro" if sensor == "gyro" else "accelerometer"
        for kind, draw, caption in (
            ("allan", plots.characterised_allan, "Allan deviation"),
            ("spectrum", plots.characterised_spectrum, "averaged spectrum"),
        ):
            image = report.png(draw(result, sensor))
            (folder / f"{kind}_{sensor}.png").write_bytes(image)
            figures.append(
                (image, f"{word}: {caption} of the record with the model that the likelihood chose")
            )
    (folder / "report.html").write_text(
        report.characterisation_page(result, figures), encoding="utf-8"
    )
    for form in formats:
        name, content = export.text(result.model, form)
        (folder / name).write_text(content, encoding="utf-8")


def _print(result, report, out, formats):
    from imu_lib import export

    for sensor in report.sensors(result):
        header, rows = report.rows_of(result, sensor)
        print(common.table(rows, header), end="\n\n")
    print("value [95 % interval]; < is the 95 % upper limit of what the record does not show")
    for note in report.notes_of(result):
        print(f"note: {note}")
    if out is not None:
        print(
            f"written to {out}: model.json, result.json, report.html, figures"
            + (", " + ", ".join(formats) if formats else "")
        )
    elif formats:
        print(f"written: {', '.join(export.FORMATS[form][0] for form in formats)}")
    else:
        print(
            "--out DIR writes the error model, figures and a report; --export kalibr a file for "
            "Kalibr"
        )
