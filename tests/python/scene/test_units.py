"""Units: functions of the package, quantities of pint, and texts in scene files."""

from __future__ import annotations

import inspect
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import gearbow as gb
from gearbow.description.part import Part
from gearbow.units.fields import FIELDS, magnitude, unit_of
from gearbow.units.parse import parsed
from reference.cases import each_case
from reference.machines import rotor


def test_functions_give_si_units():
    assert gb.mm(5) == 5e-3
    assert type(gb.mm(5)) is float
    assert gb.rpm(60) == pytest.approx(2 * np.pi, rel=1e-15)
    assert gb.degrees(20) == gb.Gear("g", "s", 0.0, 25).pressure_angle
    np.testing.assert_allclose(gb.rpm([0, 30]), [0.0, np.pi], rtol=1e-15)
    np.testing.assert_array_equal(gb.mm(np.array([[1, 2]])), [[1e-3, 2e-3]])
    with pytest.raises(gb.SceneError, match="mm: must be a number, got 'five'"):
        gb.mm("five")


@each_case(
    ("text", "path", "value"),
    [
        ("500 mm", "shafts[0].length", 0.5),
        ("0.15mm", "shafts[0].bow.amplitude", 0.15e-3),
        ("3 N/um", "bearings[1].stiffness", 3e6),
        ("3 N/µm", "bearings[1].stiffness[0]", 3e6),
        ("1 kN/mm", "meshes[0].stiffness", 1e6),
        ("12 g mm", "disks[0].unbalance", 12e-6),
        ("250 Nm", "torques[0].value", 250.0),
        ("5 kN*m/rad", "drives[0].stiffness", 5e3),
        ("2 N s/mm", "bearings[0].damping", 2e3),
        ("7.85 g/cm^3", "shafts[0].material.density", 7850.0),
        ("210 GPa", "shafts[0].material.youngs_modulus", 210e9),
        ("9.81 m/s²", "gravity", 9.81),
        ("20 deg", "gears[0].pressure_angle", np.radians(20)),
        ("20°", "gears[0].pressure_angle", np.radians(20)),
        ("1500 rpm", "speed", 50 * np.pi),
        ("25 rev/s", "speed", 50 * np.pi),
        ("-90 °/s", "speed", -np.pi / 2),
        ("1 us", "rayleigh[1]", 1e-6),
        ("15 mPa s", "bearings[0].viscosity", 0.015),
        ("0 mm", "shafts[0].bow.amplitude", 0.0),
    ],
)
def test_a_text_with_a_unit(text: str, path: str, value: float):
    # factors are exact, except for the power of pi
    exact = not re.search("deg|°|rpm|rev", text)
    assert parsed(text, path) == (value if exact else pytest.approx(value, rel=1e-15))


#: Units of the workshop: field, factor as NIST SP 811 (2008) prints it or follows from its exact
#: entries by hand, and name in pint (whose "mil" is an angle).
WORKSHOP = {
    "in": ("length", 0.0254, "inch"),
    "mil": ("length", 2.54e-5, "thou"),
    "ft": ("length", 0.3048, "foot"),
    "mm": ("length", 1e-3, "mm"),
    "µm": ("length", 1e-6, "um"),
    "lbm": ("mass", 0.45359237, "pound"),
    "lbf": ("forces[0].value", 4.4482216152605, "lbf"),
    "psi": ("youngs_modulus", 6894.757293168361, "psi"),
    "lbf/in": ("bearings[0].stiffness", 175.12683524647637, "lbf/inch"),
    "kN/mm": ("bearings[0].stiffness", 1e6, "kN/mm"),
    "N-s/m": ("bearings[0].damping", 1.0, "N*s/m"),
    "lbf-s/in": ("bearings[0].damping", 175.12683524647637, "lbf*s/inch"),
    "lbf s/in": ("bearings[0].damping", 175.12683524647637, "lbf*s/inch"),
    "lbf-in": ("torques[0].value", 0.1129848290276167, "lbf*inch"),
    "lbm-in^2": ("inertia", 2.9263965343e-4, "pound*inch**2"),
    "lbm/in^3": ("density", 27679.904710203125, "pound/inch**3"),
    "cP": ("viscosity", 1e-3, "centipoise"),
    "deg": ("phase", 0.017453292519943295, "degree"),
    "cpm": ("speed", 0.10471975511965977, "revolution/minute"),
    "rpm": ("frequency", 0.10471975511965977, "rpm"),
    "Hz": ("frequency", 6.283185307179586, "hertz"),
    "kHz": ("modal_damping.frequencies[1]", 6283.185307179586, "kilohertz"),
}


