"""Every method on one channel: from arrays, or from passes over a long one."""

from dataclasses import dataclass, field

import numpy as np

from imu_lib import allan, autocorrelation, autoregressive, likelihood, passes, spectrum
from imu_lib.estimate import Estimate
from imu_lib.processes import Flicker, GaussMarkov, RandomWalk, Sum
from imu_lib.spectrum import one_pass as averaged
from imu_lib.stream import SUMMED

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
#: Shortest stretch that a pass goes over, samples.
SHORTEST = 1 << 17


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
        (whether the residuals pass for white).
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
    for the likelihood. A long channel goes through one pass.
    """
    if x.size > SUMMED:
        whole = passes.over_array(x, fs)
        return of_passes(name, whole, _passes_over(parts, x, whole, fs), fs, candidates)
    notes = []
    stats = likelihood.Statistics.of(parts, fs, exclude_lines=True)
    variance = np.var(np.concatenate(parts))
    choice, parameters, density = fitted(stats, variance, fs, candidates, notes)
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
    ar = _autoregressive(lambda: autoregressive.characterise(x, fs), notes)
    return Channel(name, *read.values(), ar, parameters, choice, curve, density, tuple(notes))


def usable(lengths):
    """Which of these stretches a long channel's likelihood passes over, list of bool: those of a
    share of the longest that a pass can take; none where gaps cut all of them short.
    """
    least = max(SHARE * max(lengths), SHORTEST)
    return [n >= least for n in lengths]


def _passes_over(parts, x, whole, fs):
    keep = usable([part.size for part in parts])
    if not any(keep) or [part.size for part in parts] == [x.size]:
        return [whole]
    return [passes.over_array(p, fs, curves=False) for p, ok in zip(parts, keep) if ok]


def of_long(record, name, candidates=None) -> Channel:
    """All methods on one channel of a record on disk."""
    fs, runs = record.rate, record.continuous()
    n = int(runs[-1, 2] + runs[-1, 1] - runs[-1, 0] - runs[0, 2])
    whole = passes.over(record.pieces(name, runs), n, fs)
    lengths = (record.runs[:, 1] - record.runs[:, 0]).tolist()
    keep = usable(lengths)
    parts = [whole]
    if any(keep) and lengths != [n]:
        parts = [
            passes.over(record.pieces(name, record.runs[i : i + 1]), lengths[i], fs, curves=False)
            for i in np.flatnonzero(keep)
        ]
    return of_passes(name, whole, parts, fs, candidates)


def of_passes(name, whole, parts, fs, candidates=None) -> Channel:
    """All methods on one long channel.

    Parameters
    ----------
    whole : imu_lib.passes.Pass
        Over the longest stretch without a gap, with curves.
    parts : list of Pass
        Over all the stretches, for the likelihood.
    """
    notes = []
    stats = statistics(parts, fs, exclude_lines=True)
    n, mean = sum(p.n for p in parts), sum(p.mean * p.n for p in parts)
    variance = sum(p.n * (p.variance + (p.mean - mean / n) ** 2) for p in parts) / n
    choice, parameters, density = fitted(stats, variance, fs, candidates, notes)
    filters = [s for s in choice.fit.model.stages if s.name == "low_pass"]
    curve = whole.allan()
    read = {
        "allan": _asked(
            lambda: allan.from_curve(curve, stages=filters),
            "Allan variance",
            SYMBOLS["allan"],
            notes,
        ),
        "psd": _asked(
            lambda: averaged.characterise(whole.spectrum()), "spectrum", SYMBOLS["psd"], notes
        ),
        "gauss_markov": _asked(
            whole.autocorrelation, "autocorrelation", SYMBOLS["gauss_markov"], notes
        ),
    }
    ar = _autoregressive(whole.autoregressive, notes)
    return Channel(name, *read.values(), ar, parameters, choice, curve, density, tuple(notes))


def statistics(parts, fs, *, exclude_lines=False) -> likelihood.Statistics:
    """What the likelihood needs, from passes over all the stretches of a channel."""
    slow, fast = zip(*(part.scales() for part in parts))
    # the lowest frequency at which the two scales of a stretch meet serves all
    seam = min(part.seam for part in parts)
    return likelihood.of_scales(slow, fast, fs, seam, exclude_lines=exclude_lines)


def _autoregressive(method, notes):
    try:
        return method()
    except ValueError as error:
        notes.append(f"autoregressive model: {plainly(error)}.")
        return {"order": None, "phi": [], "sigma": None, "white": None}


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


def fitted(stats, variance, fs, candidates, notes):
    """The likelihood's choice on a channel of this variance: (Choice, estimates with upper limits,
    (f, density, model's density)).
    """
    if stats.lines:
        share = sum(line[1] ** 2 for line in stats.lines) / variance
        notes.append(
            f"{len(stats.lines)} ordinate{'s' * (len(stats.lines) > 1)} of the spectrum stand out "
            f"as lines and are left out of the fit; the strongest is at {stats.lines[0][0]:.4g} "
            f"Hz, together they have {share:.2g} of the variance."
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
            f"No candidate explains the whole spectrum (p = {choice.p_value:.1g}; the largest "
            f"misfit is near {used.frequency[int(np.argmax(scores))]:.3g} Hz): the intervals hold "
            "for the model, not for what it leaves out; `imu-lib gap` looks for what is missing."
        )
    parameters = dict(choice.fit.parameters)
    parameters.update(limits(used, choice.fit.model, parameters))
    long = [p.correlation_time for p in choice.fit.model.terms if p.name == "gauss_markov"]
    if long and max(long) > stats.duration / 20:
        notes.append(
            f"The record holds only {stats.duration / max(long):.2g} correlation times of "
            f"{max(long):.3g} s."
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
