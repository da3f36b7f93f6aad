"""The gap index: its scatter where the model is right, the level behind the electronics, and what
a fit leaves uncertain.
"""

import numpy as np
import pytest
from scipy.signal import welch

from imu_lib.ensembles import ensemble
from imu_lib.ensembles.draws import Draws
from imu_lib.gap.channel import analyse
from imu_lib.gap.grown import REFITS, _drawn
from imu_lib.processes import (
    Constant,
    Flicker,
    GaussMarkov,
    HeavyTails,
    LowPass,
    RandomWalk,
    Resolution,
    Saturation,
    Sum,
    WhiteNoise,
)


def test_index_of_a_right_model_is_one_on_average_and_scatters_little():
    model = Sum((WhiteNoise(N=1e-3), Flicker(B=2e-4)))
    n, fs = 30_000, 100.0
    rows = ensemble.simulate(
        [([model], 0, n, ensemble.Beside(), None)], n, fs, [[3, i] for i in range(260)], None, [0.0]
    )[0]
    values = np.array([ensemble.index(row, rows[:100]).value for row in rows[100:]])
    # 160 values of 0.06 scatter about the index's own median, which 100 simulations give to 1 %:
    # 0.03 is two and a half of both
    assert values.mean() == pytest.approx(1.0, abs=0.03)
    assert values.std() < 0.085
    # 2.5 % were beyond 1.2 with a spectrum in logarithmic bins only
    assert np.mean(values > 1.2) <= 0.02


def test_statistics_that_move_together_count_as_one():
    rng = np.random.default_rng(7)

    def row(shared):
        return {"psd": shared + 0.05 * rng.standard_normal(80), "lines": rng.standard_normal(40)}

    rows = [row(rng.standard_normal()) for _ in range(100)]
    weight = ensemble._weights(np.array([np.concatenate(list(r.values())) for r in rows]))
    # 80 copies weigh what one of forty others does, which chance correlations of one in a hundred
    # take little from
    assert weight[:80].sum() == pytest.approx(1.0, rel=0.1) and weight[80:].mean() == pytest.approx(
        1.0, rel=0.1
    )
    values = [ensemble.index(row(rng.standard_normal()), rows).value for _ in range(200)]
    # forty-one independent squares: 1 / sqrt(82); with equal weights it were that of a single one,
    # 0.4
    assert np.std(values) < 0.15 and np.mean(values) == pytest.approx(1.0, abs=0.05)
    assert (
        ensemble.index({"psd": np.full(80, 9.0), "lines": rng.standard_normal(40)}, rows).domains[
            "psd"
        ]
        > 5
    )


@pytest.mark.parametrize(
    ("stage", "offset"),
    [
        (Resolution(lsb=2.5), 0.27 * 2.5),
        (Resolution(lsb=2.5), -0.3 * 2.5),
        (Saturation(limit=0.8), 0.4),
    ],
)
def test_level_behind_electronics_that_move_the_mean(stage, offset):
    """White noise of standard deviation 1; the mean of the output is known to 1 / sqrt(n), the
    level a little worse.
    """
    n, fs = 200_000, 100.0
    noise = WhiteNoise(N=1 / np.sqrt(fs))
    out = Sum((noise, Constant(value=offset)), (stage,)).simulate(n, fs, np.random.default_rng(5))
    assert abs(out.mean() - offset) > 0.02  # or there were nothing to correct
    level = ensemble.behind_mean(Sum((noise,), (stage,)), out.mean(), n, fs)
    assert level == pytest.approx(offset, abs=5 * 1.8 / np.sqrt(n))


def test_level_is_the_mean_without_such_electronics():
    model = Sum((WhiteNoise(N=1e-3), RandomWalk(K=1e-6)), (Resolution(lsb=1e-4),))
    assert ensemble.behind_mean(Sum(model.terms), 0.25, 10_000, 100.0) == 0.25
    assert ensemble.behind_mean(model, 0.25, 10_000, 100.0) == pytest.approx(
        0.25, abs=1e-5
    )  # a thousandth of the noise


