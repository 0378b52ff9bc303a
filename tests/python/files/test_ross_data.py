"""Rotors of ROSS's own test data, against eigenvalues that ROSS 2.3 gives for these files.

The files are not part of the repository: the environment variable GEARBOW_TEST_DATA names their folder.
"""

import json
import os
from dataclasses import replace
from math import pi, sqrt, tan
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


def test_an_oil_film_is_read_with_the_coefficients_that_ross_saved(tmp_path: Path):
    # ROSS saves its plain journals and tilting pads as tables over the speed, which it calls frequency up to version 2
    speeds = [100.0, 200.0, 400.0]
    film = {f"{letter}{key}": [1e6, 2e6, 3e6] for letter in "kc" for key in ("xx", "yy")}
    film |= {"kxy": [1e5, 2e5, 4e5], "kyx": [-1e5, -2e5, -4e5], "cxy": [0.0] * 3, "cyx": [0.0] * 3}
    plain = {f"ShaftElement_e{i}": element(i, 0.05) for i in range(2)}
    for n in (0, 2):
        saved = {**film, "n": n, "tag": f"b{n}", "frequency": speeds, "scale_factor": 1.0}
        plain[f"BearingElement_b{n}"] = saved
    (tmp_path / "rotor.json").write_text(json.dumps({"ross_version": "2.3.0", **plain}))
    system = gb.RotorSystem.from_ross(tmp_path / "rotor.json")
    for bearing in system.bearings:
        assert bearing.stiffness.speeds == tuple(speeds)
        assert bearing.stiffness.frequencies is None
        assert np.abs(np.array(bearing.stiffness.values)[1]).max() == 2e6
    matrices = system.matrices(200.0)
    assert np.abs(matrices.stiffness - matrices.stiffness.T).max() == pytest.approx(4e5, rel=1e-6)


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


def test_axial_coordinates_are_those_of_axial_bearings(tmp_path: Path):
    elements = [element(n, 0.02) for n in range(2)]
    free = read(tmp_path, *elements)
    assert {kind for _, _, kind in free.dofs} == {"v", "w", "B", "G"}
    twisting = free.replace(motion="coupled")
    assert {kind for _, _, kind in twisting.dofs} == {"v", "w", "B", "G", "twist"}
    stiffness = 1e7
    file = tmp_path / "rotor.json"
    file.write_text(file.read_text().replace('"kxx"', f'"kzz": {stiffness}, "kxx"'))
    held = gb.RotorSystem.from_ross(file)
    assert "u" in {kind for _, _, kind in held.dofs}
    # a bar between two springs: β tan(βL/2) = k/EA, found by bisection between 0 and π/L
    low, high = 0.0, pi / 0.2
    for _ in range(60):
        middle = 0.5 * (low + high)
        above = middle * tan(middle * 0.1) > stiffness / (211e9 * pi * 0.01**2)
        low, high = (low, middle) if above else (middle, high)
    modes = held.modes(0.0)
    found = modes.frequencies_hz[list(modes.whirl).index("axial")]
    # the error of two linear elements
    assert found == pytest.approx(low * sqrt(211e9 / 7810.0) / (2.0 * pi), rel=1e-3)


#: Eigenfrequencies [rad/s] at 400 rad/s by the axial force [N], of a shaft of two elements in ROSS 2.3. Without force, the lowest
#: is 4631 rad/s.
TENSIONED = {
    2e5: [5063.126506, 5063.915245, 11458.06667, 11463.16408, 21576.10718, 21597.14430],
    -1e5: [4289.869371, 4291.528745, 9990.506816, 9995.677435, 18187.79645, 18208.51346],
}


@pytest.mark.parametrize("force", list(TENSIONED))
def test_an_axial_force_has_the_modes_of_ross(tmp_path: Path, force: float):
    system = read(tmp_path, *(element(n, 0.02, axial_force=force) for n in range(2)))
    assert system.shafts[0].axial_force == force
    found = system.modes(400.0).eigenvalues.imag[:6]
    # The same elements: the printed digits.
    np.testing.assert_allclose(found, TENSIONED[force], rtol=1e-9)


def test_the_axial_force_of_a_shaft_is_the_sum_over_its_layers(tmp_path: Path):
    layers = (element(1, 0.02, axial_force=7e3), element(1, 0.03, 0.02, axial_force=3e3))
    system = read(tmp_path, element(0, 0.02, axial_force=1e4), *layers)
    assert system.shafts[0].axial_force == 1e4


def test_damping_of_ross_includes_the_axial_force_with_a_warning(tmp_path: Path):
    elements = [element(n, 0.02, axial_force=1e4, beta=1e-5) for n in range(2)]
    with pytest.warns(gb.SceneWarning, match="beta of ROSS includes the stiffness of the axial"):
        system = read(tmp_path, *elements)
    assert system.rayleigh == (0.0, 1e-5)


def test_rotary_inertia_is_included_with_a_warning(tmp_path: Path):
    with pytest.warns(gb.SceneWarning, match="rotary_inertia is false"):
        system = read(tmp_path, element(0, 0.05, rotary_inertia=False), element(1, 0.05))
    assert system.description == read(tmp_path, element(0, 0.05), element(1, 0.05)).description


def test_errors_name_the_element(tmp_path: Path):
    cases = [
        ([element(0, 0.05), element(2, 0.05)], 'mesh or coupling connects "rotor 1"'),
        ([element(0, 0.05), element(0, 0.08, 0.05, L=0.2)], "e1: must be as long as the other"),
        ([element(0, 0.05), element(0, 0.08, 0.05, odr=0.1)], "e1: a conical layer"),
        ([element(0, 0.05), element(1, 0.05, shear_effects=False)], "e1: shear_effects must be"),
        (
            [element(0, 0.05), element(1, 0.05, axial_force=10.0)],
            r"e1: axial_force must be that of the other elements .* got 10 N\..*geometric_stiffness",
        ),
        ([element(0, 0.05), element(1, 0.05, torque=10.0)], "e1: torque must be 0, got 10.0"),
    ]
    for elements, message in cases:
        with pytest.raises(gb.SceneError, match=message):
            read(tmp_path, *elements)
