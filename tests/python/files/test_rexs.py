"""Gear units of REXS: numbers as listed in the file, what is missing, what is refused, damage."""

from __future__ import annotations

import base64
import contextlib
import copy
import io
import json
import math
import os
import random
import re
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pytest

import gearbow as gb
from gearbow.cli.main import main
from gearbow.exchange.rexs import read_rexs, read_system
from gearbow.exchange.rexs_joints import bearing_of_designation
from gearbow.units.speed import given_unit

FILE = Path(__file__).with_name("gearbox.rexs")

#: Damaged files of `make test`; `make fuzz` reads 50 times as many.
DAMAGED = 200 * int(os.environ.get("GEARBOW_CASES", "1"))
OTHER = {"other": 1e8}


def model() -> dict[str, Any]:
    """Give the file in the form of a JSON file."""
    root = ET.parse(FILE).getroot()

    def value(attribute: ET.Element) -> dict[str, Any]:
        if (array := attribute.find("array")) is not None:
            return {"floating_point_array": [float(cell.text or "") for cell in array]}
        text = attribute.text or ""
        if text in ("true", "false"):
            return {"boolean": text == "true"}
        if re.fullmatch(r"-?\d+", text):
            return {"integer": int(text)}
        try:
            return {"floating_point": float(text)}
        except ValueError:
            return {"enum": text}

    def components(parent: ET.Element) -> list[dict[str, Any]]:
        return [
            {**each.attrib, "id": int(each.attrib["id"])}
            | {"attributes": [{**one.attrib, **value(one)} for one in each]}
            for each in parent.iterfind("component")
        ]

    cases = [
        {"id": int(case.attrib["id"]), "components": components(case)}
        for case in root.iterfind("load_spectrum/load_case")
    ]
    relations = [
        {"id": int(each.attrib["id"]), "type": each.attrib["type"]}
        | {"refs": [{**ref.attrib, "id": int(ref.attrib["id"])} for ref in each]}
        for each in root.iterfind("relations/relation")
    ]
    return {
        **root.attrib,
        "relations": relations,
        "components": components(root.find("components")),  # type: ignore[arg-type]
        "load_spectrum": {"id": 1, "load_cases": cases},
    }


def component(plain: dict[str, Any], name: str) -> dict[str, Any]:
    """Find a component by its name or number."""
    return next(each for each in plain["components"] if name in (each.get("name"), str(each["id"])))


def attribute(plain: dict[str, Any], name: str, key: str) -> dict[str, Any]:
    """Find or add an attribute of a component."""
    attributes = component(plain, name)["attributes"]
    for each in attributes:
        if each["id"] == key:
            return each
    attributes.append({"id": key, "unit": "none"})
    return attributes[-1]


def put(plain: dict[str, Any], name: str, key: str, value: Any, unit: str | None = None) -> None:
    """Set the value of an attribute."""
    found = attribute(plain, name, key)
    for kind in [kind for kind in found if kind not in ("id", "unit")]:
        del found[kind]
    found["floating_point"] = value
    if unit is not None:
        found["unit"] = unit


def remove(plain: dict[str, Any], name: str, key: str) -> None:
    """Remove an attribute."""
    part = component(plain, name)
    part["attributes"] = [each for each in part["attributes"] if each["id"] != key]


@pytest.fixture
def write(tmp_path: Path) -> Callable[[dict[str, Any]], Path]:
    def written(plain: dict[str, Any]) -> Path:
        path = tmp_path / "gearbox.rexsj"
        path.write_text(json.dumps({"model": plain}))
        return path

    return written


def description(path: Path, **given: Any) -> dict[str, Any]:
    found, contents = read_rexs(path, **{"load_case": 2, "bearings": OTHER, **given})
    assert contents.missing == ()
    return found


def test_the_numbers_are_those_of_the_file():
    system = gb.RotorSystem.read_rexs(FILE, load_case=2, bearings=OTHER)
    assert system.reference == "motor"
    assert [shaft.name for shaft in system.shafts] == ["motor", "input", "middle", "output"]
    assert [shaft.material.youngs_modulus for shaft in system.shafts] == 4 * [2.1e11]
    assert {shaft.material.density for shaft in system.shafts} == {7850.0}
    assert system.shafts[3].segments == (
        gb.Segment(0.04, 0.045, 0.02),
        gb.Segment(0.08, 0.05, 0.02),
        gb.Segment(0.04, 0.045, 0.02),
    )
    pinion, wheel, *_ = system.gears
    assert (pinion.teeth, pinion.module, pinion.face_width) == (19, 0.002, 0.032)
    assert (pinion.tip_radius, wheel.tip_radius) == (0.0222, None)
    assert math.degrees(pinion.helix_angle) == pytest.approx(15.0, rel=1e-15)
    assert math.degrees(wheel.helix_angle) == pytest.approx(-15.0, rel=1e-15)
    assert [gear.profile_shift for gear in system.gears] == [0.3, 0.1, 0.25, 0.0]
    assert [gear.position for gear in system.gears] == [0.08, 0.05, 0.12, 0.06]
    assert [mesh.centre_distance for mesh in system.meshes] == [0.0847, 0.1036]
    # 90° and 120° from w about −u are 0° and −30° from y towards z; six decimals of a position.
    angles = np.degrees([mesh.centre_line_angle for mesh in system.meshes])
    np.testing.assert_allclose(angles, [0.0, -30.0], atol=1e-6)
    rolling = next(each for each in system.bearings if isinstance(each, gb.RollingBearing))
    assert (rolling.shaft, rolling.position, rolling.elements) == ("input", 0.015, 9)
    assert (rolling.element_diameter, rolling.pitch_diameter) == (0.007938, 0.0385)
    assert (rolling.clearance, rolling.axial_stiffness) == (1e-5, 1e8)
    (coupling,) = system.couplings
    assert (coupling.a, coupling.b) == (("motor", 0.2), ("input", 0.0))
    assert (coupling.lateral_stiffness, coupling.axial_stiffness) == (2e6, 1e6)
    assert (coupling.tilting_stiffness, coupling.torsional_stiffness) == (1e3, 2e4)
    (rotor,) = system.disks
    assert (rotor.mass, rotor.polar_inertia, rotor.diametral_inertia) == (12.5, 0.04, 0.06)
    assert system.torques == (
        gb.Torque(("motor", 0.1), 30.0),
        gb.Torque.balance(("output", 0.16)),
    )
    (force,) = system.forces
    assert (force.at, force.value) == (("output", 0.16), 200.0)
    np.testing.assert_allclose(system.gravity, [0.0, -9.81], rtol=1e-15)


