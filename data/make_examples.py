"""Draws the two short files that are committed: `python data/make_examples.py` writes them again,
byte for byte.

Both are the first minutes of a simulated 3DM-GX3-25 (the preset of that name) lying still and
level, with turn-on biases and gravity, written as a careful and as a careless logger would.
"""

import datetime as dt
from pathlib import Path

import numpy as np

from imu_lib import units
from imu_lib.presets import preset

HERE = Path(__file__).parent
RATE, SEED = 100.0, 20130724
BIAS = {
    "gyro_x": 0.12,
    "gyro_y": -0.31,
    "gyro_z": 0.05,
    "accel_x": 0.0021,
    "accel_y": -0.0013,
    "accel_z": -0.9988,
}  # deg/s, g
COUNTS = {"gyro": 131.0, "accel": 16384.0}  # per deg/s, per g


def signals(seconds, seed):
    """Channels in deg/s and g, dict of ndarray (n,)."""
    drawn = preset("3dm-gx3-25").simulate(round(seconds * RATE), RATE, np.random.default_rng(seed))
    return {
        c: BIAS[c] + x / (units.DEG_PER_S if c.startswith("gyro") else units.G)
        for c, x in drawn.items()
    }


def careful():
    """gx3_25_one_minute.csv: time, units in the header, five samples lost."""
    x = signals(60, SEED)
    rows = ["# 3DM-GX3-25, simulated, at rest and level"]
    rows.append(
        ",".join(["time [s]"] + [f"{c} [deg/s]" if c.startswith("gyro") else f"{c} [g]" for c in x])
    )
    for k in range(round(60 * RATE)):
        if 4210 <= k < 4215:
            continue
        rows.append(f"{k / RATE:.2f}," + ",".join(f"{x[c][k]:.5f}" for c in x))
    (HERE / "gx3_25_one_minute.csv").write_text(
        "\n".join(rows) + "\n", encoding="utf-8", newline="\n"
    )


def careless():
    """logger_counts.csv: wall clock of whole seconds, counts, semicolons, no units, no rate, two
    values missing.
    """
    x = signals(40, SEED + 1)
    start = dt.datetime(2024, 5, 17, 9, 59, 50)
    rows = ["date;clock;gx;gy;gz;ax;ay;az"]
    for k in range(round(40 * RATE)):
        now = start + dt.timedelta(seconds=int(k / RATE))
        counts = [f"{round(x[c][k] * COUNTS[c.partition('_')[0]])}" for c in x]
        if k in (1200, 1201):
            counts[2] = ""
        rows.append(f"{now:%Y-%m-%d;%H:%M:%S};" + ";".join(counts))
    (HERE / "logger_counts.csv").write_text("\n".join(rows) + "\n", encoding="utf-8", newline="\n")


if __name__ == "__main__":
    careful()
    careless()
