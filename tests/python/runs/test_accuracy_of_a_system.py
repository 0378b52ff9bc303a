"""One word decides elements, modes and tolerance: the accuracy of a system, which a run may only loosen."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from gearbow.accuracy import LEVELS
from gearbow.cli.main import main
from reference.machines import toothed_pair

# `scene/test_discretisation.py` tests the warning of coarse elements
pytestmark = pytest.mark.filterwarnings("ignore:accuracy:gearbow.AccuracyWarning")

SPEED = 100.0
WORDS = list(LEVELS)


def automatic(**options: Any) -> gb.RotorSystem:
    """Return the pair without numbers of elements."""
    system = toothed_pair()
    shafts = [replace(shaft, elements=None) for shaft in system.shafts]
    return system.replace(shafts=shafts, **options)


def asked(run: gb.Response) -> tuple[Any, ...]:
    """Return the accuracy and the tolerance that a run asked for."""
    assert run.request is not None
    return run.request.options["accuracy"], run.request.options["rtol"]


def test_a_run_has_the_accuracy_of_its_system():
    for word in WORDS:
        system = automatic(accuracy=word)
        assert f"accuracy {word!r}" in str(system)
        assert system.discretisation.level == word
        run = system.simulate(0.0, SPEED)
        assert asked(run) == (word, None)
        assert run.accuracy is not None
        assert run.accuracy.startswith(f"{word}: ")
        assert repr(run).endswith(f"; accuracy {word!r})")
    assert "accuracy" not in repr(automatic().simulate(0.0, SPEED, rtol=1e-4))


def test_the_word_decides_the_tolerance():
    system = toothed_pair(2, accuracy="draft")
    run = system.simulate(0.01, SPEED)
    same = system.simulate(0.01, SPEED, rtol=LEVELS["draft"].rtol)
    np.testing.assert_array_equal(run.final["state"], same.final["state"])
    other = system.replace(accuracy="engineering").simulate(0.01, SPEED)
    assert other.statistics.evaluations > run.statistics.evaluations


def test_a_run_may_loosen_the_accuracy_and_keeps_the_elements():
    system = automatic()
    loose = system.simulate(0.01, SPEED, accuracy="draft")
    assert asked(loose) == ("draft", None)
    # the same elements, so that one run continues the other
    system.simulate(1e-3, SPEED, initial=loose)
    steady = system.steady_state(SPEED, accuracy="draft")
    assert asked(steady.response) == ("draft", None)


def test_a_stricter_word_is_an_error_that_names_the_way():
    for given, word in (("draft", "engineering"), ("engineering", "reference")):
        for system in (toothed_pair(2, accuracy=given), automatic(accuracy=given)):
            for run in (
                lambda s, w: s.simulate(1e-3, SPEED, accuracy=w),
                lambda s, w: s.steady_state(SPEED, accuracy=w),
                lambda s, w: s.simulate_many([{}], 1e-3, SPEED, accuracy=w),
            ):
                with pytest.raises(gb.SceneError) as caught:
                    run(system, word)
                text = str(caught.value)
                assert f"accuracy: {word!r} is stricter than {given!r}" in text
                assert f"system.replace(accuracy={word!r})" in text
    # this is the way
    finer = toothed_pair(2, accuracy="draft").replace(accuracy="engineering")
    finer.simulate(1e-3, SPEED)


def test_resolution_is_no_name():
    with pytest.raises(TypeError, match="resolution"):
        gb.RotorSystem(toothed_pair().shafts, resolution="draft")
    with pytest.raises(gb.SceneError, match="resolution"):
        toothed_pair().replace(resolution="draft")
    with pytest.raises(gb.SceneError, match="resolution"):
        gb.RotorSystem.from_dict({**toothed_pair().description, "resolution": "draft"})


def test_a_variation_may_have_another_accuracy():
    draft, own = toothed_pair(2).simulate_many([{"accuracy": "draft"}, {}], 1e-3, SPEED)
    assert asked(draft) == ("draft", None)
    assert asked(own) == ("engineering", None)


def test_a_file_keeps_the_accuracy_and_its_errors_refer_to_it(tmp_path):
    system = toothed_pair(4, accuracy="draft")
    system.save(tmp_path / "scene.toml")
    assert 'accuracy = "draft"' in (tmp_path / "scene.toml").read_text("utf-8")
    loaded = gb.RotorSystem.load(tmp_path / "scene.toml")
    assert loaded.accuracy == "draft"
    run = loaded.simulate(0.02, SPEED)
    run.save(tmp_path / "run.npz")
    again = gb.Response.load(tmp_path / "run.npz")
    assert asked(again) == ("draft", None)
    assert again.accuracy == run.accuracy
    explicit = loaded.simulate(0.02, SPEED, rtol=LEVELS["draft"].rtol)
    for kind, error in again.errors().items():
        assert error.integration == pytest.approx(explicit.errors()[kind].integration, rel=1e-6)


def test_the_command_line_gives_the_accuracy_of_the_scene(tmp_path, capsys):
    automatic(accuracy="draft").save(tmp_path / "scene.toml")
    command = ["run", str(tmp_path / "scene.toml"), "--duration", "1 ms", "--speed", "100"]
    sizes = []
    for word in (None, "draft", "engineering"):
        given = [] if word is None else ["--accuracy", word]
        with pytest.raises(SystemExit, match="0"):
            main([*command, *given, "--json", "--out", str(tmp_path / "run.npz")])
        run = gb.Response.load(tmp_path / "run.npz")
        assert asked(run)[0] == json.loads(capsys.readouterr().out)["accuracy"] == (word or "draft")
        sizes.append(len(run.final["state"]))
    assert sizes[0] == sizes[1] < sizes[2]
