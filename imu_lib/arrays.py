"""Types of arrays, for signatures: shapes and units stand in the docstrings."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike, NDArray

__all__ = ["Array", "ArrayLike"]

#: An array of numbers; most are double precision, some are indices or flags.
Array = NDArray[Any]
