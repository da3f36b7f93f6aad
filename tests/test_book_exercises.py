"""The solutions of the exercises, executed: what a solution states as a number or a comparison is
computed here. Each test bears the label of its exercise.
"""

import re

import nbformat
import numpy as np
import pytest
import solutions_on_records
from scipy.fft import dct

import imu_lib as imu
from conftest import ROOT
from imu_lib import (
    allan,
    autocorrelation,
    autoregressive,
    likelihood,
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
    Sum,
    WhiteNoise,
)

#: Those in test_book_exercises_motion.
ELSEWHERE = {
    "ex-interval-2", "ex-interval-3", "ex-level-2", "ex-level-3", "ex-filter-2", "ex-filter-3",
    "ex-drivegap-1", "ex-drivegap-2", "ex-drivegap-3", "ex-drivescore-3",
}  # fmt: skip
GRADES = ["(Easy.)", "(Hard.)", "(Medium.)"]


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


def acf_3():
    """The fast process has the larger share here, and is the one that is reported."""
    both = (
        GaussMarkov(sigma=1.0, correlation_time=1.0),
        GaussMarkov(sigma=0.3, correlation_time=300.0),
    )
    x = (WhiteNoise(N=0.3) + both[0] + both[1]).simulate(72_000, 10.0, rng(1))
    found = autocorrelation.fit_gauss_markov(x, 10.0).correlation_time
    assert 0.7 < found.value < 1.4


SOLVED = {
    name: check
    for name, check in [*globals().items(), *vars(solutions_on_records).items()]
    if re.fullmatch(r"(?!test_)[a-z_]+_([123]|short|few|cover)", name) and callable(check)
}


@pytest.mark.parametrize("name", SOLVED)
def test_solution(name):
    SOLVED[name]()


def test_every_exercise_is_graded_and_solved():
    labels = set()
    for chapter in chapters.chapters(ROOT):
        text = "\n".join(cell.source for cell in nbformat.read(chapter.path, as_version=4).cells)
        found = re.findall(r"```\{exercise\}\n:label: ([\w-]+)\n\s*(\(\w+\.\))", text)
        assert sorted(grade for _, grade in found) == GRADES, chapter.slug
        solutions = re.findall(r"```\{solution\} ([\w-]+)\n:class: dropdown\n+(.+)", text)
        assert [name for name, _ in found] == [name for name, _ in solutions], chapter.slug
        labels |= {name for name, _ in found}
    names = {name.replace("_", "-") for name in SOLVED}
    solved = {n if n.startswith("fleet") else f"ex-{n}" for n in names} | ELSEWHERE
    assert solved == labels
