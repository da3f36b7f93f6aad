"""`imu-lib simulate MODEL --hours H --rate HZ --seed S --out FILE`: a record drawn from an error
model.
"""

from __future__ import annotations

from pathlib import Path

from imu_lib.cli import common
from imu_lib.errors import InputError

NAME = "simulate"
HELP = "A record drawn from an error model (a file or preset:NAME), written as .npz, .csv, .tsv or .parquet."
FORMATS = (".npz", ".csv", ".tsv", ".txt", ".parquet")
MOST = 1_000_000_000


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

    from imu_lib.model import Model
    from imu_lib.writers import write_record

    common.check_writable(args.out)
    common.check_writable(args.json)
    if Path(args.out).suffix.lower() not in FORMATS:
        raise InputError(
            f"--out {args.out}: the format is told by the name, which must end in {', '.join(FORMATS)}."
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
    if n * max(1, len(model.channel_names)) > MOST:
        raise InputError(
            f"--hours {args.hours:g} at {rate:g} Hz are {n:,} samples of {len(model.channel_names)} channels, more than memory "
            f"takes; draw shorter records."
        )
    temperature = None
    if args.temperature:
        temperature = _temperature(args.temperature, np.arange(n) / rate)
    elif any(p.name == "temperature" for c in model.channel_names for p in model[c].terms):
        raise InputError(f"{args.model} has a temperature term; give --temperature FILE.")
    record = model.simulate_record(
        n,
        rate,
        np.random.default_rng(args.seed),
        temperature=temperature,
        name=model.name or Path(args.model).stem,
    )
    with common.atomic_path(args.out) as part:
        write_record(record, part)
    summary = {
        "model": args.model,
        "seed": args.seed,
        "rate": rate,
        "samples": record.n,
        "duration": record.duration,
        "channels": list(record.channel_names),
        "out": args.out,
        "sd": {c: float(x.std()) for c, x in record.channels.items()},
    }
    common.write_json(summary, args.json)
    if args.json != "-":
        print(
            f"{args.out}: {record.n:,} samples at {rate:g} Hz ({record.duration:.6g} s) of {', '.join(record.channel_names)}"
        )


def _temperature(path, time):
    """Temperature at `time` from a record or a table; InputError where it does not cover it."""
    import numpy as np

    from imu_lib import readers

    try:
        t, temperature = readers.read_temperature(path)
    except readers.NoTemperature:
        raise InputError(
            f"{path} has no temperature; a column or array called temperature (degC) with time (s) is expected."
        ) from None
    if t[-1] < time[-1] - 1.5 * (time[1] - time[0]):
        raise InputError(
            f"{path} ends at {t[-1]:.6g} s, before the record's {time[-1]:.6g} s; give a longer temperature record or fewer --hours."
        )
    return np.interp(time, t, temperature)
