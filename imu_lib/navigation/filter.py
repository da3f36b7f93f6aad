"""The loosely coupled error-state filter: a drive and an error model in, a solution with its
covariance out.

Nine navigation errors in north-east-down and the sensor states of the model, closed loop: every
correction goes into the
navigation solution and into the sensor states at once (Groves 2013, section 14.1; the 2013 paper,
section 3 and Fig. 3).
"""

from copy import copy
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.stats import chi2

from imu_lib.drive import Drive
from imu_lib.errors import InputError
from imu_lib.model import Model

from . import attitude, kernel
from .alignment import Alignment, align
from .earth import horizontal
from .preparation import Gnss, prepare
from .states import SensorStates, sensor_states


@dataclass(frozen=True)
class FilterModel:
    """An error model as a filter takes it.

    model : Model; levels, causal : wavelet de-noising before the mechanization (see
    `preparation.prepare`)
    turn_on_sd : bias left at switch-on, gyro rad/s and accelerometer m/s^2, put to the slowest
    state of each channel
    scale_sd : standard deviation of scale factor states (0: none); flicker : see
    `states.sensor_states`
    constraint_sd : m/s of velocity across the vehicle's axis; 0 leaves the vehicle constraint off
    (it is knowledge about the car, not about the sensor)
    """

    name: str
    model: Model
    levels: object = None
    causal: object = False
    turn_on_sd: tuple = (0.0, 0.0)
    scale_sd: tuple = (0.0, 0.0)
    flicker: str = "refuse"
    constraint_sd: float = 0.0

    def with_(self, **changes):
        return replace(self, **changes)


@dataclass(frozen=True)
class Moments:
    """What the filter knew at some epochs of one stretch: enough to run on from each.

    stretch : index; epoch (k,); time (k,) s; nav (k, 16), x (k, m), p (k, 9+m, 9+m), road (k, 4)
    as in `kernel`;
    prior, phi, dx : for the smoother, else empty
    """

    stretch: int
    epoch: np.ndarray
    time: np.ndarray
    nav: np.ndarray
    x: np.ndarray
    p: np.ndarray
    road: np.ndarray
    prior: np.ndarray
    phi: np.ndarray
    dx: np.ndarray


@dataclass(frozen=True)
class Solution:
    """A navigation solution: epochs of all stretches one after the other.

    time (n,) s; position (n, 3); velocity (n, 3); attitude (n, 3); sd (n, 9) m, m/s, rad;
    north_east (n,) covariance of position, m^2;
    fix_time (f,); innovation (f, 6) normalised, NaN where not used; nis (f,), freedom (f,), bits
    (f,) of `kernel`;
    moments : tuple of Moments; alignments : tuple of Alignment; states : number of filter states;
    names of the sensor states
    """

    name: str
    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    attitude: np.ndarray
    sd: np.ndarray
    north_east: np.ndarray
    fix_time: np.ndarray
    innovation: np.ndarray
    nis: np.ndarray
    freedom: np.ndarray
    bits: np.ndarray
    moments: tuple
    alignments: tuple
    states: int
    names: tuple
    notes: tuple = field(default=())

    def at(self, time):
        """Position (k, 3) at times within the solution, by straight lines between epochs."""
        return np.column_stack([np.interp(time, self.time, column) for column in self.position.T])

    def sensor_error(self, channel_first):
        """Estimated error of each channel at the stored moments: (time (k,), error (k, 6))."""
        first, output = channel_first
        time = np.concatenate([m.time for m in self.moments])
        x = np.vstack([m.x for m in self.moments])
        return time, np.column_stack(
            [x[:, first[c] : first[c + 1]] @ output[first[c] : first[c + 1]] for c in range(6)]
        )


