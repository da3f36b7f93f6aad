"""Allan variance: the overlapped deviation and how sure it is, reading coefficients off it, fitting a whole model to it.

`deviation(x, fs)` gives the curve, `read_off(curve)` what IEEE Std 952 reads from its slopes, `fit(curve, terms)` the
joint fit of a sum of processes, `characterise(x, fs)` one coefficient of each kind.
"""

from imu_lib.allan.deviation import AllanCurve, cluster_lengths, deviation

__all__ = ["AllanCurve", "cluster_lengths", "deviation"]
