"""A band of a channel brought down to the level of its neighbours: its ordinates are drawn anew.

What was louder there is gone with whatever else was in the band, which is what masking a band
means; outside of the band and of the time nothing changes.
"""

from __future__ import annotations

import numpy as np

from imu_lib.arrays import Array

#: Samples that a segment has for one ordinate's width of the band at the least, and its lengths.
SHORTEST_SEGMENT, LONGEST_SEGMENT = 1024, 65536


def segment_length(n: int, fs: float, width: float) -> int:
    """Length of the segments, a power of two, whose ordinates resolve a band of `width` Hz."""
    want = 32.0 * fs / max(width, 1e-9)
    length = 2 ** int(np.ceil(np.log2(np.clip(want, SHORTEST_SEGMENT, LONGEST_SEGMENT))))
    while length > max(n // 8, 64):
        length //= 2
    return length


def quietened(
    x: Array,
    fs: float,
    bands: list[tuple[float, float]],
    rng: np.random.Generator,
    *,
    start: float = 0.0,
    stop: float | None = None,
) -> Array:
    """`x` (n,) with the `bands` [(low, high) Hz, ...] at the level of what is beside them.

    Segments under a sine window, half-overlapping, put together again under the same window (its
    squares add up to one). In each the ordinates of a band are drawn anew with the mean power of
    the ordinates on either side.
    """
    n = len(x)
    width = min(high - low for low, high in bands)
    length = segment_length(n, fs, width)
    hop = length // 2
    window = np.sin(np.pi * (np.arange(length) + 0.5) / length)
    padded = np.concatenate([x[hop:0:-1], x, x[-2 : -length - hop - 2 : -1]])
    count = (len(padded) - length) // hop + 1
    f = np.arange(length // 2 + 1) * fs / length
    out = np.zeros(len(padded))
    inside, sides = _ordinates(f, bands)
    parts = np.lib.stride_tricks.sliding_window_view(padded, length)[::hop][:count]
    step = max(1, 2**22 // length)
    for i in range(0, count, step):
        part = parts[i : i + step]
        middle = part.mean(axis=1, keepdims=True)
        z = np.fft.rfft((part - middle) * window, axis=1)
        for at, beside in zip(inside, sides):
            level = _level(np.abs(z) ** 2, at, beside)
            noise = rng.standard_normal((len(z), len(at), 2)) @ np.array([1.0, 1j])
            # the window has taken half of the power, and takes half of what is drawn behind it
            z[:, at] = noise * np.sqrt(2 * level / 2)
        back = np.fft.irfft(z, length, axis=1) * window + middle * window**2
        for k, segment in enumerate(back):
            a = (i + k) * hop
            out[a : a + length] += segment
    out = out[hop : hop + n]
    return x + _fade(n, fs, start, stop, hop) * (out - x)


def _ordinates(
    f: Array, bands: list[tuple[float, float]]
) -> tuple[list[Array], list[tuple[Array, Array]]]:
    """Ordinates of each band, and those beside it that no band holds."""
    taken = np.zeros(len(f), bool)
    inside = []
    for low, high in bands:
        at = np.flatnonzero((f >= low - f[1]) & (f <= high + f[1]))
        at = at[(at > 0) & (at < len(f) - 1)]
        if len(at) == 0:
            at = np.array([min(max(int(round((low + high) / 2 / f[1])), 1), len(f) - 2)])
        inside.append(at)
        taken[at] = True
    taken[0] = True
    free = np.flatnonzero(~taken)
    sides = []
    for at in inside:
        reach = max(6, len(at) // 2)
        guard = len(at) // 4  # a wide band has skirts
        left = free[free < at[0] - guard][-reach:]
        right = free[free > at[-1] + guard][:reach]
        sides.append((left, right))
    return inside, sides


def _level(power: Array, at: Array, beside: tuple[Array, Array]) -> Array:
    """Level at the ordinates `at` from the mean logarithms of the power beside, shape (1, at): a
    line between the two sides where both are there.
    """
    euler = 0.5772156649
    values, places = [], []
    for side in beside:
        if len(side):
            values.append(np.mean(np.log(power[:, side] + 1e-300)) + euler)
            places.append(side.mean())
    if not values:
        return np.full((1, len(at)), 1e-300)
    return np.exp(np.interp(at, places, values))[None, :]


def _fade(n: int, fs: float, start: float, stop: float | None, hop: int) -> Array:
    """1 between `start` and `stop` s, 0 away from it, with ramps outside; shape (n,)."""
    t = np.arange(n)
    ramp = max(1, min(hop // 2, int(0.5 * fs)))
    rise = np.clip((t - (start * fs - ramp)) / ramp, 0, 1) if start > 0 else np.ones(n)
    fall = np.clip(((stop * fs + ramp) - t) / ramp, 0, 1) if stop is not None else np.ones(n)
    return np.sin(0.5 * np.pi * np.minimum(rise, fall)) ** 2
