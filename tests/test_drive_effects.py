"""The key `drive` of a model file: read, written, refused."""

import json

import numpy as np
import pytest

from imu_lib import preset
from imu_lib.drive_effects import EFFECTS, DriveEffect, off_diagonal, permutation_matrix
from imu_lib.errors import InputError
from imu_lib.model import TURN_ON, Model

SOME = {
    "gnss_time_offset": {"offset": 0.15, "velocity_offset": 0.05},
    "mounting": {"roll": 0.01, "pitch": -0.02, "yaw": 0.3},
    "axes": {"permutation": ["+y", "-x", "+z"]},
    "lever_arm": {"arm": [1.0, 0.2, -1.3]},
    "accel_scale": {"scale": [0.01, 0.0, -0.02]},
    "gyro_scale": {"scale": [0.01, 0.0, -0.02]},
    "accel_misalignment": {"matrix": [0.01, 0.0, 0.0, 0.02, 0.0, -0.01]},
    "gyro_misalignment": {"matrix": [0.01, 0.0, 0.0, 0.02, 0.0, -0.01]},
    "gyro_g_sensitivity": {"matrix": [1e-4] * 9},
    "accel_bias": {"bias": [0.1, 0.2, 0.3]},
    "gyro_bias": {"bias": [1e-3, 0.0, 2e-3]},
    "bias_model": {
        "channel": "gyro_x",
        "process": "white_noise",
        "name": "N",
        "from": 1e-4,
        "to": 2e-4,
    },
    "vibration": {"channel": "accel_z", "N": 1e-3, "N_per_speed": 1e-3},
    "gnss_noise": {"ratio": 2.0, "of": "velocity"},
    "gnss_correlated": {"sigma": 1.5, "correlation_time": 60.0},
    "gnss_outliers": {"fraction": 0.02, "scale": 30.0},
    "heading": {"error": 0.1},
    "imu_clock": {"scale": 1e-4},
}


def test_every_effect_goes_into_a_file_and_out_of_it(tmp_path):
    assert set(SOME) == set(EFFECTS)
    model = preset("3dm-gx3-25-2013").with_drive(DriveEffect(n, p) for n, p in SOME.items())
    model.save(tmp_path / "model.json")
    again = Model.load(tmp_path / "model.json")
    assert again.drive == model.drive and again.channels == model.channels
    stored = json.loads((tmp_path / "model.json").read_text())["drive"]
    assert stored == [{"effect": n, "parameters": p} for n, p in SOME.items()]
    assert "drive" not in preset("3dm-gx3-25-2013").to_json()


def test_a_step_of_a_result_and_flat_entries_are_read():
    step = {
        "effect": "gnss_time_offset",
        "parameters": {"offset": 0.1},
        "intervals": {"offset": [0.09, 0.11]},
        "where": "velocity innovations along the track",
        "confidence": 0.99,
    }
    flat = {"effect": "gnss_time_offset", "offset": 0.1}
    assert DriveEffect.from_json(step) == DriveEffect.from_json(flat)
    matrix = {"effect": "gyro_g_sensitivity", "matrix": [[1, 2, 3], [4, 5, 6], [7, 8, 9]]}
    assert DriveEffect.from_json(matrix)["matrix"] == tuple(range(1, 10))


@pytest.mark.parametrize(
    "entry, said",
    [
        ({"effect": "lever", "arm": [0, 0, 0]}, "unknown effect 'lever'"),
        ({"effect": "lever_arm", "offset": 1}, "no parameter 'offset'"),
        ({"effect": "lever_arm"}, "needs the parameter 'arm'"),
        ({"effect": "lever_arm", "arm": [0, 0]}, "a list of 3 finite numbers"),
        ({"effect": "lever_arm", "arm": "here"}, "a list of 3 finite numbers"),
        ({"effect": "imu_clock", "scale": float("nan")}, "a finite number"),
        ({"effect": "imu_clock", "scale": True}, "a finite number"),
        ({"effect": "axes", "permutation": ["+x", "+x", "+z"]}, "x, y and z once each"),
        ({"effect": "axes", "permutation": "+x"}, "three of"),
        ({"effect": "gnss_noise", "ratio": 2.0, "of": "time"}, "position or velocity"),
        ({"effect": "axes", "permutation": ["+y", "+x", "+z"]}, "left-handed"),
        ({"effect": "gnss_noise", "ratio": 0.0, "of": "position"}, "above 0"),
        ({"effect": "gnss_outliers", "fraction": 1.0, "scale": 3.0}, "below 1"),
        ({"effect": "vibration", "channel": "gyro_w", "N_per_speed": 1.0}, "one of gyro_x"),
        ({"parameters": {}}, 'its name under "effect"'),
        ("mounting", 'its name under "effect"'),
    ],
)
def test_what_is_wrong_is_said_with_its_place(entry, said):
    content = {**preset("3dm-gx3-25-2013").to_json(), "drive": [entry]}
    with pytest.raises(InputError, match="file.json: drive, entry 1: ") as caught:
        Model.from_json(content, where="file.json")
    assert said in str(caught.value)


def test_the_list_and_the_bias_at_switch_on():
    content = preset("3dm-gx3-25-2013").to_json()
    with pytest.raises(InputError, match="must be a list"):
        Model.from_json({**content, "drive": {"effect": "heading"}})
    for wrong in ({"gyro": -1.0}, {"gyros": 1.0}, {"gyro": True}, 3.0):
        with pytest.raises(InputError, match="`turn_on`"):
            Model.from_json({**content, "turn_on": wrong})
    model = Model.from_json({**content, "turn_on": {"gyro": 1e-4}})
    assert model.turn_on == (1e-4, TURN_ON["accel"])
    assert Model.from_json(model.to_json()).turn_on == model.turn_on


def test_the_matrices_are_those_of_the_vocabulary():
    # the first entry is what stands in the file's x
    assert permutation_matrix(("+y", "-x", "+z")) @ [1.0, 2.0, 3.0] == pytest.approx([2, -1, 3])
    assert np.array_equal(off_diagonal((1, 2, 3, 4, 5, 6)), [[0, 1, 2], [3, 0, 4], [5, 6, 0]])
