"""The loop: build the path, ask which effects the innovations want, hold them, build again.

Linear effects (`select`) and changes of what is random (`random_effects`) compete by penalised
log-likelihood; a shock is a restart of the filter. What stays at the end is what no exchange and no
removal improves.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from imu_lib.drive import Drive

from . import columns, correct, random_effects, select
from .path import build
from .problem import Noise, Problem

ROUNDS = 10
FAR = 4.0  # of the regression's temper
SHOCK = "other: a shock"
_MOVED = 0.3  # standard deviations by which values may still move when the path is left as it is


@dataclass
class Change:
    """An accepted change of what is random: its `random_effects.Change`, values and gain."""

    change: object
    values: np.ndarray
    gain: float
    before: Noise
    rivals: list = field(default_factory=list)


@dataclass
class State:
    """What is held, and the drive under it."""

    drive: Drive
    noise: Noise
    theta: np.ndarray
    other: np.ndarray = field(default_factory=lambda: np.zeros(len(columns.ALL)))
    kept: tuple = ()
    changes: list = field(default_factory=list)
    restarts: tuple = ()
    problem: Problem | None = None
    result: object = None
    use: np.ndarray | None = None
    reg: object = None
    withhold: tuple = ()
    heading: float | None = None

    def rebuild(self):
        """The path, innovations and regression at what is held now; fixes that the last path could
        not follow are trusted less for the next.
        """
        loose = np.ones(2)
        if self.result is not None:
            e2 = np.where(self.use, self.result.e, np.nan) ** 2
            for k in (0, 1):
                part = e2[:, 3 * k : 3 * k + 3]
                if np.isfinite(part).any():
                    loose[k] = np.clip(np.sqrt(np.nanmean(part)), 1.0, 30.0)
        self.problem = build(
            correct.corrected(self.drive, self.theta),
            self.noise,
            heading=self.heading,
            velocity_shift=correct.velocity_shift(self.theta),
            restarts=self.restarts,
            loose=loose,
        )
        away = np.zeros(self.problem.time.size, bool)
        for start, duration in self.withhold:
            away |= (self.problem.time > start) & (self.problem.time <= start + duration)
        self.use = self.problem.use & ~away[:, None]
        self.weigh()

    def weigh(self):
        """Innovations and regression under the noise held now, on the path as it is."""
        self.result = self.evaluate(self.noise, sens=True)
        self.reg = select.regression(self.problem, self.result, self.theta + self.other, self.use)

    def evaluate(self, noise, sens=False):
        """Innovations under a noise, causes outside the catalogue taken out."""
        return self.problem.evaluate(noise, sens=sens, use=self.use, held=self.other)


def candidates(problem: Problem):
    """Groups of columns that can be asked for on this drive."""
    out = list(select.GROUPS)
    if problem.drive.temperature is None:
        out.remove("other: biases follow the temperature")
    return out


def run(state: State, *, given: bool, random=True, say=lambda text: None) -> State:
    """Search until nothing more is asked for."""
    state.rebuild()
    seen = {}
    for number in range(ROUNDS):
        names = candidates(state.problem)
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
        shock = _shock_step(state)
        if shock is not None and shock[0] > (0.0 if shock[2] or not moved else np.inf):
            state.restarts = (*state.restarts, shock[1])
            say(f"a shock at {shock[1]:.1f} s, {shock[0]:.0f} nats")
            state.rebuild()
            continue
        if moved:
            _hold(state, kept)
            state.rebuild()
            continue
        if not random:
            break
        _refit(state)
        noise = _noise_step(state, given)
        if noise is None:
            break
        _accept(state, noise)
        say(f"{noise.change.key}: {noise.gain:.1f} nats")
        state.weigh()
    _prune(state, say)
    return state


def _step(state, kept):
    """New values where the regression moves them, else None."""
    index = [i for e in kept for i in select.GROUPS[e]]
    x, cov, _ = state.reg.solve(index)
    sd = np.sqrt(np.diag(cov)) if len(index) else np.zeros(0)
    now = (state.theta + state.other)[index]
    return x if np.any(np.abs(x - now) > _MOVED * np.maximum(sd, 1e-12)) else None


def _hold(state, kept):
    index = [i for e in kept for i in select.GROUPS[e]]
    x, _, _ = state.reg.solve(index)
    theta, state.other = np.zeros(len(columns.ALL)), np.zeros(len(columns.ALL))
    for i, value in zip(index, x):
        outside = columns.ALL[i].effect.startswith("other")
        (state.other if outside else theta)[i] = value
    theta = _bounded(theta)
    state.theta, state.kept = theta, tuple(kept)


def _bounded(theta):
    """Values that a path can be built with; what goes beyond takes a second step."""
    theta = theta.copy()
    for effect, most in (("accel_scale", 0.3), ("gyro_scale", 0.3), ("imu_clock", 0.02)):
        part = columns.of(effect)
        theta[part] = np.clip(theta[part], -most, most)
    return theta


def _refit(state):
    """The accepted changes fitted again where the path has changed under them."""
    for found in state.changes:
        start = replace(found.change, start=tuple(float(v) for v in found.values))
        values, gain, noise = start.fitted(state, state.noise, state.result.log_likelihood)
        if gain > 0.05:
            found.values, state.noise = values, noise
            state.weigh()


def _noise_step(state, given):
    """The best change of what is random, fitted, or None."""
    base = state.result.log_likelihood
    options = random_effects.changes(state.problem, state.noise, given)
    taken = {c.change.key for c in state.changes}
    ranked = random_effects.screen(state, state.noise, base, options)
    ranked = [r for r in ranked if r[0] > 1.0 and r[1].key not in taken][:3]
    found = []
    for _, change in ranked:
        values, gain, noise = change.fitted(state, state.noise, base)
        found.append((gain - random_effects.penalty(change), gain, change, values, noise))
    if not found:
        return None
    found.sort(key=lambda f: -f[0])
    value, gain, change, values, noise = found[0]
    if value < 0.0:
        return None
    out = Change(
        change,
        values,
        gain,
        state.noise,
        [(f[2].effect, f[0] - value, f[2].key) for f in found[1:]],
    )
    out.noise = noise
    return out


def _accept(state, found):
    state.noise = found.noise
    state.changes.append(found)


def _shock_step(state):
    """(gain, time, whether most of the excess is there) of a restart of the filter where the
    innovations stand out at one place.
    """
    if len(state.restarts) >= 3:
        return None
    e = np.where(state.use, state.result.e, 0.0)
    nis = np.nansum(e**2, axis=1)
    freedom = np.maximum(state.use.sum(axis=1), 1)
    time = state.problem.time
    block = ((time - time[0]) / 5.0).astype(int)
    total = np.bincount(block, nis) / np.maximum(np.bincount(block, freedom), 1)
    usual = np.median(total)
    worst = int(np.argmax(total))
    if total[worst] < 6.0 * max(usual, 1.0):
        return None
    inside = np.flatnonzero((block >= worst - 1) & (block <= worst))
    level = nis[inside] / freedom[inside]
    out = inside[np.argmax(level > 0.3 * level.max())]
    when = float(time[max(out - 1, 0)] + 1e-3)
    trial = dict(state.problem.arrays)
    begins = trial["begins"].copy()
    node = int(np.searchsorted(trial["node_time"], when))
    if node >= begins.size or begins[node]:
        return None
    begins[node] = True
    kept = state.problem.arrays
    state.problem.arrays = {**kept, "begins": begins}
    value = state.evaluate(state.noise).log_likelihood
    state.problem.arrays = kept
    gain = value - state.result.log_likelihood - 25.0
    excess = np.maximum(nis - freedom, 0.0)
    near = np.abs(block - worst) <= 2
    return (gain, when, excess[near].sum() > 0.5 * excess.sum()) if gain > 0.0 else None


def _prune(state, say):
    """Take out every restart and every change of what is random that is not worth its price."""
    for when in state.restarts:
        kept = state.problem.arrays
        begins = kept["begins"].copy()
        begins[np.searchsorted(kept["node_time"], when)] = False
        state.problem.arrays = {**kept, "begins": begins}
        value = state.evaluate(state.noise).log_likelihood
        state.problem.arrays = kept
        if state.result.log_likelihood - value < 25.0:
            say(f"the shock at {when:.1f} s taken out again")
            state.restarts = tuple(r for r in state.restarts if r != when)
            state.rebuild()
    again = True
    while again and state.changes:
        again = False
        losses = []
        for found in state.changes:
            rest = [c for c in state.changes if c is not found]
            noise = _without(state, found)
            value = state.evaluate(noise).log_likelihood
            losses.append((state.result.log_likelihood - value, found, rest, noise))
            found.gain = state.result.log_likelihood - value
        loss, found, rest, noise = min(losses, key=lambda v: v[0])
        if loss < random_effects.penalty(found.change):
            say(f"{found.change.key} taken out again")
            state.noise, state.changes = noise, rest
            state.weigh()
            again = True


def _without(state, found):
    """The noise with one change undone: the others entered anew on the first hypothesis."""
    noise = state.changes[0].before
    for other in state.changes:
        if other is not found:
            noise = other.change.enter(noise, other.values)
    return noise
