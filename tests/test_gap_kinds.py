"""Kinds that records showed: a jump under a knock's mask, few jumps of two levels, folds of the
mains, an output that stands still, a noise that grows all the time.
"""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import signal

from imu_lib import faults, timing
from imu_lib.faults import Finding
from imu_lib.gap import knock_jumps
from imu_lib.gap.channel import ChannelResult, analyse
from imu_lib.gap.effects.jitter import Jitter
from imu_lib.gap.effects.step import sharpen
from imu_lib.gap.effects.vibration import VIBRATION
from imu_lib.gap.fault_masking import ready
from imu_lib.gap.sentences import absorbed, data_faults
from imu_lib.gap.steps import Step
from imu_lib.model import Model
from imu_lib.processes import Sum, WhiteNoise
from imu_lib.record import Record
from imu_lib.samples.uneven import uneven
from imu_lib.vibrations import mains

FS, N, SD = 100.0, 20_000, 1e-3


def noise(seed, n=N):
    return SD * np.random.default_rng(seed).standard_normal(n)


def test_an_edge_under_a_mask_may_be_anywhere_in_it():
    """The level jumps with the knock; what is masked of that tells nothing of when."""
    x, missing = noise(1, 6000), np.zeros(6000, bool)
    missing[3095:3150] = True
    x[3100:] += 4 * SD
    time, low, high = sharpen(x, FS, 31.2, 4.0, 4 * SD, SD**2 / FS, missing=missing)
    assert low <= 30.95 and high >= 31.5 and 30.9 < time < 31.55
    time, low, high = sharpen(x, FS, 31.2, 4.0, 4 * SD, SD**2 / FS)
    assert low <= 31.0 <= high and high - low < 0.2


@pytest.mark.parametrize("size", [0.6, 4.0])
def test_the_interval_of_a_jump_holds_it_beside_a_mask_and_its_cause_is_told(size):
    x = noise(2, 6000)
    x[3100:] += size * SD
    x[3095:3150] = np.nan
    result = analyse("gyro_z", x, FS, None)
    (step,) = [s for s in result.steps if s.effect == "step"]
    low, high = step.intervals["time"]
    assert low <= 31.0 <= high
    knock = Finding("disturbance", ("gyro_z",), 30.95, 31.5, {}, {}, "")
    about = SimpleNamespace(ready=SimpleNamespace(findings=(knock,), start=0.0))
    (step,) = [
        s
        for s in knock_jumps.with_causes({"gyro_z": result}, about)["gyro_z"].steps
        if s is not step
    ]
    assert step.where.endswith("with the knock at 30.95 s") and "knock" in step.cause
    assert "with the knock there" in data_faults.sentence(
        [("gyro_z", replace(step, confidence=1.0))], 0.9
    )


