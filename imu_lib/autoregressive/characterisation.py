"""The autoregressive description of one channel."""

from __future__ import annotations

import numpy as np

from imu_lib.autoregressive.fitting import checked
from imu_lib.autoregressive.order import choose_order
from imu_lib.autoregressive.whiteness import whiteness


def characterise(x, fs, *, max_order=20) -> dict:
    """Order by Schwarz's criterion, coefficients, driving noise and whiteness of the residuals.

    Returns
    -------
    dict
        `order` (int), `phi` (list of Estimate), `sigma` (Estimate, signal unit), `white` (bool).
        `fs` is not used: an autoregressive model knows samples, not seconds.
    """
    x = checked(x, 0)
    max_order = int(min(max_order, max(1, np.sqrt(x.size) // 4)))
    choice = choose_order(x, max_order)
    model = choice.steps.fit(choice.orders["sbc"])
    phi, sigma = model.estimates()
    tested = whiteness(
        model.residuals(x), fitted=model.order, lags=max(2 * max_order, model.order + 10)
    )
    return {"order": model.order, "phi": phi, "sigma": sigma, "white": tested.white}
