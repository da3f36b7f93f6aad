"""Arrays of a drive that cannot be what their keys say are refused in a sentence with the remedy."""

import drive_generator as generator
import numpy as np
import pytest

from imu_lib.cli.main import main
from imu_lib.drive import from_arrays
from imu_lib.errors import InputError
from imu_lib.health import fixes
from imu_lib.model import Model


@pytest.fixture(scope="module")
def arrays():
    return generator.make(57, duration=60.0, rate=50.0)


def refused(arrays, key, value):
    with pytest.raises(InputError) as error:
        from_arrays({**arrays, key: value}, "x.npz")
    return str(error.value)


def put(value, at, number):
    value = np.array(value, float)
    value[at] = number
    return value


def test_positions_of_other_kinds(arrays):
    place = arrays["gnss_position"]
    assert "looks like degrees, multiply them by pi/180" in refused(
        arrays, "gnss_position", place * [180 / np.pi, 180 / np.pi, 1.0]
    )
    earth = 6.37e6 * np.column_stack([np.cos(place[:, 0]), np.sin(place[:, 0]), place[:, 1]])
    assert "metres from the Earth's centre" in refused(arrays, "gnss_position", earth)
    assert "metres from an origin" in refused(
        arrays, "gnss_position", (place - place[0]) * [6.37e6, 6.37e6, 1.0] + 99
    )
    assert "no position that is a number" in refused(arrays, "gnss_position", np.nan * place)


def test_a_reference_in_degrees(arrays):
    attitude = np.zeros((len(arrays["reference_time"]), 3))
    assert "multiply them by pi/180" in refused(
        arrays, "reference_attitude", attitude + [1.0, 2.0, 170.0]
    )
    turns = attitude + [0.0, 0.1, 31.0]  # yaw may count its turns
    assert from_arrays({**arrays, "reference_attitude": turns}, "x").reference_attitude is not None


def test_numbers_that_are_none(arrays):
    assert "`gyro` is not a number at sample 20 (nan, 1 such" in refused(
        arrays, "gyro", put(arrays["gyro"], (20, 1), np.nan)
    )
    assert "`accel` is not a number at sample 3 (inf, 1 such" in refused(
        arrays, "accel", put(arrays["accel"], (3, 0), np.inf)
    )
    said = refused(
        arrays, "gnss_position_sd", put(np.ones_like(arrays["gnss_position"]), (7, 1), -1.0)
    )
    assert "-1 at row 7, column 1" in said and "write nan" in said


def test_fixes_without_positions_are_no_record_at_rest(arrays, tmp_path, capsys):
    np.savez(tmp_path / "x.npz", **{k: v for k, v in arrays.items() if k != "gnss_position"})
    assert main(["check", str(tmp_path / "x.npz")]) == 2
    assert "has no `gnss_position`" in capsys.readouterr().err


def test_fix_codes_that_are_not_there(arrays, tmp_path, capsys):
    np.savez(tmp_path / "x.npz", **arrays)
    call = [
        "outages",
        str(tmp_path / "x.npz"),
        "--accept",
        "4",
        "--windows",
        "40:10",
        "--as-stated",
    ]
    assert not main([*call, "--models", "18AV"])
    assert "--accept has no effect" in capsys.readouterr().err


def test_a_model_without_a_channel_is_told_before_the_work(arrays, tmp_path, capsys):
    np.savez(tmp_path / "x.npz", **arrays)
    (tmp_path / "m.json").write_text('{"gyro_x": [{"process": "white_noise", "N": 1e-4}]}')
    call = [
        "outages",
        str(tmp_path / "x.npz"),
        "--model",
        str(tmp_path / "m.json"),
        "--windows",
        "40:10",
    ]
    assert main(call) == 2
    assert "m.json: the error model has no channel gyro_y" in capsys.readouterr().err


@pytest.mark.parametrize("part", ["position", "velocity"])
def test_deviations_of_nothing_are_said(arrays, part):
    sd = np.full((len(arrays["gnss_time"]), 3), 0.5)
    sd[7] = 0.0
    key = f"gnss_{part}_sd"
    (said,) = fixes.exact(from_arrays({**arrays, key: sd}, "x"))
    assert said.startswith(f"1 of {len(sd)} fixes state that their {part} errs by nothing")
    assert not fixes.exact(from_arrays({**arrays, key: np.maximum(sd, 0.1)}, "x"))


def test_a_value_that_begins_with_a_minus(capsys):
    assert main(["outages", "d.npz", "--windows", "-5:10"]) == 2
    assert "as in `--windows=-5`" in capsys.readouterr().err


def test_an_effect_of_a_model_is_named_once(tmp_path):
    path = tmp_path / "m.json"
    path.write_text('{"name": "x", "drive": [{"effect": "foo"}]}')
    with pytest.raises(InputError) as error:
        Model.load(path)
    assert str(error.value).count("m.json") == 1
