"""What every process answers about itself.

A process is a frozen dataclass whose fields are the parameters of the error-model file. A field
left at None is "to be estimated": such a process is a template for a fit and answers no question.

Conventions (the contract of the package)

- `psd` is one-sided, in unit^2/Hz. With `fs` it is the spectrum of the *samples* (aliasing and
  the sampling itself included), without it the continuous limit.
- `avar` is the Allan variance. With `fs` it is exact for the mean of `m = round(tau * fs)`
  samples, without it the continuous limit that IEEE Std 952 tables.
- A sample is the point value of the process; of white noise it is the average over the sampling
  interval, so that its variance is N^2 fs.
- A form that does not exist raises `UndefinedFormError`.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from imu_lib.arrays import Array, ArrayLike
from imu_lib.errors import InputError, UndefinedFormError

if TYPE_CHECKING:
    from .sum import Sum

#: Default of a parameter: "to be estimated", or "not of this kind". Typed as any value, since only
#: a complete process is asked.
FREE: Any = None


@dataclass(frozen=True)
class Parameter:
    """One parameter of a process: its name, what kind of quantity it is, and a line of help.

    `kind` is one of amplitude (scales with the signal, positive), signed (scales with the signal,
    may be negative), time (s, positive), frequency (Hz, positive), rate (1/s, positive),
    fraction, count, ratio, angle, other.
    """

    name: str
    kind: str
    doc: str
    optional: bool = False


#: Kinds of parameter that are positive and are fitted on a logarithmic scale.
POSITIVE_KINDS = ("amplitude", "time", "frequency", "rate", "ratio")


#: Correlation time in s below which a coloured noise is of the fast noise.
SHORT = 0.1

#: Every process that has been defined, by its name.
NAMED: dict[str, type[Process]] = {}


class Process:
    """Base of all processes. See the module's docstring for the conventions."""

    name: ClassVar[str] = ""
    parameters: ClassVar[tuple[Parameter, ...]] = ()
    #: Keys of the model file that are no names in Python, and the fields they stand for.
    keys: ClassVar[dict[str, str]] = {}
    #: A deterministic process is a function of time (or temperature): it has a `mean` and no
    #: noise.
    deterministic: ClassVar[bool] = False
    #: Whether its samples are jointly normal, so that its spectrum says all of it.
    gaussian: ClassVar[bool] = True

    @property
    def memory(self) -> float:
        """Time over which it remembers, s: a correlation time, infinite where there is no end to
        it, 0 where it forgets within a few samples.
        """
        return 0.0

    @property
    def fast(self) -> bool:
        """Whether it is of the fast noise, which a change of the noise level scales."""
        return False

    @property
    def onset(self) -> float:
        """When it begins to act, s from the first sample; 0 where it is there throughout."""
        return 0.0

    @property
    def behind_filter(self) -> bool:
        """Whether it is added behind the low-pass filter of the output."""
        return False

    # -- questions -------------------------------------------------------------------------------
    def psd(self, f: ArrayLike, fs: float | None = None) -> Array:
        """One-sided power spectral density, unit^2/Hz, at frequencies `f` in Hz, same shape.

        Raises
        ------
        UndefinedFormError
            If the process has no spectral density.
        """
        raise UndefinedFormError(f"{self.name} has no power spectral density")

    def avar(self, tau: ArrayLike, fs: float | None = None) -> Array:
        """Allan variance, unit^2, at averaging times `tau` in s, same shape.

        Raises
        ------
        UndefinedFormError
            If the Allan variance depends on more than the averaging time.
        """
        raise UndefinedFormError(f"{self.name} has no Allan variance of the averaging time alone")

    def autocovariance(self, lag: ArrayLike, fs: float | None = None) -> Array:
        """Autocovariance, unit^2, at `lag` in s, same shape.

        Raises
        ------
        UndefinedFormError
            If the process is not stationary.
        """
        raise UndefinedFormError(f"{self.name} is not stationary, so it has no autocovariance")

    def simulate(
        self,
        n: int,
        fs: float,
        rng: np.random.Generator,
        *,
        temperature: Array | None = None,
        start: float = 0.0,
    ) -> Array:
        """A realisation: ndarray, shape (n,), sampled at `fs` Hz from time `start` s on."""
        raise NotImplementedError

    def state_space(self) -> StateSpace:
        """The process as a `StateSpace` (continuous time).

        Raises
        ------
        UndefinedFormError
            If no finite state space exists.
        """
        raise UndefinedFormError(f"{self.name} has no finite state space")

    def mean(self, t: ArrayLike, temperature: Array | None = None) -> Array:
        """The deterministic part at times `t` in s, same shape; zero for a noise."""
        return np.zeros_like(np.asarray(t, dtype=float))

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        if cls.name:
            NAMED.setdefault(cls.name, cls)

    # -- parameters ------------------------------------------------------------------------------
    def __post_init__(self) -> None:
        for parameter in self.parameters:
            value = getattr(self, parameter.name)
            if value is None:
                continue
            if parameter.name == "phi":
                continue
            try:
                value = float(value)
            except (TypeError, ValueError):
                raise InputError(
                    f"process {self.name}: `{parameter.name}` must be a number, not {value!r}"
                ) from None
            if not math.isfinite(value):
                raise InputError(
                    f"process {self.name}: `{parameter.name}` must be finite, not {value}"
                )
            strict = parameter.kind in ("time", "frequency", "rate", "ratio")
            if value < 0 and (strict or parameter.kind == "amplitude") or value == 0 and strict:
                raise InputError(
                    f"process {self.name}: `{parameter.name}` must be "
                    f"{'above' if strict else 'at least'} zero, not {value:g}"
                )
            object.__setattr__(
                self, parameter.name, int(value) if parameter.kind == "count" else value
            )

    @property
    def complete(self) -> bool:
        """Whether every parameter has a value."""
        return all(getattr(self, p.name) is not None for p in self.parameters if not p.optional)

    def _require(self) -> None:
        if not self.complete:
            missing = [
                p.name for p in self.parameters if getattr(self, p.name) is None and not p.optional
            ]
            raise ValueError(
                f"`{self.name}` is a template: give {', '.join(missing)} a value first"
            )

    def with_(self, **parameters: Any) -> Self:
        """The same process with some parameters replaced."""
        return dataclasses.replace(self, **parameters)  # type: ignore[type-var]

    def to_json(self) -> dict[str, Any]:
        """The entry of the error-model file."""
        entry: dict[str, Any] = {"process": self.name}
        for parameter in self.parameters:
            value = getattr(self, parameter.name)
            if value is not None:
                entry[parameter.name] = list(value) if isinstance(value, tuple) else value
        return entry

    def __add__(self, other: Any) -> Sum:
        from .sum import Sum

        return Sum((self,)) + other


