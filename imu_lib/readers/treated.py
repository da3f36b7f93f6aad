"""Readings that were worked on before the file was written: angles in place of rates, a bias
taken out.
"""

from __future__ import annotations

import re

import numpy as np

from imu_lib import units
from imu_lib.errors import InputError
from imu_lib.readers.gravity import some
from imu_lib.readers.plausibility import PARTS
from imu_lib.readers.raw import Raw
from imu_lib.readers.tokens import ROTATION

#: Variance of the steps over that of the values up to which a reading grows from row to row, and
#: correlation of neighbouring steps from which it is no noise on top that does so.
GROWS, ALIKE = 0.05, -0.2
LEAST = 50  # samples that tell
_A_RATE = re.compile(r"rate|speed|vel", re.IGNORECASE)
#: An attitude by a gyro: roll_gyro, in sketches that integrate it.
_TURNED = re.compile(r"^(?:roll|pitch|yaw)[_ .-]?gyro", re.IGNORECASE)


def refuse_angles(raw: Raw) -> None:
    """InputError where a gyro in [deg] or [rad], or one whose name may be that of an angle, is an
    integrated angle, whatever the call says of its unit.
    """
    doubtful = {
        c.read_as
        for c in raw.described
        if (c.evidence.startswith(ROTATION) or _TURNED.match(c.name.strip()))
        and c.unit is None
        and not _A_RATE.search(c.name)
    }
    there = [c for c in raw.axes("gyro") if raw.units[c] in ("deg", "rad") or c in doubtful]
    if not there or not any(_grows(raw.columns[c]) for c in there):
        return
    left = [
        "-" if c.read_as is None or c.read_as.startswith("gyro") else c.read_as
        for c in raw.described
    ]
    rest = any(c.startswith(("accel", "dv")) for c in left)
    how = (
        f"leave it out with --columns {','.join(left)}" if rest else "give the file with the rates"
    )
    unit = raw.units[there[0]]
    said = f" is in [{unit}] and" if unit in ("deg", "rad") else ""
    rate = f"{unit}/s" if unit in ("deg", "rad") else unit or "deg/s"
    raise InputError(
        f"{raw.source}: `{raw.headings[there[0]]}`{said} grows smoothly from row to row, as an "
        f"angle that was integrated does: neither a rate nor an increment; {how}, or give "
        f"--gyro-unit {rate} --trust-units if it is a rate."
    )


def _grows(x) -> bool:
    """Whether values are a sum over their rows: small steps that do not undo each other."""
    x = np.asarray(x, dtype=float)
    x = x[np.isfinite(x)]
    step = np.diff(x)
    if len(x) < LEAST or not step.any():
        return False
    # against the usual step: a slope of the whole is a bias that was integrated
    loose = step - step.mean()
    alike = float(np.mean(loose[1:] * loose[:-1]) / max(float(np.mean(loose**2)), 1e-300))
    return float(np.mean(step**2)) < GROWS * float(x.var()) and alike > ALIKE


def without_bias(gyro: np.ndarray, rate: float) -> float | None:
    """Rate (rad/s) below which the means of all three axes (n, 3) at rest lie, where they vanish to
    their noise; None where they do not.
    """
    x = some(gyro)
    if gyro.shape[1] != 3 or len(x) < 50 * PARTS:
        return None
    means = np.array([p.mean(axis=0) for p in np.array_split(x, PARTS)])
    error = means.std(axis=0, ddof=1) / np.sqrt(PARTS)
    white = np.abs(np.diff(x, axis=0)).mean(axis=0) * np.sqrt(np.pi) / 2 / np.sqrt(len(x))
    if (error > 3.0 * white).any() or not (error > 0).all():  # it moved, or drifts
        return None
    limit = 3.0 * error
    return float(limit.max()) if (np.abs(x.mean(axis=0)) < limit).all() else None


def bias_note(gyro: np.ndarray, rate: float) -> str | None:
    """A sentence on a bias that was taken out, None where there is nothing to say."""
    below = without_bias(gyro, rate)
    if below is None:
        return None
    return (
        f"The means of all three gyros vanish to their noise (below {below / units.DEG_PER_S:.2g} "
        "deg/s): the bias seems to have been taken out before the "
        "file was written, as a phone's fused or calibrated rates have it."
    )
