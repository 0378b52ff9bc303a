"""Numeric arguments: every public callable rejects a value that is not a number."""

from __future__ import annotations

import dataclasses
import datetime as dt
import math
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference import machines
from reference.cases import each_case
from reference.invalid_scenes import SCENE, build, numbers, with_value, written
from reference.machines import inertia, short_pair

#: Values that are not real numbers, although Python or NumPy would convert most of them.
WRONG = {
    "text": "1",
    "bytes": b"1",
    "truth value": True,
    "NumPy truth value": np.bool_(True),
    "complex": 1.0 + 1.0j,
    "NumPy complex": np.complex128(1.0),
    "date": np.datetime64("2020-01-01"),
    "time difference": np.timedelta64(1, "s"),
    "Python time difference": dt.timedelta(1),
    "masked": np.ma.masked,
    "masked array": np.ma.masked_array([1.0], [True]),
    "beyond floats": 10**400,
    "beyond texts": 10**5000,
    "mapping": {"a": 1.0},
    "object": object(),
    "empty text": "",
}
#: A mapping describes a force that depends on time, or a stiffness that depends on speed.
WRONG_FOR_ATTACHED = {name: value for name, value in WRONG.items() if name != "mapping"}
#: Real numbers.
RIGHT = {
    "int": 1,
    "NumPy int": np.int32(1),
    "NumPy float": np.float32(1.0),
    "extended": np.longdouble(1.0),
    "no axes": np.array(1.0),
    "fraction": Fraction(1),
    "decimal": Decimal(1),
}
COMPLEX = ("unbalance", "misalignment")


def rotor() -> gb.RotorSystem:
    wheel = inertia(10.0, 0.05, 0.1, name="wheel", unbalance=1e-4)
    return machines.rotor(disk=wheel, bearing={"stiffness": 1e8, "damping": 1e3})


@pytest.fixture(scope="module")
def system() -> gb.RotorSystem:
    return rotor()


@pytest.fixture(scope="module")
def response(system: gb.RotorSystem) -> gb.Response:
    return system.simulate(0.05, 100.0, record=["wheel"], output_step=1e-3)


# --- the fields of parts --------------------------------------------------------------------------


@each_case("value", WRONG.values(), ids=WRONG)
@each_case("path", numbers(SCENE), ids=written)
def test_a_field_without_a_number_is_an_error(path: tuple[str | int, ...], value: object):
    if path[-1] in COMPLEX and isinstance(value, complex):
        return
    start = written(path[:1])
    with pytest.raises(gb.SceneError) as caught:
        build(with_value(list(path), value))
    text = str(caught.value)
    # Constructors of bows and models know the field, but not the part.
    assert text.startswith((start, "bow.", str(path[-2:][0]))), text


def test_every_numeric_field_is_in_that_scene():
    """Check that the test above covers every field of each part."""
    beside = {"shear_modulus", "runout", "backlash", "bow", "error", "tip_relief", "segments"}
    beside.add("friction")  # of a mesh, a test of its own below
    beside.add("speed_ratio")  # of shafts that no mesh connects
    beside.add("carrier")  # of a mesh, a test of its own below
    parts = (gb.Material, gb.Segment, gb.Shaft, gb.Disk, gb.Gear, gb.Mesh, gb.Bearing)
    known = {key for path in numbers(SCENE) for key in path}
    for part in parts:
        for field in dataclasses.fields(part):
            texts = {"name", "shaft", "driver", "driven", "material", "support", "contact"}
            flags = {"shear", "damping_in_separation", "internal"}
            assert field.name in known | beside | texts | flags, (part, field.name)


@each_case("value", WRONG.values(), ids=WRONG)
def test_the_place_of_a_carrier_without_a_number_is_an_error(value: object):
    with pytest.raises(gb.SceneError, match=r"meshes\[0\]\.carrier\[1\]: must be "):
        build(with_value(["meshes", 0, "carrier"], ("input", value)))


