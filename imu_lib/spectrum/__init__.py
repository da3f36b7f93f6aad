"""Power spectral density: Welch's estimate, frequency averaging, and the coefficients read off its
slopes.

`welch(x, fs)` gives the estimate, `average(spectrum)` the same in bands of equal width on the
logarithmic axis (IEEE Std 1293), `read_off(averaged)` what lines of slope 2, 0, -1 and -2 say,
`characterise(x, fs)` all in one.
"""

from imu_lib.spectrum.density import Spectrum, average, welch
from imu_lib.spectrum.read_off import LINES, Reading, characterise, coefficient, read_off

__all__ = [
    "LINES",
    "Reading",
    "Spectrum",
    "average",
    "characterise",
    "coefficient",
    "read_off",
    "welch",
]
