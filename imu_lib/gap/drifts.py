"""Deterministic drifts: scanned by generalised least squares, their time constants and instants
found beside one another.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from imu_lib.gap import effects, slow
from imu_lib.gap.effects.step import sharpen
from imu_lib.gap.engine import SCREEN
from imu_lib.gap.state import Item, State


def _scanner(state: State, columns):
    """Gain, amplitude and squared norm of drifts by generalised least squares under the fitted
    noise, beside `columns`.
    """
    data = state.cleaned
    white = slow.whitening_matrix(state.likelihood.shapes(state.fit.vector)[1])
    e = white @ data.d
    basis = None
    if columns is not None:
        basis, _ = np.linalg.qr(white @ columns)
        e = e - basis @ (basis.T @ e)

    def scan(effect, processes):
        a = white @ np.diff(effect.columns(processes, data), axis=0)
        if basis is not None:
            a = a - basis @ (basis.T @ a)
        norm = np.maximum(np.sum(a * a, axis=0), 1e-300)
        return 0.5 * (a.T @ e) ** 2 / norm, (a.T @ e) / norm, norm

    return scan


def drift_candidates(state: State) -> list[Item]:
    """Deterministic drifts by generalised least squares under the fitted noise."""
    out, scan = [], _scanner(state, state.assemble()[3])
    for effect in effects.DRIFTS:
        if effect.name in ("ramp", "warm_up", "temperature") and any(
            i.name == effect.name for i in state.items
        ):
            continue
        # a drift beside a transient whose time constant is not yet its own gains only when both
        # are found anew
        beside = effect.name == "ramp" and any(i.name == "warm_up" for i in state.items)
        item = _best_drift(state, effect, scan, 0.0 if beside else SCREEN)
        if item is not None:
            out.append(item)
        if effect.name == "temperature":
            out += _bent(effect, scan, state.cleaned)
    return out


def _bent(effect, scan, data) -> list[Item]:
    """A bias that follows the temperature with a curvature, a lag or both; a fitted base may have
    taken so much of it for noise that only the whole shape wins it back.
    """
    out = []
    for process in effect.candidates(data):
        for best, intervals, odds in effect.bent(process, scan, data):
            gain = float(scan(effect, [best])[0][0])
            if gain > SCREEN:
                note = {"screen": gain, "intervals": intervals, "ll": 0.0}
                column = np.diff(effect.columns([best], data)[:, 0])
                out.append(Item(effect.key, best, column=column, bonus=odds, note=note))
    return out


def _best_drift(state, effect, scan, screen: float = SCREEN) -> Item | None:
    data = state.cleaned
    processes = effect.candidates(data)
    if not processes:
        return None
    gain, _, _ = scan(effect, processes)
    j = int(np.argmax(gain))
    if gain[j] < screen:
        return None
    best, note = processes[j], {"screen": float(gain[j])}
    if effect.name == "step":  # log of the share of all instants at which the jump may lie
        note["width"] = float(np.log(np.sum(np.exp(gain - gain[j])) / len(gain)))
    if effect.shape is not None:
        best, edge = _refine(effect, best, scan, data, state)
        if edge is not None:  # seen in the samples: the odds fall off on both sides like exp(-|t|)
            note["edge"], note["width"] = (
                edge,
                float(np.log((edge[2] - edge[1]) / 3.0 / data.duration)),
            )
    column = np.diff(effect.columns([best], data)[:, 0])
    return Item(effect.key, best, column=column, note=note)


def _others(state: State, item: Item):
    """The columns of the other drifts, or None."""
    columns = [o.column for o in state.items if o.column is not None and o is not item]
    return np.column_stack(columns) if columns else None


def profiled(state: State) -> State:
    """The state with the range of every drift's shape parameter noted."""
    items = []
    if not any(i.column is not None and i.effect.shape is not None for i in state.items):
        return state
    for item in state.items:
        if item.column is not None and item.effect.shape is not None:
            item = replace(
                item,
                note={
                    **item.note,
                    "profile": _profile(
                        item.effect,
                        item.process,
                        _scanner(state, _others(state, item)),
                        state.cleaned,
                    ),
                },
            )
        items.append(item)
    return state.with_items(items).settled()


def retuned(state: State) -> State:
    """The state with the shapes of its drifts (time constants, instants) found anew beside one
    another.
    """
    for _ in range(2):
        moved = False
        for i, item in enumerate(state.items):
            if item.column is None or item.effect.shape is None:
                continue
            others = _others(state, item)
            if others is None:
                continue
            scan = _scanner(state, others)
            best = _best_drift(state, item.effect, scan)
            if best is None:
                continue
            gain, _, _ = scan(item.effect, [item.process, best.process])
            if gain[1] > gain[0] + 0.1:
                state = state.with_items(state.items[:i] + (best,) + state.items[i + 1 :])
                moved = True
        if not moved:
            break
    return state


def _refine(effect, best, scan, data, state):
    """The drift with its shape at the best place, and the edge that the samples show of a jump, or
    None.
    """
    for reach in (1.0, 0.12, 0.015):
        trial = effect.around(best, data, reach, 25)
        gain, amplitude, _ = scan(effect, trial)
        j = int(np.argmax(gain))
        best = trial[j] if amplitude[j] >= 0 else effect.upright(trial[j])
    edge = None
    if effect.name == "step":
        amplitude = float(amplitude[j])
        s = state.likelihood.shapes(state.fit.vector)[0]
        density = (
            max(float(np.median(s)), float(np.median(s[:20]))) / 2
        )  # red noise has edges of its own
        edge = sharpen(data.x, data.fs, best.time, data.m / data.fs, amplitude, density)
        if edge is not None:
            best = best.with_(time=edge[0])
    return best, edge


def _profile(effect, best, scan, data):
    """Range of the shape parameter within 1.92 of the best log-likelihood (3 for an edge)."""
    trial = effect.around(best, data, 6.0, 241)
    gain, _, _ = scan(effect, trial)
    values = np.array([getattr(p, effect.shape) for p in trial])
    near = values[gain > gain.max() - (3.0 if effect.name == "step" else 1.92)]
    return [float(near.min()), float(near.max())]
