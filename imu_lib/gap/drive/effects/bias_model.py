"""`bias_model`: see `cause`."""

from __future__ import annotations

from .base import Effect


class BiasModel(Effect):
    name = "bias_model"
    cause = "A parameter of the sensor's error model is off."
    words = "innovations grow between fixes as the channel's errors would"


EFFECT = BiasModel()
