"""White noise that several channels share: the set of channels and the density that make their
coherence likeliest.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from imu_lib.arrays import Array
from imu_lib.errors import UndefinedFormError
from imu_lib.gap import coherence
from imu_lib.gap.coherence import Cross
from imu_lib.processes import CommonMode, LowPass, Sum, WhiteNoise

#: Gain in log-likelihood that noise in common has to bring.
COMMON_GAIN = 16.0
#: Log-likelihood by which noise that enters before the filters has to be better than behind them.
FILTERED = 8.0
#: Standard deviations of a pair's mean coherence by chance from which on its channels are asked.
LINKED = 3.5


@dataclass(frozen=True, eq=False)
class Place:
    """Where noise in common enters: the spectra of the channels there (bands, k), the real part of
    the coherence there (bands, k, k), its mean by pairs in units of the mean spectra, and what is
    held against it.
    """

    level: np.ndarray
    coherence: np.ndarray
    mean: np.ndarray
    handicap: float = 0.0

    def gain(self, count: Array, members: list[int], density: float) -> float:
        """Log-likelihood gained by a density that `members` share, each band with its own
        levels.
        """
        share = np.minimum(density / self.level[:, members], 0.999)
        model = np.sqrt(share[:, :, None] * share[:, None, :])
        model[:, range(len(members)), range(len(members))] = 1.0
        sign, logdet = np.linalg.slogdet(model)
        if np.any(sign <= 0):
            return -np.inf
        r = self.coherence[np.ix_(range(len(self.level)), members, members)]
        return float(
            -np.sum(
                count * (logdet + np.einsum("bii->b", np.linalg.solve(model, r)) - len(members))
            )
        )

    def loss(self, count: Array, members: list[int], log_density: float) -> float:
        """What is minimised; a density beyond the noise of a member costs all."""
        return min(-self.gain(count, members, np.exp(log_density)), 1e12)


def shared_noise(
    seen: Cross,
    fs: float,
    held: tuple[CommonMode, ...] = (),
    bases: Mapping[str, Sum] | None = None,
) -> tuple[CommonMode | None, dict[str, Any], str | None]:
    """Noise in common of channels of which `seen` are the cross-spectra: the process or None, what
    was found on the way, and a sentence where another coherence is left.

    `held` are the base model's own processes in common, `bases` its channels (name -> `Sum`).
    """
    if len(seen.names) < 2:
        return None, {}, None
    bases = bases or {}
    filters = [bases[name].low_pass if name in bases else None for name in seen.names]
    passed = np.column_stack([let_through(low_pass, seen.f, fs) for low_pass in filters])
    seen = _without_held(seen, held, passed)
    behind, before = _places(seen, filters, passed, fs)
    best = _likeliest(seen, behind, before)
    if best is None or best[0] <= COMMON_GAIN:
        return None, {}, coherence.left(seen.matrix, seen)
    gain, members, density, place = best
    names, share = [seen.names[i] for i in members], _share(best)
    inside = [i in members for i in range(len(seen.names))]
    fall = None if place is behind else np.sqrt(seen.level / before.level)
    if _largest_share(best) < coherence.SMALLEST:
        bare = coherence.without(seen.matrix, density, inside, fall)
        return None, {}, coherence.left(bare, seen)
    spread = _spread(seen, best)
    if place is behind:
        density, spread = _with_levels(density, spread, members, seen, fs, bases)
    rest = replace(seen, matrix=coherence.without(seen.matrix, density, inside, fall))
    N = float(np.sqrt(density / 2))
    return (
        CommonMode(N=N, channels=tuple(names), filtered=None if place is behind else 1),
        {
            "gain": gain,
            # sets of channels, before or behind their filters
            "sets": 2.0 * (2 ** len(inside) - len(inside) - 1),
            "interval": [N * np.exp(-1.96 * spread), N * np.exp(1.96 * spread)],
            "coherence": float(
                np.mean([behind.mean[i, j] ** 2 for i, j in combinations(members, 2)])
            ),
            "share": share,
            "z_before": seen.size,
            "z_after": rest.size,
        },
        coherence.left(rest.matrix, seen),
    )


def _without_held(seen: Cross, held: tuple[CommonMode, ...], passed: Array) -> Cross:
    """The cross-spectra less the given model's own noise in common."""
    matrix = seen.matrix
    for process in held:
        member = [c in process.channels for c in seen.names]
        fall = np.sqrt(passed) if process.filtered else None
        matrix = coherence.without(matrix, 2 * process.N**2, member, fall)
    return replace(seen, matrix=matrix)


def _places(
    seen: Cross, filters: list[LowPass | None], passed: Array, fs: float
) -> tuple[Place, Place]:
    """Noise that enters behind the channels' filters, and before them, where each turns the phase
    by its own amount.
    """
    level, f = seen.level, seen.f
    norm = np.sqrt(level[:, :, None] * level[:, None, :])
    phases = [
        np.zeros(len(f)) if low_pass is None else low_pass.phase(f, fs) for low_pass in filters
    ]
    turn = np.exp(1j * np.column_stack(phases))
    straight = seen.matrix * turn[:, :, None].conj() * turn[:, None, :]
    # before the filters it keeps its share of their noise where they fall off
    quarter = len(f) // 4
    first = np.array(np.broadcast_to(np.median(level[:quarter], axis=0), level.shape))
    for i, low_pass in enumerate(filters):
        if low_pass is not None:
            first[:, i] = level[:, i] / passed[:, i]
    return (
        Place(level, (seen.matrix / norm).real, _mean(seen, seen.matrix)),
        Place(first, (straight / norm).real, _mean(seen, straight), FILTERED),
    )


