"""Each fault put into a record is found at its time, and nothing in a sound one."""

import fault_generator as generator
import numpy as np
import pytest
from fault_judge import judge

from imu_lib import faults
from imu_lib.faults import clock, standing
from imu_lib.faults.chance import Levels, period_of
from imu_lib.health import of_record
from imu_lib.record import Record

CHANNELS = generator.CHANNELS


def record_of(case):
    return Record(case.channels, case.rate, time=case.time)


def still(n=20_000, rate=100.0, seed=1, **more):
    rng = np.random.default_rng(seed)
    x = rng.standard_normal((n, 6)) * np.r_[[2e-3] * 3, [1.5e-2] * 3]
    x[:, 5] -= 9.81
    return x, rate


def find(x, rate, time=None):
    return faults.find(Record(dict(zip(CHANNELS, x.T)), rate, time=time))


@pytest.mark.parametrize("kind", ["zero", "code", "nan", "held", "knock", "tilt", "hole", "burst"])
def test_each_kind_is_found_at_its_time(kind):
    """Two cases a kind here; benchmarks/fault_score.py has many."""
    for seed in (21, 22):
        case = generator.make(seed, kind)
        found, wrong = judge(case, faults.find(record_of(case)))
        assert found and not wrong, (seed, case.base, case.rate)


def test_nothing_in_sound_records():
    for seed in range(40, 48):
        case = generator.make(seed)
        assert judge(case, faults.find(record_of(case)))[1] == [], (seed, case.base, case.rate)


def test_a_restart_has_no_mirror_image_near_the_ends():
    """Each change is held against those one window away; at an end there is one of the two."""
    x, rate = still(n=13_000)
    x[4200:] += 8 * x.std(axis=0)
    again = [f for f in find(x, rate) if f.kind == "restart"]
    assert len(again) == 1 and again[0].start == pytest.approx(42.0, abs=0.5)


def test_a_restart_under_handling_is_seen_where_the_gyros_levels_stay_changed():
    """Being handled shakes the gyros and leaves their levels as they were."""
    x, rate = still(n=30_000)
    x[15_000:15_300] += 0.3 * np.sin(np.arange(300) / 9.0)[:, None]
    assert not [f for f in find(x, rate) if f.kind == "restart"]
    x[15_150:, :3] += 8 * 2e-3
    again = [f for f in find(x, rate) if f.kind == "restart"]
    assert len(again) == 1 and again[0].start == pytest.approx(151.5, abs=4.0)


def test_a_held_axis_on_a_coarse_grid_is_held_with_its_sensor():
    x, rate = still()
    x[:, 3:] = np.repeat(x[::4, 3:], 4, axis=0)
    x[:, 5] = np.round(x[:, 5] / 0.02) * 0.02
    held = [f for f in find(x, rate) if f.kind == "held"]
    assert [f.channels for f in held] == [("accel_x", "accel_y", "accel_z")]


@pytest.mark.parametrize(
    ("name", "kinds"),
    [
        ("hipnuc_ch104", set()),
        ("memsense_gyros", set()),
        ("mpu6050_10min", {"jitter", "rate"}),
        ("sony_cxd5602", {"burst", "gap"}),
        ("xsens_mtx", {"dropout"}),
        ("vn100_still", {"disturbance"}),
        ("xsens_dot", {"disturbance"}),
    ],
)
def test_real_records(data_dir, name, kinds):
    """What is seen in their plots by eye."""
    from imu_lib.readers import read_record

    found = faults.find(read_record(data_dir / f"static/{name}.npz", trust_units=True))
    assert {f.kind for f in found} == kinds, [f.sentence for f in found]


def test_equal_neighbours_of_a_grid_are_no_fault():
    """As many as normal noise on the grid makes: 14 pairs where 11.5 are expected, or half of all."""
    x, rate = still(30_000)
    for lsb in (1e-6, 1e-4, 2e-3):
        x[:, 0] = np.round(still(30_000)[0][:, 0] / lsb) * lsb
        again = np.mean(np.diff(x[:, 0]) == 0)
        # 2 percent of the larger ones, or the Poisson scatter of the few
        expected = Levels.of(x[:, 0]).repeat_chance()
        assert expected == pytest.approx(again, rel=0.1, abs=4 * np.sqrt(again / 30_000) + 4e-5)
        assert find(x, rate) == ()