def test_speeds_and_torques_of_every_shaft_are_in_balance():
    system = gb.RotorSystem.read_rexs(FILE, load_case=1, bearings=OTHER)
    ratios = [1.0, 1.0, -19 / 62, 19 / 62 * 17 / 50]
    np.testing.assert_allclose(system.speed_ratios, ratios, rtol=1e-15)
    static = system.static(gb.rpm(1500))
    by_name = {gear.name: gear for gear in system.gears}
    torque = 50.0
    for mesh in system.meshes:
        gears = [by_name[name] for name in (mesh.driver, mesh.driven)]
        # The force is normal to the teeth: F r_b cos β_b is the torque, tan β_b = tan β cos α_t.
        moments = []
        for gear in gears:
            beta, alpha = gear.helix_angle, gear.pressure_angle
            transverse = math.atan(math.tan(alpha) / math.cos(beta))
            base = 0.5 * gear.teeth * gear.module / math.cos(beta) * math.cos(transverse)
            slope = math.atan(math.tan(beta) * math.cos(transverse))
            force = static.mesh((mesh.driver, mesh.driven)).force
            moments.append(force * base * math.cos(slope))
        assert moments[0] == pytest.approx(torque, rel=1e-6)  # of the iteration
        torque = moments[1]


def test_load_cases_bearings_missing_values_and_notes_are_listed(write):
    contents = gb.rexs_contents(FILE)
    assert (contents.version, contents.application) == ("1.4", "gearbow example 1")
    assert [case.speed for case in contents.load_cases] == [gb.rpm(1500), gb.rpm(3000)]
    assert {given_unit(case.speed) for case in contents.load_cases} == {"rpm"}
    assert [case.torques for case in contents.load_cases] == [
        {"motor torque": 50.0},
        {"motor torque": 30.0},
    ]
    assert contents.missing == ()
    assert contents.bearings == {
        "motor left": "Bearing, 1e+08 N/m",
        "motor right": "Bearing, 1e+08 N/m",
        "6205": "RollingBearing, 9 elements of 7.94 mm",
        "NU205": "RollingBearing, cylindrical roller, 12 elements of 6.75 mm, estimated within 25%",
        "6206 left": "Bearing, 1.5e+08 N/m",
        "6206 right": "Bearing, 1.5e+08 N/m",
        "6209 left": "RollingBearing, deep groove, 10 elements of 12 mm, estimated within 15%",
        "6209 right": "RollingBearing, deep groove, 10 elements of 12 mm, estimated within 15%",
    }
    assert 'bearing "6206 left": Bearing, 1.5e+08 N/m' in contents.table().splitlines()
    contents = gb.rexs_contents(write(unknown_bearings()))
    assert {each.name: each.keys for each in contents.missing} == {
        "left": ("stiffness", "axial_stiffness"),
        "right": ("stiffness",),
    }
    assert contents.table().splitlines()[3] == (
        'to add: stiffness of "right" (radial spherical roller bearing, 45x85x19 mm, on "output" '
        "at 140 mm)"
    )
    assert contents.bearings["left"] == "needs values"
    assert "to add" in contents._repr_html_()


def unknown_bearings() -> dict[str, Any]:
    """Give the gear unit with bearings that gearbow does not know on its last shaft."""
    plain = model()
    for side in ("left", "right"):
        put(plain, f"6209 {side}", "bearing_type", "radial_spherical_roller_bearing")
        component(plain, f"6209 {side}")["name"] = side
    return plain


@pytest.mark.parametrize(
    ("profile", "kind"),
    [
        ({"profile": "lemon"}, gb.JournalBearing),
        ({"pads": [gb.Pad(0.2, 2.5, preload=0.3), gb.Pad(3.4, 2.5)]}, gb.JournalBearing),
        ({"pad_count": 5, "pad_inertia": 1e-5}, gb.TiltingPadBearing),
    ],
)
def test_an_unknown_bearing_may_have_an_oil_film(write, profile: dict[str, Any], kind: type):
    size = {"diameter": 0.06, "length": 0.03, "clearance": 1e-4, "viscosity": 0.02}
    film = {**size, "axial_stiffness": 1e8, **profile}
    with pytest.warns(gb.SceneWarning):
        system = gb.RotorSystem.read_rexs(
            write(unknown_bearings()), bearings={"left": film, "right": film}, load_case=1
        )
    films = [each for each in system.bearings if isinstance(each, kind)]
    assert len(films) == 2
    for each in films:
        assert each == kind(each.shaft, each.position, **film)


