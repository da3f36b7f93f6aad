"""Chapters are stored as they were executed, hold no algorithms, and stay small. (nbval compares
their outputs.)
"""

import ast
import re

import nbformat
import pytest

from conftest import ROOT
from imu_lib.book import chapters

CHAPTERS = chapters.chapters(ROOT)
CODE_LINES, CELL_LINES, BYTES = (
    130,  # captions of tables and comparisons with the papers included, assertions apart
    14,
    1_200_000,
)  # a chapter is read, not maintained; most have about 80 lines
COLUMNS = 110  # of code fit a page on a laptop; a longer line is scrolled sideways by every reader
each = pytest.mark.parametrize("chapter", CHAPTERS, ids=lambda chapter: chapter.slug)


def code_cells(notebook):
    return [cell for cell in notebook.cells if cell.cell_type == "code" and cell.source.strip()]


def statements(cell):
    return [
        line
        for line in cell.source.splitlines()
        if line.strip() and not line.strip().startswith("#")
    ]


def told(cell):
    """Lines of a cell without its assertions, which hold the text and are not the story."""
    asserted = {
        number
        for node in ast.walk(ast.parse(cell.source))
        if isinstance(node, ast.Assert)
        for number in range(node.lineno, node.end_lineno + 1)
    }
    lines = enumerate(cell.source.splitlines(), start=1)
    return [
        line
        for number, line in lines
        if number not in asserted and line.strip() and not line.strip().startswith("#")
    ]


def read(chapter):
    return nbformat.read(chapter.path, as_version=4)


def test_every_notebook_is_a_chapter():
    listed = {chapter.path for chapter in CHAPTERS}
    assert {path for path in (ROOT / "nbs").glob("*.ipynb")} == listed


@each
def test_executed_top_to_bottom(chapter):
    counts = [cell.execution_count for cell in code_cells(read(chapter))]
    assert counts == list(range(1, len(counts) + 1)), (
        "run `python3 make.py refresh`: what has no count is not compared"
    )


@each
def test_outputs_are_clean(chapter):
    for cell in code_cells(read(chapter)):
        for output in cell.outputs:
            assert output.output_type != "error", cell.source
            assert not (output.output_type == "stream" and output.name == "stderr"), output.text
            text = "".join(output.get("data", {}).get("text/plain", "")) + output.get("text", "")
            assert not re.search(r"<[\w.]+ (object )?at 0x|<Axes|<matplotlib|\[<", text), text
            assert str(ROOT) not in text and "/tmp/" not in text, text


@each
def test_holds_no_algorithms(chapter):
    cells = code_cells(read(chapter))
    for cell in cells:
        assert len(statements(cell)) <= CELL_LINES, cell.source
        assert max(map(len, cell.source.splitlines())) <= COLUMNS, cell.source
        kinds = {type(node) for node in ast.walk(ast.parse(cell.source))}
        assert not kinds & {ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef}, cell.source
    assert sum(len(told(cell)) for cell in cells) <= CODE_LINES
    assert chapter.path.stat().st_size < BYTES


@each
def test_follows_the_template(chapter):
    notebook = read(chapter)
    text = "\n".join(cell.source for cell in notebook.cells if cell.cell_type == "markdown")
    assert notebook.cells[0].source.startswith("# ") and notebook.cells[0].source.splitlines()[
        0
    ].endswith("?")
    assert not re.search(r"^#+ .*\$", text, re.MULTILINE), "no math in titles"
    tagged = [cell for cell in notebook.cells if "parameters" in cell.metadata.get("tags", [])]
    assert len(tagged) == 1, "one cell tagged `parameters`"
    exercises, solutions = (
        re.findall(r"\{exercise\}", text),
        re.findall(r"\{solution(?:-start)?\}", text),
    )
    assert len(exercises) >= 3 and len(solutions) >= 3
    assert "assert" in "".join(cell.source for cell in code_cells(notebook)), (
        "claims are asserted in a cell"
    )


@each
def test_is_executed_or_says_why_not(chapter):
    if chapter.missing:
        pytest.skip(
            f"{chapter.slug} keeps its stored outputs: {', '.join(chapter.missing)} not at hand"
        )


def test_needs_name_chapters():
    import tomllib

    needs = tomllib.loads((ROOT / "book/chapters.toml").read_text(encoding="utf-8"))["needs"]
    assert set(needs) <= {chapter.slug for chapter in CHAPTERS}
