"""What carries the project on: citation, changelog, workflow and hooks agree with the rest."""

import re
import tomllib

import pytest
import yaml

from conftest import ROOT
from imu_lib.book import api, front

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def test_citation_has_the_version_and_licence():
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert cited["version"] == PROJECT["version"] and cited["license"] == "MIT"
    assert cited["cff-version"] == "1.2.0" and cited["authors"]


def test_changelog_has_the_version():
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert f"## {PROJECT['version']} (" in text


def test_workflow_runs_the_test_command_on_three_systems():
    flow = yaml.safe_load((ROOT / ".github/workflows/test.yml").read_text(encoding="utf-8"))
    job = flow["jobs"]["test"]
    assert len(job["strategy"]["matrix"]["os"]) == 3
    assert "python make.py test" in [step.get("run") for step in job["steps"]]


def test_hooks_call_what_lint_calls():
    hooks = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8"))
    entries = " ".join(hook["entry"] for repo in hooks["repos"] for hook in repo["hooks"])
    assert "ruff check" in entries and "ruff format" in entries


def test_the_book_is_an_extra():
    names = {re.match(r"[\w-]+", line)[0] for line in PROJECT["dependencies"]}
    extra = {re.match(r"[\w-]+", line)[0] for line in PROJECT["optional-dependencies"]["book"]}
    assert not names & extra and "jupyter-book" in extra


def test_front_page_asks_and_answers():
    table = front.questions(ROOT)
    assert table.count("?") >= 20
    page = (ROOT / "book/intro.md").read_text(encoding="utf-8")
    assert "<!-- questions -->" in page and "<!-- chapters -->" in page


@pytest.mark.parametrize("module", api.modules())
def test_the_reference_imports(module):
    from importlib import import_module

    assert import_module(module).__doc__
