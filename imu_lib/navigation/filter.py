"""The loosely coupled error-state filter: a drive and an error model in, a solution with its
covariance out.

Nine navigation errors in north-east-down, the sensor states of the model and what of the drive is
estimated along, closed loop: every correction goes into the navigation solution and into the other
states at once (Groves 2013, section 14.1; the 2013 paper, section 3 and Fig. 3).
"""

from __future__ import annotations

from copy import copy
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from imu_lib.drive import Drive
from imu_lib.errors import InputError
from imu_lib.model import Model

from . import attitude, kernel
from .alignment import Alignment, align
from .beginning import initial_state
from .filter_model import FilterModel
from .innovations import Innovations
from .preparation import Gnss, prepare
from .solution import Moments, Solution
from .states import SensorStates, sensor_states
from .structures import Given, Imu, Logs, Measurements, Nodes, State, Written
from .tables import across, fix_table, parked, speed_table

__all__ = ["FilterModel", "LooselyCoupled", "Moments", "Solution", "run"]


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
        coarse=0.0,
    ):
        """model : FilterModel, or Model (then without a bias at switch-on); heading : rad at the
        start, where known; start : the whole alignment, where known (its epoch counts in the first
        stretch); remove_bias : take the gyros' mean at standstill off the readings; coarse : s over
        which the covariance may go at once between fixes (the solution itself goes at the full
        rate; not with states that multiply readings, a constraint or wheel speed)
        """
        if isinstance(model, Model):
            model = FilterModel(model.name or "model", model)
        self.held = model.held
        self.gnss = gnss = self.held.gnss(gnss or Gnss())
        self.drive = drive = self.held.drive(drive)
        self.model, self.start = model, start
        self.heading = self.held.heading(drive, heading)
        self.prepared = prepare(
            drive,
            levels=self.held.levels(model.levels),
            causal=model.causal,
            gnss=gnss,
            sampling=sampling,
        )
        self.remove_bias = remove_bias
        interval = float(np.median(np.diff(np.unique(self.prepared.fixes.time))))
        self.patience = max(int(gnss.patience / interval), 3)
        every = max(int(round(0.1 * self.prepared.rate)), 1)
        self.constraint = np.array([0.0, every, 3.0, max(30.0 / interval, 10.0)])
        self.coarse = coarse
        self._take(model)

    def _take(self, model: FilterModel):
        """The sensor states and the measurements of a model."""
        self.model = model
        self.sensors: SensorStates = sensor_states(
            self.held.model(model.model),
            self.prepared.rate,
            turn_on_sd=model.turn_on_sd,
            constant=model.constant,
            scale_sd=model.scale_sd,
            flicker=model.flicker,
            free=model.free,
            vibration=self.held.vibration(),
            correlated=self.held.correlated,
        )
        self.arrays = self.sensors.arrays()
        plain = not model.constraint_sd and model.speed is None and (self.arrays.driver < 0).all()
        every = max(int(round(self.coarse * self.prepared.rate)), 1) if plain else 1
        self.several = self.sensors.over(every), every
        self.constraint = np.array([model.constraint_sd, *self.constraint[1:]])
        mounting, arm = self.held.mounting, self.drive.lever_arm
        self.turn = (
            None if mounting is None else np.ascontiguousarray(attitude.matrix(mounting))
        )  # the case's axes into the vehicle's
        gate = self.gnss.gate
        self.measurements = Measurements(
            np.zeros(3) if arm is None else np.array(arm, float),
            np.zeros(3) if mounting is None else mounting,
            mounting is not None or "mounting" in model.free,
            np.full(2, np.inf if gate is None else chi2.ppf(gate, 3)),
            self.patience,
            self.held.outliers,
            self.constraint,
            self.sensors.at,
        )

    def with_model(self, model: FilterModel):
        """The same drive, made ready, with another model; its de-noising and what is held of the
        drive must be the same.
        """
        if (model.levels, model.causal) != (self.model.levels, self.model.causal):
            raise ValueError("`model` asks for another de-noising: make a new LooselyCoupled")
        if model.held != self.held:
            raise ValueError("`model` holds something else of the drive: make a new LooselyCoupled")
        other = copy(self)
        other._take(model)
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
        pieces, alignments, notes = [], [], list(self.prepared.notes)
        fixes, use = self.prepared.fixes, self.prepared.fixes.use.copy()
        for begin, duration in withhold:
            use[(fixes.time > begin) & (fixes.time <= begin + duration)] = 0
        x, p_sensor, last = np.zeros(self.sensors.count), self.sensors.initial.copy(), None
        self.offset = np.zeros(3)
        for number, stretch in enumerate(self.prepared.stretches):
            try:
                start = self._aligned(stretch, pieces)
            except InputError as error:
                if last is None and number + 1 == len(self.prepared.stretches):
                    raise
                notes.append(
                    f"Stretch from {stretch.time[0]:.1f} to {stretch.time[-1]:.1f} s left out: "
                    f"{error}."
                )
                continue
            if last is not None:
                x, p_sensor = across(
                    self.sensors, self.prepared.rate, x, p_sensor, stretch.time[start.epoch] - last
                )
            elif self.remove_bias and start.standstill >= 2.0:
                self.offset = (
                    start.gyro_offset if self.turn is None else self.turn.T @ start.gyro_offset
                )
                notes.append(
                    f"Gyro means of {start.standstill:.1f} s of standstill taken off the readings."
                )
            # an alignment from fixes has the position of the antenna
            arm = np.zeros(3) if start is self.start else self.measurements.lever
            state = initial_state(start, arm, self.turn, x, p_sensor)
            nodes = self._node_epochs(stretch, start.epoch, moments, smooth, use)
            usable = replace(fixes, use=np.where(fixes.time <= start.used, 0, use))
            pieces.append(
                self._run(number, start.epoch, stretch.time.size - 1, state, usable, nodes, smooth)
            )
            alignments.append(start)
            x, p_sensor, last = state.x, state.p[9:, 9:].copy(), stretch.time[-1]
        return self._collect(pieces, alignments, notes, x, p_sensor)

    def coast(self, moment: Moments, index, duration):
        """Run on from one stored moment without fixes, as in an outage.

        returns : time (k,), position (k, 3), sd (k, 9), north_east (k,); fewer epochs where the
        stretch ends
        """
        stretch = self.prepared.stretches[moment.stretch]
        begin = int(moment.epoch[index])
        stop = moment.time[index] + duration + 1e-9
        end = int(np.searchsorted(stretch.time, stop, side="right")) - 1
        state = State(*(getattr(moment, k)[index].copy() for k in ("nav", "x", "p", "road")))
        none = np.zeros(0, np.int64)
        time, logs, _, _ = self._run(moment.stretch, begin, end, state, None, none, False)
        return time, logs.nav[:, :3], logs.sd[:, :9], logs.sd[:, 9]

    # -- inside ----------------------------------------------------------------------------------
    def _aligned(self, stretch, pieces):
        if not pieces and self.start is not None:
            return self.start
        fixes = self.prepared.fixes
        heading = (
            parked(stretch, fixes, pieces[-1][1].nav[-1], self._angles) if pieces else self.heading
        )
        if self.turn is not None:
            stretch = replace(
                stretch, dtheta=stretch.dtheta @ self.turn.T, dvel=stretch.dvel @ self.turn.T
            )
        return align(stretch, fixes, heading=heading)

    def _node_epochs(self, stretch, begin, moments, smooth, use):
        times = (
            np.arange(np.ceil(stretch.time[begin]), stretch.time[-1], 1.0)
            if moments is None
            else np.asarray(moments, float)
        )
        times = times[(times >= stretch.time[begin]) & (times <= stretch.time[-1])]
        epochs = np.searchsorted(stretch.time, times - 1e-9)
        if smooth:
            of_fixes = np.searchsorted(stretch.time, self.prepared.fixes.time[use > 0] - 1e-9)
            epochs = np.concatenate([epochs, of_fixes, [stretch.time.size - 1]])
        epochs = np.unique(epochs)
        return epochs[(epochs > begin) & (epochs < stretch.time.size)].astype(np.int64)

    def _run(self, number, begin, end, state, fixes, nodes, smooth):
        """(time, logs, Innovations, Moments) of one run of the kernel."""
        stretch = self.prepared.stretches[number]
        dtheta = stretch.dtheta
        if self.offset.any():
            dtheta = dtheta - self.offset * stretch.dt[:, None]
        table, rows = fix_table(stretch, begin, end, fixes, self.drive.time[0])
        logs = Logs.empty(end - begin, rows.size)
        nodes = Nodes.empty(nodes, self.states, smooth)
        given = Given(
            Imu(stretch.dt, dtheta, stretch.dvel, stretch.extra_noise),
            table,
            speed_table(stretch, begin, end, self.model.speed),
        )
        written = Written(logs, nodes)
        several = (self.arrays, 1) if smooth else self.several
        kernel.run(
            (begin, end), state, self.arrays, self.measurements, given, written, smooth, several
        )
        if not np.isfinite(logs.nav[-1:]).all() or not np.isfinite(logs.sd[-1:]).all():
            raise InputError(
                f"the filter {self.model.name} diverged before {stretch.time[end]:.1f} s: check "
                "the units of the drive and the error model (an unstable process grows without "
                "bound)"
            )
        innovations = None
        if fixes is not None:
            innovations = Innovations.of(fixes.index[rows], fixes.time[rows], table.use, logs)
        time, at = stretch.time, nodes.epoch
        moments = Moments(
            number, at, time[at], logs.nav[at - begin - 1], *(getattr(nodes, k) for k in _KEPT)
        )
        return time[begin + 1 : end + 1], logs, innovations, moments

    def _angles(self, q):
        """Roll, pitch, yaw (k, 3) of the vehicle, of quaternions (k, 4) of the case."""
        if self.turn is None:
            return attitude.euler(q)
        turned = Rotation.from_quat(q, scalar_first=True) * Rotation.from_matrix(self.turn.T)
        return attitude.euler(turned.as_quat(scalar_first=True))

    def _collect(self, pieces, alignments: list[Alignment], notes, x, p):
        nav = np.vstack([piece[1].nav for piece in pieces])
        sd = np.vstack([piece[1].sd for piece in pieces])
        innovations = Innovations.join([piece[2] for piece in pieces])
        return Solution(
            self.model.name,
            np.concatenate([piece[0] for piece in pieces]),
            nav[:, :3],
            nav[:, 3:6],
            self._angles(nav[:, 6:10]),
            sd[:, :9],
            sd[:, 9],
            innovations,
            tuple(piece[3] for piece in pieces),
            tuple(alignments),
            self.states,
            self.sensors.names,
            x,
            p,
            self.sensors.initial,
            tuple(notes + innovations.notes()),
        )


_KEPT = ("x", "p", "road", "prior", "phi", "dx")


def run(drive: Drive, model, *, withhold=(), smooth=False, **options) -> Solution:
    """The solution of a drive with one error model: `LooselyCoupled(drive, model,
    **options).solve(...)`.
    """
    return LooselyCoupled(drive, model, **options).solve(withhold=withhold, smooth=smooth)
