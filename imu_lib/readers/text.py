"""Text tables: .csv, .tsv, .txt of any delimiter, with or without header, comments, date and clock
columns, decimal commas, words between the numbers.

The numbers are parsed by Arrow (or pandas where fields are set apart by runs of blanks); when that
fails the file is walked line by line, to say which line and column is at fault.
"""

from __future__ import annotations

import io
import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers import calendar, fields, formats, headerless, names, scales_above
from imu_lib.readers import layout as lay
from imu_lib.readers.columns import Heading, decide
from imu_lib.readers.header import legend
from imu_lib.readers.meaning import WORD
from imu_lib.readers.raw import Raw
from imu_lib.readers.source_text import Lines
from imu_lib.readers.spelling import unwrapped

NULLS = ["", "NaN", "nan", "NAN", "NA", "N/A", "null", *fields.NULLS]


THREADED = 1 << 24  # bytes from which Arrow's threads are worth their start


def read_text(path, *, columns=None, signal: str | None = None, data: bytes | None = None) -> Raw:
    """The columns of a text table.

    Parameters
    ----------
    path : path-like
        The file, named in messages.
    columns : str, optional
        Names by position.
    signal : {"gyro", "accel", "temperature"}, optional
        What bare x, y, z are.
    data : bytes, optional
        The content, where it was unpacked already.

    Raises
    ------
    InputError
        Naming file, line, column and remedy.
    """
    path = Path(path)
    if data is None:
        with open(path, "rb") as file:
            data = file.read()
    lines = Lines.of(data, str(path))
    lines.unfold()
    head, whole = lines.head()
    layout = lay.sniff(head, str(path), whole=whole)
    if lines.trim(layout):
        layout = lay.sniff(*lines.head()[:1], str(path), whole=lines.head()[1])
    raw = Raw(
        str(path),
        rate=lines.rate or layout.rate,
        line=lambda row: f"line {_line_of(lines, layout, row)}",
    )
    raw.notes += lines.notes
    layout = headerless.with_names(_labels_as_header(lines, layout))
    units = layout.units or ("",) * len(layout.kinds)
    headings = [
        Heading(
            layout.header[i] if layout.header else f"column {i + 1}",
            k,
            unwrapped(units[i]).strip("- ") or None,
        )
        for i, k in enumerate(layout.kinds)
    ]

    raw.legend = legend(head.decode("latin-1").splitlines()[: layout.first])

    def load(wanted):
        values = _parse(path, lines, layout, wanted)
        raw.notes += tuple(n for n in lines.notes if n not in raw.notes)
        return values

    decide(raw, headings, load, columns=columns, signal=signal, named=layout.header is not None)
    _by_the_lines_above(raw, layout)
    scales_above.take(raw, head.decode("latin-1").splitlines()[: layout.first])
    if lines.places is None and layout.header:
        formats.fix(raw, layout.header, head.decode("latin-1").splitlines()[: layout.first])
    return raw


def _by_the_lines_above(raw: Raw, layout) -> None:
    """Units and a rate that a line above the table states, where its columns state none."""
    timed = {"time", "date", "clock"} & set(raw.columns)
    if layout.rate_said and raw.rate is None and not timed:
        raw.rate = layout.rate_said
        raw.notes += (f"A line above the table states {raw.rate:g} Hz.",)
    for kind, unit in layout.said.items():
        headed = {raw.units[c] for c in raw.axes(kind)} - {None}
        if raw.state(kind, unit, "by a line above the table"):
            raw.notes += (f"A line above the table states {unit} for the {kind}.",)
        elif headed and headed != {unit}:
            raw.notes += (
                f"A line above the table states {unit} for the {WORD[kind]}, its heading "
                f"{' and '.join(sorted(headed))}: the heading was taken; --{kind}-unit says "
                "otherwise.",
            )


def _labels_as_header(lines, layout):
    """A layout whose names are those that stand before the numbers in every row: `Gyro 1 2 3
    Acc 4 5 6`.
    """
    texts = [i for i, k in enumerate(layout.kinds) if k == "text"]
    if layout.header is not None or not texts or texts[0] != 0:
        return layout
    rows = [row for _, row in itertools.islice(_rows(lines, layout), 200)]
    if any(len({r[i] for r in rows if len(r) > i}) != 1 for i in texts):
        return layout
    names_ = list(rows[0])
    for at, stop in itertools.pairwise([*texts, len(names_)]):
        size = stop - at - 1
        axes = "xyz" if size == 3 else [""] if size == 1 else [f"#{i + 1}" for i in range(size)]
        names_[at + 1 : stop] = [f"{rows[0][at].strip(':= ')} {a}".strip() for a in axes]
        names_[at] = ""
    return replace(layout, header=tuple(names_))


