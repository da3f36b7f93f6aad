"""`imu-lib compare A B`: two models or two records of one sensor side by side."""

from __future__ import annotations

import sys
from pathlib import Path

from imu_lib.cli import common
from imu_lib.cli.opening import READING
from imu_lib.errors import InputError

NAME = "compare"
HELP = (
    "Two error models, two records of one sensor, or a record and a model side by side: Allan "
    "deviation and coefficients."
)


def add_arguments(parser):
    parser.add_argument(
        "a", metavar="A", help="a record, an error-model file (.json) or preset:NAME"
    )
    parser.add_argument("b", metavar="B", help="the other one")
    common.add_record_arguments(parser, positional=None)
    common.add_json_argument(parser)


def run(args):
    from imu_lib.compare import compare

    common.check_writable(args.json)
    if args.gyro or args.accel:
        raise InputError("compare takes two files, A and B; --gyro and --accel do not apply to it.")
    if _is_model(args.a) and _is_model(args.b):
        keys = [k for k in (*READING, "only", "start", "stop") if k != "rate"]
        common.refuse_without_effect(args, keys, "A and B are models, not records; leave it out.")
    a, b = (_open(args, path) for path in (args.a, args.b))
    for path, opened in ((args.a, a), (args.b, b)):
        _told_moving(path, opened)
    if same := _same(a, b):
        print(
            f"note: {args.a} and {args.b} are {same}: that they agree says nothing.",
            file=sys.stderr,
        )
    try:
        result = compare(
            a,
            b,
            rate=args.rate,
            tell=lambda fits, total: common.progress(fits, about="fits", total=total),
        )
    except ValueError as error:
        raise InputError(f"{args.a} and {args.b}: {str(error).replace('`', '')}.") from None
    common.write_json(result.to_json() | {"a": args.a, "b": args.b}, args.json)
    if args.json != "-":
        print(report(result, args.a, args.b))


def _is_model(path) -> bool:
    return path.startswith("preset:") or Path(path).suffix.lower() == ".json"


def _open(args, path):
    from imu_lib.model import Model
    from imu_lib.stream import SUMMED

    if _is_model(path):
        return Model.load(path)
    args.file = path
    return common.open_either(args, least=SUMMED)


def _same(a, b):
    """In which way A and B are one thing, in words; nothing where they are two."""
    import numpy as np

    from imu_lib.model import Model
    from imu_lib.record import Record

    if isinstance(a, Model) and isinstance(b, Model):
        return "the same model" if a.to_json() == b.to_json() else ""
    if isinstance(a, Record) and isinstance(b, Record):
        common = [c for c in a.channel_names if c in b.channel_names]
        alike = [np.array_equal(a[c], b[c], equal_nan=True) for c in common]
        return "the same samples" if alike and all(alike) else ""
    one = not isinstance(a, Model) and not isinstance(b, Model) and a.source == b.source
    return "the same record" if one else ""


def _told_moving(path, opened):
    from imu_lib.faults import travelling
    from imu_lib.record import Record

    if isinstance(opened, Record) and (sentence := travelling.sentence(opened)):
        print(f"note: {path}: {sentence}", file=sys.stderr)


def report(result, a: str, b: str) -> str:
    """The comparison as text in datasheet units."""
    from imu_lib import units

    lines = [f"A  {a}", f"B  {b}"]
    if result.only:
        lines.append(f"In one of them only: {', '.join(result.only)}")
    for name, channel in result.channels.items():
        factor, unit = units.datasheet("B", name)
        rows = [
            (
                f"{t:.3g} s",
                f"{x / factor:.4g}",
                f"{y / factor:.4g}",
                f"{r:.3g}",
                f"[{lo:.3g}, {hi:.3g}]",
                "differ" if d else "",
            )
            for t, x, y, r, lo, hi, d in zip(
                channel.tau,
                channel.a.adev,
                channel.b.adev,
                channel.ratio,
                channel.low,
                channel.high,
                channel.differs,
            )
        ]
        lines += [
            "",
            name,
            common.table(rows, ("averaging time", f"A, {unit}", f"B, {unit}", "A/B", "95 %", "")),
        ]
        rows = []
        for key, pair in channel.coefficients.items():
            symbol = (
                key.rpartition(".")[2].partition("_2")[0]
                if key not in ("Q", "N", "B", "K", "R")
                else key
            )
            rows.append(
                (
                    f"{key}, {units.datasheet(symbol, name)[1]}".rstrip(", "),
                    *(_text(v, symbol, name) for v in pair),
                )
            )
        if rows:
            lines += ["", common.table(rows, ("coefficient", "A", "B"))]
    differing = [n for n, c in result.channels.items() if c.differs.any()]
    lines += [
        "",
        f"They differ beyond sampling in {', '.join(differing)}."
        if differing
        else "No difference beyond sampling.",
    ]
    return "\n".join(lines)


def _text(value, symbol, channel):
    if value is None:
        return "-"
    return (
        common.in_datasheet_unit(value, symbol, channel)
        if isinstance(value, float)
        else common.estimate_text(value, symbol, channel)
    )