def test_rows_of_zeros_keep_their_period():
    x, rate = still(40_000)
    rows = np.arange(23, 40_000, 57)
    rows = rows[np.random.default_rng(3).random(len(rows)) > 0.08]
    x[rows] = 0
    (found,) = find(x, rate)
    assert found.kind == "dropout" and np.array_equal(found.rows, rows)
    assert found.parameters == {
        "fraction": len(rows) / 40_000,
        "value": 0.0,
        "period": 57,
        "channels": list(CHANNELS),
    }
    assert period_of(np.sort(np.random.default_rng(4).choice(40_000, 600, replace=False))) is None


def test_the_longest_stretch_holds_no_turn_in_a_hole():
    """Twelve samples, eleven hours of nothing in which it was turned, and a record."""
    x, _ = still(4012, 0.1)
    x[:12, 3:] = x[:12, [5, 3, 4]]
    time = np.r_[np.arange(12) * 10.0, 43_000 + np.arange(4000) * 10.0]
    found = find(x, 0.1, time)
    assert {f.kind for f in found} == {"gap", "tilt"}
    record = Record(dict(zip(CHANNELS, x.T)), 0.1, time=time)
    assert faults.longest_stretch(record, found) == (43_000.0, pytest.approx(83_000.0))
    assert faults.sound(record, found).record.n == 4000


def test_what_is_found_is_masked_and_held_rows_are_thinned():
    x, rate = still()
    x[5000:5030] += 40 * x[:30].std(axis=0) * np.hanning(30)[:, None]
    x[777] = 0
    record = Record(dict(zip(CHANNELS, x.T)), rate)
    sound = faults.sound(record)
    lost = np.isnan(sound.record["gyro_x"])
    assert lost[777] and lost[5010:5020].all() and lost.sum() < 100 and not sound.cut  # a second
    held = Record({c: np.repeat(v[:4000], 4) for c, v in record.channels.items()}, 400.0)
    thin = faults.sound(held).record
    assert thin.rate == pytest.approx(100.0, rel=1e-3)
    assert np.array_equal(thin["accel_x"][:100], record["accel_x"][:100])


def test_one_sample_thrown_off_is_no_disturbance_and_a_step_no_tilt():
    x, rate = still(60_000)
    x[1000, 0] += 0.1
    x[40_000:, 3] += 0.1  # 0.6 deg, and no gyro saw it
    assert find(x, rate) == ()


def test_one_huge_sample_leaves_no_shadow_that_is_a_knock():
    x, rate = still(90_000)
    rng = np.random.default_rng(5)
    x[rng.integers(100, 89_900, 28), 2] += 2e-3 * rng.normal(0.0, 200.0, 28)
    x[53_815, 2] -= 700 * 2e-3
    assert [f.kind for f in find(x, rate) if f.kind == "disturbance"] == []


def test_the_clock():
    n = 8000
    coarse = np.floor(np.arange(n) / 238.0 / 1e-3) * 1e-3
    assert clock.grain_of(coarse) == pytest.approx(1e-3)
    assert clock.grain_of(np.arange(n) / 100.0) is None
    x, _ = still(n)
    kinds = {f.kind: f for f in find(x, 99.3, np.arange(n) / 99.3 + 1e-4 * np.sin(np.arange(n)))}
    assert set(kinds) <= {"rate", "jitter"} and "rate" in kinds


def test_an_hour_with_knocks_is_quick():
    """220,000 rows: a second or two of processor time; ten leave room for a busy machine."""
    import time

    x, rate = still(220_000, 60.0)
    for at in range(3000, 215_000, 1500):
        x[at : at + 12] += 30 * np.r_[[2e-3] * 3, [1.5e-2] * 3] * np.hanning(12)[:, None]
    started = time.process_time()
    found = find(x, rate)
    assert time.process_time() - started < 10.0
    assert len([f for f in found if f.kind == "disturbance"]) == len(range(3000, 215_000, 1500))


@pytest.mark.parametrize(
    ("step", "digits"), [(6.011749187749879e-3, 18), (1e-2 / 3, 18), (6e-3, 18), (3.23855e-4, 7)]
)
def test_zero_is_a_level_of_the_coarsest_grid(step, digits):
    """Five levels, of which the noise reaches 0 now and then: no drop-out, whatever the last digit
    of their distances, and where they are printed so that these differ.
    """
    x = step * np.rint(1.4 + 0.4 * np.random.default_rng(4).standard_normal(60_000))
    x = np.round(x, digits)
    x[1000] = -step
    share = np.mean(x == 0)
    assert 1e-4 < share < 0.02
    assert not [f for f in faults.find(Record({"gyro_x": x}, 100.0)) if f.kind == "dropout"]


