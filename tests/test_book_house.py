"""The picture of the house is of the imports as they are; buttons to elsewhere need an address."""

import xml.etree.ElementTree as tree

import yaml

from conftest import ROOT
from imu_lib.book import house, launch

TEXT = (ROOT / "book/contributing.md").read_text(encoding="utf-8")


def test_imports_are_read_in_every_way_they_are_written(tmp_path):
    (tmp_path / "high").mkdir()
    (tmp_path / "high/__init__.py").write_text("from imu_lib import low\nfrom .own import x\n")
    (tmp_path / "high/own.py").write_text(
        "import imu_lib.middle\ndef f():\n    from imu_lib.base.part import y\n"
    )
    for name in ("low", "middle", "base"):
        (tmp_path / f"{name}.py").write_text("")
    (tmp_path / "middle.py").write_text("from imu_lib.base import z\nimport numpy\n")
    edges = house.imports(tmp_path)
    assert edges == {
        "high": {"low", "middle", "base"},
        "low": set(),
        "middle": {"base"},
        "base": set(),
    }
    assert house.needed(edges)["high"] == {"low", "middle"}  # base comes by way of middle


def test_the_picture_has_every_room_and_lines_that_go_down():
    table, edges = house.layers(TEXT), house.imports()
    assert set(table) == set(edges)
    picture = tree.fromstring(house.drawing(table, edges))
    ns = {"s": "http://www.w3.org/2000/svg"}
    rooms = [g.find("s:text", ns).text for g in picture.findall("s:g", ns)]
    assert sorted(rooms) == sorted(table)
    lines = picture.findall("s:path", ns)
    starts = [float(line.get("d").split("C")[0].split()[1]) for line in lines]
    ends = [float(line.get("d").split()[-1]) for line in lines]
    assert lines and all(end > start for start, end in zip(starts, ends))
    assert house.MARK in TEXT


def test_buttons_only_where_the_project_has_an_address(tmp_path, monkeypatch):
    for name in ("IMU_LIB_REPOSITORY", "GITHUB_SERVER_URL", "GITHUB_REPOSITORY"):
        monkeypatch.delenv(name, raising=False)
    (tmp_path / "book").mkdir()
    path = tmp_path / "book/_config.yml"
    text = (ROOT / "book/_config.yml").read_text(encoding="utf-8")
    path.write_text(text, encoding="utf-8")
    launch.write(tmp_path)
    assert path.read_text(encoding="utf-8") == text
    monkeypatch.setenv("GITHUB_SERVER_URL", "https://github.com")
    monkeypatch.setenv("GITHUB_REPOSITORY", "owner/name")
    launch.write(tmp_path)
    config = yaml.safe_load(path.read_text(encoding="utf-8"))
    assert config["repository"]["url"] == "https://github.com/owner/name"
    assert "mybinder.org" in config["launch_buttons"]["binderhub_url"]
    assert (ROOT / ".binder/requirements.txt").read_text().strip() == "-r ../environment.txt"
