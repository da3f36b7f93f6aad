"""The flat level of the Allan deviation that a likelihood fit implies."""

import numpy as np

from imu_lib import allan
from imu_lib.estimate import Estimate


def flat_level(fit):
    """Allan deviation of the fitted model where its slope is nearest to zero (0.664 B of a flicker), Estimate.

    The interval is normal in the logarithm, from the covariance of the fit through the derivatives of the level.
    """
    stats, theta = fit.statistics, fit.theta
    noise = fit.template.noise
    span = 1 / stats.rate, stats.duration / 3

    def log_level(values):
        model = noise.with_values(dict(zip(fit.labels, np.exp(values).tolist())))
        tau = np.array([allan.flat_time(model, *span)])
        return 0.5 * np.log(model.avar(tau, stats.rate)[0])

    step = 1e-3
    gradient = np.array([(log_level(theta + e) - log_level(theta - e)) / (2 * step) for e in step * np.eye(len(theta))])
    return Estimate.lognormal(np.exp(log_level(theta)), np.sqrt(max(gradient @ fit.covariance @ gradient, 0.0)))
