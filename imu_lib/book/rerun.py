"""The book on somebody's own record: its static chapters executed again, with their `parameters` cell replaced."""

import re
import time
from functools import partial
from pathlib import Path

import nbformat
import numpy as np
import yaml

from imu_lib.book import build, execute
from imu_lib.book import chapters as contents
from imu_lib.record import Record

PAGES = ("book/notation", "book/status", "book/bibliography")  # pages that stay true on any record


def book(record: Record, out: Path, *, progress=execute.print_progress) -> Path:
    """Execute the chapters that are about a static record on `record` and build them into `out`; returns page one.

    A chapter that the record cannot carry to its end is cut where it stopped and says why. Chapters on other things
    (navigation, calibration on a turntable) are left out. Raises InputError where `out` holds other files, and
    BuildError where the pages cannot be built; nothing is left behind then.
    """
    build.check_target(out)
    with build.workplace(out) as work:
        build.stage(work)
        path = save(record, work / "record" / f"{safe_name(record.name)}.npz")
        # a chapter that needs certain public records is about those
        kept = [chapter for chapter in contents.chapters(work) if "record_path" in chapter.parameters and not chapter.needs]
        runs = execute.execute_files([chapter.path for chapter in kept], progress=progress,
                                     task=partial(execute_on, record_path=path, channels=record.channel_names,
                                                  shown=record.source or record.name))
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


def execute_on(path: Path, *, record_path: Path, channels: tuple[str, ...], shown: str = "") -> execute.Run:
    """Execute the chapter at `path` on the record and store it there, cut at the cell that the record fails.

    Readers see `shown` for the record's path, as the file was called before it was copied into the workplace.
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
    error = ""
    try:
        execute.run(notebook, path.parent)
    except Exception as failure:  # whatever a chapter trips over is told on its page, the other chapters go on
        error = reason(failure)
        cut(notebook, error)
        execute.settle(notebook)
    show_parameters(notebook, {**values, "record_path": shown})
    nbformat.write(notebook, path)
    return execute.Run(path, time.monotonic() - started, error=error)


def show_parameters(notebook, values: dict):
    """Write the values that were used into the `parameters` cell, in place of the cell that papermill put after it."""
    notebook.cells = [cell for cell in notebook.cells if "injected-parameters" not in cell.metadata.get("tags", [])]
    for cell in notebook.cells:
        if "parameters" in cell.metadata.get("tags", []):
            for name, value in values.items():
                cell.source = re.sub(rf"^{name} = .*$", lambda _, line=f"{name} = {value!r}": line, cell.source, flags=re.MULTILINE)


def reason(failure: Exception) -> str:
    """What the failing cell raised, in one line; our own exceptions speak for themselves."""
    kind = getattr(failure, "ename", type(failure).__name__)
    text = " ".join(str(getattr(failure, "evalue", failure)).split())
    return text if kind in ("InputError", "UndefinedFormError", "ImuLibError") else f"{kind}: {text}" if text else kind


def cut(notebook, error: str):
    """Keep what was computed before the failure, and say at the top where and why the chapter stops."""
    failing = next((number for number, cell in enumerate(notebook.cells) if cell.cell_type == "code"
                    and any(output.output_type == "error" for output in cell.outputs)), 1)
    notebook.cells = notebook.cells[:failing]
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


def write_intro(work: Path, record: Record, runs):
    """Page one: which record this is, what reading it noticed, and what each chapter could do with it."""
    rate, hours = f"{record.rate:.4g} Hz", record.duration / 3600
    lines = [f"# What is in {record.name or 'this record'}?", "",
             "The chapters on static records, executed on one of your own. Where the text speaks of the embedded record, of a "
             "paper's sensor or of a simulation, it is about those; what is computed from the record is about yours.", "",
             "| | |", "|---|---|", f"| record | {record.name or 'without a name'} |",
             f"| channels | {', '.join(record.channel_names)} |",
             f"| rate | {rate} |", f"| length | {record.n:,} samples, {hours:.3g} h |",
             f"| temperature | {'recorded' if record.temperature is not None else 'not recorded'} |", ""]
    if record.notes:
        lines += ["Noticed while reading it:", "", *(f"- {note}" for note in record.notes), ""]
    lines += ["| chapter | on this record |", "|---|---|"]
    lines += [f"| {{doc}}`../nbs/{run.path.stem}` | {'stops: ' + run.error.replace('|', '/') if run.error else 'complete'} |"
              for run in runs]
    (work / "book/intro.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
