"""Records that stay on disk: `open_long(path)` gives one where a file is long enough to need it."""

from imu_lib.long_record.folder import open_folder
from imu_lib.long_record.record import LongRecord, open_long

__all__ = ["LongRecord", "open_folder", "open_long"]