@each_case("unit", WORKSHOP)
def test_units_of_the_workshop_agree_with_two_other_tables(unit: str):
    path, factor, name = WORKSHOP[unit]
    # both tables and the factor here are rounded once, that of pint for each of its factors
    assert parsed(f"1 {unit}", path) == pytest.approx(factor, rel=3e-16)
    quantity = pytest.importorskip("pint").Quantity(8e4, name)
    assert parsed(f"8e4 {unit}", path) == pytest.approx(magnitude(quantity, path), rel=1e-15)


@each_case(
    ("text", "path", "message"),
    [
        ("50 Hz", "bearings[0].stiffness.speeds[1]", "50 Hz could be 50 rad/s or 50 rev/s"),
        ("50 Hz", "shafts[0].length", "'Hz' is not a known unit; known are"),
        ("50 khz", "frequencies", 'did you mean "kHz"?'),
        ("5 lb", "mass", "'lb' is not a known unit; a force is in lbf, a mass in lbm"),
        ("5 lbf", "mass", "must have a unit that converts to kg, got '5 lbf'"),
        ("5 N-", "forces[0].value", "is not a known unit"),
        ("5 mil pp", "amplitude", "'pp' is not a known unit"),
    ],
)
def test_a_wrong_unit_of_the_workshop_names_the_remedy(text: str, path: str, message: str):
    with pytest.raises(gb.SceneError, match=re.escape(message)):
        parsed(text, path)


@each_case(
    ("text", "message"),
    [
        ("500", 'write the number without quotes [m], or with its unit, such as "500 m"'),
        ("3 N", "must have a unit that converts to m, got '3 N'"),
        ("0,5 m", "must be a number with a decimal point"),
        ("1_0 mm", "must be a number with a decimal point"),
        ("٣ m", "must be a number"),
        ("3 inch", "'inch' is not a known unit; known are m,"),
        ("3 inch", "%, deg, rev, rpm, "),
        ("long", "must be a number [m] or a text with a number and a unit"),
        ("", "must be a number [m] or a text"),
        ("3 m^2", "must have a unit that converts to m"),
        ("3 m^", "'^' is not a known unit"),
        ("3 km^999999999", "is not a known unit"),
        ("3 m 2", "is not a known unit"),
    ],
)
def test_a_text_with_a_wrong_unit(text: str, message: str):
    with pytest.raises(gb.SceneError) as caught:
        parsed(text, "shafts[0].length")
    assert str(caught.value).startswith("shafts[0].length: ")
    assert message in str(caught.value)


def test_hertz_is_not_a_speed():
    # 50 Hz would convert to 50 rad/s, although 50 turns per second are 314 rad/s
    with pytest.raises(gb.SceneError, match="speed: 'Hz' is not a known unit; a speed is in rad/s"):
        parsed("50 Hz", "speed")
    pint = pytest.importorskip("pint")
    with pytest.raises(gb.SceneError, match="speed: a speed in Hz is ambiguous, got 50 hertz"):
        rotor().modes(pint.UnitRegistry().Quantity(50, "Hz"))


def test_extreme_numbers_take_no_time():
    assert parsed("1e999999999 mm", "shafts[0].length") == np.inf
    assert parsed("1e-999999999 mm", "shafts[0].length") == 0.0
    assert parsed("1e308 km", "shafts[0].length") == np.inf


