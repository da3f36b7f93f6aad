"""What a given model has and the record has not is told, and the grown model is without it."""

from types import SimpleNamespace

import numpy as np
import pytest

from imu_lib import gap
from imu_lib.cli import main as cli
from imu_lib.gap import absent
from imu_lib.gap.coherence import cross_spectra
from imu_lib.gap.sentences.summary import sentences
from imu_lib.gap.table import table
from imu_lib.model import Model
from imu_lib.processes import (
    CommonMode,
    Dropout,
    Jitter,
    LowPass,
    Sinusoid,
    Spikes,
    Sum,
    TimeGaps,
    Vibration,
    WhiteNoise,
)  # fmt: skip
from imu_lib.record import Record

FS, N = 50.0, 3000
NOISE = {"gyro_x": 1e-4, "accel_x": 1e-3, "accel_y": 1e-3}
SHAKES = Vibration(
    frequency=11.0, amplitude=(0.02, 0.02), channels=("accel_x", "accel_y"), bandwidth=0.0
)
SHARED = CommonMode(N=2e-4, channels=("gyro_x", "accel_x"))


def model(*record, **channels):
    own = {c: Sum((WhiteNoise(N=n), *channels.get(c, ()))) for c, n in NOISE.items()}
    return Model(own, record=record, rate=FS)


def calm(*record):
    drawn = model(*record).simulate_record(N, FS, np.random.default_rng(3))
    return drawn


@pytest.mark.parametrize("record", [SHAKES, SHARED], ids=lambda p: p.name)
def test_what_no_channel_feels_is_told_and_not_grown(record):
    found = gap.close(calm(), model(record), simulations=20, jobs=1)
    assert [a.process for a in found.absent] == [record] and not found.steps
    assert set(found.absent[0].channels) == set(record.channels)
    for name in record.channels:
        if name != "accel_x" or record is SHAKES:  # the noise in common is next to nothing there
            assert found.channels[name].before.value > 3 > found.channels[name].after.value
    assert not found.model.record and found.base.record == (record,)
    said = " ".join(sentences(found))
    assert f"does not have the given model's {record.name.replace('_', ' ')}" in said
    assert "already holds" not in said and "without the given model's" in table(found)
    assert found.to_json()["record"]["absent"][0]["effect"] == record.name
    again = gap.close(calm(), found.model, simulations=0, jobs=1)
    assert not again.absent and not again.steps


@pytest.mark.parametrize(("other", "same"), [(9.5, True), (8.0, False)])
def test_a_frequency_that_the_other_wanders_to_is_the_others(other, same):
    # a fan of another day: both lines are narrow, the foot of one is where the other stands
    fan = Vibration(
        frequency=11.0, amplitude=(0.02,), channels=("accel_x",), bandwidth=0.3,
        profile_frequency=(9.0, 10.0, 11.0, 11.5), profile=(0.1, 0.2, 1.0, 0.1),
    )  # fmt: skip
    found = SimpleNamespace(process=SHAKES.with_(frequency=other))
    assert absent.one(found, fan) == same
    assert absent.one(SimpleNamespace(process=fan), SHAKES.with_(frequency=other)) == same


@pytest.mark.parametrize("record", [SHAKES, SHARED], ids=lambda p: p.name)
def test_what_is_there_is_held(record):
    found = gap.close(calm(record), model(record), simulations=0, jobs=1)
    assert not found.absent and not found.steps
    assert [p.name for p in found.model.record] == [record.name]


def test_a_vibration_too_weak_to_be_told_stays_in_the_model():
    weak = SHAKES.with_(amplitude=(2e-4, 2e-4))
    found = gap.close(calm(), model(weak), simulations=0, jobs=1)
    assert not found.absent and found.model.record == (weak,)
    assert "already holds" not in " ".join(sentences(found))


def test_signals_that_a_channel_has_not_are_told():
    given = model(gyro_x=[Sinusoid(amplitude=1e-3, frequency=5.0)])
    own = Sum(given["accel_x"].terms, (Spikes(rate=1.0, scale=0.2),))
    given = Model({**given.channels, "accel_x": own}, rate=FS)
    found = gap.close(calm(), given, simulations=20, jobs=1)
    assert [a.process.name for a in found.absent] == ["sinusoid", "spikes"]
    assert found.model["gyro_x"].find("sinusoid") is None and not found.model["accel_x"].stages
    assert found.channels["gyro_x"].before.value > 3 > found.channels["gyro_x"].after.value
    assert found.channels["accel_x"].result.unexplained is None
    held = gap.close(given.simulate_record(N, FS, np.random.default_rng(4)), given, simulations=0)
    assert not held.absent


