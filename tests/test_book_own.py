"""`imu-lib book FILE`: a verdict on page one, all axes, the user's words, nothing about any other
record.
"""

import re
import shlex

import browser as chromium
import numpy as np
import pytest

from conftest import ROOT
from imu_lib.book import build, own
from imu_lib.cli.book import FLAGS, _of_record
from imu_lib.cli.main import joined, main, parser
from imu_lib.errors import InputError
from imu_lib.processes import GaussMarkov, WhiteNoise
from imu_lib.record import Record

#: What only the embedded records, the papers' sensors or their truth may be called.
OTHERS = re.compile(
    r"\btwins?\b|embedded|secret|3DM|GX3|RGA300|ISIS|Quinchia|the paper|the truth|20(08|11|13) ",
    re.I,
)
PAGES = ("verdict", "record_and_health", "allan_deviation", "maximum_likelihood", "simulation_gap")


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """The book on four axes of a record with a known sensor, and page one's path."""
    folder = tmp_path_factory.mktemp("own")
    rng = np.random.default_rng(20130724)
    gyro = WhiteNoise(N=2e-4) + GaussMarkov(sigma=5e-5, correlation_time=5.0)
    signals = {"gyro_x": gyro.simulate(6000, 50.0, rng) + 0.01}
    for axis, mean in (("x", 0.1), ("y", -0.2), ("z", -9.65)):
        signals[f"accel_{axis}"] = WhiteNoise(N=2e-3).simulate(6000, 50.0, rng) + mean
    path = folder / "bench test_7.npz"
    np.savez(path, time=np.arange(6000) / 50.0, **signals)
    assert main(["book", str(path), "--out", str(folder / "mine")]) == 0
    return folder / "mine/own/verdict.html"


def words(path):
    text = re.sub(
        r"<(script|style)[^>]*>.*?</\1>", " ", path.read_text(encoding="utf-8"), flags=re.S
    )
    return " ".join(re.sub(r"<[^>]+>", " ", text).split())


def test_page_one_is_a_verdict(page):
    text = words(page)
    for heading in (
        "Which grade",
        "Gravity",
        "What is wrong",
        "What limits",
        "What to record next",
    ):
        assert heading in text
    # N = 2e-4 rad/s/sqrt(Hz) in deg/sqrt(h), known to two per cent
    assert (
        abs(float(re.search(r"low-cost MEMS.{0,80}?noise, ([\d.]+) deg", text)[1]) / 0.6875 - 1)
        < 0.03
    )
    assert "bench test_7" in text and "gyro_x, accel_x, accel_y, accel_z" in text
    assert "9.652" in text and "1.6 % below gravity" in text and "poses" in text
    call = "imu-lib characterise"
    assert call in text and "bench test_7.npz" in text
    assert "Traceback" not in text


def test_every_page_is_there_and_of_all_axes(page):
    for name in PAGES:
        assert (page.parent / f"{name}.html").is_file()
    assert "accel_z" in words(page.parent / "maximum_likelihood.html")
    files = {path.name for path in (page.parents[1] / "downloads").iterdir()}
    assert {"model.json", "result.json"} <= files
    links = re.findall(r'href="(\.\./downloads/[^"]+)"', page.read_text(encoding="utf-8"))
    assert {link.rpartition("/")[2] for link in links} == files


def test_nothing_speaks_of_another_record(page):
    for path in page.parent.glob("*.html"):
        assert not OTHERS.search(words(path)), (path.name, OTHERS.search(words(path)))
        assert "Axes:" not in words(path), path.name  # what a figure is called in Python
    for name in ("own_record.md", "own_drive.md"):
        text = (ROOT / "book" / name).read_text(encoding="utf-8")
        assert not OTHERS.search(text), OTHERS.search(text)


def test_the_pages_are_quiet(page, tmp_path):
    if chromium.found() is None:
        pytest.skip("neither Chromium nor Chrome is installed")
    window = chromium.Browser(chromium.found(), tmp_path)
    try:
        for path in page.parent.glob("*.html"):
            window.open(path.as_uri(), 390)
            wide = window.evaluate(
                "document.documentElement.scrollWidth - document.documentElement.clientWidth"
            )
            assert not window.problems and wide <= 0, (path.name, window.problems, wide)
    finally:
        window.close()


def test_a_drive_gets_a_drives_book(tmp_path):
    from imu_lib.exercise import drives

    drives.draw(np.random.default_rng([5, 1]), minutes=2.2).drive.save(tmp_path / "round trip.npz")
    assert main(["book", str(tmp_path / "round trip.npz"), "--out", str(tmp_path / "mine")]) == 0
    pages = tmp_path / "mine/own"
    text = words(pages / "verdict.html")
    assert "round trip: verdict" in text and "Greatest horizontal error over" in text
    assert "There is no reference" in text and "Traceback" not in text and "Left out" not in text
    assert "imu-lib outages" in text and (tmp_path / "mine/downloads/model.json").is_file()
    for name in ("the_drive_from_above", "health_of_the_drive", "simulation_gap_of_the_drive"):
        assert (pages / f"{name}.html").is_file()
    for path in pages.glob("*.html"):
        assert not OTHERS.search(words(path)), (path.name, OTHERS.search(words(path)))
        assert "Axes:" not in words(path), path.name


