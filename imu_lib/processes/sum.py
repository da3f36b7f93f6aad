"""An error model of one channel: a sum of processes and then its output stages."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.linalg import block_diag

from imu_lib.arrays import Array, ArrayLike
from imu_lib.errors import InputError, UndefinedFormError

from . import filter_memory, realisation
from .base import Process, StateSpace
from .heavy_tails import HeavyTails
from .images import images
from .low_pass import LowPass
from .sampled import avar_from_short_memory, cluster_size
from .stage import Stage
from .stages import Resolution, Spikes
from .wandering_level import WanderingLevel
from .white import Quantization


@dataclass(frozen=True)
class Sum:
    """A sum of independent processes, followed by output stages.

    Parameters
    ----------
    terms : tuple of Process
    stages : tuple of Stage
        Kept in the order of the chain, at most one of a kind.

    Every answer of a process is the sum of the answers of the terms, with the low-pass filter and
    the variance that spikes and rounding add where the answer is of the samples (`fs` given).
    """

    terms: tuple[Process, ...] = ()
    stages: tuple[Stage, ...] = ()

    def __post_init__(self) -> None:
        stages = tuple(sorted(self.stages, key=lambda stage: stage.place))
        kinds = [stage.name for stage in stages]
        if len(set(kinds)) < len(kinds):
            raise InputError(
                "a channel has at most one output stage of a kind; there are two of "
                + next(kind for kind in kinds if kinds.count(kind) > 1)
            )
        object.__setattr__(self, "terms", tuple(self.terms))
        object.__setattr__(self, "stages", stages)

    # -- structure -------------------------------------------------------------------------------
    def __add__(self, other: object) -> Sum:
        if isinstance(other, Sum):
            return Sum(self.terms + other.terms, self.stages + other.stages)
        if isinstance(other, Stage):
            return Sum(self.terms, self.stages + (other,))
        if isinstance(other, Process):
            return Sum(self.terms + (other,), self.stages)
        return NotImplemented

    def __iter__(self) -> Iterator[Process]:
        return iter(self.terms + self.stages)

    def __len__(self) -> int:
        return len(self.terms) + len(self.stages)

    def find(self, name: str) -> Process | None:
        """The first process or stage of that name, or None."""
        return next((p for p in self if p.name == name), None)

    def replaced(self, index: int, process: Process) -> Sum:
        """The sum with the process at `index` (terms first, then stages) replaced."""
        entries = list(self)
        entries[index] = process
        return Sum.of(entries)

    def without(self, index: int) -> Sum:
        """The sum without the process at `index` (terms first, then stages)."""
        entries = list(self)
        del entries[index]
        return Sum.of(entries)

    @classmethod
    def of(cls, processes: Iterable[Process]) -> Sum:
        """From any iterable of processes and stages."""
        processes = tuple(processes)
        return cls(
            tuple(p for p in processes if not isinstance(p, Stage)),
            tuple(p for p in processes if isinstance(p, Stage)),
        )

    @property
    def noise(self) -> Sum:
        """The terms that are random, with the stages."""
        return replace(self, terms=tuple(t for t in self.terms if not t.deterministic))

    @property
    def drifts(self) -> Sum:
        """The terms that are functions of time or temperature, without stages."""
        return Sum(tuple(t for t in self.terms if t.deterministic))

    @property
    def low_pass(self) -> LowPass | None:
        """The low-pass stage, if there is one."""
        return next((s for s in self.stages if isinstance(s, LowPass)), None)

    @property
    def tails(self) -> HeavyTails | None:
        """The heavy tails of its white noise, if it has them."""
        return next((s for s in self.stages if isinstance(s, HeavyTails)), None)

    @property
    def rounding(self) -> Quantization | None:
        """The quantization that comes of rounding the integrated output, if there is one."""
        return next((t for t in self.terms if isinstance(t, Quantization) and t.rounded), None)

    @property
    def complete(self) -> bool:
        """Whether every parameter has a value."""
        return all(p.complete for p in self)

    # -- parameters ------------------------------------------------------------------------------
    def labels(self) -> list[tuple[str, int, str]]:
        """(label, index, parameter name) of every parameter; a repeated name is numbered,
        `sigma_2`.
        """
        seen: dict[str, int] = {}
        out = []
        for index, process in enumerate(self):
            for parameter in process.parameters:
                seen[parameter.name] = seen.get(parameter.name, 0) + 1
                count = seen[parameter.name]
                out.append(
                    (
                        parameter.name if count == 1 else f"{parameter.name}_{count}",
                        index,
                        parameter.name,
                    )
                )
        return out

    def with_values(self, values: dict[str, Any]) -> Sum:
        """The sum with the parameters of these labels replaced."""
        entries = list(self)
        known = {label: (index, name) for label, index, name in self.labels()}
        for label, value in values.items():
            index, name = known[label]
            entries[index] = entries[index].with_(**{name: value})
        return Sum.of(entries)

    def to_json(self) -> list[dict[str, Any]]:
        """The channel's list in an error-model file."""
        return [process.to_json() for process in self]

    # -- questions -------------------------------------------------------------------------------
    def _closed(self, what: str) -> None:
        for stage in self.stages:
            if not isinstance(stage, (LowPass, Spikes, Resolution, HeavyTails, WanderingLevel)):
                raise UndefinedFormError(
                    f"{what} behind {stage.name} has no closed form; ask the sum without it"
                )

    def _added(self, fs: float | None) -> float:
        return 0.0 if fs is None else sum(stage.added_variance(fs) for stage in self.stages)

    def _psd_of_terms(self, f: Array, fs: float | None, *, behind: bool) -> Array:
        """Of the terms that are added behind the low-pass filter, or of those before it."""
        out = np.zeros(np.shape(f))
        for term in self.terms:
            if term.name != "constant" and term.behind_filter == behind:
                out = out + term.psd(f, fs)
        return out

    def psd(self, f: ArrayLike, fs: float | None = None) -> Array:
        """One-sided power spectral density, unit^2/Hz; see `Process.psd`."""
        self._closed("the power spectral density")
        f = np.asarray(f, dtype=float)
        low_pass = self.low_pass
        if low_pass is None or fs is None:
            out = self._psd_of_terms(f, fs, behind=False)
        else:
            rate, out = low_pass.ratio(fs) * fs, np.zeros(f.shape)
            for image, gain in images(low_pass, f, fs):
                out = out + gain * self._psd_of_terms(image, rate, behind=False)
        out = out + self._psd_of_terms(f, fs, behind=True)
        return out + 2.0 * self._added(fs) / (fs or 1.0)

    def avar(self, tau: ArrayLike, fs: float | None = None) -> Array:
        """Allan variance, unit^2; see `Process.avar`."""
        self._closed("the Allan variance")
        tau = np.asarray(tau, dtype=float)
        out = np.zeros(tau.shape)
        for term in self.terms:
            out = out + term.avar(tau, fs)
        if fs is None:
            return out
        m = cluster_size(tau, fs)
        if self.low_pass is not None:
            out = np.maximum(out + avar_from_short_memory(self._filter_effect(fs), m), 0.0)
        return out + self._added(fs) / m

    def _filter_effect(self, fs: float) -> Array:
        """Autocovariance that the filter adds (negative: removes), shape (k,), zero beyond."""
        noise = tuple(t for t in self.terms if not t.deterministic)
        stages = () if self.low_pass is None else (self.low_pass,)
        return filter_memory.added(Sum(noise, stages), Sum(noise), float(fs))

    def autocovariance(self, lag: ArrayLike, fs: float | None = None) -> Array:
        """Autocovariance, unit^2; see `Process.autocovariance`."""
        self._closed("the autocovariance")
        lag = np.asarray(lag, dtype=float)
        out = np.zeros(lag.shape)
        for term in self.terms:
            if term.name != "constant":
                out = out + term.autocovariance(lag, fs)
        if fs is None:
            return out
        d = np.rint(np.abs(lag) * fs).astype(int)
        if self.low_pass is not None:
            effect = self._filter_effect(fs)
            out = out + np.where(d < len(effect), effect[np.minimum(d, len(effect) - 1)], 0.0)
        return out + self._added(fs) * (d == 0)

    def mean(self, t: ArrayLike, temperature: Array | None = None) -> Array:
        """The deterministic part at times `t` s, same shape, before the output stages."""
        out = np.zeros_like(np.asarray(t, dtype=float))
        for term in self.terms:
            out = out + term.mean(t, temperature)
        return out

    def state_space(self) -> StateSpace:
        """The random terms as one state space; deterministic terms carry no state."""
        spaces = [term.state_space() for term in self.terms if not term.deterministic]
        rates = {space.rate for space in spaces if space.order}
        if len(rates) > 1:
            raise UndefinedFormError(
                "a difference equation and a continuous process have no common "
                "state space: discretise each with `discrete(dt)`"
            )
        if not spaces:
            empty = np.zeros((0, 0))
            return StateSpace(empty, empty, np.zeros(0), empty)
        return StateSpace(
            block_diag(*(s.F for s in spaces)),
            block_diag(*(s.Q for s in spaces)),
            np.concatenate([s.H for s in spaces]),
            block_diag(*(s.P0 for s in spaces)),
            sum(s.direct for s in spaces),
            next(iter(rates), None),
        )

    def simulate(
        self,
        n: int,
        fs: float,
        rng: np.random.Generator,
        *,
        temperature: Array | None = None,
        common: Array | None = None,
    ) -> Array:
        """A realisation behind all stages: ndarray, shape (n,), at `fs` Hz.

        `temperature`, shape (n,), in degC, is needed by a temperature term. `common`, shape (n,),
        is noise shared with other channels, added before the electronics.
        """
        return realisation.of(self, n, fs, rng, temperature=temperature, common=common)

    def behind(
        self,
        slow: Array,
        quick: Array,
        fs: float,
        rng: np.random.Generator,
        *,
        common: Array | None = None,
    ) -> Array:
        """What the stages behind the low-pass filter make of the slow and the quick noise, all of
        shape (n,).
        """
        return realisation.behind(self, slow, quick, fs, rng, common=common)
