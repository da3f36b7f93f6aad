"""Records with one fault each, and sound ones, drawn by code that shares nothing with the package.

`make(seed, kind)` gives a `Case`: channels, stamps, and the truth: which rows and channels, when, how
much.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from fault_bases import CHANNELS, G, rounded, sound

KINDS = (
    "zero",
    "copy",
    "code",
    "nan",
    "held",
    "held_part",
    "stuck",
    "knock",
    "handling",
    "tilt",
    "restart",
    "hole",
    "turned_in_hole",
    "rate",
    "burst",
    "time_grid",
)


@dataclass
class Case:
    """x: ndarray (n, 6). time: ndarray (n,) or None. truth: what was put in."""

    seed: int
    kind: str
    rate: float
    x: np.ndarray
    sd: np.ndarray
    time: np.ndarray | None = None
    base: tuple = ()
    truth: dict = field(default_factory=dict)

    @property
    def channels(self):
        return {c: self.x[:, i].copy() for i, c in enumerate(CHANNELS)}


def some(rng, *, least=2):
    """Indices of channels: all, a sensor's, or any."""
    return [
        list(range(6)),
        [0, 1, 2],
        [3, 4, 5],
        sorted(rng.choice(6, int(rng.integers(least, 5)), replace=False).tolist()),
    ][int(rng.integers(4))]


