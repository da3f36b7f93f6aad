"""Allan variance: the overlapped deviation and how sure it is, reading coefficients off it,
fitting a whole model to it.

`deviation(x, fs)` gives the curve, `read_off(curve)` what IEEE Std 952 reads from its slopes,
`fit(curve, terms)` the joint fit of a sum of processes, `characterise(x, fs)` one coefficient of
each kind.
"""

from imu_lib.allan.best import characterise, fit_any, from_curve, short_filter
from imu_lib.allan.confidence import degrees_of_freedom, papers_error
from imu_lib.allan.deviation import AllanCurve, cluster_lengths, deviation
from imu_lib.allan.fit import AllanFit, fit, fit_best
from imu_lib.allan.flat import flat_gradient, flat_time
from imu_lib.allan.kinds import by_allantools
from imu_lib.allan.read_off import FLAT, LINES, PEAK, PEAK_TIME, Reading, of_record, read_off

__all__ = [
    "FLAT",
    "LINES",
    "PEAK",
    "PEAK_TIME",
    "AllanCurve",
    "AllanFit",
    "Reading",
    "by_allantools",
    "characterise",
    "cluster_lengths",
    "degrees_of_freedom",
    "deviation",
    "fit",
    "fit_any",
    "fit_best",
    "flat_gradient",
    "flat_time",
    "from_curve",
    "of_record",
    "papers_error",
    "read_off",
    "short_filter",
]
