"""Means of values that are known to different errors and scatter beside them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Pooled:
    """Weighted means, one for each choice of values.

    Attributes
    ----------
    mean, error : ndarray, shape (m,)
        And its standard error.
    between : ndarray, shape (m,)
        Variance of the values beside their errors.
    robust : ndarray, shape (m,)
        The mean's standard error from how the values lie about it (Hartung and Knapp).
    """

    mean: np.ndarray
    error: np.ndarray
    between: np.ndarray
    robust: np.ndarray


def pooled(y, s, taken=None) -> Pooled:
    """Means of values y with standard errors s, both (n,), under Paule and Mandel's scatter: the
    weighted sum of squares about the mean is its number of degrees of freedom.

    Parameters
    ----------
    taken : ndarray of bool, shape (m, n), optional
        The values of each mean, two or more; default one mean of all.

    References
    ----------
    Paule and Mandel 1982, J. Res. NBS 87, 377.
    """
    taken = np.ones((1, y.size), bool) if taken is None else taken
    freedom = taken.sum(axis=1) - 1
    between = np.zeros(len(taken))
    for _ in range(100):
        weight = np.where(taken, 1 / (between[:, None] + s**2), 0.0)
        mean = weight @ y / weight.sum(axis=1)
        squares = weight * (y - mean[:, None]) ** 2
        # the sum falls with the scatter and is convex: Newton's steps come from one side
        slope = np.maximum((squares * weight).sum(axis=1), 1e-300)
        new = np.maximum(between + (squares.sum(axis=1) - freedom) / slope, 0.0)
        done = np.all(np.abs(new - between) <= 1e-10 * (new + np.min(s) ** 2))
        between = new
        if done:
            break
    total = weight.sum(axis=1)
    robust = np.sqrt(squares.sum(axis=1) / freedom / total)
    return Pooled(mean, 1 / np.sqrt(total), between, robust)
