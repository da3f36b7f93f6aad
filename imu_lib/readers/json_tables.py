"""JSON that is one document (a list of samples, or a list of values under each name), or a document a
line, as Python prints its dictionaries, too.
"""

from __future__ import annotations

import ast
import json

import numpy as np

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
    found = _split(_samples(found))
    if isinstance(found, list):
        found = _columns(found)
    arrays = {}
    for key, value in _leaves(found, ""):
        x = np.asarray(value)
        if x.dtype.kind in "fiuU" and 1 <= x.ndim <= 2 and len(x) > 1 or x.ndim == 0:
            arrays[key] = x
    if not any(x.ndim and len(x) > 1 for x in arrays.values()):
        return None
    return from_arrays(source, arrays, columns, signal, contract=False)


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
        lists = [v for v in found.values() if isinstance(v, list) and v and isinstance(v[0], dict)]
        inner = [v for v in found.values() if isinstance(v, dict)]
        if len(lists) == 1:
            return lists[0]
        if len(found) == 1 and inner:
            found = inner[0]
            continue
        return found
    return found


def _split(found):
    """Names and rows apart (`columns`, `data`) as columns; anything else as it is."""
    if not isinstance(found, dict):
        return found
    names_, rows = found.get("columns"), found.get("data")
    if not (isinstance(names_, list) and isinstance(rows, list) and rows):
        return found
    if not all(isinstance(r, list) and len(r) == len(names_) for r in rows):
        return found
    return [dict(zip(map(str, names_), r)) for r in rows]


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
    """A message as the samples that it holds: lists of dicts (`ArrayAcc: [{x, y, z}, ...]`) one by one,
    each with what else the message says.
    """
    lists = {k: v for k, v in row.items() if isinstance(v, list) and v and all(isinstance(x, dict) for x in v)}  # fmt: skip
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
