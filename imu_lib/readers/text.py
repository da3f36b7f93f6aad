"""Text tables: .csv, .tsv, .txt of any delimiter, with or without header, comments, date and clock
columns, decimal commas.

The numbers are parsed by Arrow (or pandas where fields are set apart by runs of blanks); when that
fails the file is
walked line by line, to say which line and column is at fault.
"""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers import layout as lay
from imu_lib.readers import names
from imu_lib.readers.raw import Raw, by_position

NULLS = ["", "NaN", "nan", "NAN", "NA", "N/A", "null", "NULL", "None"]


def read_text(path, *, columns=None, signal: str | None = None) -> Raw:
    """The columns of a text table. `columns` names them by position; `signal` ("gyro" or "accel")
    is what bare x, y, z are.

    Raises InputError naming file, line, column and remedy.
    """
    path = Path(path)
    layout = lay.sniff(path)
    plan = _plan(path, layout, columns, signal)
    data = _parse(path, layout, [i for i, (canonical, _, _) in enumerate(plan) if canonical])
    raw = Raw(str(path), rate=layout.rate, line=lambda row: f"line {_line_of(path, layout, row)}")
    for i, (canonical, unit, heading) in enumerate(plan):
        if canonical:
            raw.add(canonical, data[i], unit, heading)
    return raw


def _plan(path, layout, columns, signal):
    """(canonical name or None, unit, heading) of each column."""
    width = len(layout.kinds)
    if columns:
        plan = by_position(columns, width, str(path), signal)
    elif layout.header:
        plan = [(*names.parse(h, signal=signal), h) for h in layout.header]
        plan = [
            (None, None, h) if c in ("index", "gyro", "accel", "dtheta", "dv") else (c, u, h)
            for c, u, h in plan
        ]
    else:
        plan = [(None, None, f"column {i + 1}") for i in range(width)]
    for i, what in enumerate(layout.kinds):
        if (
            what in ("date", "clock", "moment")
            and plan[i][0] in (None, "time", "date", "clock")
            and not (columns and plan[i][0] is None)
        ):
            plan[i] = ({"date": "date", "clock": "clock", "moment": "date"}[what], None, plan[i][2])
    if sum(c == "date" for c, _, _ in plan) and any(c == "time" for c, _, _ in plan):
        plan = [
            (None, u, h) if c in ("date", "clock") else (c, u, h) for c, u, h in plan
        ]  # a numeric time beats the calendar
    if signal == "temperature":
        free = [i for i in range(width) if layout.kinds[i] == "number" and plan[i][0] is None]
        if not layout.header and width == 2 and len(free) == 2:
            plan = [("time", "s", "column 1"), ("temperature", None, "column 2")]
    elif not columns and not any(
        c and c.rpartition("_")[0] in ("gyro", "accel", "dtheta", "dv") for c, _, _ in plan
    ):
        free = [
            i for i in range(width) if layout.kinds[i] in ("number", "empty") and plan[i][0] is None
        ]
        if signal and not layout.header and len(free) in (3, 4):
            if len(free) == 4:
                plan[free[0]] = ("time", None, plan[free[0]][2])
            for i, axis in zip(free[-3:], "xyz"):
                plan[i] = (f"{signal}_{axis}", None, plan[i][2])
        else:
            header = (
                f"its header ({', '.join(layout.header)[:80]}) names no gyro or accelerometer"
                if layout.header
                else (
                    f"no header of {width} name{'s' * (width > 1)} right above {'them' if width > 1 else 'it'}"
                )
            )
            columns_ = f"{width} column{'s' * (width > 1)}"
            one = (
                " (--gyro FILE or --accel FILE where it holds x, y, z of one sensor)"
                if len(free) in (3, 4) and not signal
                else ""
            )
            raise InputError(
                f"{path} has {columns_} and {header}; name them by position with --columns, as in "
                f"time,gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z{one}."
            )
    return plan


def _parse(path, layout, wanted) -> dict[int, np.ndarray]:
    """Column number -> values: numbers as int64 or float64, dates and clocks as str."""
    texts = [i for i in wanted if layout.kinds[i] in ("date", "clock", "moment")]
    numeric = [i for i in wanted if i not in texts]
    table = None
    if layout.delimiter is not None and layout.encoding == "utf-8-sig" and layout.comment is None:
        table = _arrow(path, layout, numeric, texts)
    if table is None:
        table = _pandas(path, layout, numeric, texts)
    if table is None:
        _explain(path, layout, wanted)
        raise InputError(
            f"{path} cannot be read as a table of numbers from line {layout.first + 1} on; look for a damaged line."
        )
    rows = len(next(iter(table.values())))
    if rows < 2:
        raise InputError(f"{path} has only {rows} row of data; at least two are needed.")
    last = table[max(numeric)] if numeric else None
    if last is not None and last.dtype.kind == "f" and np.isnan(last).any():
        _explain(
            path, layout, wanted
        )  # a short line reads as NaN at its end; an empty field is a missing sample
    return table