@each_case("value", WRONG.values(), ids=WRONG)
@each_case(
    "make",
    [
        lambda x: gb.Shaft("s", length=1.0, outer_diameter=0.1, elements=2, bow=gb.Bow.sag(x)),
        lambda x: gb.Shaft(
            "s", length=1.0, outer_diameter=0.1, elements=2, bow=gb.Bow.mode(x, 1e-4)
        ),
        lambda x: gb.Shaft(
            "s",
            length=x,
            outer_diameter=0.1,
            elements=2,
            bow=gb.Bow.function(lambda at: 1e-4 * at),
        ),
        lambda x: gb.Shaft(
            "s",
            length=1.0,
            outer_diameter=0.1,
            elements=2,
            material=gb.Material(2e11, 7800.0, shear_modulus=x),
        ),
        lambda x: gb.Shaft("s", segments=[gb.Segment(0.1, x)]),
    ],
)
def test_a_shaft_with_an_invalid_number(make, value):
    with pytest.raises(gb.SceneError, match=r"^shafts\[0\]"):
        gb.RotorSystem([make(value)])


def pair(**mesh: Any) -> gb.RotorSystem:
    return short_pair(("ga", "gb"), (30, 30), mesh=mesh, bearing=None, torque=0.0)


@each_case("value", WRONG.values(), ids=WRONG)
@each_case(
    "make",
    [
        lambda x: {"stiffness": gb.Stiffness.square(x)},
        lambda x: {"stiffness": gb.Stiffness.parabolic(pair=x)},
        lambda x: {"stiffness": gb.Stiffness.parabolic(2e8, end_ratio=x)},
        lambda x: {"stiffness": gb.Stiffness.square(2e8, engagement=x)},
        lambda x: {"stiffness": gb.Stiffness.table([2e8, x, 2e8])},
        lambda x: {"stiffness": gb.Stiffness.fourier(2e8, [x])},
        lambda x: {"stiffness": gb.Stiffness.potential_energy([x, 0.01])},
        lambda x: {"stiffness": gb.Stiffness.square(2e8), "tip_relief": gb.TipRelief(x, 1e-3)},
        lambda x: {"error": gb.TransmissionError(tooth=[(1e-6, x)])},
        lambda x: {"error": gb.TransmissionError(table=[0.0, 1e-6, x])},
        lambda x: {"backlash": x},
        lambda x: {"friction": x},
        lambda x: {"friction": gb.MeshFriction(viscosity=0.02, roughness=x)},
    ],
)
def test_teeth_with_an_invalid_number(make, value):
    with pytest.raises(gb.SceneError, match=r"^(meshes\[0\]|values|amplitudes|bore|tooth|table)"):
        pair(**make(value))


# --- the arguments of functions -------------------------------------------------------------------