def lost_rows(n, rng):
    """Rows of a drop-out: one, some at random, in runs, or periodic with some left out."""
    how = str(rng.choice(["one", "random", "runs", "periodic"]))
    if how == "one":
        rows = np.array([int(rng.choice([0, n // 3, n - 1]))])
    elif how == "periodic":
        rows = np.arange(int(rng.integers(5, 60)), n, int(rng.integers(15, 400)))
        rows = rows[rng.random(len(rows)) > 0.1]
    elif how == "runs":
        starts = rng.choice(n - 50, int(rng.integers(3, 25)), replace=False)
        rows = np.unique(np.concatenate([s + np.arange(int(rng.integers(2, 20))) for s in starts]))
    else:
        rows = np.flatnonzero(rng.random(n) < 10 ** rng.uniform(-3, -1.5))
        rows = rows if len(rows) > 3 else np.array([5, 99, 1234, 4000])
    return rows, how


def make(seed, kind=None):
    """A case; `kind` None is a sound one."""
    rng = np.random.default_rng([seed, KINDS.index(kind) + 1 if kind else 0])
    x, fs, sd, words = sound(seed, rng)
    case = Case(seed, kind or "sound", fs, x, sd)
    maker = globals().get(f"_{kind}") if kind else None
    early = kind in ("knock", "handling", "tilt", "restart", "hole", "turned_in_hole")
    if maker and early:  # before the output stage
        maker(case, rng)
    case.x, how = rounded(case.x, sd, rng)
    case.base = (*words, how)
    if maker and not early:
        maker(case, rng)
    if kind is None and rng.random() < 0.5:
        case.time = np.arange(len(case.x)) / fs
    return case


def by_chance(case, members, same):
    """How many rows the record itself makes that look lost on the channels."""
    share = [same(case.x[:, c]) for c in members]
    return len(case.x) * float(np.prod(share))


def _zero(case, rng):
    rows, how = lost_rows(len(case.x), rng)
    members = some(rng)
    if by_chance(case, members, lambda x: np.mean(x == 0)) > 0.1 * len(rows):
        members = list(range(6))
    case.x[np.ix_(rows, members)] = 0.0
    case.truth = {"finding": "dropout", "rows": rows, "channels": members, "how": how}


def _copy(case, rng):
    rows, how = lost_rows(len(case.x), rng)
    rows = rows[rows > 0]
    if len(rows) == 0:
        rows = np.array([len(case.x) // 2])
    members = some(rng)
    if by_chance(case, members, lambda x: np.mean(np.diff(x) == 0)) > 0.05 * len(rows):
        members, how = list(range(6)), "periodic"
        rows = np.arange(31, len(case.x), 150)
    for r in rows:
        case.x[r, members] = case.x[r - 1, members]
    case.truth = {"finding": "dropout", "rows": rows, "channels": members, "how": how}


def _code(case, rng):
    """Full scale, or a code."""
    rows, how = lost_rows(len(case.x), rng)
    if how == "one":
        rows = np.unique(rng.choice(len(case.x), 5))
    members = some(rng, least=1)
    value = [float(rng.choice([-999.0, 34.9, 2000.0, -32768.0, 65535.0])), 156.9]
    for c in members:
        case.x[rows, c] = value[0] if rng.random() < 0.7 else value[1] + c
    case.truth = {"finding": "dropout", "rows": rows, "channels": members, "how": how}


def _nan(case, rng):
    rows, how = lost_rows(len(case.x), rng)
    members = some(rng, least=1)
    case.x[np.ix_(rows, members)] = np.nan
    case.truth = {"finding": "dropout", "rows": rows, "channels": members, "how": how}


def _hold(case, rng, members):
    n = len(case.x)
    k = rng.uniform(1.8, 8.0)
    jitter = rng.choice([0.0, 0.2])
    at = np.cumsum(np.maximum(1, np.rint(k + rng.normal(0, jitter * k, n)).astype(int)))
    at = np.r_[0, at[at < n]]
    size = np.diff(np.r_[at, n])
    source = case.x[: len(at)][:, members]
    case.x[:, members] = np.repeat(source, size, axis=0)
    case.truth = {
        "finding": "held",
        "channels": list(members),
        "rate": case.rate * len(at) / n,
    }


def _held(case, rng):
    _hold(case, rng, list(range(6)))


def _held_part(case, rng):
    _hold(case, rng, [0, 1, 2] if rng.random() < 0.5 else [3, 4, 5])


def _stuck(case, rng):
    c, n = int(rng.integers(6)), len(case.x)
    starts = np.sort(rng.choice(n // 400, 3, replace=False)) * 400
    rows = []
    for s in starts:
        k = int(rng.integers(60, 300))
        case.x[s : s + k, c] = case.x[s, c]
        rows.append(np.arange(s + 1, s + k))
    case.truth = {"finding": "stuck", "rows": np.concatenate(rows), "channels": [c]}


def shape(m, fs, rng):
    """(m,) of peak 1: what a knock may look like."""
    u = np.arange(m) / max(m, 1)
    f = rng.uniform(1, max(1.5, min(m / 3.0, 12)))
    kind = int(rng.integers(6))
    if kind == 0:
        y = np.exp(-5 * u) * np.sin(2 * np.pi * f * u + rng.uniform(0, 6))
    elif kind == 1:
        y = np.sin(np.pi * (u + 0.5 / m))
    elif kind == 2:
        y = np.exp(-8 * u) * np.cos(2 * np.pi * f * u)
        y = y + 0.7 * np.roll(y, m // 2) * (u >= 0.5)
    elif kind == 3:
        y = np.exp(-4 * u)
    elif kind == 4:
        y = np.sin(2 * np.pi * (f * u + f * u * u)) * np.hanning(m + 2)[1:-1]
    else:
        y = rng.standard_normal(m) * np.exp(-3 * u)
    return y / np.abs(y).max()


def _knock(case, rng):
    n, fs = len(case.x), case.rate
    events = []
    for _ in range(int(rng.integers(1, 6))):
        m = max(2, int(rng.uniform(0.03, 0.6) * fs))
        at = int(rng.uniform(0.03, 0.95) * n)
        if any(abs(at - e["row"]) < 12 * fs + 40 for e in events):
            continue
        members = sorted(set(some(rng, least=3)) | {int(rng.integers(3, 6))})
        for c in members:
            peak = case.sd[c] * 10 ** rng.uniform(1.1, 2.2)
            case.x[at : at + m, c] += peak * shape(m, fs, rng)[: n - at]
        events.append({"row": at, "time": at / fs, "duration": m / fs})
    case.truth = {"finding": "disturbance", "events": events}


def _handling(case, rng):
    """Turned to and fro for some seconds and put back."""
    n, fs = len(case.x), case.rate
    length = int(rng.uniform(2, 20) * fs)
    at = int(rng.uniform(0.1, 0.8) * (n - length))
    m = max(length, 8)
    angle = np.zeros((m, 3))
    u = np.linspace(0, 1, m)
    for a in range(3):
        for k in range(1, 5):
            angle[:, a] += rng.normal() / k * np.sin(np.pi * k * u)
    size = 10 ** rng.uniform(-1.3, 0)
    angle *= size / np.abs(angle).max()
    rate = np.gradient(angle, axis=0) * fs
    down = np.array([0.0, 0.0, -G])
    case.x[at : at + m, :3] += rate
    case.x[at : at + m, 3:] -= np.cross(angle, down)
    hand = np.hanning(m)[:, None] * rng.standard_normal((m, 6)) * case.sd * 3
    case.x[at : at + m] += hand
    case.truth = {
        "finding": "disturbance",
        "events": [{"row": at, "time": at / fs, "duration": m / fs}],
    }


def _tilt(case, rng):
    """A turn that stays: from what both sensors can show up to some degrees."""
    n, fs = len(case.x), case.rate
    length = max(1, int(10 ** rng.uniform(-0.5, 0.8) * fs))
    at = int(rng.uniform(0.2, 0.75) * n)
    white = np.median(case.sd[:3]) / np.sqrt(fs)
    wander = np.median(case.sd[:3]) * 0.6 * length / fs
    seen = max(
        12 * white * np.sqrt(length / fs + 0.5),
        6 * wander,
        10 * np.median(case.sd[3:]) / np.sqrt(4 * fs) / G,
        12 * np.median(case.sd[3:]) * 0.6 / G,
    )
    size = max(seen * rng.uniform(1, 8), 3e-4)
    way = rng.uniform(0, 2 * np.pi)
    axis = np.array([np.cos(way), np.sin(way), rng.normal(0, 0.2)])
    turn = size * axis / np.linalg.norm(axis)
    done = np.clip((np.arange(n) - at) / length, 0, 1)
    smooth = 0.5 - 0.5 * np.cos(np.pi * done)
    force = np.median(case.x[:, 3:], axis=0)
    case.x[:, :3] += np.gradient(smooth)[:, None] * fs * turn
    size = np.linalg.norm(turn)
    around = turn / size
    angle = -size * smooth[:, None]
    along = around * (around @ force)
    side = np.cross(around, force)
    turned = along + (force - along) * np.cos(angle) + side * np.sin(angle)
    case.x[:, 3:] += turned - force
    case.truth = {
        "finding": "tilt",
        "events": [{"row": at, "time": at / fs, "duration": length / fs}],
        "angle": float(np.linalg.norm(turn[:2])),
    }


def _restart(case, rng):
    """New turn-on biases of all channels."""
    n, fs = len(case.x), case.rate
    at = int(rng.uniform(0.2, 0.8) * n)
    jump = case.sd * rng.choice([-1, 1], 6) * rng.uniform(3, 12, 6)
    jump[3:] *= rng.uniform(0.2, 1.0, 3)
    case.x[at:] += jump
    case.truth = {"finding": "restart", "events": [{"row": at, "time": at / fs, "duration": 0.0}]}


def _hole(case, rng, *, turned=False):
    n, fs = len(case.x), case.rate
    at = int(rng.uniform(0.2, 0.8) * n)
    lost = int(max(rng.uniform(2, 300) * fs, 40))
    case.time = np.arange(n) / fs
    case.time[at:] += lost / fs
    start = case.time[at - 1]
    if turned:
        force = np.median(case.x[:at, 3:], axis=0)
        angle = 10 ** rng.uniform(-1, 0.2)
        axis = np.cross(force, rng.standard_normal(3))
        axis /= np.linalg.norm(axis)
        new = force * np.cos(angle) + np.cross(axis, force) * np.sin(angle)
        case.x[at:, 3:] += new - force
        case.truth = {"finding": "tilt", "angle": angle}
    else:
        case.truth = {"finding": "gap"}
    case.truth["events"] = [{"row": at, "time": start, "duration": lost / fs}]


def _turned_in_hole(case, rng):
    _hole(case, rng, turned=True)


def _rate(case, rng):
    """Stamps of a sensor whose clock is off, a little jitter on them."""
    n = len(case.x)
    nominal = float(rng.choice([50.0, 100.0, 200.0, 400.0]))
    true = nominal * (1 + rng.choice([-1, 1]) * rng.uniform(0.004, 0.02))
    case.rate = true
    case.time = np.sort(np.arange(n) / true + rng.normal(0, 0.01 / true, n))
    case.truth = {"finding": "rate", "rate": true}


def _burst(case, rng):
    n = len(case.x)
    size, fast = int(rng.integers(2, 9)), float(rng.choice([200.0, 400.0, 960.0, 1000.0]))
    period = size / fast * rng.uniform(2.5, 8)
    k = np.arange(n)
    case.time = (k // size) * period + (k % size) / fast + rng.normal(0, 0.03 / fast, n)
    case.time = np.sort(case.time)
    case.rate = fast
    case.truth = {"finding": "burst", "rate": fast, "size": size}


def _time_grid(case, rng):
    n = len(case.x)
    fs = float(rng.choice([80.0, 119.0, 128.0, 208.0, 238.0, 333.0]))
    grain = float(rng.choice([1e-3, 2e-3]))
    case.rate = fs
    case.time = np.floor(np.arange(n) / fs / grain + 0.3) * grain
    keep = np.r_[True, np.diff(case.time) > 0]
    case.time, case.x = case.time[keep], case.x[keep]
    case.truth = {"finding": "time_grid", "step": grain}
