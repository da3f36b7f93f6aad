"""Executing notebooks so that two runs give the same bytes.

Nothing that changes by itself is stored: no run times, no machine's kernel names, no transient
ids. A chapter runs with its own folder as working directory, one thread, and the kernel of the
environment it is called from.
"""

import os
import sys
import time
import traceback
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

import nbformat

KERNEL = {"display_name": "Python 3", "language": "python", "name": "python3"}
ENVIRONMENT = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "PYTHONHASHSEED": "0",
    "JUPYTER_PREFER_ENV_PATH": "1",
    "PYDEVD_DISABLE_FILE_VALIDATION": "1",
    "PYTHONUTF8": "1",
}
KEPT = (
    "tags",
    "mystnb",
)  # metadata of a cell that mean something: papermill's tag, captions of figures
TIMEOUT_S = 900  # for one cell; a chapter is meant to take under a minute


@dataclass(frozen=True)
class Run:
    """How the execution of one notebook went."""

    path: Path
    seconds: float
    changed: bool = False
    error: str = ""  # empty where it ran to its end
    left_out: tuple[str, ...] = ()  # on a user's record: why steps were left out


def run(notebook, folder: Path, *, after_error=None, on_cell=None):
    """Execute `notebook` (a NotebookNode, changed in place) with `folder` as working directory.

    Raises nbclient's CellExecutionError where a cell fails; with `after_error` the next cells go
    on instead, after the code that `after_error(cell, reply)` returns.
    `on_cell(cell=, cell_index=)` is told of each cell before it runs.
    """
    from jupyter_core.utils import ensure_async
    from nbclient import NotebookClient

    os.environ.update(ENVIRONMENT)
    if os.environ.get("IMU_LIB_DATA"):  # meant from the folder of the call, not from the chapter's
        os.environ["IMU_LIB_DATA"] = os.path.abspath(os.environ["IMU_LIB_DATA"])
    os.environ.pop("MPLBACKEND", None)  # an outer setting would switch the figures off
    clean(notebook)
    client = NotebookClient(
        notebook,
        timeout=TIMEOUT_S,
        kernel_name="python3",
        record_timing=False,
        store_widget_state=False,
        allow_errors=after_error is not None,
        extra_arguments=["--log-level=40"],  # the kernel's own notices would land on the terminal
        resources={"metadata": {"path": str(folder)}},
    )

    async def go_on(cell, cell_index, execute_reply):
        await ensure_async(
            client.kc.execute(
                after_error(cell, execute_reply["content"]), silent=True, store_history=False
            )
        )

    if after_error is not None:
        client.on_cell_error = go_on
    if on_cell is not None:
        client.on_cell_execute = on_cell
    try:
        client.execute()
    except AssertionError:
        if client.km is None:  # nbclient takes Ctrl-C itself: it ends the kernel and then misses it
            raise KeyboardInterrupt from None
        raise
    settle(notebook)
    return notebook


def clean(notebook):
    """Remove outputs and what an editor leaves behind."""
    notebook.metadata = nbformat.from_dict(
        {"kernelspec": KERNEL, "language_info": {"name": "python"}}
    )
    notebook.nbformat, notebook.nbformat_minor = 4, 5
    for number, cell in enumerate(notebook.cells):
        cell.metadata = nbformat.from_dict(
            {key: cell.metadata[key] for key in KEPT if cell.metadata.get(key)}
        )
        cell.setdefault("id", f"cell-{number}")
        if cell.cell_type == "code":
            cell.outputs, cell.execution_count = [], None


def settle(notebook):
    """After execution: counts 1..N over the cells that have code, stream pieces joined, metadata
    as `clean` left it.
    """
    notebook.metadata = nbformat.from_dict(
        {"kernelspec": KERNEL, "language_info": {"name": "python"}}
    )
    for cell in notebook.cells:
        if cell.cell_type == "code":
            joined = []
            for output in cell.outputs:
                last = joined[-1] if joined else None
                if (
                    output.output_type == "stream"
                    and last
                    and last.output_type == "stream"
                    and last.name == output.name
                ):
                    last.text += (
                        output.text
                    )  # how a long print is cut into messages depends on timing
                else:
                    joined.append(output)
            cell.outputs = joined


def execute_file(path: Path) -> Run:
    """Execute one notebook file and store its outputs, only when something changed and every cell
    ran.
    """
    from nbclient.exceptions import CellExecutionError

    started = time.monotonic()
    before = path.read_text(encoding="utf-8")
    try:
        notebook = run(nbformat.reads(before, as_version=4), path.parent)
    except CellExecutionError as failure:
        return Run(path, time.monotonic() - started, error=str(failure))
    except Exception:
        return Run(path, time.monotonic() - started, error=traceback.format_exc())
    after = nbformat.writes(notebook, version=4) + "\n"
    if after != before:
        path.write_text(after, encoding="utf-8", newline="\n")
    return Run(path, time.monotonic() - started, changed=after != before)


def execute_files(
    paths, *, workers: int = 2, progress=lambda run, done, total: None, task=execute_file
) -> list[Run]:
    """Execute several notebook files, `workers` at a time; results in the order of `paths`."""
    paths, found = list(paths), {}
    if len(paths) == 1:
        found[paths[0]] = task(paths[0])
        progress(found[paths[0]], 1, 1)
        return [found[paths[0]]]
    with ProcessPoolExecutor(max_workers=min(workers, len(paths) or 1)) as pool:
        for future in as_completed([pool.submit(task, path) for path in paths]):
            result = future.result()
            found[result.path] = result
            progress(result, len(found), len(paths))
    return [found[path] for path in paths]


def print_progress(result: Run, done: int, total: int):
    """One line per chapter on stderr; a failure with what the cell said."""
    left = len(result.left_out)
    state = (
        "FAILED"
        if result.error
        else f"executed, {left} step{'s' * (left > 1)} not on this record,"
        if left
        else "executed"
    )
    print(
        f"[{done}/{total}] {result.path.stem}: {state} in {result.seconds:.0f} s",
        file=sys.stderr,
        flush=True,
    )
    if result.error:
        print(result.error, file=sys.stderr, flush=True)
