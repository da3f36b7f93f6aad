"""What a new user does wrong with `check`, `characterise` and `gap`: one plain sentence on
standard error, exit 2, no traceback.
"""

import numpy as np
import pytest

from imu_lib.cli import main as cli

HEADER = "time,gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z"
UNITS = ("--gyro-unit", "deg/s", "--accel-unit", "g")
COMMANDS = ("check", "characterise", "gap")


def noise(n=2400, seed=1):
    rng = np.random.default_rng(seed)
    return np.column_stack(
        [np.arange(n) / 100, rng.normal(0, 0.05, (n, 3)), rng.normal(0, 0.003, (n, 3)) + [0, 0, 1]]
    )


def written(path, rows, header=HEADER, damage=None):
    lines = [header, *(",".join(f"{v:.6f}" for v in row) for row in rows)]
    if damage:
        lines = damage(lines)
    path.write_text("\n".join(lines) + "\n")
    return path


def refused(capsys, *argv):
    """The sentence with which a call is refused."""
    assert cli.main([str(a) for a in argv]) == 2
    told = capsys.readouterr()
    assert told.out == "", "nothing is printed as if it were a result"
    sentence = [
        line for line in told.err.splitlines() if not line.startswith(("note: ", "characterising "))
    ]
    assert len(sentence) == 1 and sentence[0].startswith("imu-lib") and sentence[0].endswith("."), (
        told.err
    )
    return sentence[0]


def with_text(lines):
    return [*lines[:1200], lines[1200].replace(lines[1200].split(",")[3], "abc"), *lines[1201:]]


@pytest.mark.parametrize("command", COMMANDS)
def test_wrong_files(command, tmp_path, capsys):
    few, rows = noise(40), noise()
    cases = [
        (
            written(tmp_path / "names.csv", rows[:, :4], "time,foo,bar,baz"),
            "names no gyro or accelerometer; name them by position with --columns",
        ),
        (
            written(tmp_path / "text.csv", rows, damage=with_text),
            "line 1201, column 4 (gyro_z): 'abc' is not a number",
        ),
        (
            written(tmp_path / "untimed.csv", few[:, 1:], HEADER.removeprefix("time,")),
            "give --rate HZ",
        ),
        (
            written(tmp_path / "bare.csv", few, damage=lambda lines: lines[:1]),
            "holds no rows of numbers",
        ),
        (written(tmp_path / "empty.csv", few, damage=lambda lines: []), "is empty"),
        (tmp_path / "nowhere.csv", "does not exist; check the path"),
        (tmp_path, "is a directory; name the file in it"),
    ]
    for path, why in cases:
        sentence = refused(capsys, command, path, *UNITS)
        assert why in sentence and path.name in sentence


@pytest.mark.parametrize("command", COMMANDS)
def test_wrong_units(command, tmp_path, capsys):
    file = written(tmp_path / "record.csv", noise(400))
    for units, why in [
        ((), "does not state the unit of its gyro columns; give --gyro-unit"),
        (("--gyro-unit", "degrees", "--accel-unit", "g"), "--gyro-unit 'degrees' is not known"),
        (
            ("--gyro-unit", "deg/s", "--accel-unit", "m/s^2"),
            "its unit is likely g; correct --accel-unit",
        ),
    ]:
        assert why in refused(capsys, command, file, *units)


def test_gap_refuses_what_has_no_noise(tmp_path, capsys):
    rows = noise()
    rows[:, 1:] = [0, 0, 0, 0, 0, 1]
    sentence = refused(capsys, "gap", written(tmp_path / "still.csv", rows), *UNITS)
    assert "no channel says anything of its noise" in sentence
    assert "too few; the gap workflow needs 2000" in refused(
        capsys, "gap", written(tmp_path / "few.csv", noise(300)), *UNITS
    )
    assert "--seed -1 must be 0 or above" in refused(
        capsys, "gap", tmp_path / "few.csv", *UNITS, "--seed", "-1"
    )


def test_gap_leaves_out_dead_channels_and_long_holes(tmp_path, capsys):
    """Left in, a dead channel stops the workflow, and a hole that is filled is taken for lines of
    the sensor.
    """
    rows = np.concatenate([noise(2400, 2), noise(2400, 3)])
    rows[2400:, 0] += 624.0
    rows[:, 1], rows[1500:, 2] = 0.25, rows[1499, 2]  # one never alive, one dies
    rows[np.random.default_rng(4).random(4800) < 0.98, 3] = 0.0  # one rounded away
    file = written(
        tmp_path / "damaged.csv", rows[:, [0, 1, 2, 3, 4]], "time,gyro_x,gyro_y,gyro_z,accel_x"
    )
    assert (
        cli.main(["gap", str(file), *UNITS, "--trust-units", "--simulations", "0", "--jobs", "1"])
        == 0
    )
    told = capsys.readouterr()
    for note in (
        "gyro_x never changes; it is left out",
        "gyro_y is stuck at one value for 69% of the record; it is left out",
        "gyro_z has one value in 98% of its samples",
        "The longest stretch without a tilt, a restart or a long hole is taken: 624 to 648",
    ):
        assert note in told.err
    verdict, table = told.out.split("channel    found")
    said = " ".join(verdict.split())
    assert "on all channels that are left" in said and "yro_x never changes" in said
    assert "accel_x" in table and "gyro" not in table and "sinusoid" not in told.out
    assert "[#" not in told.err, "no progress bar where standard error is no terminal"
