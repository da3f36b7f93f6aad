"""Slow ageing and unresolved environment."""

from __future__ import annotations

from typing import Any

from imu_lib.processes import RandomWalk as Process

from .competitor import Spectral


class RandomWalk(Spectral):
    name = "random_walk"
    red = True
    single = True
    cause = "Slow ageing and unresolved environment: the bias diffuses without a restoring force."
    domain = "allan"
    process = Process
    amplitude = "K"

    def grid(self, fs: float, duration: float) -> list[Any]:
        return [Process(K=1.0)]


EFFECTS = (RandomWalk(),)