def levels(values):
    """Noise on levels of equal length, in standard deviations."""
    return noise(3) + SD * np.repeat(values, N // len(values))


def test_few_flips_between_two_levels_may_be_as_many_steps():
    found = analyse("gyro_x", levels([0, 0.6, 0, 0.6, 0]), FS, Sum((WhiteNoise(SD / FS**0.5),)))
    (step,) = found.steps
    assert step.effect == "telegraph" and "step" in step.indistinguishable
    # four flips come back three times: 4/5, as often right as such weights were
    assert 0.7 < step.confidence < 0.9 and step.where.endswith(", at 40, 80, 120 and 160 s")
    told = data_faults.sentence([("gyro_x", step)], 0.9)
    assert "or so many steps, at 40, 80, 120 and 160 s" in told


def test_levels_that_never_come_back_are_steps():
    found = analyse(
        "gyro_x", levels([0, 0.7, 0.2, 1.1, -0.4]), FS, Sum((WhiteNoise(SD / FS**0.5),))
    )
    assert {s.effect for s in found.steps} == {"step"} and len(found.steps) == 4


def test_where_the_sampling_folds_the_mains_to():
    assert timing.folded(150.0, 128.0) == pytest.approx(22.0)
    assert mains.unfolded(10.02, 60.0) == pytest.approx(49.98)
    assert mains.unfolded(50.1, 500.0) == pytest.approx(50.1)
    assert mains.unfolded(23.0, 500.0) is None
    assert mains.hint(40.02, 100.0) == "60 Hz, the mains, folds to there at 100 samples a second"
    assert "3 times the mains" in mains.hint(22.05, 128.0) and mains.hint(27.0, 128.0) == ""


@pytest.mark.parametrize("fs", [60.3, 128.0])
def test_the_folds_of_the_mains_are_its_own(fs):
    n, f0, rng = 40_000, 49.98, np.random.default_rng(4)
    t = np.arange(n) / fs
    raw = {c: SD * rng.standard_normal(n) for c in ("gyro_x", "gyro_y", "accel_z")}
    for k, a in ((1, 0.3), (3, 0.2), (5, 0.15)):
        for c in ("gyro_x", "gyro_y"):
            raw[c] = raw[c] + a * SD * np.sin(2 * np.pi * k * f0 * t + k)
    view = SimpleNamespace(record=None, raw=raw, fs=fs, temperature=None, model=None)
    (item,) = VIBRATION.candidates(view)
    assert item.process.frequency == pytest.approx(f0, abs=0.02)
    assert np.flatnonzero(item.process.shape).tolist() == [0, 2, 4]
    assert "folds" in item.where and set(item.process.channels) == {"gyro_x", "gyro_y"}


def test_an_output_that_stood_still_is_simulated_where_it_was():
    rng = np.random.default_rng(5)
    raw = {c: SD * rng.standard_normal(N) for c in ("gyro_x", "gyro_y", "accel_z")}
    for c in ("gyro_x", "gyro_y"):
        raw[c][5000:6500] = raw[c][5000]
    raw["accel_z"][17_000:] = raw["accel_z"][17_000]
    found = ready(Record(raw, FS))
    spans = {tuple(p.channels): (p.start, p.stop) for p in found.processes}
    assert spans == {("gyro_x", "gyro_y"): (50.01, 65.0), ("accel_z",): (170.01, 200.0)}
    assert all(s.effect == "dropout" and "frozen output" in s.where for s in found.steps)
    model = Model(
        channels={c: Sum((WhiteNoise(SD / FS**0.5),)) for c in raw}, record=found.processes, rate=FS
    )
    assert Model.from_json(model.to_json()) == model
    drawn = model.simulate(N, FS, np.random.default_rng(6))
    for c in raw:
        assert np.array_equal(np.diff(drawn[c]) == 0, np.diff(raw[c]) == 0)


def test_a_noise_that_grows_all_the_time_is_told_with_all_of_it():
    x = noise(7, 6000) * np.linspace(1.0, 2.5, 6000)
    (step,) = analyse("gyro_x", x, FS, None).steps
    p = step.parameters
    assert (p["time"], p["duration"]) == pytest.approx((0.0, 60.0))
    assert "from 0 to 60 s" in step.where and step.intervals["duration"][0] < 60.0


def test_what_a_fitted_base_may_hide_is_said_once():
    hidden = ["white_noise", "ramp", "warm_up", "parameter_change"]
    results = {
        c: ChannelResult(c, Sum(()), Sum(()), [], names, None)
        for c, names in (("gyro_x", hidden), ("gyro_y", hidden), ("accel_z", ["white_noise"]))
    }
    found = SimpleNamespace(channels={c: SimpleNamespace(result=r) for c, r in results.items()})
    text = absorbed.sentence(found)
    assert "a ramp (the mean drifts) and a warm-up on gyro_x and gyro_y: none is" in text
    assert "white" not in text and "--model" in text
    found.channels = {"accel_z": found.channels["accel_z"]}
    assert absorbed.sentence(found) == ""


def test_single_moments_are_told_with_their_times():
    x = noise(8)
    x[[4000, 9000, 15_000]] += 15 * SD
    (step,) = [s for s in analyse("accel_x", x, FS, None).steps if s.effect == "spikes"]
    told = data_faults.sentence([("accel_x", replace(step, confidence=1.0))], 0.9)
    assert "at 40.0, 90.0 and 150.0 s" in told
    stuck = Step("stuck", {"fraction": 0.01}, {}, "runs of equal values, at 3.0 s", 1.0, {}, [])
    assert "frozen on gyro_x, at 3.0 s" in data_faults.sentence([("gyro_x", stuck)], 0.9)


def shaken(size, at, decay=0.06):
    """Three channels of noise with a burst of 18 Hz at each time of `at`, s."""
    n, rng = 30_000, np.random.default_rng(9)
    raw = {c: rng.standard_normal(n) for c in ("gyro_x", "accel_x", "accel_z")}
    t = np.arange(40) / FS
    burst = np.exp(-t / decay) * np.sin(2 * np.pi * 18 * t)
    for when, a in zip(at, np.broadcast_to(size, len(at))):
        for c, share in (("gyro_x", 0.3), ("accel_x", 0.5), ("accel_z", 1.0)):
            first = int(when * FS)
            raw[c][first : first + 40] += a * share * burst
    return faults.find(Record(raw, FS))


@pytest.mark.parametrize("apart", [0.52, 0.75])
def test_the_steps_of_one_who_walks_by_are_one_event(apart):
    k = np.arange(24)
    rng = np.random.default_rng(10)
    at = 120.0 + apart * k + 0.02 * rng.standard_normal(24)
    found = [f for f in shaken(40 * np.exp(-(((k - 12) / 8) ** 2)), at) if f.kind == "disturbance"]
    (walk,) = found
    assert "as of footsteps" in walk.sentence and f"{1 / apart:.2g} a second" in walk.sentence
    assert walk.start == pytest.approx(at[2], abs=3.0) and walk.stop == pytest.approx(at[21], abs=3)
    # a few knocks at times of their own are so many knocks
    found = shaken(40.0, 120.0 + np.array([0.0, 3.1, 8.7, 20.2]))
    assert len(found) == 4 and not any("footsteps" in f.sentence for f in found)


def test_what_passes_is_one_event():
    n, rng = 30_000, np.random.default_rng(11)
    t = np.arange(n) / FS
    band = signal.butter(3, (8, 30), "band", fs=FS, output="sos")
    loud = 12.0 * np.exp(-(((t - 150) / 8) ** 2))
    raw = {
        c: rng.standard_normal(n) + loud * signal.sosfilt(band, rng.standard_normal(n))
        for c in ("gyro_x", "accel_x", "accel_z")
    }
    (passed,) = [f for f in faults.find(Record(raw, FS)) if f.kind == "disturbance"]
    assert "as of something that passes" in passed.sentence
    assert passed.start < 145 and passed.stop > 155


def test_a_converter_with_uneven_steps_is_no_unexplained_grid():
    """Widths that scatter by a quarter, about the noise: told, and nothing else is found."""
    rng = np.random.default_rng(13)
    edges = np.cumsum(1.0 + 0.25 * rng.standard_normal(60)) - 30.0
    x = np.searchsorted(edges, 2.5 * rng.standard_normal(N)) * 1e-3
    found = analyse("accel_x", x, FS, None)
    (step,) = found.steps
    assert step.effect == "resolution" and "uneven" in step.where and step.confidence > 0.9
    assert found.unexplained is None
    steps = uneven(x, 1e-3, 0.0)
    true = np.diff(edges)[steps.first : steps.first + len(steps.edges) - 1]
    seen = np.diff(steps.edges)
    middle = slice(4, -4)  # some hundred samples a level; the smooth density follows them a little
    assert np.corrcoef(seen[middle], true[middle])[0, 1] > 0.9
    assert uneven(np.rint(2.5 * rng.standard_normal(N)), 1.0, 0.0) is None


@pytest.mark.parametrize("seed", range(3))
def test_uneven_steps_leave_the_power_of_a_signal_as_it_is(seed):
    rng = np.random.default_rng(seed)
    edges = np.cumsum(np.tile([1.1, 1.05, 1.1, 0.75], 40)) - 80.0
    x = np.searchsorted(edges, 12.0 * rng.standard_normal(60_000)).astype(float)
    steps = uneven(x, 1.0, 0.0)
    before = np.sqrt(x.var() - steps.variance) * rng.standard_normal(400_000)
    # the variance of so many samples is known to 0.2 %
    assert steps.rounded(x.mean() + before).var() == pytest.approx(x.var(), rel=0.008)


@pytest.mark.parametrize("sd", [0.4, 1.0, 6.0])
def test_a_level_that_moves_between_two_temperatures_makes_no_steps_uneven(sd):
    """A thermostat: the signal dwells at many levels, and these are occupied as it dwells there."""
    rng = np.random.default_rng(29)
    t = np.arange(30_000) / 25.0
    level = 60.0 * np.sign(np.sin(t / 60)) * (1 - np.exp(-(t % 188) / 60)) + 20 * np.sin(t / 200)
    x = level + sd * rng.standard_normal(len(t))
    assert uneven(np.rint(x), 1.0, 0.0) is None
    # and where they are, the widths are as large as they are
    edges = np.cumsum(np.tile([1.3, 0.7], 100)) - 100.0
    seen = uneven(np.searchsorted(edges, 0.2 * level + x - level).astype(float), 1.0, 0.0)
    assert sd < 1.0 or seen.scatter == pytest.approx(0.3, abs=0.05)


def test_a_range_that_is_switched_is_said_and_makes_no_drop_outs():
    x = np.rint(20 * np.random.default_rng(14).standard_normal(N))
    x[13_000:] = 32 * np.rint(x[13_000:] / 32)
    found = analyse("gyro_x", 1e-5 * x, FS, None)
    assert "last 35 % of the record the steps are 32 times as wide" in found.unexplained
    other = np.random.default_rng(15).standard_normal(N)
    assert faults.find(Record({"gyro_x": 1e-5 * x, "gyro_y": other}, FS)) == ()


def test_two_streams_that_take_turns_are_said():
    x = noise(16)
    x[1::2] *= 1.25
    found = analyse("gyro_x", x, FS, None)
    assert "one sample in 2 is 1.2" in found.unexplained
    assert not [s for s in found.steps if s.confidence >= 0.5]


def test_a_clock_that_changes_its_rate_is_told_with_the_time():
    time = np.r_[np.arange(12_000) / 80.0, 150.0 + np.arange(8000) / 78.4]
    record = Record({"gyro_x": noise(17)}, 80.0, time=time)
    (changed,) = [f for f in faults.find(record) if f.kind == "rate"]
    assert changed.start == pytest.approx(150.0, abs=3.0)
    assert "from 80 to 78.4 Hz" in changed.sentence
    found = Jitter().detect(record)
    assert "changes its rate at 1" in found.doubt
