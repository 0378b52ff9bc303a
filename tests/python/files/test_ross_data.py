"""Rotors of ROSS's own test data, against eigenvalues that ROSS 2.3 gives for these files.

The files are not part of the repository: the environment variable GEARBOW_TEST_DATA names their folder.
"""

import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import gearbow as gb

DATA = os.environ.get("GEARBOW_TEST_DATA")
needs_data = pytest.mark.skipif(
    DATA is None, reason="GEARBOW_TEST_DATA does not name the folder of the files of ROSS"
)
#: Lowest eigenvalues of bending at speeds that the tables of all bearings contain [rad/s].
EIGENVALUES = {
    ("compressor_example", 628.3185307182): [
        complex(-261.1112, 1010.928),
        complex(-161.4105, 1038.323),
        complex(-1560.366, 984.6139),
        complex(-1629.373, 979.0547),
        complex(-1424.169, 1280.959),
        complex(-1507.668, 1310.078),
        complex(-261.9513, 2202.001),
        complex(-242.4676, 2288.961),
    ],
    ("compressor_example", 942.4777960773): [
        complex(-120.5626, 1040.41),
        complex(-284.7715, 1008.66),
        complex(-851.8007, 1702.489),
        complex(-906.5277, 1727.836),
        complex(-1175.806, 1575.408),
        complex(-1185.513, 1606.475),
        complex(-291.0492, 2191.349),
        complex(-246.0639, 2316.703),
    ],
    ("rotor", 628.3185307182): [
        complex(-346.992, 32.85233),
        complex(-1005.926, 18.16945),
        complex(-842.6446, 1184.837),
        complex(-904.9082, 1159.548),
        complex(-1679.498, 30.87058),
        complex(-428.2555, 1723.248),
        complex(-450.909, 1772.674),
        complex(-601.4662, 3612.75),
    ],
    ("rotor", 942.4777960773): [
        complex(-1022.957, 93.36596),
        complex(-466.1848, 1266.165),
        complex(-625.1486, 1284.169),
        complex(-518.4356, 1702.026),
        complex(-640.6403, 1896.293),
        complex(-818.1422, 1858.747),
        complex(-867.5207, 1921.533),
        complex(-3147.16, 5.044643),
    ],
}
#: The same of the compressor at 628 rad/s, with every element of ROSS divided into four.
REFINED = [
    complex(-261.0887950911575, 1010.9089802202661),
    complex(-161.40339373672052, 1038.316019594005),
    complex(-1560.5261297236577, 984.6558438595092),
    complex(-1629.5381552567299, 979.113235698005),
    complex(-1424.2602183587371, 1281.3007178462108),
    complex(-1507.7858560042375, 1310.4400218133062),
    complex(-261.9638003819341, 2201.5541904159422),
    complex(-242.43181313710608, 2288.7072766692827),
]
#: Largest relative difference with the elements of the files. ROSS gives each layer of an element shape functions of its own,
#: so that layers slide on each other between the nodes; this error of the elements is up to 2.4e-4, and vanishes with their
#: length. Rotors without layers agree to 1e-6 (test_exchange.py).
DIFFERENCE = 2.5e-4
#: The same with shorter elements.
REFINED_DIFFERENCE = 1e-4


@needs_data
@pytest.mark.parametrize(("name", "speed"), list(EIGENVALUES))
def test_compressors_of_ross_have_the_modes_of_ross(name: str, speed: float):
    system = gb.RotorSystem.from_ross(Path(DATA or "") / "ross" / f"{name}.toml")
    assert len(system.shafts[0].segments) == 55
    assert len(system.sleeves) == 36
    # The hubs have a modulus of 1 psi: they are masses only.
    assert {sleeve.stiffness for sleeve in system.sleeves} == {"none"}
    found = system.modes(speed).eigenvalues
    for expected in EIGENVALUES[name, speed]:
        assert np.abs(found - expected).min() < DIFFERENCE * abs(expected), expected


@needs_data
def test_with_short_elements_the_modes_agree_to_1e_4():
    system = gb.RotorSystem.from_ross(Path(DATA or "") / "ross" / "compressor_example.toml")
    (shaft,) = system.shafts
    segments = [replace(segment, elements=4) for segment in shaft.segments]
    found = system.replace(shafts=[replace(shaft, segments=segments)]).modes(628.3185307182)
    for expected in REFINED:
        difference = np.abs(found.eigenvalues - expected).min()
        assert difference < REFINED_DIFFERENCE * abs(expected), expected


def element(n: int, outer: float, inner: float = 0.0, **changed) -> dict:
    material = {"rho": 7810.0, "E": 211e9, "G_s": 81.2e9}
    diameters = {"odl": outer, "odr": outer, "idl": inner, "idr": inner}
    return {"L": 0.1, "n": n, **diameters, "material": material, "rotary_inertia": True, **changed}


def read(tmp_path: Path, *elements: dict) -> gb.RotorSystem:
    bearing = {"kxx": 1e7, "kyy": 1e7}
    plain = {f"ShaftElement_e{i}": each for i, each in enumerate(elements)}
    plain |= {f"BearingElement_b{n}": {**bearing, "n": n, "tag": f"b{n}"} for n in (0, 2)}
    (tmp_path / "rotor.json").write_text(json.dumps({"ross_version": "2.3.0", **plain}))
    return gb.RotorSystem.from_ross(tmp_path / "rotor.json")


def test_layers_are_sleeves_and_cones_are_cones(tmp_path: Path):
    light = {"rho": 4430.0, "E": 114e9, "G_s": 42.5e9}
    system = read(
        tmp_path,
        element(0, 0.05, odr=0.06, idr=0.01),
        element(1, 0.08, 0.06, material=light),
        element(1, 0.06, 0.01),
    )
    cone, cylinder = system.shafts[0].segments
    assert (cone.end_outer_diameter, cone.end_inner_diameter) == (0.06, 0.01)
    assert (cylinder.outer_diameter, cylinder.end_outer_diameter) == (0.06, None)
    (sleeve,) = system.sleeves
    assert (sleeve.begin, sleeve.end, sleeve.stiffness) == (0.1, 0.2, "full")
    assert sleeve.material == gb.Material(114e9, 4430.0, shear_modulus=42.5e9)


def test_rotary_inertia_is_included_with_a_warning(tmp_path: Path):
    with pytest.warns(gb.SceneWarning, match="rotary_inertia is false"):
        system = read(tmp_path, element(0, 0.05, rotary_inertia=False), element(1, 0.05))
    assert system.description == read(tmp_path, element(0, 0.05), element(1, 0.05)).description


def test_errors_name_the_element(tmp_path: Path):
    cases = [
        ([element(0, 0.05), element(2, 0.05)], 'no mesh connects "rotor 1"'),
        ([element(0, 0.05), element(0, 0.08, 0.05, L=0.2)], "e1: must be as long as the other"),
        ([element(0, 0.05), element(0, 0.08, 0.05, odr=0.1)], "e1: a conical layer"),
        ([element(0, 0.05), element(1, 0.05, shear_effects=False)], "e1: shear_effects must be"),
    ]
    for elements, message in cases:
        with pytest.raises(gb.SceneError, match=message):
            read(tmp_path, *elements)
