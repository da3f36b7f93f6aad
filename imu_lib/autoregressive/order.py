"""Choosing the order: Schwarz, Akaike, final prediction error, description length, and the knee."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from imu_lib.autoregressive.stepwise import Stepwise, stepwise


@dataclass(frozen=True)
class OrderChoice:
    """Criteria of the orders 0 ... p_max, each to be minimised, and the order each of them picks.

    Parameters
    ----------
    sbc, aic, fpe, mdl : ndarray, shape (p_max + 1,)
        See `choose_order`.
    residual_variance : ndarray, shape (p_max + 1,)
        Of one variable; the m-th root of the determinant for m of them.
    orders : dict
        The order that each criterion picks: "sbc", "aic", "fpe", "mdl", "knee".
    n : int
        Samples that every order was fitted to.
    steps : Stepwise
        The fits themselves: `steps.fit(order)`.
    """

    sbc: np.ndarray
    aic: np.ndarray
    fpe: np.ndarray
    mdl: np.ndarray
    residual_variance: np.ndarray
    orders: dict[str, int]
    n: int
    steps: Stepwise


def choose_order(v, max_order=20, *, knee_tolerance=0.01) -> OrderChoice:
    """Order of an autoregressive model by five criteria, all orders fitted to the same samples in
    one pass.

    Parameters
    ----------
    v : array_like, shape (n,) or (n, m)
    max_order : int
    knee_tolerance : float
        See `knee`.

    Notes
    -----
    With N samples, m variables, n_p = m p + 1 predictors and the residual cross-products Delta_p:

    * SBC(p) = ln det(Delta_p) / m - (1 - n_p / N) ln N: Eq. 4 of the 2011 paper, as ARfit has
      it. Delta_p is a sum, not a mean, and the whole is per sample and variable: ln det(C_p) / m +
      n_p ln(N) / N with C_p = Delta_p / N. On seven hours at 100 Hz one more coefficient costs
      6e-6, so the curve must not be rounded before its minimum is taken.
    * AIC(p) = N ln det(C_p) / m + 2 n_p, per variable.
    * FPE(p) = det(C_p)^(1/m) (N + n_p) / (N - n_p).
    * MDL(p) = N ln det(C_p) / (2 m) + n_p ln(N) / 2: Rissanen's two-part length of the record,
      nats per variable. It is
      N / 2 times SBC plus a constant: the two always pick the same order.
    """
    return choose(stepwise(v, max_order), max_order, knee_tolerance=knee_tolerance)


def choose(steps: Stepwise, max_order, *, knee_tolerance=0.01) -> OrderChoice:
    """`choose_order` on fits that are there."""
    n, m = steps.n, steps.m
    predictors = m * np.arange(max_order + 1) + 1
    log_det = np.linalg.slogdet(steps.cross_products())[1] / m
    sbc = log_det - (1 - predictors / n) * np.log(n)
    log_variance = log_det - np.log(n)
    aic = n * log_variance + 2 * predictors
    fpe = np.exp(log_variance) * (n + predictors) / (n - predictors)
    mdl = 0.5 * n * log_variance + 0.5 * predictors * np.log(n)
    variance = np.exp(log_variance)
    orders = {
        name: int(np.argmin(c))
        for name, c in (("sbc", sbc), ("aic", aic), ("fpe", fpe), ("mdl", mdl))
    }
    orders["knee"] = knee(variance, tolerance=knee_tolerance)
    return OrderChoice(sbc, aic, fpe, mdl, variance, orders, n, steps)


def knee(residual_variance, *, tolerance=0.01) -> int:
    """Order at which the residual variance has levelled out (Park and Gao 2008, Figs. 12 and 13),
    without an eye.

    The first order from which no higher one tried lowers the variance by more than `tolerance` of
    itself. Unlike a criterion it asks what a coefficient is worth, not whether it is real; the
    answer moves with the tolerance.
    """
    variance = np.asarray(residual_variance, dtype=float)
    best_beyond = np.minimum.accumulate(variance[::-1])[::-1]
    return int(np.argmax(variance - best_beyond <= tolerance * variance))
