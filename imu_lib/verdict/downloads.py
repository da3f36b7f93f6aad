"""The files that a verdict offers: the model, and its forms for other programs."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from imu_lib import export
from imu_lib.units import G


def write_downloads(result, folder) -> dict[str, str]:
    """Write the model and its forms for other programs into `folder`: file name -> what it is.

    A form that the record does not reach (a program that needs both sensors, say) is left out.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    result.model.save(folder / "model.json")
    (folder / "result.json").write_text(json.dumps(result.to_json()) + "\n", encoding="utf-8")
    out = {
        "model.json": "error model of this package",
        "result.json": "all coefficients with intervals",
    }
    writers = {name: (file, writer) for name, (file, writer) in export.FORMATS.items()}
    writers |= {name: entry for name, entry in FORMATS.items() if name not in writers}
    for name, (file, writer) in writers.items():
        try:
            text = writer(result.model)
        except (ValueError, KeyError):  # InputError among them
            continue
        (folder / file).write_text(text, encoding="utf-8")
        out[file] = TITLES.get(name, name)
    return out


def _densities(model):
    """Worst axis: (gyro N, gyro K, accelerometer N, accelerometer K), continuous, SI."""
    out = []
    for sensor in ("gyro", "accel"):
        names = [c for c in model.channel_names if c.startswith(sensor)]
        if not names:
            raise ValueError("a model of gyros and accelerometers is needed")
        out += [
            max(export.white(model[c]) for c in names),
            max(export.equivalent_walk(model[c]) for c in names),
        ]
    return out


def vins(model) -> str:
    """Entries for a VINS-Mono or VINS-Fusion configuration: continuous densities, worst axis."""
    gyro_n, gyro_k, accel_n, accel_k = _densities(model)
    return (
        "%YAML:1.0\n"
        "# for VINS-Mono and VINS-Fusion: white noise and bias random walk of the worst axis,\n"
        "# continuous; these programs are usually given some times more, for what a standstill\n"
        "# does not show\n"
        f"acc_n: {accel_n:.6g}  # m/s^2/sqrt(Hz)\ngyr_n: {gyro_n:.6g}  # rad/s/sqrt(Hz)\n"
        f"acc_w: {accel_k:.6g}  # m/s^3/sqrt(Hz)\ngyr_w: {gyro_k:.6g}  # rad/s^2/sqrt(Hz)\n"
        f"g_norm: {G:.5f}\n"
    )


def openvins(model) -> str:
    """Noise entries of OpenVINS' kalibr_imu_chain.yaml."""
    gyro_n, gyro_k, accel_n, accel_k = _densities(model)
    return (
        "%YAML:1.0\nimu0:\n"
        f"  accelerometer_noise_density: {accel_n:.6g}  # m/s^2/sqrt(Hz)\n"
        f"  accelerometer_random_walk: {accel_k:.6g}  # m/s^3/sqrt(Hz)\n"
        f"  gyroscope_noise_density: {gyro_n:.6g}  # rad/s/sqrt(Hz)\n"
        f"  gyroscope_random_walk: {gyro_k:.6g}  # rad/s^2/sqrt(Hz)\n"
        f"  update_rate: {float(model.rate or 0.0):g}\n"
    )


def matlab(model) -> str:
    """A script that makes MATLAB's `imuSensor` with the model's white noise and random walk.

    Its NoiseDensity and RandomWalk are the continuous densities; BiasInstability is the flat level
    B of its own filtered noise and is left at zero, since the slow terms are in the walk.
    """
    lines = [
        "% imuSensor of the Navigation or Sensor Fusion and Tracking Toolbox",
        f"imu = imuSensor('accel-gyro', 'SampleRate', {float(model.rate or 100.0):g});",
    ]
    for sensor, kind, unit in (
        ("accel", "Accelerometer", "m/s^2/sqrt(Hz), m/s^3/sqrt(Hz)"),
        ("gyro", "Gyroscope", "rad/s/sqrt(Hz), rad/s^2/sqrt(Hz)"),
    ):
        names = [f"{sensor}_{a}" for a in "xyz"]
        if any(n not in model.channel_names for n in names):
            raise ValueError("MATLAB's imuSensor needs three axes of both sensors")
        white = np.array([export.white(model[n]) for n in names])
        walk = np.array([export.equivalent_walk(model[n]) for n in names])
        params = "accelparams" if sensor == "accel" else "gyroparams"
        lines.append(
            f"imu.{kind} = {params}('NoiseDensity', {_row(white)}, 'RandomWalk', {_row(walk)}); % "
            f"{unit}"
        )
    return "\n".join(lines) + "\n"


def _row(values) -> str:
    return "[" + " ".join(f"{v:.6g}" for v in values) + "]"


FORMATS = {
    "vins": ("imu_vins.yaml", vins),
    "openvins": ("kalibr_imu_chain.yaml", openvins),
    "matlab": ("imu_sensor.m", matlab),
}
TITLES = {
    "kalibr": "Kalibr",
    "ros": "ROS",
    "gnss-ins-sim": "gnss-ins-sim",
    "vins": "VINS-Mono, VINS-Fusion",
    "openvins": "OpenVINS",
    "matlab": "MATLAB imuSensor",
}
