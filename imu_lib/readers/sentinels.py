"""Numbers that loggers write where they have no reading: -999, 9999, the largest float."""

from __future__ import annotations

import numpy as np

from imu_lib.readers.raw import Raw
from imu_lib.readers.streams import kind_of

NINES = (999.0, 9999.0, 99_999.0, 999_999.0, 999.99, 9999.99, 999.9, 9999.9)
LARGEST = (float(np.float32(3.4028235e38)), 3.4028235e38, 3.402823e38, 1.7976931348623157e308, 1e38)
FAR = 20.0  # times what the other readings reach
MOST = 0.3  # of the rows


def missing(raw: Raw) -> None:
    """Take such numbers for missing samples, with a word: each stands at least twice in a column
    and far from everything else in it.
    """
    found: dict[float, int] = {}
    for name, x in list(raw.columns.items()):
        if kind_of(name) is None or x.dtype.kind not in "fi" or len(x) < 20:
            continue
        values = np.asarray(x, dtype=np.float64)
        rough = np.abs(values)
        usual = float(np.nanquantile(rough, 0.5)) if np.isfinite(rough).any() else 0.0
        top = float(np.nanmax(rough, initial=0.0, where=np.isfinite(rough)))
        if top < FAR * max(usual, 1e-12) or top < NINES[0]:
            continue
        for size in (*NINES, *LARGEST):
            for value in (size, -size):
                there = values == value
                rest = rough[~there & np.isfinite(rough)]
                if 2 <= there.sum() <= MOST * len(x) and size > FAR * float(rest.max(initial=0.0)):
                    values = np.where(there, np.nan, values)
                    rough = np.abs(values)
                    found[value] = max(found.get(value, 0), int(there.sum()))
        raw.columns[name] = values if found else x
    for value, rows in found.items():
        raw.notes += (
            f"{value:g} stands in {rows:,} rows, far from every other reading: taken as no "
            "reading (a missing sample).",
        )
