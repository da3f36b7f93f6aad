"""A jump of the bias."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from imu_lib import timing
from imu_lib.arrays import Array
from imu_lib.gap.candidate import Candidate
from imu_lib.gap.data import Data
from imu_lib.gap.drifts import Scan
from imu_lib.gap.state import State
from imu_lib.processes import Step as Process

from .drift import Drift

#: Blocks about a filled stretch, and no more than its length, within which what was drawn there
#: moves an edge.
NEAR = 0.15


class Step(Drift):
    name = "step"
    red = True
    event = True
    cause = (
        "Stress that is released, a connector, a change of range: the bias jumps once and stays."
    )
    shape = "time"
    sharp = True
    fall = 3.0  # an edge is where it is, or a sample beside it

    def shapes(self, data: Data) -> list[Any]:
        blocks = np.arange(2, data.n // data.m - 1)
        if data.missing is not None:  # on either side there is a block of what was measured
            seen = np.cumsum(~data.missing)
            before = seen[blocks * data.m - 1]
            blocks = blocks[np.minimum(before, seen[-1] - before) >= data.m]
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
        edge = sharpen(
            data.x,
            data.fs,
            process.time,
            data.m / data.fs,
            amplitude,
            density,
            missing=data.missing,
        )
        if edge is None:
            return process, {}
        # seen in the samples: the odds fall off on both sides like exp(-|t|)
        width = float(np.log((edge[2] - edge[1]) / 3.0 / data.duration))
        return process.with_(time=edge[0]), {"edge": edge, "width": width}

    def log_prior(self, state: State, candidate: Candidate) -> float:
        return candidate.note["width"]

    def profiled(self, candidate: Candidate, scan: Scan, data: Data) -> Candidate:
        candidate = super().profiled(candidate, scan, data)
        if data.missing is None:
            return candidate
        # what was drawn into a hole decides where in it the edge seems to be: all of it is possible
        low, high = candidate.note["profile"]
        first, last = timing.runs(data.missing)
        reach = np.minimum(NEAR * data.m, last - first)
        touched = (first - 1 - reach <= high * data.fs) & (low * data.fs <= last + reach)
        wide = [
            min([low, *(first[touched] - 1) / data.fs]),
            max([high, *last[touched] / data.fs]),
        ]
        return replace(candidate, note={**candidate.note, "profile": [float(v) for v in wide]})

    def where(self, state: State, candidate: Candidate) -> str:
        return f"mean of the signal: a jump at {candidate.process.time:.1f} s"


def sharpen(
    x: Array,
    fs: float,
    time: float,
    block: float,
    amplitude: float,
    density: float,
    *,
    missing: Array | None = None,
) -> tuple[float, float, float] | None:
    """(time, low, high) of an edge near `time`, found to the sample by least squares of two levels
    in a local window, from the samples that are not `missing`.

    `density` is N^2 of the white noise around it. The edge stays where it is if the jump does not
    stand out locally.
    """
    reach = int(round(2 * block * fs))
    i = int(round(time * fs))
    half = int(min(max(16 * density / max(amplitude**2, 1e-300), block) * fs, 8 * block * fs))
    lo, hi = max(0, i - reach - half), min(len(x), i + reach + half)
    if amplitude**2 * min(half, reach) / fs / density < 12 or hi - lo < 20:
        return None
    there = np.ones(hi - lo) if missing is None else 1.0 - missing[lo:hi]
    if there.sum() < 20:
        return None
    c = np.cumsum((x[lo:hi] - np.average(x[lo:hi], weights=there)) * there)[:-1]
    before = np.cumsum(there)[:-1]
    n, k = there.sum(), np.arange(1, hi - lo)
    gain = 0.5 * c**2 * n / np.maximum(before * (n - before), 1.0) / (density * fs)
    inside = (k + lo >= i - reach) & (k + lo <= i + reach)
    gain = np.where(inside, gain, -np.inf)
    best = k[gain >= gain.max() - 1e-9]  # several where samples are missing
    edge = int(best[len(best) // 2])
    near = k[gain >= gain.max() - 3.0] + lo
    return float((edge + lo) / fs), float((near.min() - 1) / fs), float((near.max() + 1) / fs)


EFFECTS = (Step(),)
