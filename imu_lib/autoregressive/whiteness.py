"""Are the residuals white?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats


@dataclass(frozen=True)
class Whiteness:
    """Tests of residuals for whiteness.

    Parameters
    ----------
    rho : ndarray, shape (h,)
        Autocorrelations of the residuals at lags 1 ... h (of the variable with the largest, for
        several).
    band : float
        95 % half width for white noise, 1.96 / sqrt(n).
    share_outside : float
        Share of the lags outside the band; 0.05 expected.
    ljung_box, li_mcleod : float
        p-values of the two portmanteau tests, degrees of freedom less the fitted coefficients.
    white : bool
        Neither test rejects at 1 %.
    """

    rho: np.ndarray
    band: float
    share_outside: float
    ljung_box: float
    li_mcleod: float
    white: bool

    @property
    def largest(self) -> float:
        """Largest autocorrelation in magnitude: on a long record a test rejects what hardly
        matters.
        """
        return float(np.max(np.abs(self.rho)))


def whiteness(residuals, *, fitted=0, lags=40) -> Whiteness:
    """Band, Ljung-Box and Li-McLeod tests of residuals.

    Parameters
    ----------
    residuals : array_like, shape (n,) or (n, m)
    fitted : int
        Order of the fitted model.
    lags : int

    Notes
    -----
    With C_k the residual covariances at lag k, m variables and h lags, both are chi-square with
    m^2 (h - p) degrees of
    freedom: Ljung-Box (in Hosking's form for several variables) n^2 sum_k tr(C_k' C_0^-1 C_k
    C_0^-1) / (n - k), and
    Li-McLeod n sum_k tr(...) + m^2 h (h + 1) / (2 n), which is what ARfit tests with.

    Raises
    ------
    ValueError
        Unless `fitted` < `lags` < n.
    """
    e = np.asarray(residuals, dtype=float)
    e = e[:, None] if e.ndim == 1 else e
    e = e - e.mean(axis=0)
    n, m = e.shape
    if not fitted < lags < n - 1:
        raise ValueError(
            f"`lags` must lie above `fitted` ({fitted}) and below the number of residuals ({n})"
        )
    return of_covariances(np.array([e[k:].T @ e[: n - k] / n for k in range(lags + 1)]), n, fitted)


def of_covariances(covariances, n, fitted) -> Whiteness:
    """`whiteness` from the residuals' covariances, (lags + 1, m, m), sums over `n`."""
    c0, covariances = covariances[0], covariances[1:]
    lags, m = covariances.shape[:2]
    inverse = np.linalg.inv(c0)
    traces = np.array([np.trace(c.T @ inverse @ c @ inverse) for c in covariances])
    k = np.arange(1, lags + 1)
    freedom = m**2 * (lags - fitted)
    ljung_box = stats.chi2.sf((n if m > 1 else n + 2) * n * np.sum(traces / (n - k)), freedom)
    li_mcleod = stats.chi2.sf(n * np.sum(traces) + m**2 * lags * (lags + 1) / (2 * n), freedom)
    rho = covariances[:, range(m), range(m)] / np.diag(c0)
    rho = rho[:, np.argmax(np.max(np.abs(rho), axis=0))]
    band = float(stats.norm.ppf(0.975) / np.sqrt(n))
    return Whiteness(
        rho,
        band,
        float(np.mean(np.abs(rho) > band)),
        float(ljung_box),
        float(li_mcleod),
        bool(min(ljung_box, li_mcleod) > 0.01),
    )
