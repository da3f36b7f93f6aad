"""What stands for something else on a drive: another time, another kind, another axis."""

from types import SimpleNamespace

import drive_generator as generator
import numpy as np
import pytest

from imu_lib.drive import from_arrays
from imu_lib.gap.drive import (
    columns,
    displaced,
    left,
    levels,
    posterior,
    prune,
    random_effects,
    regression,
    select,
    start,
    step_time,
    steps,
    vehicle,
    worth,
)
from imu_lib.gap.drive.problem import Noise
from imu_lib.gap.drive.state import Change, State
from imu_lib.model import Model
from imu_lib.navigation import earth

MODEL = Model.from_json(generator.MODEL)


def test_a_step_of_a_bias_is_looked_for_at_its_own_time():
    arrays = generator.make(43001, duration=240.0)
    arrays["gyro"][arrays["time"] > 150.0, 2] += 0.006
    state = State(from_arrays(arrays, "x"), Noise(MODEL), np.zeros(len(columns.ALL)))
    state.rebuild()
    step_time.look(state, lambda text: None)
    assert state.step_at == pytest.approx(150.0, abs=5.0)
    kept, _ = select.best(state.reg, list(columns.GROUPS), 1)
    assert kept == (columns.STEP,)


@pytest.mark.parametrize("stays", [True, False])
def test_fixes_that_are_displaced_and_stay_so_are_no_wild_ones(stays):
    arrays = generator.make(43002, duration=130.0, rate=50.0, gnss_rate=1.0)
    time, shift = arrays["gnss_time"], np.array([-8.0, 6.0, 5.0])
    after = time > 87.0 if stays else np.abs(time - 87.0) < 0.4
    arrays["gnss_position"][after] = earth.shift(arrays["gnss_position"][after], shift)
    state = State(from_arrays(arrays, "x"), Noise(MODEL), np.zeros(len(columns.ALL)))
    state.rebuild()
    assert displaced.look(state, lambda text: None) == stays
    if stays:
        assert state.moved_at == pytest.approx(87.0, abs=1.0)
        kept, _ = select.best(state.reg, list(columns.GROUPS), 1)
        assert kept == (columns.MOVED,)
        assert state.reg.solve(columns.of(columns.MOVED))[0] == pytest.approx(shift, abs=2.0)


@pytest.mark.parametrize("one_side", [True, False])
def test_wild_fixes_that_follow_one_another_on_one_side_are_said(one_side):
    rng = np.random.default_rng(7)
    e, wild = rng.standard_normal((400, 6)), rng.random(400) < 0.03
    if one_side:
        wild[:] = False
        wild[200:212] = True
        e[wild, :3] += [-8.0, 6.0, 5.0]
    state = SimpleNamespace(
        noise=Noise(MODEL, fraction=0.03, scale=4.0), use=np.ones((400, 6), bool),
        result=SimpleNamespace(e=e, wild=wild), problem=SimpleNamespace(time=np.arange(400.0)),
    )  # fmt: skip
    said = displaced.in_a_row(state)
    assert bool(said) == one_side
    assert not one_side or "follow one another on one side (11 times" in said[0]


@pytest.mark.parametrize(("sd", "late"), [(0.6, 0.4), (0.05, None)])
def test_late_velocities_are_smoothed_ones_where_the_drive_does_not_tell(sd, late):
    size = 2 + len(columns.SMOOTHED)
    cov = np.diag([1e-3, 1e-3, *[sd] * len(columns.SMOOTHED)]) ** 2
    x = np.array([1e-3, 0.4, *np.zeros(len(columns.SMOOTHED))])
    reg = SimpleNamespace(solve=lambda index: (x[: len(index)], cov, 0.0))
    state = SimpleNamespace(kept=("gnss_time_offset",), use=np.ones((9, 6), bool), reg=reg)
    assert size == len([*left._index(state), *columns.GROUPS[left.SMOOTHED]])
    assert left.late_or_smoothed(state) == late


def test_a_heading_is_carried_back_without_what_the_temperature_did_to_the_gyro():
    time = np.arange(0.0, 300.0, 0.1)
    warmth = 20.0 + 15.0 * (1.0 - np.exp(-time / 200.0))
    drive = SimpleNamespace(time=time, gyro=np.zeros((time.size, 3)), temperature=warmth)
    path = {"time": time, "velocity": np.zeros((time.size, 3))}
    other = np.zeros(len(columns.ALL))
    other[columns.of("other: biases follow the temperature")[2]] = 2.5e-3  # rad/s per 10 degrees
    state = SimpleNamespace(
        problem=SimpleNamespace(drive=drive, path=path), other=other, stepped=150.0
    )
    drift = vehicle.drifting(state)
    end = warmth[time > 240.0 - 0.1].mean()
    assert drift[0, 2] == pytest.approx(2.5e-4 * (warmth[0] - end), rel=1e-3)
    assert not drift[:, :2].any()


def test_a_receiver_that_knows_its_errors_to_a_quarter_knows_them_well():
    stated = {f"gnss_{of}_sd": np.ones((5, 3)) for of in ("position", "velocity")}
    problem = SimpleNamespace(drive=SimpleNamespace(**stated))
    state = SimpleNamespace(problem=problem)
    change = SimpleNamespace(effect="gnss_noise", key=("gnss_noise", "position"))
    for ratio, usual in ((0.88, True), (1.2, True), (0.6, False), (1.6, False)):
        assert steps.usual(state, SimpleNamespace(change=change, values=[ratio])) == usual
        held = worth.ratios(Noise(MODEL, position=ratio), problem.drive)
        assert [e["ratio"] for e in held] == ([ratio] if usual else [])


