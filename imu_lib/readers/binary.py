"""Binary files of arrays: .npz and .npy, .mat (v5 to v7.3) and other HDF5."""

from __future__ import annotations

import re
import struct
import zlib

import numpy as np

from imu_lib.archive import load_arrays
from imu_lib.errors import InputError
from imu_lib.readers import formats, hdf5
from imu_lib.readers.arrays import from_arrays
from imu_lib.readers.raw import Raw


def read_numpy(path, *, columns=None, signal=None) -> Raw:
    """Arrays under the contract's keys are SI; others by what their names say."""
    return from_arrays(str(path), load_arrays(path), columns, signal, contract=True)


def read_mat(path, *, columns=None, signal=None) -> Raw:
    """Variables (also inside structs) by name, or one matrix whose columns the caller names."""
    with open(path, "rb") as file:
        start = file.read(128)
    if len(start) < 4:
        raise InputError(f"{path} is empty; a MATLAB file is expected.")
    if start[:8] == b"\x89HDF\r\n\x1a\n" or b"MATLAB 7.3" in start[:32]:
        flat, texts = hdf5.arrays(path)
    else:
        flat, texts = _matlab5(path)
    raw = from_arrays(str(path), flat, columns, signal, contract=False)
    formats.beside(raw, texts)
    return raw


def _matlab5(path) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """Numbers of a MATLAB file up to version 7 by dotted name, and texts that are called units."""
    import scipy.io

    try:
        arrays = scipy.io.loadmat(path, squeeze_me=False, struct_as_record=False)
    except (
        ValueError,
        TypeError,
        KeyError,
        IndexError,
        EOFError,
        NotImplementedError,
        struct.error,
        zlib.error,
        OverflowError,
        UnicodeError,
        scipy.io.matlab.MatReadError,
        AttributeError,
        MemoryError,
        OSError,
    ) as error:
        if isinstance(error, PermissionError | FileNotFoundError | IsADirectoryError):
            raise
        raise InputError(
            f"{path} is not a whole MATLAB file "
            f"({str(error).splitlines()[0][:90] if str(error) else type(error).__name__}); save "
            "it again with save -v7."
        ) from None
    flat: dict[str, np.ndarray] = {}
    texts: dict[str, str] = {}
    for key, value in arrays.items():
        if not key.startswith("__"):
            _flatten(key, value, flat, texts, 0)
    if not flat and "__function_workspace__" in arrays:
        raise InputError(
            f"{path} holds a MATLAB timetable or another object, which MATLAB alone opens; write "
            "it there with writetimetable(NAME, 'file.csv')."
        )
    return flat, texts


def _flatten(key, value, out, texts, depth):
    """Numbers of structs into `out`, texts that are called units into `texts`."""
    if isinstance(value, np.ndarray) and value.dtype == object:
        structs = [x for x in value.ravel() if hasattr(x, "_fieldnames")]
        if value.size == 1:
            value = value.ravel()[0]
        elif len(structs) == value.size and depth < 4:
            for i, struct_ in enumerate(structs):
                _flatten(f"{key}[{i}]", struct_, out, texts, depth + 1)
            return
    if hasattr(value, "_fieldnames") and depth < 4:
        values, label = _signal(value)
        if label and values is not None:  # a label is what it is called where signals have one
            name = f"{key.rpartition('.')[0]}.{label}".lstrip(".")
            out[name if name not in out else f"{key}.{label}"] = values
            return
        for name in value._fieldnames:
            _flatten(f"{key}.{name}", getattr(value, name), out, texts, depth + 1)
    elif isinstance(value, np.ndarray) and value.dtype.kind in "fiubc":
        out[key] = value
    elif isinstance(value, np.ndarray) and re.search(r"(^|[._])units?([._]|$)", key, re.IGNORECASE):
        texts[key] = ",".join(str(v) for x in value.ravel() for v in np.ravel(x))


def _signal(struct_) -> tuple[np.ndarray | None, str]:
    """Values and name of a signal of Simulink (`values` beside `label`, else the last part of
    `blockName`); None and an empty name where a struct is none.
    """
    if not {"values", "label"} <= set(struct_._fieldnames):
        return None, ""
    values = np.asarray(struct_.values)
    if values.dtype.kind not in "fiub":
        return None, ""
    label = _word(struct_.label) or _word(getattr(struct_, "blockName", "")).rpartition("/")[2]
    return (values.squeeze() if values.ndim > 2 else values), label  # (3, 1, n) of a frame


def _word(text) -> str:
    """The text of an array of one, blanks cut."""
    found = np.ravel(text)
    return str(found[0]).strip() if found.size == 1 else ""
