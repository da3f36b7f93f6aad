"""Burg, Yule-Walker and least squares."""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_toeplitz

from imu_lib.autoregressive.model import ARModel
from imu_lib.autoregressive.stepwise import stepwise

METHODS = ("burg", "yule_walker", "least_squares")


def fit(x, order, *, method="burg") -> ARModel:
    """Autoregressive model of a given order.

    Parameters
    ----------
    x : array_like, shape (n,)
    order : int
    method : {"burg", "yule_walker", "least_squares"}
        Burg minimises the forward and backward prediction errors order by order and is always
        stable (statsmodels' recursion). Yule-Walker solves for the biased sample autocovariances,
        also stable, but pulled towards zero where poles are near the unit circle. Least squares
        regresses on the past with an intercept (2011 paper, Eqs. 5-7) and may be unstable. On long
        records the three agree, as the 2008 paper found.

    Raises
    ------
    ValueError
        On a record too short for the order, non-finite samples or an unknown method.
    """
    if method not in METHODS:
        raise ValueError(f"`method` must be one of {', '.join(METHODS)}, not {method!r}")
    x = checked(x, order)
    if method == "burg":
        return burg(x, order)[-1]
    if method == "yule_walker":
        return yule_walker(x, order)
    return stepwise(x, order).fit(order)


def burg(x, order) -> list[ARModel]:
    """Burg's models of order 0 to `order`, from one pass; equal to
    `statsmodels.regression.linear_model.burg`.
    """
    from statsmodels.tsa.stattools import pacf_burg

    x = checked(x, order)
    mean = x.mean()
    centred = x - mean
    models = [ARModel(np.zeros(0), float(centred.std()), float(mean), x.size, "burg")]
    if order == 0:
        return models
    reflection, variance = pacf_burg(centred, order, demean=False)[:2]
    phi = np.zeros(0)
    for k in range(1, order + 1):
        phi = np.concatenate([phi - reflection[k] * phi[::-1], [reflection[k]]])
        models.append(ARModel(phi, float(np.sqrt(variance[k])), float(mean), x.size, "burg"))
    return models


def yule_walker(x, order) -> ARModel:
    """Yule-Walker with the sums of products divided by n; equal to statsmodels'
    `yule_walker(method="mle")`.
    """
    x = checked(x, order)
    centred = x - x.mean()
    gamma = np.array([centred[: x.size - k] @ centred[k:] for k in range(order + 1)]) / x.size
    phi = solve_toeplitz(gamma[:-1], gamma[1:]) if order else np.zeros(0)
    return ARModel(
        phi, float(np.sqrt(gamma[0] - phi @ gamma[1:])), float(x.mean()), x.size, "yule_walker"
    )


def checked(x, order) -> np.ndarray:
    """The record as floats, long enough for the order."""
    x = np.asarray(x, dtype=float)
    if int(order) != order or order < 0:
        raise ValueError(f"`order` must be a whole number, 0 or more, not {order!r}")
    if x.ndim != 1 or x.size < 3 * (order + 1) + 2:
        raise ValueError(
            f"`x` must have shape (n,) with n of {3 * (order + 1) + 2} or more for order {order}, "
            f"not {x.shape}"
        )
    if not np.all(np.isfinite(x)):
        raise ValueError("`x` holds samples that are not finite: take a gap-free stretch")
    if not np.any(x != x[0]):
        raise ValueError("`x` does not vary: there is nothing to fit")
    return x
