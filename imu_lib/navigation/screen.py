"""What each parameter of the drive would gain, from one run in which all of them are states.

The posterior of the parameters, divided by their prior, is their likelihood: information Lambda =
P^-1 - P0^-1 and score b = P^-1 x at the held values, with navigation and biases integrated out. A
subset A alone, the others at their held values, then gains b_A' Lambda_AA^-1 b_A / 2 (the score
test of Rao 1948, written for a filter).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .free import GROUPS


@dataclass(frozen=True)
class Screen:
    """Scores of parameters: names ("accel_scale x", ...), estimate, sd, prior_sd (k,), information
    (k, k), score (k,).
    """

    names: tuple
    estimate: np.ndarray
    sd: np.ndarray
    prior_sd: np.ndarray
    information: np.ndarray
    score: np.ndarray

    @classmethod
    def of(cls, names, x, p, prior):
        """Of the sensor states at the end of a run, and their covariance at its start."""
        index = [i for i, n in enumerate(names) if n.split(" ")[0] in GROUPS]
        size = np.sqrt(np.diag(prior)[index])
        index, size = np.array(index, int)[size > 0.0], size[size > 0.0]
        inside = np.ix_(index, index)
        scaled = p[inside] / np.outer(size, size)
        inverse = np.linalg.inv(0.5 * (scaled + scaled.T))
        information = (inverse - np.eye(index.size)) / np.outer(size, size)
        score = inverse @ (x[index] / size) / size
        return cls(
            tuple(names[i] for i in index),
            x[index],
            np.sqrt(np.maximum(np.diag(p)[index], 0.0)),
            size,
            information,
            score,
        )

    def index(self, subset):
        """Positions of a subset: names of groups, of single states, or both."""
        subset = (subset,) if isinstance(subset, str) else tuple(subset)
        found = [i for i, n in enumerate(self.names) if n in subset or n.split(" ")[0] in subset]
        if not found:
            raise ValueError(f"none of {subset} was a state of the run")
        return np.array(found)

    def fit(self, subset):
        """(value (k,), sd (k,)) of a subset alone, the other parameters at their held values; the
        prior counts, so that what the drive does not show stays near nothing with its prior sd.
        """
        i = self.index(subset)
        precision = self.information[np.ix_(i, i)] + np.diag(self.prior_sd[i] ** -2.0)
        covariance = np.linalg.inv(precision)
        return covariance @ self.score[i], np.sqrt(np.diag(covariance))

    def gain(self, subset):
        """Nats that a subset alone would gain (at the value of `fit`)."""
        i = self.index(subset)
        value, _ = self.fit(subset)
        return float(value @ self.score[i] - 0.5 * value @ self.information[np.ix_(i, i)] @ value)
