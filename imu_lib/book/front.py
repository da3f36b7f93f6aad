"""The front page: its tables of questions and chapters, made from chapters.toml."""

import base64
from importlib import metadata
from pathlib import Path

import nbformat

from imu_lib.book import contents

#: Folder of the cards' pictures, beside the front page.
PICTURES = "_pictures"


def questions(root: Path) -> str:
    """Which chapter answers which question."""
    lines = ["| question | chapter |", "|---|---|"]
    for slug, entry in contents.entries(root).items():
        lines += [f"| {question} | {{doc}}`../nbs/{slug}` |" for question in entry.answers]
    return "\n".join(lines)


def chapters(root: Path) -> str:
    """Every chapter as a card with a picture, its sentence, minutes and prerequisites, by part."""
    every = contents.entries(root)
    numbers = {slug: k for k, slug in enumerate(every, 1)}
    lines, part = [], ""
    for entry in every.values():
        if entry.part != part:
            lines += [":::::", ""] if part else []
            part = entry.part
            lines += [f"### {part}", "", ":::::{grid} 1 2 3 3", ":gutter: 3", ""]
        lines += card(root, entry, numbers)
    total = sum(entry.minutes for entry in every.values())
    return "\n".join([*lines, ":::::", "", f"Together {total / 60:.0f} hours of reading."])


def card(root: Path, entry: contents.Entry, numbers: dict[str, int]) -> list[str]:
    """One chapter's card; the picture is one of the figures that the chapter stores."""
    notebook = nbformat.read(root / f"nbs/{entry.slug}.ipynb", as_version=4)
    title = notebook.cells[0].source.splitlines()[0].removeprefix("# ")
    lines = [f"::::{{grid-item-card}} {numbers[entry.slug]} · {title}"]
    lines += [f":link: ../nbs/{entry.slug}", ":link-type: doc", ":class-card: chapter-card"]
    if entry.picture:
        path = root / f"book/{PICTURES}/{entry.slug}.png"
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(figures(notebook)[entry.picture - 1])
        lines += [f":img-top: {PICTURES}/{entry.slug}.png", f":img-alt: {entry.says}"]
    after = ", ".join(str(numbers[slug]) for slug in entry.important)
    asks = f" · after {after}" if after else ""
    time = f'<span class="chapter-time">{entry.minutes} minutes{asks}</span>'
    return [*lines, "", f"{entry.says[0].upper()}{entry.says[1:]}.", "", time, "::::", ""]


def figures(notebook) -> list[bytes]:
    """The drawings that a chapter stores, in order."""
    outputs = (o for cell in notebook.cells for o in cell.get("outputs", ()))
    drawn = (o.get("data", {}).get("image/png") for o in outputs)
    return [base64.b64decode(picture) for picture in drawn if picture]


def version() -> str:
    try:
        return f"version {metadata.version('imu_lib')}"
    except metadata.PackageNotFoundError:
        return "this version"


def write(root: Path) -> None:
    """Fill the front page's marks, where it has them."""
    path = root / "book/intro.md"
    text = path.read_text(encoding="utf-8")
    for mark, content in (
        ("<!-- questions -->", questions),
        ("<!-- chapters -->", chapters),
        ("<!-- version -->", lambda _: version()),
    ):
        if mark in text:
            text = text.replace(mark, content(root))
    path.write_text(text, encoding="utf-8")
