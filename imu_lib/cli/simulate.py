"""`imu-lib simulate MODEL --hours H --rate HZ --seed S --out FILE`: a record drawn from an error
model.
"""

from __future__ import annotations

from pathlib import Path

from imu_lib.cli import common
from imu_lib.errors import InputError

NAME = "simulate"
HELP = (
    "A record drawn from an error model (a file or preset:NAME), written as .npz, .csv, .tsv "
    "or .parquet."
)
FORMATS = (".npz", ".csv", ".tsv", ".txt", ".parquet")
#: Samples: a hundred days at 200 Hz.
MOST = 2_000_000_000
#: Values that are drawn at once where something acts on all channels together.
IN_MEMORY = 1_000_000_000


def add_arguments(parser):
    parser.add_argument("model", metavar="MODEL", help="an error-model file (.json) or preset:NAME")
    parser.add_argument(
        "--hours", type=common.positive, required=True, metavar="H", help="length of the record"
    )
    parser.add_argument(
        "--rate",
        type=common.positive,
        metavar="HZ",
        help="samples per second; the model's own where it states one",
    )
    parser.add_argument(
        "--seed", type=int, required=True, metavar="S", help="the same seed draws the same record"
    )
    parser.add_argument(
        "--temperature",
        metavar="FILE",
        help="a record with time and temperature, or a table of time (s) and temperature (degC)",
    )
    parser.add_argument(
        "--out", required=True, metavar="FILE", help="where to write: " + ", ".join(FORMATS)
    )
    common.add_json_argument(parser)


def run(args):
    import numpy as np

    from imu_lib import drawing
    from imu_lib.model import Model
    from imu_lib.model.reach import out_of_reach
    from imu_lib.stream import LONG
    from imu_lib.writers import write_record

    common.check_writable(args.out)
    common.check_writable(args.json)
    if Path(args.out).suffix.lower() not in FORMATS:
        raise InputError(
            f"--out {args.out}: the format is told by the name, which must end in "
            f"{', '.join(FORMATS)}."
        )
    if args.seed < 0:
        raise InputError(f"--seed {args.seed} must be 0 or above.")
    model = Model.load(args.model)
    rate = args.rate or model.rate
    if not rate:
        raise InputError(f"{args.model} states no rate; give --rate HZ.")
    n = round(args.hours * 3600 * rate)
    if n < 2:
        raise InputError(
            f"--hours {args.hours:g} at {rate:g} Hz are {n} samples; at least two are needed."
        )
    _check_room(args, n, rate, model)
    temperature = None
    if args.temperature:
        temperature = _temperature(args.temperature, np.arange(n) / rate)
    elif any(p.name == "temperature" for c in model.channel_names for p in model[c].terms):
        raise InputError(f"{args.model} has a temperature term; give --temperature FILE.")
    name = model.name or Path(args.model).stem
    generator = np.random.default_rng(args.seed)
    with common.atomic_path(args.out) as part:
        if n > LONG and drawing.by_pieces(model):
            size, duration, sd = _by_pieces(model, n, rate, generator, temperature, part)
        else:
            record = model.simulate_record(n, rate, generator, temperature=temperature, name=name)
            write_record(record, part)
            size, duration = record.n, record.duration
            sd = {c: float(x.std()) for c, x in record.channels.items()}
    summary = {
        "model": args.model,
        "seed": args.seed,
        "rate": rate,
        "samples": size,
        "duration": duration,
        "channels": list(sd),
        "out": args.out,
        "sd": sd,
        "notes": out_of_reach(model, rate, n / rate),
    }
    common.write_json(summary, args.json)
    if args.json != "-":
        print(f"{args.out}: {size:,} samples at {rate:g} Hz ({duration:.6g} s) of {', '.join(sd)}")
        for note in summary["notes"]:
            print(f"  - {note}")


def _check_room(args, n, rate, model):
    """InputError where the record does not fit on the disk."""
    import shutil

    values = n * (len(model.channel_names) + 1)
    free = shutil.disk_usage(Path(args.out).resolve().parent).free
    width = 8 if Path(args.out).suffix.lower() in (".npz", ".parquet") else 20
    # the file itself, each channel's scratch file, and the terms of one channel
    need = values * (width + 8) + 8 * 7 * n
    from imu_lib.drawing import by_pieces

    in_memory = n * len(model.channel_names) if not by_pieces(model) else 0
    if n > MOST or need > free or in_memory > IN_MEMORY:
        raise InputError(
            f"--hours {args.hours:g} at {rate:g} Hz are {n:,} samples of "
            f"{len(model.channel_names)} channels, more than memory and disk take "
            f"({need / 1e9:.3g} GB; {free / 1e9:.3g} GB are free beside {args.out}); draw shorter "
            "records."
        )


def _by_pieces(model, n, rate, generator, temperature, part):
    """Draw and write a long record: samples, duration in s, standard deviations by channel."""
    from imu_lib import drawing
    from imu_lib.stream import CHUNK
    from imu_lib.writers import write_pieces

    bar = common.progress(about="drawing channels", total=len(model.channel_names))
    options = {"temperature": temperature, "folder": part.resolve().parent}
    drawn = drawing.draw(
        model, n, rate, generator, progress=lambda channel: bar.update(1), **options
    )
    bar.close()
    sums, last = {}, [0.0]

    def told():
        for piece in drawn.pieces(2 * CHUNK):
            for name in drawn.channels if len(piece["time"]) else ():
                x = piece[name]
                first, total, squares = sums.setdefault(name, (float(x[0]), 0.0, 0.0))
                sums[name] = (
                    first,
                    total + float((x - first).sum()),
                    squares + float(((x - first) ** 2).sum()),
                )
            last[0] = float(piece["time"][-1]) if len(piece["time"]) else last[0]
            yield piece

    write_pieces(part, told(), drawn.n, simulated=True)
    sd = {
        name: max(squares / drawn.n - (total / drawn.n) ** 2, 0.0) ** 0.5
        for name, (_, total, squares) in sums.items()
    }
    return drawn.n, last[0] + 1 / rate if drawn.time is not None else drawn.n / rate, sd


def _temperature(path, time):
    """Temperature at `time` from a record or a table; InputError where it does not cover it."""
    import numpy as np

    from imu_lib import readers

    try:
        t, temperature = readers.read_temperature(path)
    except readers.NoTemperature:
        raise InputError(
            f"{path} has no temperature; a column or array called temperature (degC) with time "
            "(s) is expected."
        ) from None
    if t[-1] < time[-1] - 1.5 * (time[1] - time[0]):
        raise InputError(
            f"{path} ends at {t[-1]:.6g} s, before the record's {time[-1]:.6g} s; give a longer "
            "temperature record or fewer --hours."
        )
    return np.interp(time, t, temperature)
