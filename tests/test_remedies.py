"""Every remedy that an error prints is run: the call that the error answers, and the call it asks for."""

import ast
import functools
import re
import shlex
from pathlib import Path

import pytest
import remedies_commands
import remedies_reading
import remedy_files

import imu_lib
from imu_lib.cli import main as cli

CASES = [*remedies_reading.CASES, *remedies_commands.CASES]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("remedies")
    remedy_files.files(out)
    return out


def pattern(said):
    return ".*?".join(re.escape(part) for part in said.split("{}"))


@pytest.mark.parametrize("case", CASES, ids=lambda c: f"{c[1][:30]}: {c[0][:40]}")
def test_the_call_that_is_asked_for_works(folder, capsys, monkeypatch, case):
    said, wrong, right = case
    if "--scheduler" in wrong:  # one that refuses at once is tried until the time is over
        import distributed

        client = functools.partial(distributed.Client)
        monkeypatch.setattr(distributed, "Client", lambda at, timeout: client(at, timeout="1s"))
    assert cli.main(shlex.split(wrong.format(folder))) == 2
    told = capsys.readouterr().err
    assert re.search(pattern(said), told, re.DOTALL), told
    done = cli.main(shlex.split(right.format(folder)))
    after = capsys.readouterr().err
    if "nothing.npz" in right:  # long work behind it: the flag is taken, and the file is asked for
        assert done == 2 and "nothing.npz" in after, after
    else:
        assert done in (0, None), after


def _text(node):
    """The literal text of an expression, {} for what is put in, alternatives side by side."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(_text(v) for v in node.values)
    if isinstance(node, ast.BinOp):
        return _text(node.left) + _text(node.right)
    if isinstance(node, ast.IfExp):
        return f"{_text(node.body)}|{_text(node.orelse)}"
    return "{}"


@functools.cache
def printed():
    """(place, text) of every text in the package that is an error's, or is handed to one, and names a
    flag or a command."""
    root, out = Path(imu_lib.__file__).parent, []
    for path in sorted(root.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            raised = isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("InputError", "Asked", "Unnamed", "Several", "UnitAsked")  # fmt: skip
            if raised and node.args:
                text = _text(node.args[0])
                if re.search(r"--[a-z]|imu-lib [a-z]", text):
                    out.append((f"{path.relative_to(root)}:{node.lineno}", text))
    return out


def test_no_remedy_is_printed_that_no_test_runs():
    known = [c[0] for c in CASES] + list(remedies_commands.NOT_RUN)
    open_ = [f"{place}: {text}" for place, text in printed() if not any(k in text for k in known)]
    assert not open_, "\n".join(open_)
    assert len(printed()) > 80


def test_what_is_not_run_is_still_there():
    texts = [text for _, text in printed()]
    for said in remedies_commands.NOT_RUN:
        assert any(said in t for t in texts), said
