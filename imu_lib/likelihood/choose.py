"""Which sum of processes? Candidates compared by an information criterion, the winner held to a
goodness-of-fit test.

BIC = k log(b) - 2 log L with b the number of statistics: the samples of one flat spectrum say
nothing about the slow end, so counting them would ask for too much. The winner of a comparison is
the best of what was offered, no more: its p-value says whether the record could have come from it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from imu_lib.arrays import Array
from imu_lib.processes import (
    Flicker,
    GaussMarkov,
    LowPass,
    Quantization,
    RandomWalk,
    Sum,
    WhiteNoise,
)

from .fit import Fit, fit
from .statistics import Statistics

#: The sums that describe inertial sensors in the literature, by name.
CANDIDATES = {
    "white": WhiteNoise() + Sum(),
    "white + walk": WhiteNoise() + RandomWalk(),
    "white + flicker": WhiteNoise() + Flicker(),
    "white + flicker + walk": WhiteNoise() + Flicker() + RandomWalk(),
    "white + Gauss-Markov": WhiteNoise() + GaussMarkov(),
    "white + Gauss-Markov + walk": WhiteNoise() + GaussMarkov() + RandomWalk(),
    "white + Gauss-Markov + flicker": WhiteNoise() + GaussMarkov() + Flicker(),
    "white + 2 Gauss-Markov": WhiteNoise() + GaussMarkov() + GaussMarkov(),
    "white + 2 Gauss-Markov + walk": WhiteNoise() + GaussMarkov() + GaussMarkov() + RandomWalk(),
}
#: Twice the log-likelihood below which a filter or a quantization is not worth its parameter at
#: the fast end.
EARNS = 10.0
#: A filter is looked for above this share of the rate.
FAST = 1 / 60


@dataclass(frozen=True)
class Choice:
    """A comparison of candidate sums.

    Attributes
    ----------
    name : str
        The winner.
    fit : Fit
        The winner's fit, with intervals.
    fits : dict of str to Fit
        Every candidate's maximum.
    weights : dict of str to float
        exp(-BIC/2), normalised: how the candidates share the confidence.
    p_value : float
        Goodness of fit of the winner.
    """

    name: str
    fit: Fit
    fits: dict[str, Fit] = field(repr=False)
    weights: dict[str, float] = field(repr=False)

    @property
    def p_value(self) -> float:
        return self.fit.p_value

    def rows(self) -> list[tuple[Any, ...]]:
        """(name, parameters, BIC - best, AIC - best, p-value) of each candidate, best first."""
        least = min(f.bic for f in self.fits.values()), min(f.aic for f in self.fits.values())
        rows = [
            (name, f.free, f.bic - least[0], f.aic - least[1], f.p_value)
            for name, f in self.fits.items()
        ]
        return sorted(rows, key=lambda row: row[2])


def choose(
    x: Any,
    fs: Any,
    *,
    candidates: Any = None,
    stages: Any = (),
    extra: Any = (),
    criterion: str = "bic",
    temperature: Array | None = None,
    estimates: bool = True,
) -> Choice:
    """Fit every candidate and take the best.

    Parameters
    ----------
    x : ndarray, shape (n,), or Statistics
    fs : float
        Rate, Hz (None with Statistics).
    candidates : dict of str to Sum, optional
        Default `CANDIDATES`.
    stages, extra : sequence of processes
        Added to each candidate: output stages (a low-pass filter), further terms (quantization, a
        ramp).
    criterion : "bic" or "aic"
    """
    if criterion not in ("bic", "aic"):
        raise ValueError(f"`criterion` must be 'bic' or 'aic', got {criterion!r}")
    stats = x if isinstance(x, Statistics) else Statistics.of(x, fs)
    sums = {
        name: Sum.of([*entry, *extra, *stages])
        for name, entry in (candidates or CANDIDATES).items()
    }
    fits = {
        name: fit(stats, None, entry, temperature=temperature, estimates=False)
        for name, entry in sums.items()
    }
    score = np.array([getattr(f, criterion) for f in fits.values()])
    name = list(fits)[int(np.argmin(score))]
    weight = np.exp(-(score - score.min()) / 2)
    best = fits[name]
    if estimates:
        noise = best.model.noise
        complete = len(noise) == len(sums[name].noise)
        best = fit(
            stats,
            None,
            sums[name],
            temperature=temperature,
            starts=[noise] if complete else (),
            grid=not complete,
        )
    return Choice(name, best, fits, dict(zip(fits, (weight / weight.sum()).tolist())))


@dataclass(frozen=True)
class FastEnd:
    """What the fast end of a record shows: stages and terms to add to every candidate, and how
    well they fit.

    `top` is the frequency in Hz up to which that holds, `note` says it in words (empty where the
    spectrum is flat).
    """

    stages: tuple[Any, ...]
    extra: tuple[Any, ...]
    top: float
    p_value: float
    note: str


def fast_end(x: Any, fs: Any) -> FastEnd:
    """Look for a low-pass filter or quantization at the fast end, where nothing else bends the
    spectrum.

    A moving average (its length found on a ten times finer grid than the sampling), Butterworth
    filters of orders 1 and 2 and quantization compete against a flat end; a slow slack (flicker and
    a walk) absorbs what is below. Where none of them fits, the spectrum is used up to the frequency
    where it stops being explicable.
    """
    stats = x if isinstance(x, Statistics) else Statistics.of(x, fs)
    fs = stats.rate
    top = fs / 2
    slack = WhiteNoise() + Flicker() + RandomWalk()
    whole: tuple[Any, ...] = ()
    for share in (1.0, 0.6, 0.35, 0.2, 0.1):
        top = share * fs / 2
        part = stats.between(FAST * fs if share > 0.3 else 0.1 * top, top)
        flat = fit(part, None, slack, estimates=False)
        options = [((), (), flat, "")]
        if share == 1.0:
            options += _filters(part, fs, slack)
        best = min(options, key=lambda o: -2 * o[2].loglike + EARNS * (len(o[0]) + len(o[1])))
        if best[2].p_value > 1e-4:
            return FastEnd(
                best[0],
                best[1],
                top,
                best[2].p_value,
                best[3]
                if share == 1.0
                else f"the spectrum above {top:.3g} Hz is neither flat nor that of a known filter "
                "and is left out",
            )
        whole = whole or best
    # nothing is explained perfectly: keep the description of the whole, if it earns its place
    stages, extra, found, note = whole
    return FastEnd(stages, extra, fs / 2, found.p_value, note)


def _filters(part: Statistics, fs: float, slack: Sum) -> Iterator[tuple[Any, ...]]:
    for order in (1, 2):
        found = fit(part, None, slack + LowPass(order=order), estimates=False)
        stage = found.model.low_pass
        assert stage is not None  # it is in the template
        yield (
            (stage,),
            (),
            found,
            f"the output is low-pass filtered (order {order}, -3 dB at {stage.cutoff:.3g} Hz)",
        )
    trial = {}
    for taps in np.unique(np.rint(np.geomspace(3, 80, 24)).astype(int)):
        trial[taps] = fit(
            part, None, slack + LowPass(taps=int(taps), rate=10 * fs), estimates=False
        )
    middle = max(trial, key=lambda taps: trial[taps].loglike)
    for taps in range(max(2, middle - 3), middle + 4):
        if taps not in trial:
            trial[taps] = fit(part, None, slack + LowPass(taps=taps, rate=10 * fs), estimates=False)
    taps = max(trial, key=lambda taps: trial[taps].loglike)
    yield (
        (LowPass(taps=int(taps), rate=10 * fs),),
        (),
        trial[taps],
        f"the output is the moving average over {taps / (10 * fs):.3g} s",
    )
    yield (
        (),
        (Quantization(),),
        fit(part, None, slack + Quantization(), estimates=False),
        "the spectrum rises as that of quantization does",
    )
