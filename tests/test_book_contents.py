"""Order, prerequisites, minutes and what comes next stand once, in book/chapters.toml; figures have
captions.
"""

import nbformat
import numpy as np
import pytest

from conftest import ROOT
from imu_lib import datasets
from imu_lib.book import chapters, contents

CHAPTERS = chapters.chapters(ROOT)
ENTRIES = contents.entries(ROOT)
each = pytest.mark.parametrize("chapter", CHAPTERS, ids=lambda chapter: chapter.slug)


def test_table_of_contents_follows():
    written = (ROOT / "book/_toc.yml").read_text(encoding="utf-8")
    assert written == contents.table_of_contents(ROOT), "run `python -m imu_lib.book contents`"


def test_prerequisites_come_before():
    order = list(ENTRIES)
    for slug, entry in ENTRIES.items():
        for needed in (*entry.important, *entry.helpful):
            assert order.index(needed) < order.index(slug), f"{slug} asks for {needed}"


def test_titles_lead_with_a_term():
    for chapter in CHAPTERS:
        term, colon, question = chapter.title.partition(": ")
        assert colon and len(term.split()) <= 7, chapter.title


@each
def test_a_card_has_a_figure_of_its_chapter(chapter):
    from imu_lib.book import front

    drawn = front.figures(nbformat.read(chapter.path, as_version=4))
    picture = ENTRIES[chapter.slug].picture
    assert picture <= len(drawn) and bool(picture) == bool(drawn)


@each
def test_head_and_next_are_derived(chapter):
    notebook = nbformat.read(chapter.path, as_version=4)
    sources = [cell.source for cell in notebook.cells]
    assert sources == contents.derived(notebook, ENTRIES[chapter.slug], ENTRIES), (
        "run `python -m imu_lib.book contents`"
    )
    text = "\n".join(sources)
    assert len(contents.HEAD.findall(text)) == 1 and len(contents.NEXT.findall(text)) == 1


@each
def test_every_figure_has_a_caption(chapter):
    cells = nbformat.read(chapter.path, as_version=4).cells
    for cell, after in zip(cells, [*cells[1:], None]):
        pictures = sum("image/png" in o.get("data", {}) for o in cell.get("outputs", []))
        assert pictures <= 1, f"two figures, one caption: {cell.source}"
        if pictures:
            assert after is not None and after.source.lstrip().startswith("*"), cell.source


def test_which_code_names_an_entry_of_the_reference():
    from imu_lib.book import links

    objects = {"imu_lib.allan.fit", "imu_lib.model.Model"}
    assert links.target("allan.fit(curve, WhiteNoise() + ...)", objects) == "imu_lib.allan.fit"
    assert links.target('imu.model.Model("x")', objects) == "imu_lib.model.Model"
    assert links.target("allan.fit_any(curve)", objects) is None
    assert links.target("curve.adev", objects) is None and links.target("imu-lib", objects) is None


def test_what_the_chapter_on_recorded_gaps_says_of_its_records():
    """Sizes in its text that none of its cells prints."""
    if not all(map(datasets.available, ("mpu6050_raw_counts", "mtig_gyro_x"))):
        pytest.skip("the recorded signals are not at hand")
    x = datasets.load("mpu6050_raw_counts")["gyro_y"]
    noise = np.std(np.diff(x)) / np.sqrt(2)
    assert np.mean(np.diff(x) == 0) == pytest.approx(1 / 50, rel=0.1)
    assert np.diff(np.unique(x)).min() / noise == pytest.approx(1 / 15, rel=0.1)
    size = np.abs(datasets.load("mtig_gyro_x").slice(0.0, 600.0)["gyro_x"])
    middle = np.median(size)
    assert 170 < size.max() / middle < 210
    assert np.mean(size > 3 * 1.4826 * middle) == pytest.approx(0.2, abs=0.03)
