"""How far may position fixes be apart? The 2008 paper's study (Section 6, Table 4, Figs. 14 to
19), with truth known.

Ten drives of ten minutes on a parking lot at 10 to 30 km/h with six turns, logged at 20 Hz; a fix
every 1, 5, 10, 20, 30 or 60 s; the stochastic part of the accelerometers modelled by a first-order
Gauss-Markov process or by AR(4), both fitted to the same static records.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats
from statsmodels.regression.linear_model import burg

from ..estimate import Estimate
from ..model import Model
from ..processes import Autoregressive, Constant, GaussMarkov, Sum, WhiteNoise
from ..units import DEG, MILLI_G, G
from . import planar, planar_loop

INTERVALS = (1, 5, 10, 20, 30, 60)
KMH = 1 / 3.6


@dataclass(frozen=True)
class PlanarDrive:
    """True motion in the plane: `position` (n, 2) m and `state` (n, 5) after each step, `start`
    (5,), `inputs` (n, 3) true forward and right specific force and yaw rate (means over the step),
    `fs` Hz."""

    position: np.ndarray
    state: np.ndarray
    start: np.ndarray
    inputs: np.ndarray
    fs: float

    @property
    def time(self) -> np.ndarray:
        """Time at the end of each step, s."""
        return (np.arange(len(self.inputs)) + 1) / self.fs

    @property
    def speed(self) -> np.ndarray:
        """m/s after each step."""
        return np.hypot(self.state[:, 2], self.state[:, 3])


def parking_lot(fs: float = 20.0, duration: float = 600.0) -> PlanarDrive:
    """Ten minutes at 10 to 30 km/h with six turns of a right angle, slow in the corners (2008
    paper, Section 6).
    """
    t = (np.arange(round(duration * fs)) + 0.5) / fs
    centres = duration * (np.arange(6) + 0.6) / 6.2
    turning = np.zeros_like(t)
    slow = np.zeros_like(t)
    for at, direction in zip(centres, (1, 1, -1, 1, 1, 1), strict=True):
        bump = np.where(
            np.abs(t - at) < 4.0, 1 + np.cos(np.pi * (t - at) / 4.0), 0.0
        )  # eight seconds of turning
        turning += direction * np.pi / 2 * bump / 8.0
        slow = np.maximum(slow, np.exp(-0.5 * ((t - at) / 7.0) ** 2))
    straight = 22 + 8 * np.sin(2 * np.pi * t / 97.0)
    speed = KMH * (straight + (10 - straight) * slow) * (1 - np.exp(-t / 3.0))
    edges = np.concatenate([[0.0], (speed[1:] + speed[:-1]) / 2, speed[-1:]])
    inputs = np.column_stack([np.diff(edges) * fs, speed * turning, turning])
    state, start = np.empty((len(t), 5)), np.array([0.0, 0.0, 0.0, 0.0, 20 * DEG])
    now = start.copy()
    for k, (u, v, w) in enumerate(inputs):  # by the filter's own steps: the truth is exact
        planar_loop.mechanize(now, u, v, w, 1 / fs)
        state[k] = now
    return PlanarDrive(state[:, :2].copy(), state, start, inputs, fs)


@dataclass(frozen=True)
class Fitted:
    """Models of the static noise, as the planar filter takes them: `gm` and `ar` map channel to
    process.
    """

    gm: dict
    ar: dict


def fit_static(
    model: Model,
    rng: np.random.Generator,
    *,
    hours: float = 8.0,
    records: int = 10,
    order: int = 4,
    fs: float = 20.0,
) -> Fitted:
    """AR(`order`) by Burg and GM(1) on simulated static records of `hours` h, coefficients
    averaged over the records.

    Both see the same detrended total output, white noise included, as in the 2008 paper (Section
    5). GM(1) takes the variance and the correlation at one sample; the yaw gyroscope is white.
    """
    t = np.linspace(-1, 1, round(hours * 3600 * fs))
    found = {"accel_x": [], "accel_y": []}
    yaw = []
    for _ in range(records):
        drawn = model.simulate(len(t), fs, rng, channels=("accel_x", "accel_y", "gyro_z"))
        for channel, rows in found.items():
            x = drawn[channel] - np.polynomial.Polynomial.fit(t, drawn[channel], 1)(t)
            phi, variance = burg(x, order)
            rows.append([*phi, np.sqrt(variance), x.std(), x[1:] @ x[:-1] / (x @ x)])
        yaw.append(drawn["gyro_z"].std())
    white = WhiteNoise(float(np.mean(yaw) / np.sqrt(fs)))
    mean = {channel: np.mean(rows, axis=0) for channel, rows in found.items()}
    ar = {c: Autoregressive(tuple(m[:order]), float(m[order]), fs) for c, m in mean.items()}
    gm = {c: GaussMarkov(float(m[-2]), float(-1 / (fs * np.log(m[-1])))) for c, m in mean.items()}
    return Fitted({**gm, "gyro_z": white}, {**ar, "gyro_z": white})


@dataclass(frozen=True)
class Errors:
    """Errors of repeated drives with one interval and model: `north`, `east` (r,) RMS per run, m;
    `track` (n, 2) of the first run; `nees` mean over all."""

    north: np.ndarray
    east: np.ndarray
    track: np.ndarray
    nees: float

    @property
    def horizontal(self) -> np.ndarray:
        """RMS of the horizontal error of each run, m."""
        return np.hypot(self.north, self.east)

    @property
    def pooled(self) -> tuple[float, float, float]:
        """RMS over all runs: north, east, horizontal, m (what Table 4 prints)."""
        n, e = (float(np.sqrt(np.mean(x**2))) for x in (self.north, self.east))
        return n, e, float(np.hypot(n, e))


@dataclass(frozen=True)
class Scenario:
    """What acts besides the sensors' noise. Standard deviations; each Gauss-Markov in time.

    `tilt` rad: roll and pitch that the planar filter does not know (slope, suspension), with
    `tilt_time` s; `gnss` m north and east, with `gnss_time` s, plus `gnss_white` m; `heading` rad
    at the start; `static` s of rest that the zero-offsets are taken from.
    """

    tilt: float = 0.0
    tilt_time: float = 20.0
    gnss: tuple[float, float] = (2.3, 4.6)
    gnss_time: float = 60.0
    gnss_white: float = 0.5
    heading: float = 1.1 * DEG
    static: float = 300.0

    @property
    def gnss_sd(self) -> tuple[float, float]:
        """What the filter is told, as the paper does: the RMS error of the receiver."""
        return tuple(float(np.hypot(s, self.gnss_white)) for s in self.gnss)


@dataclass(frozen=True)
class Runs:
    """Simulated drives: `readings` (r, n, 3), fixes at every step (r, n, 2) and `start` (r, 5)."""

    readings: np.ndarray
    fixes: np.ndarray
    start: np.ndarray


def simulate(
    drive: PlanarDrive,
    model: Model,
    rng: np.random.Generator,
    *,
    runs: int = 10,
    scenario: Scenario | None = None,
) -> Runs:
    """Sensor readings and position fixes of `runs` drives over the same route."""
    scenario, (n, fs) = scenario or Scenario(), (len(drive.inputs), drive.fs)
    still = round(scenario.static * fs)
    readings, fixes, start = (
        np.empty((runs, n, 3)),
        np.empty((runs, n, 2)),
        np.tile(drive.start, (runs, 1)),
    )
    for k in range(runs):
        noise = model.simulate(n + still, fs, rng, channels=planar.SENSORS)
        for i, channel in enumerate(planar.SENSORS):
            readings[k, :, i] = (
                drive.inputs[:, i] + noise[channel][still:] - noise[channel][:still].mean()
            )
        if scenario.tilt:
            for i in range(2):
                slope = GaussMarkov(scenario.tilt, scenario.tilt_time).simulate(n, fs, rng)
                readings[k, :, i] += G * np.sin(slope - slope[0])
        for i in range(2):
            wander = GaussMarkov(scenario.gnss[i], scenario.gnss_time).simulate(n, fs, rng)
            fixes[k, :, i] = drive.position[:, i] + wander + rng.normal(0, scenario.gnss_white, n)
        start[k, 4] += rng.normal(0, scenario.heading)
    return Runs(readings, fixes, start)


def errors(
    drive: PlanarDrive,
    runs: Runs,
    models: dict,
    interval: float,
    *,
    scenario: Scenario | None = None,
    white_state: bool = False,
    order: int = 2,
) -> Errors:
    """RMS errors of the drives with a fix every `interval` s and the sensor models `models`."""
    scenario, every = scenario or Scenario(), round(interval * drive.fs)
    found = planar.run(
        runs.readings,
        runs.fixes[:, every - 1 :: every],
        planar.sensors(models, 1 / drive.fs, white_state=white_state),
        every=every,
        start=runs.start,
        start_sd=np.array([0.1, 0.1, 0.05, 0.05, scenario.heading]),
        gnss_sd=scenario.gnss_sd,
        order=order,
        truth=drive.position,
    )
    miss = found.position - drive.position
    rms = np.sqrt((miss**2).mean(axis=1))
    return Errors(rms[:, 0], rms[:, 1], miss[0], float(np.nanmean(found.nees)))


def study(
    drive: PlanarDrive,
    runs: Runs,
    models: dict[str, dict],
    *,
    intervals=INTERVALS,
    scenario: Scenario | None = None,
) -> dict[int, dict[str, Errors]]:
    """`errors` for every interval and model: interval -> model name -> Errors."""
    return {
        t: {name: errors(drive, runs, m, t, scenario=scenario) for name, m in models.items()}
        for t in intervals
    }


def paired(a: np.ndarray, b: np.ndarray) -> Estimate:
    """Ratio of the errors (r,) of `a` to those of `b` on the same runs (geometric mean), with its
    95 % t interval.
    """
    d = np.log(a) - np.log(b)
    half = stats.t.ppf(0.975, len(d) - 1) * d.std(ddof=1) / np.sqrt(len(d))
    return Estimate(*(float(np.exp(x)) for x in (d.mean(), d.mean() - half, d.mean() + half)))


def random_constants(white: dict, accel: float = MILLI_G, gyro: float = 0.04 * DEG) -> dict:
    """The sensors of the paper's 8-state filter (Eq. 15): a random constant each, and white noise
    (`white`: N).

    Sizes: the run-to-run standard deviations of its Tables 2 and 3.
    """
    sizes = {"accel_x": accel, "accel_y": accel, "gyro_z": gyro}
    return {c: Constant(size) + WhiteNoise(white[c]) for c, size in sizes.items()}


def with_slow_state(models: dict, sigma: float, correlation_time: float) -> dict:
    """The same sensor models with a slow Gauss-Markov state on both accelerometers (what Eq. 16
    lacks).
    """
    return {
        c: (m + GaussMarkov(sigma, correlation_time) if c.startswith("accel") else Sum((m,)))
        for c, m in models.items()
    }