def test_a_knock_between_chance_samples_is_as_long_as_it_is():
    """Means of seconds see it too; a single large sample seconds before is the noise's. It rings
    above half of the noise for 0.85 s; a window of a tenth and a margin of a twentieth come to it.
    """
    rng, n, fs = np.random.default_rng(11), 15_000, 50.0
    t = np.arange(n) / fs
    ring = np.where(t >= 120.3, np.exp(-np.clip(t - 120.3, 0, None) / 0.15), 0.0)
    ring *= np.sin(2 * np.pi * 9 * (t - 120.3))
    channels = {}
    for kind, sd, strength in (("gyro", 7e-4, 0.1), ("accel", 8e-3, 2.0)):
        for axis in "xyz":
            x = sd * rng.standard_normal(n)
            x[[5793, 6230]] += 4.3 * sd * (axis == "x")
            channels[f"{kind}_{axis}"] = x + strength * ring
    (found,) = [f for f in faults.find(Record(channels, fs)) if f.kind == "disturbance"]
    assert abs(found.start - 120.3) < 0.2 and found.stop - found.start < 1.1


def test_a_weak_knock_stands_out_on_one_channel_and_others_are_at_their_loudest():
    """Seven standard deviations on one axis of the gyroscope, four on two of the accelerometer, for
    a third of a second; the same on one channel alone, or at three times, is none.
    """
    rng, n, fs = np.random.default_rng(21), 14_400, 120.0
    noise = {
        c: rng.standard_normal(n) for c in ("gyro_x", "gyro_y", "accel_x", "accel_y", "accel_z")
    }
    u = np.arange(40) / fs
    ring = np.exp(-u / 0.15) * np.sin(2 * np.pi * 31 * u)
    names = []
    for times in ((54.8, 54.8, 54.8), (20.0, 54.8, 90.0)):
        x = {c: 1e-3 * y for c, y in noise.items()}
        for (c, size), time in zip({"gyro_y": 6.5, "accel_x": 3.5, "accel_z": 3.5}.items(), times):
            at = int(time * fs)
            x[c] = x[c].copy()
            x[c][at : at + 40] += 1e-3 * size * ring
        found = [f for f in faults.find(Record(x, fs)) if f.kind == "disturbance"]
        names.append([set(f.channels) for f in found])
    assert names[0] == [{"gyro_y", "accel_x", "accel_z"}]
    assert not any(len(channels) > 1 for channels in names[1])


def test_a_dead_zone_is_told_with_its_value_and_its_share():
    """Values below a threshold come out as 0; a grid, drop-outs of 0 and a rail are none of it."""
    rng, n = np.random.default_rng(31), 20_000
    x = rng.standard_normal((3, n))
    dead = {f"gyro_{a}": np.sign(v) * np.maximum(np.abs(v) - 0.5, 0.0) for a, v in zip("xyz", x)}
    (found,) = [f for f in faults.find(Record(dead, 100.0)) if f.kind == "dead_zone"]
    assert set(found.channels) == set(dead) and found.parameters["value"] == 0.0
    assert abs(found.parameters["fraction"] - 0.383) < 0.01 and "are exactly 0" in found.sentence
    others = {
        "gyro_x": 0.5 * np.rint(x[0] / 0.5),
        "gyro_y": np.where(rng.random(n) < 0.05, 0.0, x[1] + 9.0),
        "gyro_z": np.minimum(x[2], 0.7),
    }
    assert not [f for f in faults.find(Record(others, 100.0)) if f.kind == "dead_zone"]


@pytest.mark.parametrize("on", [["accel_z"], CHANNELS])
@pytest.mark.parametrize("first", [2000, 3500])
def test_what_stands_still_to_the_end_is_frozen_and_no_dead_zone(on, first):
    """Told with its times and masked, on one channel or all; the rest is used."""
    x, rate = still(n=6000)
    last = 5000 if first == 2000 else 6000
    for c in map(list(CHANNELS).index, on):
        x[first:last, c] = x[first, c]
    record = Record(dict(zip(CHANNELS, x.T)), rate)
    (found,) = faults.find(record)
    assert set(found.channels) == set(on) and "frozen output" in found.sentence
    assert np.array_equal(found.rows, np.arange(first + 1, last))
    health = of_record(record)
    assert all(health.channels[c].frozen == len(found.rows) for c in on)
    assert not any("shaken" in s or "dead zone" in s for s in health.findings)
    sound = faults.sound(record)
    assert abs(np.nanstd(sound.record["accel_z"]) / 1.5e-2 - 1) < 0.03
    assert sound.record.n == (first + 1 if len(on) > 1 and last == 6000 else 6000)
    masked, notes = standing.masked(record)
    assert np.isnan(masked["accel_z"]).sum() == len(found.rows) and len(notes) == 1
