"""What the filter gives back: the navigation solution, what it knew at some moments, and the
innovations of the fixes.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .innovations import Innovations
from .screen import Screen


@dataclass(frozen=True)
class Moments:
    """What the filter knew at some epochs of one stretch: enough to run on from each.

    stretch : index; epoch (k,); time (k,) s; nav (k, 16), x (k, m), p (k, 9+m, 9+m), road (k, 4)
    as in `structures.State`;
    prior, phi, dx : for the smoother, else empty
    """

    stretch: int
    epoch: np.ndarray
    time: np.ndarray
    nav: np.ndarray
    x: np.ndarray
    p: np.ndarray
    road: np.ndarray
    prior: np.ndarray
    phi: np.ndarray
    dx: np.ndarray


@dataclass(frozen=True)
class Solution:
    """A navigation solution: epochs of all stretches one after the other.

    time (n,) s; position (n, 3); velocity (n, 3); attitude (n, 3) of the vehicle; sd (n, 9) m,
    m/s, rad; north_east (n,) covariance of position, m^2;
    innovations : Innovations of the fixes; moments : tuple of Moments; alignments : tuple of
    Alignment; states : number of filter states; names of the sensor states; x (m,), p (m, m), prior
    (m, m) of them at the end and the start
    """

    name: str
    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    attitude: np.ndarray
    sd: np.ndarray
    north_east: np.ndarray
    innovations: Innovations
    moments: tuple
    alignments: tuple
    states: int
    names: tuple
    x: np.ndarray
    p: np.ndarray
    prior: np.ndarray
    notes: tuple = field(default=())

    @property
    def fix_time(self):
        """Times at which the fixes were taken, (f,) s."""
        return self.innovations.time

    @property
    def innovation(self):
        """Normalised innovations, (f, 6), NaN where not used."""
        return self.innovations.normalised

    @property
    def nis(self):
        """Normalised innovation squared, (f,)."""
        return self.innovations.nis

    @property
    def freedom(self):
        """Degrees of freedom of `nis`, (f,)."""
        return self.innovations.freedom

    @property
    def bits(self):
        """What became of each fix, (f,), bits of `measurement`."""
        return self.innovations.bits

    def at(self, time):
        """Position (k, 3) at times within the solution, by straight lines between epochs."""
        return np.column_stack([np.interp(time, self.time, column) for column in self.position.T])

    def estimates(self):
        """Name of a state -> (value, standard deviation) at the end of the drive."""
        sd = np.sqrt(np.maximum(np.diag(self.p), 0.0))
        return {n: (float(v), float(s)) for n, v, s in zip(self.names, self.x, sd)}

    def screen(self) -> Screen:
        """Scores of the parameters that were states of the run (`FilterModel.free`)."""
        return Screen.of(self.names, self.x, self.p, self.prior)

    def sensor_error(self, channel_first):
        """Estimated error of each channel at the stored moments: (time (k,), error (k, 6))."""
        first, output = channel_first
        time = np.concatenate([m.time for m in self.moments])
        x = np.vstack([m.x for m in self.moments])
        return time, np.column_stack(
            [x[:, first[c] : first[c + 1]] @ output[first[c] : first[c + 1]] for c in range(6)]
        )
