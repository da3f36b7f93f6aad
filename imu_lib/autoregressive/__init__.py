"""Autoregressive models: fitting, order, residuals, and what they are samples of.

* `fit(x, order, method=...)`: Burg, Yule-Walker or least squares; `burg`: all orders in one pass;
* `stepwise(v, max_order)`: least squares of all orders in one pass, one or several variables, as
  ARfit does;
* `choose_order`: Schwarz, Akaike, final prediction error, description length, and the
  residual-variance knee;
* `whiteness`: band, Ljung-Box and Li-McLeod tests of the residuals;
* `from_gauss_markov`, `to_gauss_markov`: AR(1) and the first-order Gauss-Markov process are one
  thing;
* `best_predictor`: what a fit of a given order tends to on a known autocovariance.

The sign is x_k = sum phi_i x_{k-i} + w_k, statsmodels' and the 2011 paper's; `ARModel.alpha` has
the other one.
"""

from imu_lib.autoregressive.characterisation import characterise
from imu_lib.autoregressive.fitting import burg, fit, yule_walker
from imu_lib.autoregressive.model import (
    ARModel,
    autocovariance,
    best_predictor,
    from_gauss_markov,
    poles,
    to_gauss_markov,
)
from imu_lib.autoregressive.order import OrderChoice, choose_order, knee
from imu_lib.autoregressive.stepwise import Stepwise, VectorARModel, stepwise
from imu_lib.autoregressive.whiteness import Whiteness, whiteness

__all__ = [
    "ARModel",
    "OrderChoice",
    "Stepwise",
    "VectorARModel",
    "Whiteness",
    "autocovariance",
    "best_predictor",
    "burg",
    "characterise",
    "choose_order",
    "fit",
    "from_gauss_markov",
    "knee",
    "poles",
    "stepwise",
    "to_gauss_markov",
    "whiteness",
    "yule_walker",
]
