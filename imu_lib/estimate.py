"""An estimated quantity with its 95 % interval."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

#: Two-sided 95 % point of the standard normal distribution.
Z95 = 1.959963984540054


@dataclass(frozen=True)
class Estimate:
    """A value and its 95 % interval, in the SI unit of the quantity.

    Parameters
    ----------
    value : float or None
        The estimate; None where the record does not show the quantity. Then `low` is 0
        and `high` is the 95 % upper limit.
    low, high : float
        The ends of the interval.
    """

    value: float | None
    low: float
    high: float

    @classmethod
    def absent(cls, high: float = math.inf) -> Estimate:
        """A quantity that the record does not show, with its 95 % upper limit."""
        return cls(None, 0.0, float(high))

    @classmethod
    def normal(cls, value: float, sd: float) -> Estimate:
        """Value and interval from a normal standard deviation."""
        return cls(float(value), float(value - Z95 * sd), float(value + Z95 * sd))

    @classmethod
    def lognormal(cls, value: float, relative_sd: float) -> Estimate:
        """Value and interval of a positive quantity whose logarithm has `relative_sd`."""
        factor = math.exp(min(Z95 * relative_sd, 700.0))
        return cls(float(value), float(value / factor), float(value * factor))

    @property
    def shown(self) -> bool:
        """Whether the record shows the quantity at all."""
        return self.value is not None

    def covers(self, truth: float) -> bool:
        """Whether the interval holds `truth`."""
        return bool(self.low <= truth <= self.high)

    def scaled(self, factor: float) -> Estimate:
        """The same estimate in another unit (`factor` > 0)."""
        value = None if self.value is None else self.value * factor
        return Estimate(value, self.low * factor, self.high * factor)

    def __format__(self, spec: str) -> str:
        """`value [low, high]`, each number in `spec` (four digits by default); `< high` where
        there is no value.
        """
        value, low, high = (
            None if v is None else format(v, spec or ".4g")
            for v in (self.value, self.low, self.high)
        )
        return f"{value} [{low}, {high}]" if self.shown else f"< {high}"

    def to_json(self) -> dict[str, float | None]:
        """`{"value", "low", "high"}` with numbers that JSON can hold (infinity becomes None)."""
        return {
            key: None if v is None or not np.isfinite(v) else float(v)
            for key, v in (("value", self.value), ("low", self.low), ("high", self.high))
        }
