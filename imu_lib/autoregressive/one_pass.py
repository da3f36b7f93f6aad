"""The autoregressive description of a channel from lagged products that one pass made.

Moment matrices and residual autocovariances are sums of products over nearly the whole record: the
lagged products of all of it, less those at its ends.
"""

from __future__ import annotations

import numpy as np

from imu_lib.autoregressive.order import choose
from imu_lib.autoregressive.stepwise import Stepwise, triangle
from imu_lib.autoregressive.whiteness import of_covariances
from imu_lib.stream import LagSums

ORDER = 20
#: Lags that a pass has to sum up.
LAGS = 3 * ORDER


def characterise(made: LagSums) -> dict:
    """As `autoregressive.characterise`, from the lagged products of `LAGS` lags or more."""
    products, total, n = made.total
    mean = total / n
    first, last = made.head[:LAGS] - mean, made.tail[-LAGS:] - mean
    d = np.arange(LAGS + 1)
    ends = [np.concatenate([[0.0], np.cumsum(v[:LAGS])]) for v in (first, last[::-1])]
    # products about the mean: the sums of the two factors of lag d leave d values out at one end
    left_out = mean * (2 * total - 2 * d * mean - ends[0] - ends[1]) - (n - d) * mean**2
    about = products[: LAGS + 1] - left_out
    scale = np.sqrt(about[0] / n)
    moments = _Moments(about / scale**2, first / scale, last / scale, n)
    R = triangle(moments.matrix(ORDER), moments.sums(ORDER), n - ORDER)
    if R is None:
        raise ValueError("`x` is so smooth that its moments do not tell an autoregressive model")
    one = np.ones(1)
    choice = choose(Stepwise(R, n - ORDER, 1, mean * one, scale * one), ORDER)
    model = choice.steps.fit(choice.orders["sbc"])
    phi, sigma = model.estimates()
    lags = max(2 * ORDER, model.order + 10)
    polynomial = np.concatenate([[1.0], -model.phi])
    covariances = moments.residuals(polynomial, lags)
    tested = of_covariances(covariances[:, None, None], n - model.order, model.order)
    return {"order": model.order, "phi": phi, "sigma": sigma, "white": tested.white}


class _Moments:
    """Sums of products of a series, over any range that leaves out only values at its ends."""

    def __init__(self, products, first, last, n):
        self.products, self.first, self.last, self.n = products, first, last, n

    def at(self, i, j, start):
        """Sum of v_{k-i} v_{k-j} over k = start ... n - 1, start >= i, j."""
        i, j = max(i, j), min(i, j)
        d, low = i - j, start - i
        tail, size = self.last, self.last.size
        out = self.products[d] - self.first[:low] @ self.first[d : d + low]
        # pairs whose later value is among the last j
        return out - tail[size - j :] @ tail[size - j - d : size - d]

    def matrix(self, p):
        """Moments of (v_{k-1}, ..., v_{k-p}, v_k) over k = p ... n - 1."""
        order = [*range(1, p + 1), 0]
        return np.array([[self.at(i, j, p) for j in order] for i in order])

    def sums(self, p):
        """Sums of the same over k = p ... n - 1; those of the whole series are zero."""
        order = [*range(1, p + 1), 0]
        return np.array(
            [-self.first[: p - i].sum() - self.last[self.last.size - i :].sum() for i in order]
        )

    def residuals(self, polynomial, lags):
        """Autocovariances of the polynomial's output about its mean, lags 0 ... lags."""
        p = polynomial.size - 1
        count = self.n - p
        # e_k = sum_i a_i v_{k-i}; sum over k of e_k e_{k+l} by products of lag l + i - j
        out = np.zeros(lags + 1)
        for lag in range(lags + 1):
            for i, a in enumerate(polynomial):
                for j, b in enumerate(polynomial):
                    out[lag] += a * b * self.at(i + lag, j, p + lag)
        mean = polynomial.sum() * self.sums(p)[-1] / count
        return out / count - mean**2
