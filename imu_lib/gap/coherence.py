"""Coherence between channels: averaged cross-spectra in the fast band, and what is left of them."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.stats import chi2

from imu_lib.arrays import Array
from imu_lib.likelihood.tapered import taper
from imu_lib.samples.imputation import first_fill
from imu_lib.samples.innovations import trend

#: Ordinates in a band at the least, and bands at the most: within a band the spectra have to be
#: level.
ORDINATES, MOST = 500, 192
#: log10 p below which what is left of the coherence is reported.
LEFT = -6.0
#: Share of the noise power of its quietest channel from which on noise in common is told: less
#: moves the density of none by one per cent, the second figure of a datasheet.
SMALLEST = 0.02


@dataclass(frozen=True, eq=False)
class Cross:
    """Averaged cross-spectra of channels `names`: `matrix` (bands, k, k) complex, `count` ordinates
    in each band, `f` their centres in Hz.
    """

    names: list[str]
    matrix: np.ndarray
    count: np.ndarray
    f: np.ndarray

    @property
    def level(self) -> np.ndarray:
        """Spectra of the channels, shape (bands, k)."""
        return np.einsum("bii->bi", self.matrix).real

    @property
    def size(self) -> float:
        """Root mean square of the coherence in its standard deviations by chance."""
        d = np.sqrt(self.level)
        k = len(self.names)
        z = [m / np.outer(e, e) * np.sqrt(c) for m, e, c in zip(self.matrix, d, self.count)]
        pairs = list(combinations(range(k), 2))
        return float(np.sqrt(np.mean([np.abs(a[i, j]) ** 2 for a in z for i, j in pairs])))


def cross_spectra(channels: dict[str, Array], fs: float) -> Cross:
    """Averaged cross-spectra between channels (name -> (n,)) in the fast band.

    Ordinates at which any channel has a line are left out.
    """
    names = list(channels)
    n = len(next(iter(channels.values())))
    spectra = []
    for name in names:
        x = first_fill(channels[name], np.isnan(channels[name]))
        x = x - trend(x, max(2, int(2 * fs)))
        sd = 1.4826 * np.median(np.abs(x[::5]))
        x = np.clip(x, -6 * sd, 6 * sd) if sd > 0 else x
        # what the ends leak into a filter's stop band is alike in all channels
        spectra.append(np.fft.rfft(taper(n) * x) * np.sqrt(2.0 / (n * fs)))
    z = np.array(spectra)
    f = np.arange(z.shape[1]) * fs / n
    lo, hi = np.searchsorted(f, 0.02 * fs), np.searchsorted(f, 0.49 * fs)
    z, f = z[:, lo:hi], f[lo:hi]
    bands = int(np.clip(z.shape[1] // ORDINATES, 24, MOST))
    edge = np.linspace(0, z.shape[1], bands + 1).astype(int)
    power = np.abs(z) ** 2
    keep = np.ones(z.shape[1], bool)
    for a, b in zip(edge[:-1], edge[1:]):
        level = np.median(power[:, a:b], axis=1, keepdims=True) / np.log(2)
        keep[a:b] = ~(power[:, a:b] > 16 * level).any(axis=0)
    matrix, count, centre = [], [], []
    for a, b in zip(edge[:-1], edge[1:]):
        part = z[:, a:b][:, keep[a:b]]
        matrix.append(part @ part.conj().T / part.shape[1])
        count.append(part.shape[1])
        centre.append(f[a:b].mean())
    return Cross(names, np.array(matrix), np.array(count), np.array(centre))


def without(matrix: Array, density: float, member: list[bool], fall: Array | None = None) -> Array:
    """The cross-spectra less a `density` that the members share; behind filters of amplitude
    `fall`, which may turn its phase.
    """
    off = np.outer(member, member) & ~np.eye(len(member), dtype=bool)
    if fall is None:
        return matrix - density * off
    expected = density * fall[:, :, None] * fall[:, None, :] * off
    return matrix * (1.0 - np.minimum(expected / np.maximum(np.abs(matrix), 1e-300), 1.0))


def left(rest: Array, seen: Cross) -> str | None:
    """A sentence where a coherence is left in the cross-spectra `rest`, of channels whose spectra
    are those of `seen`.
    """
    names, matrix, count, f = seen.names, seen.matrix, seen.count, seen.f
    worst: tuple[float, str | None] = (0.0, None)
    pairs = list(combinations(range(len(names)), 2))
    for i, j in pairs:
        g = np.abs(rest[:, i, j]) ** 2 / (matrix[:, i, i].real * matrix[:, j, j].real) * count * 2
        whole = float(np.mean(g / (2 * count) - 1 / count))  # beyond chance
        # the fitted density takes no more than its own accuracy; allow a percent of the coherence
        for value, dof, text in (
            (
                g.sum(),
                2 * len(g),
                f"coherence between {names[i]} and {names[j]} over the whole band",
            ),
            (
                g.max(),
                2,
                f"coherence between {names[i]} and {names[j]} near {f[int(np.argmax(g))]:.3g} Hz",
            ),
        ):
            p = chi2.logsf(value, dof) / np.log(10) + np.log10(
                len(pairs) * (len(g) if dof == 2 else 1)
            )
            if dof > 2 and whole < SMALLEST**2:
                continue
            if p < worst[0]:
                worst = (p, text)
    return worst[1] if worst[0] < LEFT else None
