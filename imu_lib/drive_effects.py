"""What can be wrong with a drive beyond the noise of its sensors: the vocabulary of a model file's
key `drive`.

Times in s, angles in rad, lengths in m; three values are the body axes x, y, z. Signs: a reading is
(I + diag(scale) + X) truth + bias, X = [[0, xy, xz], [yx, 0, yz], [zx, zy, 0]]; the gyro's gains
M f, M by rows. A fix stamped t was taken at t - offset. `mounting` turns the case's axes into the
vehicle's by Rz(yaw) Ry(pitch) Rx(roll). Stamps of the IMU are (1 + scale) times the time of GNSS.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from imu_lib.arrays import Array
from imu_lib.errors import InputError

CHANNELS = tuple(f"{sensor}_{axis}" for sensor in ("gyro", "accel") for axis in "xyz")
_AXES = ("+x", "-x", "+y", "-y", "+z", "-z")
#: Parameters of each effect: 0 a number, n a list of n numbers, "text" a name, "axes" three axes.
#: A trailing "?" means that it may be left out.
EFFECTS: Mapping[str, Mapping[str, object]] = {
    "gnss_time_offset": {"offset": 0, "velocity_offset?": 0},
    "mounting": {"roll?": 0, "pitch?": 0, "yaw?": 0},
    "axes": {"permutation": "axes"},
    "lever_arm": {"arm": 3},
    "accel_scale": {"scale": 3},
    "gyro_scale": {"scale": 3},
    "accel_misalignment": {"matrix": 6},
    "gyro_misalignment": {"matrix": 6},
    "gyro_g_sensitivity": {"matrix": 9},
    "accel_bias": {"bias": 3},
    "gyro_bias": {"bias": 3},
    "bias_model": {"channel": "channel", "process": "text", "name": "text", "from?": 0, "to": 0},
    "vibration": {"channel": "channel", "N?": 0, "N_per_speed": 0},
    "gnss_noise": {"ratio": 0, "of": "text"},
    "gnss_correlated": {"sigma": 0, "correlation_time": 0},
    "gnss_outliers": {"fraction": 0, "scale": 0},
    "heading": {"error": 0},
    "imu_clock": {"scale": 0},
}
#: Parameters that must lie above zero.
_POSITIVE = {
    ("gnss_noise", "ratio"),
    ("gnss_correlated", "sigma"),
    ("gnss_correlated", "correlation_time"),
    ("gnss_outliers", "scale"),
}
_NOT_NEGATIVE = {("vibration", "N"), ("vibration", "N_per_speed"), ("gnss_outliers", "fraction")}


@dataclass(frozen=True)
class DriveEffect:
    """One effect: its name and its parameters, checked.

    Raises InputError naming the effect, the parameter and what is expected.
    """

    name: str
    parameters: Mapping[str, Any]

    def __post_init__(self) -> None:
        if self.name not in EFFECTS:
            raise InputError(
                f"unknown effect {self.name!r} on a drive; effects are {', '.join(EFFECTS)}"
            )
        if not isinstance(self.parameters, Mapping):
            raise InputError(f"{self.name}: its parameters are an object of names and values")
        known = {key.rstrip("?"): kind for key, kind in EFFECTS[self.name].items()}
        unknown = sorted(set(self.parameters) - set(known))
        if unknown:
            raise InputError(
                f"{self.name} has no parameter {unknown[0]!r}; it has {', '.join(known)}"
            )
        missing = [k for k in EFFECTS[self.name] if k[-1] != "?" and k not in self.parameters]
        if missing:
            raise InputError(f"{self.name} needs the parameter {missing[0]!r}")
        values = {
            key: _checked(self.name, key, known[key], value)
            for key, value in self.parameters.items()
            if value is not None
        }
        if self.name == "gnss_noise" and values["of"] not in ("position", "velocity"):
            raise InputError(f"gnss_noise: `of` is position or velocity, not {values['of']!r}")
        if self.name == "axes" and np.linalg.det(permutation_matrix(values["permutation"])) < 0.0:
            raise InputError(
                f"axes: {' '.join(values['permutation'])} is left-handed, and both sensors would "
                "have to be; change one sign"
            )
        if self.name == "gnss_outliers" and values["fraction"] >= 1.0:
            raise InputError("gnss_outliers: `fraction` lies below 1")
        object.__setattr__(self, "parameters", values)

    def __getitem__(self, key: str) -> Any:
        return self.parameters[key]

    def get(self, key: str, default: Any = None) -> Any:
        return self.parameters.get(key, default)

    @classmethod
    def from_json(cls, entry: Any) -> DriveEffect:
        """From `{"effect": name, "parameters": {...}}`, as the steps of a result have it, or with
        the parameters beside the name. What else a step holds is left aside.
        """
        if not isinstance(entry, Mapping) or not isinstance(entry.get("effect"), str):
            raise InputError('an entry is an object with its name under "effect"')
        name = entry["effect"]
        if "parameters" in entry:
            return cls(name, entry["parameters"])
        return cls(name, {k: v for k, v in entry.items() if k != "effect"})

    def to_json(self) -> dict[str, Any]:
        parameters = {
            k: list(v) if isinstance(v, (tuple, np.ndarray)) else v
            for k, v in self.parameters.items()
        }
        return {"effect": self.name, "parameters": parameters}


def _checked(effect: str, key: str, kind: Any, value: Any) -> Any:
    where = f"{effect}: `{key}`"
    if kind == "text":
        if not isinstance(value, str):
            raise InputError(f"{where} is a name, not {value!r}")
        return value
    if kind == "channel":
        if value not in CHANNELS:
            raise InputError(f"{where} is one of {', '.join(CHANNELS)}, not {value!r}")
        return value
    if kind == "axes":
        return _axes(where, value)
    try:
        numbers = np.asarray(value, float)
    except (TypeError, ValueError):
        numbers = np.asarray(np.nan)
    if isinstance(value, (bool, str)) or not np.isfinite(numbers).all():
        raise InputError(f"{where} must be {_what(kind)}, not {value!r}")
    if kind == 9 and numbers.shape == (3, 3):
        numbers = numbers.ravel()
    if numbers.shape != (() if kind == 0 else (kind,)):
        raise InputError(f"{where} must be {_what(kind)}, not {value!r}")
    if (effect, key) in _POSITIVE and not (numbers > 0.0).all():
        raise InputError(f"{where} lies above 0, not {value!r}")
    if (effect, key) in _NOT_NEGATIVE and (numbers < 0.0).any():
        raise InputError(f"{where} is not below 0, not {value!r}")
    return float(numbers) if kind == 0 else tuple(float(x) for x in numbers)


def _what(kind: int) -> str:
    return "a finite number" if kind == 0 else f"a list of {kind} finite numbers"


def _axes(where: str, value: Any) -> tuple[str, ...]:
    text = value.replace(",", " ").split() if isinstance(value, str) else value
    if not isinstance(text, (list, tuple)) or len(text) != 3:
        raise InputError(f"{where} is three of {' '.join(_AXES)}, not {value!r}")
    names = tuple(str(v) if str(v)[:1] in "+-" else f"+{v}" for v in text)
    if any(n not in _AXES for n in names) or len({n[1] for n in names}) != 3:
        raise InputError(f"{where} names x, y and z once each, with their signs, not {value!r}")
    return names


def permutation_matrix(names: Sequence[str]) -> Array:
    """Turns the body's axes into the file's: file = matrix @ body, of three of `+x -x ...`."""
    out = np.zeros((3, 3))
    for row, name in enumerate(names):
        out[row, "xyz".index(name[1])] = 1.0 if name[0] == "+" else -1.0
    return out


def off_diagonal(six: Sequence[float]) -> Array:
    """X (3, 3) of xy xz yx yz zx zy."""
    xy, xz, yx, yz, zx, zy = six
    return np.array([[0.0, xy, xz], [yx, 0.0, yz], [zx, zy, 0.0]])


def from_entries(value: Any, where: str) -> tuple[DriveEffect, ...]:
    """The effects of a model file's key `drive`. InputError naming `where` and the entry."""
    if not isinstance(value, list):
        raise InputError(f"{where}: must be a list of effects")
    out = []
    for number, entry in enumerate(value, start=1):
        try:
            out.append(entry if isinstance(entry, DriveEffect) else DriveEffect.from_json(entry))
        except InputError as error:
            raise InputError(f"{where}, entry {number}: {error}") from None
    return tuple(out)
