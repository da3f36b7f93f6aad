"""The index of what is reproduced and the chapters agree: each link has its target, each target
its link.
"""

import re

import nbformat

from conftest import ROOT
from imu_lib.book import chapters, reproduced


def labels():
    return [
        label
        for paper in reproduced.items(ROOT)
        for item in paper["item"]
        for label in item.get("labels", ())
    ]


def test_each_target_is_defined_once():
    assert not {name: slugs for name, slugs in reproduced.targets(ROOT).items() if len(slugs) > 1}


def test_index_and_chapters_agree():
    found = {name for name in reproduced.targets(ROOT) if not name.startswith("eq-")}
    assert len(labels()) == len(set(labels())) and set(labels()) == found


def test_what_is_not_reproduced_has_its_reason():
    for paper in reproduced.items(ROOT):
        for item in paper["item"]:
            assert item.get("labels") or re.match(r"\w", item.get("reason", "")), item


def test_printed_tables_have_their_numbers():
    """Each table of measured values is compared by a chapter, and no comparison is left out."""
    stored, names = (
        reproduced.comparisons(ROOT),
        {
            f"{paper['year']} {item['name']}": item
            for paper in reproduced.items(ROOT)
            for item in paper["item"]
        },
    )
    assert set(stored) <= set(names)
    measured = {f"2013 Table {n}" for n in range(2, 11)} | {"2011 Table 2", "2011 Table 3"}
    assert measured | {"2008 Table 2", "2008 Table 3", "2008 Table 4"} == set(stored)
    text = reproduced.page(ROOT)
    assert all(
        f"{entry['within']} of {entry['values']} within" in text for entry in stored.values()
    )


def test_every_citation_is_in_the_bibliography():
    known = set(
        re.findall(
            r"^@\w+\{(\w+),",
            (ROOT / "book/references.bib").read_text(encoding="utf-8"),
            re.MULTILINE,
        )
    )
    texts = [path.read_text(encoding="utf-8") for path in (ROOT / "book").glob("*.md")]
    texts.append(reproduced.page(ROOT))
    for chapter in chapters.chapters(ROOT):
        texts += [cell.source for cell in nbformat.read(chapter.path, as_version=4).cells]
    cited = {
        key.strip()
        for text in texts
        for keys in re.findall(r"\{cite(?::\w+)?\}`([^`]+)`", text)
        for key in keys.split(",")
    }
    assert cited <= known
