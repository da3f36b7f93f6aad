"""The solutions of the exercises, executed: what a solution states as a number or a comparison is
computed here. Each test bears the label of its exercise.
"""

import re

import nbformat
import numpy as np
import pytest
from scipy.fft import dct

import imu_lib as imu
from conftest import ROOT
from imu_lib import (
    allan,
    autocorrelation,
    autoregressive,
    calibration,
    likelihood,
    published,
    spectrum,
    units,
    wavelet,
)
from imu_lib.book import chapters
from imu_lib.processes import (
    Flicker,
    GaussMarkov,
    LowPass,
    RandomWalk,
    Sinusoid,
    Sum,
    WhiteNoise,
)

#: Exercises whose solution is an argument in words, or needs a drive or a record that a test has not.
IN_WORDS = {
    "ex-acf-3", "ex-calibration-3", "ex-errata-3", "ex-gapreal-2", "ex-gapreal-3",
    "ex-gapscore-2", "ex-gapscore-3", "ex-outage-3", "ex-filter-2", "ex-filter-3", "ex-gap-1",
    "ex-gap-3", "ex-interval-2", "ex-real-2", "ex-recorded-signal-3", "ex-crosscheck-2",
}  # fmt: skip
ELSEWHERE = {"ex-interval-3", "ex-level-2", "ex-level-3"}  # in test_book_exercises_motion


def rng(seed):
    return np.random.default_rng(seed)


def allan_1():
    clusters = 1 / (2 * 0.1**2) + 1
    assert round(clusters, 9) == 51 and abs(clusters * 490 / 3600 - 7) < 0.1


def allan_3():
    """On a shorter draw of the twin's accelerometer x."""
    truth = imu.preset("3dm-gx3-25")["accel_x"]
    x = truth.simulate(360_000, 100.0, rng(1))
    fit = allan.fit(
        allan.deviation(x, 100.0),
        WhiteNoise() + Flicker() + RandomWalk(),
        shortest=0.02,
        filtered=True,
    )
    assert fit.p_value < 1e-6


def acf_1():
    assert round(autocorrelation.record_for(300.0, 0.05) / 3600) == 67


def acf_2():
    process = GaussMarkov(sigma=1.0, correlation_time=10.0)
    r = rng(4)
    x = process.simulate(20_000, 10.0, r)
    noisy = x + WhiteNoise(N=3.0).simulate(x.size, 10.0, r)
    fits = {
        b: autocorrelation.fit_gauss_markov(noisy, 10.0, block=b).correlation_time
        for b in (1, 4, 16, 64)
    }
    spans = {b: np.log(e.high / e.low) for b, e in fits.items() if e.shown and e.low > 0}
    assert max(spans, key=spans.get) == 1 and not fits[64].shown


def ar_1():
    model = autoregressive.from_gauss_markov(
        GaussMarkov(sigma=29.6 * units.DEG_PER_HOUR, correlation_time=491.0), 100.0
    )
    gap = 1 - model.phi[0]
    assert abs(gap / 2.04e-5 - 1) < 0.01
    assert 5e-7 / gap < 0.1 < 5e-6 / gap  # six decimals do, five do not


def ar_2():
    white = rng(13).standard_normal(200_000)
    printed = {4: (-2.37, 1.82, -0.44), 6: (-2.52, 2.06, -0.53), 8: (-2.58, 2.16, -0.58)}
    for levels, alpha in printed.items():
        smooth = wavelet.denoise(white, levels, threshold="approximation")
        assert np.allclose(autoregressive.fit(smooth, 3).alpha, alpha, atol=0.03)


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
    study = __import__("json").loads((ROOT / "benchmarks/results/outages_turin.json").read_text())
    entry = study["sensors"]["calibrated"]
    ratio = (
        entry["60 s"]["models"]["18AV"]["median"][0] / entry["30 s"]["models"]["18AV"]["median"][0]
    )
    assert 4.5 < ratio < 7.0


def outage_2():
    assert [round((1.96 * s / np.log(1.05)) ** 2, -1) for s in (0.3, 1.0)] == [150, 1610]


def likelihood_1():
    truth = WhiteNoise(N=1.0)
    widths = []
    for n in (20_000, 80_000):
        found = likelihood.fit(truth.simulate(n, 10.0, rng(n)), 10.0, WhiteNoise())["N"]
        widths.append(found.high - found.low)
    assert abs(widths[0] / widths[1] - 2) < 0.2


def likelihood_3():
    walk = RandomWalk(K=np.sqrt(2 / 9000.0))
    slow = GaussMarkov(sigma=1.0, correlation_time=9000.0)
    f = np.arange(3, 100) / (2 * 7200.0)  # from the third coefficient of two hours on
    assert np.max(np.abs(slow.psd(f) / walk.psd(f) - 1)) < 0.01 * 7


def np_1():
    assert abs(2.4 / 60 * 10 - 0.4) < 1e-9 and abs(2.4 / np.sqrt(60) - 0.31) < 0.005


def np_2():
    f = np.array([0.05, 0.5])
    found = GaussMarkov(sigma=0.02 * np.sqrt(50), correlation_time=100.0).psd(f)
    assert np.allclose(found / RandomWalk(K=0.02).psd(f), 1, atol=0.01)


def np_3():
    parts = Sum(tuple(GaussMarkov(sigma=1.0, correlation_time=t) for t in (1, 10, 100, 1000)))
    inner = np.sqrt(parts.avar(np.geomspace(10, 1000, 200)))
    assert 0.01 < inner.max() / inner.min() - 1 < 0.12


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


