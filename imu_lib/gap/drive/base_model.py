"""Where no error model is given: white noise and walks alike on the three axes, as likely as the
innovations allow.
"""

import numpy as np
from scipy.optimize import minimize

from imu_lib.model import Model
from imu_lib.navigation.tuning import vehicle_model

START = (1e-3, 0.03, 3e-5, 1e-3)  # a low-cost unit in a car: gyro N, accel N, gyro K, accel K
TRIES = 70


def guess(drive) -> Model:
    """The model to start with."""
    return vehicle_model(*START, name="fitted in motion")


def fit(state, say=lambda text: None):
    """The noise of a state with its four levels and the fixes' two ratios fitted."""
    use, problem, noise = state.use, state.problem, state.noise

    def enter(x):
        levels = np.exp(np.clip(x, -25.0, 3.0))
        return noise.with_(model=vehicle_model(*levels[:4], name="fitted in motion"))

    def loss(x):
        value = problem.evaluate(enter(x), use=use).log_likelihood
        pull = 0.5 * float(np.sum(((x - np.log(START)) / np.log(30.0)) ** 2))
        return -value + pull if np.isfinite(value) else 1e12

    start = np.log(START)
    simplex = np.vstack([start, start + np.eye(4)])
    found = minimize(
        loss, start, method="Nelder-Mead",
        options={"initial_simplex": simplex, "maxfev": TRIES, "xatol": 0.05, "fatol": 0.5},
    )  # fmt: skip
    say("noise of the sensors fitted")
    return enter(found.x)
