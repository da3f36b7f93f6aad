"""What a record cannot carry: a cell that fails becomes an explanation in its place, and what
builds on it is left out.

A name that a failed statement would have set is taken away from the kernel (`forgotten`): a later
cell then stops at it, instead of drawing what an earlier cell, on a simulation perhaps, had left
under the same name.
"""

import ast
import re

import nbformat

OWN = (
    "InputError",
    "UndefinedFormError",
    "ImuLibError",
)  # our own exceptions are sentences for a user
FILLS = (
    "append",
    "extend",
    "update",
    "add",
    "setdefault",
    "insert",
)  # methods that change what they are called on


def forgotten(source: str, line: int | None) -> list[str]:
    """Names that the statements of a cell set or fill from the one at `line` (1 is the first;
    None: all) on.
    """
    names = set()
    for statement in ast.parse(source).body:
        if line is None or statement.end_lineno >= line:
            for node in ast.walk(statement):
                if isinstance(node, (ast.Name, ast.Subscript, ast.Attribute)) and isinstance(
                    node.ctx, ast.Store
                ):
                    names.add(_base(node))
                elif (
                    isinstance(node, ast.Call)
                    and isinstance(node.func, ast.Attribute)
                    and node.func.attr in FILLS
                ):
                    names.add(_base(node.func))
    return sorted(names - {None})


def _base(node) -> str | None:
    while isinstance(node, (ast.Subscript, ast.Attribute)):
        node = node.value
    return node.id if isinstance(node, ast.Name) else None


def failing_line(traceback: list[str]) -> int | None:
    """Line of the cell at which it failed, from 1, out of the kernel's traceback; None where it
    does not say.
    """
    plain = re.sub(r"\x1b\[[\d;]*m", "", "\n".join(traceback))
    found = re.search(r"Cell In\s*\[\d+\], line (\d+)", plain)
    return int(found.group(1)) if found else None


def forget(cell, reply: dict) -> str:
    """Code that takes away what the failed `cell` leaves unset."""
    names = forgotten(cell.source, failing_line(reply.get("traceback", [])))
    return f"for _name in {names!r}:\n    globals().pop(_name, None)"


def explain(notebook, about: str, *, summary: bool = True) -> list[str]:
    """Put a note after every cell that failed and one at the top; returns the reasons, none for
    what only builds on another.

    `about`: the record in a few words, as in "300 samples, 3 s"; `summary`: whether the top says
    how many steps are left out.
    """
    cells, reasons, lost, builds = [], [], {}, 0
    for cell in notebook.cells:
        cells.append(cell)
        error = next((o for o in cell.get("outputs", []) if o.output_type == "error"), None)
        if error is None:
            continue
        cell.outputs = [
            o for o in cell.outputs if o.output_type != "error" and o.get("name") != "stderr"
        ]
        line = failing_line(error.traceback)
        name = re.search(r"name '(\w+)' is not defined", error.evalue)
        if error.ename == "NameError" and name and name.group(1) in lost:
            builds += 1
            why = lost[name.group(1)]
        else:
            why = reason(error.ename, error.evalue, cell.source, line)
            reasons.append(why)
        lost.update(dict.fromkeys(forgotten(cell.source, line), why))
        text = f":::{{admonition}} Left out on this record ({about})\n:class: note\n{why}\n:::"
        cells.append(nbformat.v4.new_markdown_cell(text, id=f"left-out-{len(cells)}"))
    if reasons and summary:
        count = len(reasons) + builds
        of = sum(cell.cell_type == "code" for cell in cells)
        verb = "is" if count == 1 else "are"
        text = (
            f":::{{warning}}\nOn this record {count} of {of} steps of this chapter {verb} left "
            "out; a note in place of each says why.\n:::"
        )
        cells.insert(1, nbformat.v4.new_markdown_cell(text, id="left-out"))
    notebook.cells = cells
    return reasons


def reason(kind: str, text: str, source: str = "", line: int | None = None) -> str:
    """What a failing cell raised, in a sentence; our own exceptions speak for themselves."""
    text = " ".join(text.split())
    if kind in OWN:
        return text
    if kind == "AssertionError":
        failed = next(
            (
                ast.unparse(s.test)
                for s in ast.parse(source).body
                if isinstance(s, ast.Assert)
                and line is not None
                and s.lineno <= line <= s.end_lineno
            ),
            "",
        )
        return "A check of this chapter does not hold" + (
            f": `{failed}`." if failed else f": {text}." if text else "."
        )
    if kind == "ValueError":
        return f"The method refuses the record: {text}."
    return (
        f"The computation stops: {text} ({kind})." if text else f"The computation stops ({kind})."
    )