ARGUMENTS = {
    "modes speed": (lambda s, _, x: s.modes(x), "speed"),
    "modes count": (lambda s, _, x: s.modes(count=x), "count"),
    "campbell speeds": (lambda s, _, x: s.campbell([0.0, x]), "speeds"),
    "campbell count": (lambda s, _, x: s.campbell([0.0, 1.0], count=x), "count"),
    "campbell harmonics": (lambda s, _, x: s.campbell([0.0, 1.0], harmonics=x), "harmonics"),
    "critical stiffness": (lambda s, _, x: s.critical_speed_map([x]), "stiffnesses"),
    "critical order": (lambda s, _, x: s.critical_speed_map([1e8], order=x), "order"),
    "synchronous": (lambda s, _, x: s.synchronous([1.0, x]), "speeds"),
    "slow roll": (lambda s, _, x: s.synchronous([1.0]).subtract_slow_roll(x), "speed"),
    "operating": (
        lambda s, _, x: s.synchronous([1.0, 2.0]).peaks("wheel", operating=(x, 2.0)),
        "operating",
    ),
    "balance speed": (lambda s, _, x: s.balance(["wheel"], x), "speed"),
    "balance plane": (lambda s, _, x: s.balance([("rotor", x)], 1.0), "planes"),
    "duration": (lambda s, _, x: s.simulate(x, 1.0), "duration"),
    "speed": (lambda s, _, x: s.simulate(1e-3, x), "speed"),
    "speed table": (lambda s, _, x: s.simulate(1e-3, ([0.0, 1.0], [1.0, x])), "speed"),
    "step": (lambda s, _, x: s.simulate(1e-3, 1.0, step=x), "step"),
    "rtol": (lambda s, _, x: s.simulate(1e-3, 1.0, rtol=x), "rtol"),
    "stages": (lambda s, _, x: s.simulate(1e-3, 1.0, stages=x), "stages"),
    "modes": (lambda s, _, x: s.simulate(1e-3, 1.0, modes=x), "modes"),
    "output_step": (lambda s, _, x: s.simulate(1e-3, 1.0, output_step=x), "output_step"),
    "times": (lambda s, _, x: s.simulate(1e-3, 1.0, times=[0.0, x]), "times"),
    "start": (lambda s, _, x: s.simulate(1e-3, 1.0, start=x), "start"),
    "record": (lambda s, _, x: s.simulate(1e-3, 1.0, record=[("rotor", x)]), "record"),
    "tradeoff": (lambda s, _, x: s.tradeoff(x, 1.0, signals="wheel"), "duration"),
    "ramp": (lambda *a: gb.SpeedProfile.ramp(0.0, 1.0, a[2]), "speed"),
    "ramp start": (lambda *a: gb.SpeedProfile.ramp(a[2], 1.0, 1.0), "speed"),
    "table": (lambda *a: gb.SpeedProfile.table([0.0, a[2]], [0.0, 1.0]), "speed"),
    "profile": (lambda *a: gb.SpeedProfile([0.0, 1.0], [[a[2]]]), "speed"),
    "gravity": (lambda s, _, x: s.replace(gravity=x), "gravity"),
    "gravity vector": (lambda s, _, x: s.replace(gravity=(0.0, x)), "gravity"),
    "modal damping": (lambda s, _, x: s.replace(modal_damping=x), "modal_damping"),
    "rayleigh": (lambda s, _, x: s.replace(rayleigh=(x, 0.0)), "rayleigh"),
    "orders skip time": (lambda _, r, x: r.orders("wheel", skip_time=x), "skip_time"),
    "orders shafts": (lambda _, r, x: r.orders("wheel", shaft_harmonics=x), "shaft_harmonics"),
    "orders meshes": (lambda _, r, x: r.orders("wheel", mesh_harmonics=x), "mesh_harmonics"),
    "orders sidebands": (lambda _, r, x: r.orders("wheel", sidebands=x), "sidebands"),
    "orders of": (lambda _, r, x: r.orders(("rotor", x)), "at"),
    "spectrum of": (lambda _, r, x: r.spectrum(("rotor", x)), "at"),
    "displacement": (lambda _, r, x: r.displacement(("rotor", x)), "at"),
    "bearing force": (lambda _, r, x: r.bearing_force(("rotor", x)), "at"),
    "static displacement": (lambda s, _, x: s.static().displacement(("rotor", x)), "at"),
    "static bearing": (lambda s, _, x: s.static().bearing_force(("rotor", x)), "at"),
    "synchronous place": (lambda s, _, x: s.synchronous([1.0]).displacement(("rotor", x)), "at"),
    "synchronous bearing": (
        lambda s, _, x: s.synchronous([1.0]).bearing_force(("rotor", x)),
        "at",
    ),
    "modes table": (lambda s, _, x: s.modes().table(x), "count"),
    "modes plot": (lambda s, _, x: s.modes().plot(x), "number"),
    "map plot": (lambda s, _, x: s.critical_speed_map([1e8]).plot(x), "count"),
    "profile at": (lambda *a: gb.SpeedProfile.ramp(0.0, 1.0, 1.0)(a[2]), "times"),
    "dictionary": (lambda s, _, x: gb.RotorSystem.from_dict({**s.description, "gravity": x}), ""),
}
#: A name in arguments that accept numbers and names.
NAMES = ("record", "balance plane")


@each_case("name", ARGUMENTS)
@each_case("value", WRONG.values(), ids=WRONG)
def test_an_argument_without_a_number_is_an_error(name, value, system, response):
    where = ARGUMENTS[name][1]
    if isinstance(value, str) and (name in NAMES or where == "at"):
        return
    with pytest.raises(gb.GearbowError, match=rf"^{where}"):
        ARGUMENTS[name][0](system, response, value)


@pytest.mark.parametrize("value", RIGHT.values(), ids=RIGHT)
def test_other_kinds_of_numbers_are_accepted(value, system):
    assert system.modes(value).speed == 1.0
    assert system.synchronous([value, value]).speeds.tolist() == [1.0, 1.0]
    assert system.campbell([value], count=value).speeds.tolist() == [1.0]
    longer = system.replace(
        shafts=[gb.Shaft("rotor", length=value, outer_diameter=0.05, elements=value)]
    )
    assert longer.description["shafts"][0]["length"] == 1.0
    assert longer.description["shafts"][0]["elements"] == 1
    assert system.simulate(1e-3, value, record=["wheel"]).speed == 1.0


