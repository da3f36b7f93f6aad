"""What a noise that was fitted to the drive hides: a walk that is large enough holds any bias that
moves, and then the innovations ask for nothing. Under smaller walks they ask for it; the two are
held against each other.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from . import across, alone, base_model, levels, select
from .hold import held
from .state import State

#: By which walks of gyros and accelerometers are made smaller.
SMALLER = ((0.3, 1.0), (1.0, 0.3), (0.1, 1.0), (1.0, 0.1), (0.3, 0.3), (0.1, 0.1))
MARGIN = 3.0  # nats
TRIED = 2  # on paths of their own


def look(state: State, names: list[str], say: Callable[[str], object]) -> bool:
    """Hold an effect that smaller walks let be seen, where both together do better than what is
    held: whether so.
    """
    now = across.worth(state, state.reg.temper)
    for trial in _promising(state, names):
        base_model.settle(trial)
        if across.worth(trial, state.reg.temper) < now - across.BETTER:
            say("under smaller walks: " + ", ".join(trial.kept))
            state.take(trial)
            state.noise, state.base, state.changes = trial.noise, trial.base, trial.changes
            return True
    return False


def _promising(state: State, names: list[str]) -> Iterator[State]:
    """States with smaller walks and one more effect whose likelihood promises to be better, the
    best first.
    """
    found = []
    for factors in SMALLER:
        trial = state.copy()
        x = levels.of(state.noise, ())
        x[2:] += np.log(factors)
        trial.noise = levels.entered(state.noise, x, ())
        trial.weigh()
        lost = state.result.log_likelihood - trial.result.log_likelihood
        more = [e for e in names if e not in state.kept]
        worth = [
            alone.promised(trial, (*state.kept, e)) - select.price(trial.reg, (e,)) for e in more
        ]
        best = int(np.argmax(worth))
        if worth[best] - lost < MARGIN:
            continue
        base_model.hold(trial, trial.noise)
        found.append((worth[best] - lost, trial, more[best]))
    for _, trial, effect in sorted(found, key=lambda f: -f[0])[:TRIED]:
        held(trial, (*state.kept, effect), freely=True)
        yield trial
