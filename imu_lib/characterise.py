"""Every method on every channel of a record at rest: one result, one error model.

Allan variance, spectrum, autocorrelation and autoregressive models read coefficients off their own
curves; the
likelihood fits whole sums of processes, chooses between them and gives the error model that is
saved. What the
record cannot support is said in the notes of the result instead of being left out in silence.
"""

import os
from dataclasses import dataclass, field

import numpy as np
from joblib import Parallel, delayed

from imu_lib import allan, autocorrelation, autoregressive, likelihood, spectrum, units
from imu_lib.errors import InputError
from imu_lib.estimate import Estimate
from imu_lib.model import Model
from imu_lib.processes import Flicker, GaussMarkov, RandomWalk, Sum
from imu_lib.record import Record

#: What each method reports, in the order of the tables.
SYMBOLS = {
    "allan": ("Q", "N", "B", "K", "R"),
    "psd": ("Q", "N", "B", "K"),
    "gauss_markov": ("sigma", "correlation_time"),
}
#: Shortest stretch that takes part, as a share of the longest.
SHARE = 0.1
#: Below this the model chosen is no description of the record.
UNLIKELY = 1e-3
#: Records above this many samples are worth a process per axis.
PARALLEL = 150_000


@dataclass(frozen=True)
class Channel:
    """The result on one channel.

    Attributes
    ----------
    allan, psd, gauss_markov, likelihood : dict of str to Estimate
        Coefficients with 95 % intervals, SI. Those of `likelihood` bear the names of the model
        file.
    autoregressive : dict
        `order`, `phi` (list of Estimate), `sigma` (Estimate, of the driving noise), `white`
        (whether the residuals pass
        for white).
    choice : imu_lib.likelihood.Choice
        Candidates, the winner's fit, p-value.
    curve : imu_lib.allan.AllanCurve
    density : tuple of ndarray
        Frequencies and averaged one-sided density, the chosen model's density there.
    notes : tuple of str
    """

    name: str
    allan: dict
    psd: dict
    gauss_markov: dict
    autoregressive: dict
    likelihood: dict
    choice: likelihood.Choice = field(repr=False)
    curve: allan.AllanCurve = field(repr=False)
    density: tuple = field(repr=False)
    notes: tuple = ()

    @property
    def model(self) -> Sum:
        """The error model the likelihood chose."""
        return self.choice.fit.model

    def to_json(self):
        """The contract's entry of this channel, with the chosen sum, its p-value and the notes
        beside it.
        """
        out = {
            key: {symbol: e.to_json() for symbol, e in getattr(self, key).items()}
            for key in ("allan", "psd", "likelihood", "gauss_markov")
        }
        out["autoregressive"] = _plain_ar(self.autoregressive)
        out["model"] = {
            "sum": self.choice.name,
            "p_value": self.choice.p_value,
            "processes": self.model.to_json(),
        }
        out["notes"] = list(self.notes)
        return out


def _plain_ar(found):
    """Order, coefficients and whiteness as numbers, their intervals beside them."""
    phi, sigma = found["phi"], found["sigma"]
    if not isinstance(sigma, Estimate):
        return dict(found)
    return {
        **found,
        "phi": [e.value for e in phi],
        "sigma": sigma.value,
        "intervals": {"phi": [[e.low, e.high] for e in phi], "sigma": [sigma.low, sigma.high]},
    }


@dataclass(frozen=True)
class Characterisation:
    """The result on a record: `channels` by name, its rate in Hz, its duration in s, notes."""

    channels: dict
    rate: float
    duration: float
    name: str
    source: str
    notes: tuple = ()

    def __getitem__(self, channel):
        return self.channels[channel]

    @property
    def model(self) -> Model:
        """The error model of all channels."""
        return Model(
            {name: c.model for name, c in self.channels.items()},
            rate=self.rate,
            name=self.name,
            source="likelihood fit of " + (self.source or self.name or "a record"),
        )

    def to_json(self):
        return {
            "channels": {name: c.to_json() for name, c in self.channels.items()},
            "rate": self.rate,
            "duration": self.duration,
            "name": self.name,
            "source": self.source,
            "notes": list(self.notes),
        }


