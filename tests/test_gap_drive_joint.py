"""Noises of a drive fitted together: what one takes, the others must give."""

from types import SimpleNamespace

import drive_generator as generator
import numpy as np
import pytest

from imu_lib.drive import from_arrays
from imu_lib.gap.drive import (
    base_model,
    columns,
    hidden,
    joint,
    left,
    levels,
    path,
    profile,
    random_effects,
    readings,
    regression,
    search,
    shocks,
    swap,
)
from imu_lib.gap.drive.problem import Noise
from imu_lib.gap.drive.state import Change, State
from imu_lib.model import Model

MODEL = Model.from_json(generator.MODEL)
SD = 0.06


def state_of(noise, effects=(), free=False, **options):
    arrays = generator.make(
        61007, effects=effects, **{"duration": 120.0, "velocity_sd": (SD,) * 3, **options}
    )
    state = State(from_arrays(arrays, "x"), noise, np.zeros(len(columns.ALL)), free=free)
    state.base = noise
    state.rebuild()
    return state


def change_of(state, effect, of=None):
    options = random_effects.changes(state.problem, state.noise, not state.free)
    return next(c for c in options if c.effect == effect and of in (None, *c.key))


def test_errors_of_velocities_without_memory_are_a_larger_white_one():
    state = state_of(Noise(MODEL))
    forgets = Noise(MODEL, velocity_sigma=0.08, velocity_tau=1e-3)
    white = Noise(MODEL, velocity=float(np.hypot(SD, 0.08) / SD))
    one, other = (state.evaluate(n, sens=True) for n in (forgets, white))
    np.testing.assert_allclose(one.by_fix, other.by_fix, atol=1e-6)
    np.testing.assert_allclose(one.jac, other.jac, atol=1e-5)
    both = Noise(MODEL, velocity_sigma=0.08, velocity_tau=1e-3, sigma=1.0, tau=20.0)
    plain = Noise(MODEL, velocity=white.velocity, sigma=1.0, tau=20.0)
    one, other = (state.evaluate(n).log_likelihood for n in (both, plain))
    assert one == pytest.approx(other, abs=1e-5)


def test_velocities_of_another_size_are_not_told_as_errors_that_last():
    state = state_of(Noise(MODEL), [("gnss_noise", {"ratio": 4.0, "of": "velocity"})])
    size = change_of(state, "gnss_noise", "velocity")
    lasts = change_of(state, random_effects.VELOCITY_LASTS)
    base = state.result.log_likelihood
    fits = [c.fitted(state, state.noise, base) for c in (lasts, size)]
    ranked = [(c, f[1]) for c, f in zip((lasts, size), fits)]
    assert search.size_first(ranked) == 1
    assert search.size_first([(lasts, 2.5 * fits[1][1]), ranked[1]]) == 0
    state.noise = fits[1][2]
    beside = change_of(state, random_effects.VELOCITY_LASTS)  # which leaves the size alone
    assert beside.enter(state.noise, np.array([0.1, 3.0])).velocity == state.noise.velocity
    assert 3.5 < state.noise.velocity < 4.5


def test_a_noise_of_fixes_is_not_left_small_by_levels_fitted_without_it():
    # the accelerometers' noise held the rest: 1.41 for a ratio of 1.6
    effects = [("gnss_noise", {"ratio": 1.6, "of": "velocity"})]
    state = state_of(Noise(levels.guess()), effects, free=True)
    loud = levels.of(state.noise, ()) + np.array([0.0, np.log(6.0), 0.0, 0.0])
    state.base = state.noise = levels.entered(state.noise, loud, ())
    state.weigh()
    change = change_of(state, "gnss_noise", "velocity")
    alone, gain, noise = change.fitted(state, state.noise, state.result.log_likelihood)
    state.changes, state.noise = [Change(change, alone, gain, state.noise)], noise
    state.weigh()
    assert alone[0] < 1.5
    base_model.settle(state)
    assert 1.5 < state.changes[0].values[0] < 1.7
    assert state.noise.velocity == state.changes[0].values[0]
    assert state.base.model is state.changes[0].before.model is state.noise.model


def test_values_follow_the_ridge_of_the_likelihood():
    # of two with correlation -0.8 the second moves by its slope on the first
    information = np.array([[4.0, 3.2], [3.2, 4.0]])
    together = joint.Joint(None, (), np.zeros(2), np.zeros(2), np.ones(2), ())
    object.__setattr__(together, "slope", lambda x: (np.zeros(2), information))
    np.testing.assert_allclose(together.follow(slice(1, 2)), [[-0.8], [1.0]])


class Bent(joint.Joint):
    """A likelihood of two parameters whose ridge is a parabola: of the first alone a normal one of
    unit width.
    """

    def value(self, x):
        return float(-0.5 * x[0] ** 2 - 50.0 * (x[1] - 0.5 * x[0] ** 2) ** 2)

    def slope(self, x):
        off, bent = 100.0 * (x[1] - 0.5 * x[0] ** 2), np.array([-x[0], 1.0])
        return np.array([-x[0], 0.0]) - off * bent, 100.0 * np.outer(bent, bent) + np.diag([1.0, 0])


def test_an_interval_goes_along_a_ridge_that_bends():
    # along the straight line that the ridge leaves, 0.95 of the chance lies within 0.6
    bent = Bent(None, (), np.zeros(2), np.zeros(2), np.ones(2), ())
    first = slice(0, 1)
    ((low, middle, high),) = profile.quantiles(bent, np.zeros(2), first, np.array([1.0]))
    assert (low, middle, high) == pytest.approx((-1.96, 0.0, 1.96), abs=0.03)
    # a width that was taken too small is no limit
    ((low, _, high),) = profile.quantiles(bent, np.zeros(2), first, np.array([0.2]))
    assert (low, high) == pytest.approx((-1.96, 1.96), abs=0.1)


