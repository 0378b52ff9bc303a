"""The table of planted faults fits the source code; `tests/mutation/run.py` plants them."""

from __future__ import annotations

import ast
import runpy
from pathlib import Path

import pytest

import gearbow

ROOT = Path(__file__).parents[2]
TABLE = runpy.run_path(str(ROOT / "tests/mutation/faults.py"))["FAULTS"]
PACKAGE = Path(gearbow.__file__).parent
MODULES = sorted({fault.module for fault in TABLE})


@pytest.mark.parametrize("module", MODULES)
def test_every_fault_changes_one_place_of_its_module(module: str):
    source = (PACKAGE / module).read_text(encoding="utf-8")
    original = ast.dump(ast.parse(source))
    changed = set()
    for fault in TABLE:
        if fault.module != module:
            continue
        assert source.count(fault.text) == 1, (
            f"{module} must hold {fault.text!r} once: adapt the entry in tests/mutation/faults.py"
        )
        planted = ast.dump(ast.parse(source.replace(fault.text, fault.replacement)))
        assert planted != original, f"{fault.replacement!r} is no fault"
        assert planted not in changed, f"{fault.replacement!r} is planted twice"
        changed.add(planted)


def test_every_fault_of_the_core_changes_one_place_of_its_module(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.syspath_prepend(str(ROOT / "tests/mutation"))
    table = runpy.run_path(str(ROOT / "tests/mutation/core.py"))["FAULTS"]
    assert len(table) >= 8
    for fault in table:
        source = (ROOT / "src" / fault.module).read_text(encoding="utf-8")
        assert source.count(fault.text) == 1, (
            f"src/{fault.module} must hold {fault.text!r} once: adapt tests/mutation/core.py"
        )
        assert fault.text != fault.replacement


def test_every_fault_names_tests_that_exist():
    assert len(TABLE) >= 40
    for fault in TABLE:
        assert fault.tests
        for name in fault.tests:
            assert (Path(__file__).parent / f"test_{name}.py").is_file(), name
