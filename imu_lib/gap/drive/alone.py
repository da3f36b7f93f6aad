"""Whether fewer effects do as well, each set on a path of its own.

The regression that chose a set is linear about the path that was held then. Where that path was far
off, effects are found beside the true one that only make up for what is not linear, and about the
path built with all of them none seems idle. So each smaller set is led to its own path, step by
step until its innovations improve no more, and kept where it loses less than the price of what
left.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from threading import Lock
from typing import TYPE_CHECKING

import numpy as np

from imu_lib.arrays import Array
from imu_lib.navigation.side_by_side import each

from . import columns, select, vehicle

if TYPE_CHECKING:
    from imu_lib.gap.drive.regression import Regression
    from imu_lib.gap.drive.state import State

STEPS = 3
STILL = 1.0  # nats: a step that gains less is the last
HOPED = 2.0  # times what the regression promises, at the most, do the steps left gain
HOPELESS = 30.0  # nats beyond that by which a set may be worse: no confidence tells more apart
SURE = 8.0  # times the price of what leaves: where the regression loses more, nothing is tried
#: Nats, and share of an effect's worth, by which a rival may lack about the path held and still be
#: the better one on its own: what is large is not quite linear.
OPEN, BENT = 20.0, 0.05
PAST = select.PER_EFFECT  # nats by which a smaller set may be worse and lead to a better one
EXCHANGES = 3
TRIED = 4


def converge(state: State, kept: tuple[str, ...], enough: float = np.inf) -> None:
    """Hold a set of effects and build the path anew until its innovations improve no more, or are
    so much worse than `enough` nats that the steps left cannot make up for it.
    """
    for number in range(STEPS):
        before, cost = replace(state), state.cost() if number else np.inf
        theta, other = values(state.reg, kept)
        state.theta, state.other, state.kept = theta, other, tuple(kept)
        state.rebuild()
        now = state.cost()
        if now > cost:
            state.take(before)
        if now > cost - STILL:
            break
        more = promised(state, kept)
        if more < STILL or now - HOPED * more > enough + HOPELESS:
            break


def promised(state: State, kept: tuple[str, ...]) -> float:
    """Nats by which the innovations would improve with the best values of a set, were they linear
    in them.
    """
    index = sorted({i for e in (*kept, *state.kept) for i in columns.GROUPS[e]})
    mine = [i for e in kept for i in columns.GROUPS[e]]
    best = np.zeros(len(columns.ALL))
    best[mine] = state.reg.solve(mine)[0]
    delta = (best - state.theta - state.other)[index]
    return 0.5 * float(delta @ state.reg.information[np.ix_(index, index)] @ delta)


def _tried(
    state: State, sets: list[tuple[str, ...]], worse: float = 0.0
) -> tuple[Array, State | None]:
    """Misfits of sets, each on a path of its own, and the state of the best: None where it is
    `worse` nats or more above what is held. The other paths are not kept: each is large.
    """
    temper = state.reg.temper  # one for all, or a worse path would count for less
    top, lock = misfit(state, temper) + worse, Lock()
    best: list[tuple[float, State]] = []

    def led(kept: tuple[str, ...]) -> float:
        trial = replace(state, theta=state.theta.copy(), other=state.other.copy())
        converge(trial, kept, enough=state.cost())
        value = misfit(trial, temper)
        with lock:
            if value < min([top, *(v for v, _ in best)]):
                best[:] = [(value, trial)]
        return value

    return np.array(each(led, sets)), best[0][1] if best else None


def values(reg: Regression, kept: tuple[str, ...]) -> tuple[Array, Array]:
    """(theta, other) of a set by the regression, in bounds with which a path can be built."""
    index = [i for e in kept for i in columns.GROUPS[e]]
    x, _, _ = reg.solve(index)
    theta, other = np.zeros(len(columns.ALL)), np.zeros(len(columns.ALL))
    for i, value in zip(index, x):
        (theta if columns.in_path(columns.ALL[i].effect) else other)[i] = value
    for effect, most in (("accel_scale", 0.3), ("gyro_scale", 0.3), ("imu_clock", 0.02)):
        part = columns.of(effect)
        theta[part] = np.clip(theta[part], -most, most)  # what goes beyond takes a second step
    return theta, other


def simplify(state: State, say: Callable[[str], object]) -> None:
    """Take effects out as long as a smaller set does as well on its own path: also past sets that
    are worse by less than chance, of effects that make up for one another.
    """
    on, temper = replace(state), state.reg.temper
    while len(on.kept) > 1:
        room = PAST - misfit(on, temper) + misfit(state, temper)
        _, found = _tried(on, _smaller(on), room)
        if found is None:
            return
        on = found
        if misfit(on, temper) < misfit(state, temper):
            say("as good on a path of their own: " + ", ".join(on.kept))
            state.take(on)


def exchange(state: State, say: Callable[[str], object]) -> bool:
    """Try each effect's nearest rivals in its place, each on a path of its own, and hold what fits
    better: whether something was exchanged. What the rivals lack stays in `state.apart`, {(effect,
    rival): nats}.
    """
    for number in range(EXCHANGES):
        pairs = _rivals(state)
        sets = [tuple(r if e == of else e for e in state.kept) for of, r in pairs]
        found, trial = _tried(state, sets)
        lacks = found - misfit(state, state.reg.temper)
        state.apart = {pair: float(v) for pair, v in zip(pairs, lacks)}
        if trial is None:
            return number > 0
        effect, rival = pairs[int(np.argmin(lacks))]
        say(f"{rival} instead of {effect}: {-lacks.min():.1f} nats better on a path of its own")
        state.take(trial)
    state.apart = {}
    return True


def _rivals(state: State) -> list[tuple[str, str]]:
    """(effect, rival): the two nearest of each that the regression about this path leaves open."""
    out, top = [], select.score_of(state.reg, state.kept)
    for effect in state.kept:
        rest = tuple(e for e in state.kept if e != effect)
        worth = top - select.score_of(state.reg, rest)
        near = []
        for rival in columns.GROUPS:
            if (
                rival in state.kept
                or not np.diag(state.reg.information)[columns.GROUPS[rival]].any()
            ):
                continue
            kept = tuple(rival if e == effect else e for e in state.kept)
            lacks = top - select.score_of(state.reg, kept)
            if lacks < OPEN + BENT * worth:
                near.append((lacks, rival))
        out += [(effect, rival) for _, rival in sorted(near)[:2]]
    return out


def misfit(state: State, temper: float) -> float:
    """Tempered misfit of the innovations and of the values with the price of the set, nats, and of
    a case that stands askew where the set has it so.
    """
    index = [i for e in state.kept for i in columns.GROUPS[e]]
    held = (state.theta + state.other)[index] / columns.PRIOR[index]
    paid = select.price(state.reg, state.kept) + 0.5 * float(held @ held)
    return state.cost() / temper + paid + _askew(state)


def _askew(state: State) -> float:
    """What it costs, nats, that the case stands as the path has it: its angles against their
    standard deviations, at the most the price of three that are free.
    """
    found = vehicle.mounting(state.problem, vehicle.attitude_sd(state))
    if found is None:
        return 0.0
    free = select.PER_EFFECT + 3 * select.PER_PARAMETER
    return min(0.5 * float(np.sum((found[0] / found[1]) ** 2)), free)


def _smaller(state: State) -> list[tuple[str, ...]]:
    """Sets without one effect, or with one alone, that the regression does not rule out: the TRIED
    that it finds best.
    """
    out: list[tuple[str, ...]] = []
    top = select.score_of(state.reg, state.kept)
    for effect in state.kept:
        out.append(tuple(e for e in state.kept if e != effect))
        out.append((effect,))
    whole = select.price(state.reg, state.kept)
    lacks = {k: top - select.score_of(state.reg, k) for k in dict.fromkeys(out)}
    open_ = [k for k in lacks if lacks[k] < SURE * (whole - select.price(state.reg, k))]
    return sorted(open_, key=lacks.__getitem__)[:TRIED]
