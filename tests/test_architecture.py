"""The house stands as book/contributing.md describes it: the table of layers there is read and
held against the imports.
"""

import ast
import re

import pytest

from conftest import ROOT

PACKAGE = ROOT / "imu_lib"
LONGEST = 350  # lines; a room that outgrows it becomes a package
LARGEST = 1_500_000  # bytes of a tracked file
# `Model.load("preset:NAME")` opens a preset, and presets are made of models: looked up when asked,
# not at import
EXCEPTIONS = {("model", "presets")}
FILES = sorted(path for path in PACKAGE.rglob("*.py") if "_book" not in path.parts)


def layers():
    """Room -> layer, from the table of the contributor's page."""
    text = (ROOT / "book/contributing.md").read_text(encoding="utf-8")
    table = text.split("<!-- layers -->")[1]
    found = {}
    for number, rooms in re.findall(r"^\| (\d+) \| ([^|]*) \|", table, re.MULTILINE):
        found.update({room: int(number) for room in re.findall(r"`(\w+)/?`", rooms)})
    return found


def room(path):
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imports(path):
    """(line, module) of every import, also those inside functions; relative ones spelled out."""
    package = ("imu_lib", *path.relative_to(PACKAGE).parts[:-1])
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = ".".join(package[: len(package) - node.level + 1]) if node.level else ""
            module = ".".join(filter(None, (base, node.module)))
            if module == "imu_lib":  # from imu_lib import units, read_record
                yield from ((node.lineno, f"imu_lib.{alias.name}") for alias in node.names)
            else:
                yield node.lineno, module


def breaches(path):
    table, own = layers(), room(path)
    for line, module in imports(path):
        parts = module.split(".")
        if parts[0] == "imu_lib" and len(parts) > 1 and parts[1] != own:
            if parts[1] not in table:
                yield f"{path.name}:{line}: `{module}` is no room of the table (import it from its own room)"
            elif table[parts[1]] >= table[own] and (own, parts[1]) not in EXCEPTIONS:
                yield f"{path.name}:{line}: {own} (layer {table[own]}) imports {parts[1]} (layer {table[parts[1]]})"
        if parts[0] == "matplotlib" and own != "plots":
            yield f"{path.name}:{line}: matplotlib outside of plots"


def test_every_room_has_its_layer():
    rooms = {room(path) for path in FILES} - {"__init__", "__main__"}
    assert rooms == set(layers()), "rooms without a layer, or layers without a room"


@pytest.mark.parametrize(
    "path",
    [path for path in FILES if room(path) not in ("__init__", "__main__")],
    ids=lambda path: path.relative_to(PACKAGE).as_posix(),
)
def test_imports_go_downward(path):
    assert not list(breaches(path))


def test_importing_the_package_is_light():
    """`import imu_lib` loads nothing heavy: every room is opened when it is first asked for."""
    import subprocess
    import sys

    code = "import sys, imu_lib; print([m for m in ('numpy', 'matplotlib', 'numba', 'pandas') if m in sys.modules])"
    assert (
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout.strip()
        == "[]"
    )


def test_every_public_name_exists():
    import imu_lib

    for name in imu_lib.__all__:
        assert getattr(imu_lib, name) is not None


def test_every_plot_exists():
    from imu_lib import plots

    for name in plots.__all__:
        assert callable(getattr(plots, name)), name


@pytest.mark.parametrize(
    "path",
    [*FILES, *sorted((ROOT / "tests").rglob("*.py")), ROOT / "make.py"],
    ids=lambda path: path.relative_to(ROOT).as_posix(),
)
def test_files_stay_small(path):
    assert len(path.read_text(encoding="utf-8").splitlines()) <= LONGEST


def test_no_large_file_and_no_machine_path():
    for folder in ("book", "nbs", "imu_lib", "tests", "benchmarks"):
        for path in (ROOT / folder).rglob("*"):
            if path.is_file() and "_build" not in path.parts and "__pycache__" not in path.parts:
                assert path.stat().st_size < LARGEST, path
                if path.suffix in (".py", ".md", ".json", ".ipynb", ".toml", ".yml"):
                    text = path.read_text(encoding="utf-8")
                    assert str(ROOT) not in text and not re.search(
                        r"(/home/|/root/|/Users/)\w", text
                    ), path
