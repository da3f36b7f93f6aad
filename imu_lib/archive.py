"""Arrays in `.npz` and `.npy` files, read with suspicion.

The header of an array is read before its data: a file that announces more than it holds is refused
before memory is asked for, and pickled objects are never loaded.
"""

from __future__ import annotations

import threading
import zipfile
import zlib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from numpy.lib import format as npy

from imu_lib.errors import InputError

# A header is Python text that NumPy has the interpreter parse; CPython 3.11 counts the depth of the
# syntax tree once for all threads and raises SystemError where two of them parse at a time.
_PARSING = threading.Lock()


def _read(stream, size: int, where: str) -> np.ndarray:
    """One array from an open .npy stream of `size` bytes."""
    try:
        version = npy.read_magic(stream)
        read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
        with _PARSING:
            shape, fortran, dtype = read(stream)
    except (ValueError, EOFError, SyntaxError, TypeError) as error:
        raise InputError(
            f"{where} is not a readable NumPy array ({str(error).splitlines()[0]}); save it again "
            "with numpy.savez."
        ) from None
    if dtype.hasobject:
        raise InputError(
            f"{where} holds Python objects, which are not read; save plain number arrays instead."
        )
    count = 1
    for length in shape:
        count *= int(length)
    held = size - stream.tell()
    if count * dtype.itemsize > held:
        raise InputError(
            f"{where} announces {count:,} values in its header but the file holds "
            f"{held // max(dtype.itemsize, 1):,}; it is cut off or damaged: write it again."
        )
    data = stream.read(count * dtype.itemsize)
    if len(data) < count * dtype.itemsize:
        raise InputError(
            f"{where} ends after {len(data) // max(dtype.itemsize, 1):,} of {count:,} values; it "
            "is cut off: write it again."
        )
    return np.frombuffer(data, dtype=dtype, count=count).reshape(
        shape, order="F" if fortran else "C"
    )


def load_arrays(path) -> dict[str, np.ndarray]:
    """Every array of an .npz file (or the one of an .npy file, under the key `data`), by key.

    The arrays are read-only. Raises InputError where the file is damaged, OSError where it cannot
    be opened.
    """
    path = Path(path)
    with open(path, "rb") as file:
        if file.read(6) == b"\x93NUMPY":
            file.seek(0)
            return {"data": _read(file, path.stat().st_size, str(path))}
    try:
        with zipfile.ZipFile(path) as archive:
            members = [m for m in archive.infolist() if m.filename.endswith(".npy")]
            if not members:
                raise InputError(
                    f"{path} holds no arrays; an .npz with time, gyro and accel is expected."
                )

            def one(member):
                # each thread opens the member for itself: inflating releases the interpreter lock
                with archive.open(member) as stream:
                    return member.filename[:-4], _read(
                        stream, member.file_size, f"{path}, array `{member.filename[:-4]}`,"
                    )

            with ThreadPoolExecutor(4) as pool:
                return dict(pool.map(one, members))
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError) as error:
        raise InputError(
            f"{path} is not a whole {Path(path).suffix or '.npz'} file ({error}); it is cut off or "
            "damaged: write or fetch it again."
        ) from None


def numbers(array: np.ndarray, where: str) -> np.ndarray:
    """`array` as float64, refused with a sentence where it holds text or complex numbers."""
    array = np.asarray(array)
    if array.dtype.kind not in "fiub":
        raise InputError(
            f"{where} holds {array.dtype} instead of numbers; save it as real numbers."
        )
    return array.astype(np.float64, copy=False)
