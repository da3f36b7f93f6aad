"""`imu-lib characterise` from a file to the contract's JSON, the model file, the figures and the
exports.
"""

import json

import numpy as np
import pytest

from imu_lib import Model, preset, report
from imu_lib.characterise import _of_record, characterise, stretches
from imu_lib.cli.main import main
from imu_lib.estimate import Estimate
from imu_lib.export import FORMATS, equivalent_markov, equivalent_walk, text
from imu_lib.processes import Flicker, GaussMarkov, RandomWalk, Sum, WhiteNoise
from imu_lib.readers import read_record as imu_record
from imu_lib.record import Record

TWIN = preset("3dm-gx3-25")


def short(n=30_000, channels=None, seed=1):
    return TWIN.simulate_record(
        n, 100.0, np.random.default_rng(seed), name="short", channels=channels
    )


@pytest.fixture(scope="module")
def result():
    return characterise(short(60_000, ("gyro_x", "accel_x")), workers=1)


def test_the_contract(result):
    entry = json.loads(json.dumps(result.to_json()))["channels"]
    assert set(entry) == {"gyro_x", "accel_x"}
    for channel in entry.values():
        assert {"allan", "psd", "likelihood", "gauss_markov", "autoregressive"} <= set(channel)
        assert set(channel["allan"]) == {"N", "B", "K", "Q", "R"}
        assert {"N"} <= set(channel["likelihood"]) and set(channel["gauss_markov"]) == {
            "sigma",
            "correlation_time",
        }
        ar = channel["autoregressive"]
        assert {"order", "phi", "sigma", "white"} <= set(ar) and len(ar["phi"]) == ar["order"]
        assert ar["intervals"]["sigma"][0] < ar["sigma"] < ar["intervals"]["sigma"][1]
        for method in ("allan", "psd", "likelihood", "gauss_markov"):
            for estimate in channel[method].values():
                assert set(estimate) == {"value", "low", "high"}
                if estimate["value"] is None:
                    assert estimate["low"] == 0
                else:
                    assert estimate["low"] <= estimate["value"] <= (estimate["high"] or np.inf)


def test_values_of_the_twin(result):
    for name in ("gyro_x", "accel_x"):
        truth = TWIN[name].terms[0].N
        assert result[name].likelihood["N"].value == pytest.approx(
            truth, rel=0.01
        )  # standard error 0.2 %
        assert "moving average" in result[name].notes[0]
    assert result.model.channel_names == ("gyro_x", "accel_x")
    assert result["gyro_x"].likelihood["K"].value is None or result["gyro_x"].choice.name.endswith(
        "walk"
    )


def test_gaps_are_reported_and_every_stretch_used():
    whole = short(40_000, ("gyro_x",))
    keep = np.r_[0:15_000, 21_000:40_000]
    record = Record(
        {"gyro_x": whole["gyro_x"][keep]}, 100.0, time=np.arange(40_000)[keep] / 100.0, name="gap"
    )
    found = characterise(record, workers=1)
    assert any("other methods the longest part without a gap" in note for note in found.notes)
    assert found["gyro_x"].choice.fit.statistics.n == len(keep)
    f, measured, expected = found["gyro_x"].density
    assert np.all(np.diff(f) >= 0) and 0.9 < np.median(measured / expected) < 1.1, (
        "one curve to draw, whatever the stretches"
    )
    assert found["gyro_x"].likelihood["N"].value == pytest.approx(
        TWIN["gyro_x"].terms[0].N, rel=0.02
    )


def test_short_gaps_are_said_to_be_bridged():
    keep = np.delete(np.arange(70_000), [20_000, 20_001, 50_000])
    x = np.random.default_rng(0).standard_normal(keep.size)
    note = _of_record(Record({"gyro_x": x}, 100.0, time=keep / 100.0), ())[0]
    assert note.startswith("2 gaps in time") and "all of it, the gaps bridged" in note


def test_stretches():
    x = np.r_[np.nan, np.ones(200), np.nan, np.ones(30), np.nan, np.ones(5)]
    assert [len(run) for run in stretches(x)] == [200, 30]


def test_a_record_too_short_for_some_methods_says_so():
    found = characterise(short(120, ("gyro_x",)), workers=1)
    assert found["gyro_x"].likelihood["N"].high > 0
    assert any("600" in note or "long" in note for note in found.notes)


