"""Scales that stand above a table as `name, number`: Gyroflow's tscale, gscale and ascale, and the
counts per g of a blackbox.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

import numpy as np

from imu_lib.readers.raw import Raw

_PAIR = re.compile(
    r'^\s*"?([A-Za-z]\w*)"?\s*[,:=;\t]\s*"?([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)"?\s*$'
)
#: What a factor of the name makes of a number: rad/s, g and seconds.
_GYROFLOW = {"gscale": ("gyro", "rad/s"), "ascale": ("accel", "g")}
_TICKS = {1.0: "s", 1e-3: "ms", 1e-6: "us", 1e-9: "ns"}


def take(raw: Raw, above: Iterable[str]) -> None:
    """The units and the clock that such scales make of columns which state none."""
    lines = list(above)
    said = {m[1].lower(): float(m[2]) for line in lines if (m := _PAIR.match(line))}
    if "tscale" in said and any(k in said for k in _GYROFLOW):
        for name, (kind, unit) in _GYROFLOW.items():
            if said.get(name, 0) > 0:
                _unit(raw, kind, said[name], unit, name)
        _clock(raw, said["tscale"])
        turned = next((x for x in lines if re.match(r"^\s*orientation\s*[,:]", x)), "")
        if turned and turned.strip()[-3:] not in ("XYZ", "xyz"):
            raw.notes += (
                f"The axes are those of the file; its `{turned.strip()}` says how the camera's "
                "lie to them.",
            )
    per_g = said.get("acc_1g", 0)
    heads = " ".join(raw.headings.values())
    if per_g > 0 and re.search(r"\bacc(?:Smooth|ADC)?\b", heads.replace("[", " ")):
        _unit(raw, "accel", 1.0 / per_g, "g", "acc_1G")


def _unit(raw: Raw, kind: str, factor: float, unit: str, name: str) -> None:
    if factor > 1 and abs(factor - 1) > 1e-9:
        return
    spelled = unit if abs(factor - 1) < 1e-9 else f"{factor:.12g} {unit}"
    raw.state(kind, spelled, f"by `{name}` above the table", over=(None, "counts"))


def _clock(raw: Raw, factor: float) -> None:
    if "time" not in raw.columns or raw.units["time"] is not None or not 0 < factor < 1e3:
        return
    known = next((u for f, u in _TICKS.items() if abs(factor / f - 1) < 1e-9), None)
    if known is None and raw.columns["time"].dtype.kind in "fiu":
        raw.columns["time"] = np.asarray(raw.columns["time"], dtype=float) * factor
        known = "s"
    raw.units["time"] = known