@dataclass(frozen=True)
class StateSpace:
    """dx/dt = F x + w, y = H x + v: a process (or a sum) as a filter wants it.

    Parameters
    ----------
    F : ndarray, shape (k, k), 1/s
    Q : ndarray, shape (k, k)
        Two-sided density of w.
    H : ndarray, shape (k,)
    P0 : ndarray, shape (k, k)
        Covariance of the state at the start (stationary where that exists, zero for a walk).
    direct : float
        Two-sided density of the white noise v on the output, N^2.
    rate : float or None
        Set where the process is a difference equation at that rate (an AR model): then F holds
        the transition matrix and Q the covariance of one step.
    """

    F: Array
    Q: Array
    H: Array
    P0: Array
    direct: float = 0.0
    rate: float | None = None

    @property
    def order(self) -> int:
        """Number of states."""
        return len(self.H)

    def discrete(self, dt: float) -> tuple[Array, Array]:
        """Transition matrix and step covariance over `dt` s, exact (Van Loan 1978, Eqs.
        1.1-1.4).
        """
        if self.rate is not None:
            if abs(dt * self.rate - 1.0) > 1e-6:
                raise ValueError(
                    f"`dt` must be 1/{self.rate:g} s: the process is a difference "
                    f"equation at that rate, not at {1 / dt:g} Hz"
                )
            return self.F.copy(), self.Q.copy()
        k = self.order
        if k == 0:
            return np.zeros((0, 0)), np.zeros((0, 0))
        from scipy.linalg import expm

        block = expm(np.block([[-self.F, self.Q], [np.zeros((k, k)), self.F.T]]) * dt)
        transition = block[k:, k:].T
        step = transition @ block[:k, k:]
        return transition, 0.5 * (step + step.T)
