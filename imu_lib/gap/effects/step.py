"""A jump of the bias."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from imu_lib.arrays import Array
from imu_lib.gap.candidate import Candidate
from imu_lib.gap.data import Data
from imu_lib.gap.state import State
from imu_lib.processes import Step as Process

from .drift import Drift


class Step(Drift):
    name = "step"
    red = True
    cause = (
        "Stress that is released, a connector, a change of range: the bias jumps once and stays."
    )
    shape = "time"
    sharp = True
    fall = 3.0  # an edge is where it is, or a sample beside it

    def shapes(self, data: Data) -> list[Any]:
        blocks = np.arange(2, data.n // data.m - 1)
        return [Process(amplitude=1.0, time=float(t)) for t in blocks * data.m / data.fs]

    def columns(self, processes: Sequence[Any], data: Data) -> Array:
        # a sum of cosines from the edge on, whose first sample is the first at or after its time
        edge = np.ceil(np.array([p.time for p in processes]) * data.fs - 1e-6)
        half = 0.5 * np.pi * np.arange(1, data.orders + 1) / data.n
        scale = -np.sqrt(1.0 / (data.n * data.fs)) / np.sin(half)
        return scale[:, None] * np.sin(2 * half[:, None] * edge[None, :])

    def around(self, process: Any, data: Data, reach: float, points: int) -> list[Any]:
        block = data.m / data.fs
        times = np.clip(
            process.time + np.linspace(-reach, reach, points) * block,
            1.5 * block,
            data.duration - 1.5 * block,
        )
        return [process.with_(time=float(t)) for t in np.unique(times)]

    def noted(self, gain: Array) -> dict[str, Any]:
        # log of the share of all instants at which the jump may lie
        return {"width": float(np.log(np.sum(np.exp(gain - gain.max())) / len(gain)))}

    def sharpened(self, process: Any, amplitude: float, state: State) -> tuple[Any, dict[str, Any]]:
        data = state.cleaned
        s = state.fit.expected[data.layout.slow :]
        # red noise has edges of its own
        density = max(float(np.median(s)), float(np.median(s[:20]))) / 2
        edge = sharpen(data.x, data.fs, process.time, data.m / data.fs, amplitude, density)
        if edge is None:
            return process, {}
        # seen in the samples: the odds fall off on both sides like exp(-|t|)
        width = float(np.log((edge[2] - edge[1]) / 3.0 / data.duration))
        return process.with_(time=edge[0]), {"edge": edge, "width": width}

    def log_prior(self, state: State, candidate: Candidate) -> float:
        return candidate.note["width"]

    def where(self, state: State, candidate: Candidate) -> str:
        return f"mean of the signal: a jump at {candidate.process.time:.1f} s"


def sharpen(
    x: Array, fs: float, time: float, block: float, amplitude: float, density: float
) -> tuple[float, float, float] | None:
    """(time, low, high) of an edge near `time`, found to the sample by least squares of two levels
    in a local window.

    `density` is N^2 of the white noise around it. The edge stays where it is if the jump does not
    stand out locally.
    """
    reach = int(round(2 * block * fs))
    i = int(round(time * fs))
    half = int(min(max(16 * density / max(amplitude**2, 1e-300), block) * fs, 8 * block * fs))
    lo, hi = max(0, i - reach - half), min(len(x), i + reach + half)
    if amplitude**2 * min(half, reach) / fs / density < 12 or hi - lo < 20:
        return None
    y = x[lo:hi] - x[lo:hi].mean()
    c = np.cumsum(y)
    k = np.arange(1, len(y))
    n = len(y)
    gain = 0.5 * c[:-1] ** 2 * n / (k * (n - k)) / (density * fs)
    inside = (k + lo >= i - reach) & (k + lo <= i + reach)
    gain = np.where(inside, gain, -np.inf)
    j = int(np.argmax(gain))
    near = k[gain >= gain[j] - 3.0] + lo
    return float((k[j] + lo) / fs), float((near.min() - 1) / fs), float((near.max() + 1) / fs)


EFFECTS = (Step(),)