@each_case(
    ("call", "text"),
    [
        (lambda s: s.synchronous([[1.0, 2.0]]), r"^speeds: must be one sequence .* \(1, 2\)"),
        (lambda s: s.synchronous([]), "^speeds: must have at least 1"),
        (lambda s: s.synchronous([[1.0], [1.0, 2.0]]), "^speeds: must have rows of equal lengths"),
        (lambda s: s.synchronous(np.ma.masked_array([1.0, 2.0], [0, 1])), "^speeds: .*masked"),
        (lambda s: s.synchronous([1.0, "2"]), r"^speeds\[1\]: must be a number, got '2'"),
        (lambda s: s.synchronous([math.nan]), r"^speeds\[0\]: must be finite, got nan"),
        (lambda s: s.campbell([]), "^speeds: must have at least 1"),
        (lambda s: s.critical_speed_map([]), "^stiffnesses: must have at least 1"),
        (lambda s: s.modes(count=-1), "^count: must be at least 1, got -1"),
        (lambda s: s.modes(count=2.5), "^count: must be a whole number, got 2.5"),
        (lambda s: s.modes(math.nan), "^speed: must be finite, got nan"),
        (lambda s: s.balance(["wheel"], 100.0, points=[]), "^points: must name at least one"),
        (lambda s: s.balance([], 100.0), "^planes: must"),
        (lambda s: s.balance([None], 100.0), r"^planes\[0\]: must be a name"),
        (lambda s: s.balance(None, 100.0), "^planes: must be a list"),
        (lambda s: s.simulate(10**400, 1.0), "^duration: must be below 1.8e308"),
        (lambda s: s.simulate(1e-3, 1.0, record=[None]), r"^record\[0\]: must be a name or"),
        (lambda s: s.simulate(1e-3, 1.0, record=5), "^record: must be a list"),
        (lambda s: s.simulate(1e-3, 1.0, record=[("wheel",)]), r"^record\[0\]: must be"),
        (lambda s: s.simulate(1e-3, 1.0, method=4), "^method: must be text"),
        (lambda s: s.simulate(1e-3, 1.0, geometry=None), "^geometry: must be text"),
        (lambda s: s.simulate(1e-3, 1.0, times=[[0.0, 1e-3]]), r"^times: must be one sequence"),
        (lambda s: s.simulate(1e-3, ([0.0, 1.0], [1.0])), "^speed: needs equal numbers"),
        (lambda s: s.simulate(1e-3, 1.0).plot("orbits", []), "^at: must name at least one"),
        (lambda s: s.replace(reference=1), "^reference: must be text"),
        (lambda s: s.replace(motion=["coupled"]), "^motion: must be text"),
        (lambda s: s.replace(shafts=None), "^shafts: must be a list"),
        (lambda _: gb.RotorSystem.from_dict([]), "^description: must be a mapping"),
        (lambda _: gb.Bow.points(None, [1.0]), "^bow.positions: must be a number"),
    ],
)
def test_an_invalid_call_is_an_error(call, text, system):
    with pytest.raises(gb.GearbowError, match=text):
        call(system)


# --- whole numbers --------------------------------------------------------------------------------


@pytest.mark.parametrize("elements", [8.0, np.float32(8.0), np.int8(8), Fraction(8)])
def test_a_whole_number_may_be_written_as_a_float(elements):
    shaft = gb.Shaft("s", length=1.0, outer_diameter=0.05, elements=elements)
    system = gb.RotorSystem([shaft])
    assert system.description["shafts"][0]["elements"] == 8
    assert len({x for _, x, _ in system.dofs}) == 9


@each_case(
    ("value", "text"),
    [
        (25.5, "must be a whole number, got 25.5"),
        (-3, "must be at least"),
        (-3.0, "must be at least"),
        (2**40, "must be smaller"),
        (1e300, "must be smaller"),
        (math.nan, "must be a whole number, got"),
    ],
)
def test_a_fractional_number_of_teeth_is_an_error(value, text):
    with pytest.raises(gb.SceneError, match=rf"^gears\[0\].teeth: {text}"):
        build(with_value(["gears", 0, "teeth"], value))


