"""Building the pages: a copy of the sources is executed and built aside, and moved into place when
it is whole.
"""

import contextlib
import importlib.util
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from imu_lib.book import api, execute, front, glossary, house, launch, reproduced
from imu_lib.book import chapters as contents
from imu_lib.errors import InputError
from imu_lib.writers import check_folder

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome", "msedge")
# tells a folder that holds an earlier book, which may be replaced, from any other
MARK = ".imu_lib_book"


class BuildError(RuntimeError):
    """The pages could not be built; the message holds what the builder said."""


def default(out: Path | None = None, *, execute_first: bool = True, strict: bool = True) -> Path:
    """Execute the chapters on the embedded data and build the book; returns its first page.

    A chapter whose public records are not at hand keeps its stored outputs, and the page on run
    times says so.
    Raises BuildError where a chapter fails or the builder warns.
    """
    out = out or contents.source() / "book/_build/html"
    check_target(out)
    with workplace(out) as work:
        stage(work)
        runs = execute_chapters(contents.chapters(work)) if execute_first else []
        derive(work)  # once more, from outputs that may be new
        write_status(work, runs, contents.chapters(work))
        failed = [result.path.stem for result in runs if result.error]
        if failed:
            raise BuildError(f"these chapters failed: {', '.join(failed)}")
        for warning in build_pages(work, strict=strict):
            print(warning, file=sys.stderr)
        return move(work / "_build/html", out)


@contextlib.contextmanager
def workplace(out: Path):
    """A temporary folder beside `out`, so that the last step is a rename; gone afterwards,
    whatever happens.
    """
    out.parent.mkdir(parents=True, exist_ok=True)
    work = Path(tempfile.mkdtemp(prefix=".book-", dir=out.parent))
    try:
        yield work
    finally:
        shutil.rmtree(work, ignore_errors=True)


def stage(work: Path, *, chapters: bool = True):
    """Copy what the book is made of, or what pages without its chapters need."""
    root = contents.source()
    for pattern in contents.SOURCES if chapters else ("book/*.*", "book/_static/*"):
        for path in sorted(root.glob(pattern)):
            if path.is_file():
                target = work / path.relative_to(root)
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(path, target)
    (work / "book/_static").mkdir(parents=True, exist_ok=True)
    shutil.copyfile(plotly_script(), work / "book/_static/plotly.min.js")
    if chapters:
        derive(work)
    else:
        glossary.write(work)


def plotly_script() -> Path:
    """The one file that draws figures to zoom, as the package `plotly` brings it."""
    found = importlib.util.find_spec("plotly")
    script = found and Path(found.origin).parent / "package_data/plotly.min.js"
    if not script or not script.is_file():
        raise InputError(
            "a book needs plotly, which is not installed: `pip install plotly` adds it."
        )
    return script


def derive(work: Path):
    """Write the pages that are made from the chapters and their outputs."""
    if (work / "book/reproduced.toml").is_file():
        reproduced.write(work)
        front.write(work)
        glossary.write(work)
        api.write(work)
        house.write(work)
        launch.write(work)


def execute_chapters(chapters) -> list[execute.Run]:
    from imu_lib import datasets

    datasets.twin()  # drawn once here rather than by two chapters at the same time
    return execute.execute_files(
        [chapter.path for chapter in chapters if not chapter.missing],
        progress=execute.print_progress,
    )


def write_status(work: Path, runs, chapters):
    """The page on run times, from this very build."""
    seconds = {result.path.stem: result.seconds for result in runs}
    lines = ["| chapter | seconds | state |", "|---|---|---|"]
    for chapter in chapters:
        if chapter.slug in seconds:
            lines.append(
                f"| {{doc}}`../nbs/{chapter.slug}` | {seconds[chapter.slug]:.1f} | executed in "
                "this build |"
            )
        else:
            reason = f"; not at hand: {', '.join(chapter.missing)}" if chapter.missing else ""
            lines.append(f"| {{doc}}`../nbs/{chapter.slug}` | - | stored outputs{reason} |")
    lines += ["", f"Together {sum(seconds.values()):.0f} s of computing, two chapters at a time."]
    page = work / "book/status.md"
    text = page.read_text(encoding="utf-8")
    head, _, _ = text.partition("<!-- table -->")
    page.write_text(head + "\n".join(lines) + "\n", encoding="utf-8")


def build_pages(work: Path, *, strict: bool, builder: str = "html") -> list[str]:
    """Run jupyter-book over `work`; returns its warnings. With `strict` each is an error. Raises
    BuildError.
    """
    # the trees of a book are kept to its end: looking for garbage among them takes two fifths of
    # the time
    command = [
        sys.executable,
        "-c",
        "import gc; gc.disable(); from jupyter_book.cli.main import main; main()",
        "build",
        str(work),
        "--builder",
        builder,
        "--config",
        str(work / "book/_config.yml"),
        "--toc",
        str(work / "book/_toc.yml"),
        "--path-output",
        str(work),
        "--keep-going",
    ]
    done = subprocess.run(
        command,
        cwd=work,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        encoding="utf-8",
        errors="replace",
        stdin=subprocess.DEVNULL,
    )
    told = re.sub(r"\x1b\[[\d;]*m", "", done.stdout).replace(f"{work}/", "")
    warnings = [line for line in told.splitlines() if "WARNING" in line or "ERROR" in line]
    if done.returncode != 0 or (strict and warnings):
        raise BuildError("\n".join(warnings) or told)
    return warnings


def check_target(out: Path):
    """Raises InputError where `out` is something that a book must not replace."""
    if out.exists() and not out.is_dir():
        raise InputError(f"{out}: this is a file; name a folder for the book with --out.")
    if out.is_dir() and any(out.iterdir()) and not (out / MARK).exists():
        raise InputError(
            f"{out}: the folder holds other files; name a new or an empty one with --out."
        )
    check_folder(out.parent)


def move(pages: Path, out: Path) -> Path:
    """Put the finished pages in place of an earlier book."""
    (pages / MARK).write_text("made by imu-lib book\n", encoding="utf-8")
    if out.exists():
        shutil.rmtree(out)
    shutil.move(str(pages), str(out))
    return out / "index.html"


def pdf(out: Path | None = None) -> Path:
    """The whole book, stored outputs, as one PDF printed by headless Chromium.

    Raises InputError where no Chromium or Chrome is installed, BuildError where it fails.
    """
    out = out or contents.source() / "book/_build/book.pdf"
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        raise InputError(
            "a PDF is printed by Chromium or Chrome, and neither is installed: install one of them."
        )
    with workplace(out) as work:
        stage(work)
        write_status(work, [], contents.chapters(work))
        build_pages(work, strict=False, builder="singlehtml")
        pages = work / "_build/singlehtml"
        # the single page lands in the folder of the root document but links as from the top
        page = (pages / "book/intro.html").replace(pages / "whole.html")
        done = subprocess.run(
            [
                browser,
                "--headless",
                "--no-sandbox",
                "--disable-gpu",
                "--disable-background-networking",
                "--no-first-run",
                f"--user-data-dir={work / 'profile'}",
                "--virtual-time-budget=60000",
                "--no-pdf-header-footer",
                f"--print-to-pdf={work / 'book.pdf'}",
                page.as_uri(),
            ],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            stdin=subprocess.DEVNULL,
        )
        if done.returncode != 0 or not (work / "book.pdf").exists():
            raise BuildError(done.stdout)
        shutil.move(work / "book.pdf", out)
    return out
