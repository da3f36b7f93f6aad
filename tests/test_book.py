"""Executing, rerunning and building on a book of two small chapters."""

import re
import shutil

import nbformat
import pytest

from conftest import ROOT
from imu_lib.book import __main__ as tasks
from imu_lib.book import build, chapters, execute, left_out

CODE, TEXT = nbformat.v4.new_code_cell, nbformat.v4.new_markdown_cell
PARAMETERS = 'record_path = ""\nchannel = "accel_z"'
OPENS = "import numpy as np\nrecord = dict(np.load(record_path)) if record_path else {'accel_z': np.zeros(3)}"
FIGURE = "import matplotlib.pyplot as plt\nplt.plot([1, 3, 2]);"


def notebook(*cells):
    built = nbformat.v4.new_notebook(cells=list(cells))
    for number, cell in enumerate(built.cells):
        cell["id"] = f"c{number}"
    return built


@pytest.fixture
def small_book(tmp_path, monkeypatch):
    """A checkout with one chapter that works on any record, one that needs a temperature, one on
    something else.
    """
    source = tmp_path / "source"
    for name in ("_config.yml", "bibliography.md", "status.md", "references.bib", "notation.md"):
        (source / "book").mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / "book" / name, source / "book" / name)
    (source / "book/intro.md").write_text("# Small\n\nA book.\n")
    (source / "book/chapters.toml").write_text("[needs]\n")
    (source / "book/_toc.yml").write_text(
        "format: jb-book\nroot: book/intro\nparts:\n  - caption: All\n    chapters:\n      - file: nbs/works\n"
        "      - file: nbs/stops\n      - file: nbs/other\n      - file: book/notation\n      - file: book/status\n"
        "      - file: book/bibliography\n"
    )
    (source / "nbs").mkdir()
    tagged = {"metadata": {"tags": ["parameters"]}}
    nbformat.write(
        notebook(
            TEXT("# Does it work?"),
            CODE(PARAMETERS, **tagged),
            CODE(OPENS),
            CODE("print(channel, len(record[channel]))"),
            CODE(FIGURE),
        ),
        source / "nbs/works.ipynb",
    )
    nbformat.write(
        notebook(
            TEXT("# Is it warm?"),
            CODE(PARAMETERS, **tagged),
            CODE(OPENS),
            CODE("warm = 99.0\nprint('kept')"),
            TEXT("Next."),
            CODE(
                "from imu_lib.errors import InputError\nif record_path and 'temperature' not in record:\n"
                "    raise InputError('there is no temperature in this record')\nwarm = 20.0"
            ),
            TEXT("## Next"),
            CODE("print('warm:', warm)"),
            CODE("print('cold')\nassert len(record) > 99"),
        ),
        source / "nbs/stops.ipynb",
    )
    nbformat.write(
        notebook(TEXT("# Does it drive?"), CODE("1 + 1", **tagged)), source / "nbs/other.ipynb"
    )
    monkeypatch.setattr(chapters, "source", lambda: source)
    return source


def test_two_executions_give_the_same_bytes(small_book):
    path = small_book / "nbs/works.ipynb"
    first = execute.execute_file(path)
    stored = path.read_bytes()
    again = execute.execute_file(path)
    assert (first.error, first.changed, again.changed) == ("", True, False)
    assert path.read_bytes() == stored
    cells = [cell for cell in nbformat.read(path, as_version=4).cells if cell.cell_type == "code"]
    assert [cell.execution_count for cell in cells] == [1, 2, 3, 4]
    assert cells[2].outputs[0].text == "accel_z 3\n" and "image/png" in cells[3].outputs[-1].data


def test_a_failing_chapter_keeps_what_is_stored(tmp_path):
    path = tmp_path / "fails.ipynb"
    nbformat.write(notebook(TEXT("# Fails?"), CODE("1 / 0")), path)
    stored = path.read_bytes()
    result = execute.execute_file(path)
    assert (
        "ZeroDivisionError" in result.error and not result.changed and path.read_bytes() == stored
    )


def test_what_a_failed_cell_leaves_unset():
    source = "import numpy as np\na = 1\nfor k in 'ab':\n    rows[k] = f(k)\n    kept.append(k)\nc, d.e = 2, 3"
    assert left_out.forgotten(source, 4) == ["c", "d", "k", "kept", "rows"]
    assert left_out.forgotten(source, 6) == ["c", "d"]
    assert left_out.forgotten(source, None) == ["a", "c", "d", "k", "kept", "rows"]
    assert (
        left_out.failing_line(
            ["\x1b[36mCell\x1b[39m\x1b[36m \x1b[39mIn[21], line 4\x1b[39m", "File x.py:7"]
        )
        == 4
    )


def test_a_warning_fails_the_book(small_book, tmp_path):
    (small_book / "book/intro.md").write_text("# Small\n\n{doc}`nowhere`\n")
    with pytest.raises(build.BuildError, match="unknown document"):
        build.default(tmp_path / "html", execute_first=False)


def test_a_chapter_without_its_record_keeps_its_outputs(small_book, monkeypatch):
    (small_book / "book/chapters.toml").write_text(
        '[needs]\nworks = ["a record that nobody has"]\n'
    )
    from imu_lib import datasets

    monkeypatch.setattr(datasets, "available", lambda name: False)
    monkeypatch.setattr(datasets, "twin", lambda *names: None)
    found = {chapter.slug: chapter.missing for chapter in chapters.chapters()}
    assert found == {"works": ("a record that nobody has",), "stops": (), "other": ()}


def test_a_wheel_carries_what_a_build_copies():
    text = (ROOT / "book/wheel_hook.py").read_text(encoding="utf-8")
    patterns = text.partition("PATTERNS = (")[2].partition(")")[0]
    assert tuple(re.findall(r'"([^"]+)"', patterns)) == chapters.SOURCES


@pytest.mark.parametrize("words", [["build", "--help"], ["-h"], ["pdf", "out.pdf", "-h"]])
def test_help_of_a_task_builds_nothing(words, monkeypatch, capsys):
    for name in ("default", "pdf"):
        monkeypatch.setattr(build, name, None)
    assert tasks.main(words) == 0
    told = capsys.readouterr()
    assert "build: Execute the chapters" in told.out or "pdf: The whole book" in told.out
    assert not told.err


@pytest.mark.parametrize(
    "words",
    [["build", "--fast"], ["pages", "one", "two"], ["contents", "here"], ["bild"], []],
)
def test_a_call_that_no_task_takes_is_one_sentence(words, monkeypatch, capsys):
    for name in ("default", "pdf"):
        monkeypatch.setattr(build, name, None)
    assert tasks.main(words) == 2
    assert capsys.readouterr().err.count("\n") == 1