def subject(path):
    return own.Subject("short", "short.npz", path, "3 samples, 0.02 s", (("record", "short"),))


def test_what_a_record_cannot_carry_is_said(tmp_path):
    path = tmp_path / "short.npz"
    np.savez(
        path, time=np.arange(400) / 100.0, gyro_x=np.random.default_rng(1).normal(size=400) * 1e-3
    )
    text = (ROOT / "book/own_record.md").read_text(encoding="utf-8")
    notebook = own.notebook_of(own.filled(text, subject(path)))
    said = []
    reasons = own.run(notebook, tmp_path, subject(path), said.append)
    assert any("2000" in reason for reason in reasons), reasons
    slugs = own.write_pages(notebook, tmp_path, subject(path))
    assert slugs[0] == "verdict" and len(slugs) > 4
    page = (tmp_path / "verdict.ipynb").read_text(encoding="utf-8")
    assert "Left out on this record (3 samples" in page and str(tmp_path) not in page
    last = (tmp_path / f"{slugs[-1]}.ipynb").read_text(encoding="utf-8")
    assert "2000" in last  # what builds on it says the same, and is no page without a word
    assert said[0].endswith("reading the record") and said[-1].startswith(f"[{len(said)}/")


def test_a_failed_build_leaves_nothing(tmp_path, monkeypatch):
    def fails(*args, **options):
        raise build.BuildError("the builder said no")

    monkeypatch.setattr(build, "build_pages", fails)
    monkeypatch.setattr(own, "run", lambda *args: [])
    with pytest.raises(build.BuildError):
        own.book(subject(tmp_path / "x.npz"), "own_record", tmp_path / "mine")
    assert not list(tmp_path.iterdir())


def test_other_files_are_not_replaced(tmp_path):
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(InputError, match="holds other files"):
        own.book(subject(tmp_path / "x.npz"), "own_record", tmp_path)
    with pytest.raises(InputError, match="name a folder"):
        own.book(subject(tmp_path / "x.npz"), "own_record", tmp_path / "thesis.tex")


def test_tools_that_lack_are_named(tmp_path, monkeypatch, capsys):
    from imu_lib.cli import book

    monkeypatch.setattr(book, "TOOLS", {"a_builder_that_nobody_has": "builder<2"})
    path = tmp_path / "x.npz"
    assert main(["book", str(path)]) == 2  # a file that is not there comes first
    told = capsys.readouterr().err
    assert "x.npz" in told and "builder" not in told and len(told.strip().splitlines()) == 1
    np.savez(path, gyro_x=np.random.default_rng(1).standard_normal(500) * 1e-3)
    assert main(["book", str(path), "--rate", "100"]) == 2
    told = capsys.readouterr().err
    assert '`pip install "builder<2"`' in told and len(told.strip().splitlines()) == 1


@pytest.mark.parametrize("name", ["own_record", "own_drive"])
def test_what_a_template_imports_is_there(name):
    import ast
    from importlib import import_module

    text = (ROOT / f"book/{name}.md").read_text(encoding="utf-8")
    cells = [c.source for c in own.notebook_of(text).cells if c.cell_type == "code"]
    assert len(cells) > 8
    for node in ast.walk(ast.parse("\n".join(cells))):
        if isinstance(node, ast.ImportFrom):
            module = import_module(node.module)
            for alias in node.names:
                if not hasattr(module, alias.name):
                    import_module(f"{node.module}.{alias.name}")


def test_the_commands_on_page_one_read_the_same(tmp_path):
    """Two files, an own rate, a stretch: each command that is shown takes the file as it was read."""
    flags = "--rate 50 --gyro-unit deg/s --accel-unit m/s^2 --columns=-,x --start 2 --trust-units"
    for given in (f"'a b.csv' {flags}", f"--gyro 'a b.csv' --accel acc.csv {flags} --only gyro"):
        asked = parser("book").parse_args(["book", *shlex.split(given)])
        record = Record({"gyro_x": np.zeros(5000)}, 50.0)
        subject = _of_record(asked, record, tmp_path)
        for line in own.commands(subject).splitlines():
            words = joined(shlex.split(line)[1:])
            again = parser(words[0]).parse_args(words)
            for name in ("file", "trust_units", *FLAGS):
                assert getattr(again, name) == getattr(asked, name), (line, name)
