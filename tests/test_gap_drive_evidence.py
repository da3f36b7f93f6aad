"""How sure a drive's findings are, and what is said of those that do not help or cannot be told apart."""

import json
from pathlib import Path
from types import SimpleNamespace

import drive_generator as generator
import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from imu_lib.cli import gap_drive as told
from imu_lib.drive import from_arrays
from imu_lib.errors import InputError
from imu_lib.gap.drive import (
    admission,
    columns,
    evidence,
    left,
    measured,
    path,
    posterior,
    regression,
    reliability,
    searched,
    select,
)
from imu_lib.health.driven import disagreements
from imu_lib.navigation import axes, fix_faults, windows

RESULTS = Path(__file__).resolve().parents[1] / "benchmarks" / "results"
REPEATS = 200
RIGHT = generator.make(21, duration=200.0)
BIAS, SCALE = columns.of("accel_bias")[2], columns.of("accel_scale")[2]
KEPT = ("accel_bias", "accel_scale")
INDEX = [i for e in KEPT for i in columns.GROUPS[e]]


def level(bias, scale):
    """Regression of a level road: the force along z is 9.8 m/s^2 and changes by a little."""
    count = len(columns.ALL)
    force = np.zeros((2000, count))
    force[:, BIAS] = 1.0
    force[:, SCALE] = -9.8 + 0.5 * np.sin(np.arange(2000) / 30.0)
    y = force @ np.eye(count)[BIAS] * bias + force @ np.eye(count)[SCALE] * scale
    return regression.Regression(200.0 * force.T @ force, 200.0 * force.T @ y, 1.0, 2000)


def test_a_bias_and_a_scale_factor_that_cancel_are_one():
    x, _, _ = (reg := level(1.4, 0.11)).solve(INDEX)
    assert x[INDEX.index(SCALE)] == 0.0
    # what they do together stays
    assert x[INDEX.index(BIAS)] == pytest.approx(1.4 - 9.8 * 0.11, abs=0.02)
    ridges = select.ridges(reg, KEPT)
    assert ridges == {KEPT: "z", KEPT[::-1]: "z"}
    found = [{"effect": "accel_bias", "indistinguishable": [], "confidence": 0.99}]
    assert "accel_bias and accel_scale z" in evidence.share(found, ridges)[0]
    assert found[0]["indistinguishable"] == ["accel_scale"] and found[0]["confidence"] <= 0.5


@pytest.mark.parametrize(("bias", "scale"), [(0.3, 0.03), (1.4, -0.11), (0.0, 0.11)])
def test_values_that_sensors_have_or_that_do_not_cancel_stay(bias, scale):
    reg = level(bias, scale)
    x, _, _ = reg.solve(INDEX)
    assert x[INDEX.index(SCALE)] == pytest.approx(scale, abs=0.005)
    assert not select.ridges(reg, KEPT)


def test_confidence_is_the_share_of_right_names_in_the_stored_score():
    tables = [
        json.loads((RESULTS / f"drive_gap_score_{n}.json").read_text()) for n in reliability.SOURCES
    ]
    stored = {c: {} for c in reliability.COUNTED}
    for table in [t for both in tables for t in (both, both["without_model"]) if t]:
        for c, names in table["names"].items():
            for e, (found, right) in names.items():
                known = stored[c].get(e, (0, 0))
                stored[c][e] = known[0] + found, known[1] + right
    assert stored == reliability.COUNTED
    for unexplained, right in ((None, True), ("a shock", True), ("too large", False)):
        found = [{"effect": "never heard of", "weight": 0.999, "runner_up": {"confidence": 0.9}}]
        beside = reliability.left(unexplained, right)
        reliability.give(found, beside)
        counted = reliability.COUNTED[beside or "full"].values()
        right, of = sum(c[1] for c in counted), sum(c[0] for c in counted)
        assert found[0]["confidence"] == pytest.approx((right + 1) / (of + 2))
        # what is left over is all that a rival can have
        assert found[0]["runner_up"]["confidence"] <= 1.0 - found[0]["confidence"] + 1e-12


