"""A found effect with its parameters, in datasheet units where there are any."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from imu_lib import units
from imu_lib.gap import fault_steps

if TYPE_CHECKING:
    from imu_lib.gap.steps import Step

#: Parameters that say which kind of effect it is, in words, and effects whose rate is that of
#: their samples.
KINDS, SAMPLED = (
    {"rounded": "by rounding of the integral", "smoothing": "exponential smoothing"},
    ("low_pass", "autoregressive"),
)
#: Parameters that are read off single samples: in the unit of these, not of a bias.
OF_SAMPLES = ("amplitude", "limit", "low", "lsb", "scale")


def value(symbol: str, x: float | str | list[Any] | tuple[Any, ...] | None, channel: str) -> str:
    """A parameter with its unit."""
    if isinstance(x, (list, tuple)):
        return f"[{', '.join(v if isinstance(v, str) else format(v, '.4g') for v in x)}]"
    if isinstance(x, str) or x is None:
        return str(x)
    gyro = channel.startswith("gyro")
    # a jump or a transient of a gyro is told as its bias is
    if symbol in OF_SAMPLES and not (gyro and symbol == "amplitude"):
        if channel.split("_")[0] in ("gyro", "accel"):
            return _of_samples(x, channel)
    if symbol == "curvature":  # as the slope, a degree more
        factor, unit = units.datasheet("slope", channel)
        return f"{x / factor:.4g} {unit}^2"
    if symbol in ("lag", "play"):
        return f"{x:.4g} {'s' if symbol == 'lag' else 'degC'}"
    try:
        factor, unit = units.datasheet(symbol, channel)
        return f"{x / factor:.4g} {unit}".rstrip()
    except (KeyError, ValueError):
        pass
    second = {
        "correlation_time": "s",
        "time_constant": "s",
        "time": "s",
        "duration": "s",
        "frequency": "Hz",
        "cutoff": "Hz",
        "rate": "/s",
        "sd": "s",
    }
    if symbol in second:
        return f"{x:.5g} {second[symbol]}"
    signal = "rad/s" if channel.startswith("gyro") else "m/s^2"
    own = {
        "amplitude": signal,
        "limit": signal,
        "low": signal,
        "lsb": signal,
        "scale": signal,
        "slope": f"{signal}/degC",
    }
    return f"{x:.4g}{' ' + own[symbol] if symbol in own and channel != 'record' else ''}"


def _of_samples(x: float, channel: str) -> str:
    """In the unit of the samples."""
    gyro = channel.startswith("gyro")
    return f"{np.rad2deg(x):.4g} deg/s" if gyro else f"{x:.4g} m/s^2"


def describe(step: Step, channel: str) -> str:
    """Name and parameters of a step."""
    p = step.parameters
    if (words := fault_steps.described(step.effect, p)) is not None:
        return words
    if step.effect == "vibration":
        return _vibration(p)
    if step.effect == "common_mode":  # the noise's unit is that of the channels that share it
        kinds = {c.split("_")[0] for c in p["channels"]}
        unit = p["channels"][0] if len(kinds) == 1 else ""
        return (
            f"{step.effect}  N "
            f"{value('N', p['N'], unit) if unit else format(p['N'], '.4g') + ' SI'}, channels "
            f"{', '.join(p['channels'])}"
            + (f", {100 * p['share']:.2g} % of their noise" if p.get("share") else "")
            + (", before their filters" if p.get("filtered") else "")
        )
    if step.effect == "parameter_change":
        return (
            f"{p['process']} {p['name']}: {value(p['name'], p['from'], channel)} -> "
            f"{value(p['name'], p['to'], channel)}"
        )
    shown = [
        KINDS.get(k) or f"{k} {_shown(step.effect, k, v, channel)}"
        for k, v in p.items()
        if v is not None and k != "phase"
    ]
    return step.effect + "  " + ", ".join(shown)


def _vibration(p: dict[str, Any]) -> str:
    """A vibration with its lines, its amplitude on each channel and its time."""
    out = f"vibration  {p['frequency']:.5g} Hz"
    if p["harmonics"] > 1:
        count = sum(r > 0 for r in p.get("ratios") or ()) or p["harmonics"]
        out += f", {count} {'lines' if p.get('lines') else 'multiples'}"
    if p["bandwidth"]:
        out += f", {p['bandwidth']:.2g} Hz wide"
    if p.get("from") is not None:
        out += f", from {p['from']:.0f} to {p['to']:.0f} s"
    felt = (f"{c} {_of_samples(a, c)}" for c, a in zip(p["channels"], p["amplitude"]))
    return out + ": " + ", ".join(felt)


def _shown(effect: str, symbol: str, x: Any, channel: str) -> str:
    """A parameter of an effect whose symbol means something else in others."""
    if symbol == "rate" and effect in SAMPLED:
        return f"{x:.5g} Hz"
    if effect == "wandering_level" and symbol == "sd":
        return f"{100 * x:.3g} %"
    return value(symbol, x, channel)