def test_a_missing_value_or_load_case_is_an_error_that_names_it(write):
    with pytest.warns(gb.SceneWarning, match="load case 1: 1500 rpm, .* acts; load_case chooses"):
        system = gb.RotorSystem.read_rexs(FILE, bearings=OTHER)
    assert system.torques[0].value == 50.0
    path = write(unknown_bearings())
    with pytest.raises(gb.SceneError, match=r'bearings={"left": 1e8}: stiffness, axial_stiff'):
        gb.RotorSystem.read_rexs(path, load_case=1)
    with pytest.raises(gb.SceneError, match=r"load_case: must be 1 to 2 for .*, got 3"):
        gb.RotorSystem.read_rexs(FILE, load_case=3)


def test_values_are_given_by_name():
    given = {
        "6205": 3e8,
        "NU205": {"stiffness": (1e8, 2e8), "damping": 100.0},
        "6206 right": None,
        "6209 left": {"elements": 9, "element_diameter": 0.01, "pitch_diameter": 0.065}
        | {"clearance": 1e-5, "axial_stiffness": 1e7},
        "other": 5e7,
    }
    system = gb.RotorSystem.read_rexs(FILE, load_case=1, bearings=given)
    found = {(each.shaft, each.position): each for each in system.bearings}
    assert found["input", 0.015].stiffness == found["input", 0.015].axial_stiffness == 3e8
    assert found["input", 0.145].stiffness == (1e8, 2e8)
    assert ("middle", 0.165) not in found
    assert found["middle", 0.015].stiffness == 1.5e8  # "other" replaces nothing
    assert isinstance(found["output", 0.02], gb.RollingBearing)
    assert (found["output", 0.14].stiffness, found["output", 0.14].axial_stiffness) == (5e7, 0.0)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"NU206": 1e8}, r'bearings: .*gearbox\.rexs has no "NU206".*did you mean "NU205"\?'),
        ({"NU205": "stiff"}, r"bearings\[\"NU205\"\]: must be a number, got 'stiff'"),
        ({"NU205": {"shaft": "a"}}, r"bearings\[\"NU205\"\]: the file has its shaft"),
        ({"NU205": {"stifness": 1e8}, **OTHER}, r"gearbox\.rexs: bearings\[3\].*stifness"),
        ({"NU205": -1.0, **OTHER}, r"gearbox\.rexs: bearings\[3\]"),
        ([1e8], r"bearings: must be a mapping of names to values, got \[100000000\.0\]"),
    ],
)
def test_a_wrong_value_is_an_error(given, message: str):
    with pytest.raises(gb.SceneError, match=message):
        gb.RotorSystem.read_rexs(FILE, load_case=1, bearings=given)


def test_the_three_formats_have_the_same_content(tmp_path: Path, write):
    expected = description(FILE)
    assert description(write(model())) == expected
    data = FILE.read_bytes()
    for content, name in ((data, "model.rexs"), (write(model()).read_bytes(), "model.rexsj")):
        for path in (tmp_path / "gearbox.rexsz", tmp_path / "gearbox.rexs.zip"):
            with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
                archive.writestr(name, content)
                archive.writestr("readme.txt", b"")
                archive.writestr(f"__MACOSX/._{name}", b"metadata of macOS")
            assert description(path) == expected
    path = tmp_path / "gearbox.REXS"
    text = data.decode().replace("<model ", '<model xmlns="https://www.rexs.info" ')
    path.write_bytes(text.replace('encoding="UTF-8"', 'encoding="UTF-16"').encode("utf-16"))
    assert description(path) == expected
    plain = model()
    coded = base64.b64encode(struct.pack("<3d", 30.0, 84.7, 0.0)).decode()
    found = attribute(plain, "middle", "support_vector")
    del found["floating_point_array"]
    found["floating_point_array_coded"] = {"code": "float64", "value": coded}
    assert description(write(plain)) == expected


#: Names and units of other versions.
NAMES = {
    "1.0": {"operating_radial_bearing_clearance": "radial_backlash"},
    "2.0.0": {"reference_diameter": "reference_diameter_rolling_bearing"},
}
UNITS = {"1.0": {"deg": "°"}, "2.0.0": {"N / mm^2": "MPa"}}


@pytest.mark.parametrize("version", NAMES)
def test_other_versions_have_other_names_and_units(write, version: str):
    plain = model() | {"version": version}
    for part in plain["components"]:
        for each in part["attributes"]:
            each["id"] = NAMES[version].get(each["id"], each["id"])
            each["unit"] = UNITS[version].get(each["unit"], each["unit"])
    assert description(write(plain)) == description(FILE)


def modes(found: dict[str, Any]) -> np.ndarray:
    for shaft in found["shafts"]:  # a choice of the elements takes longer than the test
        for segment in shaft["segments"]:
            segment["elements"] = 1
    return gb.RotorSystem.from_dict(found).modes(100.0, count=20).frequencies_hz


