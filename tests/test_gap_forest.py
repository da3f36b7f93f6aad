"""Hundreds of lines are one finding, a strong line's skirts are its own, tails are seen on a coarse
grid.
"""

import numpy as np
import pytest
from scipy import signal

from imu_lib.gap.channel import analyse
from imu_lib.vibrations import forest, skirts

FS, N = 100.0, 40_000


def lattice(rng):
    """Frequencies m f1 + n f2 within the band, Hz."""
    m, n = np.meshgrid(np.arange(1, 25), np.arange(-3, 4))
    f = (m * 1.6947 + n * 0.0923).ravel()
    return rng.permutation(f[f < 45])[:120]


def test_a_forest_of_lines_is_found_and_taken_out_and_leaves_the_noise():
    rng = np.random.default_rng(3)
    t, raw, bare = np.arange(N) / FS, {}, {}
    lines = lattice(rng)
    for c in ("gyro_x", "gyro_y"):
        bare[c] = rng.standard_normal(N)
        raw[c] = bare[c] + 0.04 * np.sum(
            [np.sin(2 * np.pi * f * t + rng.uniform(0, 6)) for f in lines], axis=0
        )
    raw["accel_z"] = rng.standard_normal(N)
    found = forest.forest(raw, FS)
    assert found.channels == ("gyro_x", "gyro_y")
    assert found.count == pytest.approx(len(lines), abs=25)  # some lie on one another
    near = np.abs(found.frequencies[:80, None] - lines).min(axis=1)
    assert np.max(near) < 2 * FS / N
    assert np.median(found.amplitude) == pytest.approx(0.04, rel=0.25)
    calm = forest.felled(raw["gyro_x"], found, rng)
    assert np.var(calm) == pytest.approx(1.0, abs=0.03)  # the lines had a tenth more
    assert forest.forest({"gyro_x": calm}, FS) is None


def test_noise_and_a_loud_line_are_no_forest():
    rng = np.random.default_rng(4)
    x = signal.lfilter([1], [1, -0.6], rng.standard_normal(N))
    phase = 2 * np.pi * 21.0 * np.arange(N) / FS + np.cumsum(0.15 * rng.standard_normal(N))
    assert forest.forest({"gyro_x": x}, FS) is None
    assert forest.forest({"gyro_x": x + 3 * np.sin(phase)}, FS) is None


def test_the_skirts_of_a_strong_line_are_its_own():
    rng = np.random.default_rng(5)
    # a Lorentzian line of 0.5 Hz: 3 Hz off its power is down to 1/145 of that in the middle
    phase = 2 * np.pi * 21.0 * np.arange(N) / FS + np.cumsum(
        np.sqrt(2 * np.pi * 0.5 / FS) * rng.standard_normal(N)
    )
    x = rng.standard_normal(N) + 1.5 * np.sin(phase)
    ((low, high),) = skirts.widened(x, FS, [(20.0, 22.0)])
    assert 15.0 < low < 19.0 and 23.0 < high < 27.0
    assert skirts.widened(rng.standard_normal(N), FS, [(20.0, 22.0)])[0] == pytest.approx(
        (20.0, 22.0), abs=0.6
    )


def test_heavy_tails_are_seen_through_a_coarse_grid():
    rng = np.random.default_rng(6)
    x = rng.standard_t(5, N) * np.sqrt(3 / 5)
    step = 0.9
    names = [s.effect for s in analyse("accel_x", np.rint(x / step) * step, FS, None).steps]
    assert "heavy_tails" in names
    x = rng.standard_normal(N)
    names = [s.effect for s in analyse("accel_x", np.rint(x / step) * step, FS, None).steps]
    assert "heavy_tails" not in names
