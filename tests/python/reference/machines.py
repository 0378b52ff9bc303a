"""The machines of the tests: trains, pairs of gears and single rotors.

`train`, `pair` and `rotor` build a machine from what differs from the defaults below; the functions
after them name machines of more than one test.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from itertools import pairwise
from math import acos, atan, atan2, cos, pi, radians, sin, tan
from typing import Any

import numpy as np
from scipy.optimize import brentq

import gearbow as gb

Fields = Mapping[str, Any]

SHAFTS = ("input", "output")
NOTHING: Fields = {}
SHAFT: Fields = {"length": 0.5, "outer_diameter": 0.05, "elements": 2}
TOOTH: Fields = {"module": 3e-3, "face_width": 0.03}
MESH: Fields = {"stiffness": 2e8, "damping_ratio": 0.05}
BEARING: Fields = {"stiffness": 1e8, "damping": 500.0}
#: Meshes and bearings of a machine without damping.
UNDAMPED: Fields = {"mesh": {"stiffness": 2e8}, "bearing": {"stiffness": 1e8}}
#: A light material, whose shaft is a spring.
LIGHT = gb.Material(207e9, 1.0, poisson_ratio=0.3)
#: A shaft without mass, the disk in its middle [kg], its stiffness there and that of each bearing [N/m].
MASSLESS: Fields = {
    "name": "s",
    "length": 0.8,
    "outer_diameter": 0.03,
    "elements": 2,
    "degree": 1,
    "shear": False,
    "material": gb.Material(2.06e11, 1e-3, poisson_ratio=0.3),
}
DISK_MASS = 10.0
BENDING_STIFFNESS = 48.0 * 2.06e11 * pi * 0.03**4 / 64.0 / 0.8**3
RIGID = 1e10
#: An oil film for shafts of 50 mm.
OIL: Fields = {"diameter": 0.05, "length": 0.02, "clearance": 5e-5, "viscosity": 0.02}


def train(
    shafts: Iterable[str],
    gears: Iterable[tuple[str, str, float, int]],
    meshes: Iterable[tuple[str, str]],
    /,
    *,
    shaft: Fields = NOTHING,
    gear: Fields = NOTHING,
    mesh: Fields = MESH,
    bearing: Fields | None = BEARING,
    own: Mapping[str, Fields] = NOTHING,
    torque: float = 250.0,
    **parts: Any,
) -> gb.RotorSystem:
    """Build shafts on end bearings with gears (name, shaft, position, teeth) and a balanced torque.

    `shaft` and `gear` are fields beyond the defaults, `mesh` and `bearing` all fields of each mesh and
    bearing, and `own` further fields of one shaft, gear or mesh ("driver/driven") by its name.
    `parts` are options of the system and lists of parts, which replace those made here.
    """
    built = [gb.Shaft(name, **{**SHAFT, **shaft, **own.get(name, {})}) for name in shafts]
    geared = [
        gb.Gear(name, on, x, teeth, **{**TOOTH, **gear, **own.get(name, {})})
        for name, on, x, teeth in gears
    ]
    given: dict[str, Any] = {
        "shafts": built,
        "gears": geared,
        "meshes": [gb.Mesh(*names, **{**mesh, **own.get("/".join(names), {})}) for names in meshes],
        "bearings": at_ends(built, **bearing) if bearing is not None else [],
    }
    if torque:
        given["torques"] = [gb.Torque(geared[0].name, torque), gb.Torque.balance(geared[-1].name)]
    return gb.RotorSystem(**{**given, **parts})


def at_ends(shafts: Iterable[gb.Shaft], **bearing: Any) -> list[gb.Bearing]:
    """Build equal bearings at both ends of each shaft."""
    return [gb.Bearing(one.name, x, **bearing) for one in shafts for x in (0.0, one.length)]


def pair(
    shafts: tuple[str, str] = SHAFTS,
    gears: tuple[str, str] = ("g1", "g2"),
    teeth: tuple[int, int] = (25, 50),
    /,
    *,
    position: float | None = None,
    shaft: Fields = NOTHING,
    **more: Any,
) -> gb.RotorSystem:
    """Build two shafts with one gear each, at mid-length unless a position is given."""
    place = {**SHAFT, **shaft}["length"] / 2 if position is None else position
    on = [(gear, name, place, z) for gear, name, z in zip(gears, shafts, teeth, strict=True)]
    return train(shafts, on, [gears], shaft=shaft, **more)


def double_stage(**more: Any) -> gb.RotorSystem:
    """Build the double-stage train of the study of accuracy and cost."""
    gears = [
        ("g1", "input", 0.25, 25),
        ("g2", "middle", 0.125, 50),
        ("g3", "middle", 0.375, 25),
        ("g4", "output", 0.25, 50),
    ]
    return train(("input", "middle", "output"), gears, [("g1", "g2"), ("g3", "g4")], **more)


def rotor(
    shaft: Fields = NOTHING,
    disk: Fields | None = None,
    bearing: Fields | None = None,
    **parts: Any,
) -> gb.RotorSystem:
    """Build a shaft on end bearings, with a disk at mid-length if its fields are given."""
    size = {"name": "rotor", "length": 1.0, "outer_diameter": 0.05, "elements": 4, **shaft}
    built = gb.Shaft(**size)
    given: dict[str, Any] = {
        "shafts": [built],
        "bearings": at_ends([built], **(bearing or {"stiffness": 1e8})),
    }
    if disk is not None:
        place = {"name": "disk", "shaft": built.name, "position": size["length"] / 2}
        given["disks"] = [gb.Disk(**{**place, **disk})]
    return gb.RotorSystem(**{**given, **parts})


def inertia(mass: float, diametral: float, polar: float, **more: Any) -> dict[str, Any]:
    """Name the mass [kg] and the moments of inertia [kg m²] of a disk or gear."""
    return {"mass": mass, "diametral_inertia": diametral, "polar_inertia": polar, **more}


# --- the default machine of the tests -------------------------------------------------------------


def hostile(**changes: Any) -> gb.RotorSystem:
    """Build the default machine of the tests, no two parts of which are alike.

    "input" drives "idler", "middle" and "output". The latter lies on the axis of "input" and has a
    bearing on its end. Tooth numbers are primes, and no speed ratio is 1. Every bow, unbalance, face
    width, bearing and angle has a value of its own. One mesh has run-out, another profile shift and
    transmission error. The torques act at places without gear or bearing.
    """
    bows = {
        "input": (1e-4, 0.3),
        "idler": (4e-5, 1.1),
        "middle": (7e-5, -2.0),
        "output": (5e-5, 2.5),
    }
    sizes = {"input": (0.36, 0.04, 3), "idler": (0.25, 0.045, 2), "middle": (0.5, 0.05, 4)}
    shafts = [
        gb.Shaft(
            name,
            length=length,
            outer_diameter=diameter,
            inner_diameter=0.01 if name == "middle" else 0.0,
            elements=elements,
            bow=gb.Bow.half_sine(*bows[name]),
        )
        for name, (length, diameter, elements) in (sizes | {"output": (0.3, 0.06, 2)}).items()
    ]
    geared = [
        ("g1", "input", 0.21, 23, 0.034, {"helix_angle": 0.3, "runout": 3e-6 + 2.5e-6j}),
        ("g2", "idler", 0.13, 31, 0.03, {"helix_angle": -0.3}),
        ("g3", "middle", 0.12, 47, 0.027, {"helix_angle": 0.3}),
        ("g4", "middle", 0.35, 29, 0.04, {"helix_angle": -0.2, "profile_shift": 0.4}),
        ("g5", "output", 0.08, 53, 0.036, {"helix_angle": 0.2, "profile_shift": 0.15}),
    ]
    gears = {
        name: gb.Gear(
            name,
            on,
            x,
            teeth,
            module=3e-3,
            face_width=width,
            unbalance=1e-4 * i * np.exp(1j * i),
            **more,
        )
        for i, (name, on, x, teeth, width, more) in enumerate(geared, 1)
    }
    meshed = (("g1", "g2"), ("g2", "g3"), ("g4", "g5"))
    a, b, c = (distance_without_play(gears[one], gears[other]) for one, other in meshed)
    # the lines of centres close a triangle: "output" returns to the axis of "input"
    first = 0.5
    second = first + pi - acos((a**2 + b**2 - c**2) / (2 * a * b))
    y, z = (a * f(first) + b * f(second) for f in (cos, sin))
    error = gb.TransmissionError(tooth=[(2e-6, 0.4)], driver=[(5e-6, 0.8)], driven=[(3e-6, -1.0)])
    film = [[[8e7, 1e7], [-5e6, 6e7]], [[1.2e8, 2e7], [-1.5e7, 9e7]], [[1.5e8, 3e7], [-2e7, 1e8]]]
    given: dict[str, Any] = {
        "shafts": shafts,
        "gears": list(gears.values()),
        "meshes": [
            gb.Mesh(
                *names, stiffness=k, damping_ratio=zeta, centre_line_angle=angle, error=own_error
            )
            for names, k, zeta, angle, own_error in zip(
                meshed,
                (2e8, 1.7e8, 2.4e8),
                (0.05, 0.04, 0.06),
                (first, second, atan2(-z, -y)),
                (None, None, error),
                strict=True,
            )
        ],
        "bearings": [
            gb.Bearing(
                on,
                x,
                stiffness=k,
                damping=c,
                axial_stiffness=along,
                axial_damping=1e-5 * along,
                **on_,
            )
            for on, x, k, c, along, on_ in (
                ("input", 0.0, 1.1e8, 550.0, 3e7, {}),
                ("idler", 0.25, 1.3e8, 400.0, 0.0, {}),
                ("middle", 0.0, 1.5e8, 450.0, 4e7, {}),
                ("output", 0.3, 2e8, 850.0, 5e7, {}),
                ("input", 0.3, (8e7, 6e7), [[900.0, 50.0], [70.0, 700.0]], 0.0, {}),
                ("idler", 0.0, (9e7, 1.2e8), (600.0, 500.0), 2e7, {}),
                ("middle", 0.5, gb.SpeedTable([0.0, 40.0, 400.0], film, "hold"), 650.0, 0.0, {}),
                ("output", 0.0, (7e7, 5e7), 350.0, 1e7, {"support": ("input", 0.36)}),
            )
        ],
        "torques": [gb.Torque(("input", 0.07), 150.0), gb.Torque(("output", 0.17), "balance")],
    }
    return gb.RotorSystem(**{**given, **changes})


def mirrored(system: gb.RotorSystem) -> gb.RotorSystem:
    """Make the mirror image of a hostile machine: every y becomes -y.

    A mirror reverses rotations: at -Ω the image has the mirrored motion of the machine at Ω.
    """

    def turned(phasor: complex) -> complex:
        return -phasor.conjugate()

    def crossed(coefficient: Any) -> Any:
        is_table = isinstance(coefficient, gb.SpeedTable)
        values = np.asarray(coefficient.values if is_table else coefficient)
        if values.ndim == 2 + is_table:
            values = values * [[1.0, -1.0], [-1.0, 1.0]]
        return replace(coefficient, values=values.tolist()) if is_table else values.tolist()

    def bent(bow: gb.Bow) -> gb.Bow:
        return replace(bow, phase=pi - bow.phase)

    def late(error: gb.TransmissionError) -> gb.TransmissionError:
        harmonics = {
            name: [(size, -phase) for size, phase in getattr(error, name)]
            for name in ("tooth", "driver", "driven")
        }
        return replace(error, **harmonics)

    return system.replace(
        shafts=[replace(shaft, bow=bent(shaft.bow)) for shaft in system.shafts],
        gears=[
            replace(
                gear,
                helix_angle=-gear.helix_angle,
                unbalance=turned(gear.unbalance),
                runout=turned(complex(gear.runout)),
            )
            for gear in system.gears
        ],
        meshes=[
            replace(
                mesh,
                centre_line_angle=pi - mesh.centre_line_angle,
                error=mesh.error and late(mesh.error),
            )
            for mesh in system.meshes
        ],
        bearings=[
            replace(each, stiffness=crossed(each.stiffness), damping=crossed(each.damping))
            for each in system.bearings
        ],
        torques=[
            replace(each, value=each.value if each.value == "balance" else -each.value)
            for each in system.torques
        ],
    )


def rated(system: gb.RotorSystem) -> gb.RotorSystem:
    """Give every linear bearing load ratings, each others."""
    bearings = [
        replace(one, dynamic_rating=3e4 + 1e3 * i, static_rating=2e4)
        if isinstance(one, gb.Bearing)
        else one
        for i, one in enumerate(system.bearings)
    ]
    return system.replace(bearings=bearings)


#: A point of measurement of the default machine away from gears, bearings and nodes.
BETWEEN = ("middle", 0.2137)


def distance_without_play(a: gb.Gear, b: gb.Gear) -> float:
    """Give the centre distance [m] of two helical gears with profile shift, by ISO 21771."""
    assert a.module is not None
    teeth, shift = a.teeth + b.teeth, a.profile_shift + b.profile_shift
    angle = atan(tan(a.pressure_angle) / cos(a.helix_angle))
    wanted = tan(angle) - angle + 2 * tan(a.pressure_angle) * shift / teeth
    working = brentq(lambda x: tan(x) - x - wanted, 0.1, 1.0, xtol=1e-15)
    return a.module * teeth / cos(a.helix_angle) / 2 * cos(angle) / cos(float(working))


# --- pairs of gears -------------------------------------------------------------------------------


def bowed_pair(
    bow: gb.Bow | float = 1e-4, teeth: tuple[int, int] = (25, 50), **more: Any
) -> gb.RotorSystem:
    """Build a pair whose input shaft has a bow, or an amplitude [m] of a half sine."""
    shape = bow if isinstance(bow, gb.Bow) else gb.Bow.half_sine(bow) if bow else None
    return pair(SHAFTS, ("g1", "g2"), teeth, own={"input": {"bow": shape}}, **more)


def toothed_pair(
    elements: int | None = 2,
    *,
    stiffness: Any = None,
    torque: float = 100.0,
    backlash: float | None = None,
    **options: Any,
) -> gb.RotorSystem:
    """Build a pair of bowed shafts with modal damping and teeth of varying stiffness."""
    return pair(
        SHAFTS,
        ("g1", "g2"),
        (23, 37),
        shaft={
            "length": 0.4,
            "outer_diameter": 0.05,
            "elements": elements,
            "bow": gb.Bow.half_sine(1e-4),
        },
        own={"input": {"outer_diameter": 0.04}},
        mesh={
            **MESH,
            "stiffness": stiffness or gb.Stiffness.parabolic(1.5e8),
            "backlash": backlash,
        },
        torque=torque,
        modal_damping=0.02,
        **options,
    )


def separating_pair(
    bow: float, backlash: float | None = 4e-4, torque: float = 10.0
) -> gb.RotorSystem:
    """Build a pair whose bow [m] moves the centres and unloads the teeth."""
    bent = {"outer_diameter": 0.04, "bow": gb.Bow.half_sine(bow)}
    return pair(
        SHAFTS,
        ("pinion", "wheel"),
        position=0.2,
        shaft={"elements": 4},
        own={"input": bent},
        mesh={**MESH, "backlash": backlash},
        bearing={"stiffness": 1e8, "damping": 2e3},
        torque=torque,
    )


def helical_pair(helix: float = radians(20.0), /, **changes: Any) -> gb.RotorSystem:
    """Build a helical pair off the middles of a bowed input shaft and a straight output shaft."""
    bearing = {**BEARING, "axial_stiffness": 3e7, "axial_damping": 400.0}
    return pair(
        position=0.15,
        shaft={"length": 0.4, "degree": 1},
        own={
            "input": {"bow": gb.Bow.half_sine(1e-4, phase=0.3)},
            "output": {"outer_diameter": 0.06},
            "g1": {"helix_angle": helix, "unbalance": 1e-4},
            "g2": {"helix_angle": -helix},
        },
        mesh={**MESH, "centre_line_angle": 0.4, **changes.pop("mesh", {})},
        bearing=bearing | changes.pop("bearing", {}),
        torque=200.0,
        **changes,
    )


def pair_on_housing(**changes: Any) -> gb.RotorSystem:
    """Build a pair with a bowed input shaft on a housing, and an output shaft on supports."""
    box = gb.Housing(
        "box",
        mass=30.0,
        inertia=(0.5, 0.6, 0.7),
        position=(0.2, 0.0, 0.0),
        stiffness=3e8,
        damping=3e3,
        rotational_stiffness=(1e7, 1e7, 1e7),
        rotational_damping=(50.0, 50.0, 50.0),
        points={"corner": (0.4, 0.1, 0.1)},
    )
    parts: dict[str, Any] = {
        "bearings": [
            gb.Bearing(shaft, x, **BEARING, support=support)
            for shaft, support in (("input", "box"), ("output", "foot"))
            for x in (0.0, 0.4)
        ],
        "supports": [gb.Support(stiffness=2e8, damping=2e3, mass=20.0, name="foot")],
        "housings": [box],
    }
    square = gb.Stiffness.square(2e8, engagement=0.3)
    return pair(
        shaft={"length": 0.4, "degree": 1},
        own={
            "input": {"bow": gb.Bow.half_sine(5e-5)},
            "output": {"outer_diameter": 0.06},
            "g1": {"unbalance": 1e-4},
        },
        mesh={**MESH, "stiffness": square, **changes.pop("mesh", {})},
        torque=200.0,
        **{**parts, **changes},
    )


def pair_with_motor(**changes: Any) -> gb.RotorSystem:
    """Build a pair between a motor and a load on a soft drive."""
    parts: dict[str, Any] = {
        "disks": [
            gb.Disk("motor", "input", 0.0, 4.0, 0.01, 0.02),
            gb.Disk("load", "output", 0.5, 6.0, 0.02, 0.04),
        ],
        "bearings": [
            gb.Bearing(name, x, **BEARING) for name in ("input", "output") for x in (0.1, 0.4)
        ],
        "drives": [gb.Drive("load", stiffness=1e5, damping=5.0)],
        "torques": [gb.Torque("motor", 100.0), gb.Torque("load", -200.0)],
    }
    return pair(shaft={"outer_diameter": 0.04, "elements": None}, **{**parts, **changes})


def twisting_pair(
    *, driver: Fields = NOTHING, centre_distance: float | None = None, **mesh: Any
) -> gb.RotorSystem:
    """Build two stiff shafts with torsion only and one mesh under torque."""
    return pair(
        shaft={"length": 0.1, "elements": 1},
        own={"g1": driver},
        mesh={"centre_distance": centre_distance, **mesh},
        bearing=None,
        torque=50.0,
        motion="torsion",
    )


def short_pair(
    gears: tuple[str, str] = ("ga", "gb"), teeth: tuple[int, int] = (25, 50), /, **more: Any
) -> gb.RotorSystem:
    """Build a pair amid the short shafts "a" and "b", which hardly bend."""
    shaft = {"length": 0.2, "outer_diameter": 0.03, **more.pop("shaft", {})}
    return pair(("a", "b"), gears, teeth, shaft=shaft, **more)


def pair_with_two_ranges(
    ranges: Mapping[str, tuple[float, float]], outside: str = "error"
) -> gb.RotorSystem:
    """Build a pair whose shafts run in bearings with tables of these ranges of speed [rad/s]."""
    bearings = [
        gb.Bearing(
            name,
            x,
            stiffness=gb.SpeedTable(list(speeds), [5e6, 2e7], outside=outside),
            damping=1e3,
        )
        for name, speeds in ranges.items()
        for x in (0.0, 0.5)
    ]
    return pair(
        ("a", "b"),
        ("ga", "gb"),
        (25, 32),
        shaft={"outer_diameter": 0.03, "bow": gb.Bow.half_sine(1e-5)},
        gear={"face_width": None, **inertia(2.0, 2e-3, 4e-3)},
        mesh={"stiffness": 1e8, "damping_ratio": 0.03},
        bearings=bearings,
        torque=10.0,
    )


# --- trains ---------------------------------------------------------------------------------------


def bowed_double_stage(
    elements: int | None = 4,
    *,
    bow: gb.Bow | None = None,
    engagement: str | float = "sharp",
    **more: Any,
) -> gb.RotorSystem:
    """Build the double-stage train with bowed shafts and teeth whose stiffness jumps."""
    square = gb.Stiffness.square(pair=2e8, engagement=engagement)
    return double_stage(
        shaft={"elements": elements, "bow": bow or gb.Bow.half_sine(1.5e-4, phase=0.3)},
        **{**more, "mesh": {**more.get("mesh", {"damping_ratio": 0.05}), "stiffness": square}},
    )


def reverted_train() -> gb.RotorSystem:
    """Build a double-stage train with input and output shaft on one axis."""
    gears = [
        ("g1", "input", 0.2, 25),
        ("g2", "middle", 0.15, 50),
        ("g3", "middle", 0.35, 25),
        ("g4", "output", 0.1, 50),
    ]
    return train(
        ("input", "middle", "output"),
        gears,
        [("g1", "g2"), ("g3", "g4")],
        shaft={"length": 0.3, "elements": None},
        own={
            "input": {"outer_diameter": 0.04},
            "middle": {"length": 0.5, "bow": gb.Bow.half_sine(1e-4, 1.0)},
            "g3/g4": {"centre_line_angle": pi},
        },
        mesh={"stiffness": 2e8},
        bearing={"stiffness": 1e8},
    )


def star(pinions: int = 4) -> gb.RotorSystem:
    """Build pinions around one wheel, which has a drive."""
    names = [f"pinion shaft {i}" for i in range(pinions)]
    gears = [(f"p{i}", name, 0.2, 20 + i) for i, name in enumerate(names)]
    meshes = [
        gb.Mesh(f"p{i}", "wheel", stiffness=2e8, centre_line_angle=i * pi / 2)
        for i in range(pinions)
    ]
    return train(
        ("wheel shaft", *names),
        [("wheel", "wheel shaft", 0.3, 100), *gears],
        (),
        shaft={"length": 0.4, "elements": None},
        own={"wheel shaft": {"length": 0.6, "outer_diameter": 0.1}},
        bearing={"stiffness": 1e8},
        meshes=meshes,
        torques=[*(gb.Torque(f"p{i}", 100.0) for i in range(pinions)), gb.Torque.balance("wheel")],
        drives=[gb.Drive("wheel", 1e5)],
    )


def chain(count: int = 6) -> gb.RotorSystem:
    """Build a train of many bowed shafts."""
    names = [f"shaft {i}" for i in range(count)]
    gears, meshes = [], []
    for i, (driver, driven) in enumerate(pairwise(names)):
        x = 0.15 if i % 2 else 0.35
        gears += [(f"a{i}", driver, x, 25), (f"b{i}", driven, x, 40)]
        angle = 0.5 if i % 2 else -0.5
        meshes.append(gb.Mesh(f"a{i}", f"b{i}", stiffness=2e8, centre_line_angle=angle))
    return train(
        names,
        gears,
        (),
        shaft={"elements": None},
        own={name: {"bow": gb.Bow.half_sine(1e-4, i - 4.0)} for i, name in enumerate(names)},
        bearing={"stiffness": 1e8},
        torque=0.0,
        meshes=meshes,
    )


# --- single rotors --------------------------------------------------------------------------------


def bowed_rotor(**parts: Any) -> gb.RotorSystem:
    """Build a bowed shaft on damped bearings, without a disk."""
    bent = {"elements": 2, "bow": gb.Bow.half_sine(1e-4)}
    return rotor(bent, bearing={"stiffness": 1e8, "damping": 1e3}, **parts)


def bowed_rotor_with_disk(**changes: Any) -> gb.RotorSystem:
    """Build a bowed shaft with an unbalanced disk on isotropic bearings."""
    bent = {"outer_diameter": 0.06, "elements": 2, "bow": gb.Bow.half_sine(1e-4, phase=0.4)}
    return rotor(bent, inertia(20.0, 0.1, 0.2, unbalance=1e-4j), BEARING, **changes)


def jeffcott(
    damping: float = 400.0, bow: complex = 0.0, eccentricity: complex = 1e-5
) -> gb.RotorSystem:
    """Build a disk of 20 kg on a light shaft between stiff bearings, with damping at the disk."""
    bent = gb.Bow.half_sine(abs(bow), phase=float(np.angle(bow))) if bow else None
    return rotor(
        {"name": "s", "elements": 2, "material": LIGHT, "bow": bent},
        inertia(20.0, 0.1, 0.2, unbalance=20.0 * eccentricity),
        bearings=[
            *(gb.Bearing("s", x, stiffness=1e10) for x in (0.0, 1.0)),
            gb.Bearing("s", 0.5, stiffness=0.0, damping=damping),
        ],
    )


def massless_rotor(
    shaft: Fields = NOTHING, *, damping: float = 0.0, unbalance: complex = 0.0, **parts: Any
) -> gb.RotorSystem:
    """Build a disk "d" amid a shaft without mass on rigid bearings, with damping at the disk [N s/m].

    The shaft has 6e-8 of the mass of the disk, and the bearings give way by 4e-5 of the deflection.
    """
    length = MASSLESS["length"]
    return rotor(
        {**MASSLESS, **shaft},
        inertia(DISK_MASS, 1e-3, 1e-3, name="d", unbalance=unbalance),
        bearings=[
            *(gb.Bearing("s", x, stiffness=RIGID) for x in (0.0, length)),
            gb.Bearing("s", length / 2, stiffness=0.0, damping=damping),
        ],
        **{"motion": "lateral", **parts},
    )


def two_disks_in_torsion() -> gb.RotorSystem:
    """Build a free shaft of almost no mass between disks of 0.02 and 0.05 kg m², in torsion."""
    material = gb.Material(207e9, 1e-3, poisson_ratio=0.3)
    disks = [
        gb.Disk(f"d{i}", "s", x, **inertia(5.0, 0.01, polar))
        for i, (x, polar) in enumerate([(0.0, 0.02), (0.5, 0.05)])
    ]
    shaft = {"name": "s", "length": 0.5, "outer_diameter": 0.03, "elements": 1}
    return rotor({**shaft, "material": material}, disks=disks, bearings=[], motion="torsion")


def rotor_with_two_disks() -> gb.RotorSystem:
    """Build a bowed shaft with two disks, one of them with unbalance, on different bearings."""
    return rotor(
        {"name": "s", "elements": 6, "bow": gb.Bow.half_sine(1e-4, phase=0.6)},
        bearing={"stiffness": (2e7, 3e7), "damping": 4e3},
        disks=[
            gb.Disk("a", "s", 0.3, 20.0, 0.1, 0.2, unbalance=1e-3j),
            gb.Disk("b", "s", 0.7, 30.0, 0.2, 0.4),
        ],
        modal_damping=0.02,
    )


def rotor_on_pedestal(**parts: Any) -> gb.RotorSystem:
    """Build a bowed shaft with two disks, one bearing of which stands on a support of its own."""
    pedestal = gb.Support("pedestal", mass=10.0, stiffness=1e8)
    return rotor(
        {
            "length": 1.2,
            "outer_diameter": 0.06,
            "elements": None,
            "bow": gb.Bow.half_sine(1e-4, 0.5),
        },
        disks=[
            gb.Disk("left", "rotor", 0.4, 12.0, 0.05, 0.1),
            gb.Disk("right", "rotor", 0.8, 12.0, 0.05, 0.1),
        ],
        bearings=[
            gb.Bearing("rotor", 0.05, stiffness=1e8, support=pedestal),
            gb.Bearing("rotor", 1.15, stiffness=1e8),
        ],
        **parts,
    )


def rotor_on_films(**changes: Any) -> gb.RotorSystem:
    """Build a disk of 40 kg amid a shaft on two oil films."""
    films = [gb.JournalBearing("r", x, **OIL) for x in (0.0, 0.5)]
    return rotor(
        {"name": "r", "length": 0.5},
        inertia(40.0, 0.5, 0.3, name="d", unbalance=4e-4),
        **{"bearings": films, "gravity": 9.81, **changes},
    )


def long_shaft(elements: int) -> gb.RotorSystem:
    """Build a disk of 20 kg amid a shaft with many elements."""
    return rotor(
        {"name": "s", "elements": elements, "degree": 1},
        inertia(20.0, 0.1, 0.2, name="d", unbalance=1e-4),
        {"stiffness": 1e7, "damping": 100.0},
        gravity=(0.0, -9.81),
    )


def stepped_rotor() -> gb.RotorSystem:
    """Build a stepped shaft with a disk on bearings that are softer along y."""
    segments = [gb.Segment(0.3, 0.04, elements=2), gb.Segment(0.5, 0.06, elements=2)]
    return gb.RotorSystem(
        [gb.Shaft("s", segments=segments)],
        disks=[gb.Disk("disk", "s", 0.3, 10.0, 0.05, 0.1)],
        bearings=[gb.Bearing("s", x, stiffness=(1e6, 2e6), damping=3e2) for x in (0.0, 0.8)],
        motion="lateral",
    )


def rigid_rotor(disk: Fields, bearing: Fields, name: str = "rotor", **parts: Any) -> gb.RotorSystem:
    """Build a disk amid a short shaft, which is far stiffer than its bearings."""
    short = {"name": name, "length": 0.2, "outer_diameter": 0.1, "elements": 2}
    return rotor(short, disk, bearing, **parts)


def whirling_rotor() -> gb.RotorSystem:
    """Build a disk of 5 kg amid a shaft on two bearings that make it whirl."""
    return rotor(
        {"length": 0.4, "outer_diameter": 0.04, "elements": None},
        inertia(5.0, 0.02, 0.01, unbalance=1e-4),
        cross_coupled(1e7, 434838.0, 3.32),
    )


def cross_coupled(stiffness: float, cross: float, damping: float) -> dict[str, Any]:
    """Give the fields of a bearing whose cross-coupling pushes a rotor into a forward whirl."""
    return {"stiffness": [[stiffness, cross], [-cross, stiffness]], "damping": damping}


def uneven_train(**changes: Any) -> gb.RotorSystem:
    """Build three helical shafts in a bent line, of which no two parts are equal.

    Only the second mesh has a transmission error.
    """
    widths = {"pinion": 0.03, "idler": 0.042, "wheel": 0.035}
    angles = {"pinion": radians(17.0), "idler": -radians(17.0), "wheel": radians(17.0)}
    own: dict[str, Fields] = {
        name: {"face_width": widths[name], "helix_angle": angles[name]} for name in widths
    }
    own |= {
        "a": {"length": 0.36, "outer_diameter": 0.042},
        "b": {"length": 0.5, "outer_diameter": 0.055},
        "c": {"length": 0.44, "outer_diameter": 0.061},
        "pinion/idler": {"stiffness": 2.3e8, "centre_line_angle": 0.3},
        "idler/wheel": {
            "centre_line_angle": 1.9,
            "error": gb.TransmissionError(tooth=[(2e-6, 0.4)]),
        },
    }
    bearing = {
        "stiffness": (1.1e8, 0.7e8),
        "damping": 4e3,
        "axial_stiffness": 6e7,
        "axial_damping": 8e3,
    }
    gears = [("pinion", "a", 0.13, 23), ("idler", "b", 0.22, 31), ("wheel", "c", 0.3, 41)]
    given: dict[str, Any] = {
        "shaft": {"elements": 2, "degree": 2},
        "mesh": {"stiffness": 1.7e8, "damping_ratio": 0.08},
        "bearing": bearing,
        "torque": 180.0,
        "rayleigh": (80.0, 2e-5),
    }
    meshes = [("pinion", "idler"), ("idler", "wheel")]
    return train(("a", "b", "c"), gears, meshes, own=own, **{**given, **changes})


def without_tooth_errors(system: gb.RotorSystem) -> gb.RotorSystem:
    """Leave out what the independent forces of bow and unbalance do not contain; random machines check it beside runs."""
    gears = [replace(gear, runout=0.0) for gear in system.gears]
    meshes = [replace(mesh, error=None) for mesh in system.meshes]
    return system.replace(gears=gears, meshes=meshes)
