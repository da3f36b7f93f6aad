"""The verdict on a record: which grade of sensor, its datasheet, what is wrong, what limits the
record, and what to record next.
"""

from imu_lib.verdict.datasheet import datasheet
from imu_lib.verdict.downloads import write_downloads
from imu_lib.verdict.findings import anomalies, effect_name, limits, means, next_record
from imu_lib.verdict.grade import grades
from imu_lib.verdict.missing import missing

__all__ = [
    "anomalies",
    "datasheet",
    "effect_name",
    "grades",
    "limits",
    "means",
    "missing",
    "next_record",
    "write_downloads",
]
