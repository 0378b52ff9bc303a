"""Mistakes of units are warnings with the usual range and the probable cause; machines of all sizes
pass.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference import scenes
from reference.cases import each_case
from reference.machines import SHAFTS, pair

MILLIMETRE = 1e-3
ROTORS = sorted((Path(__file__).parents[3] / "examples" / "rotors").glob("*.toml"))


def train(**options: Any) -> gb.RotorSystem:
    return pair(SHAFTS, ("ginput", "goutput"), **{"bearing": {"stiffness": 1e8}, **options})


def shaft(**options: Any) -> list[gb.Shaft]:
    plain = {"length": 0.5, "outer_diameter": 0.05, "elements": 2}
    return [gb.Shaft("input", **plain | options), gb.Shaft("output", **plain)]


def gears(**options: Any) -> list[gb.Gear]:
    return [replace(train().gears[0], **options), train().gears[1]]


def mesh(**options: Any) -> list[gb.Mesh]:
    return [replace(train().meshes[0], **options)]


def disk(**options: Any) -> list[gb.Disk]:
    given = {"mass": 10.0, "diametral_inertia": 0.05, "polar_inertia": 0.1} | options
    return [gb.Disk("wheel", "input", 0.1, **given)]


STEEL = {"poisson_ratio": 0.3}
PAIRS = gb.Stiffness.square(2e8)
SLIPS = {
    "length in millimetres": ({"shafts": shaft(length=500.0)}, "shafts[0].length", "millimetres"),
    "diameter in millimetres": (
        {"shafts": shaft(outer_diameter=50.0)},
        "shafts[0].outer_diameter",
        "millimetres",
    ),
    "modulus in MPa": (
        {"shafts": shaft(material=gb.Material(207e3, 7850.0, **STEEL))},
        "shafts[0].material.youngs_modulus",
        "MPa",
    ),
    "modulus in GPa": (
        {"shafts": shaft(material=gb.Material(207.0, 7850.0, **STEEL))},
        "shafts[0].material.youngs_modulus",
        "GPa",
    ),
    "density in g/cm3": (
        {"shafts": shaft(material=gb.Material(207e9, 7.85, **STEEL))},
        "shafts[0].material.density",
        "g/cm3",
    ),
    "density in t/mm3": (
        {"shafts": shaft(material=gb.Material(207e9, 7.85e-9, **STEEL))},
        "shafts[0].material.density",
        "t/mm3",
    ),
    "density in kg/mm3": (
        {"shafts": shaft(material=gb.Material(207e9, 7.85e-6, **STEEL))},
        "shafts[0].material.density",
        "is it in",
    ),
    "density in g/m3": (
        {"shafts": shaft(material=gb.Material(207e9, 7.85e6, **STEEL))},
        "shafts[0].material.density",
        "another unit",
    ),
    "bow of 0.15 m": ({"shafts": shaft(bow=gb.Bow.half_sine(0.15))}, "shafts[0].bow.amplitude", ""),
    "bow readings": (
        {"shafts": shaft(bow=gb.Bow.points([0.0, 0.2, 0.5], [0.0, 0.12, 0.0]))},
        "shafts[0].bow.amplitudes",
        "millimetres",
    ),
    "phase in degrees": (
        {"shafts": shaft(bow=gb.Bow.half_sine(1e-4, phase=90.0))},
        "shafts[0].bow.phase",
        "degrees",
    ),
    "face width": ({"gears": gears(face_width=30.0)}, "gears[0].face_width", "millimetres"),
    "mass in grams": ({"gears": gears(mass=1e3)}, "gears[0].mass", "SI units"),
    "disk in grams": ({"disks": disk(mass=1e7)}, "disks[0].mass", "grams"),
    "inertia in kg mm2": (
        {"disks": disk(diametral_inertia=5e4, polar_inertia=1e5)},
        "disks[0].polar_inertia",
        "kg m2",
    ),
    "inertia of a gear": (
        {"gears": gears(diametral_inertia=5e4, polar_inertia=5e2)},
        "gears[0].polar_inertia",
        "kg m2",
    ),
    "unbalance in g mm": ({"disks": disk(unbalance=720.0)}, "disks[0].unbalance", "g mm"),
    "unbalance in kg mm": ({"disks": disk(unbalance=0.72)}, "disks[0].unbalance", "g mm"),
    "run-out": ({"gears": gears(runout=0.02)}, "gears[0].runout", "millimetres"),
    "angle of centres": (
        {"meshes": mesh(centre_line_angle=90.0)},
        "meshes[0].centre_line_angle",
        "degrees",
    ),
    "another angle": (
        {"meshes": mesh(centre_line_angle=-20.0)},
        "meshes[0].centre_line_angle",
        "degrees",
    ),
    "mesh in N/mm": ({"meshes": mesh(stiffness=2e5)}, "meshes[0].stiffness", "N/mm"),
    "pair in N/mm": (
        {"meshes": mesh(stiffness=gb.Stiffness.square(pair=1.5e5))},
        "meshes[0].stiffness.pair",
        "N/mm",
    ),
    "damping in percent": (
        {"meshes": mesh(damping_ratio=5.0)},
        "meshes[0].damping_ratio",
        "percent",
    ),
    "backlash": ({"meshes": mesh(backlash=0.1)}, "meshes[0].backlash", "millimetres"),
    "tip relief": (
        {"meshes": mesh(stiffness=PAIRS, tip_relief=gb.TipRelief(15e-3, 3e-3))},
        "meshes[0].tip_relief.amount",
        "millimetres",
    ),
    "length of relief": (
        {"meshes": mesh(stiffness=PAIRS, tip_relief=gb.TipRelief(15e-6, 3.0))},
        "meshes[0].tip_relief.length",
        "millimetres",
    ),
    "transmission error": (
        {"meshes": mesh(error=gb.TransmissionError(tooth=[(5e-3, 0.0)]))},
        "meshes[0].error.tooth[0]",
        "micrometres",
    ),
    "phase of an error": (
        {"meshes": mesh(error=gb.TransmissionError(driven=[(5e-6, 45.0)]))},
        "meshes[0].error.driven[0]",
        "degrees",
    ),
    "phase of a stiffness": (
        {"meshes": mesh(stiffness=gb.Stiffness.fourier(2e8, [1e7], [180.0]))},
        "meshes[0].stiffness.phases[0]",
        "degrees",
    ),
    "bearings in N/mm": (
        {"bearings": [replace(bearing, stiffness=1e5) for bearing in train().bearings]},
        "bearings[0].stiffness",
        "N/mm",
    ),
    "torque in N mm": (
        {"torques": [gb.Torque("ginput", 2.5e5), gb.Torque.balance("goutput")]},
        "torques[0]",
        "N mm",
    ),
    "damping of modes": ({"modal_damping": 2.0}, "modal_damping", "percent"),
    "gravity in mm/s2": ({"gravity": 9810.0}, "gravity", "mm/s2"),
}


@each_case("name", SLIPS)
def test_a_mistake_of_units_is_a_warning(name):
    change, where, cause = SLIPS[name]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        train(**change)
    texts = [str(each.message) for each in caught if each.category is gb.SceneWarning]
    found = [text for text in texts if text.startswith(f"{where}: ")]
    assert len(found) == 1, texts
    assert cause in found[0]
    assert (
        "usual is" in found[0]
        or "more than a full turn" in found[0]
        or "of the stiffness" in found[0]
    )


@pytest.mark.parametrize(
    "change",
    [
        {"meshes": mesh(centre_distance=112.5)},
        {"gears": gears(profile_shift=20.0)},
        {"gears": gears(profile_shift=-20.0)},
    ],
    ids=str,
)
def test_teeth_that_are_out_of_reach_give_a_warning_or_an_error(change):
    """Either a warning about the value, or an error that the teeth cannot touch."""
    with pytest.raises((gb.SceneError, gb.SceneWarning), match=r"^(meshes|gears)\[0\]"):
        train(**change)


@each_case(
    ("change", "text"),
    [
        (
            {"disks": disk(polar_inertia=0.2)},
            r"^disks\[0\].polar_inertia: .* twice the diametral inertia",
        ),
        (
            {"gears": gears(diametral_inertia=1e-3, polar_inertia=3e-3)},
            r"^gears\[0\].polar_inertia: .*are the two exchanged\?",
        ),
        (
            {"shafts": shaft(bow=gb.Bow.half_sine(0.6))},
            r"^shafts\[0\].bow.amplitude: 0.6 m is more than the length of the shaft",
        ),
        (
            {"shafts": shaft(bow=gb.Bow.points([0.0, 0.5], [0.0, -100.0]))},
            r"^shafts\[0\].bow.amplitudes: 100 m is more",
        ),
        ({"gears": gears(pressure_angle=20.0)}, r"^gears\[0\].pressure_angle: .*in degrees\?"),
    ],
)
def test_impossible_values_are_errors(change, text):
    with pytest.raises(gb.SceneError, match=text):
        train(**change)


def test_idealised_bodies_are_valid():
    train(disks=disk(mass=0.0, diametral_inertia=0.0, polar_inertia=0.1))
    train(disks=disk(mass=1.0, diametral_inertia=0.0, polar_inertia=0.0))
    train(disks=disk(polar_inertia=0.1049))  # a rounded ratio
    with pytest.raises(gb.SceneError, match="polar_inertia"):
        train(disks=disk(polar_inertia=0.1051))


def test_all_lengths_in_millimetres():
    """Every part gives a warning, one for each quantity."""
    k = 1 / MILLIMETRE
    shafts = [gb.Shaft(x, length=500.0, outer_diameter=50.0, elements=2) for x in ("a", "b")]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        gb.RotorSystem(
            shafts=shafts,
            gears=[
                gb.Gear("g1", "a", 0.25 * k, 25, module=3e-3 * k, face_width=0.03 * k),
                gb.Gear("g2", "b", 0.25 * k, 50, module=3e-3 * k, face_width=0.03 * k),
            ],
            meshes=[gb.Mesh("g1", "g2")],
        )
    texts = [str(each.message) for each in caught]
    for where in ("shafts[0].length", "shafts[0].outer_diameter", "gears[0].module"):
        (text,) = [text for text in texts if text.startswith(where)]
        assert "is it in millimetres?" in text
        assert f"(also {where.replace('[0]', '[1]')})" in text


def test_the_warning_has_value_range_and_cause():
    with pytest.warns(gb.SceneWarning) as caught:
        train(modal_damping=2.0)
    assert str(caught[0].message) == (
        "modal_damping: a modal damping ratio is 2, usual is up to 0.5; is it in percent?"
    )


# --- speeds ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "call",
    [
        lambda system, speed: system.simulate(1e-5, speed),
        lambda system, speed: system.simulate(1e-5, ([0.0, 1e-5], [0.0, speed])),
        lambda system, speed: system.synchronous([1.0, -speed]),
        lambda system, speed: system.campbell([0.0, speed], count=2),
    ],
)
def test_too_fast_teeth_give_a_warning(call):
    system = train()
    limit = 250.0 / system.gears[0].module / 25 * 2
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gb.AccuracyWarning)
        call(system, 0.99 * limit)
        with pytest.warns(gb.SceneWarning, match=r'^speed: .*"g.*put" is 25\d.* m/s .*in rpm\?'):
            call(system, 1.01 * limit)


# --- machines -------------------------------------------------------------------------------------


def geared(size: float, module: float, teeth: tuple[int, int], **options: Any) -> gb.RotorSystem:
    """Return a pair of gears on shafts of ten diameters length."""
    return pair(
        ("a", "b"),
        ("ga", "gb"),
        teeth,
        shaft={"length": 10 * size, "outer_diameter": size},
        gear={"module": module, "face_width": 10 * module},
        mesh={"backlash": 0.05 * module},
        bearing={"stiffness": options.pop("bearing", 2e9 * size)},
        torque=0.0,
        gravity=9.81,
        **options,
    )


ONE_BEARING = {"stiffness": 1e8}
SWINGING: dict[str, tuple[dict[str, Any], bool]] = {
    "one bearing": ({}, True),
    "two bearings at one place": ({"bearings": [gb.Bearing("b", 0.1, **ONE_BEARING)] * 2}, True),
    "two bearings": ({"bearings": [gb.Bearing("b", x, **ONE_BEARING) for x in (0.1, 0.4)]}, False),
    "tilting stiffness": (
        {"bearings": [gb.Bearing("b", 0.1, **ONE_BEARING, tilting_stiffness=1e4)]},
        False,
    ),
    "bearing between shafts": (
        {
            "bearings": [
                gb.Bearing("b", 0.1, **ONE_BEARING),
                gb.Bearing("b", 0.5, **ONE_BEARING, support=("a", 0.25)),
            ]
        },
        False,
    ),
    "mesh": (
        {
            "gears": [gb.Gear(f"g{s}", s, 0.3, 25, module=3e-3, face_width=0.03) for s in "ab"],
            "meshes": [gb.Mesh("ga", "gb", stiffness=2e8)],
        },
        False,
    ),
    "coupling": (
        {
            "couplings": [
                gb.Coupling(("a", 0.5), ("b", 0.0), torsional_stiffness=1e4, lateral_stiffness=1e7)
            ]
        },
        False,
    ),
    "torsion": ({"motion": "torsion"}, False),
}


@pytest.mark.parametrize("name", SWINGING)
def test_a_shaft_that_one_bearing_holds_may_swing(name: str):
    changes, swings = SWINGING[name]
    own_speed = None if {"meshes", "couplings"} & changes.keys() else 2.0
    shafts = [
        gb.Shaft(each, length=0.5, outer_diameter=0.05, elements=2, speed_ratio=ratio)
        for each, ratio in (("a", None), ("b", own_speed))
    ]
    held = [gb.Bearing("a", x, **ONE_BEARING) for x in (0.0, 0.5)]
    own = changes.get("bearings", [gb.Bearing("b", 0.1, **ONE_BEARING)])
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        gb.RotorSystem(shafts, **{**changes, "bearings": [*held, *own]})
    message = (
        'shafts[1]: the bearing at 0.1 m alone holds "b", which may swing about it; add a bearing, '
        "or give tilting_stiffness"
    )
    assert [str(each.message) for each in caught] == ([message] if swings else [])


@pytest.mark.parametrize("path", ROTORS, ids=lambda path: path.stem)
def test_no_published_rotor_is_implausible(path):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        gb.RotorSystem.load(path)
    # Rao's radii are rounded; no other warning
    assert all("base pitch" in str(each.message) for each in caught)


def test_the_reference_scenes_are_plausible():
    scenes.v2()
    scenes.v3()


def test_a_watch():
    geared(5e-4, 1e-4, (80, 20))


def test_a_car():
    geared(0.03, 2.5e-3, (21, 43))


def test_a_wind_turbine():
    geared(0.6, 18e-3, (23, 97))


def test_the_drive_of_a_ship():
    geared(0.5, 12e-3, (40, 300))


def test_a_turbogenerator():
    shaft = gb.Shaft("rotor", length=12.0, outer_diameter=1.1, elements=8)
    bearings = [gb.Bearing("rotor", x, stiffness=(1e9, 2e9), damping=1e6) for x in (0.5, 11.5)]
    gb.RotorSystem([shaft], bearings=bearings, gravity=9.81, modal_damping=0.01)


def test_a_turbocharger():
    shaft = gb.Shaft("rotor", length=0.12, outer_diameter=0.008, elements=6)
    gb.RotorSystem(
        [shaft],
        bearings=[gb.Bearing("rotor", x, stiffness=1e6, damping=50.0) for x in (0.04, 0.08)],
        disks=[
            gb.Disk("turbine", "rotor", 0.12, 0.25, 2.5e-5, 4e-5, unbalance=1e-7),
            gb.Disk("compressor", "rotor", 0.0, 0.1, 1.2e-5, 2e-5, unbalance=1e-7),
        ],
    )


def test_a_test_rig():
    shaft = gb.Shaft("rotor", length=0.6, outer_diameter=0.01, elements=6)
    gb.RotorSystem(
        [shaft],
        bearings=[gb.Bearing("rotor", x, stiffness=1e6) for x in (0.05, 0.55)],
        disks=[gb.Disk("disk", "rotor", 0.3, 0.8, 3e-4, 5.5e-4, unbalance=2e-5)],
    )


def test_a_hydroelectric_set():
    shaft = gb.Shaft("rotor", length=15.0, outer_diameter=1.8, elements=6)
    gb.RotorSystem(
        [shaft],
        bearings=[gb.Bearing("rotor", x, stiffness=2e9) for x in (2.0, 8.0, 14.0)],
        disks=[gb.Disk("generator", "rotor", 5.0, 9e5, 1.4e7, 2.6e7)],
    )


def test_rotors_with_magnetic_bearings_and_polymer_gears():
    shaft = gb.Shaft("rotor", length=0.8, outer_diameter=0.08, elements=6)
    gb.RotorSystem([shaft], bearings=[gb.Bearing("rotor", x, stiffness=1e6) for x in (0.1, 0.7)])
    nylon = gb.Material(2.8e9, 1150.0, poisson_ratio=0.4)
    soft = geared(0.01, 1e-3, (20, 40), bearing=1e6)
    soft.replace(
        shafts=[replace(shaft, material=nylon) for shaft in soft.shafts],
        meshes=[gb.Mesh("ga", "gb", stiffness=2e6)],
    )


def test_a_shaft_without_mass():
    massless = gb.Material(207e9, 1.0, **STEEL)
    train(shafts=shaft(material=massless), disks=disk())
    train(shafts=shaft(material=replace(massless, density=1e-3)), disks=disk())


def test_angles_up_to_one_revolution_are_plausible():
    train(meshes=mesh(centre_line_angle=2 * math.pi))
    train(meshes=mesh(centre_line_angle=-np.pi))
