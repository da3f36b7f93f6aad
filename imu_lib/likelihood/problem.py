"""A template (a sum whose unknown parameters are None) as a function of a vector of logarithms.

The expected density is linear in the squared amplitudes, one spectral shape per process, so the
derivative by an
amplitude is the shape itself; times and frequencies are differentiated numerically. Amplitudes may
sink to a floor
that no statistic notices: that is zero, and its logarithm stays finite.
"""

from dataclasses import dataclass, field

import numpy as np

from imu_lib.processes import Sum

from .evaluate import Images, gaussian, quantization_ends

#: Share of the density below which a process is zero.
FLOOR = 1e-9
POSITIVE = ("amplitude", "time", "frequency", "rate", "ratio")


@dataclass(frozen=True)
class Free:
    """One unknown: its label, the index of its process (terms, then stages), its name, its kind,
    log bounds.
    """

    label: str
    index: int
    name: str
    amplitude: bool
    low: float
    high: float


@dataclass
class Problem:
    """`stats` against `template`; `shift` (Regressors or None) holds mean shapes whose amplitudes
    are solved for.
    """

    stats: object
    template: Sum
    regressors: object = None
    free: tuple = ()
    _cache: dict = field(default_factory=dict)
    _images: dict = field(default_factory=dict)

    def __post_init__(self):
        self.free = tuple(self._unknowns())
        self.low = np.array([u.low for u in self.free])
        self.high = np.array([u.high for u in self.free])
        self.scale = float(np.sum(self.stats.power) / np.sum(self.stats.count))

    def _unknowns(self):
        fs, duration = self.stats.rate, self.stats.duration
        for label, index, name in self.template.labels():
            process = list(self.template)[index]
            kind = next(p for p in process.parameters if p.name == name)
            if getattr(process, name) is not None:
                continue
            if process.name == "low_pass":
                if name == "cutoff" and process.tunable:
                    top = 0.49 * (process.rate or fs)
                    yield Free(label, index, name, False, np.log(fs / 500), np.log(top))
                continue
            if kind.optional:
                continue
            if kind.kind not in POSITIVE:
                raise ValueError(
                    f"`model`: the parameter `{name}` of {process.name} can't be fitted by the "
                    "likelihood: give it a value"
                )
            if kind.kind == "amplitude":
                yield Free(label, index, name, True, -80.0, 80.0)
            elif kind.kind == "time":
                yield Free(label, index, name, False, np.log(2 / fs), np.log(duration))
            else:
                yield Free(label, index, name, False, np.log(0.5 / duration), np.log(fs / 2))

    def model(self, theta):
        """The template with its unknowns at exp(theta)."""
        return self.template.with_values(
            {u.label: float(np.exp(t)) for u, t in zip(self.free, theta)}
        )

    def _term(self, index, values):
        """Expected density of one term behind the stages, (b,)."""
        key = (index, *values)
        if key not in self._cache:
            if len(self._cache) > 4000:
                self._cache.clear()
            changed = {u.label: v for u, v in zip(self._own(index), values)}
            whole = self.template.with_values(changed)
            term, low_pass = whole.terms[index], whole.low_pass
            psd = (
                term.psd(self.stats.grid, self.stats.rate)
                if low_pass is None
                else self._images_of(low_pass).psd(term)
            )
            self._cache[key] = self.stats.collapse(psd) + quantization_ends(
                self.stats, Sum((term,))
            )
        return self._cache[key]

    def _images_of(self, low_pass):
        if low_pass not in self._images:
            if len(self._images) > 20:
                self._images.clear()
            self._images[low_pass] = Images(low_pass, self.stats.grid, self.stats.rate)
        return self._images[low_pass]

    def _own(self, index):
        """Unknowns that the density of a term depends on: its own and the filter's."""
        terms = len(self.template.terms)
        return [u for u in self.free if u.index == index or u.index >= terms]

    def parts(self, theta):
        """Expected density of each term, (terms, b), and of the rest (rounding, spikes)."""
        value = {u.label: float(np.exp(t)) for u, t in zip(self.free, theta)}
        rows = [self._scaled(i, value) for i in range(len(self.template.terms))]
        added = sum(
            s.added_variance(self.stats.rate) for s in self.template.stages if s.name != "low_pass"
        )
        return np.array(rows), 2 * added / self.stats.rate

    def _scaled(self, index, value):
        """One term: amplitudes scale a cached shape, so that only times and cutoffs cost an
        evaluation.
        """
        own = self._own(index)
        amplitude = next((u for u in own if u.amplitude), None)
        values = tuple(1.0 if u is amplitude else value[u.label] for u in own)
        shape = self._term(index, values)
        return shape if amplitude is None else value[amplitude.label] ** 2 * shape

    def density(self, theta):
        """Expected mean ordinate of each band, (b,)."""
        rows, rest = self.parts(theta)
        return rows.sum(axis=0) + rest

    def slopes(self, theta):
        """Density (b,) and its derivatives by theta, (k, b)."""
        rows, rest = self.parts(theta)
        out = np.empty((len(self.free), rows.shape[1]))
        terms = len(self.template.terms)
        for k, unknown in enumerate(self.free):
            if unknown.amplitude:
                out[k] = 2 * rows[unknown.index]
            else:
                step = 1e-3
                ends = []
                for sign in (1, -1):
                    moved = np.array(theta, float)
                    moved[k] += sign * step
                    value = {u.label: float(np.exp(t)) for u, t in zip(self.free, moved)}
                    which = range(terms) if unknown.index >= terms else [unknown.index]
                    ends.append(sum(self._scaled(i, value) for i in which))
                out[k] = (ends[0] - ends[1]) / (2 * step)
        return rows.sum(axis=0) + rest, out

    def loglike(self, theta):
        """Log-likelihood at theta, mean shapes solved for."""
        return self._value(self.density(theta))[0]

    def _value(self, expected):
        power = self.stats.power
        if self.regressors is not None:
            power = self.regressors.remaining(power, self.regressors.solve(expected)[0])
        return gaussian(self.stats, expected, power), power

    def score(self, theta):
        """Log-likelihood, its gradient (k,) and the Fisher information (k, k)."""
        expected, slopes = self.slopes(theta)
        value, power = self._value(expected)
        g = slopes / expected
        return (
            value,
            0.5 * g @ (power / expected - self.stats.count),
            0.5 * (g * self.stats.count) @ g.T,
        )

    def floors(self, theta):
        """Log-amplitude of each unknown below which its process is zero, (k,); bounds for the
        others.
        """
        rows, rest = self.parts(theta)
        total = np.maximum(rows.sum(axis=0) + rest, 1e-300)
        low = self.low.copy()
        for k, u in enumerate(self.free):
            if u.amplitude:
                row = self._scaled(
                    u.index,
                    {**{v.label: float(np.exp(t)) for v, t in zip(self.free, theta)}, u.label: 1.0},
                )
                low[k] = 0.5 * np.log(FLOOR / np.max(row / total))
        return low
