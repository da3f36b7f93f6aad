"""Burst noise: a bias that jumps between two levels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numba import njit
from scipy.fft import dct, idct

from imu_lib.gap.candidate import Candidate
from imu_lib.likelihood.evaluate import with_extra
from imu_lib.likelihood.evidence import amplitude_occam
from imu_lib.processes import Telegraph as Process

from .competitor import Z95, Competitor, process_parameters
from .gauss_markov import GaussMarkov

#: Samples that a level has to last on average to be told from noise.
MIN_DWELL_SAMPLES = 50
#: Gain of the noises in whose place two levels are tried, starts that are tried, and flips from
#: which on there are two levels.
MIN_GAIN, MAX_STARTS, MIN_FLIPS = 8.0, 6, 2.5
#: Flips in the record from which two levels beside a fitted base are started.
FLIPS = (10, 40)


#: The noise of their spectrum.
TWIN = GaussMarkov()


@njit(cache=True, nogil=True)
def _posterior(y, a, flip, var):
    """Probability of the upper level and log-likelihood against pure noise of y = a (s - 1/2) +
    N(0, var).
    """
    n = len(y)
    alpha = np.empty(n)
    ll = 0.0
    p = 0.5
    for k in range(n):
        q = p * (1 - flip) + (1 - p) * flip
        odds = a * y[k] / var  # log of upper to lower, relative to the likelier one: no overflow
        up, down = (1.0, np.exp(-odds)) if odds > 0 else (np.exp(odds), 1.0)
        total = q * up + (1 - q) * down
        ll += np.log(total) + 0.5 * abs(odds) - a * a / (8 * var)
        p = q * up / total
        alpha[k] = p
    out = np.empty(n)
    out[n - 1] = alpha[n - 1]
    flips = 0.0
    for k in range(n - 2, -1, -1):
        forward = alpha[k] * (1 - flip) + (1 - alpha[k]) * flip
        stay_up = alpha[k] * (1 - flip) / max(forward, 1e-300)
        up_to_down = alpha[k] * flip / max(1 - forward, 1e-300)
        out[k] = out[k + 1] * stay_up + (1 - out[k + 1]) * up_to_down
        flips += (1 - out[k + 1]) * up_to_down + out[k + 1] * (1 - stay_up)
    return out, ll, flips


def _cosines(x):
    """Orthonormal cosine transform of a series less its mean, shape (n,)."""
    return dct(x - x.mean(), norm="ortho")


def _amplitude(y, w, v, var, quiet):
    """Distance of the two levels by generalised least squares of `y` on the expected states `w` -
    of variance `v` each - and its
    standard deviation; `quiet` is the share of white noise, of variance `var`, in the noise at
    each ordinate.

    `y` and `w` are given by their cosine transforms.
    """
    square = max(float(np.sum(quiet * w**2) + v * np.mean(quiet) * len(w)), 1e-300)
    return float(np.sum(quiet * y * w)) / square, float(np.sqrt(var / square))


def _beyond_spectrum(y, rest, w, a, flip, ll, var, quiet) -> float:
    """Log-likelihood of two levels beyond that of the Gaussian process of the same spectrum.

    The first is a lower bound: the expectation over the paths, of probability `ll` under white
    noise of variance `var` in
    `rest` = `y` less its drift, of the likelihood of `y` under the noise with its drift, less
    their divergence from what
    the flips foretell. The second is Whittle's, on the same cosine transform. Equal where the
    noise is white.
    """
    n = len(y)
    power, left = _cosines(y)[1:] ** 2, _cosines(y - a * w)[1:] ** 2
    noise = var / np.broadcast_to(quiet, n)[1:]
    unknown = 0.5 * a * a * np.mean(1 / noise) * np.sum(0.25 - w**2)
    levels = (
        0.5 * np.sum((power - left) / noise) - unknown + ll - np.sum(a * rest * w - a * a / 8) / var
    )
    phi = 1 - 2 * flip
    both = (
        noise
        + 0.25
        * a
        * a
        * (1 - phi * phi)
        / np.abs(1 - phi * np.exp(-1j * np.pi * np.arange(1, n) / n)) ** 2
    )
    return float(levels + 0.5 * np.sum(np.log(both / noise) + power / both - power / noise))


class Telegraph(Competitor):
    name = "telegraph"
    cause = (
        "A single trap or contact switches between two states at random (burst or popcorn noise)."
    )
    domain = "distribution"
    process = Process

    def decode(self, x, fs, start: Process, density: float, drift_gain=None, *, rounds: int = 12):
        """Two levels by expectation maximisation: (process, signal of shape (n,), expected flips,
        log-likelihood
        beyond that of a Gauss-Markov process of the same spectrum, standard deviation of the
        amplitude), or None.

        `density` is N^2 of the white noise; `drift_gain(size)` is the Wiener gain of the base
        model's own drift on a
        real transform of `size` points at the decimated rate, or None.
        """
        # a step is a small part of a dwell, and no longer than it takes to see on which level the
        # signal is
        seen = 2.0 * density * fs / start.amplitude**2
        q = int(max(1, min(round(fs / (12 * start.rate)), seen, len(x) // 64)))
        k = len(x) // q
        y = x[: k * q].reshape(k, q).mean(axis=1)
        y = y - 0.5 * (np.quantile(y, 0.1) + np.quantile(y, 0.9))
        var = density * fs / q
        a, rate, middle = start.amplitude, start.rate, 0.0
        drift = np.zeros(k)
        gain = None if drift_gain is None else drift_gain(2 * k, fs / q)[:k]
        waves = _cosines(y)
        quiet = (
            1.0 if gain is None else 1.0 - gain
        )  # share of the noise that is white at each ordinate
        s = None
        for _ in range(rounds):
            if not (np.isfinite(a) and a > 0):
                return None
            flip = 0.5 * -np.expm1(-2 * rate * q / fs)
            s, ll, flips = _posterior(y - drift - middle, a, flip, var)
            w = s - 0.5
            rest = y - drift
            # two levels by weighted means
            up, down = np.sum(s), np.sum(1 - s)
            if min(up, down) < 2:
                return None
            high, low = np.sum(s * rest) / up, np.sum((1 - s) * rest) / down
            states = _cosines(w)
            a, sd = _amplitude(waves, states, np.mean(s * (1 - s)), var, quiet)
            middle = 0.5 * (high + low)
            rate = float(
                np.clip(
                    -0.5 * np.log1p(-2 * min(flips / (k - 1), 0.45)) * fs / q,
                    2.0 * fs / len(x),
                    fs / q / 4,
                )
            )
            if gain is not None:
                drift = idct((waves - a * states) * gain, norm="ortho")
        if not (np.isfinite(a) and a > 0):  # the last round may have lost the levels
            return None
        flip = 0.5 * -np.expm1(-2 * rate * q / fs)
        s, ll, flips = _posterior(y - drift - middle, a, flip, var)
        w = s - 0.5
        beyond = _beyond_spectrum(y, y - drift - middle, w, a, flip, ll, var, quiet)
        signal = np.repeat(a * w, q)
        signal = np.concatenate([signal, np.full(len(x) - len(signal), signal[-1])])
        return Process(amplitude=float(a), rate=rate), signal, float(flips), beyond, float(sd)

    def candidates_beside(self, state, weighed):
        """Two levels instead of the noises that would otherwise explain a red spectrum."""
        return self._decoded(state, self._starts(state, weighed))

    def candidates_in_base(self, state):
        duration, sd = state.data.duration, state.cleaned.slow_sd
        return self._decoded(state, [(2 * sd, flips / duration) for flips in FLIPS])

    def _decoded(self, state, starts):
        if not starts:
            return []
        data, fit = state.cleaned, state.fit
        # before a filter, which takes nothing from a dwell
        s = with_extra(data.layout.spectrum(fit.terms), data.extra)
        s = s[data.layout.slow :]
        density = min(float(np.median(s[:40])), float(np.median(s))) / 2
        drift = [t for t in fit.terms if t.memory > 0]

        def gain(size, rate):
            f = np.maximum(np.arange(size // 2 + 1), 0.5) * rate / size
            d = sum(t.psd(f) for t in drift)
            return d / (d + 2 * density)

        x = data.x - state.drift if len(fit.beta) else data.x
        out = []
        for amplitude, rate in starts[:MAX_STARTS]:
            start = Process(amplitude=float(amplitude), rate=float(max(rate, 2 / data.duration)))
            found = self.decode(x, data.fs, start, density, gain if drift else None)
            if found is not None and found[2] >= MIN_FLIPS and found[0].amplitude > 0:
                out.append(self._candidate(state, *found))
        return out

    @staticmethod
    def _starts(state, weighed) -> list:
        """(amplitude, rate) to start from, after the red noises that promise most."""
        starts, data = [], state.cleaned
        for w in weighed:
            if w.gain < MIN_GAIN or not w.item.effect.red:
                continue
            levels = w.item.effect.levels(w.state, w.item)
            if levels is not None:
                if max(rate for _, rate in levels) <= data.fs / MIN_DWELL_SAMPLES:
                    starts += levels
            elif len(starts) < 4:
                sd = data.slow_sd
                starts += [(2 * sd, 10 / data.duration), (2 * sd, 60 / data.duration)]
        return starts

    def _candidate(self, state, process, signal, flips, beyond, sd) -> Candidate:
        """Two levels at `signal`; what they gain beyond the Gauss-Markov noise of their spectrum
        is no affair of the likelihood of the record without them.
        """
        occam = amplitude_occam(process.amplitude / sd)
        occam += np.log(np.sqrt(2 * np.pi / max(flips, 1)) / np.log(1e4))
        bare = Candidate(self, process, signal=signal, note={"flips": flips, "sd": sd})
        trial, alike = state.plus(bare), state.holding(process.twin)
        return replace(
            bare,
            bonus=float(alike.evidence - trial.evidence + beyond + occam),
            gain=float(alike.ll - trial.ll + beyond),
        )

    def absorbed(self, base):
        # two levels whose dwells are lost in the noise have the spectrum of a Gauss-Markov process
        return base.has(TWIN.process) or TWIN.absorbed(base)

    def enter(self, assembly, candidate):
        """It is taken out of the record instead."""

    def settled(self, state, candidate):
        return candidate

    def grow(self, state, candidate, fit, terms, stages):
        terms.append(candidate.process)

    def report(self, state, candidate):
        p, note = candidate.process, candidate.note
        spread = Z95 / np.sqrt(max(note["flips"], 1))
        sd = Z95 * note["sd"]
        return process_parameters(p), {
            "amplitude": [p.amplitude - sd, p.amplitude + sd],
            "rate": [p.rate * np.exp(-spread), p.rate * np.exp(spread)],
        }

    def where(self, state, candidate):
        return (
            f"distribution of the bias: two levels, about {candidate.note['flips']:.0f} flips "
            f"in {state.data.duration:.0f} s"
        )


EFFECTS = (Telegraph(),)