def test_intervals_cover_where_the_innovations_of_one_column_alone_are_correlated():
    rng = np.random.default_rng(12)
    count, fixes = len(columns.ALL), 900
    x, y, z = columns.of("accel_scale")
    time, use = np.arange(fixes) * 1.0, np.ones((fixes, 6), bool)
    inside, plain = 0, 0
    for _ in range(REPEATS):
        e, jac = rng.standard_normal((fixes, 6)), np.zeros((fixes, 6, count))
        slow = lfilter([np.sqrt(1.0 - 0.9**2)], [1.0, -0.9], rng.standard_normal((2, fixes)))
        e[:, 0], jac[:, 0, x] = slow[0], 100.0 * slow[1]  # correlated, and so is what would show it
        jac[:, 1, y], jac[:, 2, z] = 100.0 * rng.standard_normal((2, fixes))
        result = SimpleNamespace(e=e, jac=jac)
        reg = regression.of(SimpleNamespace(time=time), result, np.zeros(count), use)
        value, cov, _ = reg.solve([x])
        inside += abs(value[0]) < 1.96 * reg.sd([x])[0]
        plain += abs(value[0]) < 1.96 * np.sqrt(cov[0, 0])
    # of 95 % asked, four standard deviations of the count; the likelihood alone covers far less
    assert inside > REPEATS * (0.95 - 4.0 * np.sqrt(0.05 * 0.95 / REPEATS))
    assert plain < 0.75 * REPEATS


def test_wild_fixes_side_by_side_lie_far_off_and_the_path_has_none_of_them():
    time = np.arange(200) * 0.1
    position = np.column_stack([0.8 + 1e-6 * time, 0.2 + 2e-6 * np.sin(time), 100.0 + 0.0 * time])
    position += np.random.default_rng(8).standard_normal(position.shape) * [3e-9, 3e-9, 0.02]
    true, wild = position.copy(), [3, 50, 51, 120, 198]
    position[wild] += np.array(
        [[5e-6, 0, 30], [0, 4e-6, -9], [0, 3e-6, -5], [-3e-6, 0, 4], [0, 0, 8]]
    )
    np.testing.assert_array_equal(np.flatnonzero(fix_faults.far_off(time, position)), wild)
    drive = SimpleNamespace(gnss_time=time, gnss_position=position, with_=lambda **k: k)
    tame, _ = path._tame(drive, SimpleNamespace(fraction=0.03))
    off = (tame["gnss_position"] - true) * [6.4e6, 6.4e6, 1.0]
    assert np.abs(off).max() < 0.5


def test_an_arm_does_not_swing_with_the_guesses_of_a_heading_that_is_not_yet_known():
    rng, count = np.random.default_rng(4), 200
    sd = np.where(np.arange(count) < 40, 0.17, 0.002)
    turn = np.where(sd > 0.1, 0.05 * rng.standard_normal(count), 1e-4)  # by each fix, about down
    true = Rotation.from_euler("ZYX", [0.7, 0.1, -0.05]).as_matrix()
    after = np.cumsum(turn) - turn[:40].sum()
    c_now = Rotation.from_rotvec(np.outer(after, [0, 0, 1])).as_matrix() @ true
    c = Rotation.from_rotvec(np.outer(after - turn, [0, 0, 1])).as_matrix() @ true
    assert np.abs(c[:40] - true).max() > 0.05
    settled = measured._settled(c, c_now, sd)
    np.testing.assert_allclose(settled[:40], np.broadcast_to(true, (40, 3, 3)), atol=0.002)
    np.testing.assert_array_equal(settled[40:], c[40:])


def test_a_component_that_the_drive_does_not_show_has_the_interval_of_its_limit():
    step = {
        "effect": "lever_arm",
        "parameters": {"arm": [0.2, -0.4, -0.65]},
        "intervals": {"arm": [[0.1, 0.3], [-0.5, -0.3], [-0.7, -0.6]]},
    }
    unseen = [{"effect": "lever_arm", "parameter": "arm z", "upper_limit": 1.3}]
    left.limited([step], unseen, np.array([0.0, 0.0, 0.5]))
    assert step["intervals"]["arm"] == [[0.1, 0.3], [-0.5, -0.3], [pytest.approx(-0.8), 1.8]]


def test_steps_that_do_not_help_are_said():
    found = [
        {"effect": "gnss_correlated", "gap_before": 53.9, "gap_after": 73.4},
        {"effect": "gnss_noise", "gap_before": 73.4, "gap_after": 48.0},
    ]
    (said,) = evidence.widening(found)
    assert "gnss_correlated (53.9 to 73.4)" in said and "gnss_noise" not in said
    assert not evidence.widening(found[1:])
    assert "not proven" in evidence.unproven(found, {"value": 0.85, "low": 0.5, "high": 1.4})[0]
    assert not evidence.unproven(found, {"value": 0.2, "low": 0.1, "high": 0.5})


