"""The examples run without warnings: their scenes are plausible machines.

Warnings are errors in tests. Long examples only build their systems here; `make random` runs them completely.
"""

from __future__ import annotations

import os
import runpy
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import gearbow as gb

EXAMPLES = Path(__file__).parents[3] / "examples"
COMPLETE = bool(os.environ.get("GEARBOW_CASES"))

pytestmark = pytest.mark.skipif(not EXAMPLES.is_dir(), reason="the examples are not installed")

#: The systems of each example, made as in its `main`. Examples without an entry are short and run completely.
SYSTEMS: dict[str, Callable[[Any], list[Any]]] = {
    "bowed_train": lambda m: [m.train(ratio * m.RADIUS) for ratio in m.BOWS],
    "figures": lambda m: [m.train(), m.train(m.BOW / 2.0)],
    "frequency": lambda m: [m.train(), m.rotor()],
    "labelled_signals": lambda m: [m.machine(**labels) for labels in m.machines(2)],
    "map": lambda m: [m.train(bow) for bow in m.BOWS[:2]],
    "housing": lambda m: [m.train(0.0), m.train(m.BOW)],
    "gearbox": lambda m: [m.gearbox(), m.straight(m.gearbox())],
    "resonance_sweep": lambda m: [m.pair(torque) for torque in m.TORQUES],
    "tradeoff": lambda m: [scene.system() for scene in m.SCENES.values()],
}
#: Arguments of a complete run; none for a study that takes many minutes.
ARGUMENTS: dict[str, list[str] | None] = {
    "bowed_train": ["--output", "figure.png"],
    "elements": ["conditioning"],
    "figures": [],
    "frequency": [],
    "labelled_signals": ["--count", "40"],
    "map": ["--output", "figure.png"],
    "from_ross": [],
    "gear_noise": [],
    "gearbox": [],
    "housing": [],
    "mesh_models": ["--output", "."],
    "published": ["--summary"],
    "resonance_sweep": ["--output", "figure.png"],
    "signals": [],
    "tradeoff": None,
    "verification": ["--measured"],
}
#: Libraries that a complete run needs and the tests do not install.
LIBRARIES = {"labelled_signals": "sklearn"}


def load(name: str, monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    """Run the module of an example without its `main`."""
    pytest.importorskip("matplotlib")
    path = EXAMPLES / f"{name}.py"
    # An example may import another one, as when it runs as a program.
    monkeypatch.syspath_prepend(EXAMPLES)
    # A dataclass looks its module up by name.
    module = SimpleNamespace(__name__=name)
    monkeypatch.setitem(sys.modules, name, module)
    vars(module).update(runpy.run_path(str(path), run_name=name))
    return module


def test_the_machines_of_the_examples_are_those_of_the_package():
    package = Path(gb.__file__).parent / "machines"
    examples = EXAMPLES / "machines"
    names = {path.name for path in package.glob("*.toml")}
    assert {path.name for path in examples.glob("*.toml")} == names
    for name in names:
        assert (examples / name).read_text("utf-8") == (package / name).read_text("utf-8"), name


def test_every_example_is_tested():
    assert sorted(ARGUMENTS) == sorted(path.stem for path in EXAMPLES.glob("*.py"))


@pytest.mark.parametrize("name", ARGUMENTS)
def test_an_example_has_plausible_scenes(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    module = load(name, monkeypatch)
    arguments = ARGUMENTS[name]
    if name in SYSTEMS:
        assert len(SYSTEMS[name](module)) > 1
    if arguments is None or (name in SYSTEMS and not COMPLETE):
        return
    if name in LIBRARIES:
        pytest.importorskip(LIBRARIES[name], reason=f"the example needs {LIBRARIES[name]}")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [name, *arguments])
    if "FIGURES" in vars(module):
        module.main.__globals__["FIGURES"] = tmp_path
    module.main()
