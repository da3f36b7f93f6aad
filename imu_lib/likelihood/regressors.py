"""Mean shapes against a record, band by band: what a fit of their amplitudes needs."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from imu_lib.arrays import Array


@dataclass(frozen=True)
class Regressors:
    """Per band: `gram` (b, q, q) and `cross` (b, q) of q mean shapes with each other and with the
    record.
    """

    gram: Array = field(repr=False)
    cross: Array = field(repr=False)

    def solve(self, expected: Array) -> tuple[Array, Array]:
        """Amplitudes (q,) by generalised least squares under `expected` (b,), and their covariance
        (q, q).
        """
        information = np.einsum("bij,b->ij", self.gram, 1 / expected)
        covariance = np.linalg.pinv(information, hermitian=True)
        return covariance @ (self.cross.T @ (1 / expected)), covariance

    def remaining(self, power: Array, amplitudes: Array) -> Array:
        """Power per band once the shapes are taken out."""
        gone = 2 * self.cross @ amplitudes - np.einsum(
            "bij,i,j->b", self.gram, amplitudes, amplitudes
        )
        return np.maximum(power - gone, 0.0)
