"""Lines among all frequencies: how many chance makes, from which gain on one is told, and how well
its frequency is known.
"""

import numpy as np
import pytest

from imu_lib.gap.data import Data
from imu_lib.gap.effects.sinusoid import LEAST_GAIN, Sinusoid, occam, threshold
from imu_lib.gap.state import MIN_EVIDENCE

FS = 100.0


def by_chance(gain, n):
    """Maxima of the continuous periodogram of `n` samples of noise that reach a `gain` (Rice 1944;
    Baluev 2008, Eq. 6): their mean number.
    """
    return 0.5 * n * np.sqrt(np.pi / 3 * gain) * np.exp(-gain)


def test_chance_makes_no_more_lines_than_rice_foretells():
    rng, n, records, least = np.random.default_rng(1), 8192, 120, 9.0
    gains = []
    for _ in range(records):
        found, _ = Sinusoid().find(Data(rng.standard_normal(n), FS), least=least)
        gains += [f.gain for f, _ in found]
    for gain in (9.0, 10.0, 11.0):
        expected = records * by_chance(gain, n)
        count = np.sum(np.array(gains) >= gain)
        # near the least gain of the search a louder place may hide the next; of a density that is
        # known from 2 x 400 ordinates a gain g is exceeded exp(g^2 / 1600) times as often
        assert 0.4 * expected < count < 1.1 * expected + 3 * np.sqrt(expected)


@pytest.mark.parametrize("n", [2_000, 60_000, 360_000, 8_640_000])
def test_a_line_is_told_where_its_evidence_is_that_of_any_effect(n):
    gain = threshold(n)
    assert gain >= LEAST_GAIN
    assert gain + occam(gain, n) > MIN_EVIDENCE - 1e-6
    assert by_chance(gain, n) < 2e-4


def test_the_interval_of_a_frequency_is_as_wide_as_its_scatter():
    rng, n, off = np.random.default_rng(2), 4096, []
    t = np.arange(n) / FS
    for _ in range(80):
        f = rng.uniform(5.0, 45.0)
        amplitude = np.sqrt(4.0 * 60.0 / n)  # a gain of 60 in noise of variance 1
        x = amplitude * np.sin(2 * np.pi * f * t + rng.uniform(0, 6)) + rng.standard_normal(n)
        ((found, _), *_), _ = Sinusoid().find(Data(x, FS))
        low, high = found.intervals["frequency"]
        off.append((found.process.frequency - f) / ((high - low) / 3.92))
    # 80 draws: a scatter of 8 %, three times that
    assert abs(np.std(off) - 1) < 0.24


@pytest.mark.parametrize("walk", [0.0, 0.5])
def test_a_slow_line_stands_out_beside_a_walk(walk):
    """Just above the first ordinate that is searched, with half again the gain that a line needs:
    before the mean of its surroundings was that of a power law, none of 40 was found beside a walk.
    """
    rng, n, found, cycles = np.random.default_rng(3), 36_000, 0, 33.4
    fs, turn = 20.0, 2 * np.pi * cycles / n
    density = 2 / fs * (1.0 + (walk / turn) ** 2)
    amplitude = np.sqrt(2 * fs * density * 1.5 * LEAST_GAIN / n)
    for _ in range(20):
        x = rng.standard_normal(n) + walk * np.cumsum(rng.standard_normal(n))
        x += amplitude * np.sin(turn * np.arange(n) + rng.uniform(0, 6))
        lines, _ = Sinusoid().find(Data(x, fs))
        found += any(abs(f.process.frequency * n / fs - cycles) < 2 for f, _ in lines)
    assert found >= 12  # 20 draws of a share of 0.8
