"""Series longer than memory: kept in scratch files, taken in chunks, summed up in one pass.

`Scratch` holds a series on disk, `Windowed` is the base of every one-pass statistic: a pass over
two halves, merged, equals a pass over the whole.
"""

from imu_lib.stream.decimation import PASSED, Halved, original
from imu_lib.stream.fourier import inverse
from imu_lib.stream.scratch import CHUNK, LONG, SUMMED, Scratch, bounds
from imu_lib.stream.windowed import Keep, LagSums, Means, Products, Segments, Windowed

__all__ = [
    "CHUNK",
    "LONG",
    "PASSED",
    "SUMMED",
    "Halved",
    "Keep",
    "LagSums",
    "Means",
    "Products",
    "Scratch",
    "Segments",
    "Windowed",
    "bounds",
    "inverse",
    "original",
]
