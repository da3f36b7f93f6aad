"""What is derived from book/chapters.toml: the table of contents, and in each chapter the line of
prerequisites and minutes and the paragraph on what comes next.
"""

import re
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

import nbformat
import yaml

from imu_lib.book import chapters

HEAD = re.compile(r"\*\*Needs\*\* .*?\*\*Time\*\* \d+ minutes\.", re.DOTALL)
NEXT = re.compile(r"\*\*Next:?\*\* .*?(?=\n\n|\Z)", re.DOTALL)


@dataclass(frozen=True)
class Entry:
    """One chapter of chapters.toml."""

    slug: str
    minutes: int
    says: str
    answers: tuple[str, ...] = ()
    important: tuple[str, ...] = ()
    helpful: tuple[str, ...] = ()
    also: str = ""  # knowledge that is no chapter
    picture: int = 0  # which of its figures stands for it on the front page, from 1; 0: none
    part: str = field(default="", compare=False)


def parts(root: Path) -> list[dict]:
    return tomllib.loads((root / "book/chapters.toml").read_text(encoding="utf-8"))["part"]


def entries(root: Path) -> dict[str, Entry]:
    """slug -> Entry, in reading order."""
    found = {}
    for part in parts(root):
        for chapter in part.get("chapter", ()):
            values = {k: tuple(v) if isinstance(v, list) else v for k, v in chapter.items()}
            found[chapter["slug"]] = Entry(**values, part=part["caption"])
    return found


def table_of_contents(root: Path) -> str:
    """The text of book/_toc.yml."""
    toc = {"format": "jb-book", "root": "book/intro", "parts": []}
    for part in parts(root):
        files = [f"nbs/{chapter['slug']}" for chapter in part.get("chapter", ())]
        numbered = {"numbered": True} if files else {}
        files += [f"book/{page}" for page in part.get("pages", ())]
        toc["parts"].append(
            {"caption": part["caption"], **numbered, "chapters": [{"file": f} for f in files]}
        )
    return yaml.safe_dump(toc, sort_keys=False)


def head(entry: Entry, all_entries: dict[str, Entry]) -> str:
    """The line on what a chapter asks for and how long it takes."""

    def listed(slugs):
        return ", ".join(f"{{doc}}`{s}` ({all_entries[s].minutes} minutes)" for s in slugs)

    needs = []
    if entry.also or entry.important:
        needs.append(", ".join(filter(None, (entry.also, listed(entry.important)))))
    if entry.helpful:
        needs.append(f"helpful: {listed(entry.helpful)}")
    return f"**Needs** {'; '.join(needs) or 'no other chapter'}. **Time** {entry.minutes} minutes."


def following(entry: Entry, all_entries: dict[str, Entry]) -> str:
    """The paragraph on what comes next."""
    slugs = list(all_entries)
    at = slugs.index(entry.slug) + 1
    if at == len(slugs):
        return "**Next** {doc}`/book/your_record`: the same on a record of your own."
    return f"**Next** {{doc}}`{slugs[at]}`: {all_entries[slugs[at]].says}."


def derived(notebook, entry: Entry, all_entries: dict[str, Entry]) -> list[str]:
    """The sources of the notebook's markdown cells as chapters.toml wants them."""
    lines = {HEAD: head(entry, all_entries), NEXT: following(entry, all_entries)}
    sources = []
    for cell in notebook.cells:
        text = cell.source
        if cell.cell_type == "markdown":
            for pattern, line in lines.items():
                text = pattern.sub(lambda _, line=line: line, text)
        sources.append(text)
    return sources


def write(root: Path) -> list[Path]:
    """Bring _toc.yml and the chapters to what chapters.toml says; returns what was changed."""
    changed = []
    toc = root / "book/_toc.yml"
    text = table_of_contents(root)
    if toc.read_text(encoding="utf-8") != text:
        toc.write_text(text, encoding="utf-8")
        changed.append(toc)
    every = entries(root)
    for chapter in chapters.chapters(root):
        notebook = nbformat.read(chapter.path, as_version=4)
        sources = derived(notebook, every[chapter.slug], every)
        if sources != [cell.source for cell in notebook.cells]:
            for cell, source in zip(notebook.cells, sources):
                cell.source = source
            nbformat.write(notebook, chapter.path)
            changed.append(chapter.path)
    return changed