def test_an_interval_goes_where_the_path_has_moved_the_likelihood():
    # fitted at 0.51 on a path since built anew: the likelihood now lies at 0.486, and narrow
    def evaluate(x):
        return SimpleNamespace(by_fix=np.array([-0.5 * (np.log(x / 0.486) / 0.004) ** 2]))

    change = SimpleNamespace(
        start=(0.51,),
        middle=np.log([0.51]),
        enter=lambda noise, v: float(v[0]),
        describe=lambda v: {"ratio": float(v[0])},
    )
    found = SimpleNamespace(change=change, values=np.array([0.51]))
    state = SimpleNamespace(evaluate=evaluate, noise=None, free=False, changes=[found])
    low, high = posterior.intervals(state, found)["ratio"]
    assert low < found.values[0] < high
    assert (low, high) == pytest.approx(
        (0.486 * np.exp(-0.00784), 0.486 * np.exp(0.00784)), abs=3e-4
    )


@pytest.mark.parametrize("first", [("+y", "-x", "+z"), ("-y", "-x", "+z")])
def test_no_mirror_image_is_a_rival_of_a_rigid_case(first, monkeypatch):
    mirror, other = (first[0], "+x", "+z"), ("-x", "-y", "+z")
    nats = {first: 0.0, mirror: 500.0, other: 800.0}

    def costs(m, tried):
        return {p: nats.get(p, 5e4) for p in tried}

    monkeypatch.setattr(axes, "motion", lambda d: SimpleNamespace(moving=np.ones(1000, bool)))
    monkeypatch.setattr(axes, "_costs", costs)
    monkeypatch.setattr(axes, "MIRRORED", 0.0)
    found, _, rival, _, _ = axes.of(None)
    # a file with a wrong sign has left-handed axes: then every case is a rival
    assert found == first and rival == (mirror if axes.mirrored(first) else other)


@pytest.mark.parametrize("first", [axes.IDENTITY, ("-z", "+y", "+x")])
def test_a_case_turned_by_a_right_angle_has_other_axes(first):
    there = Rotation.from_matrix(axes.to_body(("+y", "-x", "+z")))
    askew = Rotation.from_euler("ZYX", [0.1, 0.05, -0.1]) * there
    found = (first, 0.9, axes.IDENTITY, 9.0, ())

    def turned(rotation):
        return rotation.as_euler("ZYX")[::-1], np.full(3, 0.02)

    both = searched._askew(found, turned(askew))[0]
    assert np.array_equal(axes.to_body(both), there.as_matrix().round() @ axes.to_body(first))
    # a case a little askew, or one that stands across, is no file with other axes
    assert searched._askew(found, turned(Rotation.from_euler("z", 0.2))) is None
    assert searched._askew(found, turned(Rotation.from_euler("z", 0.8))) is None


def test_accelerometers_with_all_signs_turned_are_refused():
    drive = from_arrays(RIGHT, "x")
    admission.check(drive)
    with pytest.raises(InputError, match="multiply `accel` by -1"):
        admission.check(drive.with_(accel=-drive.accel))
    # in a case that leans by 10 degrees
    leaning = Rotation.from_euler("YX", [0.18, -0.14]).as_matrix()
    leant = drive.with_(gyro=drive.gyro @ leaning, accel=drive.accel @ leaning)
    assert axes.reversed_sensor(leant) == ""
    assert axes.reversed_sensor(leant.with_(accel=-leant.accel)) == "accel"
    assert axes.reversed_sensor(leant.with_(gyro=-leant.gyro)) == "gyro"
    # in one that is turned by any angle no order of axes fits either of the two
    case = Rotation.from_euler("ZYX", [50.0, 40.0, 35.0], degrees=True)
    any_way = drive.with_(**{k: case.apply(RIGHT[k]) for k in ("gyro", "accel")})
    assert axes.reversed_sensor(any_way) == ""
    for sensor in ("gyro", "accel"):
        turned = any_way.with_(**{sensor: -getattr(any_way, sensor)})
        assert axes.reversed_sensor(turned) in (sensor, "either")
        assert "multiply" in " ".join(disagreements(turned))


def test_fixes_and_readings_that_do_not_overlap_are_said():
    away = from_arrays({**RIGHT, "gnss_time": RIGHT["gnss_time"] + 5000.0}, "x")
    for ask in (admission.check, windows.regular_windows):
        with pytest.raises(InputError, match="do not overlap"):
            ask(away)


def test_stamps_less_than_half_a_second_late_are_said():
    late = " ".join(
        disagreements(from_arrays({**RIGHT, "gnss_time": RIGHT["gnss_time"] + 0.4}, "x"))
    )
    assert "s late against the IMU" in late
    assert not disagreements(from_arrays(RIGHT, "x"))


