"""Records that stay on disk: `open_long(path)` gives one where a file is long enough to need it,
`open_converted(path)` where it has to be read once into another file first, `open_folder(path)` of
a folder of logs; `on_disk(path)` whichever of these it is.
"""

from imu_lib.long_record.converted import open_converted
from imu_lib.long_record.cut import cut
from imu_lib.long_record.either import on_disk, worth_it
from imu_lib.long_record.folder import open_folder
from imu_lib.long_record.opening import open_long
from imu_lib.long_record.record import LongRecord

__all__ = [
    "LongRecord",
    "cut",
    "on_disk",
    "open_converted",
    "open_folder",
    "open_long",
    "worth_it",
]
