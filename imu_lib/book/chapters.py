"""Where the chapters and the book's configuration are, and what each chapter needs in order to be
executed.
"""

import ast
import tomllib
from dataclasses import dataclass
from pathlib import Path

import nbformat
import yaml

PACKAGE = Path(__file__).resolve().parents[1]
# what a build copies, by folder: the rest of a checkout is no part of the book
SOURCES = (
    "CHANGELOG.md",
    "book/*.*",
    "book/_static/*",
    "nbs/*.ipynb",
    "benchmarks/results/*.json",
    "data/*.csv",
    "data/*.json",
)


def source() -> Path:
    """Folder that holds `book/` and `nbs/`: the checkout itself, or what travels in the wheel."""
    packaged = PACKAGE / "_book"
    return packaged if packaged.is_dir() else PACKAGE.parent


@dataclass(frozen=True)
class Chapter:
    """One notebook of the table of contents."""

    path: Path
    needs: tuple[str, ...]  # public records without which it keeps its stored outputs

    @property
    def slug(self) -> str:
        return self.path.stem

    @property
    def missing(self) -> tuple[str, ...]:
        """Records it needs that cannot be had here without a download."""
        if not self.needs:
            return ()
        from imu_lib import datasets

        return tuple(name for name in self.needs if not datasets.available(name))

    @property
    def parameters(self) -> dict:
        """Names and default values of the cell tagged `parameters`."""
        return parameters(nbformat.read(self.path, as_version=4))

    @property
    def title(self) -> str:
        return title(nbformat.read(self.path, as_version=4))


def table_of_contents(root: Path) -> dict:
    return yaml.safe_load((root / "book/_toc.yml").read_text(encoding="utf-8"))


def entries(toc: dict):
    """Every `file:` of a table of contents, in order, with the part that lists it."""
    for part in toc.get("parts", [toc]):
        for entry in part.get("chapters", []):
            yield part, entry
            for section in entry.get("sections", []):
                yield part, section


def chapters(root: Path | None = None) -> list[Chapter]:
    """The notebooks of the table of contents, in reading order."""
    root = root or source()
    needs = tomllib.loads((root / "book/chapters.toml").read_text(encoding="utf-8"))["needs"]
    files = [
        entry["file"]
        for _, entry in entries(table_of_contents(root))
        if entry["file"].startswith("nbs/")
    ]
    return [
        Chapter(root / f"{name}.ipynb", tuple(needs.get(Path(name).name, ()))) for name in files
    ]


def parameters(notebook) -> dict:
    """Literal assignments of the cell tagged `parameters`; empty where there is none."""
    values = {}
    for cell in notebook.cells:
        if "parameters" in cell.metadata.get("tags", []):
            for statement in ast.parse(cell.source).body:
                if isinstance(statement, ast.Assign) and isinstance(statement.targets[0], ast.Name):
                    try:
                        values[statement.targets[0].id] = ast.literal_eval(statement.value)
                    except ValueError:  # not a literal: nothing a rerun could replace
                        continue
    return values


def title(notebook) -> str:
    """The first heading of a notebook."""
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            for line in cell.source.splitlines():
                if line.startswith("# "):
                    return line[2:].strip()
    return "Untitled"
