"""Records by name: the embedded twins, the public records of the registry, the short committed
file.

record = datasets.twin("3dm-gx3-25")          # drawn on first use, then read from the cache
record = datasets.load("adis16405_1")         # from IMU_LIB_DATA, the cache, or a download
"""

from __future__ import annotations

from imu_lib.datasets.embedded import chapter_record, twin
from imu_lib.datasets.places import example
from imu_lib.datasets.public import available, entry, fetch, load, paths, registry

__all__ = [
    "available",
    "chapter_record",
    "entry",
    "example",
    "fetch",
    "load",
    "paths",
    "registry",
    "twin",
]