def _arrow(path, layout, numeric, texts):
    import pyarrow as pa
    from pyarrow import csv

    width = [f"c{i}" for i in range(len(layout.kinds))]
    whole = {f"c{i}": pa.string() for i in texts}
    try:
        table = csv.read_csv(
            path,
            read_options=csv.ReadOptions(
                skip_rows=layout.first, column_names=width, block_size=1 << 22
            ),
            parse_options=csv.ParseOptions(delimiter=layout.delimiter),
            convert_options=csv.ConvertOptions(
                include_columns=[f"c{i}" for i in sorted(numeric + texts)],
                null_values=NULLS,
                column_types=whole,
                decimal_point=layout.decimal,
                strings_can_be_null=False,
            ),
        )
    except (pa.ArrowInvalid, pa.ArrowNotImplementedError, pa.ArrowKeyError):
        return None
    out = {}
    for i in numeric:
        column = table[f"c{i}"]
        if pa.types.is_null(column.type):
            out[i] = np.full(table.num_rows, np.nan)
        elif pa.types.is_floating(column.type) or pa.types.is_integer(column.type):
            out[i] = column.to_numpy()
        else:
            return None
    out.update({i: np.asarray(table[f"c{i}"].to_pylist(), dtype=object) for i in texts})
    return out


def _pandas(path, layout, numeric, texts):
    import pandas as pd

    width = len(layout.kinds)
    try:
        frame = pd.read_csv(
            path,
            sep=r"\s+" if layout.delimiter is None else layout.delimiter,
            header=None,
            names=range(width),
            skiprows=layout.first,
            dtype={i: str for i in texts},
            decimal=layout.decimal,
            engine="c",
            encoding=layout.encoding,
            comment=layout.comment[0] if layout.comment else None,
            na_values=NULLS,
            skip_blank_lines=True,
            skipinitialspace=True,
        )
    except (
        pd.errors.ParserError,
        pd.errors.EmptyDataError,
        ValueError,
        UnicodeError,
        OverflowError,
    ):
        return None
    out = {i: frame[i].to_numpy() for i in numeric}
    if any(x.dtype.kind not in "fiu" for x in out.values()):
        return None
    if texts and frame[texts].isna().any().any():
        return None
    out.update({i: frame[i].to_numpy(dtype=object) for i in texts})
    return out


def _rows(path, layout):
    """(line number from 1, fields) of each data row."""
    with open(path, encoding=layout.encoding, errors="replace") as file:
        for number, line in enumerate(itertools.islice(file, layout.first, None), layout.first + 1):
            if line.strip() and not line.lstrip().startswith(lay.COMMENTS):
                yield (
                    number,
                    layout.split(line.split(layout.comment)[0] if layout.comment else line),
                )


def _explain(path, layout, wanted):
    """InputError that names the first line with a wrong number of columns or with text where a
    number belongs.
    """
    width = len(layout.kinds)
    for number, fields in _rows(path, layout):
        if len(fields) != width and not (len(fields) == width + 1 and fields[-1] == ""):
            raise InputError(
                f"{path}, line {number}: {len(fields)} columns where line {layout.first + 1} has {width}; the file is cut off "
                f"or damaged there: "
                "complete or remove the line."
            )
        for i in wanted:
            want, got = layout.kinds[i], lay.kind(fields[i], layout.decimal)
            if got not in (want, "empty") and not (want == "empty" and got == "number"):
                heading = f" ({layout.header[i]})" if layout.header else ""
                raise InputError(
                    f"{path}, line {number}, column {i + 1}{heading}: {fields[i][:30]!r} is not a {want if want != 'empty' else 'number'}; "
                    "correct the line or leave the field empty for a missing sample."
                )


def _line_of(path, layout, row: int) -> int:
    """Line number, from 1, of data row `row`, from 0."""
    return next(itertools.islice(_rows(path, layout), row, None), (row + layout.first + 1,))[0]