class LooselyCoupled:
    """A drive and a filter model, made ready once; `solve` runs the whole drive, `coast` runs on
    from a moment without fixes.
    """

    def __init__(
        self,
        drive: Drive,
        model,
        *,
        gnss: Gnss | None = None,
        heading=None,
        start: Alignment | None = None,
        remove_bias=True,
        sampling="average",
    ):
        """model : FilterModel or Model; heading : rad at the start, where known; start : the whole
        alignment, where known (its epoch counts in the first
        stretch); remove_bias : take the gyros' mean at standstill off the readings."""
        gnss = gnss or Gnss()
        if isinstance(model, Model):
            model = FilterModel(model.name or "model", model)
        self.drive, self.model, self.gnss, self.heading, self.start = (
            drive,
            model,
            gnss,
            heading,
            start,
        )
        self.prepared = prepare(
            drive, levels=model.levels, causal=model.causal, gnss=gnss, sampling=sampling
        )
        self.sensors: SensorStates = sensor_states(
            model.model,
            self.prepared.rate,
            turn_on_sd=model.turn_on_sd,
            scale_sd=model.scale_sd,
            flicker=model.flicker,
        )
        self.remove_bias = remove_bias
        self.lever = np.zeros(3) if drive.lever_arm is None else np.asarray(drive.lever_arm, float)
        self.gates = np.full(2, chi2.ppf(gnss.gate, 3))
        interval = float(np.median(np.diff(self.prepared.fixes.time)))
        self.patience = max(int(gnss.patience / interval), 3)
        every = max(int(round(0.1 * self.prepared.rate)), 1)
        self.constraint = np.array([model.constraint_sd, every, 3.0, max(30.0 / interval, 10.0)])

    def with_model(self, model: FilterModel):
        """The same drive, made ready, with another model; its de-noising must be the same."""
        if (model.levels, model.causal) != (self.model.levels, self.model.causal):
            raise ValueError("`model` asks for another de-noising: make a new LooselyCoupled")
        other = copy(self)
        other.model = model
        other.sensors = sensor_states(
            model.model,
            self.prepared.rate,
            turn_on_sd=model.turn_on_sd,
            scale_sd=model.scale_sd,
            flicker=model.flicker,
        )
        other.constraint = np.array([model.constraint_sd, *self.constraint[1:]])
        return other

    @property
    def states(self):
        """Number of filter states."""
        return 9 + self.sensors.count

    def solve(self, *, withhold=(), moments=None, smooth=False) -> Solution:
        """Run the drive.

        withhold : windows (start s, duration s) without fixes
        moments : times (s) to keep what the filter knows at; None keeps one a second
        smooth : keep what the smoother needs, at every fix and every second
        """
        pieces, alignments, kept, logs, notes = [], [], [], [], list(self.prepared.notes)
        fixes, use = self.prepared.fixes, self.prepared.fixes.use.copy()
        for start, duration in withhold:
            use[(fixes.time > start) & (fixes.time <= start + duration)] = 0
        x, p_sensor, last = np.zeros(self.sensors.count), self.sensors.initial.copy(), None
        offset = np.zeros(3)
        for number, stretch in enumerate(self.prepared.stretches):
            try:
                if last is None and self.start is not None:
                    start = self.start
                else:
                    start = align(
                        stretch,
                        fixes,
                        heading=self.heading
                        if last is None
                        else self._parked(stretch, pieces[-1], fixes),
                    )
            except InputError as error:
                if last is None and number + 1 == len(self.prepared.stretches):
                    raise
                notes.append(
                    f"Stretch from {stretch.time[0]:.1f} to {stretch.time[-1]:.1f} s left out: {error}."
                )
                continue
            if last is not None:
                x, p_sensor = self._across(x, p_sensor, stretch.time[start.epoch] - last)
            elif self.remove_bias and start.standstill >= 2.0:
                offset = start.gyro_offset
                notes.append(
                    f"Gyro means of {start.standstill:.1f} s of standstill taken off the readings."
                )
            nav = np.zeros(16)
            nav[:3], nav[3:6], nav[6:10] = (
                start.position,
                start.velocity,
                attitude.quaternion(start.attitude),
            )
            p = np.zeros((self.states, self.states))
            p[np.arange(9), np.arange(9)] = start.sd**2
            p[9:, 9:] = p_sensor
            road = np.zeros(4)
            piece, moment = self._run(
                number,
                start.epoch,
                stretch.time.size - 1,
                nav,
                x,
                p,
                road,
                fixes,
                np.where(fixes.time <= start.used, 0, use),
                self._node_epochs(stretch, start.epoch, moments, smooth, use),
                smooth,
                offset,
            )
            pieces.append((stretch.time[start.epoch + 1 :],) + piece[:2])
            logs.append(piece[2])
            kept.append(moment)
            alignments.append(start)
            x, p_sensor, last = x, p[9:, 9:].copy(), stretch.time[-1]
        self.offset = offset
        return self._collect(pieces, logs, kept, alignments, notes)

    def coast(self, moment: Moments, index, duration):
        """Run on from one stored moment without fixes, as in an outage.

        returns : time (k,), position (k, 3), sd (k, 9), north_east (k,); fewer epochs where the
        stretch ends
        """
        stretch = self.prepared.stretches[moment.stretch]
        begin = int(moment.epoch[index])
        end = (
            int(np.searchsorted(stretch.time, moment.time[index] + duration + 1e-9, side="right"))
            - 1
        )
        nav, x, p, road = (
            moment.nav[index].copy(),
            moment.x[index].copy(),
            moment.p[index].copy(),
            moment.road[index].copy(),
        )
        none = np.zeros(0, np.int64)
        (log, sd, _), _ = self._run(
            moment.stretch, begin, end, nav, x, p, road, None, None, none, False, self.offset
        )
        return stretch.time[begin + 1 : end + 1], log[:, :3], sd[:, :9], sd[:, 9]

    # -- inside
    # ------------------------------------------------------------------------------------------------
    def _node_epochs(self, stretch, begin, moments, smooth, use):
        times = (
            np.arange(np.ceil(stretch.time[begin]), stretch.time[-1], 1.0)
            if moments is None
            else np.asarray(moments, float)
        )
        times = times[(times >= stretch.time[begin]) & (times <= stretch.time[-1])]
        epochs = np.searchsorted(stretch.time, times - 1e-9)
        if smooth:
            epochs = np.concatenate(
                [
                    epochs,
                    np.searchsorted(stretch.time, self.prepared.fixes.time[use > 0] - 1e-9),
                    [stretch.time.size - 1],
                ]
            )
        epochs = np.unique(epochs)
        return epochs[(epochs > begin) & (epochs < stretch.time.size)].astype(np.int64)

    def _run(self, number, begin, end, nav, x, p, road, fixes, use, nodes, smooth, offset):
        stretch, sensors = self.prepared.stretches[number], self.sensors
        n, m = self.states, sensors.count
        if fixes is None:
            epoch, delay, value, variance, use, count = (
                np.zeros(0, np.int64),
                np.zeros(0),
                np.zeros((0, 6)),
                np.zeros((0, 6)),
                np.zeros(0, np.int64),
                0,
            )
        else:
            epoch = np.searchsorted(stretch.time, fixes.time - 1e-9).astype(np.int64)
            inside = (epoch > begin) & (epoch <= end)
            epoch, value, variance, use = (
                epoch[inside],
                fixes.value[inside],
                fixes.variance[inside],
                use[inside],
            )
            delay, count = stretch.time[epoch] - fixes.time[inside], int(inside.sum())
        dtheta = (
            stretch.dtheta if not offset.any() else stretch.dtheta - offset * stretch.dt[:, None]
        )
        log, sd, fix_log = (
            np.empty((end - begin, 16)),
            np.empty((end - begin, 10)),
            np.zeros((count, 9)),
        )
        k, full = nodes.size, nodes.size if smooth else 0
        node_x, node_p, node_road = np.empty((k, m)), np.empty((k, n, n)), np.empty((k, 4))
        prior, phi, dx = np.empty((full, n, n)), np.empty((full, n, n)), np.empty((full, n))
        kernel.run(
            begin,
            end,
            nav,
            x,
            p,
            road,
            stretch.dt,
            dtheta,
            stretch.dvel,
            sensors.transition,
            sensors.noise,
            sensors.output,
            sensors.first,
            sensors.white,
            sensors.scale,
            stretch.extra_noise,
            epoch,
            delay,
            value,
            variance,
            use,
            self.lever,
            self.gates,
            self.patience,
            self.constraint,
            log,
            sd,
            fix_log,
            nodes,
            node_x,
            node_p,
            prior,
            phi,
            dx,
            node_road,
            smooth,
        )
        if not np.isfinite(log[-1]).all() or not np.isfinite(sd[-1]).all():
            raise InputError(
                f"the filter {self.model.name} diverged before {stretch.time[end]:.1f} s: check the units of the drive "
                "and the error model (an unstable process grows without bound)"
            )
        moment = Moments(
            number,
            nodes,
            stretch.time[nodes],
            log[nodes - begin - 1],
            node_x,
            node_p,
            node_road,
            prior,
            phi,
            dx,
        )
        times = fixes.time[inside] if fixes is not None else np.zeros(0)
        return (log, sd, (times, fix_log, use)), moment

    def _parked(self, stretch, piece, fixes):
        """The heading before a hole in the data, where the car stood before it and stands at the
        same place after it; else None.
        """
        after = fixes.time >= stretch.time[0]
        velocity = fixes.value[after, 3:5][:1]
        stood = np.hypot(*piece[1][-1, 3:5]) < 0.5
        if (
            not after.any()
            or not stood
            or np.hypot(*velocity[0]) > 0.5
            or horizontal(fixes.value[after, :3][0], piece[1][-1, :3]) > 5.0
        ):
            return None
        return float(attitude.euler(piece[1][-1, 6:10])[2])

    def _across(self, x, p, gap):
        """Sensor states carried over a hole in the data, `gap` s."""
        steps = max(int(round(gap * self.prepared.rate)), 0)
        s, q = self.sensors.transition, self.sensors.noise
        power, total = s.copy(), q.copy()
        out_s, out_q = np.eye(s.shape[0]), np.zeros_like(q)
        while steps:  # doubling: the noise of 2k steps is that of k, carried on, and that of k
            if steps & 1:
                out_q = power @ out_q @ power.T + total
                out_s = power @ out_s
            total = power @ total @ power.T + total
            power = power @ power
            steps >>= 1
        return out_s @ x, out_s @ p @ out_s.T + out_q

    def _collect(self, pieces, logs, kept, alignments: list[Alignment], notes):
        time = np.concatenate([p[0] for p in pieces])
        nav, sd = np.vstack([p[1] for p in pieces]), np.vstack([p[2] for p in pieces])
        fix_time = np.concatenate([each[0] for each in logs])
        fix_log = np.vstack([each[1] for each in logs])
        bits = fix_log[:, 8].astype(int)
        offered = np.concatenate([each[2] for each in logs])
        for flag, what in (
            (kernel.REJECTED_POSITION, "positions"),
            (kernel.REJECTED_VELOCITY, "velocities"),
        ):
            if (bits & flag).any():
                notes.append(
                    f"{int(((bits & flag) > 0).sum())} of {int((offered > 0).sum())} fixes had their {what} rejected by the innovation test."
                )
        if (bits & kernel.RECOVERED).any():
            notes.append(
                f"The covariance was widened {int(((bits & kernel.RECOVERED) > 0).sum())} times because the fixes kept disagreeing with the filter, "
                f"first at {fix_time[np.argmax((bits & kernel.RECOVERED) > 0)]:.1f} s."
            )
        return Solution(
            self.model.name,
            time,
            nav[:, :3],
            nav[:, 3:6],
            attitude.euler(nav[:, 6:10]),
            sd[:, :9],
            sd[:, 9],
            fix_time,
            fix_log[:, :6],
            fix_log[:, 6],
            fix_log[:, 7].astype(int),
            bits,
            tuple(kept),
            tuple(alignments),
            self.states,
            self.sensors.names,
            tuple(notes),
        )


def run(drive: Drive, model, *, withhold=(), smooth=False, **options) -> Solution:
    """The solution of a drive with one error model: `LooselyCoupled(drive, model,
    **options).solve(...)`.
    """
    return LooselyCoupled(drive, model, **options).solve(withhold=withhold, smooth=smooth)
