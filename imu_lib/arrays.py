"""Arrays: their types for signatures (shapes and units stand in the docstrings), and those that
nobody changes.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["Array", "ArrayLike", "frozen"]

#: An array of numbers; most are double precision, some are indices or flags.
Array = NDArray[Any]


def frozen(value: ArrayLike, name: str, shape: tuple[int, ...]) -> np.ndarray:
    """A read-only contiguous float64 array of `shape` (-1 where any length will do); ValueError
    naming `name` otherwise.
    """
    try:
        array = np.ascontiguousarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"`{name}` must hold numbers") from None
    if array.ndim != len(shape) or any(
        want not in (-1, got) for want, got in zip(shape, array.shape)
    ):
        wanted = ", ".join("n" if s == -1 else str(s) for s in shape)
        raise ValueError(f"`{name}` must have the shape ({wanted}), not {array.shape}")
    if array is value or array.base is not None:
        array = array.copy() if array.flags.writeable else array
    array.setflags(write=False)
    return array
