"""Misspelt names suggest the nearest one; an unconstrained motion names the missing part."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference import machines
from reference.cases import each_case
from reference.machines import SHAFTS, UNDAMPED, rotor


def pair(**options: Any) -> gb.RotorSystem:
    return machines.pair(SHAFTS, ("pinion", "wheel"), **{**UNDAMPED, **options})


def described(**changes) -> dict:
    return pair().description | changes


def scene_with(key: str, index: int, **changes) -> dict:
    given = pair().description
    given[key][index] |= changes
    return given


@each_case(
    ("call", "text"),
    [
        (
            lambda: pair(bearings=[gb.Bearing("inptu", 0.0, stiffness=1e8)]),
            r'^bearings\[0\].shaft: no shaft is called "inptu"; did you mean "input"\?',
        ),
        (
            lambda: pair(meshes=[gb.Mesh("pinon", "wheel")]),
            r'^meshes\[0\].driver: no gear is called "pinon"; did you mean "pinion"\?',
        ),
        (
            lambda: pair(torques=[gb.Torque("whel", 1.0)]),
            r'^torques\[0\].at: .* called "whel"; did you mean "wheel"\?',
        ),
        (
            lambda: pair(disks=[gb.Disk("a/b", "input", 0.25, 1.0, 1e-3, 2e-3)]),
            r'^disks\[0\].name: must not contain "/", got "a/b"',
        ),
        (lambda: pair(reference="imput"), r'^reference: .*; did you mean "input"\?'),
        (lambda: pair(motion="couple"), r'^motion: .*; did you mean "coupled"\?'),
        (
            lambda: pair().simulate(1e-3, 1.0, record=["wheeel"]),
            r'^record\[0\]: "wheeel" is no .*; did you mean "wheel"\?',
        ),
        (
            lambda: pair().simulate(1e-3, 1.0, record=["bearing"]),
            r'^record\[0\]: .*; did you mean "bearings"\?',
        ),
        (
            lambda: pair().simulate(1e-3, 1.0, record=[("outptu", 0.5)]),
            r'^record\[0\]: no shaft is called "outptu"; did you mean "output"\?',
        ),
        (
            lambda: pair().simulate(1e-3, 1.0, record=[("pinion", "weel")]),
            r'^record\[0\]: .* not in mesh; did you mean "wheel"\?',
        ),
        (
            lambda: pair().synchronous([1.0]).displacement("pinio"),
            r'^at: no gear, disk, support or housing is called "pinio"; did you mean "pinion"\?',
        ),
        (
            lambda: pair(meshes=[gb.Mesh("pinion", "wheel", stiffness=gb.Stiffness("sqare"))]),
            r'^meshes\[0\].stiffness.model: .*; did you mean "square"\?',
        ),
        (lambda: pair().balance(["pinoin"], 1.0), r'^planes\[0\]: .*; did you mean "pinion"\?'),
        (
            lambda: gb.RotorSystem.from_dict(scene_with("shafts", 0, lenght=1.0)),
            r'^shafts\[0\].*lenght.*; did you mean "length"\?',
        ),
        (
            lambda: gb.RotorSystem.from_dict(described(gravty=9.81)),
            r'gravty.*; did you mean "gravity"\?',
        ),
        (
            lambda: gb.RotorSystem.from_dict(
                scene_with("meshes", 0, stiffness={"model": "square", "pairs": 2e8})
            ),
            r'^meshes\[0\].stiffness.*pairs.*; did you mean "pair"\?',
        ),
    ],
)
def test_the_nearest_name_is_suggested(call, text):
    with pytest.raises(gb.SceneError, match=text):
        call()


def test_a_key_of_a_file(tmp_path):
    file = tmp_path / "scene.toml"
    pair().save(file)
    file.write_text(file.read_text().replace("outer_diameter", "outer_diametre", 1))
    with pytest.raises(gb.SceneError, match=r'outer_diametre.*; did you mean "outer_diameter"\?'):
        gb.RotorSystem.load(file)


def test_an_unlike_name_gets_no_suggestion():
    with pytest.raises(gb.SceneError, match=r'no shaft is called "something else"$'):
        pair(bearings=[gb.Bearing("something else", 0.0, stiffness=1e8)])


@each_case("sign", ["/", ":"])
@each_case(
    ("path", "changes"),
    [
        (
            "shafts[2].name",
            lambda name: {"shafts": [gb.Shaft(name, length=1.0, outer_diameter=0.05)]},
        ),
        ("disks[0].name", lambda name: {"disks": [gb.Disk(name, "input", 0.1, 1.0, 0.01, 0.02)]}),
        (
            "supports[0].name",
            lambda name: {"supports": [gb.Support(name, mass=1.0, stiffness=1e8)]},
        ),
        (
            "housings[0].points.",
            lambda name: {
                "housings": [
                    gb.Housing("box", mass=9.0, stiffness=1e8, points={name: (0.0, 0.0, 0.0)})
                ]
            },
        ),
    ],
)
def test_names_do_not_contain_what_joins_names(path, changes, sign):
    given = changes(f"a{sign}b")
    if "shafts" in given:
        given["shafts"] = [*pair().shafts, *given["shafts"]]
    with pytest.raises(gb.SceneError) as caught:
        pair(**given)
    text = str(caught.value)
    assert text.startswith(path)
    assert f'must not contain "{sign}", got "a{sign}b"' in text
    assert 'write "a-b"' in text


# --- missing parts --------------------------------------------------------------------------------

BALANCE = r"^torques: no static equilibrium: .*, is 250 N m; add gb.Torque.balance\("


def test_a_missing_torque_balance_is_named():
    with pytest.raises(gb.SceneError, match=BALANCE):
        pair(torques=[gb.Torque("pinion", 250.0)]).static()
    with pytest.raises(gb.SceneError, match=BALANCE):
        pair(torques=[gb.Torque("pinion", 250.0)]).simulate(1e-3, 1.0)


def test_a_missing_bearing_is_named():
    system = pair()
    held = [bearing for bearing in system.bearings if bearing.shaft == "input"]
    text = r'^shafts\[1\]: .*: "output" is unconstrained: no bearing .*gb.Bearing\("output"'
    with pytest.raises(gb.SceneError, match=text):
        system.replace(bearings=held).static()
    # a single bearing does not constrain the tilt of the shaft
    one = [*held, gb.Bearing("output", 0.0, stiffness=1e8)]
    text = (
        r'^shafts\[1\]: .*the load moves or tilts "output", which its bearings do not constrain; '
        "add a bearing at another"
    )
    with pytest.raises(gb.SceneError, match=text):
        system.replace(bearings=one).static()
    # and one that has stiffness in one direction only
    soft = [replace(bearing, stiffness=(1e8, 0.0)) for bearing in system.bearings]
    with pytest.raises(gb.SceneError, match="which its bearings do not constrain"):
        system.replace(bearings=soft).static()


def test_a_missing_bearing_is_named_before_a_missing_balance():
    system = pair(torques=[gb.Torque("pinion", 250.0)], bearings=[], gravity=9.81)
    with pytest.raises(gb.SceneError, match="no bearing holds"):
        system.static()


# --- no synchronous start -------------------------------------------------------------------------


def test_an_unbalance_in_gram_millimetres_is_named():
    with pytest.warns(gb.SceneWarning, match=r"^disks\[0\].unbalance: .*g mm"):
        system = rotor(disk=machines.inertia(20.0, 0.1, 0.2, unbalance=720.0))
    with pytest.raises(gb.SceneError, match=r'^initial: .*unbalance of "disk" .*in g mm\?'):
        system.simulate(1e-3, 100.0)


def test_an_undamped_critical_speed_is_named():
    system = rotor(disk=machines.inertia(20.0, 0.1, 0.2, unbalance=1e-4))
    critical = system.campbell(np.linspace(0.0, 500.0, 20), count=2).intersections[-1].speed
    with pytest.raises(gb.SceneError, match=r"^initial: .*critical speed with too little damping"):
        system.simulate(1e-3, critical)
