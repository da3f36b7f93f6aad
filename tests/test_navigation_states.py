"""The states that a model gives the filter, against the 2013 paper's matrices and closed forms."""

import numpy as np
import pytest

from imu_lib import preset
from imu_lib.errors import InputError, UndefinedFormError
from imu_lib.model import Model
from imu_lib.navigation import (
    covariance,
    models,
)
from imu_lib.navigation.states import sensor_states
from imu_lib.processes import (
    Autoregressive,
    Constant,
    Flicker,
    GaussMarkov,
    Quantization,
    RandomWalk,
    Sum,
    WhiteNoise,
)
from imu_lib.published import AR_2013
from imu_lib.record import CHANNELS

PAPER = preset("3dm-gx3-25-2013")


def test_eighteen_states_are_those_of_the_paper_to_first_order():
    """2013 paper, Eqs. 7, 8 and 21 to 30: what the general builder makes of the model of Eqs. 19
    and 20.
    """
    dt = 0.01
    sensors = sensor_states(PAPER, 1.0 / dt)
    assert sensors.count == 9 and 9 + sensors.count == 18
    for row, (name, s, q) in enumerate(
        zip(sensors.names, np.diag(sensors.transition), np.diag(sensors.noise))
    ):
        channel, process = name.split()
        term = PAPER[channel].find(process)
        if process == "gauss_markov":
            beta = 1.0 / term.correlation_time
            assert s == pytest.approx(
                1.0 - beta * dt, abs=(beta * dt) ** 2
            )  # Eq. 21 is the exponential to first order
            assert q == pytest.approx(
                term.sigma**2 * (1.0 - np.exp(-2.0 * dt * beta)), rel=1e-9
            )  # Eq. 28, exact
            assert sensors.initial[row, row] == term.sigma**2
        else:
            assert s == 1.0 and q == pytest.approx(term.K**2 * dt, rel=1e-12)  # Eq. 30
    table = {c: PAPER[c].find("white_noise").N for c in CHANNELS}
    assert sensors.white == pytest.approx([table[c] ** 2 for c in CHANNELS])
    # Eq. 27 gives the variance of one sample, N^2 / dt; the velocity gains N^2 dt in a step only
    # if G carries dt (as printed it has none)
    printed_q = table["accel_x"] ** 2 / dt
    nn = np.zeros((9, 9))
    covariance.add_white(nn, np.eye(3), sensors.white, dt)
    assert nn[3, 3] == pytest.approx(printed_q * dt**2)
    assert printed_q / nn[3, 3] == pytest.approx(1.0 / dt**2)


def test_states_by_the_table_and_printed_autoregressions():
    made = models.five()
    assert {n: 9 + sensor_states(m.model, 100.0).count for n, m in made.items()} == {
        "15AV": 15,
        "18AV": 18,
        "18AVWD": 18,
        "15AR": 15,
        "27AR": 27,
    }  # Table 8
    printed = models.printed(1)
    assert isinstance(printed["accel_x"].terms[1], RandomWalk) and isinstance(
        printed["gyro_x"].terms[1], Autoregressive
    )
    with pytest.raises(UndefinedFormError, match="not stationary"):  # accelerometer X of Table 2
        sensor_states(models.printed(3), 100.0)
    poles = np.abs(np.roots([1.0, *AR_2013["accel_x"][3][0]]))
    assert poles.max() == pytest.approx(1.044, abs=5e-4)
    stable = made["27AR"].model
    assert all(stable[c].terms[1].stable for c in CHANNELS)
    block = sensor_states(stable, 100.0)
    companion = block.transition[:3, :3]  # Eq. 31, newest value first
    assert companion[0] == pytest.approx(stable["gyro_x"].terms[1].phi) and np.array_equal(
        companion[1:], [[1, 0, 0], [0, 1, 0]]
    )
    assert (
        block.noise[0, 0] == pytest.approx(stable["gyro_x"].terms[1].sigma ** 2)
        and np.count_nonzero(block.noise) == 6
    )  # Eqs. 35, 36


def test_processes_without_a_state_are_refused_or_said():
    flicker = Model({c: WhiteNoise(N=1e-3) + Flicker(B=1e-4) for c in CHANNELS})
    with pytest.raises(UndefinedFormError, match="gauss_markov"):
        sensor_states(flicker, 100.0)
    bank = sensor_states(flicker, 100.0, flicker="markov")
    f = np.logspace(-3, 0, 30)
    assert bank.count == 36
    psd = sum(
        GaussMarkov(
            sigma=1e-4 * np.sqrt(np.log(10) / np.pi), correlation_time=10.0**k / (2 * np.pi)
        ).psd(f)
        for k in range(-1, 5)
    )
    assert np.max(np.abs(psd / Flicker(B=1e-4).psd(f) - 1.0)) < 0.1
    with pytest.raises(InputError, match="rate"):
        sensor_states(
            Model({c: Sum((Autoregressive(phi=(0.9,), sigma=1e-3, rate=50.0),)) for c in CHANNELS}),
            100.0,
        )
    with pytest.raises(InputError, match="accel_z"):
        sensor_states(Model({c: Sum((WhiteNoise(N=1.0),)) for c in CHANNELS[:5]}), 100.0)
    mixed = Model(
        {c: WhiteNoise(N=1e-3) + Quantization(Q=1e-3) + Constant(value=0.1) for c in CHANNELS}
    )
    sensors = sensor_states(mixed, 100.0, turn_on_sd=(1e-3, 0.1))
    assert (
        sensors.count == 6
        and len(sensors.ignored) == 6
        and sensors.initial[5, 5] == pytest.approx(0.01)
    )
