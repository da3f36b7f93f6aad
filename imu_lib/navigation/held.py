"""Effects on a drive as the filter holds them: what they do to the readings, the fixes, the model
and the measurements.

A reading in the file's axes is turned to the body's (`axes`), its bias, scale, cross-coupling and
g-sensitivity are taken out, and its clock is put right; the filter then runs in the axes of the
case, and `mounting` says where the vehicle is. Of two effects alike the later one holds.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from imu_lib import processes
from imu_lib.arrays import Array
from imu_lib.drive import Drive
from imu_lib.drive_effects import DriveEffect, off_diagonal, permutation_matrix
from imu_lib.errors import InputError
from imu_lib.model import Model
from imu_lib.processes import Sum

from .preparation import Gnss

_MANY = {
    "bias_model": ("channel", "process", "name"),
    "vibration": ("channel",),
    "gnss_noise": ("of",),
}


@dataclass(frozen=True)
class Held:
    """The effects by name; those that may come several times by name and what they are of."""

    effects: dict[tuple[str, ...], DriveEffect]

    @classmethod
    def of(cls, effects: Iterable[DriveEffect]) -> Held:
        """From DriveEffects, in order."""
        found = {}
        for effect in effects:
            key = (effect.name, *(effect[k] for k in _MANY.get(effect.name, ())))
            found[key] = effect
        return cls(found)

    def get(self, name) -> DriveEffect | None:
        return self.effects.get((name,))

    def value(self, name, key, default):
        """A parameter of an effect, or the default where the effect is not held."""
        effect = self.get(name)
        return default if effect is None else effect.get(key, default)

    def all(self, name):
        return [e for e in self.effects.values() if e.name == name]

    @property
    def permutation(self):
        """(3, 3), file = P body."""
        effect = self.get("axes")
        return np.eye(3) if effect is None else permutation_matrix(effect["permutation"])

    @property
    def mounting(self) -> Array | None:
        """Roll, pitch, yaw (3,) of the case against the vehicle, or None where it is not held."""
        effect = self.get("mounting")
        if effect is None:
            return None
        return np.array([effect.get(k, 0.0) for k in ("roll", "pitch", "yaw")])

    @property
    def correlated(self):
        """(sigma m, correlation_time s) of the fixes, or None."""
        effect = self.get("gnss_correlated")
        return None if effect is None else (effect["sigma"], effect["correlation_time"])

    @property
    def outliers(self):
        """(fraction, scale m) of wild positions; fraction 0 where none are held."""
        effect = self.get("gnss_outliers")
        return (
            np.array([0.0, 1.0])
            if effect is None
            else np.array([effect["fraction"], effect["scale"]])
        )

    def vibration(self):
        """Channel of the body -> (N or None, N_per_speed)."""
        to_body = self.channels()
        return {
            to_body[e["channel"]]: (e.get("N"), e["N_per_speed"]) for e in self.all("vibration")
        }

    def channels(self):
        """The file's channel -> the body's."""
        column = np.abs(self.permutation).argmax(axis=1)
        return {
            f"{sensor}_{axis}": f"{sensor}_{'xyz'[column[i]]}"
            for sensor in ("gyro", "accel")
            for i, axis in enumerate("xyz")
        }

    def readings(self, gyro, accel):
        """The true turn rate and specific force (n, 3), in the axes of the case."""
        turn = self.permutation.T
        if not np.array_equal(turn, np.eye(3)):
            gyro, accel = gyro @ turn.T, accel @ turn.T
        accel = self._undone("accel", np.asarray(accel, float))
        sensitivity = np.reshape(self.value("gyro_g_sensitivity", "matrix", np.zeros(9)), (3, 3))
        if sensitivity.any():
            gyro = gyro - accel @ sensitivity.T
        return self._undone("gyro", np.asarray(gyro, float)), accel

    def _undone(self, sensor, x):
        bias = np.asarray(self.value(f"{sensor}_bias", "bias", np.zeros(3)))
        scale = np.asarray(self.value(f"{sensor}_scale", "scale", np.zeros(3)))
        cross = np.asarray(self.value(f"{sensor}_misalignment", "matrix", np.zeros(6)))
        if bias.any():
            x = x - bias
        if scale.any() or cross.any():
            mix = np.eye(3) + np.diag(scale) + off_diagonal(cross)
            if abs(np.linalg.det(mix)) < 1e-3:
                raise InputError(f"{sensor}_scale and {sensor}_misalignment leave no axis to read")
            x = x @ np.linalg.inv(mix).T
        return x

    def drive(self, drive: Drive) -> Drive:
        """The drive with its readings and the IMU's clock put right."""
        changes = {}
        gyro, accel = self.readings(drive.gyro, drive.accel)
        if gyro is not drive.gyro or accel is not drive.accel:
            changes = {"gyro": gyro, "accel": accel}
        clock = self.value("imu_clock", "scale", 0.0)
        if clock:
            changes["time"] = drive.time[0] + (drive.time - drive.time[0]) / (1.0 + clock)
        arm = self.get("lever_arm")
        if arm is not None:
            changes["lever_arm"] = np.asarray(arm["arm"])
        return drive.with_(**changes) if changes else drive

    def gnss(self, gnss: Gnss) -> Gnss:
        """How fixes are taken, with the effects on them."""
        changes = {}
        offset = self.get("gnss_time_offset")
        if offset is not None:
            changes["latency"] = gnss.latency - offset["offset"]
            own = offset.get("velocity_offset", offset["offset"])
            changes["velocity_latency"] = gnss.latency - own
        for effect in self.all("gnss_noise"):
            key = f"{effect['of']}_ratio"
            changes[key] = getattr(gnss, key) * effect["ratio"]
        return replace(gnss, **changes) if changes else gnss

    def model(self, model: Model) -> Model:
        """The error model with its parameters changed, its channels in the body's axes."""
        channels = dict(model.channels)
        for effect in self.all("bias_model"):
            channels[effect["channel"]] = _changed(channels, effect)
        to_body = self.channels()
        if any(a != b for a, b in to_body.items()):
            channels = {to_body[c]: entry for c, entry in channels.items()}
        return replace(model, channels=channels)

    def heading(self, drive: Drive, heading):
        """The heading at the start (rad, or None) less its error, where one is held."""
        effect = self.get("heading")
        if effect is None:
            return heading
        if heading is None:
            if drive.reference_attitude is None:
                raise InputError(
                    "the effect heading is the error of a given heading: give one, or a drive "
                    "with reference_attitude"
                )
            heading = float(drive.reference_attitude[0, 2])
        return heading - effect["error"]

    def levels(self, levels):
        """De-noising levels of the file's channels for those of the body."""
        if levels is None or not isinstance(levels, dict):
            return levels
        to_body = self.channels()
        return {to_body.get(c, c): n for c, n in levels.items()}


def _changed(channels, effect) -> Sum:
    channel, name, key = effect["channel"], effect["process"], effect["name"]
    if channel not in channels:
        raise InputError(f"bias_model: the error model has no channel {channel}")
    terms, done = list(channels[channel].terms), False
    for i, term in enumerate(terms):
        if term.name == name and not done:
            entry = term.to_json()
            if key not in entry:
                raise InputError(f"bias_model: {name} of {channel} has no parameter {key!r}")
            terms[i] = processes.from_json({**entry, key: effect["to"]}, on_record=False)
            done = True
    if not done:
        raise InputError(
            f"bias_model: {channel} of the error model has no process {name!r}; "
            f"it has {', '.join(t.name for t in terms)}"
        )
    return Sum(tuple(terms))
