"""Scene files: valid contents of a TOML file, and error messages for mistakes in it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import gearbow as gb
from reference import scenes
from reference.bows import HalfSine
from reference.scenes import Geared


def load(tmp_path: Path, text: str) -> gb.RotorSystem:
    path = tmp_path / "scene.toml"
    path.write_text(text, encoding="utf-8")
    return gb.RotorSystem.load(path)


TOML = """
[[shafts]]
name = "a"
length = 0.5
outer_diameter = 0.05
elements = 4
bow = { shape = "half_sine", amplitude = 1e-4 }

[[bearings]]
shaft = "a"
position = 0.0
stiffness = 1e8

[[bearings]]
shaft = "a"
position = 0.5
stiffness = [1e8, 2e8]
"""


def test_a_file(tmp_path: Path):
    assert load(tmp_path, TOML).matrices().mass.shape == (20, 20)


@pytest.mark.parametrize(
    ("old", "new", "where"),
    [
        ("elements = 4", "elements = 4\ncolour = 3", "shafts[0]"),
        ("length = 0.5", "lenght = 0.5", "shafts[0]"),
        ("amplitude = 1e-4 }", "amplitude = 1e-4, plane = 1 }", "shafts[0].bow"),
        ('shape = "half_sine"', 'shape = "banana"', "shafts[0].bow"),
        ("amplitude = 1e-4", "amplitude = nan", "shafts[0].bow.amplitude"),
        ("stiffness = 1e8\n", "stiffness = 1e8\nsoftness = 1\n", "bearings[0]"),
        ("position = 0.5", 'position = "end"', "bearings[1].position"),
        ('name = "a"', "name = 3", "shafts[0].name"),
    ],
)
def test_a_file_with_a_mistake(tmp_path: Path, old: str, new: str, where: str):
    assert old in TOML
    with pytest.raises(gb.SceneError) as caught:
        load(tmp_path, TOML.replace(old, new))
    text = str(caught.value)
    assert text.startswith(where), text
    for word in ("colour", "lenght", "plane", "softness", "banana"):
        if word in new:
            assert word in text


def test_a_file_with_an_unknown_table(tmp_path: Path):
    with pytest.raises(gb.SceneError, match="gaers"):
        load(tmp_path, TOML + '\n[[gaers]]\nname = "g"\n')


def test_a_file_that_is_not_toml(tmp_path: Path):
    with pytest.raises(gb.SceneError):
        load(tmp_path, TOML + "\n[[shafts\n")


def test_saved_and_loaded_scene_is_the_same(tmp_path: Path):
    everything = replace(
        Geared(
            bows={"input": HalfSine(1.5e-4), "middle": HalfSine(1.5e-4, 0.8)}, angles=(0.4, -1.1)
        ),
        gears=[replace(g, unbalance=1e-4 + 2e-5j) for g in Geared().gears],
        bearing_stiffness=np.array([[1e8, 1.1e7], [1.1e7, 7e7]]),
        gravity=(0.3, -9.81),
        modal_damping=0.013,
        options={"reference": "middle"},
    )
    for i, system in enumerate((everything.package(), scenes.v1(), scenes.v2(), scenes.v3())):
        path = tmp_path / f"scene{i}.toml"
        system.save(path)
        if i == 1:
            with pytest.warns(gb.SceneWarning):
                again = gb.RotorSystem.load(path)
        else:
            again = gb.RotorSystem.load(path)
        for name in ("mass", "stiffness", "damping", "gyroscopic"):
            first, second = (getattr(s.matrices(), name) for s in (system, again))
            assert np.array_equal(first, second), name
        assert again.matrices().dofs == system.matrices().dofs
        assert np.array_equal(again.speed_ratios, system.speed_ratios)
        a, b = (s.synchronous([50.0]).amplitudes for s in (system, again))
        assert np.array_equal(a, b)


def test_saved_bow_of_points_and_of_a_function(tmp_path: Path):
    for bow in (
        gb.Bow.points([0, 0.2, 1.0], [0, 1e-4, 3e-5], [0, 0.4, -0.4]),
        gb.Bow.function(lambda x: 1e-4 * x**2 * (1 + 0.3j * x)),
        gb.Bow.sag(1e-4, phase=0.1),
        gb.Bow.mode(3, 1e-4, phase=0.1),
    ):
        system = scenes.single_shaft(bow)
        system.save(tmp_path / "scene.toml")
        again = gb.RotorSystem.load(tmp_path / "scene.toml")
        a, b = (s.synchronous([300.0]).displacement(("s", 0.5)) for s in (system, again))
        assert np.array_equal(a, b)
        assert np.abs(a).max() > 1e-6
