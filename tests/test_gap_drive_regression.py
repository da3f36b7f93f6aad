"""The regression of innovations on what parameters do to them, and its limits."""

import numpy as np
import pytest

from imu_lib.gap.drive import columns, left, regression, select


def test_a_limit_leaves_the_other_end_of_the_ridge_free():
    # 0.1 s at 10 m/s is a metre ahead: held at 0 s, the antenna's place was said to a tenth of what
    # it is known to
    count = len(columns.ALL)
    row, apart = np.zeros(count), np.zeros(count)
    late, ahead = columns.of("gnss_time_offset")[0], columns.of("lever_arm")[0]
    row[late], row[ahead], apart[ahead] = 10.0, -1.0, 1.0
    information = 400.0 * np.outer(row, row) + 4.0 * np.outer(apart, apart)
    reg = regression.Regression(information, np.zeros(count), 1.0, 400)
    _, sd, _ = select.seen(reg, (), "lever_arm")
    _, cov, _ = reg.solve(columns.of("lever_arm"))
    assert sd[0] > 5.0 * np.sqrt(cov[0, 0])


@pytest.mark.parametrize(
    ("x", "kept"),
    [
        ((0.0, 0.4, 0.6, 0.0), True),  # a filter of two thirds of a second
        ((-0.6, 0.8, 0.1, 0.0), True),  # the same, seen a few times a second
        ((0.8, -0.5, 0.16, -0.02), False),  # fast motion alone: noise of the readings
    ],
)
def test_a_filter_that_takes_nothing_from_slow_motion_is_none(x, kept):
    index = columns.GROUPS[left.SMOOTHED]
    count = len(columns.ALL)
    information = np.zeros((count, count))
    information[np.ix_(index, index)] = 1e4 * np.eye(4)
    score = np.zeros(count)
    score[index] = 1e4 * np.array(x)
    reg = regression.Regression(information, score, 1.0, 1000)
    values, _, gain = reg.solve(index)
    assert np.any(values) == kept and (gain > 0.0) == kept
    assert np.isclose(reg.gains([index])[0], gain)


def test_gains_of_many_sets_are_those_of_each():
    rng = np.random.default_rng(12)
    width = columns.PRIOR * rng.choice([0.05, 0.5, 3.0], len(columns.ALL))
    j = rng.normal(size=(400, len(columns.ALL))) / width
    y = j @ (rng.normal(size=len(columns.ALL)) * 3.0 * columns.PRIOR)
    reg = regression.Regression(j.T @ j, j.T @ y, 1.0, 400)
    effects = list(columns.GROUPS)
    sets = [
        (),
        *[rng.choice(effects, k, replace=False) for k in (1, 2, 3, 5, 8) for _ in range(12)],
    ]
    indices = [[i for e in kept for i in columns.GROUPS[e]] for kept in sets]
    each = [reg.solve(np.array(index, int))[2] for index in indices]
    assert np.allclose(reg.gains(indices), each)
    # some meet a limit, where the quick way would say too much
    free = [reg.solved(np.array(index, int))[2] for index in indices]
    assert 3 < np.sum(~np.isclose(free, each)) < len(sets) - 3