def test_command_writes_all_or_nothing(tmp_path, capsys):
    file = tmp_path / "static.npz"
    record = short(6_000)
    level = np.stack([record[f"accel_{a}"] for a in "xyz"], axis=1) + [0, 0, -9.81]
    np.savez(file, time=record.times(), gyro=record["gyro"], accel=level)
    out = tmp_path / "out"
    assert (
        main(
            [
                "characterise",
                str(file),
                "--out",
                str(out),
                "--export",
                "kalibr",
                "--export",
                "ros,gnss-ins-sim",
                "--json",
                str(tmp_path / "result.json"),
                "--workers",
                "1",
            ]
        )
        == 0
    )
    assert {p.name for p in out.iterdir()} == {
        "model.json",
        "result.json",
        "report.html",
        "allan_gyro.png",
        "allan_accel.png",
        "spectrum_gyro.png",
        "spectrum_accel.png",
        *(name for name, _ in FORMATS.values()),
    }
    assert len(Model.load(out / "model.json").channel_names) == 6
    assert set(json.loads((tmp_path / "result.json").read_text())["channels"]) == set(
        record.channel_names
    )
    page = (out / "report.html").read_text()
    assert page.count("<img") == 4 and "http" not in page.replace("http-equiv", "")
    printed = capsys.readouterr()
    assert (
        "deg/sqrt(h)" in printed.out
        and "likelihood" in printed.out
        and "characterising" in printed.err
    )


@pytest.mark.parametrize(
    "arguments, words",
    [
        (["--export", "matlab"], "matlab"),
        (["--workers", "0"], "--workers"),
        (["--json", "/nowhere/at/all.json"], "/nowhere"),
    ],
)
def test_command_refuses_before_long_work(tmp_path, capsys, arguments, words):
    file = tmp_path / "r.npz"
    np.savez(
        file, gyro_x=np.random.default_rng(1).standard_normal(100) * 1e-3, time=np.arange(100) / 100
    )
    before = set(tmp_path.iterdir())
    assert main(["characterise", str(file), *arguments]) == 2
    assert words in capsys.readouterr().err and set(tmp_path.iterdir()) == before


def test_british_and_american(tmp_path):
    assert (
        main(["characterize", str(tmp_path / "none.npz")])
        == main(["characterise", str(tmp_path / "none.npz")])
        == 2
    )


@pytest.mark.parametrize("name", ["mtig_gyro_x.npz", "mpu6050_10min.npz"])
def test_real_records(data_dir, name, tmp_path):
    assert (
        main(
            [
                "characterise",
                str(data_dir / "static" / name),
                *("--stop", "200"),
                "--json",
                str(tmp_path / "r.json"),
                "--workers",
                "1",
            ]
        )
        == 0
    )
    for channel in json.loads((tmp_path / "r.json").read_text())["channels"].values():
        assert channel["likelihood"]["N"]["high"] > 0


# -- exports --------------------------------------------------------------------------------------


def test_equivalents_give_a_process_itself():
    white = WhiteNoise(N=1e-3)
    assert equivalent_walk(white + RandomWalk(K=2e-5)) == pytest.approx(2e-5)
    long = white + GaussMarkov(sigma=1e-3, correlation_time=1e5)
    assert equivalent_walk(long) == pytest.approx(1e-3 * np.sqrt(2 / 1e5), rel=1e-3)
    assert equivalent_markov(long) == (1e-3, 1e5)
    sigma, time = equivalent_markov(white + Flicker(B=1e-4))
    bump = GaussMarkov(sigma, time).avar(np.array([1.893 * time]))[0]
    assert 0.5 < bump / (0.664e-4) ** 2 < 3  # a bump cannot be flat over three decades
    assert equivalent_walk(white + Flicker(B=0.0)) == 0.0


@pytest.mark.parametrize("form", FORMATS)
def test_exports_read_back(form):
    name, content = text(TWIN, form)
    if form == "gnss-ins-sim":
        space = {}
        exec(content, space)
        assert space["imu_err"]["gyro_b_corr"].shape == (3,)
        assert space["imu_err"]["gyro_arw"][0] == pytest.approx(
            TWIN["gyro_x"].terms[0].N / (np.pi / 180 / 60), rel=1e-4
        )
        return
    import yaml

    found = yaml.safe_load(content)
    if form == "kalibr":
        assert found["accelerometer_noise_density"] == pytest.approx(
            max(TWIN[f"accel_{a}"].terms[0].N for a in "xyz")
        )
        assert set(found) == {
            "accelerometer_noise_density",
            "accelerometer_random_walk",
            "gyroscope_noise_density",
            "gyroscope_random_walk",
            "rostopic",
            "update_rate",
        }
    else:
        imu = found["/**"]["ros__parameters"]["imu"]
        assert len(imu["angular_velocity_covariance"]) == 9
        assert imu["angular_velocity_covariance"][0] == pytest.approx(
            TWIN["gyro_x"].terms[0].N ** 2 * 1000 / 15, rel=1e-3
        )


