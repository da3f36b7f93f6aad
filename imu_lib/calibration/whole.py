"""A whole record into a calibration, with or without a list of what was done when (`sections`)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..errors import InputError
from ..record import Record
from ..units import DEG, MILLI_G, G
from .gyro import from_turns
from .poses import from_gravity, from_reference
from .rest import RestWindows, rest_windows
from .sections import Section, read_poses
from .triad import AXES, Triad


@dataclass(frozen=True)
class Calibration:
    """Calibrations of the two triads (None where not determined), how, and from which windows.

    `windows` (k, 2) s: the rests or sections used; `magnitude` (k,) m/s^2: length of the specific
    force of each pose after calibration; `notes`: sentences on what was left out and why.
    """

    accelerometers: Triad | None
    gyroscopes: Triad | None
    method: str
    windows: np.ndarray
    gravity: float
    magnitude: np.ndarray | None = None
    rests: RestWindows | None = None
    notes: tuple[str, ...] = ()

    def summary(self) -> dict[str, float]:
        """Biases and scale factors in datasheet units by name, for tables."""
        out = {}
        for name, triad, unit, label in (
            ("accel", self.accelerometers, MILLI_G, "mg"),
            ("gyro", self.gyroscopes, DEG, "deg/s"),
        ):
            for what, factor in (
                (("biases", 1 / unit), ("scale_factors", 100)) if triad is not None else ()
            ):
                text = f"bias, {label}" if what == "biases" else "scale, %"
                estimates = zip(AXES, getattr(triad, what))
                out |= {
                    f"{name} {axis} {text}": e.value * factor
                    for axis, e in estimates
                    if e is not None
                }
        return out

    def to_json(self) -> dict:
        """The whole result; SI units (`bias`, `offset`, `residual_sd`), scale factors and
        cross-coupling relative.
        """
        return {
            "method": self.method,
            "gravity": self.gravity,
            "windows": self.windows.tolist(),
            "notes": list(self.notes),
            "accelerometers": None
            if self.accelerometers is None
            else self.accelerometers.to_json(),
            "gyroscopes": None if self.gyroscopes is None else self.gyroscopes.to_json(),
        }


def calibrate(
    accel: np.ndarray | None,
    gyro: np.ndarray | None,
    fs: float,
    *,
    sections: list[Section] | None = None,
    gravity: float = G,
    accel_nominal: float | None = 1.0,
    gyro_nominal: float | None = 1.0,
    window: float = 1.0,
) -> Calibration:
    """Bias, scale factor and cross-coupling of a record's accelerometers and gyroscopes.

    Parameters
    ----------
    accel, gyro : ndarray, shape (n, 3), or None
        m/s^2 and rad/s, or counts with `nominal` None. Only `sections` with rates can do without
        accelerometers.
    fs : float, Hz
    sections : what was done when (`read_poses`); None finds the rests and uses gravity alone
    gravity : float, local gravity, m/s^2
    window : float, s, of the search for rests

    Raises
    ------
    InputError
        In one sentence: missing samples, never at rest, too few poses, poses or turns that leave
        an axis out.
    """
    _check(accel, gyro)
    if sections is not None:
        return _known(accel, gyro, fs, sections, gravity, accel_nominal or 1.0, gyro_nominal or 1.0)
    if accel is None:
        raise InputError(
            "Poses at rest calibrate nothing without three accelerometers; give them, or the true "
            "rates of a rate table (--poses)."
        )
    rests = rest_windows(accel, fs, gyro=gyro, window=window)
    means = rests.means(accel)
    accelerometers = from_gravity(means, gravity=gravity, nominal=accel_nominal)
    notes, gyroscopes = [], None
    if gyro is not None:
        try:
            gyroscopes = from_turns(gyro, accel, fs, rests, accelerometers, nominal=gyro_nominal)
        except InputError as error:
            notes.append(f"Gyroscopes not calibrated: {error}")
    return Calibration(
        accelerometers,
        gyroscopes,
        "static poses found in the record, magnitude of gravity",
        np.column_stack([rests.start, rests.stop]) / fs,
        gravity,
        np.linalg.norm(accelerometers.correct(means), axis=1),
        rests,
        tuple(notes),
    )


def _check(accel, gyro) -> None:
    """Raises ValueError for arrays that do not fit, InputError for samples without a number."""
    for name, x in (("accel", accel), ("gyro", gyro)):
        if x is not None and (np.ndim(x) != 2 or np.shape(x)[1] != 3):
            raise ValueError(f"`{name}` must have the shape (n, 3), not {np.shape(x)}")
    if accel is not None and gyro is not None and len(accel) != len(gyro):
        raise ValueError(
            f"`gyro` has {len(gyro)} samples, `accel` {len(accel)}; they must be sampled together"
        )
    for name, x in (("accelerometers", accel), ("gyroscopes", gyro)):
        if x is not None and not np.isfinite(x).all():
            row = int(np.flatnonzero(~np.isfinite(x).all(axis=1))[0])
            raise InputError(
                f"The {name} have a missing or infinite sample at row {row}; cut the record "
                "around it (--start, --stop)."
            )


def _known(accel, gyro, fs, sections, gravity, accel_nominal, gyro_nominal) -> Calibration:
    """Calibration from sections whose inputs are known."""
    n = len(accel if accel is not None else gyro)
    for k, s in enumerate(sections):
        if not 0 <= s.start < s.stop <= n / fs + 1e-9:
            raise InputError(
                f"Section {k + 1} of the poses runs from {s.start:g} to {s.stop:g} s, outside the "
                f"record of {n / fs:g} s or backwards; correct its start and stop."
            )

    def mean(x, s):
        return x[round(s.start * fs) : max(round(s.stop * fs), round(s.start * fs) + 1)].mean(
            axis=0
        )

    accelerometers = gyroscopes = magnitude = None
    still = [s for s in sections if s.force is not None]
    if still and accel is not None:
        means = np.array([mean(accel, s) for s in still])
        accelerometers = from_reference(
            means, gravity * np.array([s.force for s in still]), nominal=accel_nominal
        )
        magnitude = np.linalg.norm(accelerometers.correct(means), axis=1)
    moving = [s for s in sections if s.rate is not None or s.turn is not None]
    if moving and gyro is not None:
        rest = [s for s in still if s.rate is None and s.turn is None]
        zero = np.mean([mean(gyro, s) for s in rest], axis=0) if rest else np.zeros(3)
        truth, reading = [np.zeros(3)] * len(rest), [mean(gyro, s) for s in rest]
        for s in moving:
            rate = s.rate if s.rate is not None else s.turn / (s.stop - s.start)
            reading.append(mean(gyro, s))
            truth.append(rate if s.signed else rate * np.sign((reading[-1] - zero) @ rate))
        gyroscopes = from_reference(reading, truth, nominal=gyro_nominal)
    if accelerometers is None and gyroscopes is None:
        raise InputError(
            "The poses give no input that this record can be compared with; state x, y, z in g or "
            "rate_x, rate_y, rate_z in deg/s for every row."
        )
    return Calibration(
        accelerometers,
        gyroscopes,
        "sections with known inputs, least squares",
        np.array([[s.start, s.stop] for s in sections]),
        gravity,
        magnitude,
        notes=(
            "The intervals take the listed poses and turns as exact; what the hand or the table "
            "is off by adds to them.",
        ),
    )


def calibrate_record(
    record: Record, *, poses: str | Path | None = None, gravity: float = G
) -> Calibration:
    """`calibrate` on a record in SI: its gap-free part without `poses`, the whole of it with them.

    Raises
    ------
    InputError
        As `calibrate`, and where the record has too few channels.
    """
    sections = None if poses is None else read_poses(poses, record.rate)
    even = record.uniform() if sections is not None else record.continuous()
    signals, absent = {}, {}
    for kind in ("accel", "gyro"):
        present = [f"{kind}_{axis}" in even for axis in AXES]
        absent[kind] = [a for a, there in zip(AXES, present) if not there]
        signals[kind] = None
        if (
            all(present) or any(present) and sections is not None
        ):  # known inputs calibrate single sensors too
            columns = [
                even[f"{kind}_{a}"] if there else np.zeros(even.n)
                for a, there in zip(AXES, present)
            ]
            signals[kind] = np.column_stack(columns)
    if signals["accel"] is None and sections is None:
        raise InputError(
            f"{record.name or record.source or 'The record'} has no "
            f"{', '.join('accel_' + a for a in absent['accel'])}; poses "
            "at rest need three accelerometers, a rate table needs --poses."
        )
    found = calibrate(
        signals["accel"], signals["gyro"], record.rate, sections=sections, gravity=gravity
    )

    def only(triad, missing):
        if triad is None or not missing:
            return triad
        rows = [AXES.index(a) for a in missing]
        held = triad.estimated.copy()
        held[[3 * i + j for i in rows for j in range(3)] + [9 + i for i in rows]] = False
        return replace(triad, estimated=held)

    return replace(
        found,
        accelerometers=only(found.accelerometers, absent["accel"]),
        gyroscopes=only(found.gyroscopes, absent["gyro"]),
        notes=tuple(n for n in even.notes if n not in record.notes) + found.notes,
    )
