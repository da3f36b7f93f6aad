"""The gains that benchmarks reckon for what they put in are those of the likelihood."""

import sys
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).resolve().parents[1] / "benchmarks"))
import gap_put
import gap_strange

FS, N = 100.0, 20_000


def test_gains_in_white_noise_are_half_the_squared_distance():
    """Half the squared signal-to-noise ratio: of a sinusoid n a^2 / 4 sd^2, of a ramp and a step
    about their means. The spectrum is read off twelve ordinates at the lowest frequencies, to a
    third; the median of sixteen records to a tenth.
    """
    t = np.arange(N) / FS
    drawn = [np.random.default_rng([3, k]).standard_normal(N) for k in range(16)]
    made = [gap_put.Stretch(x, FS) for x in drawn]
    for signal in (np.sin(2 * np.pi * 7.3 * t), t / t[-1], (t > 90.0) * 1.0):
        want = 0.5 * np.sum((signal - signal.mean()) ** 2)
        ratio = np.median([s.of_shape(signal) for s in made]) / want
        assert abs(ratio - 1) < 0.25
    s = made[0]
    # white noise of a quarter of the power, in every ordinate: ln 1.25 less than 0.25
    gain = s.of_noise(lambda f: np.full(f.shape, 0.25 * 2 / FS))
    assert abs(gain / (N / 2 * (0.25 - np.log(1.25))) - 1) < 0.1


def test_every_effect_goes_into_records_that_nobody_has_seen():
    for k, effect in enumerate(gap_put.EFFECTS):
        rng = np.random.default_rng([5, k])
        fs, channels = gap_strange.record(k, six=True)
        n = len(channels["gyro_x"])
        out, on, gain, _ = gap_put.put(effect, channels, fs, "gyro_y", rng, np.linspace(20, 25, n))
        assert set(on) <= set(channels) and gain > 0
        moved = {c for c in channels if len(out[c]) != n or np.any(out[c] != channels[c])}
        assert moved <= set(on) and (moved or effect == "saturation")
