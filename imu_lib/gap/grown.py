"""Models that the workflow makes of a base and of what was found: the grown one, those on the way,
and refits to a part.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from imu_lib.gap.effects.base import Finding
from imu_lib.gap.state import State
from imu_lib.likelihood.evidence import Maximum
from imu_lib.likelihood.slot import FILTER
from imu_lib.processes import Stage, Sum

#: Part of the record, from its beginning, that the held-out comparison is fitted on.
FITTED = 0.6
#: Share of that part by which an effect has to have begun to be seen in it.
LATE = 0.95
#: Models that stand for what a fit to that part leaves uncertain.
REFITS = 100


def grown(
    base: Sum,
    state: State,
    findings: list[Finding],
    n_base: int,
    shared: int,
    *,
    fit: Maximum | None = None,
) -> Sum:
    """The base with what was found: changed parameters, added processes, drifts with their
    amplitudes, stages.

    `shared` terms after the base's own stand for noise that the record accounts for; they are left
    out. `fit` takes the place of the state's own.
    """
    fit = state.fit if fit is None else fit
    terms = [t for t in base.terms]
    noise = [i for i, t in enumerate(terms) if not t.deterministic]
    fitted = list(fit.terms)
    own = (
        fitted[shared : n_base + shared] if not base.terms or state.base_slots else fitted[:n_base]
    )
    for place, index in enumerate(noise):
        terms[index] = own[place]
    terms += fitted[n_base + shared :]
    stages = {s.name: s for s in base.stages}
    for item in state.items:
        item.effect.grow(state, item, fit, terms, stages)
    for f in findings:
        if isinstance(f.process, Stage):
            stages[f.process.name] = f.process
        else:
            terms.append(f.process)
    return Sum(tuple(terms), tuple(stages.values()))


def between(base: Sum, findings: list[Finding], state: State) -> list[Sum]:
    """The models after each step but the last: the base with the first effects only."""
    count = len(findings) + len(state.items)
    out = []
    for k in range(1, count):
        few = findings[:k]
        items = list(state.items[: max(0, k - len(findings))])
        part = state.with_items(items)
        noise = [t for t in base.terms if not t.deterministic]
        out.append(grown(base, part, few, len(noise), len(state.base) - len(noise)))
    return out


def refits(
    base: Sum,
    state: State,
    findings: list[Finding],
    n_base: int,
    shared: int,
    rng: np.random.Generator,
) -> list[Sum]:
    """Grown models whose free parameters are drawn from their distribution given the first part of
    the record alone.

    The distribution is normal about the fit, in logarithms but for the amplitudes of drifts: what
    is predicted from the first part scatters by the noise and by what the first part leaves open.
    Empty where an effect happens only in the rest.
    """
    data = state.data
    n = int(FITTED * data.n)
    every: list[Any] = [*state.items, *findings]
    added = [f.process for f in every if f.process is not None]
    if any(p.onset > LATE * n / data.fs for p in added):
        return []
    first = data.part(data.x[:n], slice(n))
    items = []
    for item in state.items:
        if item.column is not None:
            column = item.effect.columns([item.process], first)[:, 0]
            if not np.any(column):
                return []
            items.append(replace(item, column=column))
        elif item.signal is not None:
            items.append(replace(item, signal=item.signal[:n]))
        else:
            items.append(item)
    again = State(
        first, state.base, items, low_pass=state.base_low_pass, base_slots=state.base_slots
    )
    free = len(again.fit.vector) + len(again.fit.beta) > 0
    return [
        grown(base, again, findings, n_base, shared, fit=fit)
        for fit in _drawn(again, rng, REFITS if free else 1)
    ]


def likely(
    states: list[tuple[State, float]],
    given: Sum | None,
    findings: list[Finding],
    held_terms: int,
    rng: np.random.Generator,
) -> list[Sum]:
    """Grown models whose free parameters are drawn from their distribution given the whole record,
    as many of each of `states` (state, share) as its share: what the record leaves uncertain.
    """
    out = []
    for state, share in states:
        base = given if given is not None else Sum(tuple(state.base[held_terms:]))
        parts = base, state, findings, len(state.base) - held_terms, held_terms
        out += [grown(*parts, fit=fit) for fit in _drawn(state, rng, round(share * REFITS))]
    return out


def _drawn(state: State, rng: np.random.Generator, count: int) -> list[Maximum]:
    """Fits whose parameters are drawn from the normal distribution about the state's own, within
    the bounds of each.
    """
    fit, problem = state.fit, state.problem
    vectors, betas = np.zeros((count, 0)), np.zeros((count, 0))
    if len(fit.vector):
        # where the data say little the prior's width is what is left
        prior = np.diag(1.0 / np.concatenate([np.asarray(s.widths, float) for s in fit.slots]) ** 2)
        low, high = problem.low, problem.high
        cov = np.linalg.inv(fit.information + prior)
        # a parameter at its bound says nothing: rounding may leave it a variance below zero
        size, axes = np.linalg.eigh(0.5 * (cov + cov.T))
        root = axes * np.sqrt(np.maximum(size, 0.0))
        vectors = fit.vector + rng.standard_normal((count, len(size))) @ root.T
        at = np.cumsum([0, *(len(s.names) for s in fit.slots)])
        for k in (at[i] for i, s in enumerate(fit.slots) if s.index == FILTER):
            # a filter's cutoff takes a few values only: its spectrum is made once for each
            grid = 0.5 * np.sqrt(cov[k, k])
            vectors[:, k] = fit.vector[k] + grid * np.round((vectors[:, k] - fit.vector[k]) / grid)
        vectors = np.clip(vectors, low, high)
    if len(fit.beta):
        betas = rng.multivariate_normal(fit.beta, fit.beta_cov, count, method="eigh")
    out = []
    for vector, beta in zip(vectors, betas):
        terms, low_pass = problem.unpack(vector)
        out.append(replace(fit, terms=tuple(terms), low_pass=low_pass, beta=beta))
    return out
