"""The commands: one parser, results written whole or not at all, simulate and compare and data."""

import argparse
import json
import os
import subprocess
import sys

import numpy as np
import pytest

from imu_lib.cli import common
from imu_lib.cli import main as cli
from imu_lib.errors import InputError
from imu_lib.presets import preset

MODEL = {
    "gyro_x": [
        {"process": "white_noise", "N": 1e-4},
        {"process": "temperature", "slope": 1e-5, "reference": 25},
    ],
    "accel_z": [{"process": "constant", "value": -9.81}, {"process": "white_noise", "N": 1e-3}],
    "rate": 50.0,
}


@pytest.fixture
def model(tmp_path):
    path = tmp_path / "model.json"
    path.write_text(json.dumps(MODEL))
    return path


@pytest.fixture
def warmth(tmp_path):
    path = tmp_path / "T.csv"
    path.write_text("time,temperature\n0,20\n100,30\n4000,30\n")
    return path


def run(*argv):
    return cli.main([str(a) for a in argv])


def test_module_and_command_are_the_same():
    told = [
        subprocess.run(
            [sys.executable, *call, "--version"],
            capture_output=True,
            text=True,
            env={**os.environ, "PYTHONPATH": os.getcwd()},
        ).stdout
        for call in (
            ["-m", "imu_lib"],
            ["-c", "import sys; from imu_lib.cli.main import main; sys.exit(main())"],
        )
    ]
    assert told[0] == told[1] and told[0].startswith("imu-lib ")


def test_every_command_has_its_help(capsys):
    for name, (_, aliases, _) in cli.there().items():
        for word in (name, *aliases):
            assert run(word, "--help") == 0
            assert f"usage: imu-lib {name}" in capsys.readouterr().out
    assert run("--help") == 0
    listed = capsys.readouterr().out
    assert all(name in listed for name in cli.there())


