"""An error model as the filter takes it: with what is held of the drive, what is estimated along,
and what is known of the vehicle.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from imu_lib.model import TURN_ON, Model

from .free import GROUPS, priors
from .held import Held
from .preparation import Speed

__all__ = ["GROUPS", "FilterModel", "priors"]


@dataclass(frozen=True)
class FilterModel:
    """An error model as a filter takes it.

    model : Model; its `drive` is held; levels, causal : wavelet de-noising before the
    mechanization (see `preparation.prepare`)
    turn_on_sd : bias left at switch-on, gyro rad/s and accelerometer m/s^2, put to the slowest
    state of each channel, or, where `constant`, to one that does not forget it
    scale_sd : standard deviation of scale factor states (0: none); flicker : see
    `states.sensor_states`
    constraint_sd : m/s of velocity across the vehicle's axis; 0 leaves the vehicle constraint off
    (it is knowledge about the car, not about the sensor)
    effects : DriveEffects held as well, after those of the model (of two alike the later holds)
    speed : preparation.Speed of the wheels, used in outages too; None without
    free : parameters estimated as states, about what is held: group of `free.GROUPS` -> standard
    deviation (see `free.priors`)
    """

    name: str
    model: Model
    levels: object = None
    causal: object = False
    turn_on_sd: tuple = (0.0, 0.0)
    scale_sd: tuple = (0.0, 0.0)
    flicker: str = "refuse"
    constraint_sd: float = 0.0
    constant: bool = False
    effects: tuple = ()
    speed: Speed | None = None
    free: Mapping = field(default_factory=dict)

    def __post_init__(self):
        priors(*self.free)

    @classmethod
    def of(cls, model: Model, **changes):
        """A model as it stands: the bias at switch-on that it states, else 0.1 deg/s and 0.05
        m/s^2, kept as a constant; flicker noise as Gauss-Markov processes.
        """
        turn_on = tuple(TURN_ON.values()) if model.turn_on is None else model.turn_on
        usual = {"turn_on_sd": turn_on, "constant": True, "flicker": "markov"}
        return cls(**{"name": model.name or "model", "model": model, **usual, **changes})

    def with_(self, **changes):
        return replace(self, **changes)

    @property
    def held(self) -> Held:
        """What is held of the drive."""
        return Held.of((*self.model.drive, *self.effects))
