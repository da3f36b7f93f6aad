"""The catalogue: one small file for each effect, found by itself; a file lists its own in
`EFFECTS`.

Files of one's own, in folders named by the environment variable `IMU_LIB_EFFECTS`, count as if they
were here.
"""

import os
from importlib import import_module
from pkgutil import iter_modules

from .base import ChannelEffect, ChannelView, Effect, Finding, SignalEffect
from .competitor import Competitor, Spectral
from .drift import Drift

__path__ += [
    os.path.abspath(p) for p in os.environ.get("IMU_LIB_EFFECTS", "").split(os.pathsep) if p
]

#: Every effect, in the order of `Effect.order` and its file's name.
ALL = tuple(
    sorted(
        (
            effect
            for module in iter_modules(__path__)
            for effect in getattr(import_module(f"{__name__}.{module.name}"), "EFFECTS", ())
        ),
        key=lambda effect: effect.order,
    )
)
#: What competes for the model of a channel.
COMPETITORS = tuple(e for e in ALL if isinstance(e, Competitor))
#: Noises known by their spectrum.
SPECTRAL = tuple(e for e in ALL if isinstance(e, Spectral))
#: Functions of time or temperature.
DRIFTS = tuple(e for e in ALL if isinstance(e, Drift))
#: What is taken out of a channel as a signal.
SIGNALS = tuple(e for e in ALL if isinstance(e, SignalEffect))
#: What acts on the noise of a channel.
CHANNEL = tuple(e for e in ALL if isinstance(e, ChannelEffect))
#: By name; where several effects have one name, the last.
CATALOGUE = {effect.name: effect for effect in ALL}

__all__ = [
    "ALL",
    "CATALOGUE",
    "CHANNEL",
    "COMPETITORS",
    "ChannelEffect",
    "ChannelView",
    "Competitor",
    "DRIFTS",
    "Drift",
    "Effect",
    "Finding",
    "SIGNALS",
    "SPECTRAL",
    "SignalEffect",
    "Spectral",
]
