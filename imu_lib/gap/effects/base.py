"""What an entry of the catalogue is."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from imu_lib.arrays import Array
from imu_lib.gap.data import Data
from imu_lib.processes import LowPass, Sum
from imu_lib.samples.level_tails import Levels


class Effect:
    """An entry of the catalogue: its name in the model file, its physical cause in a sentence, the
    domain it shows in.
    """

    name: ClassVar[str] = ""
    cause: ClassVar[str] = ""
    domain: ClassVar[str] = "psd"
    #: What it acts on: record, samples, channel (its noise), noise (terms of the model).
    level: ClassVar[str] = "samples"
    #: Place among the others of its level.
    order: ClassVar[int] = 50
    #: Whether samples are drawn anew or scaled where it is found: evidences of records that differ
    #: in it cannot be compared.
    alters: ClassVar[bool] = False
    #: Whether it bends the fast end: a free base is fitted below it first.
    rolls_off: ClassVar[bool] = False
    #: Whether it comes of the levels of a converter.
    rounds: ClassVar[bool] = False
    #: The parameter that all axes of a sensor have in common, where it is of the sensor's design.
    of_design: ClassVar[str] = ""
    #: Log evidence by which what is too small of it to be found may mislead a comparison.
    unseen: ClassVar[float] = 0.0

    @property
    def key(self) -> str:
        """The name, and behind a colon which of several effects of that name it is."""
        return self.name

    def beside(self, low_pass: LowPass | None, fs: float) -> bool:
        """Whether the effect can stand beside a filter (or None) in the sensor."""
        return True

    def of_differences(self, parameters: dict[str, Any]) -> bool:
        """Whether such a finding beside a grid may come of rounding the integral: differenced
        errors, white noise the less, samples that agree.
        """
        return False

    def most_sure(self, parameters: dict[str, Any], beside: list[Effect], shared: float) -> float:
        """Confidence at the most in such a finding `beside` the effects of its channel, which
        shares noise of the density N `shared`.
        """
        return 1.0


@dataclass
class Finding:
    """An effect found in samples, time stamps or innovations.

    Attributes
    ----------
    effect, process
        What was found, and as an entry of the model.
    gain : float or None
        Log-likelihood against nothing being there; None where there is none (`evidence` says what
        there is).
    where : str
    intervals : dict
        95 % intervals by parameter.
    mask : ndarray of bool, shape (n,), optional
        The samples it touches.
    doubt : str, optional
        Why it may be something else.
    signal : dict, optional
        Of the record: channel -> what is taken out of it (n,).
    scale : ndarray, shape (n,), optional
        Of a channel: the level of the fast noise through the record, 1 on the whole or before.
    places : float
        Independent places among which this one has the largest gain.
    evidence : str
        What there is instead of a gain.
    counted : bool
        Whether it is counted in the samples, not inferred from them: what is left unexplained says
        nothing against it.
    """

    effect: Effect
    process: Any
    gain: float | None
    where: str
    intervals: dict[str, Any] = field(default_factory=dict)
    mask: np.ndarray | None = None
    doubt: str | None = None
    signal: dict[str, Array] | None = None
    scale: np.ndarray | None = None
    places: float = 1.0
    evidence: str = ""
    #: Of tails: the samples by level, and the variance of the noise before the rounding where the
    #: levels are those of the converter.
    levels: Levels | None = None
    variance: float | None = None
    #: Bands (low, high) in Hz that a vibration fills; whether the given model has it already.
    bands: list[tuple[float, float]] = field(default_factory=list)
    held: bool = False
    counted: bool = False


@dataclass(frozen=True)
class ChannelView:
    """What an effect on the noise of a channel sees.

    Attributes
    ----------
    x : ndarray, shape (n,)
        The samples, electronics undone.
    y : ndarray, shape (n,)
        Its innovations: the fast part as white noise of variance 1.
    raw : ndarray, shape (n,)
        As they came, NaN where one is missing or was thrown off, clipped or frozen.
    slow : ndarray, shape (n,)
        What `raw` has beside the fast noise.
    fs : float, Hz
    smooth : innovations.Smooth
        The spectrum that `y` was whitened by.
    given : Sum or None
        The given model.
    model_level : float
        Variance of the fast noise as a multiple of what the given noises have.
    temperature : ndarray, shape (n,), or None
    scale : ndarray, shape (n,), or 1
        The level of the fast noise that was undone in `x` and `y`.
    """

    x: np.ndarray
    y: np.ndarray
    raw: np.ndarray
    slow: np.ndarray
    fs: float
    smooth: Any
    given: Any
    model_level: float
    temperature: np.ndarray | None = None
    scale: np.ndarray | float = 1.0


class SignalEffect(Effect):
    """What is in a channel as a signal: fitted and taken out before the noises compete."""

    def find(self, data: Any) -> tuple[list[Any], Any]:
        """All there are, strongest first: [(finding, signal of shape (n,))], and the data without
        them.
        """
        raise NotImplementedError

    def foreseen(self, finding: Finding, given: Sum | None, data: Data) -> bool:
        """Whether the given model (or None) has it."""
        return False


class ChannelEffect(Effect):
    """What acts on the noise of a channel behind the electronics: its level, its distribution.

    The likeliest of all candidates enters, then all others are asked again. A candidate with a
    doubt does not enter; the doubt is told if nothing else resolves it.
    """

    level = "channel"

    def candidates(self, view: ChannelView) -> list[Finding]:
        """Where the effect may be, in what is left."""
        raise NotImplementedError

    def normal(self, y: Array, finding: Finding) -> Array:
        """Innovations of the levelled samples made normal, for the tests of what is left."""
        return y
