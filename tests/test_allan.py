"""Overlapped Allan deviation: against allantools, closed forms, gaps, and its degrees of freedom."""

import allantools
import numpy as np
import pytest
from allantools import ci
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from imu_lib import allan
from imu_lib.allan import confidence
from imu_lib.allan.clusters import squared_differences
from imu_lib.processes import GaussMarkov, RandomWalk, WhiteNoise
from imu_lib.record import Record


def plain(x, m):
    """The definition, Eq. 13 of the 2013 paper, on cluster means."""
    mean = np.convolve(x, np.ones(m) / m, mode="valid")
    return np.mean((mean[m:] - mean[:-m]) ** 2) / 2


@pytest.mark.parametrize("signal", ["white", "walk", "offset", "ramp"])
def test_equals_allantools(signal):
    rng = np.random.default_rng(1)
    n = 50_000
    x = rng.standard_normal(n)
    x += {
        "white": 0.0,
        "walk": np.cumsum(rng.standard_normal(n)),
        "offset": -9.8e3,
        "ramp": 1e-2 * np.arange(n),
    }[signal]
    curve = allan.deviation(x, 100.0)
    tau, adev, _, n_windows = allantools.oadev(x, rate=100.0, data_type="freq", taus=curve.tau)
    same = np.isin(curve.m, np.rint(tau * 100).astype(int))
    assert (
        same.sum() >= curve.m.size - 1
    )  # allantools leaves out averaging times with a single window
    # 1e-10 is what the two sums, taken in another order, may differ by at this length
    assert np.abs(curve.adev[same] / adev - 1).max() < 1e-10
    assert np.array_equal(curve.n[same], n_windows)


def test_kinds_of_deviation_take_rates():
    """The white noise of a rate falls as 1/sqrt(tau) in all of them; taken for a phase it would
    fall as 1/tau.
    """
    x = np.random.default_rng(3).standard_normal(40_000)
    kinds = allan.by_allantools(x, 10.0, taus=[1.0, 16.0])
    assert set(kinds) == {"Allan", "modified", "Hadamard", "total"}
    for _, value in kinds.values():
        assert np.log2(value[0] / value[1]) / 4 == pytest.approx(
            0.5, abs=0.06
        )  # 250 clusters at 16 s: 4 %, 0.015 of slope
    with pytest.raises(ValueError, match="`kinds`"):
        allan.by_allantools(x, 10.0, kinds=["parabolic"])


def test_a_record_is_read_channel_by_channel():
    x = np.random.default_rng(4).standard_normal((2, 3000))
    curves, readings = allan.of_record(Record({"gyro_x": x[0], "accel_z": x[1]}, 50.0))
    assert list(curves) == list(readings) == ["gyro_x", "accel_z"]
    assert np.array_equal(curves["accel_z"].adev, allan.deviation(x[1], 50.0).adev)
    assert readings["gyro_x"]["N"] == allan.read_off(curves["gyro_x"])["N"]


@settings(max_examples=40, deadline=None)
@given(hnp.arrays(float, st.integers(6, 300), elements=st.floats(-1e3, 1e3)), st.integers(1, 3))
def test_equals_its_definition(x, m):
    means, counts = squared_differences(x, np.array([m]))
    assert counts[0] == x.size - 2 * m + 1
    scale = np.mean((x - x.mean()) ** 2) + 1e-12
    assert abs(means[0] / 2 - plain(x, m)) <= 1e-9 * max(plain(x, m), scale)


def test_threads_agree():
    x = np.random.default_rng(2).standard_normal(30_000)
    one, many = (allan.deviation(x, 1.0, threads=k).adev for k in (1, 4))
    assert np.abs(one / many - 1).max() < 1e-12  # only the order of the sum differs


def test_gaps_leave_out_windows_and_nothing_else():
    rng = np.random.default_rng(3)
    x = rng.standard_normal(4000)
    x[1000:1100] = np.nan
    curve = allan.deviation(x, 1.0, taus=[1, 10, 100])
    for j, m in enumerate(curve.m):
        windows = np.lib.stride_tricks.sliding_window_view(x, 2 * m)
        whole = windows[np.isfinite(windows).all(axis=1)]
        d = whole[:, m:].mean(axis=1) - whole[:, :m].mean(axis=1)
        assert curve.n[j] == len(whole)
        assert curve.avar[j] == pytest.approx(np.mean(d**2) / 2, rel=1e-10)


