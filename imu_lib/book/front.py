"""The front page: its tables of questions and chapters, made from chapters.toml."""

from importlib import metadata
from pathlib import Path

from imu_lib.book import contents


def questions(root: Path) -> str:
    """Which chapter answers which question."""
    lines = ["| question | chapter |", "|---|---|"]
    for slug, entry in contents.entries(root).items():
        lines += [f"| {question} | {{doc}}`../nbs/{slug}` |" for question in entry.answers]
    return "\n".join(lines)


def chapters(root: Path) -> str:
    """Every chapter with its sentence, minutes and prerequisites."""
    every = contents.entries(root)
    numbers = {slug: k for k, slug in enumerate(every, 1)}
    lines = ["| | chapter | what it is about | minutes | asks for |", "|---|---|---|---|---|"]
    part = ""
    for slug, entry in every.items():
        if entry.part != part:
            part = entry.part
            lines.append(f"| | **{part}** | | | |")
        needs = ", ".join(str(numbers[s]) for s in entry.important) or "-"
        lines.append(
            f"| {numbers[slug]} | {{doc}}`../nbs/{slug}` | {entry.says} | {entry.minutes} | {needs} |"
        )
    total = sum(entry.minutes for entry in every.values())
    return "\n".join([*lines, "", f"Together {total / 60:.0f} hours of reading."])


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