#: Classes of the parts of a system, and the list that contains them.
LISTS = {
    gb.Shaft: "shafts",
    gb.Gear: "gears",
    gb.Mesh: "meshes",
    gb.Bearing: "bearings",
    gb.JournalBearing: "bearings",
    gb.TiltingPadBearing: "bearings",
    gb.RollingBearing: "bearings",
    gb.Torque: "torques",
    gb.Disk: "disks",
    gb.Support: "supports",
    gb.Housing: "housings",
    gb.Coupling: "couplings",
    gb.Drive: "drives",
    gb.Force: "forces",
}
#: Classes of parts within parts, and the path of one of them.
INNER = {
    gb.Segment: "shafts[0].segments[0]",
    gb.Material: "shafts[0].material",
    gb.Bow: "shafts[0].bow",
    gb.Stiffness: "meshes[0].stiffness",
    gb.TipRelief: "meshes[0].tip_relief",
    gb.TransmissionError: "meshes[0].error",
    gb.MeshFriction: "meshes[0].friction",
    gb.SpeedTable: "bearings[0].stiffness",
    gb.Pad: "bearings[0].pads[0]",
    gb.SqueezeFilm: "bearings[0].support",
}


def described(part: type[Part]) -> dict[str, str | None]:
    """Give the first unit in the description of each parameter of a part, or one for each name."""
    text = inspect.getdoc(part).split("Parameters\n----------\n")[1]
    text = re.split(r"\n\n\w+\n-+\n", text)[0]
    found: dict[str, str | None] = {}
    for names, body in re.findall(r"^(\S[^\n]*?) : [^\n]*\n((?:    [^\n]*\n?)+)", text, re.M):
        plain = re.sub(r"\[\[.*?\]\]", "", body).replace("²", "^2").replace("³", "^3")
        units = re.findall(r"\[([^\[\]]*[a-zA-Z/][^\[\]]*)\]", plain)
        each, known = names.split(", "), [unit for own in units for unit in own.split(", ")]
        if len(each) == 1 or len(known) != len(each):
            known = [units[0] if units else None] * len(each)
        found |= zip(each, known, strict=True)
    return found


def test_the_table_agrees_with_the_documented_units():
    paths = [(kind, f"{key}[0]") for kind, key in LISTS.items()] + list(INNER.items())
    count = 0
    for kind, path in paths:
        for name, unit in described(kind).items():
            if unit is None or unit.startswith(("N/m^", "yy")):
                continue
            entry = {"tooth": "[0][0]", "driver": "[0][0]", "driven": "[0][0]"}
            entry = entry if kind is gb.TransmissionError else {}
            entry |= {"at": "[1]", "a": "[1]", "b": "[1]", "support": "[1]", "carrier": "[1]"}
            entry |= {"points": ".name"}
            if kind is gb.Coupling:
                entry |= {"stiffness": "[0]", "damping": "[0]"}
            here = f"{path}.{name}{entry.get(name, '')}"
            assert unit_of(here) == unit, here
            count += 1
    assert count > 80


def test_every_entry_of_the_table_is_a_unit():
    for key, units in FIELDS.items():
        for unit in units if isinstance(units, tuple) else (units,):
            if unit is not None:
                path = key.replace("*", "name")
                path += f"[{units.index(unit)}]" if isinstance(units, tuple) else ""
                assert parsed(f"2 {unit}", path) == 2.0


TOML = """
gravity = "9.81 m/s^2"
rayleigh = ["2 1/s", "1e-3 ms"]

[[shafts]]
name = "a"
length = "500 mm"
outer_diameter = "5 cm"
elements = 4
bow = { shape = "half_sine", amplitude = "150 um", phase = "20 deg" }

[[disks]]
name = "wheel"
shaft = "a"
position = "25 cm"
mass = "20 kg"
diametral_inertia = 0.1
polar_inertia = "0.2 kg m^2"
unbalance = ["0 g mm", "12 g mm"]

[[bearings]]
shaft = "a"
position = "0 mm"
stiffness = ["30 N/um", "4e7 N/m"]

[[bearings]]
shaft = "a"
position = "0.5 m"
stiffness = { speeds = ["0 rpm", "3000 rpm"], values = ["50 kN/mm", 6e7], outside = "hold" }

[[torques]]
at = ["a", "250 mm"]
value = "250 Nm"

[[torques]]
at = "wheel"
balance = true
"""


