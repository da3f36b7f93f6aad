"""A base where none is given: the family and its parameters fitted to the record, so that only what it cannot express shows."""
from __future__ import annotations

import numpy as np

from imu_lib.gap.effects import CATALOGUE
from imu_lib.gap.engine import Data
from imu_lib.gap.search import State
from imu_lib.processes import Flicker, GaussMarkov, Quantization, RandomWalk, WhiteNoise

#: Families of a free base: the noises beside white noise.
FAMILIES = ((), ("random_walk",), ("flicker",), ("gauss_markov",), ("flicker", "random_walk"), ("gauss_markov", "random_walk"), ("gauss_markov", "gauss_markov"))


def _starts(data: Data, family):
    """Several starting points of a family, from the level of the spectrum."""
    s = data.power
    top = float(np.median(s[-60:]))
    low = float(np.median(s[2:8]))
    f_low = float(np.median(data.layout.f[2:8]))
    excess = max(low - top, 0.1 * top)
    N = np.sqrt(top / 2)
    make = {"random_walk": lambda _: RandomWalk(K=float(np.sqrt(excess / 2) * 2 * np.pi * f_low)),
            "flicker": lambda _: Flicker(B=float(np.sqrt(excess * np.pi * f_low))),
            "gauss_markov": lambda t: GaussMarkov(sigma=float(np.sqrt(max(excess, 0.3 * top) * (1 + (2 * np.pi * f_low * t) ** 2) / (4 * t))), correlation_time=t)}
    times = [0.003 * data.duration, 0.02 * data.duration, 0.1 * data.duration]
    if "gauss_markov" not in family:
        yield [WhiteNoise(N=N)] + [make[n](None) for n in family]
    elif family.count("gauss_markov") == 1:
        for t in times:
            yield [WhiteNoise(N=N)] + [make[n](t) for n in family]
    else:
        for a, b in ((0, 2), (0, 1), (1, 2)):
            yield [WhiteNoise(N=N), make["gauss_markov"](times[a]), make["gauss_markov"](times[b])]


def free_base(data: Data, held=()) -> State:
    """The best family by evidence, as a state whose base is free."""
    best = None
    for family in FAMILIES:
        for terms in _starts(data, family):
            terms = list(held) + terms
            slots = [CATALOGUE[t.name].slot(i, data.fs, data.duration) for i, t in enumerate(terms) if i >= len(held)]
            state = State(data, terms, base_slots=slots)
            if best is None or state.evidence > best.evidence:
                best = state
    return best.settled()