def characterise(
    record: Record, *, channels=None, candidates=None, workers=None, progress=None
) -> Characterisation:
    """All methods on all channels.

    Parameters
    ----------
    record : Record
    channels : sequence of str, optional
        Default all.
    candidates : dict of str to Sum, optional
        Sums the likelihood chooses from, default `likelihood.CANDIDATES`.
    workers : int, optional
        Processes; default one per core for long records.
    progress : callable, optional
        Called with the name of each channel when it is done.

    Raises InputError where the record has fewer than 100 samples without a gap, or no channel that
    ever changes.
    A channel that never changes is left out, and a note says so.
    """
    gap_free = record.continuous().enough()
    flat = [name for name in channels or record.channel_names if np.ptp(gap_free[name]) == 0]
    names = tuple(name for name in channels or record.channel_names if name not in flat)
    if not names:
        raise InputError(
            f"{record.source or 'The record'}: no channel ever changes, so there is no noise to describe; check the logger."
        )
    notes = tuple(note for note in gap_free.notes if note not in record.notes)
    filled = record.uniform() if notes else gap_free
    tasks = [
        (name, gap_free[name], stretches(filled[name]), record.rate, candidates) for name in names
    ]
    cores = workers or (min(len(tasks), os.cpu_count() or 1) if record.n > PARALLEL else 1)
    found = {}
    with Parallel(n_jobs=cores, return_as="generator_unordered", max_nbytes=None) as pool:
        for result in pool(delayed(channel)(*task) for task in tasks):
            found[result.name] = result
            if progress is not None:
                progress(result.name)
    return Characterisation(
        {name: found[name] for name in names},
        record.rate,
        record.duration,
        record.name,
        record.source,
        record.notes + notes + _of_record(record, flat),
    )


def _of_record(record, flat):
    notes = [f"{name} never changes and is left out." for name in flat]
    gaps = record.gaps()
    if gaps:
        longest = max(gaps, key=lambda gap: gap.duration)
        notes.append(
            f"{len(gaps)} gap{'s' * (len(gaps) > 1)} in time, the longest {longest.duration:.3g} s at "
            f"{longest.start:.6g} s: the likelihood takes every stretch, the other methods the longest one."
        )
    if record.duration < 600:
        notes.append(
            f"The record is {units.duration(record.duration)} long: bias instability, walks and correlation times "
            "take hours; their limits say little."
        )
    return tuple(notes)


def stretches(x):
    """The runs of numbers in a channel with NaN, those of at least a tenth of the longest, as a
    list.
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[0], np.isfinite(x).astype(int), [0]])))
    runs = [x[a:b] for a, b in zip(edges[::2], edges[1::2])]
    longest = max(len(run) for run in runs)
    return [run for run in runs if len(run) >= max(SHARE * longest, 16)] or [max(runs, key=len)]


def channel(name, x, parts, fs, candidates=None) -> Channel:
    """All methods on one channel: `x` (n,) without gaps for the curves, `parts` (all stretches)
    for the likelihood.
    """
    notes = []
    choice, parameters, density = fitted(parts, fs, candidates, notes)
    filters = [s for s in choice.fit.model.stages if s.name == "low_pass"]
    curve = allan.deviation(x, fs)
    read = {
        "allan": _asked(
            lambda: allan.characterise(x, fs, stages=filters),
            "Allan variance",
            SYMBOLS["allan"],
            notes,
        ),
        "psd": _asked(lambda: spectrum.characterise(x, fs), "spectrum", SYMBOLS["psd"], notes),
        "gauss_markov": _asked(
            lambda: autocorrelation.characterise(x, fs),
            "autocorrelation",
            SYMBOLS["gauss_markov"],
            notes,
        ),
    }
    try:
        ar = autoregressive.characterise(x, fs)
    except ValueError as error:
        ar = {"order": None, "phi": [], "sigma": None, "white": None}
        notes.append(f"autoregressive model: {plainly(error)}.")
    return Channel(
        name,
        read["allan"],
        read["psd"],
        read["gauss_markov"],
        ar,
        parameters,
        choice,
        curve,
        density,
        tuple(notes),
    )


def _asked(method, title, symbols, notes):
    try:
        return method()
    except ValueError as error:
        notes.append(f"{title}: {plainly(error)}.")
        return {symbol: Estimate.absent() for symbol in symbols}


def plainly(error) -> str:
    """An estimator's complaint about its arguments as words about the record."""
    return (
        str(error)
        .rstrip(".")
        .replace("`curve`", "the Allan curve")
        .replace("`x`", "the channel")
        .replace("`", "")
    )


