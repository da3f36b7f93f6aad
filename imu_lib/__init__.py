"""Errors of low-cost inertial sensors: what they are, how they are estimated, where simulation and
measurement disagree.

One idea holds the package together: an error model is a sum of named processes, and each process
knows its own closed forms (power spectral density, Allan variance, autocovariance, a realisation,
a state space). Estimators fit them, figures overlay them, the simulator draws them, and the
navigation filter takes its bias states from them.

Conventions, the same everywhere:

* SI inside and in every file: seconds, rad/s, m/s^2, rad, m. Datasheet units are named constants
  of `imu_lib.units`, used at the edge: ``2.42 * units.DEG_PER_SQRT_HOUR`` in,
  ``value / units.DEG_PER_SQRT_HOUR`` out.
* Time counts from the first sample. Body axes are forward, right, down; navigation axes north,
  east, down. An accelerometer at rest and level reads (0, 0, -g).
* Power spectral densities are one-sided unless a name says `_twosided`. White noise of
  coefficient N has the two-sided density N^2, the one-sided density 2 N^2 and the Allan variance
  N^2 / tau.
* Coefficients carry the symbols of IEEE Std 952 and 1293: Q, N, B, K, R, and sigma with a
  correlation time for the
  Gauss-Markov process. B is the flat part of the Allan deviation divided by 0.664.
* A sample is the point value of its process, white noise its average over the sampling interval.
  Closed forms given a rate `fs` are exact for the samples; without one they are the continuous
  limit.
* Estimators take `(x, fs)` arrays; options are keyword-only after the data; results are frozen
  dataclasses. A coefficient is an `Estimate(value, low, high)` with a 95 % interval; `value` is
  None where the record does not show the term, and `high` is then its 95 % upper limit.
* Randomness is one explicit `numpy.random.Generator`, passed down.

A chapter or a script begins with ``import imu_lib as imu`` and ``from imu_lib import allan,
plots``.
"""

from importlib import import_module, metadata
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from imu_lib.datasets import chapter_record, twin
    from imu_lib.drive import Drive
    from imu_lib.errors import ImuLibError, InputError, UndefinedFormError
    from imu_lib.estimate import Estimate
    from imu_lib.model import Model
    from imu_lib.presets import preset
    from imu_lib.readers import read_drive, read_record
    from imu_lib.record import Record

# Each name is imported when it is first asked for, so that `import imu_lib` and the commands start
# at once.
_HOME = {
    "ImuLibError": "errors",
    "InputError": "errors",
    "UndefinedFormError": "errors",
    "Estimate": "estimate",
    "Record": "record",
    "Drive": "drive",
    "Model": "model",
    "preset": "presets",
    "read_record": "readers",
    "read_drive": "readers",
    "twin": "datasets",
    "chapter_record": "datasets",
}
__all__ = sorted(_HOME)


def __getattr__(name):
    if name == "__version__":
        return metadata.version("imu_lib")
    if name not in _HOME:
        raise AttributeError(f"module `imu_lib` has no attribute `{name}`")
    value = getattr(import_module(f"imu_lib.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__():
    return sorted({*globals(), *_HOME})
