"""HDF5 as MATLAB 7.3, pandas and h5py write it: arrays by name, and the texts that say their
units.
"""

from __future__ import annotations

import re

import numpy as np

from imu_lib.errors import InputError

MOST_VALUES = 2_000_000_000  # 16 GB of float64: no record of an IMU
_UNITS = re.compile(r"(^|[./_])units?([._]|$)", re.IGNORECASE)


def arrays(path) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """Arrays by dotted name, and the texts among them that are called units. InputError where the
    file is damaged.
    """
    import h5py

    out: dict[str, np.ndarray] = {}
    texts: dict[str, str] = {}
    try:
        with h5py.File(path, "r") as file:

            def visit(name, item):
                if not isinstance(item, h5py.Dataset) or name.startswith("#refs#"):
                    return
                dotted = name.replace("/", ".")
                if _is_text(item) and _UNITS.search(name):
                    texts[dotted] = _text(file, item)
                elif item.dtype.names or item.dtype.kind in "fiu" and not _is_text(item):
                    _refuse_empty_promise(path, name, item)
                    _take(out, dotted, item)

            file.visititems(visit)
            _blocks(file, out)
    except (OSError, RuntimeError, KeyError, ValueError) as error:
        if isinstance(error, PermissionError | FileNotFoundError | IsADirectoryError):
            raise
        raise InputError(
            f"{path} is not a whole HDF5 (MATLAB 7.3) file ({str(error).splitlines()[0][:90]}); "
            "save it again."
        ) from None
    return out, texts


def _refuse_empty_promise(path, name, item) -> None:
    """InputError where a data set announces what it does not store."""
    stored = item.id.get_storage_size()
    if (
        item.size > 1000
        and stored * 20_000 < item.size * item.dtype.itemsize
        or item.size > MOST_VALUES
    ):
        raise InputError(
            f"{path}, `{name}`: announces {item.size:,} values but stores {stored:,} bytes; it is "
            "damaged: save it again."
        )


def _take(out: dict[str, np.ndarray], name: str, item) -> None:
    """A data set as arrays: the fields of a table, or the whole under its name and stated unit."""
    value = item[()]
    if item.dtype.names:
        for field in item.dtype.names:
            if value[field].dtype.kind in "fiu":
                part = value[field]
                # pandas keeps the columns of one type as one field
                out[f"{name}.{field}"] = part.T if part.ndim == 2 else part
        return
    unit = item.attrs.get("units", item.attrs.get("unit"))
    unit = unit.decode() if isinstance(unit, bytes) else unit
    key = f"{name} [{unit}]" if isinstance(unit, str) and unit.strip() else name
    out[key] = value.T if value.ndim == 2 else value  # MATLAB stores columns first


def _is_text(item) -> bool:
    return item.attrs.get("MATLAB_class") in (b"char", b"cell") or item.dtype.kind in "OS"


def _text(file, item) -> str:
    """A text, or the texts of a cell array, with commas between them."""
    import h5py

    value = item[()]
    if isinstance(value, bytes | str):
        return value.decode() if isinstance(value, bytes) else value
    parts = []
    for x in np.ravel(value):
        if isinstance(x, h5py.Reference):
            parts.append(_text(file, file[x]))
        elif isinstance(x, bytes | str):
            parts.append(x.decode() if isinstance(x, bytes) else x)
    if parts:
        return ",".join(parts)
    return "".join(chr(int(c)) for c in np.ravel(value))


def _blocks(file, out: dict[str, np.ndarray]) -> None:
    """The columns of pandas' fixed format, which stand as a matrix beside a list of their names."""
    for key in [k for k in out if re.search(r"(^|\.)block\d+_values$", k)]:
        place = key.replace(".", "/")
        names = file.get(place.replace("_values", "_items"))
        value = out.pop(key)
        if names is None:
            continue
        heads = [n.decode() if isinstance(n, bytes) else str(n) for n in names[()]]
        rows = value if value.shape[0] == len(heads) else value.T
        out.update(dict(zip(heads, rows)))
    for key in [k for k in out if re.search(r"(^|\.)(?:block\d+_items|axis\d+)$", k)]:
        out.pop(key)
