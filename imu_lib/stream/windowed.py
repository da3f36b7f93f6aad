"""One-pass statistics that merge: a pass over two halves equals a pass over the whole.

Whatever is summed over windows of bounded length (lagged products, differences of neighbouring
clusters, transforms of segments, outputs of a short filter) needs of each half its sum, its first
and its last values: those make the windows that straddle the seam.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Self

import numpy as np


class Windowed:
    """Base: windows of `span` values whose starts lie on a grid of `stride`.

    Parameters
    ----------
    span, stride : int
    begin : int
        Index, in the whole series, of the first value that this pass will see.
    phase : int
        Window starts are congruent to it modulo `stride`.
    """

    def __init__(self, span: int, stride: int = 1, begin: int = 0, phase: int = 0) -> None:
        self.span, self.stride = span, stride
        self.begin = self.end = begin
        self.next = begin + (phase - begin) % stride
        self.head = np.empty(0)
        self.tail = np.empty(0)

    def use(self, values: np.ndarray, count: int) -> None:
        """Take `count` windows in; the first begins with `values`, the next `stride` later."""
        raise NotImplementedError

    def absorb(self, other: Self) -> None:
        """Add the sums of the pass that follows; the seam is done."""
        raise NotImplementedError

    def feed(self, x: np.ndarray) -> None:
        """The next values, ndarray (k,)."""
        if self.head.size < self.span - 1:
            self.head = np.concatenate([self.head, x[: self.span - 1 - self.head.size]])
        skip = max(self.next - self.end, 0)
        self.end += x.size
        x = x[skip:]
        values = np.concatenate([self.tail, x]) if self.tail.size else x
        count = max((values.size - self.span) // self.stride + 1, 0)
        if count:
            self.use(values, count)
            self.next += count * self.stride
            values = values[count * self.stride :]
        self.tail = values.copy()

    def merge(self, other: Self) -> None:
        """Go on with a pass that began where this one ends."""
        if other.begin != self.end:
            raise ValueError(f"`other` begins at {other.begin}, this pass ends at {self.end}")
        if other.end - other.begin < other.span:
            self.feed(other.head[: other.end - other.begin])
            return
        count = max(-(-(other.begin - self.next) // self.stride), 0)
        if count:
            self.use(np.concatenate([self.tail, other.head]), count)
        if self.head.size < self.span - 1:
            self.head = np.concatenate([self.head, other.head])[: self.span - 1]
        self.absorb(other)
        self.next, self.end, self.tail = other.next, other.end, other.tail


class Keep(Windowed):
    """All values, one after the other: for a series that is short by now."""

    def __init__(self, begin: int = 0) -> None:
        super().__init__(1, begin=begin)
        self.parts: list[np.ndarray] = []

    def use(self, values: np.ndarray, count: int) -> None:
        self.parts.append(values[:count].copy())

    def absorb(self, other: Self) -> None:
        self.parts += other.parts

    @property
    def values(self) -> np.ndarray:
        return np.concatenate(self.parts) if self.parts else np.empty(0)


class Means(Windowed):
    """Means of `size` values, handed on to `children`."""

    def __init__(self, size: int, children: Sequence[Windowed], begin: int = 0) -> None:
        super().__init__(size, size, begin)
        self.children = children

    def use(self, values: np.ndarray, count: int) -> None:
        means = values[: count * self.span].reshape(count, self.span).mean(axis=1)
        for child in self.children:
            child.feed(means)

    def absorb(self, other: Self) -> None:
        for child, after in zip(self.children, other.children, strict=True):
            child.merge(after)


class LagSums(Windowed):
    """Sums of x_t x_{t+d} for the lags d = 0 ... `lags`, of x, and the number of values."""

    def __init__(self, lags: int, begin: int = 0) -> None:
        super().__init__(lags + 1, begin=begin)
        self.products, self.sum, self.count = np.zeros(lags + 1), 0.0, 0

    def use(self, values: np.ndarray, count: int) -> None:
        for low in range(0, count, 8192):  # in the cache, and below what BLAS gives to threads
            x = values[low : min(low + 8192, count)]
            for d in range(self.span):
                self.products[d] += x @ values[low + d : low + d + x.size]
            self.sum += x.sum()
        self.count += count

    def absorb(self, other: Self) -> None:
        self.products += other.products
        self.sum += other.sum
        self.count += other.count

    @property
    def total(self) -> tuple[np.ndarray, float, int]:
        """(products, sum, number) with the last values, whose longer lags do not exist."""
        products = self.products.copy()
        for d in range(min(self.span, self.tail.size)):
            products[d] += self.tail[: self.tail.size - d] @ self.tail[d:]
        return products, self.sum + self.tail.sum(), self.count + self.tail.size


class Products(Windowed):
    """Sum over segments of `size` values of the outer product of each with itself."""

    def __init__(self, size: int, begin: int = 0) -> None:
        super().__init__(size, size, begin)
        self.matrix, self.count = np.zeros((size, size)), 0

    def use(self, values: np.ndarray, count: int) -> None:
        y = values[: count * self.span].reshape(count, self.span)
        self.matrix += y.T @ y
        self.count += count

    def absorb(self, other: Self) -> None:
        self.matrix += other.matrix
        self.count += other.count


class Segments(Windowed):
    """Sum over segments of the squared magnitude of a transform of each.

    Parameters
    ----------
    size, stride : int
    transform : callable
        (k, size) -> (k, m), real or complex.
    """

    def __init__(
        self, size: int, stride: int, transform: Callable[[np.ndarray], np.ndarray], begin: int = 0
    ) -> None:
        super().__init__(size, stride, begin)
        self.transform, self.count = transform, 0
        self.power: np.ndarray | float = 0.0

    def use(self, values: np.ndarray, count: int) -> None:
        windows = np.lib.stride_tricks.sliding_window_view(values, self.span)
        for k in range(count):
            z = self.transform(windows[k * self.stride])
            self.power = self.power + (z.real**2 + z.imag**2 if np.iscomplexobj(z) else z * z)
        self.count += count

    def absorb(self, other: Self) -> None:
        self.power = self.power + other.power
        self.count += other.count