def _mean(seen: Cross, matrix: Array) -> Array:
    """Coherence by pairs over all bands, in units of the mean spectra."""
    weight = seen.count / seen.count.sum()
    sd = np.sqrt(weight @ seen.level)
    return np.einsum("b,bij->ij", weight, matrix).real / np.outer(sd, sd)


def _likeliest(
    seen: Cross, behind: Place, before: Place
) -> tuple[float, list[int], float, Place] | None:
    """(gain, members, density, place) of the likeliest set of channels, or None."""
    k, total = len(seen.names), seen.count.sum()
    strength = np.maximum(behind.mean, before.mean) * np.sqrt(2 * total)
    linked = [i for i in range(k) if any(strength[i, j] > LINKED for j in range(k) if j != i)]
    sd = np.sqrt((seen.count / total) @ seen.level)
    parts = {behind: behind.mean * np.outer(sd, sd), before: _low(seen, before)}
    best = None
    for size in range(2, len(linked) + 1):
        for members in map(list, combinations(linked, size)):
            # beyond all of the noise of a member there is nothing to share
            for place, part in parts.items():
                guess = np.median([part[i, j] for i, j in combinations(members, 2)])
                if guess <= 0:
                    continue
                fit = minimize_scalar(
                    partial(place.loss, seen.count, members),
                    bounds=(np.log(guess) - 1.5, np.log(guess) + 1.5),
                    method="bounded",
                    options={"xatol": 1e-4},
                )
                if best is None or -fit.fun - place.handicap > best[0]:
                    best = (-fit.fun - place.handicap, members, float(np.exp(fit.x)), place)
    return best


def _low(seen: Cross, before: Place) -> Array:
    """Cross-spectra in the lowest quarter of the bands, where filters let all through."""
    quarter, level = len(seen.f) // 4, seen.level
    norm = np.sqrt(level[:, :, None] * level[:, None, :])
    return np.mean((before.coherence * norm)[:quarter], axis=0)


def _spread(seen: Cross, best: tuple[float, list[int], float, Place]) -> float:
    """Standard deviation of the logarithm of N, from the curvature of the likelihood."""
    _, members, density, place = best
    h = 1e-2
    curve = -sum(
        c * place.gain(seen.count, members, density * np.exp(d))
        for c, d in ((1, h), (-2, 0.0), (1, -h))
    )
    return float(0.5 / np.sqrt(max(curve / h**2, 1e-9)))


def _share(best: tuple[float, list[int], float, Place]) -> float:
    """Share of the noise power of the channels that they have in common, their mean."""
    _, members, density, place = best
    return float(density / np.exp(np.mean(np.log(np.mean(place.level[:, members], axis=0)))))


def _largest_share(best: tuple[float, list[int], float, Place]) -> float:
    """The same of the quietest of the channels."""
    _, members, density, place = best
    return float(density / np.min(np.mean(place.level[:, members], axis=0)))


def let_through(low_pass: LowPass | None, f: Array, fs: float) -> Array:
    """Share of white noise that the low-pass filter of a channel lets through, shape of `f`."""
    return (
        np.ones(len(f))
        if low_pass is None
        else Sum((WhiteNoise(N=np.sqrt(0.5)),), (low_pass,)).psd(f, fs)
    )


def _with_levels(
    density: float,
    spread: float,
    members: list[int],
    seen: Cross,
    fs: float,
    bases: Mapping[str, Sum],
) -> tuple[float, float]:
    """(density, sd of the logarithm of N) sharpened by the levels of the channels, where the bases
    foretell these and agree.
    """
    names, f, count = [seen.names[i] for i in members], seen.f, seen.count
    matrix = seen.matrix[:, members][:, :, members]
    try:
        own = np.column_stack([bases[name].noise.psd(f, fs) for name in names])
    except (KeyError, UndefinedFormError):
        return density, spread

    def loss(log_density: float) -> float:
        model = np.exp(log_density) * np.ones((len(f), len(names), len(names)))
        model[:, range(len(names)), range(len(names))] += own
        return float(
            np.sum(
                count
                * (
                    np.linalg.slogdet(model)[1]
                    + np.einsum("bii->b", np.linalg.solve(model, matrix)).real
                )
            )
        )

    at, reach, h = np.log(density), max(6 * spread, 0.06), 1e-2
    best = minimize_scalar(
        loss, bounds=(at - 2 * reach, at + 2 * reach), method="bounded", options={"xatol": 1e-5}
    ).x
    if abs(best - at) > reach:  # another noise in a channel: its level says nothing of this one
        return density, spread
    curve = (loss(best + h) - 2 * loss(best) + loss(best - h)) / h**2
    return float(np.exp(best)), float(0.5 / np.sqrt(max(curve, 1e-9)))
