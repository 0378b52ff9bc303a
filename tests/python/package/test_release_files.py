"""Metadata, workflows and paper: what several files state agrees, and nothing refers to a missing file."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

import pytest

yaml = pytest.importorskip("yaml")
ROOT = Path(__file__).parents[3]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
PAPER = ROOT / "paper" / "paper.md"

pytestmark = pytest.mark.skipif(not WORKFLOWS, reason="the files are not installed")


@pytest.fixture
def tools(monkeypatch: pytest.MonkeyPatch):
    """Make the tools importable."""
    monkeypatch.syspath_prepend(ROOT / "tools")
    yield
    for name in ("metadata", "use_package"):
        sys.modules.pop(name, None)


def jobs(workflow: Path) -> dict[str, Any]:
    return yaml.safe_load(workflow.read_text(encoding="utf-8"))["jobs"]


def steps(workflow: Path) -> list[dict[str, Any]]:
    return [step for job in jobs(workflow).values() for step in job["steps"]]


@pytest.mark.usefixtures("tools")
def test_files_state_one_version():
    import metadata

    import gearbow

    assert metadata.version() == gearbow.__version__


@pytest.mark.usefixtures("tools")
def test_workflows_test_the_oldest_and_the_newest_python():
    import metadata

    supported = metadata.pythons()
    assert supported[0] == "3.10"
    test = yaml.safe_load((ROOT / ".github/workflows/ci.yml").read_text(encoding="utf-8"))
    matrix = test["jobs"]["python"]["strategy"]["matrix"]
    assert {supported[0], supported[-1]} <= set(matrix["python"])
    tested = [*matrix["python"], *(one["python"] for one in matrix["include"])]
    assert sorted(tested) == sorted(supported)
    for job in ("linux", "others"):
        found = [
            step["with"]["python-version"]
            for step in jobs(ROOT / ".github/workflows/release.yml")[job]["steps"]
            if "setup-python" in step.get("uses", "")
        ]
        assert found[0] == supported[0]
        assert supported[-1] in found


@pytest.mark.parametrize("workflow", WORKFLOWS, ids=lambda path: path.name)
def test_a_workflow_says_that_it_has_not_run_and_uses_files_that_exist(workflow: Path):
    text = workflow.read_text(encoding="utf-8")
    assert text.startswith("# Not run yet:")
    assert "secrets." not in text
    for step in steps(workflow):
        assert ("run" in step) != ("uses" in step)
        for name in re.findall(
            r"\b(?:tools|tests)/[\w/]+(?:\.py)?|README\.md", step.get("run", "")
        ):
            assert (ROOT / name).exists(), name
        for target in re.findall(r"\bmake (\S+)", step.get("run", "")):
            assert re.search(f"^{target}:", (ROOT / "Makefile").read_text(), re.MULTILINE), target


def test_only_the_job_that_publishes_may_write():
    for workflow in WORKFLOWS:
        content = yaml.safe_load(workflow.read_text(encoding="utf-8"))
        assert content["permissions"] == {"contents": "read"}
        writing = {name for name, job in content["jobs"].items() if "permissions" in job}
        assert writing <= {"publish"}
    publish = jobs(ROOT / ".github/workflows/release.yml")["publish"]
    assert set(publish["needs"]) == {*jobs(ROOT / ".github/workflows/release.yml")} - {"publish"}


@pytest.mark.usefixtures("tools")
def test_every_placeholder_is_one_of_address_contact_and_doi():
    import metadata

    found = metadata.placeholders()
    texts = re.findall(r"[\w@:/.]*placeholder\.invalid", "\n".join(line for line in found))
    known = {
        "https://placeholder.invalid",
        "contact@placeholder.invalid",
        "10.0000/placeholder.invalid",
        "placeholder.invalid",  # names that only the authors know
    }
    assert set(texts) == known
    stated = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    urls = re.findall(r'^\w+ = "(https?://[^"]+)"', stated, re.MULTILINE)
    assert urls
    assert all(url.startswith("https://placeholder.invalid/gearbow") for url in urls)


def test_the_paper_cites_what_its_bibliography_has():
    text = PAPER.read_text(encoding="utf-8")
    cited = set(re.findall(r"@([a-z]+\d{4})", text))
    listed = re.findall(
        r"^@\w+\{(\w+),$", (ROOT / "paper/paper.bib").read_text("utf-8"), re.MULTILINE
    )
    assert sorted(cited) == listed
    body = re.sub(r"<!--.*?-->", "", text.split("---", 2)[2], flags=re.DOTALL)
    words = [
        word for line in body.splitlines() if not line.startswith("|") for word in line.split()
    ]
    assert 750 <= len(words) <= 1750
    headings = re.findall(r"^# (.+)$", body, re.MULTILINE)
    assert {"Summary", "Statement of need", "State of the field"} <= set(headings)


def test_the_recipe_needs_what_the_package_needs():
    recipe = yaml.safe_load((ROOT / "conda/recipe.yaml").read_text(encoding="utf-8"))
    stated = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    [line] = re.findall(r"^dependencies = \[(.+)\]$", stated, re.MULTILINE)
    needed = {re.split(r"[>=;]", one.strip(' "'))[0] for one in line.split(", ")}
    assert {one.split()[0] for one in recipe["requirements"]["run"]} == needed | {"python"}
    oldest = re.search(r'^requires-python = ">=(.+)"', stated, re.MULTILINE)
    assert recipe["context"]["python_min"] == oldest[1]


@pytest.mark.usefixtures("tools")
def test_the_example_that_a_release_runs_is_that_of_the_readme(capsys):
    import use_package

    code, expected = use_package.example()
    assert "import gearbow as gb" in code
    exec(compile(code, "README.md", "exec"), {})
    assert capsys.readouterr().out.split() == expected.split()
