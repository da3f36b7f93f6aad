"""Stepwise least squares over all orders in one pass, one or several variables (Neumaier and
Schneider 2001).

All orders 0 ... p_max are fitted to the same samples, those that have p_max predecessors. One QR
factorisation of [1, v_{k-1}, ..., v_{k-p_max}, v_k] holds them all: with R = [[R11, R12], [0,
R22]], the residual cross-product matrix of order p is R22' R22 plus the rows of R12 beyond the
first n_p = m p + 1, and the coefficients of order p solve the leading triangle. Where the problem
is well conditioned R comes from the moment matrices (2011 paper, Eq. 5), else from a QR over the
record in pieces, each stacked under the triangle so far, so memory does not grow with the record.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr, solve_triangular

from imu_lib.autoregressive.model import ARModel

_ROWS = 32_768


@dataclass(frozen=True)
class VectorARModel:
    """v_k = intercept + sum_i A_i v_{k-i} + e_k, with covariance C of e (2011 paper, Eqs. 1-7).

    Parameters
    ----------
    intercept : ndarray, shape (m,)
    A : ndarray, shape (p, m, m)
    C : ndarray, shape (m, m)
        Residual cross-products over N - n_p (Eq. 7).
    A_sd : ndarray, shape (p, m, m)
        Standard deviations of the coefficients.
    n : int
        Samples that the fit used.
    """

    intercept: np.ndarray
    A: np.ndarray
    C: np.ndarray
    A_sd: np.ndarray
    n: int

    @property
    def order(self) -> int:
        return len(self.A)

    @property
    def poles(self) -> np.ndarray:
        """Eigenvalues of the companion matrix, shape (m p,)."""
        p, m = self.A.shape[:2]
        if not p:
            return np.zeros(0, dtype=complex)
        companion = np.eye(m * p, k=-m)
        companion[:m] = self.A.transpose(1, 0, 2).reshape(m, m * p)
        return np.linalg.eigvals(companion)

    @property
    def stable(self) -> bool:
        """Whether all poles are inside the unit circle."""
        return bool(np.all(np.abs(self.poles) < 1))

    def residuals(self, v) -> np.ndarray:
        """One-step prediction errors of `v`, shape (n, m), as (n - p, m)."""
        v = np.asarray(v, dtype=float)
        p = self.order
        out = v[p:] - self.intercept
        for i in range(p):
            out = out - v[p - 1 - i : len(v) - 1 - i] @ self.A[i].T
        return out


@dataclass(frozen=True)
class Stepwise:
    """All orders 0 ... p_max at once.

    Parameters
    ----------
    R : ndarray, shape (m p_max + 1 + m, m p_max + 1 + m)
        Triangular factor.
    n : int
        Equations, N - p_max.
    m : int
        Variables.
    shift, scale : ndarray, shape (m,)
        Taken off and divided by before the factorisation, for its conditioning.
    """

    R: np.ndarray
    n: int
    m: int
    shift: np.ndarray
    scale: np.ndarray

    @property
    def max_order(self) -> int:
        return (len(self.R) - 1 - self.m) // self.m

    def cross_products(self) -> np.ndarray:
        """Residual cross-product matrices Delta_p of order 0 ... p_max, shape (p_max + 1, m, m)."""
        right = self.R[:, -self.m :]
        tails = [right[self.m * p + 1 :] for p in range(self.max_order + 1)]
        return np.array([t.T @ t for t in tails]) * np.outer(self.scale, self.scale)

    def residual_variance(self) -> np.ndarray:
        """Residual variance of each order, Delta_p / n (of the first variable), shape (p_max +
        1,).
        """
        return self.cross_products()[:, 0, 0] / self.n

    def vector_fit(self, order) -> VectorARModel:
        """The model of one order."""
        m, k = self.m, self.m * order + 1
        triangle = self.R[:k, :k]
        B = solve_triangular(triangle, self.R[:k, -m:])
        C = self.cross_products()[order] / (self.n - k)
        inverse = solve_triangular(triangle, np.eye(k))
        spread = np.sqrt(np.outer(np.sum(inverse**2, axis=1), np.diag(C) / self.scale**2))
        ratio = self.scale[:, None] / self.scale  # row variable over column variable
        A = B[1:].reshape(order, m, m).transpose(0, 2, 1) * ratio
        A_sd = spread[1:].reshape(order, m, m).transpose(0, 2, 1) * ratio
        intercept = self.shift + B[0] * self.scale - (A @ self.shift).sum(axis=0)
        return VectorARModel(intercept, A, C, A_sd, self.n)

    def fit(self, order) -> ARModel:
        """The model of one order, one variable."""
        if self.m != 1:
            raise ValueError("`vector_fit` is the one for several variables")
        model = self.vector_fit(order)
        phi = model.A[:, 0, 0]
        gap = 1 - phi.sum()
        mean = model.intercept[0] / gap if abs(gap) > 1e-12 else self.shift[0]
        return ARModel(phi, float(np.sqrt(model.C[0, 0])), float(mean), self.n, "least_squares")


def stepwise(v, max_order) -> Stepwise:
    """Least squares of every order up to `max_order`.

    Parameters
    ----------
    v : array_like, shape (n,) or (n, m)
    max_order : int

    Raises
    ------
    ValueError
        On fewer samples than coefficients, or non-finite samples.
    """
    v = np.asarray(v, dtype=float)
    v = v[:, None] if v.ndim == 1 else v
    n, m = v.shape
    width = m * max_order + 1 + m
    if n - max_order < 2 * width:
        raise ValueError(f"`v` has {n} samples, too few for order {max_order} of {m} variables")
    if not np.all(np.isfinite(v)):
        raise ValueError("`v` holds samples that are not finite: take a gap-free stretch")
    shift, scale = v.mean(axis=0), v.std(axis=0)
    if np.any(scale == 0):
        raise ValueError("`v` has a variable that does not vary")
    v = (v - shift) / scale
    R = _triangle_from_products(v, max_order)
    return Stepwise(
        _triangle_by_qr(v, max_order) if R is None else R, n - max_order, m, shift, scale
    )


def _triangle_by_qr(v, p):
    """R of [1, v_{k-1}, ..., v_{k-p}, v_k], the record taken in pieces."""
    n, m = v.shape
    width = m * p + 1 + m
    R = np.zeros((0, width))
    for start in range(p, n, _ROWS):
        stop = min(n, start + _ROWS)
        rows = [
            np.ones((stop - start, 1)),
            *(v[start - i : stop - i] for i in range(1, p + 1)),
            v[start:stop],
        ]
        R = qr(np.vstack([R, np.hstack(rows)]), mode="r", overwrite_a=True, check_finite=False)[0][
            :width
        ]
    return R


def _triangle_from_products(v, p):
    """The same as the Cholesky factor of the moment matrix, or None where that would lose digits.

    The products of lags i + 1 and j + 1 are those of i and j shifted by one sample, so p + 1 sums
    over the record give them all. Squaring the matrix squares its condition: smooth series
    (de-noised ones) go to the QR.
    """
    n, m = v.shape
    blocks = np.empty(
        (p + 1, p + 1, m, m)
    )  # [i, j]: sum over k of v_{k-i} v_{k-j}', k = p ... n - 1
    for j in range(p + 1):
        blocks[0, j] = v[p:].T @ v[p - j : n - j]
        blocks[j, 0] = blocks[0, j].T
    for i in range(p):
        for j in range(p):
            blocks[i + 1, j + 1] = (
                blocks[i, j]
                + np.outer(v[p - 1 - i], v[p - 1 - j])
                - np.outer(v[n - 1 - i], v[n - 1 - j])
            )
    order = [*range(1, p + 1), 0]
    moments = blocks[np.ix_(order, order)].transpose(0, 2, 1, 3).reshape(m * (p + 1), -1)
    sums = np.concatenate([v[p - i : n - i].sum(axis=0) for i in order])
    return triangle(moments, sums, n - p)


def triangle(moments, sums, n):
    """The triangle of [1, rows] from the moments (k, k) and the sums (k,) of `n` rows, or None."""
    moments = np.block([[np.full((1, 1), float(n)), sums[None]], [sums[:, None], moments]])
    try:
        R = np.linalg.cholesky(moments).T
    except np.linalg.LinAlgError:
        return None
    diagonal = np.diag(R)
    return R if diagonal.min() > 1e-4 * diagonal.max() else None
