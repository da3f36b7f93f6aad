"""The inverse Fourier transform of a real series that does not fit into memory.

Two even-odd halves make one complex series of half the length; its transform goes over a matrix of
A columns and B rows in two passes, columns and then rows, with a twist between (Bailey 1990, "FFTs
in external or hierarchical memory", the four-step method). Some 20 MB are in memory at a time.
"""

from __future__ import annotations

import numpy as np
from scipy import fft

from imu_lib.stream.scratch import Scratch, bounds

#: Numbers in a block of columns.
_BLOCK = 1 << 20


def inverse(spectrum: Scratch, *, folder=None):
    """The real series of 2 h numbers whose transform is `spectrum`, in pieces.

    Parameters
    ----------
    spectrum : Scratch of complex numbers, h + 1 of them
        As `numpy.fft.irfft` takes it.

    Yields
    ------
    ndarray
        Pieces in order, 2 h numbers in all.
    """
    h = spectrum.n - 1
    columns = _divisor(h)
    rows = h // columns
    packed = Scratch(h, dtype=complex, folder=folder)
    for start, stop in bounds(h):
        k = np.arange(start, stop)
        one = spectrum.read(start, stop)
        other = np.conj(spectrum.read(h - stop + 1, h - start + 1)[::-1])
        if start == 0:  # the two ends are real
            one[0], other[0] = one[0].real, other[0].real
        turn = np.exp(1j * np.pi / h * k)
        packed.write(start, 0.5 * (one + other) + 0.5j * (one - other) * turn)
    width = max(1, min(columns, _BLOCK // rows))
    for left, right in bounds(columns, width):
        block = _columns(packed, rows, columns, left, right)
        block = fft.ifft(block, axis=0, overwrite_x=True)
        # exp(2 pi i j k / h), the product reduced in whole numbers first: its digits are kept
        product = np.arange(rows)[:, None] * np.arange(left, right)[None, :] % h
        block *= np.exp(2j * np.pi / h * product)
        for row in range(rows):
            packed.write(row * columns + left, block[row])
    height = max(1, _BLOCK // columns)
    for top, bottom in bounds(rows, height):
        block = packed.read(top * columns, bottom * columns).reshape(bottom - top, columns)
        packed.write(top * columns, fft.ifft(block, axis=1, overwrite_x=True))
    for left, right in bounds(columns, width):
        block = _columns(packed, rows, columns, left, right)
        yield np.ascontiguousarray(block.T).view(float).ravel()
    packed.close()


def _columns(packed, rows, columns, left, right):
    out = np.empty((rows, right - left), complex)
    for row in range(rows):
        out[row] = packed.read(row * columns + left, row * columns + right)
    return out


def _divisor(h) -> int:
    """The largest divisor of h up to its root."""
    for d in range(int(np.sqrt(h)), 0, -1):
        if h % d == 0:
            return d
    return 1
