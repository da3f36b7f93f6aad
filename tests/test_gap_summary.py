"""The verdict in a few sentences."""

import re

import numpy as np

from imu_lib import gap
from imu_lib.gap.sentences.environment import coupled
from imu_lib.gap.sentences.summary import sentences
from imu_lib.gap.table import table
from imu_lib.processes import Vibration
from imu_lib.record import Record

FS, N = 50.0, 20_000


def record(**channels):
    rng = np.random.default_rng(3)
    still = {
        name: sd * rng.standard_normal(N)
        for name, sd in (("gyro_x", 1e-3), ("gyro_y", 1e-3), ("accel_z", 1e-2))
    }
    return Record({**still, **channels}, FS, name="test")


def test_a_sound_record_is_said_to_be_sound_in_at_most_six_sentences():
    found = gap.close(record(), simulations=0, jobs=1)
    said = sentences(found)
    assert 3 <= len(said) <= 6
    text = " ".join(said)
    assert "400 s at 50 Hz" not in text  # a duration beyond two minutes is told in minutes
    assert "6.67 min at 50 Hz, is good from 0 to 400 s" in text and "on all channels" in text
    assert "Nothing is wrong with the data" in text and "Nothing is left" in text
    # N = sd / sqrt(rate), to three per cent of a level read off 20,000 samples
    (number,) = [
        float(w) for w, u in zip(text.split(), text.split()[1:]) if u.startswith("deg/sqrt(h)")
    ]
    assert abs(number / (1e-3 / np.sqrt(FS) * 180 / np.pi * 60) - 1) < 0.05
    assert table(found).startswith("The record, 6.67 min")
    assert found.to_json()["verdict"] == said


def test_what_shakes_is_the_environments_and_where_to_go_from_there():
    quiet = record()
    shake = Vibration(frequency=7.0, amplitude=(1e-3, 1e-2), channels=("gyro_x", "accel_z"), start=100.0, stop=250.0)  # fmt: skip
    moved = shake.on(N, FS, np.random.default_rng(4))
    found = gap.close(
        record(**{c: quiet.channels[c] + x for c, x in moved.items()}), simulations=0, jobs=1
    )
    text = " ".join(sentences(found))
    assert "it shook at 7 Hz from 1" in text and "gyro_x and accel_z" in text
    assert "away from what shakes it" in text
    shown = table(found)
    # in the unit of the samples, 1e-3 rad/s and 1e-2 m/s^2 to the hundredth that the fit has
    felt = re.search(r"gyro_x (\S+) deg/s, accel_z (\S+) m/s\^2", shown)
    assert abs(float(felt[1]) / np.rad2deg(1e-3) - 1) < 0.1 and abs(float(felt[2]) / 1e-2 - 1) < 0.1
    rows = {line.split()[0]: line for line in shown.splitlines() if line.strip()}
    assert rows["gyro_x"].endswith("on the record: vibration")
    assert rows["gyro_y"].endswith("nothing found; no gap index was asked for")


def test_a_channel_whose_noise_grows_is_told_with_both_of_its_levels():
    """N from 1e-3 to 2.5e-3 over the record: no time is before it, and each has an interval."""
    n, fs = 8000, 100.0
    x = 1e-3 * np.sqrt(fs) * np.random.default_rng(6).standard_normal(n)
    grown = Record({"accel_y": 0.3 + x * (1 + 1.5 * np.arange(n) / n)}, fs)
    found = gap.close(grown, simulations=0, jobs=1)
    (step,) = [s for _, s in found.steps if s.effect == "noise_level_change"]
    for name, true in (("time", 0.0), ("duration", n / fs)):
        low, high = step.intervals[name]
        assert 0 <= low <= step.parameters[name] <= high and low <= true <= high + 1e-6, name
    told = re.search(r"accel_y (\S+) m/s/sqrt\(h\) at the start and (\S+) m/s/sqrt\(h\) at the end", " ".join(sentences(found)))  # fmt: skip
    assert abs(float(told[1]) / 0.06 - 1) < 0.1 and abs(float(told[2]) / 0.15 - 1) < 0.1


def test_where_white_noise_meets_a_walk_is_no_bias_instability():
    """N 1.5e-3 m/s^2/sqrt(Hz) and K 5e-3: they meet at half a second."""
    n, fs = 6000, 100.0
    rng = np.random.default_rng(9)
    walk = np.cumsum(5e-3 / np.sqrt(fs) * rng.standard_normal(n))
    x = 0.3 + 1.5e-3 * np.sqrt(fs) * rng.standard_normal(n) + walk
    found = gap.close(Record({"accel_y": x}, fs), simulations=0, jobs=1)
    text = " ".join(sentences(found)[:-1])
    assert "bias instability" not in text
    assert "random walk of" in text or "Gauss-Markov process" in text


def test_a_line_of_the_mains_on_gyros_alone_is_no_shaking():
    line = {"frequency": 50.02, "bandwidth": 0.0, "harmonics": 1, "channels": ["gyro_x", "gyro_y"]}
    assert coupled(line)
    assert not coupled({**line, "channels": ["gyro_x", "accel_z"]})
    assert not coupled({**line, "frequency": 47.0}) and not coupled({**line, "from": 3.0})
