"""Error models: files, presets, realisations."""

import json

import numpy as np
import pytest

from imu_lib import units
from imu_lib.errors import InputError
from imu_lib.model import Model
from imu_lib.presets import PRESETS, preset, published_2013, twin_misfit
from imu_lib.processes import (
    CommonMode,
    GaussMarkov,
    Jitter,
    RandomWalk,
    Sum,
    Temperature,
    TimeGaps,
    WhiteNoise,
)


@pytest.mark.parametrize("name", PRESETS)
def test_presets_survive_their_file(name, tmp_path):
    model = preset(name)
    path = tmp_path / "model.json"
    model.save(path)
    assert Model.load(path) == model
    assert Model.load(f"preset:{name}") == model
    assert not list(tmp_path.glob(".*"))


def test_twin_meets_what_was_measured_where_the_tables_agree():
    """Gyros and Acc Z: within the tolerance of the tables; Acc X can't (its N and K alone exceed
    its flat level).
    """
    for channel, row in published_2013().items():
        misfit = twin_misfit(preset("3dm-gx3-25")[channel], row)
        assert misfit["N"] == pytest.approx(1.0, abs=0.02)
        assert misfit["flat"] == pytest.approx(1.0, abs=0.02)
        assert misfit["slope"] == pytest.approx(0.0, abs=0.02)
        if channel.startswith("gyro"):
            assert misfit["sd"] == pytest.approx(1.0, abs=0.1)
    acc_x = published_2013()["accel_x"]
    alone = Sum((WhiteNoise(acc_x.N), RandomWalk(acc_x.K))).avar(acc_x.flat_time)
    assert np.sqrt(alone) > 0.664 * acc_x.B
    walk = acc_x.K * np.sqrt(7 * units.HOUR / 6)
    assert walk > 5 * acc_x.sd


def test_model_of_the_2013_paper_follows_its_equations():
    channel = preset("3dm-gx3-25-2013")["gyro_x"]
    markov = channel.find("gauss_markov")
    assert markov.sigma == pytest.approx(44.533 * 0.664 / 3600 * np.pi / 180)  # Eq. 29
    assert markov.correlation_time == 490.89  # Table 5
    assert channel.find("white_noise").N ** 2 == pytest.approx(
        (2.420 * np.pi / 180) ** 2 / 3600
    )  # Eq. 27


def test_a_channel_does_not_depend_on_which_others_are_drawn():
    model = preset("3dm-gx3-25")
    whole = model.simulate(1000, 100.0, np.random.default_rng(1))
    alone = model.simulate(1000, 100.0, np.random.default_rng(1), channels=["accel_z"])
    assert np.array_equal(whole["accel_z"], alone["accel_z"])


def test_common_mode_is_common():
    model = Model(
        {c: Sum((WhiteNoise(1.0),)) for c in ("gyro_x", "gyro_y", "gyro_z")},
        record=(CommonMode(1.0, ("gyro_x", "gyro_y")),),
    )
    x = model.simulate(50_000, 100.0, np.random.default_rng(2))
    # correlation 1/2; its standard error over 50,000 samples is 0.0034
    assert np.corrcoef(x["gyro_x"], x["gyro_y"])[0, 1] == pytest.approx(0.5, abs=0.02)
    assert np.corrcoef(x["gyro_x"], x["gyro_z"])[0, 1] == pytest.approx(0.0, abs=0.02)


def test_record_with_gaps_jitter_and_temperature():
    model = Model(
        {"gyro_x": Sum((WhiteNoise(1e-6), Temperature(1e-5, 20.0)))},
        record=(TimeGaps(0.02, 10), Jitter(2e-4)),
    )
    temperature = np.linspace(20, 30, 20_000)
    record = model.simulate_record(20_000, 100.0, np.random.default_rng(4), temperature=temperature)
    assert record.n < 20_000 and len(record.temperature) == record.n == len(record.time)
    assert np.polyfit(record.temperature, record["gyro_x"], 1)[0] == pytest.approx(
        1e-5, rel=0.01
    )  # 4 standard errors


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "line 1"),
        ("[]", "object of channels"),
        ("{}", "no channel"),
        ('{"gyro_q": []}', "unknown channel 'gyro_q'"),
        (
            '{"gyro_x": [{"process": "white_noise", "N": 1e-4}], "record": [{"process": '
            '"common_mode", "N": 5e-4, "channels": ["gyro_x", "gyro_k"]}]}',
            "unknown channel 'gyro_k'",
        ),
        ('{"gyro_x": [], "gyro_x": []}', '"gyro_x" stands twice'),
        ('{"gyro_x": {}}', "channel gyro_x: must be a list"),
        ('{"gyro_x": [{"process": "x"}]}', "entry 1: unknown process"),
        ('{"gyro_x": [], "rate": -1}', "`rate`"),
        ('{"gyro_x": [], "record": [{"process": "white_noise", "N": 1}]}', "record, entry 1"),
    ],
)
def test_bad_files_are_refused_in_a_sentence(text, message, tmp_path):
    path = tmp_path / "m.json"
    path.write_text(text)
    with pytest.raises(InputError, match=message) as caught:
        Model.load(path)
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)


def test_missing_files_and_presets_are_refused_in_a_sentence(tmp_path):
    for path, message in [
        (tmp_path / "none.json", "no such file"),
        (tmp_path, "directory"),
        ("preset:none", "unknown preset"),
    ]:
        with pytest.raises(InputError, match=message):
            Model.load(path)


def test_unknown_keys_are_kept():
    content = {
        "gyro_x": [{"process": "gauss_markov", "sigma": 1.0, "correlation_time": 2.0}],
        "note": {"by": "us"},
    }
    assert Model.from_json(content).to_json() == content
    assert Model.from_json(content)["gyro_x"].terms == (GaussMarkov(1.0, 2.0),)
    assert json.dumps(Model.from_json(content).to_json())
