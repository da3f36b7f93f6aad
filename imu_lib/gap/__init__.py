"""Where simulation and measurement disagree: find it, name it, add it, show that the gap shrinks,
go on.

    found = gap.close(record, model)  # or gap.close(record): the base is fitted first
    found.steps                       # what is missing: channel, effect, parameters, confidence
    found.model                       # the model that holds it
    found = gap.close(drive, model)   # a drive: what the filter does not know (`gap.drive`)

The order of the work: what the electronics did to single samples, changes of the noise level,
lines; then all noises and drifts of the catalogue compete on one likelihood (`likelihood`), one is
added at a time (`rounds`), and what is left is tested (`residual_tests`). `gauge` measures the gap
before and after. What shakes a record is found in a room of its own (`vibrations`), so are single
samples (`samples`) and simulations (`ensembles`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from imu_lib.drive import Drive
from imu_lib.ensembles.ensemble import Index
from imu_lib.long_record import LongRecord
from imu_lib.model import Model
from imu_lib.record import Record

from . import left_out
from .effects import CATALOGUE
from .found import ChannelReport, Report
from .loop import close as _of_record
from .steps import Step

if TYPE_CHECKING:
    from .drive import DriveReport

__all__ = ["CATALOGUE", "ChannelReport", "Index", "Report", "Step", "close"]


def close(
    measured: Record | LongRecord | Drive, model: Model | None = None, **options: Any
) -> Report | DriveReport:
    """What is missing from `model`, held against a record at rest or against a drive.

    Parameters
    ----------
    measured : Record, LongRecord or Drive
        A record on disk is looked at by `gap.long`, in bounded memory.
    model : Model, optional
        None: the base is fitted first.
    **options
        Of `gap.loop.close` for a record (a `Report` comes back), of `gap.drive.close` for a drive
        (a `gap.drive.DriveReport`); the `to_json` of either is what `imu-lib gap --json` writes.

    Raises
    ------
    ValueError, InputError
        As `gap.loop.close` or `gap.drive.close`.
    """
    if isinstance(measured, Drive):
        from .drive import close as of_drive  # the navigation filter is not needed for a record

        return of_drive(measured, model, **options)
    if isinstance(measured, LongRecord):
        from .long import close as of_long

        return of_long(measured, model, **options)
    return left_out.looked_at(_of_record(measured, model, **options), measured, model, **options)
