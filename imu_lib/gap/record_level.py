"""What acts on the whole record: noise that channels share, missing samples, jitter of the time
stamps.
"""

from __future__ import annotations

from functools import partial
from itertools import combinations

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.stats import chi2

from imu_lib.errors import UndefinedFormError
from imu_lib.gap import measured
from imu_lib.gap.effects.common_mode import CommonMode
from imu_lib.gap.effects.jitter import Jitter
from imu_lib.gap.effects.time_gaps import TimeGaps
from imu_lib.gap.imputation import first_fill
from imu_lib.gap.innovations import trend
from imu_lib.gap.steps import Step
from imu_lib.likelihood.tapered import taper
from imu_lib.processes import CommonMode as SharedNoise
from imu_lib.processes import Sum, WhiteNoise

#: Gain in log-likelihood that noise in common has to bring.
COMMON_GAIN = 16.0
#: Ordinates in a band at the least, and bands at the most: within a band the spectra have to be
#: level.
ORDINATES, MOST = 500, 192
#: Log-likelihood by which noise that enters before the filters has to be better than behind them.
FILTERED = 8.0
#: log10 p below which what is left of the coherence is reported.
LEFT = -6.0


def timing(record, model) -> tuple[list[Step], str | None]:
    """Missing samples and jitter, and a sentence where the time stamps do something else."""
    held = {p.name for p in model.record} if model is not None else set()
    steps = []
    for effect in (TimeGaps(), Jitter()):
        if effect.name in held:
            continue
        found = effect.detect(record)
        if found is not None:
            steps.append(
                Step(
                    effect.name,
                    {k: v for k, v in found.process.to_json().items() if k != "process"},
                    found.intervals,
                    found.where,
                    0.5 if found.doubt else measured.share(effect.name),
                    {"effect": "none", "confidence": 0.0},
                    [],
                    gain=None,
                    cause=effect.cause,
                    detected=True,
                    evidence=found.where,
                )
            )
            if found.doubt:
                return steps, found.doubt
    return steps, None


def cross_spectra(channels: dict, fs: float, *, segments: int = 512):
    """Averaged cross-spectra between channels in the fast band: (names, matrix (bands, k, k)
    complex, ordinates per band, Hz).

    Ordinates at which any channel has a line are left out.
    """
    names = list(channels)
    n = len(next(iter(channels.values())))
    z = []
    for name in names:
        x = first_fill(channels[name], np.isnan(channels[name]))
        x = x - trend(x, max(2, int(2 * fs)))
        sd = 1.4826 * np.median(np.abs(x[::5]))
        x = np.clip(x, -6 * sd, 6 * sd) if sd > 0 else x
        # what the ends leak into a filter's stop band is alike in all channels
        z.append(np.fft.rfft(taper(n) * x) * np.sqrt(2.0 / (n * fs)))
    z = np.array(z)
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
    return names, np.array(matrix), np.array(count), np.array(centre)


def _loss(gain, members, log_density) -> float:
    """What is minimised; a density beyond the noise of a member costs all."""
    return min(-gain(members, np.exp(log_density)), 1e12)


