"""An effect answers for itself: nobody asks for its name, and a file of its own is all that it takes."""

import ast

import pytest

from conftest import ROOT

#: What compares names for a reason: the sentences and tables of a report, which speak of one effect.
SPEAKS = (
    "summary.py",
    "sensor.py",
    "data_faults.py",
    "table.py",
    "fault_masking.py",
    "fault_steps.py",
    "parameters.py",
)
FILES = [
    path
    for room in ("gap", "likelihood", "samples", "vibrations", "ensembles")
    for path in sorted((ROOT / "imu_lib" / room).rglob("*.py"))
    if path.name not in SPEAKS and not {"drive", "long"} & set(path.parts)
]


def asked(tree):
    """Lines in which the name of an effect or process is compared with a literal, or looked up by
    one.
    """
    for node in ast.walk(tree):
        if isinstance(node, ast.Compare):
            sides = [node.left, *node.comparators]
            named = any(
                isinstance(s, ast.Attribute) and s.attr in ("name", "effect") for s in sides
            )
            literal = any(
                isinstance(part, ast.Constant) and isinstance(part.value, str)
                for s in sides
                for part in ast.walk(s)
            )
            if named and literal:
                yield node.lineno
        if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Constant):
            if "CATALOGUE" in ast.unparse(node.value):
                yield node.lineno


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.relative_to(ROOT / "imu_lib").as_posix())
def test_nobody_asks_an_effect_for_its_name(path):
    assert not list(asked(ast.parse(path.read_text(encoding="utf-8"))))


def test_that_would_be_seen():
    for line in ('item.name == "low_pass"', 's.effect in ("stuck", "spikes")', 'CATALOGUE["step"]'):
        assert list(asked(ast.parse(line)))
