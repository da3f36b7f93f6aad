"""The words of the glossary, for the script that explains them where they stand in a chapter."""

import json
import re
from pathlib import Path

ENTRY = re.compile(r"^(?P<words>(?:\S.*\n)+)(?P<meaning>(?:[ \t]+\S.*\n?)+)", re.MULTILINE)


def terms(root: Path) -> dict[str, str]:
    """Word -> what it means, in plain text, as `book/glossary.md` has it."""
    text = (root / "book/glossary.md").read_text(encoding="utf-8")
    body = text.partition("```{glossary}\n")[2].partition("```")[0]
    found = {}
    for entry in ENTRY.finditer(body):
        meaning = " ".join(plain(entry["meaning"]).split())
        for word in entry["words"].splitlines():
            found[word] = meaning
    return found


def plain(text: str) -> str:
    """Text without the marks of its markup."""
    text = re.sub(r"\{\w+\}`([^`<]*?)(?: <[^`]*>)?`", r"\1", text)
    return re.sub(r"[`*]", "", text)


def write(root: Path) -> None:
    """Put the words beside the scripts of the pages."""
    words = json.dumps(terms(root), ensure_ascii=False, indent=0)
    path = root / "book/_static/terms_data.js"
    path.write_text(f"window.BOOK_TERMS = {words};\n", encoding="utf-8")