def shared_noise(
    channels: dict, fs: float, held=(), bases=None
) -> tuple[SharedNoise | None, dict, str | None]:
    """Noise in common: the process or None, what was found on the way, and a sentence where
    another coherence is left.

    `held` are the base model's own processes in common, `bases` its channels (name -> `Sum`).
    """
    if len(channels) < 2:
        return None, {}, None
    names, matrix, count, f = cross_spectra(channels, fs)
    k = len(names)
    filters = [bases[name].low_pass if bases and name in bases else None for name in names]
    passed = np.column_stack([_passed(low_pass, f, fs) for low_pass in filters])
    for process in held:
        matrix = _without(
            matrix,
            2 * process.N**2,
            [c in process.channels for c in names],
            np.sqrt(passed) if process.filtered else None,
        )
    level = np.einsum("bii->bi", matrix).real
    norm = np.sqrt(level[:, :, None] * level[:, None, :])
    # before the filters, where each turns the phase by its own amount
    turn = np.exp(
        1j
        * np.column_stack(
            [
                np.zeros(len(f)) if low_pass is None else low_pass.phase(f, fs)
                for low_pass in filters
            ]
        )
    )
    straight = matrix * turn[:, :, None].conj() * turn[:, None, :]
    best = None
    total = count.sum()
    weight = count / total
    mean = np.einsum("b,bij->ij", weight, matrix).real
    sd = np.sqrt(np.diag(mean))

    # noise that enters before the channels' filters keeps its share of their noise where they fall
    # off
    before = np.array(np.broadcast_to(np.median(level[: len(f) // 4], axis=0), level.shape))
    for i, low_pass in enumerate(filters):
        if low_pass is not None:
            before[:, i] = level[:, i] / passed[:, i]

    behind_them, before_them = (level, (matrix / norm).real), (before, (straight / norm).real)

    def gain(members, density, level, coherence):
        """Log-likelihood gained by a density in common, each band with its own levels."""
        share = np.minimum(density / level[:, members], 0.999)
        model = np.sqrt(share[:, :, None] * share[:, None, :])
        model[:, range(len(members)), range(len(members))] = 1.0
        sign, logdet = np.linalg.slogdet(model)
        if np.any(sign <= 0):
            return -np.inf
        r = coherence[np.ix_(range(len(level)), members, members)]
        return float(
            -np.sum(
                count * (logdet + np.einsum("bii->b", np.linalg.solve(model, r)) - len(members))
            )
        )

    r = mean / np.outer(sd, sd)
    both = np.maximum(r, np.einsum("b,bij->ij", weight, straight).real / np.outer(sd, sd))
    strength = both * np.sqrt(2 * total)
    linked = [i for i in range(k) if any(strength[i, j] > 3.5 for j in range(k) if j != i)]
    for size in range(2, len(linked) + 1):
        for members in combinations(linked, size):
            members = list(members)
            # beyond all of the noise of a member there is nothing to share
            for place, handicap, part in (
                (behind_them, 0.0, mean),
                (before_them, FILTERED, np.mean(straight[: len(f) // 4], axis=0).real),
            ):
                guess = np.median([part[i, j] for i, j in combinations(members, 2)])
                if guess <= 0:
                    continue
                loss = partial(_loss, partial(gain, level=place[0], coherence=place[1]), members)
                fit = minimize_scalar(
                    loss,
                    bounds=(np.log(guess) - 1.5, np.log(guess) + 1.5),
                    method="bounded",
                    options={"xatol": 1e-4},
                )
                if best is None or -fit.fun - handicap > best[0]:
                    best = (-fit.fun - handicap, members, float(np.exp(fit.x)), place)
    found, note = None, {}
    rest = matrix
    if best is not None and best[0] > COMMON_GAIN:
        value, members, density, place = best
        h = 1e-2
        curve = (
            -sum(
                c * gain(members, density * np.exp(d), *place)
                for c, d in ((1, h), (-2, 0.0), (1, -h))
            )
            / h**2
        )
        spread = 0.5 / np.sqrt(max(curve, 1e-9))
        if place is behind_them:
            density, spread = _with_levels(
                density,
                spread,
                [names[i] for i in members],
                matrix[:, members][:, :, members],
                count,
                f,
                fs,
                bases or {},
            )
        N = np.sqrt(density / 2)
        found = SharedNoise(
            N=float(N),
            channels=tuple(names[i] for i in members),
            filtered=None if place is behind_them else 1,
        )
        note = {
            "gain": value,
            "sets": 2.0 * (2**k - k - 1),  # sets of channels, before or behind their filters
            "interval": [N * np.exp(-1.96 * spread), N * np.exp(1.96 * spread)],
            "coherence": float(np.mean([r[i, j] ** 2 for i, j in combinations(members, 2)])),
            "z_before": _size(matrix, count),
        }
        rest = _without(
            matrix,
            density,
            [i in members for i in range(k)],
            None if place is behind_them else np.sqrt(level / before),
        )
        note["z_after"] = _size(rest, count)
    return found, note, _left(names, rest, matrix, count, f)


def _passed(low_pass, f, fs):
    """Share of white noise that the low-pass filter of a channel lets through, shape of `f`."""
    return (
        np.ones(len(f))
        if low_pass is None
        else Sum((WhiteNoise(N=np.sqrt(0.5)),), (low_pass,)).psd(f, fs)
    )


def _without(matrix, density, member, fall=None):
    """The cross-spectra less a `density` that the members share; behind filters of amplitude
    `fall`, which may turn its phase.
    """
    off = np.outer(member, member) & ~np.eye(len(member), dtype=bool)
    if fall is None:
        return matrix - density * off
    expected = density * fall[:, :, None] * fall[:, None, :] * off
    return matrix * (1.0 - np.minimum(expected / np.maximum(np.abs(matrix), 1e-300), 1.0))


def _with_levels(density, spread, names, matrix, count, f, fs, bases):
    """(density, sd of the logarithm of N) sharpened by the levels of the channels, where the bases
    foretell these and agree.
    """
    try:
        own = np.column_stack([bases[name].noise.psd(f, fs) for name in names])
    except (KeyError, UndefinedFormError):
        return density, spread

    def loss(log_density):
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


def _size(matrix, count):
    k = matrix.shape[1]
    d = np.sqrt(np.einsum("bii->bi", matrix).real)
    z = [m / np.outer(e, e) * np.sqrt(c) for m, e, c in zip(matrix, d, count)]
    return float(
        np.sqrt(np.mean([np.abs(a[i, j]) ** 2 for a in z for i, j in combinations(range(k), 2)]))
    )


def _left(names, rest, matrix, count, f):
    worst = (0.0, None)
    pairs = list(combinations(range(len(names)), 2))
    for i, j in pairs:
        g = np.abs(rest[:, i, j]) ** 2 / (matrix[:, i, i].real * matrix[:, j, j].real) * count * 2
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
            if p < worst[0]:
                worst = (p, text)
    return worst[1] if worst[0] < LEFT else None


def common_step(process, note) -> Step:
    """Noise in common as a step of the record."""
    names = ", ".join(process.channels)
    parameters = {name: v for name, v in process.to_json().items() if name != "process"}
    return Step(
        "common_mode",
        parameters,
        {"N": note["interval"]},
        f"coherence between {names}: {note['coherence']:.2g} where independent channels have none",
        measured.odds(note["gain"], note["sets"]),
        {"effect": "none", "confidence": 0.0},
        [],
        gain=note["gain"],
        gap_before=note["z_before"],
        gap_after=note["z_after"],
        cause=CommonMode.cause,
    )