@pytest.mark.filterwarnings("ignore::gearbow.SceneWarning")
def test_a_shaft_that_points_the_other_way_is_the_same_shaft(write):
    plain = model()
    # The middle shaft ends at 210 mm; its sections are made different from both sides.
    put(plain, "66", "outer_diameter_begin", 28, "mm")
    put(plain, "66", "outer_diameter_end", 28, "mm")
    expected = description(write(plain))
    put(plain, "middle", "support_vector", [210, 84.7, 0.0])
    put(plain, "middle", "u_axis_vector", [-1, 0, 0])
    for section in ("64", "65", "66"):
        begin = attribute(plain, section, "u_coordinate_on_shaft")["integer"]
        length = attribute(plain, section, "length")["integer"]
        put(plain, section, "u_coordinate_on_shaft", 180 - begin - length)
    for part, key in (("wheel 1", ""), ("pinion 2", ""), ("6206 left", "_inner_side")):
        name = f"u_coordinate_on_shaft{key}"
        put(plain, part, name, 180 - attribute(plain, part, name)["integer"])
    put(plain, "6206 right", "u_coordinate_on_shaft_inner_side", 15)
    found = description(write(plain))
    assert [len(shaft["segments"]) for shaft in found["shafts"]] == [1, 3, 3, 3]
    for shaft, other in zip(found["shafts"], expected["shafts"], strict=True):
        for segment, same in zip(shaft["segments"], other["segments"], strict=True):
            assert segment == pytest.approx(same)
    # Positions differ by rounding.
    np.testing.assert_allclose(modes(found), modes(expected), rtol=1e-8, atol=1e-3)


@pytest.mark.filterwarnings("ignore::gearbow.SceneWarning")
def test_a_gear_unit_that_stands_elsewhere_is_the_same_gear_unit(write):
    expected = description(FILE)
    plain = model()
    component(plain, "gearbox")["id"] = 1
    turn = math.radians(30.0)
    put(plain, "gearbox", "support_vector", [100.0, -50.0, 20.0], "mm")
    put(plain, "gearbox", "u_axis_vector", [math.cos(turn), math.sin(turn), 0.0])
    put(plain, "gearbox", "w_axis_vector", [0.0, 0.0, 1.0])
    found = description(write(plain))
    np.testing.assert_allclose(modes(found), modes(expected), rtol=1e-8, atol=1e-3)


def test_the_coordinate_of_a_gear_may_be_its_begin(write):
    plain = model()
    put(plain, "pinion 1", "u_coordinate_on_shaft", 64)  # face width 32 mm
    assert description(write(plain)) == description(FILE)
    _, contents = read_rexs(write(plain), 1, OTHER)
    assert not any("support_vector" in note for note in contents.notes)
    put(plain, "pinion 1", "u_coordinate_on_shaft", 70)
    found, contents = read_rexs(write(plain), 1, OTHER)
    assert found["gears"][0]["position"] == pytest.approx(0.08, rel=1e-15)
    assert any("support_vector is at 80 mm on the shaft" in note for note in contents.notes)


def test_the_stage_places_shafts_without_vectors(write):
    plain = model()
    for part in plain["components"]:
        part["attributes"] = [
            each for each in part["attributes"] if not each["id"].endswith(("vector", "position"))
        ]
    put(plain, "stage 1", "rotating_angle_around_neg_u_axis", 90, "deg")
    found = description(write(plain))
    angles = np.degrees([mesh["centre_line_angle"] for mesh in found["meshes"]])
    np.testing.assert_allclose(angles, [0.0, -30.0], atol=1e-12)
    assert [gear["position"] for gear in found["gears"]] == [0.08, 0.05, 0.12, 0.06]


def test_a_load_may_have_a_power(write):
    plain = model()
    case = plain["load_spectrum"]["load_cases"][0]["components"][1]["attributes"]
    case[:] = [{"id": "power", "unit": "kW", "floating_point": 7.853981633974483}]
    found = description(write(plain), load_case=1)
    assert found["torques"][0]["value"] == pytest.approx(50.0, rel=1e-14)


@pytest.mark.parametrize("sense", [1, -1])
def test_a_power_has_the_torque_in_the_sense_of_the_speed(write, sense):
    plain = model()
    power = {"id": "power", "unit": "kW", "floating_point": 7.853981633974483}
    for component in plain["load_spectrum"]["load_cases"][0]["components"]:
        for attribute in component["attributes"]:
            if attribute["id"] == "rotational_speed":
                kind = next(key for key in attribute if key in ("integer", "floating_point"))
                attribute[kind] *= sense
    plain["load_spectrum"]["load_cases"][0]["components"][1]["attributes"][:] = [power]
    # a driving power accelerates: the torque has the sign of the speed
    value = description(write(plain), load_case=1)["torques"][0]["value"]
    assert value == pytest.approx(50.0 * sense, rel=1e-14)


def joined(plain: dict[str, Any], kind: str, **refs: int) -> None:
    listed = [{"id": number, "role": role} for role, number in refs.items()]
    plain["relations"].append({"id": 999, "type": kind, "refs": listed})


def between_shafts(plain: dict[str, Any]) -> None:
    for relation in plain["relations"]:
        for ref in relation["refs"]:
            if (
                relation["type"] == "side"
                and ref["role"] == "outer_part"
                and 33 in (each["id"] for each in relation["refs"])
            ):
                ref["id"] = 13


