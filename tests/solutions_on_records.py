"""Solutions of exercises on records, calibration, navigation and the gap, executed by
`test_book_exercises`: each bears the label of its exercise.
"""

import json

import numpy as np
import pytest
from scipy.stats import binomtest, chi2, linregress, norm, t

import imu_lib as imu
from conftest import ROOT
from imu_lib import allan, calibration, datasets, gap, likelihood, published, timing, units, wavelet
from imu_lib.fleet.spread import of_units
from imu_lib.gap.effects.noise_level_change import unsteady
from imu_lib.gap.residual_tests import distribution
from imu_lib.processes import RandomWalk, Sinusoid, WhiteNoise


def rng(seed):
    return np.random.default_rng(seed)


def calibration_1():
    half = calibration.repeatability(rng(1).normal(size=50)).sd
    assert abs((half.high - half.low) / 2 / half.value - 0.2) < 0.03


def calibration_2():
    truth = calibration.triad((0.004, -0.003, 0.006), (0.05, -0.1, 0.2), {})
    directions = rng(3).standard_normal((40, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    means = 9.80665 * directions @ truth.matrix.T + truth.bias
    means += 1e-4 * rng(5).standard_normal(means.shape)

    calibration.from_gravity(means)
    with pytest.raises(imu.InputError, match="accel_z"):
        calibration.from_gravity(means[directions[:, 2] > 0])


def crosscheck_1():
    n = 2.2 * units.DEG_PER_SQRT_HOUR
    assert abs(n * 10 / units.DEG_PER_S - 0.37) < 0.005
    assert abs(n / np.sqrt(0.015) / units.DEG_PER_S - 0.30) < 0.005


def crosscheck_3():
    assert abs(0.617**2 / 1.893 - 0.20) < 0.002


def errata_1():
    assert abs(published.FLAT_2013["accel_z"][0] / 1.893 - 11) < 0.1


def errata_2():
    sds = [RandomWalk(K=1.0).simulate(1000, 1000.0, rng([2, k])).std() for k in range(2000)]
    assert np.allclose(np.quantile(sds, (0.025, 0.975)), (0.17, 0.77), atol=0.03)
    assert abs(np.sqrt(np.mean(np.square(sds))) - 0.41) < 0.02


def gapscore_1():
    assert abs(1.96**2 / (300 + 1.96**2) - 0.0126) < 1e-3


def outage_1():
    study = json.loads((ROOT / "benchmarks/results/outages_turin.json").read_text())
    entry = study["sensors"]["calibrated"]
    ratio = (
        entry["60 s"]["models"]["18AV"]["median"][0] / entry["30 s"]["models"]["18AV"]["median"][0]
    )
    assert 4.5 < ratio < 7.0


def outage_2():
    assert [round((1.96 * s / np.log(1.05)) ** 2, -1) for s in (0.3, 1.0)] == [150, 1610]


def real_1():
    hours = {"adis": 2.78, "mpu": 0.182}
    assert abs(200 * 300 / 3600 - 16.7) < 0.1
    assert round(hours["adis"] * 3600 / 300) == 33 and round(hours["mpu"] * 3600 / 300) == 2
    assert abs(np.sqrt(2 / 33) - 0.25) < 0.01


def real_3():
    line = Sinusoid(amplitude=1.0, frequency=5.0)
    tau = np.array([0.1, 0.9, 8.1])  # where the line is at its largest
    assert np.allclose(line.avar(tau), 1 / (np.pi * 5.0 * tau) ** 2 * 1.0, rtol=1e-6)


def recorded_signal_1():
    step = 500 / 65536
    n = step / np.sqrt(12 * 100)
    assert abs(step - 0.00763) < 1e-5 and abs(n * 60 - 0.013) < 5e-4


def recorded_signal_2():
    record = imu.read_record(ROOT / "data/gx3_25_one_minute.csv")
    assert abs(record.n / 100 - 59.95) < 1e-9


def filter_1():
    b, t = 30 * units.DEG_PER_HOUR, 30.0
    assert abs(b * t / 2 * 15 * t - 1.0) < 0.05 and abs(9.81 * b * t**3 / 6 - 6.4) < 0.05


def interval_1():
    rows = {r.interval_s: r.ar4_m[2] for r in published.UPDATE_INTERVALS_2008}
    assert abs(rows[30] / rows[10] - 5.4) < 0.1


def gap_2():
    """The gain of a line, and the largest that noise alone reaches among the frequencies."""
    n, amplitude, level = 180_000, 0.01, 2e-2  # one-sided density at 100 Hz
    sd = np.sqrt(level * 50.0)
    wave = amplitude * np.sin(2 * np.pi * 24.7 * np.arange(n) / 100.0)
    closed = amplitude**2 * (n / 100.0) / (2 * level)
    assert np.sum(wave**2) / (2 * sd**2) == pytest.approx(closed, rel=1e-3)
    noise = np.abs(np.fft.rfft(rng(1).standard_normal(n)))[1:-1] ** 2 / n
    assert 10 < noise.max() < 17 and abs(np.log(len(noise)) - 11.4) < 0.1  # about 12, a few more


def gapreal_1():
    """Differences do not see the mean: a record and one shifted by gravity have the same steps."""
    x = rng(2).standard_normal(1000)
    assert np.allclose(np.diff(x + 9.8), np.diff(x), atol=1e-12)


def level_1():
    assert wavelet.level_for_band(2.0, 400.0) == 6 and wavelet.level_for_band(2.0, 100.0) == 4


def calibration_3():
    """The slope of runs 5 to 10 against its own standard error: four degrees of freedom."""
    later = np.array(published.GYRO_RUNS_2008.bias_deg_s[4:])
    line = linregress(np.arange(6), later)
    assert len(later) - 2 == 4 and line.pvalue > 0.05


def errata_3():
    """Both ratios with an interval, which seven outages make wide."""
    worst = published.outage_errors_2013("max")
    ratio = np.array(worst["18AVWD"]) / np.array(worst["15AR"])
    half = t.ppf(0.975, 6) * np.log(ratio).std(ddof=1) / np.sqrt(7)
    assert np.exp(2 * half) > 2.5  # from the lower end to the upper


def gapscore_2():
    """A gain of 1.9 is the 5 % test of one place; twenty is that of a record of six channels."""
    assert abs(chi2.sf(2 * 1.92, 1) - 0.05) < 1e-3
    places = 6 * 20 * 1000
    assert places * chi2.sf(2 * 1.92, 1) > 1000 and places * chi2.sf(2 * 20, 1) < 0.05


def outage_3():
    """On the calibrated sensor 15AV and 18AV are alike, as mounted they are not."""
    sensors = json.loads((ROOT / "benchmarks/results/outages_turin.json").read_text())["sensors"]
    ratio = {
        name: entry["30 s"]["models"]["15AV"]["median"][0]
        / entry["30 s"]["models"]["18AV"]["median"][0]
        for name, entry in sensors.items()
    }
    assert abs(ratio["calibrated"] - 1) < 0.1 and ratio["as mounted"] > 4


def real_2():
    if not datasets.available("adis16405_2"):
        pytest.skip("adis16405_2 is not at hand")
    record = datasets.load("adis16405_2")
    found = likelihood.Statistics.of(record["accel_x"], record.rate, exclude_lines=True).lines
    assert abs(found[0][0] / 0.564 - 1) < 0.05


def recorded_signal_3():
    """One sample taken out of stamps of which some are punctual is found; late stamps are none."""
    r = rng(2024)
    stamps = np.arange(4000) / 100.0
    late = np.where(r.random(4000) < 0.02, r.exponential(0.025, 4000), 0.0)
    busy = np.maximum.accumulate(stamps + late) + 1e-9 * np.arange(4000)
    for removed, missing in (([], 0), ([1500], 1)):
        left = np.delete(busy, removed)
        slot = timing.slots(left, 100.0)
        assert sum(gap.missing for gap in timing.gaps(left, slot, 100.0)) == missing


def crosscheck_2():
    """Ten methods that see the same data miss together: half a miss on average, rarely one alone."""
    same = np.abs(rng(1).standard_normal(20_000)) > 1.96
    misses = 10 * same  # all ten, or none
    assert abs(misses.mean() - 0.5) < 0.03 and set(misses) == {0, 10}


def drivescore_1():
    assert abs(1 - 0.025 ** (1 / 20) - 0.168) < 5e-4


def drivescore_2():
    assert 1 - 0.025 ** (1 / 122) < 0.03 < 1 - 0.025 ** (1 / 121)


def fleet_short():
    """A sixth of the record: standard errors times the root of six."""
    model, errors = WhiteNoise(N=2e-4), []
    for n in (14_400, 2_400):
        found = likelihood.fit(model.simulate(n, 20.0, rng(n)), 20.0, WhiteNoise())["N"]
        errors.append((found.high - found.low) / found.value)
    assert abs(errors[1] / errors[0] - np.sqrt(6)) < 0.3
    # logarithms of forty units: scatter 0.15 known to 0.6 %, then 0.3 known to 23 %
    for tau, error, grows in ((0.15, 0.006, False), (0.3, 0.23, True)):
        units_, noise = rng(38).standard_normal((2, 40))
        plain, width = [], []
        for s in (error, error * np.sqrt(6)):
            c = np.exp(tau * units_ + s * noise)
            found = of_units(c, c * np.exp(-1.96 * s), c * np.exp(1.96 * s)).scatter
            assert found.covers(tau)
            plain.append(np.log(c).std())
            width.append(found.high - found.low)
        assert (plain[1] > 1.4 * plain[0]) == grows and (width[1] > 1.2 * width[0]) == grows


def fleet_few():
    """Bounds above the typical value, for ten units and for four of the same scatter."""
    above = {}
    for units_ in (4, 10):
        c = np.exp(0.15 * norm.ppf((np.arange(units_) + 0.5) / units_))
        found = of_units(c, 0.99 * c, 1.01 * c)
        above[units_] = found.worst / found.typical.value
    assert 1.3 < above[10] < 1.7 and above[4] > 1.5 * above[10]


def recorded(name):
    if not datasets.available(name):
        pytest.skip(f"the record {name} is not at hand")
    return datasets.load(name)


def gapreal_2():
    """The steps of the output and what the clock does are in both halves, the warming in the first."""
    desk = recorded("mpu6050_10min")
    halves = [
        gap.close(desk.slice(a, a + 300.0), simulations=0, jobs=1, channels=["accel_z"])
        for a in (0.0, 300.0)
    ]
    first, second = ({step.effect for _, step in half.steps} for half in halves)
    assert {"resolution", "jitter"} <= first & second
    assert first - second and first - second <= {"temperature", "warm_up", "step", "ramp"}


def gapreal_3():
    """Steps of the output and filter belong to the unit; another axis has other parameters."""
    record = recorded("adis16405_1").continuous().slice(600.0, 840.0)
    unit = gap.close(record, simulations=0, jobs=1, channels=["gyro_x"])
    other = imu.Record({"gyro_x": record["gyro_y"]}, record.rate)
    found = [step for _, step in gap.close(other, unit.model, simulations=0, jobs=1).steps]
    assert {"resolution", "low_pass"} <= {step.effect for _, step in unit.steps}
    assert not {"resolution", "low_pass"} & {step.effect for step in found}
    noise = next(s.parameters for s in found if s.parameters.get("process") == "white_noise")
    assert 1.04 < noise["to"] / noise["from"] < 1.09


def gap_1():
    """What alters single samples hardly moves the Allan curve, and changes which values occur."""
    x = rng(31).standard_normal(100_000)
    frozen = x.copy()
    at = np.flatnonzero(rng(32).random(x.size) < 0.005)
    frozen[np.minimum(at + 1, x.size - 1)] = x[at]
    thrown = x + (rng(33).random(x.size) < 2e-4) * 15.0 * rng(34).standard_normal(x.size)
    altered = (np.round(x / 0.6) * 0.6, np.clip(x, -2.4, 2.4), frozen, thrown)
    values = (
        lambda y: np.unique(y).size / y.size,
        lambda y: np.abs(y).max(),
        lambda y: np.mean(np.diff(y) == 0),
        lambda y: np.abs(y).max(),
    )
    curve = allan.deviation(x, 100.0).adev
    for y, value in zip(altered, values):
        moved = np.abs(allan.deviation(y, 100.0).adev / curve - 1)
        assert np.median(moved) < 0.03
        before, after = value(x), value(y)
        assert after < 0.7 * before or after > before + 0.004, (before, after)


def gap_3():
    """The gain of a jump goes with the product of both durations over their sum."""
    n, noise = 1800, rng(35).standard_normal(1800)
    gains = []
    for time in (710, 1700):
        y = noise + 3.0 * (np.arange(n) >= time)
        parts = y[:time], y[time:]
        gain = 0.5 * (y.var() * n - sum(p.var() * p.size for p in parts))
        assert abs(gain / (0.5 * 9.0 * time * (n - time) / n) - 1) < 0.1
        gains.append(gain)
    assert gains[1] < 0.3 * gains[0] and 0.6 * n < 1700


def gapscore_3():
    """An hour at 100 Hz shows a per cent of bend or of swelling, and seldom a thousandth."""
    t = np.arange(360_000) / 100.0
    seen = {}
    for depth in (0.01, 0.001):
        found = []
        for k in range(4):
            x = rng([36, k]).standard_normal(t.size)
            bent = x + depth * (x * x - 1)
            swelling = x * (1 + depth * np.sin(2 * np.pi * t / 600.0))
            found.append(min(check.log_p for check in distribution(bent)) < -4)
            found.append(unsteady(swelling, 100.0)[0] < -4)
        seen[depth] = np.mean(found)
    assert seen[0.01] > 0.5 > seen[0.001]


def fleet_cover():
    """The share of intervals that hold, with its interval: 95 per cent lies inside."""
    truth, held = {"N": 2e-4, "K": 1e-5}, []
    model = WhiteNoise(N=truth["N"]) + RandomWalk(K=truth["K"])
    for k in range(40):
        found = likelihood.fit(
            model.simulate(18_000, 20.0, rng([37, k])), 20.0, WhiteNoise() + RandomWalk()
        )
        held += [found[name].covers(value) for name, value in truth.items()]
    low, high = binomtest(int(np.sum(held)), len(held)).proportion_ci(0.95)
    assert low < 0.95 < high