def test_a_file_with_units_is_saved_in_si(tmp_path: Path):
    (tmp_path / "units.toml").write_text(TOML)
    system = gb.RotorSystem.load(tmp_path / "units.toml")
    system.save(tmp_path / "si.toml")
    assert '"5' not in (tmp_path / "si.toml").read_text()
    assert gb.RotorSystem.load(tmp_path / "si.toml").description == system.description
    shaft, table = system.shafts[0], system.bearings[1].stiffness
    assert (shaft.length, shaft.outer_diameter, shaft.bow.amplitude) == (0.5, 0.05, 1.5e-4)
    assert shaft.bow.phase == pytest.approx(np.radians(20), rel=1e-15)
    assert system.disks[0].unbalance == 12e-6j
    assert system.rayleigh == (2.0, 1e-6)
    assert system.torques[0].at == ("a", 0.25)
    assert table.values == (5e7, 6e7)
    assert table.speeds == pytest.approx((0.0, 100 * np.pi), rel=1e-15)


def test_plain_data_with_units():
    shaft = {"name": "a", "length": "500 mm", "outer_diameter": 0.05}
    assert gb.RotorSystem.from_dict({"shafts": [shaft]}).shafts[0].length == 0.5


@each_case(
    ("old", "new", "where"),
    [
        ('"500 mm"', '"500 N"', "shafts[0].length"),
        ('"20 deg"', '"20 mm"', "shafts[0].bow.phase"),
        ('"12 g mm"', '"12 g"', "disks[0].unbalance[1]"),
        ('"1e-3 ms"', '"1 m"', "rayleigh[1]"),
        ('"3000 rpm"', '"3000 Hz"', "bearings[1].stiffness.speeds[1]"),
        ('"250 mm"', '"250 s"', "torques[0].at[1]"),
        ("elements = 4", 'elements = "4"', "shafts[0].elements"),
        ('name = "wheel"', 'nmae = "wheel"', "disks[0]"),
    ],
)
def test_a_file_with_a_wrong_unit(tmp_path: Path, old: str, new: str, where: str):
    assert old in TOML
    (tmp_path / "scene.toml").write_text(TOML.replace(old, new))
    with pytest.raises(gb.SceneError) as caught:
        gb.RotorSystem.load(tmp_path / "scene.toml")
    assert str(caught.value).startswith(where)


#: Factors of the units of `train`.
FACTORS = {"mm": 1e-3, "m": 1.0, "um": 1e-6, "deg": np.pi / 180, "GPa": 1e9, "kg/m^3": 1.0}
FACTORS |= {"kg*m": 1.0, "N/um": 1e6, "rpm": np.pi / 30, "N*s/m": 1.0, "N*m": 1.0, "s": 1.0}
FACTORS |= {"m/s^2": 1.0, "1/s": 1.0, "us": 1e-6, "kg": 1.0, "N*m/rad": 1.0, "N*m*s/rad": 1.0}
FACTORS |= {"kN": 1e3, "kg*m^2": 1.0, "mPa*s": 1e-3}


def plain(value, unit):
    return np.multiply(value, FACTORS[unit]).tolist()


