"""The catalogue: one small class in one file for each effect."""

from .autoregressive import Autoregressive, FirstOrder
from .base import Drift, Effect, Finding, Spectral
from .flicker import Flicker
from .gauss_markov import GaussMarkov
from .gauss_markov_2 import GaussMarkov2
from .low_pass import LowPass
from .noise_level_change import NoiseLevelChange
from .quantization import Quantization
from .ramp import Ramp
from .random_walk import RandomWalk
from .resolution import Resolution
from .saturation import Saturation
from .sinusoid import Sinusoid
from .slow_sinusoid import SlowSinusoid
from .spikes import Spikes
from .step import Step
from .stuck import Stuck
from .telegraph import Telegraph
from .temperature import Temperature
from .warm_up import WarmUp
from .white_noise import WhiteNoise

#: Noises known by their spectrum.
SPECTRAL = (
    WhiteNoise(),
    Quantization(),
    Flicker(),
    RandomWalk(),
    GaussMarkov(),
    GaussMarkov2(),
    FirstOrder(),
    Autoregressive(),
)
#: Functions of time or temperature.
DRIFTS = (Ramp(), WarmUp(), Temperature(), Step(), SlowSinusoid())
#: What is found by means of its own.
OTHERS = (
    Sinusoid(),
    Telegraph(),
    LowPass(),
    NoiseLevelChange(),
    Spikes(),
    Saturation(),
    Resolution(),
    Stuck(),
)
CATALOGUE = {effect.name: effect for effect in SPECTRAL + DRIFTS + OTHERS}

__all__ = ["CATALOGUE", "DRIFTS", "Drift", "Effect", "Finding", "OTHERS", "SPECTRAL", "Spectral"]
