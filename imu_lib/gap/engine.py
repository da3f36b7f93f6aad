"""One likelihood for slow and fast together, its maximum, and the evidence of what was fitted.

log L = exact Gaussian of the differenced block means + gamma likelihood of the binned spectrum
above their Nyquist frequency. Drifts are columns of a regression in the slow part, their
amplitudes profiled out by generalised least squares.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from imu_lib.gap import fast, slow, unit_shapes

#: Widths of the log-uniform priors: three decades of amplitude, four of time.
AMPLITUDE_WIDTH, TIME_WIDTH = np.log(1e3), np.log(1e4)
#: Gain in log-likelihood below which a screened candidate is not fitted.
SCREEN = 4.0


def measured(s, extra):
    """A model's spectrum `s` with the density that the electronics add; coarse rounding may add
    less than nothing, but leaves a rest.
    """
    return np.maximum(s + extra, 1e-3 * s)


class Data:
    """A clean, evenly sampled channel and what the likelihood needs of it.

    Parameters
    ----------
    x : ndarray, shape (n,)
    fs : float, Hz
    white : float
        Variance that the electronics add to every sample (rounding), unit^2.
    extra : ndarray, optional
        One-sided density that the electronics add in the bins of the spectrum, where it is not 2
        white / fs.
    blind : ndarray of bool, optional
        Bins that tell nothing: the stop band of a filter, where samples that were filled in are
        stronger than the signal.
    """

    def __init__(
        self, x, fs: float, *, white: float = 0.0, temperature=None, extra=None, blind=None
    ):
        self.x, self.fs, self.white, self.blind = x, float(fs), white, blind
        self.n = len(x)
        self.m = slow.block_length(self.n, fs)
        self.layout = fast.bins(self.n, self.fs, self.m)
        if blind is not None and blind.any():
            self.layout = replace(self.layout, nu=np.where(blind, 0.0, self.layout.nu))
        self.means = slow.block_means(x, self.m)
        self.d = np.diff(self.means)
        self.k = len(self.d)
        self.block_time = (np.arange(self.k + 1) + 0.5) * self.m / fs
        self.duration = self.n / fs
        self.temperature = temperature
        self.block_temperature = (
            None if temperature is None else slow.block_means(temperature, self.m)
        )
        self.extra = np.full(len(self.layout.f), 2.0 * white / fs) if extra is None else extra
        self._z = None
        self._p = None

    @property
    def z(self):
        """Transform of the tapered record."""
        if self._z is None:
            self._z = fast.transform(self.x)
        return self._z

    @property
    def power(self):
        """Binned periodogram, one-sided, unit^2/Hz."""
        if self._p is None:
            self._p = fast.average(np.abs(self.z) ** 2, self.layout) / self.fs
        return self._p

    def minus(self, signal) -> Data:
        """The channel without a deterministic signal."""
        return Data(
            self.x - signal,
            self.fs,
            white=self.white,
            temperature=self.temperature,
            extra=self.extra,
            blind=self.blind,
        )

    def column(self, values_at_blocks) -> np.ndarray:
        """A drift given at the block means as a column of the regression."""
        return np.diff(values_at_blocks)


@dataclass(frozen=True)
class Fit:
    """A maximum of the likelihood.

    `terms` are all noise terms, `vector` and `cov` the free parameters (log scale) with their
    covariance, `beta` and
    `beta_cov` the amplitudes of the regression columns, `evidence` the log marginal likelihood by
    Laplace's method.
    """

    ll: float
    terms: tuple
    low_pass: object
    vector: np.ndarray
    cov: np.ndarray
    beta: np.ndarray
    beta_cov: np.ndarray
    evidence: float
    slots: tuple = field(default=())


@dataclass(frozen=True)
class Slot:
    """A process some of whose parameters are free: `index` in the terms (-1: the low-pass filter),
    names, prior widths, bounds.
    """

    index: int
    names: tuple
    low: tuple
    high: tuple
    widths: tuple

    def read(self, process):
        return [np.log(getattr(process, name)) for name in self.names]

    def write(self, process, vector):
        return process.with_(**{name: float(np.exp(v)) for name, v in zip(self.names, vector)})

    def relative(self, process, name: str) -> np.ndarray:
        """Relative change of the process's parameter `name` with each entry of the vector."""
        return (np.array(self.names) == name).astype(float)


