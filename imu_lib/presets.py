"""Error models of published sensors, each with its source.

What a paper prints is taken from it; what it does not print and a model needs is marked "ours".

- `3dm-gx3-25`: the digital twin of what the 2013 paper measured (its Tables 4 and 5).
- `3dm-gx3-25-2013`: the paper's own model of it (its Eqs. 19, 20, 27-30).
- `isis-imu`: the ISIS-IMU of the 2011 paper (its Tables 2 and 3).
- `rga300ca`: the RGA300CA of the 2008 paper (its Table 1; the noise itself is ours).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.optimize import least_squares

from imu_lib import units
from imu_lib.errors import InputError
from imu_lib.model import Model
from imu_lib.processes import (
    Autoregressive,
    Flicker,
    GaussMarkov,
    LowPass,
    Quantization,
    Ramp,
    RandomWalk,
    Resolution,
    Sum,
    WhiteNoise,
)
from imu_lib.published import ALLAN_2013, FLAT_2013

#: Root of the flat Allan variance over B, sqrt(2 ln2 / pi), rounded as the papers and IEEE 952 do.
FLAT_LEVEL = 0.664


@dataclass(frozen=True)
class Published:
    """What Tables 4 and 5 of the 2013 paper print for one axis, in SI.

    N, B, K as in the package's conventions (K is None where the table has no entry), `flat_time`
    the correlation time read off the flat part in s, `sd` the standard deviation of the record.
    """

    N: float
    B: float
    K: float | None
    flat_time: float
    sd: float


def published_2013() -> dict[str, Published]:
    """Tables 4 and 5 of the 2013 paper, converted to SI, by channel."""
    out = {}
    for channel, row in ALLAN_2013.items():
        flat_time, sd = FLAT_2013[channel]
        factor = {symbol: units.datasheet(symbol, channel)[0] for symbol in "NBK"}
        out[channel] = Published(
            row["N"][0] * factor["N"],
            row["B"][0] * factor["B"],
            row["K"][0] * factor["K"] if "K" in row else None,
            flat_time,
            sd,
        )
    return out


#: The sensor's moving average: 15 taps at 1 kHz, read out at 100 Hz (2013 paper, Sec. 5.1).
MOVING_AVERAGE_2013 = LowPass(taps=15, rate=1000.0)
#: Length of the 2013 paper's record, s.
DURATION_2013 = 7 * units.HOUR

#: How closely each printed figure is to be met, as a relative standard deviation (ours): the
#: tables print 0.5-4 % for N, 1-12 % for B and 3-14 % for K; a walk's share of one record's
#: standard deviation scatters by tens of per cent.
_TOLERANCE = {"N": 0.02, "flat": 0.05, "slope": 0.1, "K": 0.1, "sd": 0.1}


def twin_misfit(entry: Sum, published: Published) -> dict[str, float]:
    """What a channel's model has, over what the 2013 paper printed for it.

    The moving average lets noise from above half the output rate fold down, so that an Allan
    curve shows a white noise 5 % above N; else it changes nothing at the times of Table 5.

    Returns
    -------
    dict
        `N` (as an Allan curve shows it), `flat` (Allan deviation at the printed correlation time
        over 0.664 B), `K` (where printed) and `sd` (expected standard deviation of a seven-hour
        record) as ratios; `slope`, the slope of the log-log Allan deviation at that time, as it is
        (a flat part has 0).
    """
    white, markov, walk = (
        entry.find(name) for name in ("white_noise", "gauss_markov", "random_walk")
    )
    low_pass = entry.low_pass or MOVING_AVERAGE_2013
    folded = float(Sum((white,), (low_pass,)).psd(1e-3, 100.0) / white.psd(1e-3))
    seen = white.with_(N=white.N * np.sqrt(folded))
    slow_terms = tuple(term for term in (markov, walk) if term is not None)
    tau = published.flat_time
    around = np.sqrt(Sum((seen, *slow_terms)).avar(tau * np.array([0.9, 1.0, 1.1])))
    fast = white.N**2 * low_pass.rate / low_pass.taps
    slow = markov.sigma**2 + (0.0 if walk is None else walk.K**2 * DURATION_2013 / 6.0)
    out = {
        "N": seen.N / published.N,
        "flat": around[1] / (FLAT_LEVEL * published.B),
        "slope": np.log(around[2] / around[0]) / np.log(1.1 / 0.9),
        "sd": np.sqrt(fast + slow) / published.sd,
    }
    if walk is not None:
        out["K"] = walk.K / published.K
    return {key: float(value) for key, value in out.items()}


def _twin_channel(published: Published) -> Sum:
    """White noise, a Gauss-Markov process and (accelerometers) a walk that meet the tables best."""
    start = [published.N, FLAT_LEVEL * published.B / 0.617, published.flat_time / 1.893]
    start += [] if published.K is None else [published.K]

    def entry(values):
        terms = [WhiteNoise(values[0]), GaussMarkov(values[1], values[2])]
        if published.K is not None:
            terms.append(RandomWalk(values[3]))
        return Sum(tuple(terms), (MOVING_AVERAGE_2013,))

    def residuals(log):
        misfit = twin_misfit(entry(np.exp(log)), published)
        return [
            (value if key == "slope" else np.log(value)) / _TOLERANCE[key]
            for key, value in misfit.items()
        ]

    # four digits are more than the tables hold, and the same on every machine
    best = least_squares(residuals, np.log(start)).x
    return entry([float(f"{value:.4g}") for value in np.exp(best)])


@cache
def _twin() -> Model:
    return Model(
        {channel: _twin_channel(row) for channel, row in published_2013().items()},
        rate=100.0,
        name="3dm-gx3-25",
        source="twin of what Quinchia et al. (2013) measured, Tables 4 and 5; moving average of "
        "Sec. 5.1",
    )


def _model_of_2013() -> Model:
    channels = {}
    for channel, row in published_2013().items():
        terms = [WhiteNoise(row.N), GaussMarkov(FLAT_LEVEL * row.B, row.flat_time)]
        if row.K is not None:
            terms.append(RandomWalk(row.K))
        channels[channel] = Sum(tuple(terms))
    return Model(
        channels,
        rate=100.0,
        name="3dm-gx3-25-2013",
        source="Quinchia et al. (2013), Eqs. 19-20 and 27-30 with Tables 4 and 5",
    )


def _isis_imu() -> Model:
    deg, mps = units.DEG, 1.0
    hour = units.MPS_PER_HOUR
    return Model(
        {
            "gyro_x": Sum(
                (
                    Quantization(2.5e-3 * deg),
                    WhiteNoise(4.8e-2 * units.DEG_PER_SQRT_HOUR),
                    Flicker(1.4 * units.DEG_PER_HOUR),
                    RandomWalk(5.2 * units.DEG_PER_HOUR_1_5),
                )
            ),
            "gyro_y": Sum((Quantization(7.2e-3 * deg), Ramp(72 * units.DEG_PER_HOUR_2))),
            "gyro_z": Sum(
                (
                    Quantization(9.1e-4 * deg),
                    WhiteNoise(2.6e-2 * units.DEG_PER_SQRT_HOUR),
                    Flicker(1.2 * units.DEG_PER_HOUR),
                    RandomWalk(8.1 * units.DEG_PER_HOUR_1_5),
                )
            ),
            "accel_x": Sum((Quantization(4.5e-3 * mps), Flicker(1.4 * hour))),
            "accel_y": Sum(
                (Quantization(2.1e-3 * mps), Flicker(0.9 * hour), Ramp(3.2 * units.MPS_PER_HOUR_2))
            ),
            "accel_z": Sum((Quantization(4.8e-1 * mps),)),
        },
        rate=100.0,
        name="isis-imu",
        source="Zhao et al. (2011), Tables 2 and 3 (B of Table 3 read as m/s/h); the sampling "
        "rate, 100 Hz, is ours",
    )


def _rga300ca() -> Model:
    # The paper prints no noise parameters. Ours: white noise at half of Table 1's random-walk
    # limits behind the 10 Hz bandwidth of the 20 Hz logging, a correlated part on the
    # accelerometers
    # that a fourth-order model can follow, and Table 1's resolution.
    white = WhiteNoise(0.5 * 0.15 * units.MPS_PER_SQRT_HOUR)
    coloured = {
        "accel_x": Autoregressive((0.42, 0.23, 0.14, 0.10), 1.6e-3, 20.0),
        "accel_y": Autoregressive((0.38, 0.25, 0.15, 0.11), 1.8e-3, 20.0),
        "accel_z": Autoregressive((0.45, 0.20, 0.14, 0.09), 1.5e-3, 20.0),
    }
    channels = {channel: Sum((white, process)) for channel, process in coloured.items()}
    channels["gyro_z"] = Sum(
        (WhiteNoise(0.5 * 2.25 * units.DEG_PER_SQRT_HOUR),), (Resolution(0.025 * units.DEG_PER_S),)
    )
    return Model(
        channels,
        rate=20.0,
        name="rga300ca",
        source="Park and Gao (2008): Table 1's limits; the noise parameters are ours, the paper "
        "prints none",
    )


PRESETS: dict[str, Callable[[], Model]] = {
    "3dm-gx3-25": _twin,
    "3dm-gx3-25-2013": _model_of_2013,
    "isis-imu": _isis_imu,
    "rga300ca": _rga300ca,
}


def preset(name: str) -> Model:
    """The preset of that name.

    Raises
    ------
    InputError
        If there is none.
    """
    if name not in PRESETS:
        raise InputError(f"unknown preset {name!r}; presets are {', '.join(PRESETS)}")
    return PRESETS[name]()
