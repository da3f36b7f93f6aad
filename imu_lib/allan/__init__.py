"""Allan variance: the overlapped deviation and how sure it is, reading coefficients off it, fitting a whole model to it.

`deviation(x, fs)` gives the curve, `read_off(curve)` what IEEE Std 952 reads from its slopes, `fit(curve, terms)` the
joint fit of a sum of processes, `characterise(x, fs)` one coefficient of each kind.
"""

from imu_lib.allan.deviation import AllanCurve, cluster_lengths, deviation
from imu_lib.allan.fit import AllanFit, fit
from imu_lib.allan.limits import flat_time

__all__ = ["AllanCurve", "AllanFit", "cluster_lengths", "deviation", "fit", "flat_time"]
