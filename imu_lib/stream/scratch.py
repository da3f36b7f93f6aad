"""A series of numbers in a temporary file, read and written by pieces.

Plain reads and writes, no memory map: what has been read does not stay in the process.
"""

from __future__ import annotations

import tempfile

import numpy as np

#: Samples that are in memory at a time.
CHUNK = 1 << 18
#: Series of more samples than this are drawn and written by pieces, and searched in two views.
LONG = 1 << 22
#: Series of more samples than this are summed up in one pass: at once, six channels of this length
#: take as much memory as a pass over any (benchmarks/scaling.py).
SUMMED = 1 << 20


class Scratch:
    """`n` numbers of type `dtype` in a temporary file in `folder`, zero until written.

    Parameters
    ----------
    n : int
    dtype : numpy dtype
    folder : path or None
        Where the file is made; it has no name and vanishes with the object.
    """

    def __init__(self, n, *, dtype=float, folder=None):
        self.n, self.dtype = int(n), np.dtype(dtype)
        self._file = tempfile.TemporaryFile(dir=folder, buffering=0)
        self._file.truncate(self.n * self.dtype.itemsize)

    def read(self, start, stop) -> np.ndarray:
        """The numbers start .. stop - 1, ndarray (stop - start,)."""
        out = np.empty(max(stop - start, 0), self.dtype)
        view = memoryview(out).cast("B") if out.size else memoryview(b"")
        self._file.seek(start * self.dtype.itemsize)
        got = 0
        while got < len(view):
            step = self._file.readinto(view[got:])
            if not step:
                raise OSError(f"a scratch file ends after {got} of {len(view)} bytes")
            got += step
        return out

    def write(self, start, values) -> None:
        """Put `values` at start, start + 1, ..."""
        values = np.ascontiguousarray(values, self.dtype)
        self._file.seek(start * self.dtype.itemsize)
        view = memoryview(values).cast("B") if values.size else b""
        done = 0
        while done < len(view):
            done += self._file.write(view[done:])

    def close(self) -> None:
        """Give the disk back."""
        self._file.close()


def bounds(n, size=CHUNK):
    """(start, stop) of the pieces of `n` samples, `size` at a time."""
    for start in range(0, n, size):
        yield start, min(start + size, n)
