"""The README's example runs as it stands, and what it names exists."""

import re

from conftest import ROOT

TEXT = (ROOT / "README.md").read_text(encoding="utf-8")


def test_example_runs():
    code = re.search(r"```python\n(.*?)```", TEXT, re.DOTALL)[1]
    names = {}
    exec(compile(code, "README.md", "exec"), names)
    fit = names["fit"]
    assert fit.parameters["N"].low < fit.parameters["N"].value < fit.parameters["N"].high


def test_the_record_at_hand_needs_no_flags(capsys):
    from imu_lib.cli.main import main

    file = re.search(r"`(data/\S+\.csv)` states its units", TEXT)[1]
    assert (
        main(["check", str(ROOT / file)]) == 0
        and "rate             100 Hz" in capsys.readouterr().out
    )


def test_commands_and_files_exist():
    from imu_lib.cli.main import COMMANDS

    assert set(COMMANDS) == set(
        re.findall(r"`(\w+)`", TEXT.split("lists the commands:")[1].split(".")[0])
    )
    for folder in re.findall(r"`(\w+)/`", TEXT):
        assert (ROOT / folder).is_dir(), folder
    for path in re.findall(r"\]\(([\w/.]+)\)", TEXT):
        assert (ROOT / path).is_file(), path
