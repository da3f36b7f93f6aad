"""A sampling clock that is off."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from imu_lib.arrays import Array, ArrayLike

from .base import FREE, Parameter, Process


@dataclass(frozen=True)
class RateError(Process):
    """The samples are taken at `ratio` times the stated rate, while stamps and file say the rate.

    Parameters
    ----------
    ratio : float, true rate over the stated one
    """

    ratio: float = FREE
    name: ClassVar[str] = "rate_error"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("ratio", "ratio", "true rate over the stated one"),
    )

    def true(self, time: ArrayLike) -> Array:
        """True times, s, of stamps that follow the stated rate, same shape."""
        self._require()
        return np.asarray(time, dtype=float) / self.ratio

    def paced(self, channel: Any) -> Any:
        """A channel's `Sum` with its digital filter and difference equations at the true rate:
        they step with the samples.
        """
        self._require()
        if self.ratio == 1.0:
            return channel
        out = []
        for process in channel:
            faster = {"rate": process.rate * self.ratio} if _stepped(process) else {}
            if faster and getattr(process, "cutoff", None):
                faster["cutoff"] = process.cutoff * self.ratio
            out.append(process.with_(**faster))
        return type(channel).of(out)


def _stepped(process: Any) -> bool:
    """Whether a process runs sample by sample, at a rate of its own."""
    return process.name in ("low_pass", "autoregressive") and process.rate is not None
