"""The loop: build the path, ask which effects the innovations want, hold them, build again.

Linear effects (`select`) and changes of what is random (`random_effects`) compete by penalised
log-likelihood; a shock is a restart of the filter. What stays at the end is what no exchange and no
removal improves.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from imu_lib.arrays import Array
from imu_lib.navigation import fix_faults
from imu_lib.navigation.side_by_side import each

from . import (
    across,
    alone,
    base_model,
    columns,
    common_turn,
    displaced,
    hidden,
    prune,
    random_effects,
    readings,
    select,
    shocks,
    step_time,
    swap,
)
from .hold import held, refit
from .problem import Problem
from .state import Change, State

Say = Callable[[str], object]

ROUNDS = 14
FAR = 4.0  # of the regression's temper
SHOCK = "other: a shock"
SIZE_OF_VELOCITY = ("gnss_noise", "velocity")
LEAST_FAR = 0.06  # of the logarithm of the innovations' size
_MOVED = 0.3  # standard deviations by which values may still move when the path is left as it is


def candidates(problem: Problem) -> list[str]:
    """Groups of columns that can be asked for on this drive."""
    out = list(columns.GROUPS)
    if problem.drive.temperature is None:
        out.remove("other: biases follow the temperature")
    return out


def run(state: State, *, given: bool, random: bool = True, say: Say = lambda text: None) -> State:
    """Search until nothing more is asked for."""
    state.rebuild()
    for _ in range(2):  # a path that chases noisy fixes is no path to be linear about
        if state.size() > 1.5:
            state.rebuild()
    if random:
        _start_wild(state, say)
    step_time.look(state, say)
    displaced.look(state, say)
    seen: dict[tuple[object, ...], int] = {}
    refused: set[str] = set()
    for number in range(ROUNDS):
        names = [n for n in candidates(state.problem) if n not in refused]
        # a path that is still far off looks like many things at once
        most = number + 1 if number < 2 and state.reg.temper > FAR else 8
        kept, _ = select.best(state.reg, names, most)
        linear = _step(state, kept)
        moved = set(kept) != set(state.kept) or linear is not None
        key = (frozenset(kept), tuple(c.change.key for c in state.changes), state.restarts)
        seen[key] = seen.get(key, 0) + 1
        if seen[key] > 3:
            moved = False
        say(f"round {number + 1}: {', '.join(kept) or 'no linear effect'}")
        # what gains most comes first: under a wrong noise, or past a shock, all looks like an
        # effect
        promise = alone.promised(state, kept) if moved else 0.0
        if random and not moved:
            refit(state)
        noise = _noise_step(state, given) if random and (not moved or _far(state)) else None
        wild = noise is not None and noise.change.effect == "gnss_outliers"
        if wild and displaced.look(state, say):  # the first fixes after it look wild
            continue
        if _random_step(state, noise, promise, given, say):
            continue
        if moved and held(state, kept):
            continue
        if moved and set(kept) - set(state.kept):
            refused |= set(kept) - set(state.kept)
            say("no better on a path of its own: " + ", ".join(set(kept) - set(state.kept)))
            continue
        break
    if state.free and random and state.reg.temper < FAR:
        shocks.hidden(state, say)
        hidden.look(state, candidates(state.problem), say)
    for _ in range(3):
        common_turn.taken_out(state, say)
        alone.simplify(state, say)
        again = alone.exchange(state, say)
        if random and state.reg.temper < FAR:  # nothing small is told apart far from a right model
            names = candidates(state.problem)
            again |= across.exchange(state, names, lambda s: _noise_step(s, given), say)
        if not again:
            break
    prune.worthless(state, say)
    swap.noises(state, given, say)
    prune.noises(state, say)
    if state.changes:
        prune.effects(state, say)
    return state


def _random_step(state: State, noise: Change | None, promise: float, given: bool, say: Say) -> bool:
    """Hold a shock, or the change of what is random, where it gains more than the columns promise
    and than the other: whether something is held that was not.
    """
    gain = noise.gain if noise is not None else 0.0
    shock = shocks.step(state)
    if shock is not None and shock[0] > max(promise, gain):
        state.restarts = (*state.restarts, shock[1])
        say(f"a shock at {shock[1]:.1f} s, {shock[0]:.0f} nats")
    elif noise is None or gain <= promise:
        return False
    elif given or not base_model.anew(state, say):
        # levels that hold what was found since may leave no room for another noise
        _accept(state, noise)
        say(f"{noise.change.key}: {noise.gain:.1f} nats")
    state.rebuild()
    return True


def _start_wild(state: State, say: Say) -> None:
    """Start with wild fixes where the fixes alone show them: a path that follows a few that are far
    off says nothing of the others.
    """
    found = fix_faults.wild(state.drive)
    if found is None or state.noise.fraction > 0.0 or not state.use[:, 0].any():
        return
    options = random_effects.changes(state.problem, state.noise, False)
    change = next(c for c in options if c.effect == "gnss_outliers")
    values = np.array(found)
    change = replace(change, start=tuple(found))
    # afresh: what the path that followed them was trusted with is nothing to start from
    trial = State(
        state.drive, change.enter(state.noise, values), state.theta, state.other, state.kept,
        withhold=state.withhold, step_at=state.step_at, moved_at=state.moved_at, free=state.free,
    )  # fmt: skip
    trial.rebuild()
    gain = trial.result.log_likelihood - state.result.log_likelihood
    if gain < 5.0 * random_effects.penalty(change):
        return
    say(f"{100 * found[0]:.1f} % of the fixes are wild, by {found[1]:.3g} m")
    state.changes.append(Change(change, values, gain, state.noise))
    state.noise = trial.noise
    state.take(trial)


def _step(state: State, kept: tuple[str, ...]) -> Array | None:
    """New values where the regression moves them, else None."""
    index = [i for e in kept for i in columns.GROUPS[e]]
    x, cov, _ = state.reg.solve(index)
    sd = np.sqrt(np.diag(cov)) if len(index) else np.zeros(0)
    now = (state.theta + state.other)[index]
    return x if np.any(np.abs(x - now) > _MOVED * np.maximum(sd, 1e-12)) else None


def _far(state: State) -> bool:
    """Whether innovations are so far from white ones of unit size that a noise may be the cause,
    under which everything looks like an effect.
    """
    chance = np.sqrt(2.0 / max(state.use.sum(), 1))
    far = max(LEAST_FAR, 5.0 * chance)
    return abs(np.log(max(state.size(), 1e-6))) > far or state.reg.temper > 1.2


def _noise_step(state: State, given: bool) -> Change | None:
    """The best change of what is random, fitted, or None."""
    whole, state = state, replace(state, problem=state.problem.brief())
    base = state.evaluate(state.noise).log_likelihood
    taken = {c.change.key for c in state.changes}
    options = random_effects.changes(state.problem, state.noise, given)
    options = [c for c in options if c.key not in taken]
    slow = readings.densities(state.problem, readings.SLOW)
    ranked = random_effects.screen(state, state.noise, base, options)
    ranked = [r for r in ranked if readings.possible(r[1], np.array(r[1].start), slow)]
    ranked = random_effects.shortlist(ranked)
    fitted = each(lambda r: r[1].fitted(state, state.noise, base), ranked)
    measured = readings.densities(state.problem)
    found = []
    for (_, change), (values, gain, noise) in zip(ranked, fitted):
        if not readings.possible(change, values, slow):
            continue
        value = gain - random_effects.penalty(change)
        value += readings.evidence(change, values, measured)
        found.append((value, gain, change, values, noise))
    if not found:
        return None
    found.sort(key=lambda f: -f[0])
    found.insert(0, found.pop(size_first([(f[2], f[1]) for f in found])))
    value, gain, change, values, noise = found[0]
    if state.problem is not whole.problem:
        gain = whole.evaluate(noise).log_likelihood - whole.result.log_likelihood
    if gain < random_effects.penalty(change):
        return None
    rivals = [(f[2].effect, f[0] - value, f[2].key) for f in found[1:]]
    return Change(change, values, gain, state.noise, rivals, noise)


def size_first(ranked: list[tuple[random_effects.Change, float]]) -> int:
    """Which of the changes fitted, the best first, is held: (change, gain, nats). Velocities half
    of whose gain is their size alone have errors of another size, whatever lasts of them besides.
    """
    best, most = ranked[0]
    for k, (change, gain) in enumerate(ranked):
        if best.effect == random_effects.VELOCITY_LASTS and change.key == SIZE_OF_VELOCITY:
            return k if gain > 0.5 * most else 0
    return 0


def _accept(state: State, found: Change) -> None:
    """Hold a change of what is random."""
    state.noise = found.noise
    state.changes.append(found)
