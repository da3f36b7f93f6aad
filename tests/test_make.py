"""The door: make.py refuses what it cannot do in one sentence, and its lists of packages agree."""

import re
import subprocess
import sys
import tomllib

import pytest

from conftest import ROOT


def make(*arguments):
    return subprocess.run(
        [sys.executable, str(ROOT / "make.py"), *arguments], capture_output=True, text=True
    )


@pytest.mark.parametrize("arguments", [(), ("boook",), ("--book",)])
def test_wrong_task_is_one_sentence(arguments):
    done = make(*arguments)
    assert done.returncode == 2
    assert len(done.stderr.strip().splitlines()) == 1 and "book, test, refresh" in done.stderr


def test_old_python_is_one_sentence():
    code = (
        "import sys; sys.version_info = (3, 9, 1); import make\n"
        "try: make.main(['book'])\nexcept make.Stop as stop: print(stop)"
    )
    done = subprocess.run(
        [sys.executable, "-B", "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert "Python 3.11 or later, this is 3.9" in done.stdout


def test_uses_the_standard_library_only():
    import ast

    tree = ast.parse((ROOT / "make.py").read_text(encoding="utf-8"))
    modules = [
        alias.name
        for node in ast.walk(tree)
        if isinstance(node, ast.Import)
        for alias in node.names
    ]
    assert set(modules) <= set(sys.stdlib_module_names)


def requirements(lines):
    return {
        re.match(r"[\w-]+", line)[0].lower(): line
        for line in lines
        if line and not line.startswith("#")
    }


def test_package_and_environment_ask_for_the_same():
    listed = requirements((ROOT / "environment.txt").read_text(encoding="utf-8").split("\n"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    asked = requirements(
        [*project["dependencies"], *sum(project["optional-dependencies"].values(), [])]
    )
    for name, line in asked.items():
        assert listed.get(name) == line
    assert all("<" in line for line in listed.values()), (
        "upper bounds keep to versions tried together"
    )


def test_every_package_has_its_reason():
    text = (ROOT / "book/contributing.md").read_text(encoding="utf-8").lower()
    for name in requirements((ROOT / "environment.txt").read_text(encoding="utf-8").split("\n")):
        assert f"`{name}`" in text, f"book/contributing.md does not say what {name} is for"


def test_ci_calls_the_test_command_of_the_readme():
    command = "python3 make.py test"
    assert command in (ROOT / "README.md").read_text(encoding="utf-8")
    assert command in (ROOT / ".ci/run").read_text(encoding="utf-8")
