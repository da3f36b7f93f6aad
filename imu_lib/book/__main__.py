"""`python -m imu_lib.book TASK`: what make.py calls for the book."""

import inspect
import sys
import time
from pathlib import Path

from imu_lib.book import build, chapters, contents, execute
from imu_lib.errors import InputError


def main(arguments: list[str]) -> int:
    try:
        return run(arguments)
    except (InputError, build.BuildError) as problem:
        print(problem, file=sys.stderr)
        return 2 if isinstance(problem, InputError) else 1


def run(arguments: list[str]) -> int:
    """The task that is asked for, or what it would do."""
    task, names = (arguments or [""])[0], arguments[1:]
    options = [word for word in arguments if word.startswith("-")]
    if {"-h", "--help"} & {*options}:
        told = [task] if task in TASKS else TASKS
        print(__doc__, *(f"{name}: {inspect.getdoc(TASKS[name][0])}" for name in told), sep="\n\n")
        return 0
    if task not in TASKS:
        raise InputError(
            f"there is no task `{task}` for the book: choose one of {', '.join(TASKS)}."
        )
    does, most = TASKS[task]
    if options:
        raise InputError(f"`{task}` has no option `{options[0]}`: --help shows what it takes.")
    if len(names) > most:
        raise InputError(
            f"`{task}` cannot take `{names[most]}` as well: --help shows what it takes."
        )
    return does(names)


def build_book(names) -> int:
    """Execute the chapters and build the pages into the folder that is named, by default
    book/_build/html.
    """
    started = time.monotonic()
    page = build.default(Path(names[0]).resolve() if names else None)
    print(f"{page} ({time.monotonic() - started:.0f} s)")
    return 0


def pages(names) -> int:
    """Build the pages, into the folder that is named, from the stored outputs; nothing is executed
    and warnings are told: for whoever is writing.
    """
    print(
        build.default(
            Path(names[0]).resolve() if names else None, execute_first=False, strict=False
        )
    )
    return 0


def write_contents(names) -> int:
    """Bring the table of contents and the chapters' heads to what book/chapters.toml says."""
    for path in contents.write(chapters.source()):
        print(f"wrote {path.name}")
    return 0


def refresh(names) -> int:
    """Re-execute the named notebooks (default: every chapter whose records are at hand) and store
    their outputs.
    """
    if names:
        paths = [Path(name).resolve() for name in names]
    else:
        paths = [chapter.path for chapter in chapters.chapters() if not chapter.missing]
    missing = [path for path in paths if not path.is_file()]
    if missing:
        raise InputError(f"{missing[0]}: there is no such notebook.")
    runs = execute.execute_files(paths, progress=execute.print_progress)
    for result in runs:
        if result.changed:
            print(f"stored {result.path.name}")
    return int(any(result.error for result in runs))


def executable(names) -> int:
    """Print the notebooks that can be executed here, one on a line; what the test task hands to
    nbval.
    """
    for chapter in chapters.chapters():
        if not chapter.missing:
            print(chapter.path.relative_to(chapters.source()).as_posix())
    return 0


def pdf(names) -> int:
    """The whole book as one PDF, under the name that is given."""
    print(build.pdf(Path(names[0]).resolve() if names else None))
    return 0


#: Task -> (what does it, how many names it takes at the most).
TASKS = {
    "build": (build_book, 1),
    "pages": (pages, 1),
    "contents": (write_contents, 0),
    "refresh": (refresh, sys.maxsize),
    "executable": (executable, 0),
    "pdf": (pdf, 1),
}

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
