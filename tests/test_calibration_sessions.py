"""Calibration from files of poses and of public sessions, against what other programs made of them."""

import json

import numpy as np
import pytest

from imu_lib import calibration as cal
from imu_lib.calibration import simulated
from imu_lib.errors import InputError
from imu_lib.units import DEG


def test_poses_file(tmp_path):
    rng = np.random.default_rng(10)
    sensor = cal.triad((0, 0, -0.004), (0, 0, 0.28 * DEG))
    rates, y = simulated.stepped_table(sensor, 20.0, noise=simulated.white(0.1 * DEG, rng))
    file = tmp_path / "table.csv"
    rows = [f"{20 * k + 10},{20 * k + 20},{r / DEG}" for k, r in enumerate(rates)]
    file.write_text("\n".join(["start,stop,rate_z", *rows]))
    found = cal.calibrate(None, y, 20.0, sections=cal.read_poses(file, 20.0))
    assert found.accelerometers is None and found.gyroscopes.scale_factors[0] is None
    assert found.gyroscopes.scale_factors[2].covers(-0.004) and found.gyroscopes.biases[2].covers(
        0.28 * DEG
    )
    for text, match in (
        ("a,b\n1,2", "start and stop"),
        ("start,stop,rate_z\n0,1,fast", "row 2, column rate_z"),
        ("start,stop,x\n0,1,", "row 2 says nothing"),
        ("start,stop,x\n,1,2", "row 2 has no start"),
        ("start,stop,x\n0,1,nan", "row 2, column x: 'nan' is not a number"),
        ("start,stop,x,y,z\n0,1,9.8,0,0\n2,3,0,-9.8,0", "are in g, and those of every row are 9.8"),
        ("", "no pose"),
    ):
        file.write_text(text)
        with pytest.raises(InputError, match=match):
            cal.read_poses(file, 20.0)
    file.write_text("start;stop;z\n0,5;1;-1")  # as a spreadsheet with decimal commas saves it
    (one,) = cal.read_poses(file, 20.0)
    assert (one.start, one.stop, *one.force) == (0.5, 1.0, 0.0, 0.0, -1.0)
    with pytest.raises(InputError, match="cannot be read"):
        cal.read_poses(tmp_path / "none.csv", 20.0)
    (tmp_path / "s.json").write_text('{"x_q": {"start": 1, "stop": 2}}')
    with pytest.raises(InputError, match="x_q"):
        cal.read_poses(tmp_path / "s.json", 20.0)


def test_ferraris_session_equals_imucal(data_dir):
    """imucal 2.6.0 on the same session, computed with its own FerrarisCalibration (gravity 9.81,
    angle 360 deg).
    """
    folder = data_dir / "calibration"
    table = np.genfromtxt(folder / "ferraris_session.csv", delimiter=",", names=True)
    accel = np.column_stack([table[f"acc_{a}"] for a in "xyz"])
    gyro = np.column_stack([table[f"gyr_{a}"] for a in "xyz"]) * DEG
    sections = json.loads((folder / "ferraris_session.json").read_text())
    means = {k: accel[v["start"] : v["end"]].mean(axis=0) for k, v in sections.items()}
    matrix, bias = cal.ferraris(
        [means[a + "_p"] for a in "xyz"], [means[a + "_a"] for a in "xyz"], gravity=9.81
    )
    assert np.allclose(
        matrix,
        [
            [0.996608343, -0.01478231, -0.007457416],
            [0.008597647, 1.002399045, 0.001848012],
            [0.013643076, 0.002050493, 1.02330235],
        ],
        atol=1e-8,
    )
    assert np.allclose(bias, [0.537117424, -0.616202993, 0.398867342], atol=1e-8)
    found = cal.calibrate(
        accel,
        gyro,
        204.8,
        sections=cal.read_poses(folder / "ferraris_session.json", 204.8),
        gravity=9.81,
    )
    assert np.allclose(found.accelerometers.matrix, matrix, atol=1e-8)
    theirs = [
        [0.5139515, -0.0002334, -0.0032953],
        [-0.0001092, 0.4912120, -0.0013674],
        [0.0048488, 0.0038142, 0.4991171],
    ]
    # imucal takes g-sensitivity out of the gyroscopes before the turns; its effect on M is 3e-5
    assert np.allclose(found.gyroscopes.matrix, theirs, atol=1e-4)


def test_xsens_poses(data_dir):
    """The public record of Tedaldi et al.: a residual of 1e-3 m/s^2 is 0.1 mg, a tenth of the
    noise per sample.
    """
    d = np.load(data_dir / "calibration/xsens_mti_poses.npz")
    found = cal.calibrate(
        d["accel_counts"],
        d["gyro_counts"],
        100.0,
        gravity=9.81744,
        accel_nominal=None,
        gyro_nominal=None,
    )
    assert 36 <= len(found.rests) <= 42
    assert found.accelerometers.residual_sd < 2e-3
    assert np.allclose(found.gyroscopes.matrix.diagonal(), 4770, rtol=0.005)
    assert 0.5 < found.gyroscopes.consistency < 2.0
