"""Two noises that take turns: how often the loud one is there, how loud, and for how long."""

from __future__ import annotations

import numpy as np

from imu_lib.arrays import Array
from imu_lib.units import duration

#: Classes of size, in standard deviations of the quiet noise, and rounds of the fit.
CLASSES, FURTHEST, ROUNDS = 400, 40.0, 60
#: Share of the samples and ratio of the two that are worth telling.
SHARE, RATIO = 0.005, 1.7
#: Blocks of the record, those in a row that are quiet at the least, their share of the loud samples
#: over that of all, and loud samples that chance would put there.
BLOCKS, ROW, QUIET, EXPECTED = 24, 3, 0.35, 20.0
#: Standard deviations of the quiet noise beyond which a sample is counted as loud.
FAR = 3.5
#: Lags, samples, at which the sizes of neighbours are compared.
LAGS = np.unique(np.geomspace(1, 2000, 25).astype(int))


def sentence(y: Array, fs: float) -> str | None:
    """What the innovations `y` (n,) at `fs` Hz do, or None where one noise is as good."""
    share, ratio = two_sizes(y)
    if not SHARE < share < 1.0 - SHARE or ratio < RATIO:
        return None
    stay = stays(y)
    how = (
        f"for {duration(stay / fs)} at a time"
        if stay > 2
        else "from one sample to the next, at no time of its own"
    )
    return (
        f"distribution of the innovations: two noises take turns; in {100 * share:.2g} % of the "
        f"samples the scatter is {ratio:.2g} times that of the others, {how}{_rest(y, fs)}"
    )


def _rest(y: Array, fs: float) -> str:
    """Words for when the loud noise (of innovations `y` (n,) at `fs` Hz) is not there."""
    size = len(y) // BLOCKS
    u = np.abs(y - np.median(y))
    far = u > FAR * 1.4826 * float(np.median(u))
    count = far[: size * BLOCKS].reshape(BLOCKS, size).sum(axis=1)
    quiet = count < QUIET * count.mean()
    step = np.diff(np.concatenate([[0], quiet.astype(np.int8), [0]]))
    start, stop = np.flatnonzero(step == 1), np.flatnonzero(step == -1)
    if not len(start):
        return ""
    k = int(np.argmax(stop - start))
    a, b = int(start[k]), int(stop[k])
    if b - a < ROW or (b - a) * count.mean() < EXPECTED:
        return ""
    return f", hardly ever from {a * size / fs:.0f} to {b * size / fs:.0f} s"


def two_sizes(y: Array) -> tuple[float, float]:
    """(share of the loud samples, its standard deviation over that of the quiet ones) of the
    likeliest mixture of two normal distributions about zero.
    """
    u = np.abs(y - np.median(y))
    scale = 1.4826 * float(np.median(u))
    if not scale > 0:
        return 0.0, 1.0
    count, edge = np.histogram(np.minimum(u / scale, FURTHEST), CLASSES, (0.0, FURTHEST))
    square = (0.5 * (edge[1:] + edge[:-1])) ** 2
    share, quiet, loud = 0.2, 0.5, 6.0  # variances
    for _ in range(ROUNDS):
        a = (1.0 - share) / np.sqrt(quiet) * np.exp(-0.5 * square / quiet)
        b = share / np.sqrt(loud) * np.exp(-0.5 * square / loud)
        odds = b / np.maximum(a + b, 1e-300)
        many = max(float(count @ odds), 1e-9)
        loud = max(float((count * odds) @ square) / many, 1e-9)
        rest = max(float(count @ (1.0 - odds)), 1e-9)
        quiet = max(float((count * (1.0 - odds)) @ square) / rest, 1e-9)
        share = many / count.sum()
    return float(share), float(np.sqrt(loud / quiet))


def stays(y: Array) -> float:
    """Samples for which the loud noise is there at a time, from the correlation of sizes."""
    size = np.minimum(np.abs(y), 4.0 * np.std(y))
    size = size - size.mean()
    lags = LAGS[LAGS < len(y) // 4]
    alike = np.array([np.mean(size[k:] * size[:-k]) for k in lags]) / np.mean(size**2)
    first = float(alike[0])
    if first < 0.05:
        return 1.0
    below = np.flatnonzero(alike < 0.5 * first)
    half = float(lags[below[0]]) if len(below) else float(lags[-1])
    # episodes of one length: their correlation falls in a straight line
    return 2.0 * half
