"""The drive: an IMU in a vehicle, with GNSS and, where there is one, a reference solution.

Units are SI; body axes forward-right-down, navigation axes north-east-down; positions are latitude
and longitude in rad and height in m above the WGS-84 ellipsoid. All times count from the first IMU
sample.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from pathlib import Path

import numpy as np

from imu_lib import drive_checks, timing
from imu_lib.archive import load_arrays, numbers
from imu_lib.arrays import frozen
from imu_lib.errors import InputError
from imu_lib.record import Record

_SHAPES = {
    "gyro": "time",
    "accel": "time",
    "temperature": "time",
    "gnss_position": "gnss_time",
    "gnss_velocity": "gnss_time",
    "gnss_position_sd": "gnss_time",
    "gnss_velocity_sd": "gnss_time",
    "gnss_fix": "gnss_time",
    "reference_position": "reference_time",
    "reference_velocity": "reference_time",
    "reference_attitude": "reference_time",
}
_FLAT = ("temperature", "gnss_fix")


@dataclass(frozen=True, eq=False)
class Drive:
    """A drive; arrays are read-only float64.

    time (n,) s, rising; gyro (n, 3) rad/s; accel (n, 3) m/s^2. gnss_time (m,) s, rising;
    gnss_position (m, 3) rad, rad, m; gnss_velocity (m, 3) m/s NED; the `_sd` in m and m/s, NED;
    gnss_fix (m,) the receiver's own code. reference_* likewise, reference_attitude (r, 3) roll,
    pitch, yaw in rad. lever_arm (3,) IMU to antenna, body axes, m. extra: what else the file held.
    Raises ValueError naming the argument.
    """

    time: np.ndarray
    gyro: np.ndarray
    accel: np.ndarray
    gnss_time: np.ndarray
    gnss_position: np.ndarray
    gnss_velocity: np.ndarray | None = None
    gnss_position_sd: np.ndarray | None = None
    gnss_velocity_sd: np.ndarray | None = None
    gnss_fix: np.ndarray | None = None
    reference_time: np.ndarray | None = None
    reference_position: np.ndarray | None = None
    reference_velocity: np.ndarray | None = None
    reference_attitude: np.ndarray | None = None
    lever_arm: np.ndarray | None = None
    temperature: np.ndarray | None = None
    extra: dict = field(default_factory=dict)
    name: str = ""
    source: str = ""
    notes: tuple[str, ...] = ()

    def __post_init__(self):
        put = object.__setattr__
        for key in ("time", "gnss_time", "reference_time"):
            value = getattr(self, key)
            if value is None:
                continue
            value = frozen(value, key, (-1,))
            if len(value) < 2 or not np.isfinite(value).all() or (np.diff(value) <= 0).any():
                what = {"time": "samples", "gnss_time": "fixes"}.get(key, "points of the reference")
                raise ValueError(
                    f"`{key}` must hold at least two rising times in seconds and holds "
                    f"{len(value)}; write the times of all {what} there"
                )
            put(self, key, value)
        for key, clock in _SHAPES.items():
            value = getattr(self, key)
            if value is None:
                continue
            if getattr(self, clock) is None:
                raise ValueError(f"`{key}` has no `{clock}`")
            n = len(getattr(self, clock))
            put(self, key, frozen(value, key, (n,) if key in _FLAT else (n, 3)))
        if self.lever_arm is not None:
            put(self, "lever_arm", frozen(self.lever_arm, "lever_arm", (3,)))
        for key in ("gyro", "accel"):
            drive_checks.numbers(getattr(self, key), key)
        for key in ("gnss_position", "reference_position"):
            drive_checks.position(getattr(self, key), key)
        drive_checks.attitude(self.reference_attitude, "reference_attitude")
        for key in ("gnss_position_sd", "gnss_velocity_sd"):
            drive_checks.deviations(getattr(self, key), key)
        put(self, "notes", tuple(self.notes))

    def __repr__(self):
        return (
            f"Drive({self.name or 'unnamed'}: {self.duration:.6g} s, IMU {self.rate:.6g} Hz, "
            f"{len(self.gnss_time)} fixes)"
        )

    @property
    def rate(self) -> float:
        """IMU samples per second, from the stamps, gaps left out, Hz."""
        return timing.measured_rate(self.time)

    @property
    def duration(self) -> float:
        return float(self.time[-1] - self.time[0])

    @property
    def has_reference(self) -> bool:
        return self.reference_time is not None and self.reference_position is not None

    def imu(self) -> Record:
        """The IMU signals alone, as a record."""
        channels = {
            f"{kind}_{axis}": getattr(self, kind)[:, i]
            for kind in ("gyro", "accel")
            for i, axis in enumerate("xyz")
        }
        return Record(
            channels,
            self.rate,
            self.time - self.time[0],
            self.temperature,
            self.name,
            self.source,
            self.notes,
        )

    def slice(self, start: float | None = None, stop: float | None = None) -> Drive:
        """The part from `start` to before `stop`, s on the drive's own clock (which is kept)."""
        changes = {}
        for clock in ("time", "gnss_time", "reference_time"):
            t = getattr(self, clock)
            if t is None:
                continue
            part = slice(
                *np.searchsorted(
                    t, [-np.inf if start is None else start, np.inf if stop is None else stop]
                )
            )
            for key in [clock] + [k for k, c in _SHAPES.items() if c == clock]:
                if getattr(self, key) is not None:
                    changes[key] = getattr(self, key)[part]
        return replace(self, **changes)

    def with_fixes(self, kept) -> Drive:
        """The drive with some of its fixes, kept (m,) bool."""
        names = [k for k, clock in _SHAPES.items() if clock == "gnss_time"]
        given = {k: getattr(self, k) for k in ("gnss_time", *names)}
        return replace(self, **{k: v[kept] for k, v in given.items() if v is not None})

    def without_velocity(self) -> Drive:
        """The drive with the positions of its fixes alone."""
        return replace(self, gnss_velocity=None, gnss_velocity_sd=None)

    @property
    def called(self) -> str:
        """What messages call it."""
        return self.source or self.name or "the drive"

    def with_(self, **changes) -> Drive:
        return replace(self, **changes)

    @classmethod
    def load(cls, path) -> Drive:
        """A drive from an `.npz` with the contract's keys. InputError where the file is at fault,
        OSError where it cannot be opened.
        """
        return from_arrays(load_arrays(path), str(path))

    def save(self, path) -> None:
        """Write the drive as `.npz` with the contract's keys."""
        arrays = {
            f.name: getattr(self, f.name)
            for f in fields(self)
            if isinstance(getattr(self, f.name), np.ndarray)
        }
        with open(path, "wb") as file:
            np.savez_compressed(file, **arrays, **self.extra)