def test_a_bearing_between_shafts_stands_on_the_other_shaft(write):
    plain = model()
    between_shafts(plain)
    remove(plain, "NU205", "support_vector")
    put(plain, "NU205", "u_coordinate_on_shaft_outer_side", 35, "mm")
    place = {"shaft": "input", "position": 0.145, "support": ["output", 0.035]}
    for given, value in ((OTHER, 1e8), ({**OTHER, "NU205": 4e8}, 4e8)):
        found = description(write(plain), bearings=given)
        assert found["bearings"][3] == {**place, "stiffness": value}
    found = description(write(plain), bearings=None)["bearings"][3]
    rolling = {"kind": "cylindrical_roller", "boundary": [0.025, 0.052, 0.015]}
    assert {key: value for key, value in found.items() if key != "contact"} == place | rolling
    assert len(description(write(plain), bearings={**OTHER, "NU205": None})["bearings"]) == 7


def test_the_outer_ring_may_turn(write):
    plain = model()
    for relation in plain["relations"]:
        if {"id": 33, "role": "assembly", "hint": relation["refs"][0].get("hint")} in relation[
            "refs"
        ]:
            for ref in relation["refs"]:
                ref["role"] = {"inner_part": "outer_part", "outer_part": "inner_part"}.get(
                    ref["role"], ref["role"]
                )
    put(plain, "NU205", "u_coordinate_on_shaft_outer_side", 145, "mm")
    assert description(write(plain))["bearings"] == description(FILE)["bearings"]


def test_values_of_couplings_are_given_by_name(write):
    plain = model()
    remove(plain, "coupling", "rotational_stiffness")
    path = write(plain)
    for given in (
        {"coupling": 3e4},
        {"other": 3e4},
        {"coupl": 3e4},
        {"coupling": {"torsional_stiffness": 3e4}},
    ):
        (found,) = description(path, couplings=given)["couplings"]
        assert (found["torsional_stiffness"], found["lateral_stiffness"]) == (3e4, 2e6)
    assert "couplings" not in description(path, couplings={"coupling": None})
    put(plain, "coupling", "is_engaged", ["false"])
    assert "couplings" not in description(write(plain))
    (found,) = description(FILE, couplings={"other": 3e4})["couplings"]
    assert found["torsional_stiffness"] == 2e4  # "other" replaces nothing


def test_a_rigid_coupling_has_a_large_stiffness(write):
    plain = model()
    for key in ("rotational_stiffness", "radial_stiffness", "bending_stiffness", "axial_stiffness"):
        put(plain, "coupling", key, 1e20)
    (found,) = description(write(plain))["couplings"]
    assert (found["lateral_stiffness"], found["axial_stiffness"]) == (1e12, 1e12)
    assert (found["tilting_stiffness"], found["torsional_stiffness"]) == (1e10, 1e10)
    # One rotor in one piece, and in two halves that a rigid coupling joins.
    halves = [gb.Shaft(name, length=0.5, outer_diameter=0.05) for name in ("a", "b")]
    joined = {key: found[key] for key in found if key not in ("a", "b")}
    bearings = [gb.Bearing("a", 0.05, stiffness=1e8), gb.Bearing("b", 0.45, stiffness=1e8)]
    two = gb.RotorSystem(
        halves, bearings=bearings, couplings=[gb.Coupling(("a", 0.5), ("b", 0.0), **joined)]
    )
    bearings = [gb.Bearing("a", at, stiffness=1e8) for at in (0.05, 0.95)]
    one = gb.RotorSystem([gb.Shaft("a", length=1.0, outer_diameter=0.05)], bearings=bearings)
    bending = [system.modes(count=7).frequencies_hz for system in (two, one)]
    # The first mode of the halves is their rotation. Both systems choose their elements, with an
    # error of about 1e-5.
    np.testing.assert_allclose(bending[0][1:5], bending[1][:4], rtol=3e-5)


def test_a_cone_is_a_cone_seen_from_both_sides(write):
    plain = model()
    put(plain, "66", "outer_diameter_begin", 28, "mm")
    put(plain, "66", "outer_diameter_end", 24, "mm")
    put(plain, "66", "inner_diameter_end", 10, "mm")
    cone = description(write(plain))["shafts"][2]["segments"][2]
    length = attribute(plain, "66", "length")["integer"] / 1000
    sizes = {"outer_diameter": 0.028, "end_outer_diameter": 0.024, "end_inner_diameter": 0.01}
    assert cone == {"length": length, **sizes}
    put(plain, "middle", "u_axis_vector", [-1, 0, 0])
    turned = read_rexs(write(plain), 2, OTHER)[0]["shafts"][2]["segments"][0]
    sizes = {"outer_diameter": 0.024, "end_outer_diameter": 0.028, "inner_diameter": 0.01}
    assert turned == {"length": length, **sizes, "end_inner_diameter": 0.0}


def test_sections_have_materials_of_their_own(write):
    plain = model()
    a_second_material(plain)
    shafts = description(write(plain))["shafts"]
    found = [segment.get("material", shafts[1]["material"]) for segment in shafts[1]["segments"]]
    moduli = [material["youngs_modulus"] for material in found]
    assert sorted(moduli) == [1.1e11, *(len(moduli) - 1) * [2.1e11]]
    assert moduli.index(1.1e11) == 1


