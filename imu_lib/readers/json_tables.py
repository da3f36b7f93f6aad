"""JSON that is one document (a list of samples, or a list of values under each name), or a
document a line, as Python prints its dictionaries, too.
"""

from __future__ import annotations

import ast
import json

import numpy as np

from imu_lib.readers import names
from imu_lib.readers.arrays import from_arrays
from imu_lib.readers.raw import Raw

MOST = 400_000_000  # bytes of a document


def read_json(data: bytes, source: str, columns, signal) -> Raw | None:
    """The columns of a JSON document, None where the bytes are no such document."""
    start = data[:64].lstrip(b"\xef\xbb\xbf \t\r\n")
    if not start.startswith((b"[", b"{")) or len(data) > MOST:
        return None
    try:
        found = json.loads(data.decode("utf-8-sig"))
    except (ValueError, UnicodeDecodeError, RecursionError):
        found = _lines(data)
    if found is None:
        return None
    found, rate = _split(_samples(found)), _interval(found)
    if isinstance(found, list):
        found = _with_units(_columns(found))
    arrays = {}
    for key, value in _leaves(found, ""):
        x = np.asarray(value)
        if x.dtype.kind in "fiuU" and 1 <= x.ndim <= 2 and len(x) > 1 or x.ndim == 0:
            arrays[key] = x
    if not any(x.ndim and len(x) > 1 for x in arrays.values()):
        return None
    raw = from_arrays(source, arrays, columns, signal, contract=False)
    if rate and raw.rate is None and "time" not in raw.columns:
        raw.rate = rate
        raw.notes += (f"The document states an interval that makes {rate:g} Hz.",)
    return raw


def _lines(data: bytes) -> list | None:
    """A dictionary a line, of JSON or as Python prints it; None where the lines are none."""
    try:
        lines = [x for x in data.decode("utf-8-sig").splitlines() if x.strip()]
    except UnicodeDecodeError:
        return None
    for load in (json.loads, ast.literal_eval):
        out = []
        for line in lines:
            try:
                out.append(load(line))
            except (ValueError, SyntaxError, MemoryError, RecursionError):
                if not out or len(out) < 0.9 * len(lines) - 1:
                    break  # the last line may be cut
        if len(out) >= max(2, 0.9 * len(lines) - 1) and all(isinstance(x, dict) for x in out):
            return out
    return None


def _samples(found):
    """The list of samples that a document holds under one of its keys, or the document itself."""
    while isinstance(found, dict):
        for inner in [found, *(v for v in found.values() if isinstance(v, dict))]:
            if streams := _streams(inner):
                return streams
        lists = [v for v in found.values() if isinstance(v, list) and v and isinstance(v[0], dict)]
        inner = [v for v in found.values() if isinstance(v, dict)]
        if len(lists) == 1:
            return lists[0]
        if len(found) == 1 and inner:
            found = inner[0]
            continue
        return found
    return found


def _streams(found: dict) -> list | None:
    """Samples of gyro and accelerometer in lists of their own, in the order of their stamps, each
    value under the name of its list; None where a document holds none.
    """
    lists = {k: v for k, v in found.items() if isinstance(v, list) and v and isinstance(v[0], dict)}
    kinds = {names.meaning(f"{k} x").quantity for k in lists}
    if not {"gyro", "accel"} <= kinds:
        return None
    stamps = [
        {k for k in rows[0] if names.meaning(k).quantity == "time"} for rows in lists.values()
    ]
    shared = set.intersection(*stamps)
    if len(shared) != 1:
        return None
    stamp = shared.pop()
    samples = [
        {k if k == stamp else f"{name}.{k}": v for k, v in sample.items()}
        for name, rows in lists.items()
        for sample in rows
    ]
    return sorted(samples, key=lambda sample: sample.get(stamp) or 0)


def _split(found):
    """Names and rows apart (`columns` and `data`, `sensors` and `values`), perhaps under one key,
    as columns; anything else as it is.
    """
    if not isinstance(found, dict):
        return found
    for inner in [found, *(v for v in found.values() if isinstance(v, dict))]:
        heads = next((inner[k] for k in _HEADS if isinstance(inner.get(k), list)), None)
        rows = next((inner[k] for k in _ROWS if isinstance(inner.get(k), list)), None)
        if not heads or not rows:
            continue
        if all(isinstance(r, list) and len(r) == len(heads) for r in rows):
            return [dict(zip(map(_head, heads), r)) for r in rows]
    return found