class Likelihood:
    """The likelihood of a `Data` as a function of the free slots of a list of terms."""

    def __init__(self, data: Data, terms, slots=(), *, low_pass=None, columns=None, power=None):
        self.data, self.terms, self.slots, self.low_pass = data, list(terms), tuple(slots), low_pass
        self.columns = None if columns is None or columns.shape[1] == 0 else columns
        self.power_full = data.power if power is None else power
        self.power = self.power_full[data.layout.slow :]
        self.nu = data.layout.nu[data.layout.slow :]
        self.free_index = {s.index for s in self.slots}
        # what is held stays as it is, unless a filter before it moves
        self.held = None
        if -1 not in self.free_index:
            held = [t for i, t in enumerate(self.terms) if i not in self.free_index]
            self.held = unit_shapes.of_sum(held, self.low_pass, data.n, data.fs)

    def start(self):
        return (
            np.concatenate(
                [
                    [*s.read(self.low_pass if s.index == -1 else self.terms[s.index])]
                    for s in self.slots
                ]
            )
            if self.slots
            else np.zeros(0)
        )

    def unpack(self, vector):
        """(terms, low_pass) at a vector of the free parameters."""
        terms, low_pass, at = list(self.terms), self.low_pass, 0
        for s in self.slots:
            part = vector[at : at + len(s.names)]
            at += len(s.names)
            if s.index == -1:
                low_pass = s.write(low_pass, part)
            else:
                terms[s.index] = s.write(terms[s.index], part)
        return terms, low_pass

    def _bare(self, vector):
        """Spectrum in all bins and covariance of the block differences, without the electronics."""
        data = self.data
        terms, low_pass = self.unpack(vector)
        if self.held is None:
            return unit_shapes.of_sum(terms, low_pass, data.n, data.fs)
        free = [terms[i] for i in self.free_index]
        s, c = unit_shapes.of_sum(free, low_pass, data.n, data.fs)
        return s + self.held[0], c + self.held[1]

    def _with_electronics(self, s, c):
        data, k = self.data, self.data.layout.slow
        # coarse rounding may add less than nothing: it leaves a tenth
        v = max(data.white / data.m, -0.45 * c[0])
        c = c.copy()
        c[0] += 2 * v
        c[1:2] -= v
        return measured(s[k:], data.extra[k:]), c

    def shapes(self, vector):
        """Spectrum in the fast bins and covariance of the block differences."""
        return self._with_electronics(*self._bare(vector))

    def value(self, vector, shapes=None):
        """log L up to a constant of the data, with the regression profiled out: (ll, beta,
        beta_cov).
        """
        s, c = self.shapes(vector) if shapes is None else shapes
        ll = -0.5 * float(np.sum(self.nu * (np.log(s) + self.power / s)))
        y = (
            self.data.d[:, None]
            if self.columns is None
            else np.column_stack([self.data.d, self.columns])
        )
        logdet, e = slow.whiten(c, y)
        if not np.isfinite(logdet):
            return -np.inf, np.zeros(0), np.zeros((0, 0))
        r = e[:, 0]
        if self.columns is None:
            return ll - 0.5 * (logdet + r @ r), np.zeros(0), np.zeros((0, 0))
        a = e[:, 1:]
        cov = np.linalg.pinv(a.T @ a)
        beta = cov @ (a.T @ r)
        r = r - a @ beta
        return ll - 0.5 * (logdet + r @ r), beta, cov

    def bounds(self):
        """The least and the most that each free parameter may be, logarithms, shapes (k,)."""
        return (
            np.concatenate([np.asarray(s.low, float) for s in self.slots]),
            np.concatenate([np.asarray(s.high, float) for s in self.slots]),
        )

    def maximise(self, start=None, *, iterations: int = 14, tolerance: float = 0.02) -> Fit:
        """Fisher scoring with a damped step, from `start` or the slots' own values."""
        x = self.start() if start is None else np.array(start, float)
        k = len(x)
        shapes = self.shapes(x)
        best, beta, beta_cov = self.value(x, shapes)
        information = np.zeros((k, k))
        if k:
            low, high = self.bounds()
            x = np.clip(x, low, high)
            shapes = self.shapes(x)
            best, beta, beta_cov = self.value(x, shapes)
            damping = 1e-3
            for _ in range(iterations):
                gradient, information = self._derivatives(x, shapes)
                moved = False
                for _ in range(6):
                    step = np.linalg.solve(
                        information + damping * np.diag(np.diag(information) + 1e-6), gradient
                    )
                    trial = np.clip(x + np.clip(step, -1.0, 1.0), low, high)
                    new_shapes = self.shapes(trial)
                    value, b, bc = self.value(trial, new_shapes)
                    if value > best:
                        gain, x, best, beta, beta_cov, shapes = (
                            value - best,
                            trial,
                            value,
                            b,
                            bc,
                            new_shapes,
                        )
                        damping, moved = max(damping / 10, 1e-6), True
                        break
                    damping = max(10 * damping, 1e-2)
                if not moved or gain < tolerance:
                    break
            _, information = self._derivatives(x, shapes, gradient=False)
        cov = np.linalg.pinv(information) if k else np.zeros((0, 0))
        terms, low_pass = self.unpack(x)
        return Fit(
            best,
            tuple(terms),
            low_pass,
            x,
            cov,
            beta,
            beta_cov,
            best + self._occam(information, beta, beta_cov),
            self.slots,
        )

    def _occam(self, information, beta, beta_cov):
        out = 0.0
        if self.slots:
            widths = np.concatenate([np.asarray(s.widths, float) for s in self.slots])
            sd = 1.0 / np.sqrt(np.maximum(np.linalg.eigvalsh(information), 1e-12))
            out += float(
                np.sum(
                    np.minimum(
                        np.log(np.maximum(sd, 1e-6) * np.sqrt(2 * np.pi)), np.log(widths.max())
                    )
                )
                - np.sum(np.log(widths))
            )
        for b, v in zip(beta, np.diag(beta_cov) if len(beta) else ()):
            out += amplitude_occam(abs(b) / np.sqrt(max(v, 1e-300)))
        return out

    def _derivatives(self, x, shapes, *, gradient: bool = True):
        """Gradient and expected information of the free parameters."""
        a, b, g = self.directions(x, shapes, gradient=gradient)
        return g, 0.5 * (a * self.nu) @ a.T + 0.5 * b @ b.T

    def directions(self, x, shapes=None, *, gradient: bool = False):
        """Relative change of the spectrum in the fast bins and of the slow spectrum by each free
        parameter, shapes
        (parameters, bins) and (parameters, blocks), and the gradient."""
        shapes = self.shapes(x) if shapes is None else shapes
        h, g = 2e-3, np.zeros(len(x))
        fast_d, slow_d = [], []
        two_sided = slow.spectrum(shapes[1])
        for i, (su, sd) in enumerate(self._either_side(x, h)):
            if gradient:
                rise = (self.value(None, su)[0] - self.value(None, sd)[0]) / (2 * h)
                g[i] = np.clip(
                    np.nan_to_num(rise), -1e12, 1e12
                )  # at the edge of what is a covariance at all
            fast_d.append((su[0] - sd[0]) / (2 * h) / shapes[0])
            slow_d.append(slow.spectrum_difference(su[1] - sd[1]) / (2 * h) / two_sided)
        return np.array(fast_d), np.array(slow_d), g

    def _either_side(self, x, h: float):
        """Shapes a step `h` above and below `x` in each free parameter."""
        data = self.data
        terms, low_pass = self.unpack(x)
        s, c = self._bare(x)
        names = [(slot.index, name) for slot in self.slots for name in slot.names]
        for i, (index, name) in enumerate(names):
            if index >= 0 and name == unit_shapes.amplitude_of(terms[index]):
                own = unit_shapes.of_sum([terms[index]], low_pass, data.n, data.fs)
                yield [
                    self._with_electronics(s + more * own[0], c + more * own[1])
                    for more in (np.expm1(2 * h), np.expm1(-2 * h))
                ]
            else:
                step = h * (np.arange(len(x)) == i)
                yield self.shapes(x + step), self.shapes(x - step)


def amplitude_occam(snr: float) -> float:
    """Log ratio of posterior to prior width of an amplitude of either sign, uniform in its
    logarithm over three decades.
    """
    return float(np.log(np.sqrt(2 * np.pi) / (2 * AMPLITUDE_WIDTH * max(snr, 1.0))))