def train(q) -> gb.RotorSystem:
    """Make a train whose numbers with a unit are `q(value, unit)`."""
    tooth = {"module": q(3, "mm"), "face_width": q(30, "mm"), "pressure_angle": q(20, "deg")}
    film = {"diameter": q(50, "mm"), "length": q(20, "mm"), "clearance": q(50, "um")}
    support = gb.Support("foot", mass=q(12, "kg"), stiffness=q((50, 80), "N/um"))
    moving = gb.TimeSeries(q([0, 1], "s"), q([0, 5], "N*m"))
    return gb.RotorSystem(
        shafts=[
            gb.Shaft(
                "a",
                length=q(500, "mm"),
                outer_diameter=q(50, "mm"),
                material=gb.Material(q(207, "GPa"), q(7850, "kg/m^3"), 0.3),
                bow=gb.Bow.half_sine(q(0.1, "mm"), phase=q(20, "deg")),
            ),
            gb.Shaft(
                "b",
                segments=[gb.Segment(q(200, "mm"), q(0.05, "m")), gb.Segment(0.3, q(60, "mm"))],
                bow=gb.Bow.points(q([0, 250, 500], "mm"), [0.0, q(0.1, "mm"), 0.0], q(3, "deg")),
            ),
        ],
        gears=[
            gb.Gear("g1", "a", q(250, "mm"), teeth=25, **tooth),
            gb.Gear("g2", "b", q(250, "mm"), teeth=50, unbalance=q(1e-4, "kg*m"), **tooth),
        ],
        meshes=[
            gb.Mesh(
                "g1",
                "g2",
                stiffness=gb.Stiffness.parabolic(q(200, "N/um")),
                damping=q(500, "N*s/m"),
                error=gb.TransmissionError(tooth=[(q(5, "um"), q(10, "deg"))]),
            )
        ],
        bearings=[
            gb.Bearing(
                "a",
                0.0,
                stiffness=gb.SpeedTable(q([0, 3000], "rpm"), q([100, 200], "N/um"), "hold"),
                damping=(q(500, "N*s/m"), 400.0),
                support=support,
            ),
            gb.Bearing("a", q(500, "mm"), stiffness=q([[100, 5], [5, 200]], "N/um")),
            gb.JournalBearing("b", q(0, "mm"), viscosity=q(20, "mPa*s"), **film),
            gb.Bearing("b", q(50, "mm"), stiffness=1e8, support="box"),
            gb.Bearing("b", 0.5, stiffness=q(100, "N/um")),
        ],
        housings=[
            gb.Housing(
                "box",
                mass=q(80, "kg"),
                stiffness=2e8,
                inertia=q((2, 3, 3), "kg*m^2"),
                rotational_stiffness=(1e7, q(2e7, "N*m/rad"), 2e7),
                points={"ear": (0.0, q(100, "mm"), q(150, "mm"))},
            )
        ],
        torques=[gb.Torque("g1", q(250, "N*m")), gb.Torque(("b", q(500, "mm")), moving)],
        drives=[gb.Drive("g2", q(1e5, "N*m/rad"), q(20, "N*m*s/rad"))],
        forces=[gb.Force("g1", q(1, "kN"))],
        gravity=q(9.81, "m/s^2"),
        rayleigh=(q(1, "1/s"), q(1, "us")),
    )


def assert_close(first, second, where: str = ""):
    """Compare plain data; pint rounds its factors once more."""
    if isinstance(first, dict):
        assert first.keys() == second.keys(), where
        for key, value in first.items():
            assert_close(value, second[key], f"{where}.{key}")
    elif isinstance(first, list):
        for i, (a, b) in enumerate(zip(first, second, strict=True)):
            assert_close(a, b, f"{where}[{i}]")
    elif isinstance(first, float):
        assert first == pytest.approx(second, rel=1e-15), where
    else:
        assert first == second, where


def test_quantities_of_pint():
    quantity = pytest.importorskip("pint").UnitRegistry().Quantity
    system, expected = train(quantity), train(plain)
    assert_close(system.description, expected.description)
    assert system.shafts[0].length == 0.5  # parts of a system are in SI units
    assert type(system.shafts[0].length) is float
    assert system.bearings[0].stiffness.values == (1e8, 2e8)
    film, same = (
        one.coefficients(load, speed)
        for one, load, speed in (
            (
                gb.JournalBearing(
                    "b",
                    0.0,
                    diameter=quantity(50, "mm"),
                    length=quantity(20, "mm"),
                    clearance=quantity(50, "um"),
                    viscosity=quantity(20, "mPa*s"),
                ),
                quantity(0.5, "kN"),
                quantity(1500, "rpm"),
            ),
            (expected.bearings[2], 500.0, gb.rpm(1500)),
        )
    )
    assert film.sommerfeld == pytest.approx(same.sommerfeld, rel=1e-12)


