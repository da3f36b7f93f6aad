"""Autoregressive processes: a resonance, of second order, and noise that alternates, of first
order.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from imu_lib.arrays import Array
from imu_lib.gap.candidate import Candidate
from imu_lib.gap.state import State
from imu_lib.likelihood.evidence import AMPLITUDE_WIDTH
from imu_lib.likelihood.slot import Slot
from imu_lib.processes import Autoregressive as Process
from imu_lib.processes import LowPass

from .base import Effect
from .competitor import SLOPE_BESIDE_FILTER, Spectral


class Resonance(Slot):
    """AR(2) through the logarithms of its standard deviation, its damping -ln r and its
    frequency.
    """

    def read(self, process: Any) -> list[float]:
        a, b = process.phi
        r = np.sqrt(max(-b, 1e-12))
        w = np.arccos(np.clip(a / (2 * r), -1, 1))
        gain = process.sigma / np.sqrt(1 - r * r)
        return [np.log(gain), np.log(-np.log(r)), np.log(w)]

    def write(self, process: Any, vector: Array) -> Any:
        gain, damping, w = np.exp(vector)
        r = np.exp(-damping)
        return process.with_(
            phi=(2 * r * np.cos(w), -r * r), sigma=float(gain * np.sqrt(1 - r * r))
        )

    def relative(self, process: Any, name: str) -> Array:
        # the innovations' sigma is gain sqrt(1 - r^2) with r = exp(-damping)
        square = -process.phi[1]
        return np.array([1.0, -0.5 * np.log(square) * square / (1 - square), 0.0])


class Alternating(Slot):
    """AR(1) of a negative coefficient -r through the logarithms of its standard deviation and of
    -ln r.
    """

    def read(self, process: Any) -> list[float]:
        r = -process.phi[0]
        return [np.log(process.sigma / np.sqrt(1 - r * r)), np.log(-np.log(r))]

    def write(self, process: Any, vector: Array) -> Any:
        gain, damping = np.exp(vector)
        r = np.exp(-damping)
        return process.with_(phi=(-r,), sigma=float(gain * np.sqrt(1 - r * r)))

    def relative(self, process: Any, name: str) -> Array:
        square = process.phi[0] ** 2
        return np.array([1.0, -0.5 * np.log(square) * square / (1 - square)])


class Autoregressive(Spectral):
    name = "autoregressive"
    cause = "A mechanical resonance of the sensor or its mounting, driven by noise."
    domain = "psd"
    process = Process
    amplitude = "sigma"
    rarity = 1.0
    simple = False
    local = True

    def worth_fitting(self, candidate: Candidate, state: State, best: float, simple: float) -> bool:
        # one in a channel, and a resonance only where it beats every simpler noise
        if any(c.name == self.name for c in state.items):
            return False
        if not self.simple and candidate.screen < simple + 3:
            return False
        return super().worth_fitting(candidate, state, best, simple)

    def of_differences(self, parameters: dict[str, Any]) -> bool:
        return len(parameters["phi"]) == 1

    def most_sure(self, parameters: dict[str, Any], beside: list[Effect], shared: float) -> float:
        return SLOPE_BESIDE_FILTER if any(e.rolls_off for e in beside) else 1.0

    def beside(self, low_pass: LowPass | None, fs: float) -> bool:
        # a resonance of the samples has no spectrum at a filter's inner rate
        return low_pass is None or low_pass.rate == fs

    def grid(self, fs: float, duration: float) -> list[Any]:
        return [
            Process(phi=(2 * r * np.cos(w), -r * r), sigma=np.sqrt(1 - r * r), rate=fs)
            for r in (0.7, 0.9, 0.97, 0.99)
            for w in np.linspace(0.08, 0.95, 12) * np.pi
        ]

    def slot(self, index: int, fs: float, duration: float) -> Slot:
        return Resonance(
            index,
            ("sigma", "damping", "frequency"),
            (-60.0, np.log(5e-4), np.log(0.02)),
            (30.0, np.log(1.5), np.log(0.98 * np.pi)),
            (AMPLITUDE_WIDTH, np.log(1e3), np.log(50.0)),
        )


class FirstOrder(Autoregressive):
    """Noise whose neighbours are anticorrelated; where they are correlated it is a quick
    Gauss-Markov process.
    """

    cause = "The sensor's loop overshoots from sample to sample, or a filter sharpens its output."
    rarity = 2.0
    simple = True

    def grid(self, fs: float, duration: float) -> list[Any]:
        return [
            Process(phi=(-r,), sigma=np.sqrt(1 - r * r), rate=fs)
            for r in (0.3, 0.45, 0.6, 0.75, 0.9, 0.97)
        ]

    def slot(self, index: int, fs: float, duration: float) -> Slot:
        # with a coefficient near zero it would be white noise by another name
        return Alternating(
            index,
            ("sigma", "damping"),
            (-60.0, np.log(5e-4)),
            (30.0, np.log(-np.log(0.25))),
            (AMPLITUDE_WIDTH, np.log(1e3)),
        )


EFFECTS = (FirstOrder(), Autoregressive())
