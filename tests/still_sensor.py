"""A plausible sensor at rest, 600 rows at 50 Hz, and a table of it as a logger would write one."""

import numpy as np
import pytest

from imu_lib import units
from imu_lib.record import Record

RATE, N = 50.0, 600


def still(n=N, seed=1):
    """A plausible sensor at rest: deg/s of noise and bias, gravity down."""
    rng = np.random.default_rng(seed)
    gyro = rng.normal(scale=2e-3, size=(n, 3)) + [0.01, -0.02, 0.005]
    accel = rng.normal(scale=2e-2, size=(n, 3)) - [0, 0, units.G]
    return gyro, accel


def record(n=N):
    gyro, accel = still(n)
    channels = {
        f"{k}_{a}": v[:, i]
        for k, v in (("gyro", gyro), ("accel", accel))
        for i, a in enumerate("xyz")
    }
    return Record(channels, RATE, temperature=np.linspace(20, 25, n))


def same(found, rtol=1e-9):
    gyro, accel = still(found.n)
    assert found.rate == pytest.approx(RATE, rel=1e-6)
    assert np.allclose(found["gyro"], gyro, rtol=rtol, atol=1e-12) and np.allclose(
        found["accel"], accel, rtol=rtol, atol=1e-12
    )
    return True


def table(
    path,
    *,
    delimiter=",",
    header=True,
    decimal=".",
    comment="",
    gyro=1.0,
    accel=1.0,
    time=None,
    preamble="",
):
    g, a = still()
    t = np.arange(N) / RATE if time is None else time
    rows = [
        delimiter.join(f"{v:.12g}".replace(".", decimal) for v in row)
        for row in np.column_stack([t, g / gyro, a / accel])
    ]
    head = [delimiter.join(["time", "gx", "gy", "gz", "ax", "ay", "az"])] if header else []
    path.write_text(
        "\n".join([preamble] * bool(preamble) + [comment] * bool(comment) + head + rows) + "\n"
    )
    return path
