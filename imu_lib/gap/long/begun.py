"""What the views of a long record begin with where no model was given."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from imu_lib import likelihood
from imu_lib.arrays import Array
from imu_lib.gap import loop
from imu_lib.gap.found import Report
from imu_lib.gap.long import views
from imu_lib.gap.long.scan import Scan
from imu_lib.model import Model
from imu_lib.processes import GaussMarkov, Sum, Telegraph
from imu_lib.record import Record


def with_bases(model: Model | None, fast: Report, scans: list[Scan], rate: float) -> Model:
    """The given model; a channel that it lacks has what the part at the full rate was started
    from, with the slow processes that the likelihood chooses for the block means.
    """
    found = {}
    for s in scans:
        if s.name in fast.channels and (model is None or s.name not in model):
            base = fast.channels[s.name].result.base
            quick = [t for t in base.terms if not views.is_slow(t, rate)]
            found[s.name] = Sum((*quick, *_slow_terms(s.means, rate)), base.stages)
    if model is None:
        return Model(found, rate=fast.record.rate)
    return replace(model, channels={**model.channels, **found})


def between_levels(
    means: Record, given: Model, free: list[str], block: int, options: dict[str, Any]
) -> Model:
    """The model without the Gauss-Markov processes that two levels explain better, of the channels
    `free` whose slow processes nobody gave: the spectrum of both is the same.
    """
    bare = {}
    for n in free:
        entry = given[n]
        slow = [
            t for t in entry.terms if isinstance(t, GaussMarkov) and views.is_slow(t, means.rate)
        ]
        if slow:
            bare[n] = Sum(tuple(t for t in entry.terms if t not in slow), entry.stages)
    if not bare:
        return given
    begun = {n: views.averaged(entry, block, means.rate * block)[0] for n, entry in bare.items()}
    found = loop.close(
        means, Model(begun, rate=means.rate), channels=list(bare), **options | {"simulations": 0}
    )
    levels = {
        n: bare[n]
        for n, c in found.channels.items()
        if any(s.effect == Telegraph.name for s in c.result.steps)
    }
    return replace(given, channels={**given.channels, **levels})


def _slow_terms(means: Array, rate: float) -> list[Any]:
    """The slow processes of the sum that the likelihood chooses for a series of block means."""
    stats = likelihood.Statistics.of([means], rate, exclude_lines=True)
    fit = likelihood.choose(stats.between(0.0, 0.2 * rate), None).fit
    return [t for t in fit.model.terms if views.is_slow(t, rate)]