def test_what_is_usual_is_not_where_a_fit_is_started():
    state = state_of(Noise(MODEL), duration=90.0, velocity=False)
    base, change = state.result.log_likelihood, change_of(state, "gnss_correlated")
    ((_, tried),) = random_effects.screen(state, state.noise, base, [change])
    assert tried.start != change.start
    np.testing.assert_array_equal(tried.middle, change.middle)
    assert tried.pull(change.middle) == 0.0


def test_a_white_noise_that_the_readings_show_is_not_absurd(monkeypatch):
    step = {
        "effect": "bias_model",
        "parameters": {
            "channel": "gyro_z", "process": "white_noise", "name": "N", "from": 1e-6, "to": 1e-3,
        },
    }  # fmt: skip
    after = SimpleNamespace(right=True)
    for shown, doubted in ((1e-3, False), (1e-5, True)):
        measured = np.full((9, 6), shown**2), np.zeros(9)
        monkeypatch.setattr(readings, "densities", lambda problem, m=measured: m)
        told = left.absurd([step], SimpleNamespace(problem=None), after)
        assert (told is not None) == doubted
    step["parameters"] |= {"process": "random_walk", "name": "K"}
    for right in (True, False):
        told = left.absurd([step], SimpleNamespace(problem=None), SimpleNamespace(right=right))
        assert (told is None) == right


def test_centimetre_fixes_have_the_size_that_they_state():
    # a floor of 2 cm made fixes of 8 mm look four times better than stated
    state = state_of(Noise(MODEL), position_sd=(0.008, 0.008, 0.012), duration=60.0)
    seen = state.use[:, :3]
    assert np.sqrt(np.median(state.problem.stated[:, 0])) == pytest.approx(0.008)
    assert 0.8 < np.nanmean(state.result.e[:, :3][seen] ** 2) < 1.25


def fitted(unknown, **options):
    state = state_of(Noise(levels.guess()), free=True, unknown=[unknown], **options)
    base_model.hold(state, base_model.fit(state))
    state.weigh()
    state.rebuild()
    return state


def test_a_shock_that_the_fitted_noise_had_hidden_is_found():
    # accelerometers of 0.04 m/s^2/sqrt(Hz) held a pothole: no innovation stood out
    state = fitted("pothole", velocity=False, duration=150.0)
    assert shocks.hidden(state, lambda text: None)
    assert abs(state.restarts[0] - 0.6 * 150.0) < 2.0
    assert "a shock at" in left.unexplained(
        state, SimpleNamespace(right=True, worst=lambda: ("", 0))
    )


def test_a_drift_that_a_fitted_walk_had_hidden_is_found():
    state = fitted("temperature_bias", velocity=False, duration=240.0)
    assert not state.kept
    assert hidden.look(state, search.candidates(state.problem), lambda text: None)
    assert state.kept == ("other: biases follow the temperature",)


def test_nothing_is_hidden_where_nothing_is():
    state = fitted("nothing", velocity=False, duration=150.0)
    names = search.candidates(state.problem)
    assert not shocks.hidden(state, lambda text: None)
    assert not hidden.look(state, names, lambda text: None)


def test_a_shake_that_is_there_at_rest_too_stands_in_the_place_of_a_slow_noise():
    # taken for a slow noise while other channels still had the wrong one; nothing put it right
    shaken = {"channel": "accel_x", "N": 0.02, "N_per_speed": 3e-3}
    state = state_of(Noise(MODEL), [("vibration", shaken)])
    state.base = state.noise
    wrong = next(
        c
        for c in random_effects.changes(state.problem, state.noise, True)
        if c.key == ("bias_model", "accel_x", "gauss_markov", "sigma")
    )
    values, gain, noise = wrong.fitted(state, state.noise, state.result.log_likelihood)
    state.changes, before = [Change(wrong, values, gain, state.noise)], state.noise
    state.noise = noise
    state.weigh()
    swap.noises(state, True, lambda text: None)
    (held,) = state.changes
    told = held.change.describe(held.values)
    assert held.change.effect == "vibration"
    assert told["N"] == pytest.approx(0.02, rel=0.3)
    assert told["N_per_speed"] == pytest.approx(3e-3, rel=0.3)
    # what stood there is a rival now, and the path's own filter knows the level at rest
    assert wrong.key in [key for _, _, key in held.rivals]
    (effect,) = path._vibrations(state.noise)
    assert effect.parameters == pytest.approx(told)
    assert state.noise.model is before.model


def test_a_gyro_that_shakes_more_than_it_turns_has_no_scale_factor():
    # its column holds the noise that the innovations hold: 0.11 was named, and sure, at 15 nats
    shaken = {"channel": "gyro_x", "N": 8e-5, "N_per_speed": 8e-4}
    noise = Noise(MODEL, per_speed=(8e-4, 0.0, 0.0, 0.0, 0.0, 0.0))
    state = state_of(noise, [("vibration", shaken)], kind="motorway")
    result = state.evaluate(noise, sens=True)
    plain = regression.of(state.problem, result, state.theta, state.use)
    x = columns.of("gyro_scale")[0]
    scores = [r.score[x] / np.sqrt(r.information[x, x]) for r in (plain, state.reg)]
    assert scores[0] > 4.0 and abs(scores[1]) < 3.0
