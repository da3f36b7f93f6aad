"""What the gap workflow wrote of a drive is taken by `outages` and by the workflow itself."""

import dataclasses
import html
import json

import drive_generator as generator
import numpy as np
import pytest

from imu_lib import gap
from imu_lib.cli import gap_drive_report
from imu_lib.cli.main import main
from imu_lib.drive import from_arrays
from imu_lib.drive_effects import DriveEffect
from imu_lib.model import Model

MODEL = Model.from_json(generator.MODEL)
ARM = [1.4, 0.9, -1.1]  # m, in the vehicle's axes
ANGLES = {"roll": 0.03, "pitch": -0.1, "yaw": 0.4}  # rad: the arm is elsewhere in the case's axes


@pytest.fixture(scope="module")
def drive():
    effects = [("mounting", ANGLES), ("lever_arm", {"arm": ARM})]
    return from_arrays(generator.make(31, effects=effects, duration=300.0), "turned")


@pytest.fixture(scope="module")
def files(drive, tmp_path_factory):
    folder = tmp_path_factory.mktemp("turned")
    drive.save(folder / "drive.npz")
    MODEL.save(folder / "base.json")
    out = str(folder / "out")
    said = str(folder / "gap.json")
    assert not main(
        ["gap", str(folder / "drive.npz"), "--model", str(folder / "base.json"), "--out", out, "--json", said]
    )  # fmt: skip
    return folder


def worst(files, model):
    """Median over the windows of the largest error against the truth, m."""
    out = files / "outages.json"
    flags = ["--models", "18AV", "--duration", "30", "--as-stated", "--json", str(out)]
    assert not main(["outages", str(files / "drive.npz"), "--model", str(model), *flags])
    content = json.loads(out.read_text())
    return {n: np.median(m["against"]["reference"]["max"]) for n, m in content["models"].items()}


def test_both_are_found_in_the_vehicles_axes(files):
    steps = {s["effect"]: s for s in json.loads((files / "gap.json").read_text())["drive"]["steps"]}
    assert {"mounting", "lever_arm"} <= set(steps)
    found = steps["lever_arm"]
    for k in (0, 1):  # the drive shows the antenna's height hardly at all
        low, high = found["intervals"]["arm"][k]
        half = 0.5 * (high - low)
        # four standard deviations, and what the mounting's own error turns of the arm
        assert abs(found["parameters"]["arm"][k] - ARM[k]) < 2.0 * half + 0.05


def test_outages_take_the_model_file(files):
    held = Model.load(files / "out" / "model.json")
    assert {"mounting", "lever_arm"} <= {e.name for e in held.drive}
    before, after = worst(files, files / "base.json"), worst(files, files / "out" / "model.json")
    for name in before:
        assert after[name] < before[name]


@pytest.fixture(scope="module")
def again(files, drive):
    held = Model.load(files / "out" / "model.json")
    return gap.close(drive, held, judge=False, random=False)


def test_the_search_starts_where_the_file_stands(files, again):
    held = Model.load(files / "out" / "model.json")
    assert list(again.to_json()) == ["drive"]
    arms = [next(e["arm"] for e in m.drive if e.name == "lever_arm") for m in (held, again.model)]
    assert arms[1] == pytest.approx(arms[0], abs=0.1)
    assert again.after.index < 3.0


def test_the_page_says_what_the_terminal_says(again, tmp_path):
    noted = dataclasses.replace(again, notes=("a note < of the drive",))
    gap_drive_report.write(noted, tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "a note &lt; of the drive" in page
    assert again.invisible  # or nothing is asked below
    for entry in again.invisible:
        assert html.escape(entry["why"]) in page
        component = entry["parameter"].partition(" ")[2]
        assert f"{component} {entry['upper_limit']:.3g}".strip() in page
    # a long reason runs over lines, or the table is wider than the page
    assert "<td class=words>" in page


def test_what_a_model_holds_and_a_drive_has_not_is_let_go():
    # it stayed where it was put, and two noises of the accelerometers made up for it
    drive = from_arrays(generator.make(32, duration=150.0, rate=50.0), "plain")
    wrong = MODEL.with_drive((DriveEffect("lever_arm", {"arm": [1.5, -0.8, -1.2]}),))
    found = gap.close(drive, wrong, judge=False)
    assert not found.steps and found.unexplained is None
    assert not found.model.drive