def test_export_of_a_gyro_alone_says_what_is_missing():
    model = Model({"gyro_x": TWIN["gyro_x"]}, rate=100.0)
    assert "# accelerometer_noise_density" in text(model, "kalibr")[1]
    assert "divides by it" in text(Model({"gyro_x": Sum((WhiteNoise(N=1e-4),))}), "kalibr")[1], (
        "a walk that is not shown"
    )
    assert "no gyro_y" in text(model, "gnss-ins-sim")[1]


# -- report ---------------------------------------------------------------------------------------


def test_estimates_in_words():
    assert report.estimate(Estimate(None, 0.0, np.inf), "K", "gyro_x") == "not shown"
    assert report.estimate(Estimate(None, 0.0, np.pi / 180 / 60), "N", "gyro_x") == "< 1"
    assert (
        report.estimate(Estimate(1.0, 0.5, 2.0), "correlation_time_2", "accel_x", 3) == "1 [0.5, 2]"
    )


def test_html_escapes():
    page = report.page(
        "<b>", report.paragraph("a < b"), report.table_html(["x"], [["<i>"]]), report.bullets(["&"])
    )
    assert "<b>" not in page and "<i>" not in page and "a &lt; b" in page


def test_too_short_a_record_is_told_what_to_do(tmp_path, capsys):
    for name, n in (("short.npz", 99), ("long.npz", 100)):
        record = short(n, ("gyro_x",))
        np.savez(tmp_path / name, gyro_x=record["gyro_x"], time=np.arange(n) / 100.0)
    for argv in (
        ["characterise", tmp_path / "short.npz"],
        ["compare", tmp_path / "short.npz", tmp_path / "long.npz"],
    ):
        assert main([str(a) for a in argv]) == 2
        said = capsys.readouterr().err.splitlines()[-1]
        assert "short.npz has 99 samples (0.99 s)" in said and "at rest for longer" in said
    assert main(["compare", str(tmp_path / "long.npz"), str(tmp_path / "long.npz")]) == 0


def test_a_dead_channel_is_left_out_and_named(tmp_path, capsys):
    record = short(2000, ("gyro_x",))
    for name, x in (("one.npz", record["gyro_x"]), ("none.npz", np.zeros(2000))):
        np.savez(
            tmp_path / name, gyro_x=x, gyro_y=np.full(2000, 1e-3), time=np.arange(2000) / 100.0
        )
    found = characterise(imu_record(tmp_path / "one.npz"), workers=1)
    assert (
        set(found.channels) == {"gyro_x"} and "gyro_y never changes and is left out." in found.notes
    )
    assert main(["characterise", str(tmp_path / "none.npz")]) == 2
    assert "no channel ever changes" in capsys.readouterr().err


def test_steps_coarser_than_the_scatter_are_said():
    """A wristband's 1/64 g: what the coefficients describe is the rounding."""
    from imu_lib.characterise import causes

    rng = np.random.default_rng(8)
    fine = 9.81 + rng.normal(0, 0.03, 4000)
    step = 9.80665 / 64
    coarse = np.round(fine / step) * step
    record = Record({"accel_x": fine, "accel_z": coarse}, 32.0)
    (note,) = [n for n in causes.notes(record, record.channel_names) if "output steps" in n]
    assert "accel_z 0.0156 against" in note and "accel_x" not in note


def test_a_sensor_that_moves_is_told(tmp_path, capsys):
    """What a hand or a car does is no noise; each command that describes noise says so."""
    rng = np.random.default_rng(5)
    t = np.arange(6000) / 100.0
    rest = Record({"gyro_z": rng.normal(0, 1e-3, t.size)}, 100.0)
    turning = Record({"gyro_z": 0.3 * np.sin(0.5 * t) + rest["gyro_z"]}, 100.0)
    moved = [n for n in characterise(turning, workers=1).notes if "moved or was shaken" in n]
    assert len(moved) == 1 and "`imu-lib check FILE`" in moved[0]
    assert not [n for n in characterise(rest, workers=1).notes if "moved" in n]
    for name, record in (("rest", rest), ("turning", turning)):
        np.savez(tmp_path / f"{name}.npz", time=t, gyro_z=record["gyro_z"])
    assert main(["compare", *(str(tmp_path / f"{n}.npz") for n in ("rest", "turning"))]) == 0
    (note,) = [x for x in capsys.readouterr().err.splitlines() if "moved" in x]
    assert "turning.npz" in note
    assert main(["gap", str(tmp_path / "turning.npz"), "--simulations", "0"]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "not of a sensor at rest" in out and "nobody touched" not in out
