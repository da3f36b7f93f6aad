"""Units: named constants that take a value to SI, and the datasheet unit of each coefficient.

Multiply to enter SI, divide to leave it::

    N = 2.42 * units.DEG_PER_SQRT_HOUR       # rad/s/sqrt(Hz)
    N / units.DEG_PER_SQRT_HOUR              # 2.42

Symbols and units are those of IEEE Std 952 (gyros) and 1293 (accelerometers).
"""

from __future__ import annotations

import math

MINUTE = 60.0
HOUR = 3600.0
SQRT_HOUR = 60.0

DEG = math.pi / 180.0  # rad
ARCSEC = DEG / 3600.0  # rad
DEG_PER_S = DEG  # rad/s
DEG_PER_HOUR = DEG / HOUR  # rad/s
DEG_PER_SQRT_HOUR = DEG / SQRT_HOUR  # rad/s/sqrt(Hz), that is rad/sqrt(s)
DEG_PER_HOUR_1_5 = DEG / HOUR**1.5  # rad/s^2/sqrt(Hz)
DEG_PER_HOUR_2 = DEG / HOUR**2  # rad/s^2
DEG_PER_S_PER_SQRT_HZ = DEG  # rad/s/sqrt(Hz)

G = 9.80665  # standard gravity, m/s^2
MILLI_G = 1e-3 * G
MICRO_G = 1e-6 * G
MICRO_G_PER_SQRT_HZ = MICRO_G  # m/s^2/sqrt(Hz)
MPS_PER_HOUR = 1.0 / HOUR  # m/s^2
MPS_PER_SQRT_HOUR = 1.0 / SQRT_HOUR  # m/s^2/sqrt(Hz)
MPS_PER_HOUR_1_5 = 1.0 / HOUR**1.5  # m/s^3/sqrt(Hz)
MPS_PER_HOUR_2 = 1.0 / HOUR**2  # m/s^3

#: Symbol -> (factor to SI, datasheet unit, SI unit) of a gyro.
GYRO = {
    "Q": (DEG, "deg", "rad"),
    "N": (DEG_PER_SQRT_HOUR, "deg/sqrt(h)", "rad/s/sqrt(Hz)"),
    "B": (DEG_PER_HOUR, "deg/h", "rad/s"),
    "K": (DEG_PER_HOUR_1_5, "deg/h^1.5", "rad/s^2/sqrt(Hz)"),
    "R": (DEG_PER_HOUR_2, "deg/h^2", "rad/s^2"),
    "signal": (DEG_PER_HOUR, "deg/h", "rad/s"),
    "per_degC": (DEG_PER_HOUR, "deg/h/degC", "rad/s/degC"),
}
#: Symbol -> (factor to SI, datasheet unit, SI unit) of an accelerometer.
ACCEL = {
    "Q": (1.0, "m/s", "m/s"),
    "N": (MPS_PER_SQRT_HOUR, "m/s/sqrt(h)", "m/s^2/sqrt(Hz)"),
    "B": (MPS_PER_HOUR, "m/s/h", "m/s^2"),
    "K": (MPS_PER_HOUR_1_5, "m/s/h^1.5", "m/s^3/sqrt(Hz)"),
    "R": (MPS_PER_HOUR_2, "m/s/h^2", "m/s^3"),
    "signal": (MPS_PER_HOUR, "m/s/h", "m/s^2"),
    "per_degC": (MILLI_G, "mg/degC", "m/s^2/degC"),
}
_SAME = {
    "correlation_time": (1.0, "s", "s"),
    "time_constant": (1.0, "s", "s"),
    "time": (1.0, "s", "s"),
    "frequency": (1.0, "Hz", "Hz"),
    "cutoff": (1.0, "Hz", "Hz"),
    "rate": (1.0, "1/s", "1/s"),
    "fraction": (1.0, "", ""),
    "ratio": (1.0, "", ""),
    "length": (1.0, "samples", "samples"),
    "phase": (1.0, "rad", "rad"),
    "sd": (1.0, "s", "s"),
    "reference": (1.0, "degC", "degC"),
}
#: Parameters that carry the unit of the signal itself.
_SIGNAL = ("sigma", "amplitude", "value", "scale", "limit", "low", "lsb")


def _row(symbol: str, channel: str) -> tuple[float, str, str]:
    table = GYRO if channel.startswith("gyro") else ACCEL
    if symbol in table:
        return table[symbol]
    if symbol in _SIGNAL:
        return table["signal"]
    if symbol == "slope":
        return table["per_degC"]
    if symbol in _SAME:
        return _SAME[symbol]
    return (1.0, "", "")


def datasheet(symbol: str, channel: str) -> tuple[float, str]:
    """Factor to SI and name of the datasheet unit of a coefficient.

    Parameters
    ----------
    symbol : str
        A coefficient (`Q N B K R`) or a process parameter (`sigma`, `correlation_time`, ...).
    channel : str
        A channel name; what begins with `gyro` is a gyro, anything else an accelerometer.
    """
    factor, unit, _ = _row(symbol, channel)
    return factor, unit


def si_unit(symbol: str, channel: str) -> str:
    """Name of the SI unit of a coefficient or parameter on a channel."""
    return _row(symbol, channel)[2]


def duration(seconds: float) -> str:
    """A length of time in words a reader can picture: `0.03 s`, `10.9 min`, `2.78 h`."""
    if seconds >= 3600:
        return f"{seconds / 3600:.3g} h"
    return f"{seconds / 60:.3g} min" if seconds >= 120 else f"{seconds:.3g} s"