def test_scattered_dropouts():
    """One sample in fifty lost: no long cluster is whole, but nearly whole ones tell the same."""
    rng = np.random.default_rng(4)
    x = rng.standard_normal(200_000) + 0.02 * np.cumsum(rng.standard_normal(200_000))
    full = allan.deviation(x, 10.0)
    lost = np.where(rng.random(x.size) < 0.02, np.nan, x)
    assert allan.deviation(lost, 10.0).tau[-1] < 200
    kept = allan.deviation(lost, 10.0, present=0.9)
    assert kept.tau[-1] == full.tau[-1]
    late = slice(full.at(10.0), None)
    # 2 % of the samples are gone: the walk's variance is the same within their noise
    assert np.abs(kept.adev[late] / full.adev[kept.m.size * 0 + late.start :] - 1).max() < 0.05


def test_bad_arguments():
    x = np.zeros(10)
    for call, word in (
        (lambda: allan.deviation(np.zeros((2, 5)), 1.0), "`x`"),
        (lambda: allan.deviation(x[:2], 1.0), "`x`"),
        (lambda: allan.deviation(x, 0.0), "`fs`"),
        (lambda: allan.deviation(x, np.nan), "`fs`"),
        (lambda: allan.deviation(x, 1.0, taus=[100.0]), "`taus`"),
        (lambda: allan.deviation(x, 1.0, present=0.0), "`present`"),
        (lambda: allan.deviation(np.full(10, np.nan), 1.0), "`x`"),
    ):
        with pytest.raises(ValueError, match=word):
            call()


def test_hundred_averaging_times_at_most():
    for n in (10, 1000, 100_000, 2_520_000, 10**9):
        m = allan.cluster_lengths(n)
        assert m.size <= 100 and m[0] == 1 and m[-1] == n // 3 and np.all(np.diff(m) > 0)


def test_degrees_of_freedom_are_those_of_allantools():
    """allantools has Greenhall and Riley's sums and tables; 2 % is what its tables are rounded to."""
    checked = 0
    for n in (300, 5000, 2_520_000):
        for m in (1, 2, 7, 33, 34, 100, 1000, 30_000, 400_000):
            for slope, alpha in confidence.SLOPES.items():
                if 3 * m > n or alpha == 2 and n - 2 * m + 1 <= 2 * m:
                    continue
                mine = allan.degrees_of_freedom([m], [n - 2 * m + 1], [slope])[0]
                assert mine == pytest.approx(
                    max(1.0, ci.edf_greenhall(alpha, 2, m, n + 1, overlapping=True)), rel=0.02
                )
                checked += 1
    assert checked > 60


def test_papers_error():
    """The 2013 paper's example: 360 000 points, clusters of 60 000: about 32 %; 1.1 % is its
    figure for N.
    """
    assert allan.papers_error(360_000, 60_000) == pytest.approx(0.316, abs=0.001)


@pytest.mark.parametrize(
    "model",
    [
        WhiteNoise(N=1.0),
        RandomWalk(K=1.0),
        WhiteNoise(N=1.0) + GaussMarkov(sigma=1.0, correlation_time=30.0),
    ],
)
def test_intervals_cover_the_closed_form(model):
    rng = np.random.default_rng(5)
    hits = []
    for _ in range(300):
        curve = allan.deviation(model.simulate(3000, 1.0, rng), 1.0, per_decade=4)
        truth = np.sqrt(model.avar(curve.tau, 1.0))
        hits.append((curve.low <= truth) & (truth <= curve.high))
    share = np.mean(hits, axis=0)
    # 300 draws at 95 %: five standard errors are 6 %; the longest averaging times have fewer than
    # three degrees of
    # freedom and the kind of noise is itself read from the curve there
    assert np.all(share[:-2] > 0.89) and np.all(share > 0.85), share


def test_holds_at_about_its_level():
    """Twenty records of white noise: the share of intervals that hold the closed form, neighbours
    alike, near 95 %.
    """
    model = WhiteNoise(N=1.0)
    held = [
        allan.deviation(model.simulate(4000, 10.0, np.random.default_rng(seed)), 10.0)
        .holds(model)
        .mean()
        for seed in range(20)
    ]
    assert (
        0.88 < np.mean(held) < 0.99
    )  # each record's mean scatters by some 0.1, twenty of them by 0.02: three of those
    assert (
        not allan.deviation(model.simulate(4000, 10.0, np.random.default_rng(1)), 10.0)
        .holds(WhiteNoise(N=2.0))[:5]
        .any()
    )
