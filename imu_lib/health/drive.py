"""The health of a drive: its IMU, its fixes, its reference."""

from __future__ import annotations

import numpy as np

from imu_lib.drive import Drive
from imu_lib.health.driven import disagreements
from imu_lib.health.record import of_record
from imu_lib.health.result import Health
from imu_lib.navigation import windows

TILTED = "The sensor was tilted"


def of_drive(drive: Drive) -> Health:
    """The health of a drive: its IMU, its fixes, its reference."""
    imu = of_record(drive.imu())
    step = np.diff(drive.gnss_time)
    usual = float(np.median(step))
    gnss = _gnss(drive, step)
    more = []
    if drive.gnss_time[0] > drive.time[-1] or drive.gnss_time[-1] < drive.time[0]:
        more.append(
            "The fixes and the IMU do not overlap in time: bring both to one clock; `imu-lib gap` "
            "and `imu-lib outages` take --gnss-offset S, the IMU's time of the first fix."
        )
    if gnss["gaps"]:
        count = int((step > 1.5 * usual).sum())
        more.append(
            f"{count} {'gap' if count == 1 else 'gaps'} between fixes, the longest "
            f"{float(step.max()):.3g} s."
        )
    if drive.gnss_velocity is None:
        more.append("The fixes have no velocity.")
    if not any("overlap" in m for m in more):
        more += [said] if (said := windows.uncovered(drive)) else []
        more += disagreements(drive)
    # a vehicle moves, accelerates, and nobody reads bias instability off it: none is a finding here
    keep = tuple(
        f
        for f in imu.findings
        if "of the kind tilt " not in f
        and not f.startswith(
            ("The sensor is", "In ", "The longest stretch", "The record lasts", TILTED)
        )
    )
    return Health(
        drive.name,
        drive.source,
        imu.clock,
        imu.channels,
        imu.motion,
        imu.temperature,
        gnss,
        drive.notes + imu.notes,
        keep + tuple(more),
        imu.faults,
    )


def _gnss(drive, step):
    """What is counted of the fixes; step (m-1,) s between them."""
    usual = float(np.median(step))
    gnss = {
        "fixes": len(drive.gnss_time),
        "rate": 1.0 / usual,
        "from": float(drive.gnss_time[0]),
        "to": float(drive.gnss_time[-1]),
        "gaps": [
            (float(drive.gnss_time[i]), float(step[i]))
            for i in np.argsort(-step)[:5]
            if step[i] > 1.5 * usual
        ],
        "velocity": drive.gnss_velocity is not None,
        "standard_deviations": drive.gnss_position_sd is not None,
        "reference": drive.has_reference,
        "lever_arm": None if drive.lever_arm is None else drive.lever_arm.tolist(),
        "max_speed": None
        if drive.gnss_velocity is None
        else float(np.nanmax(np.linalg.norm(drive.gnss_velocity[:, :2], axis=1))),
    }
    if drive.gnss_fix is not None:
        code, count = np.unique(drive.gnss_fix, return_counts=True)
        gnss["fix_codes"] = {f"{c:g}": int(n) for c, n in zip(code, count)}
    return gnss