def test_a_finding_says_who_is_late():
    step = {"effect": "gnss_time_offset", "parameters": {"offset": 0.534}}
    assert "fixes are stamped 0.534 s late" in told.sentence(step)
    step["parameters"]["offset"] = -0.2
    assert "0.2 s early" in told.sentence(step) and "after t" in told.sentence(step)
    unseen = ({"effect": "accel_scale", "parameter": f"scale {a}"} for a in "yz")
    assert told._unseen(unseen) == ["accel_scale (y z)"]


def test_the_delay_of_a_smoothed_velocity_is_no_time_offset():
    kept = ("gnss_time_offset", left.SMOOTHED)
    index = [i for e in kept for i in columns.GROUPS[e]]

    def held(position, velocity):
        x = np.array([position, velocity, *[0.5] * (len(index) - 2)])
        reg = SimpleNamespace(solve=lambda i: (x, 1e-4 * np.eye(len(index)), 0.0))
        return left.smoothed_delay(SimpleNamespace(kept=kept, reg=reg))

    assert held(0.01, 0.4) == 0.4
    assert held(0.2, 0.4) is None  # the positions are late too: the stamps are


def test_a_parameter_whose_usual_size_would_not_be_named_is_listed():
    count = len(columns.ALL)
    x, y, _ = columns.of("accel_scale")
    information = np.zeros((count, count))
    # what 0.03 promises: 3 nats along x, 60 along y
    information[x, x], information[y, y] = 2 * 3.0 / 0.03**2, 2 * 60.0 / 0.03**2
    reg = regression.Regression(information, np.zeros(count), 1.0, 1000)
    state = SimpleNamespace(reg=reg, kept=(), use=np.ones((9, 6), bool))
    turned = np.zeros(3), np.full(3, 0.001)
    listed = {(u["effect"], u["parameter"]) for u in left.invisible(state, turned)}
    assert ("accel_scale", "scale x") in listed and ("accel_scale", "scale y") not in listed


def _of_a_clock(true, sd, seed):
    """A regression that sees a clock of `true` priors with a standard deviation of `sd` priors."""
    count, k = len(columns.ALL), columns.of("imu_clock")[0]
    prior = columns.ALL[k].prior
    x = prior * (true + sd * np.random.default_rng(seed).standard_normal())
    information, score = np.zeros((count, count)), np.zeros(count)
    information[k, k] = (sd * prior) ** -2.0
    score[k] = x * information[k, k]
    return regression.Regression(information, score, 1.0, 1000), k, true * prior


def test_a_value_beyond_its_prior_is_not_drawn_to_nothing():
    # the prior alone would draw it by 1.2 of its standard deviations: 80 % of the intervals held it
    held = 0
    for seed in range(400):
        reg, k, true = _of_a_clock(4.0, 0.37, seed)
        (x,), (sd,) = reg.told([k])
        held += abs(x - true) < 1.96 * sd
    assert 0.92 < held / 400  # 95 % and three standard deviations of 400 draws


def test_a_value_of_the_usual_size_is_told_as_it_is_held():
    reg, k, _ = _of_a_clock(0.7, 0.2, 1)
    assert reg.told([k])[0] == pytest.approx(reg.solve([k])[0])
    assert reg.told([k])[1] == pytest.approx(reg.sd([k]))


def test_a_clock_that_was_found_is_not_listed_as_invisible():
    reg, _, _ = _of_a_clock(4.0, 0.37, 2)
    turned = np.zeros(3), np.full(3, 0.001)
    for kept, listed in (((), True), (("imu_clock",), False)):
        state = SimpleNamespace(reg=reg, kept=kept, use=np.ones((9, 6), bool))
        assert listed == any(u["effect"] == "imu_clock" for u in left.invisible(state, turned))


def test_a_component_that_the_drive_does_not_show_is_printed_without_a_value():
    from imu_lib.cli.gap_drive import values

    step = {
        "effect": "lever_arm",
        "parameters": {"arm": [-1.5, 0.6, 1.7]},
        "intervals": {"arm": [[-1.6, -1.4], [0.5, 0.7], [0.5, 2.8]]},
    }
    unseen = [{"effect": "lever_arm", "parameter": "arm z"}, {"effect": "other", "parameter": "x"}]
    assert values(step, unseen) == "x -1.5 [-1.6, -1.4], y 0.6 [0.5, 0.7] m, z not visible"