_HEADS = ("columns", "sensors", "fields", "channels", "header", "headers")
_ROWS = ("data", "values", "rows", "samples", "records")


def _head(head) -> str:
    """A name, with its unit where it is described: {"name": "accX", "units": "m/s2"}."""
    if not isinstance(head, dict):
        return str(head)
    unit = head.get("units", head.get("unit"))
    return f"{head.get('name', '')} [{unit}]" if unit else str(head.get("name", ""))


def _interval(found) -> float | None:
    """The rate, Hz, that an interval in the head of a document makes, None where there is none."""
    if not isinstance(found, dict):
        return None
    for inner in [found, *(v for v in found.values() if isinstance(v, dict))]:
        for key, factor in (("interval_ms", 1e-3), ("interval_us", 1e-6), ("interval_s", 1.0)):
            value = inner.get(key)
            if isinstance(value, int | float) and value > 0:
                return 1.0 / (value * factor)
    return None


def _columns(rows: list) -> dict:
    """Samples (dicts, perhaps nested) as columns; a sample without a value has NaN there."""
    if rows and isinstance(rows[0], list):
        return {"": rows}
    flat = [f for r in rows if isinstance(r, dict) for f in _unpacked(dict(_leaves(r, "")))]
    keys = dict.fromkeys(k for r in flat for k in r)
    out: dict = {}
    for key in keys:
        values = [r.get(key) for r in flat]
        some = next(v for v in values if v is not None)
        blank = [float("nan")] * len(some) if isinstance(some, list) else float("nan")
        if isinstance(some, str):
            out[key] = _numbers(values) or [str(v) for v in values]
        elif isinstance(some, list | int | float) and all(
            isinstance(v, type(some) if isinstance(some, list) else int | float) or v is None
            for v in values
        ):
            out[key] = [blank if v is None else v for v in values]
    return out


def _with_units(columns: dict) -> dict:
    """Columns with the unit that stands beside them under a key of its own, the same in every
    sample: {"x": 0.1, "y": 0.2, "z": 9.8, "unit": "m/s^2"}.
    """
    out = dict(columns)
    for key, values in columns.items():
        parent, _, leaf = key.rpartition(".")
        if leaf not in ("unit", "units") or len(set(map(str, values))) != 1:
            continue
        if names.unit_of(str(values[0])) is None:
            continue
        out.pop(key)
        beside = [k for k in columns if k.rpartition(".")[0] == parent and k != key]
        out = {f"{k} [{values[0]}]" if k in beside else k: v for k, v in out.items()}
    return out


def _numbers(values: list) -> list | None:
    """Numbers that stand in quotes, None where one of the texts is no number."""
    try:
        return [int(v) for v in values]
    except (TypeError, ValueError):
        pass
    try:
        return [float("nan") if v is None else float(v) for v in values]
    except (TypeError, ValueError):
        return None


def _unpacked(row: dict) -> list[dict]:
    """A message as the samples that it holds: lists of dicts (`ArrayAcc: [{x, y, z}, ...]`) one by
    one, each with what else the message says.
    """
    lists = {
        k: v
        for k, v in row.items()
        if isinstance(v, list) and v and all(isinstance(x, dict) for x in v)
    }
    if not lists:
        return [row]
    rest = {k: v for k, v in row.items() if k not in lists}
    size = max(len(v) for v in lists.values())
    out = []
    for i in range(size):
        one = dict(rest)
        for key, value in lists.items():
            if i < len(value):
                one.update(_leaves(value[i], key))
        out.append(one)
    return out


def _leaves(item, name: str):
    """(dotted name, value) of whatever is no dict."""
    if not isinstance(item, dict):
        yield name, list(item) if isinstance(item, tuple) else item
        return
    for key, value in item.items():
        yield from _leaves(value, f"{name}.{key}" if name else str(key))
