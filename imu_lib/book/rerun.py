"""The book on somebody's own record: its static chapters executed again, with their `parameters`
cell replaced.
"""

import re
import time
from functools import partial
from pathlib import Path

import nbformat
import numpy as np
import yaml

from imu_lib import units
from imu_lib.book import build, execute, left_out
from imu_lib.book import chapters as contents
from imu_lib.record import Record

SHORT_S = 600.0  # below, page one says what the record is too short for
PAGES = ("book/notation", "book/status", "book/bibliography")  # pages that stay true on any record


def book(record: Record, out: Path, *, progress=execute.print_progress) -> Path:
    """Execute the chapters that are about a static record on `record` and build them into `out`;
    returns page one.

    A step that the record cannot carry is left out and says why in its place (`left_out`).
    Chapters on other things
    (navigation, calibration on a turntable) are left out whole. Raises InputError where `out`
    holds other files, and
    BuildError where the pages cannot be built; nothing is left behind then.
    """
    build.check_target(out)
    with build.workplace(out) as work:
        build.stage(work)
        path = save(record, work / "record" / f"{safe_name(record.name)}.npz")
        # a chapter that needs certain public records is about those
        kept = [
            chapter
            for chapter in contents.chapters(work)
            if "record_path" in chapter.parameters and not chapter.needs
        ]
        runs = execute.execute_files(
            [chapter.path for chapter in kept],
            progress=progress,
            task=partial(
                execute_on,
                record_path=path,
                channels=record.channel_names,
                shown=record.source or record.name,
                about=described(record),
            ),
        )
        write_toc(work, [chapter.slug for chapter in kept])
        write_intro(work, record, runs)
        build.write_status(work, runs, kept)
        build.build_pages(work, strict=False)
        return build.move(work / "_build/html", out)


def save(record: Record, path: Path) -> Path:
    """`record` as an .npz of the contract's keys, SI."""
    path.parent.mkdir(parents=True, exist_ok=True)
    arrays = {"time": record.times(), **record.channels}
    if record.temperature is not None:
        arrays["temperature"] = record.temperature
    np.savez(path, **{name: np.asarray(value) for name, value in arrays.items()})
    return path


def safe_name(name: str) -> str:
    return re.sub(r"[^\w.-]+", "_", Path(name).stem).strip("._") or "record"


def described(record: Record) -> str:
    """Length of the record in a few words."""
    return f"{record.n:,} samples, {units.duration(record.duration)}"


def execute_on(
    path: Path, *, record_path: Path, channels: tuple[str, ...], shown: str = "", about: str = ""
) -> execute.Run:
    """Execute the chapter at `path` on the record and store it there, with a note in place of each
    step that it cannot carry.

    Readers see `shown` for the record's path, as the file was called before it was copied into the
    workplace, and
    `about` for its length.
    """
    from papermill.iorw import load_notebook_node
    from papermill.parameterize import parameterize_notebook

    started = time.monotonic()
    notebook = load_notebook_node(str(path))
    values = {"record_path": str(record_path)}
    if contents.parameters(notebook).get("channel", channels[0]) not in channels:
        values["channel"] = channels[0]
    notebook.metadata["kernelspec"] = dict(execute.KERNEL)
    notebook = parameterize_notebook(notebook, values)
    error, reasons = "", []
    try:
        execute.run(notebook, path.parent, after_error=left_out.forget)
        reasons = left_out.explain(notebook, about)
    # a kernel that died, a cell without end: told on its page, the other chapters go on
    except Exception as failure:
        error = left_out.reason(type(failure).__name__, str(failure))
        cut(notebook, error)
        execute.settle(notebook)
    show_parameters(notebook, {**values, "record_path": shown})
    reasons = [text.replace(str(record_path), shown) for text in reasons]
    for cell in notebook.cells:  # the file that was read lies in the workplace and is gone by then
        for said in [cell] * (cell.cell_type == "markdown") + [
            o for o in cell.get("outputs", []) if o.output_type == "stream"
        ]:
            key = "source" if said is cell else "text"
            said[key] = said[key].replace(str(record_path), shown)
    nbformat.write(notebook, path)
    return execute.Run(path, time.monotonic() - started, error=error, left_out=tuple(reasons))


