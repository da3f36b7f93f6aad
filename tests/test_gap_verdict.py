"""What is left after a fit is tested against the model, not against the record itself."""

import numpy as np
import pytest

from imu_lib.gap import residual_tests
from imu_lib.gap.data import Data
from imu_lib.gap.state import State
from imu_lib.processes import RandomWalk, WhiteNoise

RECORDS = 120


def walk(n, fs, rng, K):
    return rng.standard_normal(n) * np.sqrt(fs) + np.cumsum(rng.standard_normal(n)) * K / np.sqrt(
        fs
    )


@pytest.mark.parametrize("seconds, fs", [(20, 100.0), (120, 100.0), (20, 1000.0), (7200, 4.0)])
def test_autocorrelation_of_what_is_left_of_a_short_record_is_that_of_chance(seconds, fs):
    rng = np.random.default_rng(int(seconds + fs))
    log_p = []
    for _ in range(RECORDS):
        x = walk(int(seconds * fs), fs, rng, 30.0 / seconds)
        state = State(Data(x, fs), [WhiteNoise(1.0), RandomWalk(30.0 / seconds)])
        log_p.append(residual_tests.residual_autocorrelation(state, x).log_p)
    log_p = np.array(log_p)
    # corrected for the lags it looked at (neighbouring ones are nearly independent): a share p of
    # the records lies below p, to three standard deviations of a count
    assert log_p.min() > -4.5
    assert np.mean(log_p < -1) < 0.1 + 3 * np.sqrt(0.09 / RECORDS)


def test_an_echo_is_seen_in_the_autocorrelation_at_its_lag():
    rng = np.random.default_rng(4)
    n, lag = 60_000, 130
    x = 10.0 * rng.standard_normal(n + lag)
    x = x[lag:] + 0.08 * x[:-lag]
    check = residual_tests.residual_autocorrelation(State(Data(x, 100.0), [WhiteNoise(1.0)]), x)
    assert check.log_p < -20 and "lag of 1.3 s: +0.0" in check.where
