"""The files that a call names: no output takes the place of an input or of another output, and
devices, pipes and symbolic links stay what they are.
"""

import json
import os
import threading

import numpy as np
import pytest

from imu_lib.cli import main as cli
from imu_lib.cli import named, outputs


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A folder with a short record, a model and a fleet, as the current folder."""
    monkeypatch.chdir(tmp_path)
    rng = np.random.default_rng(1)
    rows = np.column_stack([np.arange(400) / 100, rng.normal(0, 2e-3, (400, 3)) + 1e-3])
    text = "time [s],gx [rad/s],gy [rad/s],gz [rad/s]\n"
    text += "\n".join(",".join(f"{v:.7f}" for v in r) for r in rows) + "\n"
    (tmp_path / "units").mkdir()
    (tmp_path / "logs").mkdir()
    for name in ("r.csv", "units/a.csv", "logs/1.csv"):
        (tmp_path / name).write_text(text)
    model = {"gyro_x": [{"process": "white_noise", "N": 2e-4}], "rate": 100.0}
    (tmp_path / "m.json").write_text(json.dumps(model))
    (tmp_path / "d").mkdir()
    for name in ("model.json", "result.json", "report.html"):
        (tmp_path / "d" / name).write_text(json.dumps(model))
    (tmp_path / "list.csv").write_text("file\nunits/a.csv\n")
    (tmp_path / "link.csv").symlink_to("r.csv")
    return tmp_path


def content(folder):
    return {str(p): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


SIMULATE = "--hours 0.001 --rate 100 --seed 1"
OVERWRITING = [
    "check r.csv --json r.csv",
    "check r.csv --json ./units/../r.csv",
    "check link.csv --json r.csv",
    "check r.csv --json link.csv",
    "check logs --json logs/1.csv",
    "check --gyro r.csv --json r.csv",
    "check r.csv --gnss m.json --json m.json",
    "calibrate r.csv --poses m.json --json m.json",
    "characterise r.csv --json r.csv",
    "characterise r.csv --out d --json d/result.json",
    "characterise r.csv --out new --json new/model.json",
    "characterise r.csv --export kalibr --json imu.yaml",
    "compare r.csv m.json --json m.json",
    "gap r.csv --model m.json --json m.json",
    "gap r.csv --model d/model.json --out d",
    "outages r.csv --gnss m.json --model d/result.json --out d",
    f"simulate m.json {SIMULATE} --out s.npz --json m.json",
    f"simulate m.json {SIMULATE} --out s.csv --json s.csv",
    f"simulate m.json {SIMULATE} --out s.csv --temperature s.csv",
    "fleet units --out f --json units/a.csv",
    "fleet list.csv --out f --json list.csv",
    "fleet list.csv --out f --json units/a.csv",
    "exercise mark d --json d/key.json --key d/key.json",
]


@pytest.mark.parametrize("call", OVERWRITING)
def test_no_output_takes_the_place_of_what_the_call_names(here, capsys, call):
    before = content(here)
    assert cli.main(call.split()) == 2
    told = capsys.readouterr()
    assert told.out == "" and len(told.err.splitlines()) == 1, told
    assert "would overwrite" in told.err or "both write" in told.err, told.err
    assert content(here) == before


@pytest.mark.parametrize(
    "call",
    [
        "check r.csv --json d/model.json",
        "check logs --json d/model.json",
        "characterise r.csv --out d --export kalibr",
        "gap r.csv --model m.json --out d",
        f"simulate d/model.json {SIMULATE} --out d/s.csv --json d/result.json",
        f"simulate m.json {SIMULATE} --out s.csv --json /dev/null",
        "fleet units --out units --json units/said.json",
        "fleet d/fleet.parquet --out units --json r.csv",
    ],
)
def test_what_is_no_input_may_be_there_already(here, call):
    for name in ("units/said.json", "units/fleet.parquet", "d/imu.yaml"):
        (here / name).write_text("of an earlier call")
    args = cli.parser(call.split()[0]).parse_args(call.split())
    named.check(args)
    named.refuse_overwriting(args, [here / "units/a.csv"])


def test_every_file_that_a_parser_takes_is_known_as_input_or_output():
    """A flag that is new has to be added to INPUTS, or be no file."""
    other = {"json", "out", "export", "task", "action", "count", "name", "title", "accept"}
    paths = {"FILE", "MODEL", "DRIVE", "FOLDER|MANIFEST", "A", "B"}
    seen = set()
    for command in cli.there():
        sub = cli.parser(command)._subparsers._group_actions[0].choices[command]
        for action in sub._actions:
            if action.metavar in paths and action.dest not in other:
                seen.add(action.dest)
    assert seen and seen <= set(named.INPUTS)


def test_a_symbolic_link_is_followed(here):
    (here / "to.json").symlink_to("d/new.json")
    (here / "to.csv").symlink_to("d/s.csv")
    assert cli.main(["check", "r.csv", "--json", "to.json"]) == 0
    assert cli.main(f"simulate m.json {SIMULATE} --out to.csv".split()) == 0
    assert (here / "to.json").is_symlink() and (here / "to.csv").is_symlink()
    assert json.loads((here / "d/new.json").read_text())["columns"]
    assert (here / "d/s.csv").read_text().count("\n") > 100
    (here / "f").mkdir()
    (here / "f/model.json").symlink_to("../d/model.json")
    with outputs.atomic_folder("f") as folder:
        (folder / "model.json").write_text('{"a": 1, "b": 2, "c": 3}')
    assert (here / "f/model.json").is_symlink()
    assert len(json.loads((here / "d/model.json").read_text())) > 2


def test_a_pipe_is_written_through(here):
    os.mkfifo(here / "pipe.json")
    got = []
    reader = threading.Thread(target=lambda: got.append((here / "pipe.json").read_text()))
    reader.start()
    assert cli.main(["check", "r.csv", "--json", "pipe.json"]) == 0
    reader.join(10)
    assert json.loads(got[0])["columns"] and outputs.in_place(here / "pipe.json")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full on this system")
def test_a_device_stays_a_device(here, capsys):
    """The device is named by a link, so that a fault here could not replace it."""
    for name in ("full", "null"):
        (here / f"{name}.json").symlink_to(f"/dev/{name}")
    assert cli.main(["check", "r.csv", "--json", "null.json"]) == 0
    capsys.readouterr()
    assert cli.main(["check", "r.csv", "--json", "full.json"]) == 2
    assert "full.json cannot be written to: No space left" in capsys.readouterr().err
    assert all((here / f"{name}.json").is_symlink() for name in ("full", "null"))


def test_standard_output_by_its_device_is_json_alone(here, capfd):
    assert cli.main(["check", "r.csv", "--json", "/dev/stdout"]) == 0
    assert json.loads(capfd.readouterr().out)["columns"]
    assert cli.main(["check", "r.csv", "--json", "/dev/stderr"]) == 0
    assert json.loads(capfd.readouterr().err)["columns"]


@pytest.mark.parametrize("name", ["-", "https://example.org/a.csv", "file:///tmp/a.csv"])
@pytest.mark.parametrize("call", ["check {}", "gap r.csv --model {}", "compare r.csv {}"])
def test_what_is_no_file_name_is_said(here, capsys, name, call):
    assert cli.main(call.format(name).split()) == 2
    told = capsys.readouterr().err
    assert (
        "standard input" if name == "-" else "is a URL"
    ) in told and "does not exist" not in told


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="no file system that refuses files")
@pytest.mark.parametrize(
    "call", ["characterise r.csv --out /proc/xx", "check r.csv --json /proc/x.json"]
)
def test_a_file_system_that_refuses_is_said_before_the_work(here, capsys, monkeypatch, call):
    from imu_lib.cli import common

    def opened(*_, **__):
        raise AssertionError("the work has begun")

    monkeypatch.setattr(common, "open_either", opened)
    monkeypatch.setattr("imu_lib.cli.check.look", opened)
    assert cli.main(call.split()) == 2
    told = capsys.readouterr().err
    assert f"{call.split()[-1]} cannot be made: /proc may not be written to" in told
