"""Spikes on noise that has heavy tails of its own: what lies further out than those tails reach."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.optimize import minimize
from scipy.stats import norm
from scipy.stats import t as student

from imu_lib.arrays import Array

#: Standard deviations up to which samples tell the noise's own distribution.
CENTRE = 4.5
#: Classes of size of those.
CLASSES = 600
#: Freedom of the tails at the least: heavier ones reach as far as any spike.
LEAST = 2.6


def beyond(y: Array) -> tuple[float, float, float]:
    """(gain, probability, scale) of the best spikes of normal heights on Student's noise for the
    surprises `y` (n,), over that noise alone; `scale` in standard deviations of the centre.
    """
    u, count = _counted(np.abs(y) / _sd(y))
    freedom, width = _student(u, count, CENTRE)
    noise = _log_student(u, freedom, width)
    reach = student.isf(0.5 / count.sum(), freedom) * width
    far = u > reach  # heights that the tails do not make
    if freedom < LEAST or count[far].sum() < 2:
        return 0.0, 0.0, 0.0
    alone = max(float(count @ noise), float(count @ _log_student(u, *_student(u, count, np.inf))))

    def loss(v: Array) -> float:
        p, scale = 1.0 / (1.0 + np.exp(-v[0])), np.exp(v[1])
        spike = norm.logpdf(u, scale=np.hypot(width, scale)) + np.log(2)
        return -float(count @ np.logaddexp(np.log1p(-p) + noise, np.log(p) + spike))

    share = count[far].sum() / count.sum()
    height = np.sqrt(np.average(u[far] ** 2, weights=count[far]))
    best = _least(loss, [np.log(share / (1 - share)), np.log(height)])
    return -alone - best.fun, float(1.0 / (1.0 + np.exp(-best.x[0]))), float(np.exp(best.x[1]))


def odds(y: Array, p: float, scale: float) -> np.ndarray:
    """Log odds of each sample for being a spike, shape (n,)."""
    u = np.abs(y) / _sd(y)
    freedom, width = _student(*_counted(u), CENTRE)
    spike = norm.logpdf(u, scale=np.hypot(width, scale)) + np.log(2)
    return np.log(p / (1 - p)) + spike - _log_student(u, freedom, width)


def _sd(y: Array) -> float:
    return 1.4826 * float(np.median(np.abs(y)))


def _counted(u: Array) -> tuple[np.ndarray, np.ndarray]:
    """Sizes and how many samples have them: those near the centre in classes."""
    near, far = u[u < CENTRE], u[u >= CENTRE]
    count, edge = np.histogram(near, CLASSES, (0.0, CENTRE))
    values = np.r_[0.5 * (edge[1:] + edge[:-1]), far]
    return values, np.r_[count, np.ones(len(far))].astype(float)


def _log_student(u: Array, freedom: float, width: float) -> Array:
    """Logarithm of the density of sizes."""
    return student.logpdf(u / width, freedom) - np.log(width) + np.log(2)


def _student(u: Array, count: Array, end: float) -> tuple[float, float]:
    """Freedom and width of the Student's distribution that is likeliest for the samples within
    `end`, as a distribution that ends there.
    """
    near = u < end
    u, count = u[near], count[near]

    def loss(v: Array) -> float:
        freedom, width = 1.5 + np.exp(v[0]), np.exp(v[1])
        inside = 1.0 - 2.0 * student.sf(end / width, freedom)
        return float(count.sum() * np.log(inside) - count @ _log_student(u, freedom, width))

    best = _least(loss, [np.log(4.0), 0.0])
    return 1.5 + float(np.exp(best.x[0])), float(np.exp(best.x[1]))


def _least(loss: Callable[[Array], float], start: list[float]) -> Any:
    return minimize(loss, start, method="Nelder-Mead", options={"xatol": 1e-2, "fatol": 1e-2})