def test_simulate_draws_the_same_record_for_the_same_seed(model, warmth, tmp_path, capsys):
    for name in ("a.npz", "b.npz"):
        assert (
            run(
                "simulate",
                model,
                "--hours",
                0.1,
                "--seed",
                7,
                "--temperature",
                warmth,
                "--out",
                tmp_path / name,
                "--json",
                tmp_path / "s.json",
            )
            == 0
        )
    a, b = (np.load(tmp_path / name) for name in ("a.npz", "b.npz"))
    assert (
        len(a["time"]) == 18_000
        and np.array_equal(a["gyro_x"], b["gyro_x"])
        and a["temperature"][-1] == 30.0
    )
    # white noise of N at 50 Hz has N sqrt(50) per sample; the temperature term rises by 1e-5 per
    # degC
    assert np.diff(a["gyro_x"]).std() / 2**0.5 == pytest.approx(
        1e-4 * 50**0.5, rel=0.03
    )  # 0.5 % is one standard error
    assert json.loads((tmp_path / "s.json").read_text())["samples"] == 18_000
    assert run("check", tmp_path / "a.npz") == 0 and "20 to 30 degC" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("extra", "says"),
    [
        ([], "--temperature"),
        (["--rate", "0"], "above 0"),
        (["--hours", "1e9"], "memory"),
        (["--hours", "1e-9"], "at least two"),
        (["--seed", "-1"], "--seed"),
        (["--out", "x.xls"], "format"),
        (["--temperature", "missing.csv"], "missing.csv"),
    ],
)
def test_simulate_refuses(model, tmp_path, capsys, extra, says, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run("simulate", model, "--hours", 0.1, "--seed", 7, "--out", "a.npz", *extra) == 2
    err = capsys.readouterr().err
    assert says in err and len(err.strip().splitlines()) == 1
    assert sorted(p.name for p in tmp_path.iterdir()) == ["model.json"]


def test_simulate_says_what_the_record_cannot_show(tmp_path, capsys):
    """A line above half the rate is folded, and a step after the end is not there: both with a
    word."""
    effects = [
        {"process": "white_noise", "N": 1e-6},
        {"process": "sinusoid", "amplitude": 0.01, "frequency": 70.0},
        {"process": "step", "amplitude": 0.1, "time": 500.0},
        {"process": "step", "amplitude": 0.1, "time": 100.0},
    ]
    model, out = tmp_path / "model.json", tmp_path / "record.npz"
    model.write_text(json.dumps({"gyro_x": effects}))
    options = ("--hours", 0.1, "--rate", 100, "--seed", 1, "--out", out)
    assert run("simulate", model, *options) == 0
    notes = capsys.readouterr().out.splitlines()[1:]
    assert len(notes) == 2 and "30 Hz" in notes[0] and "500 s" in notes[1]
    x = np.load(out)["gyro_x"]
    power = np.abs(np.fft.rfft((x - x.mean())[:36_000])) ** 2
    power[:500] = 0.0  # the step's own, below 1.4 Hz
    assert power.argmax() / 360.0 == pytest.approx(30.0, abs=0.01)
    assert x[-1000:].mean() - x[:1000].mean() == pytest.approx(0.1, abs=1e-3)


def test_simulate_refuses_what_is_no_model(tmp_path, capsys):
    for text, says in (
        ("{", "line 1"),
        ("[]", "object"),
        ('{"gyro_x": [{"process": "magic"}]}', "magic"),
        ('{"gyro_x": [{"process": "white_noise", "N": "x"}]}', "N"),
    ):
        (tmp_path / "m.json").write_text(text)
        assert (
            run(
                "simulate",
                tmp_path / "m.json",
                "--hours",
                1,
                "--rate",
                10,
                "--seed",
                1,
                "--out",
                tmp_path / "a.npz",
            )
            == 2
        )
        assert says in capsys.readouterr().err


def test_compare_two_models(capsys, tmp_path):
    assert (
        run("compare", "preset:3dm-gx3-25", "preset:3dm-gx3-25-2013", "--json", tmp_path / "c.json")
        == 0
    )
    assert "differ beyond sampling" in capsys.readouterr().out
    told = json.loads((tmp_path / "c.json").read_text())["channels"]["gyro_x"]
    for side, name in (("a", "3dm-gx3-25"), ("b", "3dm-gx3-25-2013")):
        assert told["coefficients"]["N"][side] == pytest.approx(
            preset(name)["gyro_x"].find("white_noise").N
        )
    assert run("compare", "preset:isis-imu", "preset:isis-imu") == 0
    said = capsys.readouterr()
    assert "No difference beyond sampling" in said.out
    assert "the same model" in said.err and "fits" not in said.err  # nothing is fitted


def test_compare_two_records(capsys, tmp_path):
    rng = np.random.default_rng(9)
    for name, sigma in (("a", 1e-3), ("b", 1e-3), ("c", 1.3e-3)):
        np.savez(
            tmp_path / f"{name}.npz",
            gyro_x=rng.normal(scale=sigma, size=8000),
            time=np.arange(8000) / 50,
        )
    assert run("compare", tmp_path / "a.npz", tmp_path / "b.npz") == 0
    said = capsys.readouterr()
    assert "No difference beyond sampling" in said.out and "same samples" not in said.err
    assert run("compare", tmp_path / "a.npz", tmp_path / "a.npz") == 0
    assert "are the same samples: that they agree says nothing" in capsys.readouterr().err
    assert run("compare", tmp_path / "a.npz", tmp_path / "c.npz") == 0
    assert "differ beyond sampling in gyro_x" in capsys.readouterr().out
    assert run("compare", tmp_path / "a.npz", "preset:rga300ca") == 2
    assert "no channel in common" in capsys.readouterr().err


def test_data_list(capsys, tmp_path):
    assert run("data", "list", "--json", tmp_path / "l.json") == 0
    assert (
        "adis16405_1" in capsys.readouterr().out
        and json.loads((tmp_path / "l.json").read_text())["phone"]["licence"]
    )
    assert run("data", "fetch", "nothing") == 2
    assert "data list" in capsys.readouterr().err


def test_interrupts_and_pipes(monkeypatch, capsys):
    def stop(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(cli, "parser", stop)
    assert run("check", "x") == 130 and "Stopped" in capsys.readouterr().err


def test_results_appear_whole_or_not_at_all(tmp_path):
    target = tmp_path / "r.json"
    target.write_text("old")
    with pytest.raises(RuntimeError), common.atomic_path(target) as part:
        part.write_text("half")
        raise RuntimeError
    assert target.read_text() == "old" and len(list(tmp_path.iterdir())) == 1
    common.write_json(
        {"a": np.float64(np.nan), "b": np.arange(2), "c": np.bool_(True), "d": (1, None)}, target
    )
    assert json.loads(target.read_text()) == {"a": None, "b": [0, 1], "c": True, "d": [1, None]}
    with pytest.raises(RuntimeError), common.atomic_folder(tmp_path / "out") as part:
        (part / "x").write_text("half")
        raise RuntimeError
    assert not (tmp_path / "out").exists() and len(list(tmp_path.iterdir())) == 1
    with common.atomic_folder(tmp_path / "out") as part:
        (part / "figures").mkdir()
        (part / "figures" / "x").write_text("whole")
    assert (tmp_path / "out/figures/x").read_text() == "whole"
    with pytest.raises(InputError, match="no folder .*none; make it first"):
        common.check_writable(tmp_path / "none" / "x.json")
    # where a file stands no folder can be made: the remedy was to make it
    for check, name in ((common.check_writable, "x.json"), (common.check_out, "new")):
        with pytest.raises(InputError, match="r.json is a file, not a folder"):
            check(target / name)


def test_table_and_numbers():
    assert common.table([("a", 1), ("bb", 22)], ("x", "y")).splitlines() == [
        "x    y",
        "--  --",
        "a    1",
        "bb  22",
    ]
    with pytest.raises(argparse.ArgumentTypeError):
        common.number("inf")


def test_a_place_that_may_not_be_written_is_told_before_the_work(tmp_path, monkeypatch, capsys):
    file = tmp_path / "r.npz"
    np.savez(
        file, gyro_x=np.random.default_rng(5).normal(scale=1e-3, size=500), time=np.arange(500) / 50
    )
    monkeypatch.setattr(
        "imu_lib.writers.os.access", lambda *_, **__: False
    )  # the superuser of a test machine may write anywhere
    for argv in (
        ("check", file, "--json", tmp_path / "x.json"),
        ("characterise", file, "--out", tmp_path / "new"),
        ("gap", file, "--out", tmp_path / "new"),
        ("book", file, "--out", tmp_path / "new"),
        (
            "simulate",
            "preset:isis-imu",
            "--hours",
            1,
            "--rate",
            10,
            "--seed",
            1,
            "--out",
            tmp_path / "s.npz",
        ),
    ):
        assert run(*argv) == 2
        err = capsys.readouterr().err
        assert f"{tmp_path} may not be written to" in err and len(err.splitlines()) == 1, err
    assert [path.name for path in tmp_path.iterdir()] == ["r.npz"]
