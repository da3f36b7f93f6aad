"""`imu-lib calibrate`: result, figures, one-sentence refusals."""

import json

import numpy as np
import pytest

from imu_lib import calibration as cal
from imu_lib.calibration import simulated
from imu_lib.cli.main import main
from imu_lib.units import DEG

COLUMNS = "time,accel_x,accel_y,accel_z,gyro_x,gyro_y,gyro_z"


@pytest.fixture(scope="module")
def truth():
    return cal.triad((0.004, -0.003, 0.006), (0.1, -0.05, 0.2)), cal.triad(
        (0.01, 0.0, -0.01), (0.01, -0.02, 0.0)
    )


@pytest.fixture(scope="module")
def record(tmp_path_factory, truth):
    rng = np.random.default_rng(1)
    accel, gyro = simulated.hand_held(
        16,
        50.0,
        rng,
        accelerometers=truth[0],
        gyroscopes=truth[1],
        rest=3.0,
        accel_noise=simulated.white(0.02, rng),
        gyro_noise=simulated.white(0.002, rng),
    )
    path = tmp_path_factory.mktemp("calibrate") / "poses.npz"
    np.savez(path, time=np.arange(len(accel)) / 50.0, accel=accel, gyro=gyro)
    return path


def test_poses_by_hand(record, truth, tmp_path, capsys):
    out, result = tmp_path / "out", tmp_path / "result.json"
    assert main(["calibrate", str(record), "--out", str(out), "--json", str(result)]) == 0
    text = capsys.readouterr().out
    assert "accelerometers" in text and "gyroscopes" in text and "16 windows" in text
    found = json.loads(result.read_text())
    for kind, true in zip(("accelerometers", "gyroscopes"), truth):
        for i, axis in enumerate("xyz"):
            e = found[kind]["scale_factor"][axis]
            # the interval of one record may miss once in twenty: three times its half width does
            # not
            assert abs(e["value"] - (true.matrix[i, i] - 1)) < 1.5 * (e["high"] - e["low"])
    assert {p.name for p in out.iterdir()} == {"calibration.json", "rests.png", "poses.png"}
    assert json.loads((out / "calibration.json").read_text()) == found


def test_rate_table_with_one_gyroscope(tmp_path, capsys):
    rng = np.random.default_rng(2)
    rates, y = simulated.stepped_table(
        cal.triad((0, 0, -0.004), (0, 0, 0.28 * DEG)), 20.0, noise=simulated.white(1e-3, rng)
    )
    np.savez(tmp_path / "table.npz", time=np.arange(len(y)) / 20.0, gyro_z=y[:, 2])
    rows = [f"{20 * k + 10},{20 * k + 20},{r / DEG}" for k, r in enumerate(rates)]
    (tmp_path / "steps.csv").write_text("\n".join(["start,stop,rate_z", *rows]))
    call = [
        "calibrate",
        str(tmp_path / "table.npz"),
        "--poses",
        str(tmp_path / "steps.csv"),
        "--json",
        "-",
    ]
    assert main(call) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["accelerometers"] is None and found["gyroscopes"]["scale_factor"]["x"] is None
    e = found["gyroscopes"]["scale_factor"]["z"]
    assert abs(e["value"] + 0.004) < 1.5 * (e["high"] - e["low"])


def refusal(capsys, *call):
    assert main(["calibrate", *map(str, call)]) == 2
    out = capsys.readouterr()
    assert out.out == "" and "Traceback" not in out.err
    return out.err


def test_refusals(record, tmp_path, capsys):
    data = np.load(record)
    rng = np.random.default_rng(3)
    still, moving = tmp_path / "still.npz", tmp_path / "moving.npz"
    np.savez(
        still, time=np.arange(3000) / 50.0, accel=rng.normal(0, 0.02, (3000, 3)) + [0, 0, -9.81]
    )
    np.savez(
        moving, time=np.arange(3000) / 50.0, accel=rng.normal(0, 4.0, (3000, 3)) + [0, 0, -9.81]
    )
    np.savez(tmp_path / "gyro.npz", time=data["time"], gyro=data["gyro"])
    assert "1 pose at rest cannot determine 9" in refusal(capsys, still)
    assert "never at rest" in refusal(capsys, moving)
    assert "need three accelerometers" in refusal(capsys, tmp_path / "gyro.npz")
    assert "poses cannot be read" in refusal(capsys, record, "--poses", tmp_path / "none.csv")
    assert "is a file" in refusal(capsys, record, "--out", record)
    assert "not that of any place on Earth" in refusal(capsys, record, "--gravity", 1)
    assert "not both" in refusal(capsys, record, "--gravity", 9.8, "--latitude", 51)
    assert "between -90 and 90" in refusal(capsys, record, "--latitude", 91)
    assert "needs --latitude" in refusal(capsys, record, "--height", 100)
    np.savez(
        tmp_path / "in_g.npz", time=data["time"], accel=data["accel"] / 9.80665, gyro=data["gyro"]
    )
    assert "likely g" in refusal(capsys, tmp_path / "in_g.npz")
    assert not list(tmp_path.glob(".*"))


def test_gravity_of_the_place():
    """Calgary, 51.08 deg north and 1,100 m: the 2008 paper used 9.8080; normal gravity knows no
    local anomaly (1e-3).
    """
    from argparse import Namespace

    from imu_lib.cli.calibrate import local_gravity

    assert (
        abs(local_gravity(Namespace(gravity=None, latitude=51.08, height=1100.0)) - 9.8080) < 1e-3
    )
    assert local_gravity(Namespace(gravity=None, latitude=None, height=None)) == 9.80665