@pytest.mark.parametrize(
    ("name", "kind", "boundary", "angle"),
    [
        ("6305-2Z", "deep_groove", [25.0, 62.0, 17.0], None),
        ("Lager 7208-B [3]", "angular_contact", [40.0, 80.0, 18.0], None),
        ("NUP204-E-XL-TVP2", "cylindrical_roller", [20.0, 47.0, 14.0], None),
        ("NJ 2", None, None, None),
        ("NU1010", "cylindrical_roller", [50.0, 80.0, 16.0], None),
        (
            "not a catalogue bearing: 33016 (Rolling bearing [35])",
            "tapered_roller",
            [80.0, 125.0, 36.0],
            10.5,
        ),
        ("32010-X", "tapered_roller", [50.0, 80.0, 20.0], 15.75),
        ("32031", None, None, None),
        ("K 50x58x25", "needle_cage", [50.0, 58.0, 25.0], None),
        ("22216", None, None, None),
        ("Bearing 62055", None, None, None),
    ],
)
def test_a_designation_has_prefixes_and_suffixes(name: str, kind, boundary, angle):
    found = bearing_of_designation(["", name])
    if kind is None:
        assert found == {}
        return
    estimate = gb.RollingBearing("", 0.0, **found).estimate
    assert estimate.kind == kind
    sizes = [1e3 * size for size in (estimate.bore, estimate.outer, estimate.width)]
    assert sizes == pytest.approx(boundary, rel=1e-12)
    if angle is not None:
        given = found.get("contact_angle", estimate.contact_angle)
        assert math.degrees(given) == pytest.approx(angle, rel=1e-12)


def test_bearings_of_the_catalogue_take_options_and_carry_thrust(write):
    plain = model()
    put(plain, "6209 left", "axial_force_absorption", "negative")
    put(plain, "6209 left", "bearing_type", "radial_tapered_roller_bearing")
    options = {"6209": {"clearance": 5e-6}, "other": {"damping": 100.0}}
    with pytest.raises(
        gb.SceneError, match=r'has no "6209".* it is a part of 6209 left, 6209 right'
    ):
        description(write(plain), bearings=options)
    options["6209 l"] = options.pop("6209")
    found = {
        each["position"]: each for each in description(write(plain), bearings=options)["bearings"]
    }
    left, right = found[0.02], found[0.14]
    assert (left["clearance"], left["damping"], right["damping"]) == (5e-6, 100.0, 100.0)
    assert (left["degrees_of_freedom"], left["kind"]) == (5, "tapered_roller")
    assert math.degrees(left["contact_angle"]) == pytest.approx(-15.0, rel=1e-12)
    for bearings in (None, "catalogue", {"other": "catalogue"}):
        found = description(write(plain), bearings=bearings)
        assert found == description(write(plain), bearings={})


def a_second_material(plain: dict[str, Any]) -> None:
    steel = copy.deepcopy(component(plain, "steel")) | {"id": 4, "name": "bronze"}
    plain["components"].append(steel)
    put(plain, "bronze", "elastic_modulus", 1.1e5)
    joined(plain, "reference", origin=62, referenced=4)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda p: component(p, "wheel 2").update(type="worm_wheel", name="worm wheel"),
            'worm_wheel "worm wheel": gearbow cannot represent it: gearbow has spur and helical gears',
        ),
        (
            lambda p: put(p, "62", "length", 79),
            "shaft_section 63 begins at 120 mm, but shaft_section 62 before it ends at 119 mm",
        ),
        (
            lambda p: put(p, "output", "u_axis_vector", [1, 0.01, 0]),
            'shaft "output": must be parallel to the other shafts',
        ),
        (
            lambda p: put(p, "output", "w_axis_vector", [1, 0, 1]),
            'shaft "output": u_axis_vector and w_axis_vector must be at right angles',
        ),
        (
            lambda p: put(p, "output", "reference_component_for_position", 77),
            "reference_component_for_position: there is no component 77",
        ),
        (
            lambda p: [
                put(p, "output", "reference_component_for_position", 12),
                put(p, "middle", "reference_component_for_position", 13),
            ],
            "reference_component_for_position: refers back to itself",
        ),
        (
            lambda p: put(p, "243", "addendum_modification_coefficient", 0.2),
            'cylindrical_gear "wheel 1": addendum_modification_coefficient of both flanks',
        ),
        (
            lambda p: remove(p, "wheel 1", "normal_module"),
            'cylindrical_gear "wheel 1": needs the attribute normal_module',
        ),
        (
            lambda p: put(p, "wheel 1", "number_of_teeth", 62.5),
            "number_of_teeth: must be a whole number of at most 1e9, got 62.5",
        ),
        (
            lambda p: put(p, "wheel 1", "number_of_teeth", 1e20),
            "number_of_teeth: must be a whole number of at most 1e9, got 1e+20",
        ),
        (
            lambda p: put(p, "wheel 1", "face_width", 3, "deg"),
            'cylindrical_gear "wheel 1": face_width: must have a unit that converts to m',
        ),
        (
            lambda p: put(p, "wheel 1", "face_width", "wide"),
            'cylindrical_gear "wheel 1": face_width: must be a number',
        ),
        (
            lambda p: put(p, "wheel 1", "face_width", -3),
            "gears[1].face_width",
        ),
        (
            lambda p: p["components"].append({"id": 98, "type": "side_plate", "name": "plate"}),
            "components of these types are left out: side_plate",
        ),
        (
            lambda p: p["relations"].pop(0),
            'no material in the file for "motor"',
        ),
        (lambda p: p.update(version="3.0"), "version: must be 1.0 to 2.0, got '3.0'"),
        (lambda p: p.update(components=[]), "has no components"),
        (
            lambda p: p["components"].append({"id": 1, "type": "shaft"}),
            "two components have the id 1",
        ),
        (
            lambda p: joined(p, "side", assembly=1000),
            "relation 999: there is no component 1000",
        ),
        (
            lambda p: p["components"].append({"id": 99, "type": "slide_bearing", "name": "b"}),
            'slide_bearing "b": no relation of the type side says what it joins',
        ),
        (
            lambda p: remove(p, "coupling", "rotational_stiffness"),
            'torsional_stiffness of "coupling" (coupling, on "motor" at 200 mm)',
        ),
    ],
)
@pytest.mark.filterwarnings("error::gearbow.SceneWarning")
def test_what_cannot_be_represented_is_an_error_that_names_it(write, change, message: str):
    plain = model()
    change(plain)
    path = write(plain)
    with pytest.raises((gb.SceneError, gb.SceneWarning)) as caught:
        gb.RotorSystem.read_rexs(path, load_case=1, bearings=OTHER)
    assert str(caught.value).startswith(f"{path}: ")
    assert message in str(caught.value)