def fitted(parts, fs, candidates, notes):
    """The likelihood's choice on a channel: (Choice, estimates with upper limits, (f, density,
    model's density)).
    """
    stats = likelihood.Statistics.of(parts, fs, exclude_lines=True)
    if stats.lines:
        share = sum(line[1] ** 2 for line in stats.lines) / np.var(np.concatenate(parts))
        notes.append(
            f"{len(stats.lines)} ordinate{'s' * (len(stats.lines) > 1)} of the spectrum stand out as lines and "
            f"are left out of the fit; the strongest is at {stats.lines[0][0]:.4g} Hz, together they have "
            f"{share:.2g} of the variance."
        )
    end = likelihood.fast_end(stats, None)
    if end.note:
        notes.append(end.note[0].upper() + end.note[1:] + ".")
    used = stats if end.top >= fs / 2 else stats.between(0.0, end.top)
    choice = likelihood.choose(
        used, None, candidates=candidates, stages=end.stages, extra=end.extra
    )
    if choice.p_value < UNLIKELY:
        scores = np.abs(likelihood.residuals(used, choice.fit.model))
        notes.append(
            f"No candidate explains the whole spectrum (p = {choice.p_value:.1g}; the largest misfit is near "
            f"{used.frequency[int(np.argmax(scores))]:.3g} Hz): the intervals hold for the model, not for what "
            "it leaves out; `imu-lib gap` looks for what is missing."
        )
    parameters = dict(choice.fit.parameters)
    parameters.update(limits(used, choice.fit.model, parameters))
    long = [p.correlation_time for p in choice.fit.model.terms if p.name == "gauss_markov"]
    if long and max(long) > stats.duration / 20:
        notes.append(
            f"The record holds only {stats.duration / max(long):.2g} correlation times of {max(long):.3g} s."
        )
    order = np.argsort(stats.frequency, kind="stable")  # stretches come one after the other
    measured, expected = (
        stats.power / stats.count,
        likelihood.density(stats, choice.fit.model.noise),
    )
    return choice, parameters, (stats.frequency[order], measured[order], expected[order])


def limits(stats, model, known):
    """Upper limits of the walk and of the Gauss-Markov process where the chosen sum lacks them."""
    out = {}
    for process, labels in ((RandomWalk(), ("K",)), (GaussMarkov(), ("sigma", "correlation_time"))):
        if any(label in known for label in labels) or (
            labels[0] == "sigma" and any(isinstance(t, Flicker) for t in model.terms)
        ):
            continue
        held = Sum.of(
            [
                type(p)(**{q.name: None for q in p.parameters}) if p in model.terms else p
                for p in model
            ]
        )
        found = likelihood.fit(stats, None, held + process)
        # chosen without it, so not shown; a value that the fit would give anyway is inside the
        # limit
        out.update({label: Estimate.absent(found[label].high) for label in labels})
    return out


__all__ = [
    "Channel",
    "Characterisation",
    "channel",
    "characterise",
    "fitted",
    "limits",
    "plainly",
    "stretches",
]