def test_a_refit_that_makes_outages_worse_is_not_taken(monkeypatch):
    windows = [SimpleNamespace(start=200.0 + 10.0 * k, duration=20.0) for k in range(12)]
    grown = np.full(12, 1.1) * np.exp(0.1 * np.cos(np.arange(12)))
    monkeypatch.setattr(worth.outages, "regular_windows", lambda *a, **k: windows)
    monkeypatch.setattr(worth, "held", lambda state: state.name)
    monkeypatch.setattr(worth.FilterModel, "of", lambda model: model)
    laid, factors = [], []

    def compare(drive, filters, free, **options):
        laid.extend(free)
        errors = {"before": np.ones(len(free)), "after": factors[-1] * grown[: len(free)]}
        return SimpleNamespace(errors=lambda name, against: errors[name])

    monkeypatch.setattr(worth.outages, "compare", compare)
    before, after = (
        SimpleNamespace(name=n, drive=SimpleNamespace(duration=600.0), withhold=((260.0, 20.0),))
        for n in ("before", "after")
    )
    for factor, taken in ((1.0, False), (0.9, True), (0.6, True)):
        factors.append(factor)
        assert worth.no_worse(before, after) == taken
    # none of them meets one that the report tells
    assert all(w.start + 20.0 <= 260.0 or w.start >= 280.0 for w in laid)


def test_what_its_path_no_longer_asks_for_leaves(monkeypatch):
    count = len(columns.ALL)
    information, score = np.zeros((count, count)), np.zeros(count)
    big, small = columns.GROUPS["lever_arm"], columns.GROUPS["gyro_scale"]
    information[[*big, *small], [*big, *small]] = 1e4
    score[big], score[small] = 5e3, 50.0
    reg = regression.Regression(information, score, 1.0, 1000)
    state = SimpleNamespace(kept=("lever_arm", "gyro_scale"), reg=reg)

    def held(state, kept, freely):
        state.kept = kept

    monkeypatch.setattr(prune, "held", held)
    prune.worthless(state, lambda text: None)
    assert state.kept == ("lever_arm",)


def test_halves_that_seem_late_apart_are_chance_where_the_innovations_are_right(monkeypatch):
    monkeypatch.setattr(left.lateness, "of_halves", lambda drive: (0.0, -0.7))
    monkeypatch.setattr(left.correct, "corrected", lambda *held: held[0])
    state = SimpleNamespace(drive=None, theta=None, moved_at=np.inf)
    for right, said in ((True, False), (False, True)):
        after = SimpleNamespace(right=right)
        assert (left.clocks(state, after) is not None) == said


def _of_one_parameter(top):
    """A state whose log-likelihood has its top there, and what is tried of it."""
    tried = []

    def evaluate(noise):
        tried.append(round(noise, 9))
        return SimpleNamespace(log_likelihood=-50.0 * np.log(noise / top) ** 2)

    state = SimpleNamespace(noise=1.0, evaluate=evaluate)
    change = random_effects.Change(
        "bias_model", ("bias_model",), (1.0,), lambda noise, v: float(v[0]), lambda v: {}
    )
    return state, change, tried


@pytest.mark.parametrize(
    "top, looked_at, best",
    [(5.0, [1.5, 6.0, 30.0], 6.0), (0.6, [1.5, 0.67], 0.67), (1.4, [1.5, 6.0], 1.5)],
)
def test_values_are_tried_outward_until_the_likelihood_falls(top, looked_at, best):
    state, change, tried = _of_one_parameter(top)
    base = -50.0 * np.log(1.0 / top) ** 2
    ((gain, found),) = random_effects.screen(state, 1.0, base, [change])
    assert tried == looked_at and found.start == (best,)
    assert gain == pytest.approx(-50.0 * np.log(best / top) ** 2 - base)


def test_an_accepted_change_is_fitted_again_from_where_it_is():
    state, change, tried = _of_one_parameter(1.3)
    held = Change(change, np.array([1.0]), 1.0, 1.0)
    assert posterior.refitted(state, held)[0] == pytest.approx(1.3, rel=0.01)
    assert len(tried) < 12


@pytest.mark.parametrize("late", [0.3, -0.3, 0.0])
def test_a_search_starts_at_the_delay_that_the_innovations_like_best(late):
    # a path follows centimetre fixes: the regression about it asks for a third of their delay, and
    # an antenna 3 m ahead turns so early that turns match 0.2 s off
    arm = [3.0, 0.0, -1.0]
    effects = [("gnss_time_offset", {"offset": late}), ("lever_arm", {"arm": arm})]
    arrays = generator.make(
        62001, effects=effects, duration=120.0, rate=50.0, position_sd=(0.02,) * 3
    )
    drive = from_arrays(arrays, "x").with_(lever_arm=np.array(arm))
    state = State(drive, Noise(levels.guess()), np.zeros(len(columns.ALL)))
    start.in_time(state, lambda text: None)
    assert state.theta[columns.of("gnss_time_offset")] == pytest.approx(late, abs=0.04)
    assert bool(state.kept) == (late != 0.0)
