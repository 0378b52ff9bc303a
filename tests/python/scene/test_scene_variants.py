"""Variants of a system: `replace`, `from_dict`, and the options as attributes."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

import gearbow as gb
from reference.machines import pair

OPTIONS = {
    "reference": "b",
    "modal_damping": 0.01,
    "rayleigh": (1.0, 1e-6),
    "gravity": (1.0, -9.81),
    "motion": "coupled",
}


def full() -> gb.RotorSystem:
    """Return a system with every kind of part and every option."""
    wheel = gb.Disk("wheel", "a", 0.1, 2.0, 1e-3, 2e-3, unbalance=1e-5j)
    return pair(("a", "b"), ("ga", "gb"), mesh={"stiffness": 2e8}, disks=[wheel], **OPTIONS)


PARTS = ("shafts", "gears", "meshes", "bearings", "torques", "disks")


@pytest.mark.parametrize("name", PARTS)
def test_replace_keeps_all_other_parts_and_options(name):
    system = full()
    same = system.replace(**{name: getattr(system, name)})
    assert same.description == system.description
    assert same is not system


def test_replace_changes_only_the_given_argument():
    system = full()
    shafts = [replace(system.shafts[0], bow=gb.Bow.half_sine(1e-4)), system.shafts[1]]
    bent = system.replace(shafts=shafts)
    changed = {key for key in bent.description if bent.description[key] != system.description[key]}
    assert changed == {"shafts"}
    assert bent.disks == system.disks
    for key, value in OPTIONS.items():
        assert getattr(bent, key) == value
    np.testing.assert_array_equal(bent.matrices().damping, system.matrices().damping)


@pytest.mark.parametrize("name", OPTIONS)
def test_none_removes_an_option(name):
    other = full().replace(**{name: None})
    assert getattr(other, name) is None
    assert name not in other.description
    for key in OPTIONS.keys() - {name}:
        assert getattr(other, key) == OPTIONS[key]


@pytest.mark.parametrize("way", ["made", "file", "pickle", "dict", "replace"])
def test_options_are_attributes_of_every_system(way, tmp_path):
    system = full()
    if way == "file":
        system.save(tmp_path / "scene.toml")
        system = gb.RotorSystem.load(tmp_path / "scene.toml")
    elif way == "pickle":
        system = pickle.loads(pickle.dumps(system))
    elif way == "dict":
        system = gb.RotorSystem.from_dict(system.description)
    elif way == "replace":
        system = system.replace()
    assert {name: getattr(system, name) for name in OPTIONS} == OPTIONS


def test_a_bow_function_is_kept():
    shaft = gb.Shaft(
        "a",
        length=1.0,
        outer_diameter=0.05,
        elements=2,
        bow=gb.Bow.function(lambda x: 1e-4 * x * (1 - x)),
    )
    system = gb.RotorSystem([shaft], gravity=9.81)
    longer = system.replace(shafts=[replace(shaft, length=1.2)])
    assert longer.description["shafts"][0]["bow"]["positions"][-1] == 1.2


def test_from_dict_is_the_inverse_of_description():
    system = full()
    again = gb.RotorSystem.from_dict(system.description)
    assert again.description == system.description
    assert again.gears == system.gears
    assert again.disks == system.disks


def test_from_dict_takes_numpy_and_complex_numbers():
    given = full().description
    given["gravity"] = np.array([1.0, -9.81])
    given["modal_damping"] = np.float32(0.5)
    given["disks"][0]["unbalance"] = 1e-5j
    given["bearings"][0]["stiffness"] = 1e8 * np.eye(2)
    given["motion"] = None
    system = gb.RotorSystem.from_dict(given)
    assert system.gravity == (1.0, -9.81)
    assert system.disks[0].unbalance == 1e-5j


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (
            {"shaft": []},
            "^replace: 'shaft' is not a parameter of a system; did you mean \"shafts\"",
        ),
        ({"gravitiy": 1.0}, 'did you mean "gravity"'),
        ({"modal_damping": "much"}, "^modal_damping: must be a number"),
        ({"gears": []}, r"^torques\[0\].at: no gear or disk is called"),
    ],
)
def test_invalid_replacements_are_errors(change, text):
    with pytest.raises(gb.SceneError, match=text):
        full().replace(**change)


def test_warnings_point_to_the_line_that_made_the_variant():
    system = full()
    with pytest.warns(gb.SceneWarning, match="modal damping") as caught:
        system.replace(modal_damping=2.0)
    assert caught[0].filename == __file__
    with pytest.warns(gb.SceneWarning, match="modal damping") as caught:
        gb.RotorSystem.from_dict(system.description | {"modal_damping": 2.0})
    assert caught[0].filename == __file__
