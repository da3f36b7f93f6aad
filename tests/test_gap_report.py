"""The page of the gap workflow: everything that was found on a record stands in it."""

import json

import numpy as np
import pandas as pd
import pytest

from imu_lib.cli.main import main

FS, N = 100.0, 12_000
MODEL = {
    **{f"gyro_{a}": [{"process": "white_noise", "N": 2e-4}] for a in "xyz"},
    **{f"accel_{a}": [{"process": "white_noise", "N": 1e-3}] for a in "xyz"},
}


@pytest.fixture(scope="module")
def shaken(tmp_path_factory):
    """A record with a machine beside it, a knock, and lost rows; its model."""
    folder = tmp_path_factory.mktemp("page")
    rng, t = np.random.default_rng(4), np.arange(N) / FS
    table = {"time [s]": t}
    for kind, density, unit in (("gyro", 2e-4, "rad/s"), ("accel", 1e-3, "m/s^2")):
        for axis in "xyz":
            x = density * np.sqrt(FS) * rng.standard_normal(N)
            if kind == "accel":
                x += 8e-3 * np.sin(2 * np.pi * 23.4 * t + rng.uniform(0, 6)) - 9.81 * (axis == "z")
                x[7000:7040] += 3.0 * rng.standard_normal(40)
            table[f"{kind}_{axis} [{unit}]"] = x
    frame = pd.DataFrame(table)
    frame.iloc[57::57, 1:] = 0.0
    frame.to_csv(folder / "shaken.csv", index=False)
    (folder / "model.json").write_text(json.dumps(MODEL))
    return folder


def test_every_finding_and_interval_stands_in_the_page(shaken, capsys):
    call = ["gap", shaken / "shaken.csv", "--model", shaken / "model.json", "--simulations", "20"]
    call += ["--json", shaken / "found.json", "--out", shaken / "out", "--jobs", "1"]
    assert main([str(c) for c in call]) == 0, capsys.readouterr().err
    found = json.loads((shaken / "found.json").read_text())
    page = (shaken / "out" / "report.html").read_text(encoding="utf-8")
    steps = found["record"]["steps"]
    assert {"vibration", "dropout", "disturbance"} <= {s["effect"] for s in steps}
    for step in steps:
        for key, interval in step["intervals"].items():
            for low, high in interval if isinstance(interval[0], list) else [interval]:
                assert f"{low:.4g} to {high:.4g}" in page, (step["effect"], key)
    shaking = next(s for s in steps if s["effect"] == "vibration")
    for channel in shaking["parameters"]["channels"]:
        assert f"95 % interval of amplitude {channel}" in page