def test_quantities_of_pint_in_analyses():
    quantity = pytest.importorskip("pint").UnitRegistry().Quantity
    system, speed = rotor(), gb.rpm(1500)
    given = quantity(1500, "rpm")
    assert system.modes(given).frequencies_hz == pytest.approx(system.modes(speed).frequencies_hz)
    speeds = quantity([0, 1500], "rpm")
    assert system.campbell(speeds, count=4).speeds == pytest.approx([0.0, speed])
    assert system.campbell([0.0, given], count=4).speeds == pytest.approx([0.0, speed])
    response = system.simulate(
        quantity(2, "ms"), given, record=[("rotor", quantity(50, "cm"))], output_step=1e-4
    )
    assert response.time[-1] == 2e-3
    assert response.speed == pytest.approx(speed)
    np.testing.assert_array_equal(
        response.displacement(("rotor", quantity(500, "mm"))),
        response.displacement(("rotor", 0.5)),
    )
    profile = gb.SpeedProfile.ramp(quantity(0, "rpm"), given, duration=quantity(500, "ms"))
    assert profile([0.5]) == pytest.approx([speed])
    assert system.default_output_step(quantity(1, "s"), given) == system.default_output_step(
        1.0, speed
    )
    assert system.critical_speed_map(quantity([10], "N/um")).stiffnesses == pytest.approx([1e7])


@each_case(
    ("change", "where"),
    [
        (
            lambda q: {"shafts": [gb.Shaft("a", length=q(1, "N"), outer_diameter=0.1)]},
            "shafts[0].length",
        ),
        (
            lambda q: {
                "shafts": [gb.Shaft("a", length=1.0, outer_diameter=0.1, elements=q(4, "m"))]
            },
            "shafts[0].elements: must have no unit",
        ),
        (
            lambda q: {
                "bearings": [
                    gb.Bearing("rotor", 0.0, stiffness=gb.SpeedTable([0, 1], q([1, 1], "N")))
                ]
            },
            "bearings[0].stiffness.values",
        ),
        (lambda q: {"gravity": q(9.81, "m/s")}, "gravity"),
        (lambda q: {"torques": [gb.Torque(("rotor", q(1, "s")), 1.0)]}, "torques[0].at[1]"),
    ],
)
def test_a_quantity_of_another_dimension(change, where: str):
    quantity = pytest.importorskip("pint").UnitRegistry().Quantity
    with pytest.raises(gb.SceneError) as caught:
        rotor().replace(**change(quantity))
    assert str(caught.value).startswith(where)


def test_quantities_of_pint_in_sensors():
    quantity = pytest.importorskip("pint").UnitRegistry().Quantity
    probe = gb.Probe("rotor", quantity(300, "mm"), angle=quantity(45, "deg"))
    assert probe.position == pytest.approx(0.3, rel=1e-15)
    assert probe.angle == pytest.approx(np.pi / 4, rel=1e-15)
    eccentric = gb.Probe("rotor", 0.3, runout=quantity(5 + 2j, "um"))
    assert eccentric.runout == pytest.approx(5e-6 + 2e-6j, rel=1e-15)
    angles, values = quantity([0.0, 90.0], "deg"), quantity([1.0, 2.0], "um")
    table = gb.Probe("rotor", 0.3, runout=(angles, values)).runout
    assert np.allclose(table, ([0.0, np.pi / 2], [1e-6, 2e-6]), rtol=1e-15, atol=0.0)
    place = ("rotor", quantity(300, "mm"))
    assert gb.Accelerometer(place, angle=quantity(90, "deg")).angle == pytest.approx(np.pi / 2)
    assert gb.Accelerometer(place).at == ("rotor", pytest.approx(0.3, rel=1e-15))
    assert gb.Tacho("rotor", position=quantity(30, "cm")).position == pytest.approx(0.3)
    with pytest.raises(gb.SceneError, match=r"^probe\.runout: must have a unit that converts to m"):
        gb.Probe("rotor", 0.3, runout=quantity(1.0, "kg"))


def test_gearbow_does_not_import_pint():
    code = "import sys, gearbow as gb; gb.rpm(3); gb.Shaft('a', length=1.0); assert 'pint' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)