def test_stamps_of_a_clock_that_changes_its_rate_do_not_scatter():
    time = np.r_[np.arange(N // 2) / FS, N / (2 * FS) + np.arange(N - N // 2) / (0.98 * FS)]
    changed = Record({"gyro_x": np.array(calm()["gyro_x"])}, FS, time=time)
    told = absent.of_faults(model(Jitter(sd=2e-3)), (), changed)
    assert [a.process.name for a in told] == ["jitter"]


@pytest.mark.parametrize("fault", [
    TimeGaps(fraction=0.05), Jitter(sd=2e-3), Dropout(fraction=0.02, value=0.0, channels=("gyro_x",)),
], ids=lambda p: p.name)  # fmt: skip
def test_faults_that_the_data_have_not_are_told(fault):
    found = gap.close(calm(), model(fault), channels=["gyro_x"], simulations=0, jobs=1)
    assert [a.process.name for a in found.absent] == [fault.name] and not found.model.record
    there = model(fault).simulate_record(N, FS, np.random.default_rng(5))
    held = gap.close(there, model(fault), channels=["gyro_x"], simulations=0, jobs=1)
    assert not held.absent and [p.name for p in held.model.record] == [fault.name]


def test_what_a_filter_of_the_sensor_takes_away_is_not_missed():
    slow = (LowPass(cutoff=3.0, order=2, rate=FS),)
    noise = WhiteNoise(N=1e-4)
    line = Sum((noise, Sinusoid(amplitude=1e-3, frequency=10.0)), slow)
    shared = CommonMode(N=2e-4, channels=("gyro_x", "gyro_y"), filtered=1)
    given = Model({"gyro_x": line, "gyro_y": Sum((noise,), slow)}, record=(shared,), rate=FS)
    drawn = given.simulate_record(N, FS, np.random.default_rng(6))
    raw = {c: np.array(drawn[c]) for c in drawn.channel_names}
    assert not absent.of_lines(given, raw, FS) and not absent.of_common(
        given, cross_spectra(raw, FS), FS
    )
    bare = Model({c: Sum((noise,), slow) for c in raw}, rate=FS)
    drawn = bare.simulate_record(N, FS, np.random.default_rng(6))
    raw = {c: np.array(drawn[c]) for c in drawn.channel_names}
    assert absent.of_lines(given, raw, FS) and absent.of_common(given, cross_spectra(raw, FS), FS)


def test_effects_on_channels_that_the_record_lacks_are_one_sentence():
    kept, said = absent.elsewhere(model(SHAKES, SHARED), ["gyro_x"])
    assert kept.record == (SHARED,) and "vibration on accel_x, accel_y" in said


def test_samples_without_a_number_are_no_sound_data():
    record = calm()
    x = np.array(record["gyro_x"])
    x[500:800] = np.nan
    found = gap.close(Record({"gyro_x": x}, FS), simulations=0, jobs=1)
    said = " ".join(sentences(found))
    assert "300 values are missing (NaN) on gyro_x, 10 %" in said and "no drop-outs" not in said
    assert "gap index is 1" not in table(found) and "held out" not in table(found)


def test_a_temperature_term_without_a_temperature_has_a_remedy(tmp_path, capsys):
    given = tmp_path / "warm.json"
    given.write_text(
        '{"gyro_x": [{"process": "white_noise", "N": 1e-4}, '
        '{"process": "temperature", "slope": 1e-4, "reference": 25}]}'
    )
    np.savez(
        tmp_path / "r.npz",
        time=np.arange(N) / FS,
        gyro=np.array(calm()["gyro_x"])[:, None].repeat(3, 1),
    )
    assert cli.main(["gap", str(tmp_path / "r.npz"), "--model", str(given)]) == 2
    said = capsys.readouterr().err
    assert "`temperature` (degC)" in said and "take the term out" in said
