"""The innovations of the fixes: what was measured minus what the filter predicted, with the
covariance that it gave.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import measurement

#: A model that rejects a larger share of the fixes than this is lost: it is not ranked.
LOST = 0.2


@dataclass(frozen=True)
class Innovations:
    """One row per fix (two where position and velocity of a fix are taken at different times).

    index (f,) row of the drive's `gnss_*`; time (f,) s at which the fix was taken, on the IMU's
    clock; bits (f,) of `measurement` value (f, 6) measured minus predicted, NED m and m/s;
    covariance (f, 6, 6); both NaN where the part was not offered (`used`: and passed) normalised
    (f, 6) whitened one after the other, predicted minus measured, NaN where not used; nis, freedom
    (f,) log_likelihood (f,) nats; velocity (f, 3) NED of the filter before the fix
    """

    index: np.ndarray
    time: np.ndarray
    bits: np.ndarray
    value: np.ndarray
    covariance: np.ndarray
    normalised: np.ndarray
    nis: np.ndarray
    freedom: np.ndarray
    log_likelihood: np.ndarray
    velocity: np.ndarray

    @classmethod
    def of(cls, index, time, use, logs):
        """From the kernel's logs and what was offered."""
        part = np.repeat(
            [(use & measurement.POSITION) > 0, (use & measurement.VELOCITY) > 0], 3, axis=0
        ).T
        both = part[:, :, None] & part[:, None, :]
        return cls(
            index,
            time,
            logs.bits,
            np.where(part, -logs.innovation, np.nan),
            np.where(both, logs.covariance, np.nan),
            logs.normalised,
            logs.nis,
            logs.freedom,
            logs.likelihood,
            logs.velocity,
        )

    @classmethod
    def join(cls, pieces):
        return cls(*(np.concatenate([getattr(p, k) for p in pieces]) for k in cls.__annotations__))

    @property
    def position(self):
        """Whether the position was used, (f,)."""
        return (self.bits & measurement.POSITION) > 0

    @property
    def velocity_used(self):
        """Whether the velocity was used, (f,)."""
        return (self.bits & measurement.VELOCITY) > 0

    @property
    def rejected(self):
        """Whether a part of the fix failed the innovation test, (f,)."""
        both = measurement.REJECTED_POSITION | measurement.REJECTED_VELOCITY
        return (self.bits & both) > 0

    @property
    def speed(self):
        """Horizontal speed of the filter, (f,) m/s."""
        return np.hypot(self.velocity[:, 0], self.velocity[:, 1])

    @property
    def course(self):
        """Direction of motion of the filter, (f,) rad."""
        return np.arctan2(self.velocity[:, 1], self.velocity[:, 0])

    def notes(self):
        """Sentences on fixes that failed the innovation test."""
        out, offered = [], int(np.isfinite(self.value).any(axis=1).sum())
        for flag, what in (
            (measurement.REJECTED_POSITION, "positions"),
            (measurement.REJECTED_VELOCITY, "velocities"),
        ):
            count = int(((self.bits & flag) > 0).sum())
            if count:
                out.append(
                    f"{count} of {offered} fixes had their {what} rejected by the innovation test."
                )
        recovered = (self.bits & measurement.RECOVERED) > 0
        if recovered.any():
            out.append(
                f"The covariance was widened {int(recovered.sum())} times because the fixes kept "
                f"disagreeing with the filter, first at {self.time[np.argmax(recovered)]:.1f} s."
            )
        return out

    def along_cross(self):
        """(value (f, 6), covariance (f, 6, 6)) along the track, across it to the right, and down:
        m, m/s.
        """
        turn = np.zeros((self.time.size, 6, 6))
        cos, sin = np.cos(self.course), np.sin(self.course)
        for k in (0, 3):
            turn[:, k, k], turn[:, k, k + 1] = cos, sin
            turn[:, k + 1, k], turn[:, k + 1, k + 1] = -sin, cos
            turn[:, k + 2, k + 2] = 1.0
        shown = np.isfinite(self.value)
        value = np.einsum("fij,fj->fi", turn, np.where(shown, self.value, 0.0))
        inner = np.where(np.isfinite(self.covariance), self.covariance, 0.0)
        covariance = np.einsum("fij,fjk,flk->fil", turn, inner, turn)
        return (
            np.where(shown, value, np.nan),
            np.where(shown[:, :, None] & shown[:, None, :], covariance, np.nan),
        )

    def total(self, keep=None):
        """Log-likelihood, nats, of the fixes; keep : bool over the rows of the drive's `gnss_*`,
        the same for all that are compared.
        """
        if keep is None:
            return float(self.log_likelihood.sum())
        return float(self.log_likelihood[np.asarray(keep, bool)[self.index]].sum())
