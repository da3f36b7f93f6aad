"""Output stages on a signal in pieces: what their `apply` does to the whole.

A stage draws what it needs before it returns, so that stages ask the generator in their order.
"""

from __future__ import annotations

from functools import singledispatch

import numpy as np

from imu_lib.processes.stages import Resolution, Saturation, Spikes, Stuck
from imu_lib.stream import CHUNK, bounds


@singledispatch
def passed(stage, pieces, fs, rng, n):
    """The signal of `n` samples behind a stage, in pieces; the default takes it as a whole."""
    x = stage.apply(np.concatenate(list(pieces)), fs, rng)
    return (x[low:high] for low, high in bounds(n))


@passed.register(Saturation)
@passed.register(Resolution)
def _(stage, pieces, fs, rng, n):
    return (stage.apply(x, fs, rng) for x in pieces)


@passed.register(Spikes)
def _(stage, pieces, fs, rng, n):
    hit = [
        low + np.flatnonzero(rng.random(high - low) < stage.rate / fs)
        for low, high in bounds(n, CHUNK)
    ]
    hit = np.concatenate(hit)
    height = stage.scale * rng.standard_normal(len(hit))
    if stage.differenced:
        after = hit[hit + 1 < n] + 1
        hit, height = np.r_[hit, after], np.r_[height, -height[: len(after)]]
        order = np.argsort(hit, kind="stable")
        hit, height = hit[order], height[order]

    def thrown():
        at = 0
        for x in pieces:
            low, high = np.searchsorted(hit, (at, at + len(x)))
            x = np.array(x)
            np.add.at(x, hit[low:high] - at, height[low:high])
            at += len(x)
            yield x

    return thrown()


@passed.register(Stuck)
def _(stage, pieces, fs, rng, n):
    begin, length = stage.runs(n, rng), max(int(stage.length), 1)

    def held():
        at, frozen = 0, 0.0
        for x in pieces:
            x = np.array(x, dtype=float)
            first = int(np.searchsorted(begin, at - length))
            last = int(np.searchsorted(begin, at + x.size))
            for start in begin[first:last] - at:
                if start >= 0:
                    frozen = x[start]
                x[max(start + 1, 0) : max(start + 1 + length, 0)] = frozen
            at += x.size
            yield x

    return held()


def rounded(process, pieces, fs, rng):
    """`Quantization.round` on a signal in pieces."""
    step = process.Q * np.sqrt(12.0) * fs
    first = rng.random()

    def out():
        total = np.array([first])
        for x in pieces:
            total = np.cumsum(np.concatenate([total[-1:], x / step]))
            yield np.diff(np.rint(total)) * step

    return out()


def level(change, size, fs, start):
    """The factor of a change of noise level on `size` samples from sample `start` on."""
    return change.factor(size, fs, start)
