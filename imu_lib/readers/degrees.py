"""The column of the temperature in degrees Celsius."""

from __future__ import annotations

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers import spelling
from imu_lib.readers.raw import Raw, numbers


def celsius(raw: Raw, keep) -> np.ndarray | None:
    """Degrees Celsius (n,), None where there is none or it cannot be one."""
    if "temperature" not in raw.columns:
        return None
    unit = raw.units["temperature"]
    known = spelling.UNITS["temperature"]
    heading = raw.headings["temperature"]
    if unit is not None and unit not in known:
        raise InputError(
            f"{raw.source}: the temperature `{heading}` is in [{unit}]; degC, degF and K are "
            "known: name it temperature[degC] with --columns, or skip it with -."
        )
    x = raw.columns["temperature"]
    if x.dtype.kind not in "fiub" or not np.isfinite(x.astype(float)).any():
        raw.drop("temperature", "it holds no numbers")
        return None
    t = numbers(raw, "temperature")[keep]
    t = {"degF": lambda x: (x - 32.0) / 1.8, "K": lambda x: x - 273.15}.get(
        unit, lambda x: x * known.get(unit, 1.0)
    )(t)
    middle = float(np.nanmedian(t))
    if not -90 < middle < 200:
        likely = "K" if 200 <= middle < 400 and unit is None else None
        raw.notes += (
            f"The temperature column (median {middle:.6g}) is not in degC and was left out"
            + ("; it looks like K: name it temperature[K] with --columns." if likely else "."),
        )
        raw.drop("temperature", f"no temperature in degC (median {middle:.6g})")
        return None
    raw.told("temperature", unit or "degC", None if unit else "no unit stated: taken as degC")
    if unit is None and middle > 60:
        raw.notes += (
            f"The temperature `{heading}` states no unit and was taken as degC; its median of "
            f"{middle:.4g} would be {(middle - 32) / 1.8:.3g} degC if it were degF "
            "(name it temperature[degF] with --columns).",
        )
    if np.isnan(t).any():
        good = ~np.isnan(t)
        t = np.interp(np.arange(len(t)), np.flatnonzero(good), t[good])
    return t