def show_parameters(notebook, values: dict):
    """Write the values that were used into the `parameters` cell, in place of the cell that
    papermill put after it.
    """
    notebook.cells = [
        cell
        for cell in notebook.cells
        if "injected-parameters" not in cell.metadata.get("tags", [])
    ]
    for cell in notebook.cells:
        if "parameters" in cell.metadata.get("tags", []):
            for name, value in values.items():
                cell.source = re.sub(
                    rf"^{name} = .*$",
                    lambda _, line=f"{name} = {value!r}": line,
                    cell.source,
                    flags=re.MULTILINE,
                )


def cut(notebook, error: str):
    """Keep what was computed before the kernel failed, and say at the top where and why the
    chapter stops.
    """
    reached = [
        number
        for number, cell in enumerate(notebook.cells)
        if cell.cell_type == "code" and cell.outputs
    ]
    notebook.cells = notebook.cells[: max(reached, default=0) + 1]
    note = f":::{{warning}}\nOn this record the chapter stops before its end: {error}\n:::"
    notebook.cells.insert(1, nbformat.v4.new_markdown_cell(note, id="stopped"))


def write_toc(work: Path, slugs: list[str]):
    """The table of contents with the kept chapters only, in their parts."""
    path = work / "book/_toc.yml"
    toc = contents.table_of_contents(work)
    keep = {f"nbs/{slug}" for slug in slugs} | set(PAGES)
    for part in toc["parts"]:
        part["chapters"] = [entry for entry in part["chapters"] if entry["file"] in keep]
    toc["parts"] = [part for part in toc["parts"] if part["chapters"]]
    path.write_text(yaml.safe_dump(toc, sort_keys=False), encoding="utf-8")


def used_part(record: Record) -> tuple[str, ...]:
    """What the chapters do to gaps before they begin, in sentences."""
    try:
        return record.continuous().notes
    except ValueError:  # not two neighbouring samples that are numbers: each chapter says so
        return ()


def write_intro(work: Path, record: Record, runs):
    """Page one: which record this is, what reading it noticed, and what each chapter could do with
    it.
    """
    lines = [
        f"# What is in {record.name or 'this record'}?",
        "",
        "The chapters on static records, executed on one of your own. Where the text speaks of the embedded record, of a "
        "paper's sensor or of a simulation, it is about those; what is computed from the record is about yours.",
        "",
        "| | |",
        "|---|---|",
        f"| record | {record.name or 'without a name'} |",
        f"| channels | {', '.join(record.channel_names)} |",
        f"| rate | {record.rate:.4g} Hz |",
        f"| length | {described(record)} |",
        f"| temperature | {'recorded' if record.temperature is not None else 'not recorded'} |",
        "",
    ]
    notes = [*record.notes, *(note for note in used_part(record) if note not in record.notes)]
    if notes:
        lines += ["Noticed while reading it:", "", *(f"- {note}" for note in notes), ""]
    if record.duration < SHORT_S:
        lines += [
            f":::{{warning}}\n{units.duration(record.duration)} are short for a record at rest. White noise takes minutes; bias instability, "
            "walks and correlation times take hours. What this record cannot carry is left out of the chapters, with a note in its place.\n:::",
            "",
        ]
    lines += ["| chapter | on this record |", "|---|---|"]
    lines += [
        f"| {{doc}}`../nbs/{run.path.stem}` | {outcome(run).replace('|', '/')} |" for run in runs
    ]
    (work / "book/intro.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def outcome(run: execute.Run) -> str:
    """How a chapter went, for the table of page one."""
    if run.error:
        return f"stops: {run.error}"
    more = f" (and {len(run.left_out) - 1} more)" if len(run.left_out) > 1 else ""
    return f"in part: {run.left_out[0]}{more}" if run.left_out else "complete"
