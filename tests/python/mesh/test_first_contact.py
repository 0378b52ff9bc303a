"""First contact: import, names, help."""

from __future__ import annotations

import contextlib
import inspect
import json
import pydoc

import pytest

import gearbow as gb
from reference.cases import each_case
from reference.processes import printed

#: Modules that only some functions need. The import takes as long as its modules.
HEAVY = {
    "tqdm",
    "matplotlib",
    "scipy",
    "pandas",
    "xarray",
    "h5py",
    "pint",
    "ross",
    "dask",
    "argparse",
}
HEAVY |= {"zipfile", "tomllib", "tomli", "html", "fractions", "decimal", "statistics", "difflib"}
HEAVY |= {"email", "importlib.metadata", "multiprocessing", "asyncio", "sqlite3", "random"}


def test_the_import_is_small():
    code = "import json, sys, numpy; before = set(sys.modules); import gearbow"
    added = set(
        json.loads(printed(f"{code}; print(json.dumps(sorted(set(sys.modules) - before)))"))
    )
    assert added & HEAVY == set()
    assert {name.split(".")[1] for name in added if name.startswith("gearbow.")} & {
        "plotting",
        "cli",
    } == set()
    assert added & {"hashlib", "gearbow.sweeps.run", "gearbow.studies.study"} == set()
    # of the standard library and of gearbow itself
    assert len(added) < 160


def test_completion_shows_the_public_names_only():
    for name in dir(gb):
        assert not inspect.ismodule(getattr(gb, name)), name
        assert not name.startswith("_") or name == "__version__"
    assert {"Any", "TYPE_CHECKING", "annotations"} & set(dir(gb)) == set()


def test_an_unknown_name_of_the_package_is_refused():
    with pytest.raises(AttributeError, match="module 'gearbow' has no attribute 'Geer'"):
        _ = gb.Geer


def test_the_help_of_the_package_fits_on_a_screen():
    text = inspect.getdoc(gb)
    assert text.count("\n") < 40
    assert ">>>" in text
    assert all(len(line) <= 100 for line in text.splitlines())
    # without the listing of every class
    assert pydoc.plain(pydoc.render_doc(gb)).count("\n") <= 67


PUBLIC = {name: getattr(module, name) for module in (gb, gb.results) for name in dir(module)}


def test_results_that_no_file_holds_are_not_at_the_top():
    assert {*dir(gb)} & {*dir(gb.results)} == {"Continuation", "Response", "SteadyState", "Sweep"}
    assert all(hasattr(getattr(gb, name), "load") for name in {*dir(gb)} & {*dir(gb.results)})
    with pytest.raises(AttributeError, match=r"module 'gearbow\.results' has no attribute 'Mode'"):
        _ = gb.results.Mode


@each_case("name", [name for name in PUBLIC if inspect.isclass(PUBLIC[name])])
def test_signatures_show_array_like_by_its_name(name: str):
    members = inspect.getmembers(PUBLIC[name], inspect.isfunction)
    for each in (PUBLIC[name], *(method for key, method in members if key[0] != "_")):
        # Some exceptions and bases have no signature of their own.
        with contextlib.suppress(ValueError):
            assert "numpy._typing" not in str(inspect.signature(each)), each


@each_case("name", [name for name in PUBLIC if callable(PUBLIC[name])])
def test_a_docstring_begins_with_one_sentence_and_has_an_example(name: str):
    text = inspect.getdoc(PUBLIC[name])
    first, *_ = text.split("\n\n")
    assert first.endswith(".")
    assert "\n" not in first
    one = PUBLIC[name]
    if not (inspect.isclass(one) and issubclass(one, Exception)):
        assert ">>>" in text