def test_files_follow_the_same_rule_for_whole_numbers(tmp_path):
    system = rotor()
    file = tmp_path / "scene.toml"
    system.save(file)
    text = file.read_text()
    assert "elements = 4" in text
    file.write_text(text.replace("elements = 4", "elements = 4.0"))
    assert gb.RotorSystem.load(file).description == system.description
    file.write_text(text.replace("elements = 4", "elements = 4.5"))
    with pytest.raises(
        gb.SceneError, match=r"(?s)^shafts\[0\].elements: .*must be a whole number, got 4.5"
    ):
        gb.RotorSystem.load(file)
    file.write_text(text.replace("elements = 4", "elements = true"))
    with pytest.raises(gb.SceneError, match=r"(?s)^shafts\[0\].elements: .*whole number"):
        gb.RotorSystem.load(file)


def test_a_file_that_is_not_text(tmp_path):
    file = tmp_path / "scene.toml"
    file.write_bytes("[[shafts]]\nname = 'Wellenlänge'\n".encode("latin-1"))
    with pytest.raises(gb.SceneError, match=r"scene.toml: is not UTF-8 text: .*0xe4"):
        gb.RotorSystem.load(file)


def test_integers_beyond_64_bits_are_accepted():
    stiff = gb.Bearing("rotor", 0.0, stiffness=10**20)
    assert stiff._describe("bearings[0]")["stiffness"] == 1e20


# --- supports, couplings, drives and forces -------------------------------------------------------

#: Parts with valid numbers, and the argument of the system that takes them.
ATTACHED: dict[str, tuple[type, dict[str, Any]]] = {
    "supports": (gb.Support, {"name": "base", "mass": 2.0, "stiffness": 1e8, "damping": 10.0}),
    "housings": (gb.Housing, {"name": "base", "mass": 2.0, "stiffness": 1e8, "damping": 10.0}),
    "couplings": (
        gb.Coupling,
        {
            "a": ("rotor", 1.0),
            "b": ("second", 0.0),
            "axial_stiffness": 1e8,
            "lateral_stiffness": 1e8,
            "tilting_stiffness": 1e4,
            "torsional_stiffness": 1e5,
            "axial_damping": 1.0,
            "lateral_damping": 1.0,
            "tilting_damping": 1.0,
            "torsional_damping": 1.0,
        },
    ),
    "drives": (gb.Drive, {"at": "wheel", "stiffness": 1e3, "damping": 1.0}),
    "forces": (gb.Force, {"at": "wheel", "value": 10.0, "order": 1.0}),
}
FIELDS = [
    (key, name)
    for key, (_, given) in ATTACHED.items()
    for name, value in given.items()
    if isinstance(value, float)
] + [("couplings", name) for name in ("offset", "angle", "runout")]


def with_attached(key: str, **changed: object) -> gb.RotorSystem:
    """Return a system with one part of this kind."""
    kind, given = ATTACHED[key]
    bearings = [gb.Bearing("rotor", 0.0, stiffness=1e8), gb.Bearing("second", 0.5, stiffness=1e8)]
    if key in ("supports", "housings"):
        bearings[0] = dataclasses.replace(bearings[0], support="base")
    shafts = [*rotor().shafts, gb.Shaft("second", length=0.5, outer_diameter=0.05, elements=2)]
    parts: dict[str, Any] = {"couplings": [gb.Coupling(**ATTACHED["couplings"][1])]}
    parts[key] = [kind(**given | changed)]
    return rotor().replace(shafts=shafts, bearings=bearings, **parts)


@pytest.mark.parametrize("key", ATTACHED)
def test_attached_parts_with_numbers_are_valid(key: str):
    assert len(getattr(with_attached(key), key)) == 1


@each_case("value", WRONG_FOR_ATTACHED.values(), ids=WRONG_FOR_ATTACHED)
@each_case(("key", "name"), FIELDS, ids=map(".".join, FIELDS))
def test_attached_parts_reject_a_value_that_is_no_number(key: str, name: str, value: object):
    if isinstance(value, complex) and name in ("value", "offset", "angle", "runout"):
        return
    with pytest.raises(gb.SceneError, match=name):
        with_attached(key, **{name: value})