def from_arrays(arrays: dict[str, np.ndarray], source: str, notes: tuple[str, ...] = ()) -> Drive:
    """A Drive from arrays under the contract's keys; fixes out of order or repeated are put right,
    and `notes` say so.
    """
    known = {f.name for f in fields(Drive)} - {"extra", "name", "source", "notes"}
    missing = [
        k for k in ("time", "gyro", "accel", "gnss_time", "gnss_position") if k not in arrays
    ]
    if missing:
        raise InputError(
            f"{source} has no `{missing[0]}`; a drive needs time, gyro, accel, gnss_time and "
            f"gnss_position (found: {', '.join(sorted(arrays)) or 'nothing'})."
        )
    values = {k: numbers(v, f"{source}, array `{k}`,") for k, v in arrays.items() if k in known}
    for clock in ("gnss_time", "reference_time"):
        if clock not in values or values[clock].ndim != 1:
            continue
        t = values[clock]
        partners = [
            k
            for k, c in _SHAPES.items()
            if c == clock and k in values and len(np.atleast_1d(values[k])) == len(t)
        ]
        good = np.isfinite(t)
        position = clock.replace("_time", "_position")
        if position in partners:
            whole = np.isfinite(values[position]).all(axis=-1)
            good &= whole | ~whole.any()  # of none at all the positions are told, not their times
            nowhere = (values[position][..., :2] == 0.0).all(axis=-1)
            if nowhere.any() and not nowhere.all():
                good &= ~nowhere
                notes += (f"{position}: {int(nowhere.sum())} rows at 0, 0 are no fixes.",)
        order = np.flatnonzero(good)[np.argsort(t[good], kind="stable")]
        order = order[np.r_[True, np.diff(t[order]) > 0]] if order.size else order
        if len(order) < len(t) or (np.diff(order) < 0).any():
            swapped = int((np.diff(t[good]) < 0).sum())
            notes += (
                f"{clock}: {len(t) - len(order)} rows without a number or with a repeated time "
                f"left out, {swapped} out of order put in place.",
            )
            for k in [clock] + partners:
                values[k] = values[k][order]
    t = values["time"]
    if t.ndim == 1 and len(t) and np.isfinite(t[0]) and t[0] != 0.0:
        # the contract counts from the first sample; a file on another clock is moved there as a
        # whole
        for k in ("time", "gnss_time", "reference_time"):
            if k in values:
                values[k] = values[k] - t[0]
        if "speed_time" in arrays:
            arrays = {
                **arrays,
                "speed_time": numbers(arrays["speed_time"], f"{source}, array `speed_time`,")
                - t[0],
            }
    try:
        return Drive(
            **values,
            extra={k: v for k, v in arrays.items() if k not in known},
            name=Path(source).stem,
            source=source,
            notes=notes,
        )
    except ValueError as error:
        raise InputError(f"{source}: {error}.") from None