def test_held_out_models_scatter_as_the_fit_is_uncertain():
    fs, n = 50.0, 60_000
    rng = np.random.default_rng(12)
    base = Sum((WhiteNoise(N=1e-3),))
    t = np.arange(n) / fs
    x = (
        Sum((*base.terms, GaussMarkov(sigma=1e-3, correlation_time=5.0))).simulate(n, fs, rng)
        + 4e-6 * t
    )
    found = analyse("gyro_x", x, fs, base)
    assert {s.effect for s in found.steps} == {"gauss_markov", "ramp"}
    assert len(found.refit) == REFITS
    sigma = np.log(
        [next(p.sigma for p in m.terms if p.name == "gauss_markov") for m in found.refit]
    )
    slope = np.array([next(p.R for p in m.terms if p.name == "ramp") for m in found.refit])
    whole = next(s for s in found.steps if s.effect == "gauss_markov").intervals["sigma"]
    # from three fifths of the record: sqrt(5/3) of the whole's, a slope (5/3)^1.5; 100 draws give
    # a standard deviation to 7 %
    assert sigma.std() / (np.diff(np.log(whole))[0] / 3.92) == pytest.approx(1.29, rel=0.4)
    whole = next(s for s in found.steps if s.effect == "ramp").intervals["R"]
    assert slope.std() / (np.diff(whole)[0] / 3.92) == pytest.approx(2.15, rel=0.4)


def test_one_model_is_enough_where_nothing_was_fitted():
    fs, n = 100.0, 40_000
    rng = np.random.default_rng(4)
    x = Sum((WhiteNoise(N=1e-3),), (Saturation(limit=0.02),)).simulate(n, fs, rng)
    found = analyse("gyro_x", x, fs, Sum((WhiteNoise(N=1e-3),)))
    assert [s.effect for s in found.steps] == ["saturation"] and len(found.refit) == 1


def test_drawn_parameters_keep_their_bounds_and_covariance():
    from imu_lib.gap import effects
    from imu_lib.gap.candidate import Candidate
    from imu_lib.gap.data import Data
    from imu_lib.gap.state import State

    fs, n = 50.0, 60_000
    model = Sum((WhiteNoise(N=1e-3), GaussMarkov(sigma=4e-4, correlation_time=20.0)))
    data = Data(model.simulate(n, fs, np.random.default_rng(2)), fs)
    effect = effects.CATALOGUE["gauss_markov"]
    state = State(
        data,
        [WhiteNoise(N=1e-3)],
        [Candidate(effect, model.terms[1], effect.slot(0, fs, data.duration))],
    )
    fits = _drawn(state, np.random.default_rng(0), 4000)
    logs = np.log([[f.terms[1].sigma, f.terms[1].correlation_time] for f in fits])
    sd = np.sqrt(np.diag(state.fit.cov))
    assert len(sd) == 2 and np.all(sd < 1)
    low, high = state.problem.low, state.problem.high
    vectors = np.array([[*state.fit.slots[0].read(f.terms[1])] for f in fits])
    assert np.all(vectors >= low - 1e-9) and np.all(vectors <= high + 1e-9)
    # the prior is some ten times wider than the data allow
    assert vectors.std(axis=0) == pytest.approx(sd, rel=0.1)
    assert np.all(np.isfinite(logs))


@pytest.mark.parametrize("ratio", [1, 10])
def test_heavy_tails_behind_a_filter_have_the_spectrum_of_the_model(ratio):
    """What folds in from above half the sampling rate included."""
    n, fs = 40_000, 200.0
    white, low = WhiteNoise(N=1.0), LowPass(cutoff=65.0, order=1, rate=ratio * fs)
    _, drawn = Draws([5], n, fs).terms((white,), low, HeavyTails(6.0))
    f, power = welch(drawn, fs, nperseg=400)
    part = (f > 5) & (f < 0.48 * fs)
    # 12,000 means of 199 half-overlapping segments: a hundredth, in each tenth of the band a thirtieth
    for band in np.array_split(np.flatnonzero(part), 10):
        want = Sum((white,), (low,)).psd(f[band], fs)
        assert np.mean(power[band] / want) == pytest.approx(1.0, abs=0.08)
