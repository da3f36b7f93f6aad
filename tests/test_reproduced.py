"""The index of what is reproduced and the chapters agree: each link has its target, each target
its link.
"""

import re

import nbformat

from conftest import ROOT
from imu_lib.book import chapters

NAME = r"((?:fig|tab|eq)-(?:2008|2011|2013)-[\w-]+)"


def targets():
    """Target of a table, figure or equation of a paper -> the chapters that define it."""
    found = {}
    for chapter in chapters.chapters(ROOT):
        for cell in nbformat.read(chapter.path, as_version=4).cells:
            if cell.cell_type == "markdown":
                for pattern in (
                    rf"^\({NAME}\)=",
                    rf"\$\$\s*\({NAME}\)",
                    rf":(?:label|name): {NAME}",
                ):
                    for name in re.findall(pattern, cell.source, re.MULTILINE):
                        found.setdefault(name, []).append(chapter.slug)
    return found


def linked():
    text = (ROOT / "book/reproduced.md").read_text(encoding="utf-8")
    return set(re.findall(rf"[<`]{NAME}[>`]", text))


def test_each_target_is_defined_once():
    assert not {name: slugs for name, slugs in targets().items() if len(slugs) > 1}


def test_index_and_chapters_agree():
    assert linked() == set(targets())


def test_what_is_not_reproduced_has_its_reason():
    rows = [
        row
        for row in (ROOT / "book/reproduced.md").read_text(encoding="utf-8").splitlines()
        if row.startswith("|") and "not reproduced" in row
    ]
    assert all(re.search(r"not reproduced: \w", row) for row in rows), "\n".join(rows)


def test_every_citation_is_in_the_bibliography():
    known = set(
        re.findall(
            r"^@\w+\{(\w+),",
            (ROOT / "book/references.bib").read_text(encoding="utf-8"),
            re.MULTILINE,
        )
    )
    texts = [path.read_text(encoding="utf-8") for path in (ROOT / "book").glob("*.md")]
    for chapter in chapters.chapters(ROOT):
        texts += [cell.source for cell in nbformat.read(chapter.path, as_version=4).cells]
    cited = {
        key.strip()
        for text in texts
        for keys in re.findall(r"\{cite(?::\w+)?\}`([^`]+)`", text)
        for key in keys.split(",")
    }
    assert cited <= known
