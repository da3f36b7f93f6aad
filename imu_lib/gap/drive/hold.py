"""Taking values and noises over: a set of effects held on a path built for it, noises fitted
again.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from . import alone, posterior, select

if TYPE_CHECKING:
    from imu_lib.gap.drive.state import State

SLACK = 2.0  # nats by which a path of its own may disappoint


def held(state: State, kept: tuple[str, ...], freely: bool = False) -> bool:
    """Hold a set of effects and build the path anew, with half the change where the whole makes the
    innovations worse, and with none where that does too (freely: the whole in any case): whether
    something was held.
    """
    theta, other = alone.values(state.reg, kept)
    before, cost = replace(state), state.cost()
    # what leaves need not have been worth more than its price
    saved = max(select.price(state.reg, state.kept) - select.price(state.reg, kept), 0.0)
    for share in (1.0, 0.5):
        state.theta = before.theta + share * (theta - before.theta)
        state.other = before.other + share * (other - before.other)
        state.kept = tuple(kept)
        state.rebuild()
        if freely or state.cost() < cost + SLACK + saved:
            return True
    state.take(before)
    return False


def refit(state: State) -> None:
    """The accepted changes fitted again where the path has changed under them."""
    short = replace(state, problem=state.problem.brief())
    for found in state.changes:
        values = posterior.refitted(replace(short, noise=state.noise), found)
        noise = found.change.enter(state.noise, values)
        gain = state.evaluate(noise).log_likelihood - state.result.log_likelihood
        if gain > 0.05:
            found.values, state.noise = values, noise
            state.weigh()
