"""Where simulations of a grown model are still off, in words that the eye can check in a figure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from imu_lib.ensembles.battery import BLOCK, JOINED, LAGS, edges

#: Simulations outside the told range, on either side.
OUTSIDE = 0.05


def sentence(domain: str, measured: Any, rows: Sequence[Any], n: int, fs: float) -> str:
    """The statistic of the domain that is furthest off, against the simulations' range; `n` samples
    at `fs` Hz.
    """
    own, many = np.asarray(measured[domain]), np.array([r[domain] for r in rows])
    scatters = many.std(axis=0)
    i = int(np.argmax(np.abs(own - many.mean(axis=0)) / (scatters + 1e-9)))
    low, high = np.quantile(many[:, i], [OUTSIDE, 1.0 - OUTSIDE])
    if domain in ("psd", "allan"):
        off, scatter = (10 / np.log(10) * v for v in (own[i] - np.median(many[:, i]), scatters[i]))
        return (
            f"{_place(domain, i, n, fs)} is {off:+.2g} dB off that of simulations, which scatter "
            f"by {scatter:.2g} dB"
        )
    what, to = _told(domain, i, len(own) - 1)
    return f"{what} is {to(own[i])} where simulations have {to(low)} to {to(high)}"


def _place(domain: str, i: int, n: int, fs: float) -> str:
    """Where on a curve a statistic is."""
    if domain == "allan":
        return f"the Allan variance at {3**i / fs:.3g} s"
    edge = edges(n) * fs / n
    return f"the power between {edge[i]:.3g} and {edge[i + 1]:.3g} Hz"


def _told(domain: str, i: int, last: int) -> tuple[str, Any]:
    """Name of a statistic, and its value in words."""
    if domain == "lines":
        return "the largest line of a band over its mean power, in dB,", _decibel
    if domain == "variance":
        if i == last:
            return "the power of the first half over that of the second, in dB,", _decibel
        what = "the scatter" if i % 2 == 0 else "the largest"
        span = BLOCK * JOINED[min(i // 2, len(JOINED) - 1)]
        return f"{what} of the noise power over {span:g} s, over its mean,", _ratio
    if domain == "distribution":
        return _of_sizes(i)
    if domain == "autocorrelation":
        apart = int(LAGS[i])
        what = "neighbouring samples" if apart == 1 else f"samples {apart} apart"
        return f"the correlation of {what}", _plain
    return f"a statistic of the {domain}", _plain


def _of_sizes(i: int) -> tuple[str, Any]:
    names = (
        ("the skewness of the samples", _plain),
        ("the kurtosis of the samples", _ratio),
        ("the share of samples beyond three standard deviations", _percent),
        ("the share of samples beyond four standard deviations", _percent),
        ("the largest sample in standard deviations", _ratio),
        ("the share of samples that equal the one before", _percent),
        ("the share of samples within half a standard deviation", _percent),
        ("whether samples crowd at an end of the range", _plain),
    )
    return names[i]


def _plain(v: float) -> str:
    return f"{v:.3g}"


def _ratio(v: float) -> str:
    return f"{np.exp(v):.3g}"


def _percent(v: float) -> str:
    return f"{100 * np.exp(v):.2g} %"


def _decibel(v: float) -> str:
    return f"{10 * v / np.log(10):.3g}"
