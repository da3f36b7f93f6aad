"""The book on somebody's own record: one notebook, executed from top to bottom, cut into pages.

The text is `book/own_record.md` (or `own_drive.md`); it speaks of the record at hand alone. Fenced
`python` blocks are its cells, those marked `hidden` show their output only, and a heading of the
first level begins a page.
"""

from __future__ import annotations

import contextlib
import html
import os
import re
import shutil
import time
from dataclasses import dataclass
from pathlib import Path

import nbformat
import yaml

from imu_lib import units
from imu_lib.book import build, execute, left_out

FENCE = re.compile(r"^```python(?P<hidden> hidden)?\n(?P<code>.*?)^```$", re.MULTILINE | re.DOTALL)
DOWNLOADS = "downloads"


@dataclass(frozen=True)
class Subject:
    """What the book is about, in the words of its owner.

    title : name for the title; shown : path as the user gave it; path : the file that the cells
    read; about : its length in words; facts : rows of the first table; call, options : file and
    flags of the call; commands : the calls that give the same, {} where file and flags go
    """

    title: str
    shown: str
    path: Path
    about: str
    facts: tuple[tuple[str, str], ...]
    notes: tuple[str, ...] = ()
    call: str = ""
    options: str = ""
    commands: tuple[str, ...] = ()


def book(subject: Subject, template: str, out: Path, *, progress=None) -> Path:
    """Execute `book/<template>.md` on the subject and build it into `out`; returns page one.

    A step that the record cannot carry is left out and says why in its place. Raises InputError
    where `out` holds other files, BuildError where the pages cannot be built.
    """
    build.check_target(out)
    with build.workplace(out) as work:
        build.stage(work, chapters=False)
        text = (work / f"book/{template}.md").read_text(encoding="utf-8")
        notebook = notebook_of(filled(text, subject))
        (work / "own").mkdir()
        run(notebook, work / "own", subject, progress)
        slugs = write_pages(notebook, work / "own", subject)
        configure(work, subject, slugs)
        if progress:
            progress("building the pages")
        build.build_pages(work, strict=False)
        pages = work / "_build/html"
        if (work / DOWNLOADS).is_dir():
            for path in (work / DOWNLOADS).iterdir():  # the file that was read is gone by then
                text = path.read_text(encoding="utf-8").replace(str(subject.path), subject.shown)
                path.write_text(text, encoding="utf-8")
            shutil.copytree(work / DOWNLOADS, pages / DOWNLOADS)
        return build.move(pages, out)


def filled(text: str, subject: Subject) -> str:
    """The template with the subject's words in it."""
    (name, value), *others = subject.facts
    facts = "\n".join(f"| {name} | {value} |" for name, value in others)
    table = f"| {name} | {value} |\n|---|---|\n{facts}"
    if subject.notes:
        table += "\n\nNoticed while reading it:\n\n" + "\n".join(f"- {n}" for n in subject.notes)
    values = {
        "title": subject.title,
        "shown": subject.shown,
        "options": subject.options,
        "facts": table,
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda m: values.get(m[1], m[0]), text)


def notebook_of(text: str):
    """The notebook of a template: text cells, code cells, a text cell for each heading of a
    page.
    """
    cells, at = [], 0
    for match in FENCE.finditer(text):
        cells += texts(text[at : match.start()])
        code = match["code"].strip()
        if code.splitlines()[-1].startswith("plots."):
            code += ";"  # as in the chapters: a figure without the names of its axes in Python
        cell = nbformat.v4.new_code_cell(code)
        cell.metadata["tags"] = ["remove-input"] if match["hidden"] else []
        cells.append(cell)
        at = match.end()
    cells += texts(text[at:])
    notebook = nbformat.v4.new_notebook(cells=cells)
    notebook.metadata["kernelspec"] = dict(execute.KERNEL)
    for number, cell in enumerate(notebook.cells):
        cell["id"] = f"own-{number}"
    return notebook


def texts(text: str):
    """Text cells, a new one at each heading of the first level."""
    return [
        nbformat.v4.new_markdown_cell(part.strip())
        for part in re.split(r"^(?=# )", text, flags=re.MULTILINE)
        if part.strip()
    ]


def run(notebook, folder: Path, subject: Subject, progress) -> list[str]:
    """Execute the notebook; returns why steps were left out."""
    first = next(cell for cell in notebook.cells if cell.cell_type == "code")
    own = first.source
    first.source = f"record_path = {str(subject.path)!r}\n{own}"
    steps = sum(cell.cell_type == "code" for cell in notebook.cells)
    done, page, began = 0, "", time.monotonic()

    def told(cell, cell_index, **_):
        nonlocal done, page
        before = notebook.cells[cell_index - 1]
        if before.cell_type == "markdown":
            heads = re.findall(r"^##? (.+)$", before.source, re.MULTILINE)
            page = heads[-1] if heads else page
        done += 1
        comment = re.match(r"# (.+)", own if cell is first else cell.source)
        if progress:
            elapsed = int(time.monotonic() - began)
            told = comment[1] if comment else page
            progress(f"[{done}/{steps}] {elapsed // 60}:{elapsed % 60:02d} {told}")

    # processes that a step started are cleaned up behind the kernel, which is no news for the
    # reader
    with environment(PYTHONWARNINGS="ignore"):
        execute.run(notebook, folder, after_error=left_out.forget, on_cell=told)
    reasons = left_out.explain(notebook, subject.about, summary=False)
    first.source = own
    for cell in notebook.cells:  # the file that was read lies in the workplace and is gone by then
        for said in [cell, *cell.get("outputs", [])]:
            for key in ("source", "text"):
                if isinstance(said.get(key), str):
                    said[key] = said[key].replace(str(subject.path), subject.shown)
    return reasons