# --- files that are damaged or hostile ------------------------------------------------------------

ENTITIES = b"""<?xml version="1.0"?>
<!DOCTYPE model [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">]>
<model version="1.4">&b;</model>"""


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.rexs", b"", "is not a REXS file: no element found"),
        ("a.rexs", ENTITIES, "is not a REXS file: it has a document type (<!DOCTYPE)"),
        ("a.rexs", b"<gears/>", "is not a REXS file: it begins with <gears>, not with <model>"),
        ("a.rexs", b"<model version='1.4'/>", "has no components"),
        ("a.rexs", 100_000 * b"<a>", "is not a REXS file: "),
        ("a.rexsj", b"{", "is not a REXS file: "),
        ("a.rexsj", b"[]", "is not a REXS file: it has no model"),
        ("a.rexsj", b'{"model": ' + 200_000 * b"[", "is nested too deeply"),
        ("a.rexsj", b"\xe9", "is not a REXS file: "),
        ("a.rexsz", b"PK", "is not a zip archive that can be read"),
    ],
)
def test_another_file_is_not_a_gear_unit(tmp_path, name: str, content: bytes, message: str):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(gb.SceneError) as caught:
        gb.rexs_contents(path)
    assert str(caught.value).startswith(f"{path}: {message}")


def test_the_ending_is_the_format(tmp_path: Path):
    with pytest.raises(gb.SceneError, match=r"must end with \.rexs, \.rexsj, \.rexsz or"):
        gb.rexs_contents(tmp_path / "gearbox.xml")
    with pytest.raises(FileNotFoundError):
        gb.rexs_contents(tmp_path / "gearbox.rexs")


def test_an_archive_with_too_much_is_refused(tmp_path: Path):
    path = tmp_path / "a.rexsz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.rexs", bytes(100_000_001))
    assert path.stat().st_size < 200_000
    with pytest.raises(gb.SceneError, match="has more than 100000000 bytes"):
        gb.rexs_contents(path)
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        archive.writestr("a.rexs", b"")
        archive.writestr("b.rexs", b"")
    path.write_bytes(buffer.getvalue())
    with pytest.raises(gb.SceneError, match="must have one file with the ending"):
        gb.rexs_contents(path)


WORDS = (
    *(b"", b"0", b"-1", b"1e400", b"NaN", b"1e300", b"1e-300", b"99999999999999999999", b"10"),
    *(b"13", b"true", b"mm", b"rad", b"shaft", b"stage", b"ring_gear", b"\xff", b"&x;", b"<c>"),
)
#: A value or the text of an XML attribute.
VALUE = re.compile(rb'>([^<>\s]+)<|"([^"]*)"')


def damaged(data: bytes, dice: random.Random) -> bytes:
    """Change bytes, values or lines of a file."""
    for _ in range(dice.choice((1, 1, 2, 5))):
        kind = dice.randrange(8)
        place = dice.randrange(len(data) + 1)
        if kind == 0:
            data = data[:place] + bytes([dice.randrange(256)]) + data[place + 1 :]
        elif kind == 1:
            data = data[:place] + data[place + dice.choice((1, 3, 30, 3000)) :]
        elif kind == 2:
            begin = dice.randrange(len(data) + 1)
            data = data[:place] + data[begin : begin + dice.choice((5, 50, 500))] + data[place:]
        elif kind == 3:
            lines = data.splitlines(keepends=True) or [b""]
            del lines[dice.randrange(len(lines))]
            data = b"".join(lines)
        elif found := list(VALUE.finditer(data)):
            match = dice.choice(found)
            begin, end = match.span(1 if match[1] is not None else 2)
            data = data[:begin] + dice.choice(WORDS) + data[end:]
        if len(data) < 2:
            break
    return data


