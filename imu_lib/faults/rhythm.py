"""Steps of somebody who walks by, and a shake that comes and goes with something that passes: one
event each, not a list of knocks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from imu_lib.faults.finding import Finding, named, seconds
from imu_lib.faults.levels import Prepared

#: s from one step to the next, s between two knocks of one walk, and steps that are a walk.
STEP, PAUSE, LEAST = (0.3, 1.0), 1.5, 5
#: s of the blocks of the envelope, its correlation from one step to the next and that over chance.
BLOCK, ALIKE, CHANCE = 0.05, 0.25, 4.0
#: s that a shake lasts at the least to have a shape, its parts, and power at its ends over the
#: largest.
LONG, PARTS, ENDS = 8.0, 8, 0.75
WALKED, PASSED = "as of footsteps", "as of something that passes"


def gathered(
    touched: Sequence[Finding], channels: dict[str, Prepared], rate: float
) -> list[Finding]:
    """Disturbances in the order of time, those of one walk as one, and what each of them is like.

    Parameters
    ----------
    touched : sequence of Finding
    channels : dict
        Name -> channel made ready.
    rate : float, Hz
    """
    out: list[Finding] = []
    for group in _near(touched):
        one = _as_one(group) if len(group) > 1 else None
        # a longer event holds the others
        whole = one is not None and any(
            f.start <= one.start and one.stop <= f.stop + PAUSE for f in group
        )
        if one is not None and (whole or _rhythm(one, channels, rate) is not None):
            out.append(_told(one, channels, rate))
        else:
            out += [_told(f, channels, rate) for f in group]
    return out


def _near(touched: Sequence[Finding]) -> list[list[Finding]]:
    """Disturbances with short pauses between them, together."""
    out: list[list[Finding]] = []
    for item in sorted(touched, key=lambda f: f.start):
        if out and item.start - max(f.stop for f in out[-1]) < PAUSE:
            out[-1].append(item)
        else:
            out.append([item])
    return out


def _as_one(group: list[Finding]) -> Finding:
    """All of a group, from the first row to the last, on all channels that felt any of it."""
    first, last = int(group[0].rows[0]), int(max(f.rows[-1] for f in group))
    start, stop = group[0].start, max(f.stop for f in group)
    peak: dict[str, float] = {}
    for f in group:
        for c, p in zip(f.channels, f.parameters["peak"]):
            peak[c] = p if abs(p) > abs(peak.get(c, 0.0)) else peak[c]
    score = max(f.evidence["peak_over_noise"] for f in group)
    rhythm = next((f.evidence for f in group if "rhythm" in f.evidence), {})
    names = tuple(peak)
    sentence = (
        f"A shake at {seconds(start)} s, {stop - start:.2g} s long, on {named(names)}, up to "
        f"{score:.3g} times the noise."
    )
    return replace(
        group[0],
        channels=names,
        stop=stop,
        parameters={
            "start": start,
            "duration": stop - start,
            "peak": list(peak.values()),
            "channels": list(names),
        },
        evidence={**rhythm, "peak_over_noise": score},
        sentence=sentence,
        rows=np.arange(first, last + 1),
    )


def _told(item: Finding, channels: dict[str, Prepared], rate: float) -> Finding:
    """The disturbance with what it is like."""
    steps = _rhythm(item, channels, rate)
    if steps is not None:
        how = f"in a rhythm of {steps:.2g} a second, {WALKED}"
    elif _passes(item, channels, rate):
        how = f"it rises and falls once, {PASSED}"
    else:
        return item
    return replace(item, sentence=f"{item.sentence.rstrip('.')}, {how}.")


def _envelope(item: Finding, channels: dict[str, Prepared], size: int) -> np.ndarray:
    """Amplitude in blocks of `size` samples over that of the noise, shape (k,)."""
    part = slice(int(item.rows[0]), int(item.rows[-1]) + 1)
    ready = [channels[c] for c in item.channels if c in channels]
    # over the noise of the record: that of the surroundings has the event in it
    fast = [r.fast[part] * (r.sigma[part] / np.median(r.sigma)) for r in ready]
    k = len(fast[0]) // size if fast else 0
    blocks = [x[: k * size].reshape(k, size) for x in fast]
    return np.sqrt(np.mean([np.mean(b**2, axis=1) for b in blocks], axis=0)) if k else np.zeros(0)


def _rhythm(item: Finding, channels: dict[str, Prepared], rate: float) -> float | None:
    """Steps a second; None where there is no rhythm, or the samples are too few to show it."""
    if "rhythm" in item.evidence:
        return float(item.evidence["rhythm"])
    size = max(1, round(BLOCK * rate))
    low, high = (round(s * rate / size) for s in STEP)
    if low < 3 or not len(item.rows):
        return None
    e = np.log1p(_envelope(item, channels, size))
    if len(e) < LEAST * high:
        return None
    width = 2 * high + 1
    e = e - np.convolve(np.pad(e, high, mode="edge"), np.ones(width) / width, "valid")
    lagged = np.correlate(e, e, "full")[len(e) - 1 :] / max(float(e @ e), 1e-300)
    part = lagged[low : high + 1]
    best = int(np.argmax(part))
    if not 0 < best < len(part) - 1 or part[best] < max(ALIKE, CHANCE / np.sqrt(len(e))):
        return None
    before, top, after = part[best - 1 : best + 2]
    bend = before - 2.0 * top + after
    between = 0.0 if bend >= 0 else 0.5 * (before - after) / bend
    return float(rate / size / (low + best + between))


def _passes(item: Finding, channels: dict[str, Prepared], rate: float) -> bool:
    """Whether a long shake rises and falls once."""
    size = len(item.rows) // PARTS
    if item.stop - item.start < LONG or not size:
        return False
    e = _envelope(item, channels, size)[:PARTS]
    top = int(np.argmax(e))
    slack = 0.15 * e[top]
    smooth = np.all(np.diff(e[: top + 1]) > -slack) and np.all(np.diff(e[top:]) < slack)
    return bool(0 < top < len(e) - 1 and smooth and max(e[0], e[-1]) < ENDS * e[top])