def _parse(path, lines, layout, wanted) -> dict[int, np.ndarray]:
    """Column number -> values: numbers as int64 or float64, dates and clocks as str."""
    texts = [i for i in wanted if layout.kinds[i] in (*fields.STAMPS, "text")]
    numeric = [i for i in wanted if i not in texts]
    table = None
    if layout.delimiter is not None and layout.encoding == "utf-8-sig" and layout.comment is None:
        table = _arrow(lines, layout, numeric, texts)
    if table is None:
        table = _pandas(lines, layout, numeric, texts)
    if table is None and (lines.without_thousands() or lines.without_words(layout)):
        return _parse(path, lines, layout, wanted)
    if table is None:
        _explain(path, lines, layout, wanted)
        raise InputError(
            f"{path} cannot be read as a table of numbers from line {layout.first + 1} on; look "
            "for a damaged line."
        )
    for i in texts:
        if layout.kinds[i] == "moment" and len(table[i]) and calendar.usual(str(table[i][0])):
            table[i] = np.array([calendar.usual(str(x)) or x for x in table[i]], dtype=object)
    rows = len(next(iter(table.values())))
    if rows < 2:
        raise InputError(f"{path} has only {rows} row of data; at least two are needed.")
    last = table[max(numeric)] if numeric else None
    if last is not None and last.dtype.kind == "f" and np.isnan(last).any():
        _explain(
            path, lines, layout, wanted
        )  # a short line reads as NaN at its end; an empty field is a missing sample
    return table


def _arrow(lines, layout, numeric, texts):
    import pyarrow as pa
    from pyarrow import csv

    width = [f"c{i}" for i in range(len(layout.kinds))]
    whole = {f"c{i}": pa.string() for i in texts}
    try:
        table = csv.read_csv(
            pa.BufferReader(lines.data),
            read_options=csv.ReadOptions(
                skip_rows=layout.first,
                column_names=width,
                block_size=1 << 22,
                use_threads=len(lines.data) > THREADED,
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


def _pandas(lines, layout, numeric, texts):
    import pandas as pd

    width = len(layout.kinds)
    try:
        frame = pd.read_csv(
            io.BytesIO(lines.data),
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
    stamps = [i for i in texts if layout.kinds[i] != "text"]
    if stamps and frame[stamps].isna().any().any():
        return None
    out.update({i: frame[i].to_numpy(dtype=object) for i in texts})
    return out


def _rows(lines, layout):
    """(line number from 1, fields) of each data row."""
    file = io.TextIOWrapper(io.BytesIO(lines.data), encoding=layout.encoding, errors="replace")
    row = 0
    for number, line in enumerate(itertools.islice(file, layout.first, None), layout.first + 1):
        if line.strip() and not line.lstrip().startswith(fields.COMMENTS):
            if lines.places is not None:
                number = lines.places[min(row, len(lines.places) - 1)]
            row += 1
            yield (
                number,
                layout.split(line.split(layout.comment)[0] if layout.comment else line),
            )


def _explain(path, lines, layout, wanted):
    """InputError that names the first line with a wrong number of columns or with text where a
    number belongs.
    """
    width = len(layout.kinds)
    for number, row in _rows(lines, layout):
        worded = [f for f in row if f[:1].isalpha()] if layout.header else []
        if len(worded) > 1 and sum(names.meaning(f).quantity is not None for f in worded) > 1:
            raise InputError(
                f"{path}, line {number}: another header stands there, with other columns than the "
                f"first ({', '.join(row)[:60]}); cut the file in two before that line."
            )
        if len(row) != width and not (len(row) == width + 1 and row[-1] == ""):
            raise InputError(
                f"{path}, line {number}: {len(row)} columns where line {layout.first + 1} has "
                f"{width}; the file is cut off or damaged there: complete or remove the line."
            )
        for i in wanted:
            want, got = layout.kinds[i], fields.kind(row[i], layout.decimal)
            if want == "text":
                continue
            if got not in (want, "empty") and not (want == "empty" and got == "number"):
                heading = f" ({layout.header[i]})" if layout.header else ""
                if fields.MONTH.match(row[i]):
                    raise InputError(
                        f"{path}, line {number}, column {i + 1}{heading}: {row[i][:30]!r} is a "
                        "date that a spreadsheet made of a number (Sep 81 of 9.81); take the file "
                        "that it was made from."
                    )
                raise InputError(
                    f"{path}, line {number}, column {i + 1}{heading}: {row[i][:30]!r} is not a "
                    f"{want if want != 'empty' else 'number'}; "
                    "correct the line or leave the field empty for a missing sample."
                )


def _line_of(lines, layout, row: int) -> int:
    """Line number, from 1, of data row `row`, from 0."""
    return next(itertools.islice(_rows(lines, layout), row, None), (row + layout.first + 1,))[0]