@pytest.mark.implausible
def test_every_damaged_file_gives_a_system_or_an_error(tmp_path: Path, write):
    # `make fuzz` reads new files in each call.
    dice = random.Random() if DAMAGED > 200 else random.Random(1)
    sources = {"a.rexs": FILE.read_bytes(), "a.rexsj": write(model()).read_bytes()}
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.rexs", sources["a.rexs"])
    sources["a.rexsz"] = buffer.getvalue()
    read = 0
    for _ in range(DAMAGED):
        name = dice.choice(("a.rexs", "a.rexs", "a.rexs", "a.rexsj", "a.rexsz"))
        path = tmp_path / name
        path.write_bytes(damaged(sources[name], dice))
        error = ""
        try:
            found, _ = read_system(path, dice.choice((1, 2)), OTHER, None)
        except gb.SceneError as caught:
            error = str(caught)
        if error:
            assert error.startswith((f"{path}: ", "load_case: ", "bearings: "))
            continue
        read += 1
        for shaft in found["shafts"]:
            for segment in shaft["segments"]:
                segment["elements"] = 1  # a choice of the elements takes longer than the test
        with contextlib.suppress(gb.GearbowError):
            gb.RotorSystem.from_dict(found)
    assert read > 0.02 * DAMAGED  # the test reaches the readers of values


# --- the command ----------------------------------------------------------------------------------


def printed(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    with pytest.raises(SystemExit) as ended:
        main(["import", *arguments])
    output = capsys.readouterr()
    assert ended.value.code == 0, output.err
    return output.out


@pytest.mark.filterwarnings("ignore:.*are estimates:gearbow.SceneWarning")
def test_the_command_prints_a_scene(capsys, tmp_path: Path):
    options = ["--load-case", "2", "--bearing", "other=1e8", "--bearing", "NU205=200 N/um"]
    scene = tmp_path / "train.toml"
    scene.write_text(printed(capsys, str(FILE), *options))
    written = tmp_path / "written.toml"
    assert "next: gearbow check" in printed(capsys, str(FILE), *options, "--out", str(written))
    assert written.read_bytes() == scene.read_bytes().removesuffix(b"\n")
    assert scene.read_text().startswith(
        "# From gearbox.rexs, REXS 1.4 of gearbow example 1\n# Load case 2: 314.159"
    )
    expected = gb.RotorSystem.read_rexs(FILE, load_case=2, bearings={**OTHER, "NU205": 2e8})
    assert gb.RotorSystem.load(scene).description == expected.description
    options = ["--load-case", "1", "--bearing", "NU=clearance:5 um, elements:12, damping:100"]
    of_command = json.loads(printed(capsys, str(FILE), *options, "--json"))["scene"]["bearings"][3]
    assert (of_command["clearance"], of_command["elements"]) == (5e-6, 12)
    assert (of_command["damping"], of_command["kind"]) == (100.0, "cylindrical_roller")
    options = ["--load-case", "2", "--bearing", "other=1e8", "--bearing", "NU205=200 N/um"]
    without = printed(capsys, str(FILE), *options, "--bearing", "6206 right=none")
    assert without.count("[[bearings]]") == len(expected.bearings) - 1
    listed = printed(capsys, str(FILE), "--list")
    assert listed == gb.rexs_contents(FILE).table() + "\n"
    data = json.loads(printed(capsys, str(FILE), *options, "--json"))
    assert data["load_cases"][0]["torques"] == {"motor torque": 50.0}
    assert data["scene"]["reference"] == "motor"


def test_the_command_reads_rotors_of_ross(capsys, tmp_path: Path):
    rotor = Path(__file__).parents[3] / "examples" / "ross_files" / "rotor.toml"
    if not rotor.is_file():
        pytest.skip("the examples are not installed")
    scene = tmp_path / "rotor.toml"
    scene.write_text(printed(capsys, str(rotor)))
    assert gb.RotorSystem.load(scene).description == gb.RotorSystem.from_ross(rotor).description


CASE = ("--load-case", "1", "--bearing", "other=1e8")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            [str(FILE), "--load-case", "3"],
            "see --list, and the options --load-case, --bearing and --coupling",
        ),
        ([str(FILE), "--bearing", "1e8", "--load-case", "1"], 'must be NAME=VALUES, got "1e8"'),
        ([str(FILE), *CASE, "--out", "a.json"], "--out: must end with .toml or .rexs"),
        ([str(FILE), "--mesh", "a/b=1e8"], "--mesh: is for a rotor of ROSS, but"),
        (["a.json", "--mesh", "a/b"], '--mesh: must be DRIVER/DRIVEN=STIFFNESS, got "a/b"'),
        (["a.json", "--mesh", "a=1e8"], '--mesh: must be DRIVER/DRIVEN=STIFFNESS, got "a=1e8"'),
        (
            ["a.json", "--mesh", "a/b=1 m"],
            "meshes.stiffness: must have a unit that converts to N/m",
        ),
        (
            ["a.json", "--mesh", "a/b=1e8", "--centre-line-angle", "b/a=30 deg"],
            '--centre-line-angle: no --mesh is given for "b/a"',
        ),
    ],
)
def test_a_wrong_call_of_the_command_is_an_error(capsys, arguments, message: str):
    with pytest.raises(SystemExit) as ended:
        main(["import", *arguments])
    assert ended.value.code == 2
    assert message in capsys.readouterr().err
