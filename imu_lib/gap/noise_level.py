"""What acts on the noise of a channel: found in its innovations one after the other, each undone
before the next is asked for.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from imu_lib.arrays import Array
from imu_lib.gap.effects import CHANNEL
from imu_lib.gap.effects.base import ChannelEffect, ChannelView, Finding
from imu_lib.likelihood.evaluate import with_extra
from imu_lib.processes import LowPass, Sum


def settled(view: ChannelView) -> tuple[ChannelView, list[Finding], list[str | None]]:
    """(view with everything undone that was found, findings, doubts with the likeliest first)."""
    findings: list[Finding] = []
    while True:
        known = {f.effect.name for f in findings}
        trials = [f for e in CHANNEL if e.name not in known for f in e.candidates(view)]
        sound = [f for f in trials if f.doubt is None]
        if not sound:
            return view, findings, [f.doubt for f in sorted(trials, key=_gain, reverse=True)]
        best = max(sound, key=_gain)
        findings.append(best)
        if best.scale is not None:
            view = scaled(view, best.scale)


def _gain(finding: Finding) -> float:
    return finding.gain or 0.0


def scaled(view: ChannelView, scale: Array) -> ChannelView:
    """The view with its fast noise brought back to one level; what the model calls slow stays."""
    x = _levelled(view.x, scale, view.fs, view.given)
    return replace(view, x=x, y=view.y / scale, scale=view.scale * scale)


#: Factor, or difference of what may be negative, by which the parameters of a stage of the given
#: model may lie beyond the intervals of what was found.
BEYOND = 0.25


def of_model(found: Finding, given: Sum | None) -> bool:
    """Whether the given model has the level or the distribution of the noise that was found."""
    held = (
        None
        if given is None or found.effect.level != ChannelEffect.level
        else given.find(found.effect.name)
    )
    if held is None:
        return False
    for name, (low, high) in found.intervals.items():
        value = getattr(held, name) or 0.0
        slack = BEYOND * (1.0 if min(low, value) <= 0.0 else max(high, value))
        if not low - slack < value < high + slack:
            return False
    return True


def model_level(clean: Any, terms: list[Any], low_pass: LowPass | None, fs: float) -> float:
    """Variance of the fast noise as a multiple of what the given noises have."""
    layout = clean.smooth.layout
    s = with_extra(layout.spectrum(terms, low_pass), clean.rounding)
    k = layout.slow
    return float(np.average(clean.smooth.level[k:] / s[k:], weights=clean.smooth.count[k:]))


def _levelled(x: Array, scale: Array, fs: float, given: Sum | None) -> np.ndarray:
    """The fast noise over `scale`, shape (n,); samples of scale 1 stay as they are."""
    n, size = len(x), 2 * len(x)
    louder = scale != 1.0
    if not louder.any():
        return x
    drifts = [] if given is None else [t for t in given.terms if not t.deterministic and not t.fast]
    quick = [] if given is None else [t for t in given.terms if not t.deterministic and t.fast]
    f = np.maximum(np.arange(n + 1), 0.5) * fs / size
    if drifts and quick:
        # what is slow among the louder (or quieter) noise
        power = float(np.mean(scale[louder] ** 2))
        d = np.asarray(sum(t.psd(f, fs) for t in drifts))
        gain = d / (d + power * sum(t.psd(f, fs) for t in quick))
    elif quick:
        gain = np.zeros(n + 1)
        gain[:2] = 1.0
    else:
        gain = 1.0 / (1.0 + (f * 20.0) ** 4)
    gain[0] = 1.0  # the mean is no noise
    slow_part = np.fft.irfft(np.fft.rfft(np.concatenate([x, x[::-1]])) * gain, size)[:n]
    return np.where(louder, slow_part + (x - slow_part) / scale, x)