def spectrum_1():
    assert 0.03 * 60 == pytest.approx(1.8)
    assert 2 * (0.03 * 3600) ** 2 == pytest.approx(2.33e4, rel=2e-3)


def spectrum_2():
    model = imu.preset("3dm-gx3-25")["gyro_x"]
    x = model.simulate(1_200_000, 100.0, rng(2))
    found = {}
    for power in (14, 17, 20):
        averaged = spectrum.average(spectrum.welch(x, 100.0, segment=2**power))
        found[power] = (spectrum.read_off(averaged)["N"].value, averaged.f[0])
    values = [n for n, _ in found.values()]
    assert np.ptp(values) / np.mean(values) < 0.03
    assert found[20][1] < 1e-3 < found[14][1]


def spectrum_3():
    folded = {
        k: np.sqrt(
            (WhiteNoise(N=1.0) + LowPass(taps=k, rate=1000.0)).psd(np.array([0.01]), 100.0)[0] / 2
        )
        for k in (15, 20)
    }
    assert abs(folded[20] - 1) < 0.01 < folded[15] - 1
    assert (
        abs(1 - np.sqrt(LowPass(taps=20, rate=1000.0).gain(np.array([20.0]), 100.0))[0] - 0.24)
        < 0.02
    )


def filter_1():
    b, t = 30 * units.DEG_PER_HOUR, 30.0
    assert abs(b * t / 2 * 15 * t - 1.0) < 0.05 and abs(9.81 * b * t**3 / 6 - 6.4) < 0.05


def interval_1():
    rows = {r.interval_s: r.ar4_m[2] for r in published.UPDATE_INTERVALS_2008}
    assert abs(rows[30] / rows[10] - 5.4) < 0.1


def wd_1():
    assert wavelet.span(200.0, 8) == pytest.approx(wavelet.span(100.0, 7), rel=0.01)
    assert wavelet.bands(200.0, 8)[-1].high == pytest.approx(wavelet.bands(100.0, 7)[-1].high)


def wd_2():
    x = imu.preset("3dm-gx3-25")["accel_z"].simulate(200_000, 100.0, rng(3))
    first, each = (
        wavelet.thresholds(x - x.mean(), 8, noise=noise).kept
        for noise in ("first_level", "per_level")
    )
    assert np.mean(first[3:]) > 3 * np.mean(each[3:])


def wd_3():
    edge = wavelet.edge_response(7, window=4096)
    assert abs(1 / edge.noise_gain**2 - 4) < 0.5 and abs(edge.delay - 4.4) < 0.1


def likelihood_2():
    """The cosine coefficients of a random walk, exactly."""
    n = 60
    walk = np.minimum.outer(np.arange(1.0, n + 1), np.arange(1.0, n + 1))  # K = 1, steps of 1 s
    cosines = dct(dct(walk, norm="ortho", axis=0), norm="ortho", axis=1)[1:, 1:]
    p = np.arange(1, n)
    assert np.allclose(cosines, np.diag(1 / (4 * np.sin(np.pi * p / 2 / n) ** 2)), atol=1e-9)


def allan_2():
    bare = WhiteNoise(N=1.8) + GaussMarkov(sigma=1.0, correlation_time=100.0)
    read, fitted = [], []
    for seed in (11, 12, 13):
        curve = allan.deviation(bare.simulate(720_000, 10.0, rng(seed)), 10.0)
        flat, fit = allan.read_off(curve), allan.fit(curve, WhiteNoise() + GaussMarkov())
        read.append(2 * (0.664 * flat["B"].value) ** 2 / flat.correlation_time.value / 0.02)
        fitted.append(2 * fit["sigma"].value ** 2 / fit["correlation_time"].value / 0.02)
    assert read[0] > 0.8 and all(0.16 < r < 0.26 for r in read[1:])
    assert all(0.85 < f < 1.15 for f in fitted)  # 4 % is one standard error


def ar_3():
    x, read = imu.twin()["gyro_x"], []
    for seconds in (0.1, 1, 10, 60, 200, 600):
        means = x.reshape(-1, round(100 * seconds)).mean(axis=1)
        phi = autoregressive.fit(means - means.mean(), 1).phi[0]
        read.append(-seconds / np.log(phi))
    assert read[0] < 0.05 and read == sorted(read) and read[3] < 280 and read[-1] > 2 * 280


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


SOLVED = {
    name: check
    for name, check in list(globals().items())
    if re.fullmatch(r"(?!test_)[a-z_]+_[123]", name) and callable(check)
}


@pytest.mark.parametrize("name", SOLVED)
def test_solution(name):
    SOLVED[name]()


def test_every_exercise_is_graded_and_solved_or_argued():
    labels = {}
    for chapter in chapters.chapters(ROOT):
        for cell in nbformat.read(chapter.path, as_version=4).cells:
            for label, text in re.findall(
                r"```\{exercise\}\n:label: ([\w-]+)\n\s*(.{8})", cell.source
            ):
                labels[label] = chapter.slug
                assert text.startswith(("(Easy.)", "(Medium", "(Hard.)")), label
    solved = {f"ex-{name.replace('_', '-')}" for name in SOLVED} | ELSEWHERE
    covered = solved | IN_WORDS
    assert not solved & IN_WORDS and covered <= set(labels)
    # a chapter whose exercises nobody has looked at here has tests of its own
    open_ones = {slug for label, slug in labels.items() if label not in covered}
    assert not open_ones & {labels[label] for label in covered}