@contextlib.contextmanager
def environment(**values):
    """Environment variables for the while of a `with`."""
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def write_pages(notebook, folder: Path, subject: Subject) -> list[str]:
    """Cut the notebook at its headings and store each page; returns their names in order."""
    pages = []
    for cell in drawn(notebook.cells):
        if cell.cell_type == "markdown" and cell.source.startswith("# "):
            pages.append([])
        pages[-1].append(listed(cell) if bulleted(cell) else cell)
    links = downloads(folder.parent / DOWNLOADS)
    slugs = []
    for number, cells in enumerate(pages):
        slug = "verdict" if number == 0 else slug_of(cells[0].source)
        for cell in cells:
            if cell.cell_type == "markdown":
                cell.source = cell.source.replace("{{downloads}}", links)
                cell.source = cell.source.replace("{{commands}}", commands(subject))
        page = nbformat.v4.new_notebook(cells=cells)
        page.metadata["kernelspec"] = dict(execute.KERNEL)
        nbformat.write(page, folder / f"{slug}.ipynb")
        slugs.append(slug)
    return slugs


def drawn(cells):
    """The cells without those for a sensor that the record lacks: no output, a caption behind."""
    kept = []
    for cell, after in zip(cells, [*cells[1:], None]):
        nothing = cell.cell_type == "code" and not cell.outputs and after is not None
        if nothing and after.cell_type == "markdown" and after.source.startswith("*"):
            _, _, after.source = after.source.partition("\n\n")
            continue
        if cell.cell_type == "code" or cell.source:
            kept.append(cell)
    return kept


def bulleted(cell) -> bool:
    """Whether a hidden cell printed a list, which the page shows as one."""
    outputs = cell.get("outputs", [])
    return (
        cell.cell_type == "code"
        and bool(outputs)
        and all(o.output_type == "stream" for o in outputs)
        and all(o.text.startswith("- ") for o in outputs)
    )


def listed(cell):
    """The printed list of a cell as a text cell; words of a program are not markup."""
    lines = "".join(o.text for o in cell.outputs).splitlines()
    text = "\n".join(f"- {plain(line[2:])}" if line.startswith("- ") else line for line in lines)
    return nbformat.v4.new_markdown_cell(text, id=cell["id"])


def plain(text: str) -> str:
    """Text with what Markdown would take for markup escaped; code in backticks stays."""
    parts = re.split(r"(`[^`]*`)", text)
    return "".join(
        p if p.startswith("`") else re.sub(r"([\\*_{}\[\]<>|$#~^])", r"\\\1", p) for p in parts
    )


def slug_of(heading: str) -> str:
    return re.sub(r"\W+", "_", heading.splitlines()[0][2:].partition(":")[0].lower()).strip("_")


def downloads(folder: Path) -> str:
    """Links to what lies in the folder of downloads, as HTML that Sphinx leaves alone."""
    if not folder.is_dir() or not any(folder.iterdir()):
        return "Nothing could be written for other programs: the fit was left out."
    items = "".join(
        f'<li><a href="../{DOWNLOADS}/{html.escape(p.name)}" '
        f"download>{html.escape(p.name)}</a></li>"
        for p in sorted(folder.iterdir())
    )
    return f"```{{raw}} html\n<ul>{items}</ul>\n```"


def commands(subject: Subject) -> str:
    """The commands that give what the pages show."""
    call = f"{subject.call} {subject.options}".strip()
    return "\n".join(f"imu-lib {line.format(call)}" for line in subject.commands)


def configure(work: Path, subject: Subject, slugs: list[str]):
    """The table of contents with these pages, and the title of the subject."""
    toc = {
        "format": "jb-book",
        "root": f"own/{slugs[0]}",
        "chapters": [{"file": f"own/{slug}"} for slug in slugs[1:]],
    }
    (work / "book/_toc.yml").write_text(yaml.safe_dump(toc, sort_keys=False), encoding="utf-8")
    path = work / "book/_config.yml"
    config = yaml.safe_load(path.read_text(encoding="utf-8"))
    config["title"], config["author"] = subject.title, "imu-lib book"
    config.pop("repository", None)  # these pages are nobody else's
    config.pop("launch_buttons", None)
    for name in ("repository_url", "repository_branch", "path_to_docs", "launch_buttons"):
        config["sphinx"]["config"]["html_theme_options"].pop(name, None)
    config["sphinx"]["config"]["smartquotes"] = False  # a flag keeps its two dashes
    path.write_text(yaml.safe_dump(config, sort_keys=False), encoding="utf-8")


def described(samples: int, seconds: float) -> str:
    """Length of a record in a few words."""
    return f"{samples:,} samples, {units.duration(seconds)}"


def safe_name(name: str) -> str:
    return re.sub(r"[^\w.-]+", "_", Path(name).stem).strip("._") or "record"
