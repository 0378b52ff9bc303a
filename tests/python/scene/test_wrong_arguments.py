"""Each argument of each public function and method with wrong values: an error of gearbow names the argument."""

from __future__ import annotations

import inspect
import json
import re
import warnings
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference.cases import each_case
from reference.machines import bowed_pair, rated

pytestmark = pytest.mark.implausible
pytest.importorskip("matplotlib")
pytest.importorskip("pandas")
pytest.importorskip("xarray")


def empty(*_: object, **__: object) -> list[object]:
    return []


#: Values that no argument takes, or that only some arguments take.
WRONG: dict[str, Any] = {
    "array": np.array([1.0, 2.0, 3.0]),
    "empty list": [],
    "True": True,
    "text": "x",
    "object": object(),
    "nan": float("nan"),
    "2**70": 2**70,
    "bytes": b"x",
    "number": -1.5,
    "list of None": [None],
    "function": empty,
}


@cache
def system() -> gb.RotorSystem:
    return rated(bowed_pair())


def lossy() -> gb.RotorSystem:
    meshes = [replace(mesh, friction=0.05) for mesh in system().meshes]
    return system().replace(meshes=meshes)


@cache
def response() -> gb.Response:
    record = ["gears", "meshes", "bearings", "energy", "acceleration"]
    return system().simulate(0.15, 100.0, output_step=2e-4, record=record)


def point(x: float) -> float:
    return x


def measure(made: gb.RotorSystem, **_: object) -> float:
    return made.modes(count=1).frequencies_hz[0]


@cache
def sweep() -> gb.Sweep:
    return gb.sweep(lambda x: system(), {"x": [1.0, 2.0]}, measure)  # noqa: ARG005


@cache
def branch() -> gb.Continuation:
    return system().continuation("speed", 100.0, 100.5, max_points=3, first_step=1.1)


@cache
def steady() -> gb.SteadyState:
    return system().steady_state(100.0)


@cache
def tradeoff() -> gb.results.Tradeoff:
    few: dict[str, Any] = {"methods": ["exponential"], "elements": (), "repeats": 1, "budget": 5.0}
    return system().tradeoff(2e-3, 100.0, frozen=False, mean_stiffness=False, **few)


def with_part(name: str) -> Callable[..., object]:
    """Make a part, and a system with it, which checks its values."""
    key = {
        "Bearing": "bearings",
        "Coupling": "couplings",
        "Disk": "disks",
        "Drive": "drives",
        "Force": "forces",
        "Gear": "gears",
        "Housing": "housings",
        "JournalBearing": "bearings",
        "Mesh": "meshes",
        "RollingBearing": "bearings",
        "Shaft": "shafts",
        "Support": "supports",
        "TiltingPadBearing": "bearings",
        "Torque": "torques",
    }[name]

    def make(**given: Any) -> object:
        part = getattr(gb, name)(**given)
        if key in ("gears", "meshes", "shafts"):
            return system().replace(**{key: [part, *getattr(system(), key)[1:]]})
        return system().replace(**{key: [*getattr(system(), key), part]})

    return make


def in_shaft(name: str, **shaft: Any) -> Callable[..., object]:
    """Make a part of a shaft, and a system with it."""

    def make(**given: Any) -> object:
        other = {"length": 0.5, "outer_diameter": 0.05, "elements": 2} if name != "segments" else {}
        part = shaft["make"](**given)
        value = [part] if name == "segments" else part
        return system().replace(
            shafts=[gb.Shaft("input", **{**other, name: value}), system().shafts[1]]
        )

    return make


def as_limit(name: str) -> Callable[..., object]:
    """Make a limit of a bow, and find the bow."""

    def make(**given: Any) -> object:
        one = getattr(gb.BowLimit, name)(**given)
        return system().bow_limits("input", 100.0, limits=[one])

    return make


def of_source(name: str) -> Callable[..., object]:
    """Make a source, and a response to it."""
    return lambda **given: system().frequency_response([9.0], source=getattr(gb, name)(**given))


def in_mesh(name: str, make: Callable[..., Any], **more: Any) -> Callable[..., object]:
    """Make a part of a mesh, and a system with it."""
    return lambda **given: system().replace(
        meshes=[gb.Mesh("g1", "g2", **{"stiffness": 2e8, **more, name: make(**given)})]
    )


def star(ring: Any = "ring", **given: Any) -> gb.RotorSystem:
    """Make a star gear."""
    tooth = {"module": 3e-3, "face_width": 0.02}
    wanted = {"planets": 3, "planet": gb.Gear("planet", "pin", 0.01, teeth=24, **tooth), **PLANETS}
    return gb.RotorSystem(
        shafts=[gb.Shaft(name, length=0.1, outer_diameter=0.03) for name in ("in", "out")],
        gears=[
            gb.Gear("sun", "in", 0.05, teeth=24, **tooth),
            *(
                [gb.Gear("ring", "out", 0.05, teeth=72, internal=True, **tooth)]
                * (str(ring) == "ring")
            ),
        ],
        bearings=[gb.Bearing(name, x, stiffness=1e8) for name in ("in", "out") for x in (0.0, 0.1)],
        planetary_stages=[gb.PlanetaryStage(ring=ring, **(wanted | given))],
    )


def measurement() -> gb.Measurement:
    """Return a measurement beside the input shaft."""
    return gb.Measurement([10.0, 50.0, 90.0], [[1e-6], [2e-6], [3e-6]], [gb.Probe("input", 0.25)])


def identification() -> dict[str, Any]:
    """Return the arguments of an identification."""
    unknowns = [gb.unknown.bow("input")]
    return {"system": system(), "measured": measurement(), "unknowns": unknowns, "runout": False}


PLANETS: dict[str, Any] = {
    "sun": "sun",
    "bearing": [gb.Bearing("pin", x, stiffness=1e8) for x in (0.0, 0.02)],
}
AT: dict[str, Any] = {"shaft": "input", "position": 0.0}
PROFILE = gb.SpeedProfile.ramp(0.0, 1.0, 1.0)
THERMAL = {"at": "g1", "gain": 1e4, "time_constant": 9.0, "shape": gb.Bow.half_sine(1e-6)}
JOURNAL: dict[str, Any] = {
    "diameter": 0.05,
    "length": 0.025,
    "clearance": 5e-5,
    "viscosity": 0.03,
}
ROLLING: dict[str, Any] = {
    "elements": 9,
    "element_diameter": 0.0127,
    "pitch_diameter": 0.065,
    "clearance": 1e-5,
    "hertz_stiffness": 1e10,
}
#: A function that takes the arguments of each callable by name, and valid ones. Optional arguments are added.
CALLS: dict[str, tuple[Callable[..., object], dict[str, Any]]] = {
    "mm": (gb.mm, {"value": 1.0}),
    "rpm": (gb.rpm, {"value": 1.0}),
    "degrees": (gb.degrees, {"value": 1.0}),
    "MeshExcitation": (of_source("MeshExcitation"), {"at": "g1/g2"}),
    "GroundMotion": (of_source("GroundMotion"), {"value": 1e-6}),
    "ShaftExcitation": (of_source("ShaftExcitation"), {"shaft": "input"}),
    "sweep": (
        gb.sweep,
        {"make": lambda x: system(), "parameters": {"x": [1.0]}, "measure": measure},  # noqa: ARG005
    ),
    "dataset": (
        gb.dataset,
        {
            "make": lambda x: system(),  # noqa: ARG005
            "parameters": {"x": [1.0]},
            "run": lambda made, x: response(),  # noqa: ARG005
            "sensors": {"y": gb.Probe("input", 0.25)},
            "path": "x.nc",
        },
    ),
    "Measurement": (
        gb.Measurement,
        {
            "speeds": [10.0, 50.0],
            "amplitudes": [[1e-6], [2e-6]],
            "probes": [gb.Probe("input", 0.25)],
        },
    ),
    "Measurement.read_csv": (gb.Measurement.read_csv, {"path": "x.csv"}),
    "Measurement.read_uff": (
        gb.Measurement.read_uff,
        {"path": "x.uff", "channels": {1: gb.Probe("input", 0.25), 2: gb.Tacho("input")}},
    ),
    "Measurement.from_signals": (
        gb.Measurement.from_signals,
        {
            "time": 0.1 * np.arange(1000),
            "signals": {gb.Probe("input", 0.25): np.sin(0.1 * np.arange(1000))},
            "pulses": {gb.Tacho("input"): 2.0 * np.pi * np.arange(16)},
            "revolutions": 5,
        },
    ),
    "identify": (
        lambda **given: gb.identify(**{**identification(), **given}),
        {},
    ),
    "waterfall": (
        lambda responses=None, **given: gb.waterfall(
            [response()] if responses is None else responses, **given
        ),
        {"at": "g1"},
    ),
    "Material": (
        in_shaft("material", make=gb.Material),
        {"youngs_modulus": 2e11, "density": 7850.0, "poisson_ratio": 0.3},
    ),
    "Segment": (
        in_shaft("segments", make=gb.Segment),
        {"length": 0.5, "outer_diameter": 0.05},
    ),
    "Shaft": (with_part("Shaft"), {"name": "input", "length": 0.5, "outer_diameter": 0.05}),
    "Bow.half_sine": (in_shaft("bow", make=gb.Bow.half_sine), {"amplitude": 1e-4}),
    "Bow.sag": (in_shaft("bow", make=gb.Bow.sag), {"amplitude": 1e-4}),
    "Bow.mode": (in_shaft("bow", make=gb.Bow.mode), {"number": 1, "amplitude": 1e-4}),
    "Bow.points": (
        in_shaft("bow", make=gb.Bow.points),
        {"positions": [0.0, 0.2, 0.5], "amplitudes": [0.0, 1e-4, 0.0]},
    ),
    "Bow.function": (in_shaft("bow", make=gb.Bow.function), {"f": lambda x: 1e-4 * x}),
    "Bow.read_table": (gb.Bow.read_table, {"path": "x.csv"}),
    "BowLimit.displacement": (as_limit("displacement"), {"at": "g1", "limit": 1e-4}),
    "BowLimit.velocity": (as_limit("velocity"), {"at": "g1", "limit": 1e-3}),
    "BowLimit.contact_ratio": (as_limit("contact_ratio"), {"at": "g1/g2", "least": 1.2}),
    "BowLimit.mesh_force": (gb.BowLimit.mesh_force, {"at": "g1/g2", "factor": 1.5}),
    "BowLimit.bearing_force": (as_limit("bearing_force"), {"at": ("input", 0.0), "force": 1e4}),
    "BowLimit.bearing_life": (
        as_limit("bearing_life"),
        {"at": ("input", 0.0), "hours": 1e4, "capacity": 5e4, "exponent": 3.0},
    ),
    "BowLimit.stress": (
        as_limit("stress"),
        {"at": ("input", 0.1), "endurance_limit": 2e8, "tensile_strength": 6e8},
    ),
    "BowLimit.clearance": (gb.BowLimit.clearance, {"at": ("input", 0.0), "approach": 1e-5}),
    "BowLimit.film": (gb.BowLimit.film, {"at": ("input", 0.0), "thickness": 1e-5}),
    "Gear": (
        with_part("Gear"),
        {
            "name": "g1",
            "shaft": "input",
            "position": 0.25,
            "teeth": 25,
            "module": 3e-3,
            "face_width": 0.03,
        },
    ),
    "Disk": (
        with_part("Disk"),
        {"name": "d", **AT, "mass": 1.0, "diametral_inertia": 1e-3, "polar_inertia": 1e-3},
    ),
    "Mesh": (with_part("Mesh"), {"driver": "g1", "driven": "g2", "stiffness": 2e8}),
    "Bearing": (with_part("Bearing"), {**AT, "stiffness": 1e8}),
    "JournalBearing": (with_part("JournalBearing"), {**AT, **JOURNAL}),
    "JournalBearing.coefficients": (
        gb.JournalBearing(**AT, **JOURNAL).coefficients,
        {"load": 100.0, "speed": 100.0},
    ),
    "Pad": (
        lambda **given: system().replace(
            bearings=[
                *system().bearings,
                gb.JournalBearing(**AT, **JOURNAL, pads=[gb.Pad(**given)]),
            ]
        ),
        {"begin": 0.2, "extent": 2.5, "preload": 0.3},
    ),
    "TiltingPadBearing": (
        with_part("TiltingPadBearing"),
        {**AT, **JOURNAL, "pad_count": 5, "pad_inertia": 1e-5},
    ),
    "TiltingPadBearing.coefficients": (
        gb.TiltingPadBearing(**AT, **JOURNAL, pad_count=5).coefficients,
        {"load": 100.0, "speed": 100.0, "frequency": 50.0},
    ),
    "SqueezeFilm": (
        lambda **given: system().replace(
            bearings=[
                *system().bearings,
                gb.Bearing(**AT, stiffness=1e8, support=gb.SqueezeFilm(**given)),
            ]
        ),
        {**JOURNAL, "mass": 1.0, "stiffness": 1e7},
    ),
    "SqueezeFilm.coefficients": (
        gb.SqueezeFilm(**JOURNAL).coefficients,
        {"eccentricity_ratio": 0.4, "frequency": 100.0},
    ),
    "RollingBearing": (with_part("RollingBearing"), {**AT, **ROLLING}),
    "RollingBearing.coefficients": (
        gb.RollingBearing(**AT, **ROLLING).coefficients,
        {"load": 100.0},
    ),
    "RollingBearing.from_dimensions": (
        lambda **given: system().replace(
            bearings=[*system().bearings, gb.RollingBearing.from_dimensions(**given)]
        ),
        {**AT, "bore": 0.04, "outer": 0.09, "width": 0.023},
    ),
    "RollingBearing.ring_coefficients": (
        gb.RollingBearing(**AT, **ROLLING).ring_coefficients,
        {"load": 100.0},
    ),
    "ThermalBow": (gb.ThermalBow, THERMAL),
    "Support": (with_part("Support"), {"name": "s", "mass": 1.0, "stiffness": 1e8}),
    "Housing": (with_part("Housing"), {"name": "h", "mass": 1.0, "stiffness": 1e8}),
    "Housing.from_matrices": (
        gb.Housing.from_matrices,
        {
            "name": "h",
            "mass": np.eye(3),
            "stiffness": 1e8 * np.eye(3),
            "interfaces": {"seat": gb.Interface((0.0, 0.0, 0.0), [0, 1, 2])},
            "highest_frequency": 1e4,
        },
    ),
    "Coupling": (
        with_part("Coupling"),
        {
            "a": ("input", 0.5),
            "b": ("output", 0.0),
            "lateral_stiffness": 1e6,
            "torsional_stiffness": 1e4,
        },
    ),
    "Drive": (with_part("Drive"), {"at": "g1", "stiffness": 1e4}),
    "Force": (with_part("Force"), {"at": "g1", "value": 1.0}),
    "Torque": (with_part("Torque"), {"at": "g1", "value": 1.0}),
    "Torque.balance": (
        lambda at: system().replace(torques=[gb.Torque.balance(at)]),
        {"at": "g1"},
    ),
    "SpeedTable": (
        lambda **given: system().replace(
            bearings=[gb.Bearing("input", 0.0, stiffness=gb.SpeedTable(**given))]
        ),
        {"speeds": [0.0, 1.0], "values": [1e8, 2e8]},
    ),
    "SpeedTable.at_frequency": (
        lambda frequency: gb.SpeedTable(None, [1e8, 2e8], frequencies=[0.0, 1.0]).at_frequency(
            frequency
        ),
        {"frequency": 0.5},
    ),
    "SpeedTable.read_table": (
        lambda **given: system().replace(
            bearings=[gb.Bearing("input", 0.0, stiffness=gb.SpeedTable.read_table(**given))]
        ),
        {"path": "x.csv"},
    ),
    "SpeedProfile": (gb.SpeedProfile, {"breaks": [0.0, 1.0], "coefficients": [[1.0]]}),
    "SpeedProfile.ramp": (gb.SpeedProfile.ramp, {"start": 0.0, "end": 1.0, "duration": 1.0}),
    "SpeedProfile.table": (gb.SpeedProfile.table, {"times": [0.0, 1.0], "speeds": [0.0, 1.0]}),
    "SpeedProfile.function": (gb.SpeedProfile.function, {"f": point, "duration": 1.0}),
    "SpeedProfile.angle": (PROFILE.angle, {"times": [0.0]}),
    "SpeedProfile.__call__": (PROFILE.__call__, {"times": [0.0]}),
    "TimeSeries": (
        lambda **given: system().replace(torques=[gb.Torque("g1", gb.TimeSeries(**given))]),
        {"times": [0.0, 1.0], "values": [0.0, 1.0]},
    ),
    "TimeSeries.function": (
        lambda **given: system().replace(
            torques=[gb.Torque("g1", gb.TimeSeries.function(**given))]
        ),
        {"f": point, "duration": 1.0},
    ),
    "TipRelief": (
        in_mesh("tip_relief", gb.TipRelief, stiffness=gb.Stiffness.square(2e8)),
        {"amount": 1e-5, "length": 0.3},
    ),
    "RingGear": (
        lambda **given: star(gb.RingGear(**given)),
        {"name": "annulus", "teeth": 72, "support": "out", "position": 0.05, "module": 3e-3}
        | {"face_width": 0.02},
    ),
    "PlanetaryStage": (
        star,
        {"ring": "ring", "planets": 3, **PLANETS}
        | {
            "planet": gb.Gear("planet", "pin", 0.01, teeth=24, module=3e-3, face_width=0.02),
        },
    ),
    "MeshFriction": (in_mesh("friction", gb.MeshFriction), {"coefficient": 0.05}),
    "TransmissionError": (in_mesh("error", gb.TransmissionError), {"tooth": [(1e-6, 0.0)]}),
    "Stiffness.constant": (in_mesh("stiffness", gb.Stiffness.constant), {"mean": 2e8}),
    "Stiffness.fourier": (
        in_mesh("stiffness", gb.Stiffness.fourier),
        {"mean": 2e8, "amplitudes": [1e7]},
    ),
    "Stiffness.iso6336": (in_mesh("stiffness", gb.Stiffness.iso6336), {}),
    "Stiffness.parabolic": (in_mesh("stiffness", gb.Stiffness.parabolic), {"mean": 2e8}),
    "Stiffness.potential_energy": (in_mesh("stiffness", gb.Stiffness.potential_energy), {}),
    "Stiffness.square": (in_mesh("stiffness", gb.Stiffness.square), {"mean": 2e8}),
    "Stiffness.table": (in_mesh("stiffness", gb.Stiffness.table), {"values": [1e8, 2e8, 1.5e8]}),
    "RotorSystem": (
        gb.RotorSystem,
        {"shafts": [gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=2)]},
    ),
    "RotorSystem.from_dict": (gb.RotorSystem.from_dict, {"description": {}}),
    "RotorSystem.from_ross": (gb.RotorSystem.from_ross, {"path": "x.json"}),
    "RotorSystem.read_rexs": (
        gb.RotorSystem.read_rexs,
        {"path": "x.rexs", "load_case": 1, "bearings": {"other": 1e8}},
    ),
    "rexs_contents": (gb.rexs_contents, {"path": "x.rexs"}),
    "read": (gb.read, {"path": "x.rexs", "load_case": 1, "bearings": {"other": 1e8}}),
    "examples": (gb.examples, {}),
    "RotorSystem.load": (gb.RotorSystem.load, {"path": "x.toml"}),
    "RotorSystem.replace": (lambda **given: system().replace(**given), {}),
    "Accelerometer": (lambda **given: response().measure(gb.Accelerometer(**given)), {"at": "g1"}),
    "Probe": (
        lambda **given: response().measure(gb.Probe(**given)),
        {"shaft": "input", "position": 0.25},
    ),
    "Tacho": (
        lambda **given: response().measure(gb.Tacho(**given)),
        {"shaft": "input"},
    ),
    "Response.load": (gb.Response.load, {"path": "x.npz"}),
    "Continuation.load": (gb.Continuation.load, {"path": "x.npz"}),
    "SteadyState.load": (gb.SteadyState.load, {"path": "x.npz"}),
    "Sweep.load": (gb.Sweep.load, {"path": "x.sweep"}),
}
REXS = Path(__file__).parents[1] / "files" / "gearbox.rexs"
#: A free shaft of ROSS.
SIZES = {"L": 1.0, "idl": 0.0, "idr": 0.0, "odl": 0.05, "odr": 0.05}
STEEL = {"rho": 7810.0, "E": 211e9, "G_s": 81.2e9}
ROSS = {"ross_version": "2.3.0", "ShaftElement_0": {"n": 0, **SIZES, "material": STEEL}}
BEARING = {"at": ("input", 0.0)}
MESH = {"at": ("g1", "g2")}
PARAMETERS = ["bearings[0].stiffness"]
#: A value of each class, and valid required arguments of its methods.
METHODS: dict[str, tuple[Callable[[], Any], dict[str, dict[str, Any]]]] = {
    "RotorSystem": (
        system,
        {
            "balance": {"planes": ["g1"], "speed": 100.0},
            "bearing_life": {"speed": 100.0},
            "bow_limits": {"shaft": "input", "speed": 100.0},
            "campbell": {"speeds": [0.0, 100.0]},
            "continuation": {
                "parameter": "speed",
                "begin": 100.0,
                "end": 100.5,
                "max_points": 1,
                "first_step": 1.1,
                "max_period": 0.2,
            },
            "critical_speed_map": {"stiffnesses": [1e7, 1e8]},
            "default_output_step": {"duration": 1e-3, "speed": 100.0},
            "efficiency": {"speeds": [100.0]},
            "frequency_response": {"frequencies": [100.0], "source": gb.Force("g1", 1.0)},
            "matrices": {},
            "mesh_response": {"at": "g1/g2", "speeds": [100.0]},
            "modes": {},
            "mass_properties": {},
            "plot": {},
            "report": {"path": "x.html", "modes": 1},
            "save": {"path": "x.toml"},
            "to_fmu": {"path": "x.fmu", "speed": 100.0},
            "thermal_bow": {"bow": gb.ThermalBow(**THERMAL), "speeds": [100.0]},
            "sensitivity": {"parameters": PARAMETERS, "of": system().modes(100.0, count=2)},
            "simulate": {"duration": 1e-3, "speed": 100.0},
            "simulate_many": {"variations": [{}], "duration": 1e-3, "speed": 100.0},
            "static": {},
            "steady_state": {"speed": 100.0},
            "synchronous": {"speeds": [100.0]},
            "tradeoff": {
                "duration": 1e-3,
                "speed": 100.0,
                "budget": 1.0,
                "methods": ["exponential"],
                **dict.fromkeys(("modes", "elements", "degrees"), ()),
                "frozen": False,
                "mean_stiffness": False,
                "repeats": 1,
            },
        },
    ),
    "Response": (
        response,
        {
            **{
                name: {"at": "g1"}
                for name in (
                    "acceleration",
                    "axial",
                    "axial_acceleration",
                    "axial_velocity",
                    "displacement",
                    "twist",
                    "twist_rate",
                    "velocity",
                )
            },
            **dict.fromkeys(
                (
                    "axial_bearing_force",
                    "bearing_displacement",
                    "bearing_force",
                    "journal",
                    "rolling",
                ),
                BEARING,
            ),
            "angle": {"shaft": "input"},
            "animate": {"path": "x.gif", "duration": 1.0, "fps": 1.0},
            "contact_shares": MESH,
            "energy_balance": {},
            "errors": {},
            "measure": {"sensor": gb.Tacho("input")},
            "mesh": MESH,
            "orders": {"at": "g1"},
            "plot": {},
            "resample": {"rate": 3000.0},
            "save": {"path": "x.npz"},
            "spectrum": {"at": "g1"},
            "spin": {"shaft": "input"},
            "to_dataframe": {},
            "to_xarray": {},
        },
    ),
    "Static": (
        lambda: system().static(100.0),
        {
            "bearing_life": {},
            **{name: {"at": "g1"} for name in ("axial", "displacement", "twist")},
            **dict.fromkeys(
                ("axial_bearing_force", "bearing_displacement", "bearing_force", "journal"), BEARING
            ),
            "mesh": MESH,
        },
    ),
    "Synchronous": (
        lambda: system().synchronous([0.0, 50.0, 100.0]),
        {
            **dict.fromkeys(("bearing_displacement", "bearing_force"), BEARING),
            "bode": {"at": ["g1"]},
            **{name: {"at": "g1"} for name in ("displacement", "elastic", "orbit", "peaks")},
            **{name: {"at": "g1"} for name in ("phase", "twist", "velocity", "acceleration")},
            "axial_displacement": {"at": "g1"},
            "measure": {"sensor": gb.Probe("input", 0.25)},
            "mesh_force": {"at": "g1/g2"},
            "plot": {"at": ["g1"]},
            "radiated_power": {"housing": "housing"},
            "subtract_slow_roll": {"speed": 50.0},
        },
    ),
    "FrequencyResponse": (
        lambda: system().frequency_response([50.0, 100.0], source=gb.Force("g1", 1.0)),
        {
            **dict.fromkeys(("bearing_displacement", "bearing_force"), BEARING),
            **{
                name: {"at": "g1"} for name in ("acceleration", "displacement", "twist", "velocity")
            },
            "axial_displacement": {"at": "g1"},
            "compare": {"measured": "x.csv"},
            "measure": {"sensor": gb.Probe("input", 0.25)},
            "mesh_force": {"at": "g1/g2"},
            "plot": {"at": ["g1"]},
            "radiated_power": {"housing": "housing"},
            "save": {"path": "x.mat"},
            "to_dataframe": {},
            "to_xarray": {},
        },
    ),
    "FrequencyComparison": (
        lambda: (
            system()
            .frequency_response([50.0, 100.0], source=gb.Force("g1", 1.0))
            .compare(
                [gb.results.MeasuredCurve("g1", "y", "velocity", np.array([50.0]), np.array([1j]))]
            )
        ),
        {"plot": {}},
    ),
    "Campbell": (
        lambda: system().campbell([0.0, 100.0], count=3),
        {"plot": {}, "table": {}, "to_dataframe": {}},
    ),
    "FilmCoefficients": (
        lambda: gb.JournalBearing(**AT, **JOURNAL).coefficients(1e3, 300.0),
        {"plot": {}},
    ),
    "Continuation": (
        branch,
        {
            "amplitude": {"at": "g1"},
            "plot": {},
            "save": {"path": "x.npz"},
            "statistic": {"name": "mean", "at": "g1"},
            "to_dataframe": {},
        },
    ),
    "CriticalSpeedMap": (
        lambda: system().critical_speed_map([1e7, 1e8], count=2),
        {"lines": {"whirl": "forward"}, "plot": {}},
    ),
    "EnergyBalance": (lambda: response().energy_balance(), {"plot": {}, "to_dataframe": {}}),
    "Modes": (
        lambda: system().modes(100.0),
        {
            "displacement": {"at": "g1"},
            "twist": {"at": "g1"},
            "shapes_at": {"places": ["g1"]},
            "compare": {"measured": "x.uff"},
            "energy_shares": {},
            "names": {},
            "plot": {},
            "table": {},
            "to_dataframe": {},
        },
    ),
    "Orders": (
        lambda: response().orders("g1", shaft_harmonics=1, mesh_harmonics=0, sidebands=0),
        {"amplitude": {"name": "1"}, "plot": {}, "table": {}, "track": {"name": "1"}},
    ),
    "Spectrum": (lambda: response().spectrum("g1"), {"plot": {}}),
    "SteadyState": (
        steady,
        {
            "instability": {},
            "is_stable": {},
            "largest_multiplier": {},
            "multipliers": {"magnitude": 0.5},
            "plot": {},
            "save": {"path": "x.npz"},
        },
    ),
    "Sweep": (
        sweep,
        {
            "plot": {"name": "value"},
            "save": {"path": "x.sweep"},
            "to_dataframe": {},
            "to_xarray": {},
            "values": {},
        },
    ),
    "Tradeoff": (
        tradeoff,
        {"front": {}, "plot": {}, "recommend": {}, "table": {}, "to_dataframe": {}},
    ),
    "Trial": (lambda: tradeoff().trials[0], {"cost": {}}),
    "RexsContents": (lambda: gb.rexs_contents(REXS), {"table": {}}),
    "Waterfall": (
        lambda: gb.waterfall(
            [system().simulate(0.05, speed, output_step=1e-4) for speed in (100.0, 110.0)], "g1"
        ),
        {"plot": {}},
    ),
    "Accelerometer": (lambda: gb.Accelerometer("g1"), {"measure": {"recording": None}}),
    "Probe": (lambda: gb.Probe("input", 0.25), {"measure": {"recording": None}}),
    "Tacho": (lambda: gb.Tacho("input"), {"measure": {"recording": None}}),
}

METHODS["Measurement"] = (
    measurement,
    {
        "plot": {},
        "save": {"path": "x.csv"},
        "subtract_slow_roll": {"speed": 10.0},
        "table": {},
        "to_dataframe": {},
    },
)
METHODS["Identification"] = (
    lambda: gb.identify(**identification()),
    {
        "balance": {"planes": ["g1"], "speeds": [100.0]},
        "plot": {},
        "to_dict": {},
        "value": {"name": "bow of input, half wave 1"},
    },
)
METHODS["Correction"] = (
    lambda: gb.identify(**identification()).balance("g1", [100.0]),
    {"plot": {}},
)
METHODS["Balance"] = (lambda: system().balance(["g1"], 100.0), {"plot": {}})
METHODS["BowLimits"] = (lambda: system().bow_limits("input", 100.0), {"plot": {}})
METHODS["BearingLife"] = (
    lambda: system().bearing_life(100.0),
    {"plot": {}, "bearing": BEARING},
)
METHODS["ThermalStability"] = (
    lambda: system().thermal_bow(gb.ThermalBow(**THERMAL), [100.0]),
    {"plot": {}, "spiral": {"speed": 100.0, "duration": 5.0}},
)
METHODS["ThermalSpiral"] = (
    lambda: system().thermal_bow(gb.ThermalBow(**THERMAL), [100.0]).spiral(100.0, 5.0),
    {"plot": {}},
)
METHODS["Efficiency"] = (
    lambda: lossy().efficiency(100.0),
    {"plot": {}},
)
METHODS["SectionForces"] = (lambda: system().static().section_forces("input"), {"plot": {}})
METHODS["Stresses"] = (lambda: system().stresses(100.0), {"plot": {}})
for name in ("FrequencyResponse", "Synchronous", "Static"):
    METHODS[name][1]["section_forces"] = {"at": "input"}
METHODS["Response"][1].update({"section_forces": {"at": "g1"}, "stresses": {}})
METHODS["SteadyState"][1]["section_forces"] = {"at": "g1"}
METHODS["RotorSystem"][1]["stresses"] = {"speed": 100.0}
METHODS["RingSensor"] = (lambda: gb.RingSensor("ring"), {"measure": {"recording": None}})
METHODS["StrainGauge"] = (lambda: gb.StrainGauge("g1"), {"measure": {"recording": None}})
METHODS["MassProperties"] = (lambda: system().mass_properties(), {})
METHODS["TrialInfluence"] = (
    lambda: gb.results.TrialInfluence(
        ("g1",), ("probe",), np.ones(1), np.full(1, 1j), np.full(1, 2j), np.ones(1)
    ),
    {"plot": {}},
)
METHODS["Sensitivity"] = (
    lambda: system().sensitivity(PARAMETERS, system().modes(100.0, count=2)),
    {"plot": {}},
)
METHODS["ResponseSensitivity"] = (
    lambda: system().sensitivity(PARAMETERS, system().synchronous([100.0]), at="g1"),
    {"plot": {}, "largest": {}},
)
METHODS["ModeComparison"] = (
    lambda: system().modes(count=2).compare(system().modes(count=2)),
    {"plot": {}},
)
METHODS["Peaks"] = (
    lambda: system().synchronous([0.0, 50.0, 100.0]).peaks("g1"),
    {"plot": {}},
)
for kind in [getattr(gb.results, name) for name in dir(gb.results)]:
    if hasattr(kind, "to_dataframe"):
        common: dict[str, Any] = {"table": {}, "to_dataframe": {}, "save": {"path": "x.csv"}}
        METHODS[kind.__name__][1].update(common | METHODS[kind.__name__][1])
METHODS["Static"][1]["plot"] = {}

#: Values that no other argument takes: the error names the argument. Numbers, texts and arrays are of the right type for
#: some arguments; each gives a result or an error of gearbow.
OF_WRONG_TYPE = {
    "True": {"progress", "runout", "shear", "sparse", "frozen", "mean_stiffness", "simplified"}
    | {"vibrating", "ruptures"}
    | {"damping_in_separation", "axial", "foundation", "geometric_stiffness", "bow_torque"},
    "function": {"gain", "progress", "make", "measure", "f", "speed", "value", "runout"},
    "object": set(),
    "bytes": set(),
    "list of None": set(),
}
#: Of sequences, integers and exceptions, from Python, and constructors from data of the core.
NOT_FOR_USERS = re.compile(
    r"(Contact|Event|\w*Error|\w*Warning)\.|\w+\.of$|(Sweep|Peaks)\.(count|index)$"
)
#: The system of the method, and the beginning of error messages.
NO_ARGUMENTS = {("RotorSystem.simulate_many", "system"), ("TimeSeries.function", "path")}


def parameters(name: str) -> list[str]:
    """Return the names of the arguments of a public function, class or method."""
    first = name.split(".", maxsplit=1)[0]
    found: Any = gb if hasattr(gb, first) else gb.results
    for part in name.split("."):
        found = getattr(found, part)
    given = inspect.signature(found).parameters.values()
    own = [each.name for each in given if each.kind is not each.VAR_KEYWORD]
    return [each for each in own if each != "self" and (name, each) not in NO_ARGUMENTS]


def of_method(owner: str, method: str) -> Callable[..., object]:
    """Return a function that calls a method."""
    make = METHODS[owner][0]

    def call(**given: Any) -> object:
        return getattr(make(), method)(**given)

    return call


ALL = CALLS | {
    f"{owner}.{method}": (of_method(owner, method), arguments)
    for owner, (_, methods) in METHODS.items()
    for method, arguments in methods.items()
}


@pytest.mark.parametrize("name", [name for name in ALL if parameters(name)])
def test_an_error_names_the_argument(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    import matplotlib.pyplot as plt

    from gearbow.report import compose

    monkeypatch.chdir(tmp_path)
    Path("x.csv").write_text("speed,k\n0,1e8\n1,2e8\n", encoding="utf-8")
    Path("x.rexs").write_bytes(REXS.read_bytes())
    Path("x.json").write_text(json.dumps(ROSS), encoding="utf-8")
    # A section turns each error into a sentence of the page, so that one stands for all of them.
    monkeypatch.setattr(compose, "SECTIONS", compose.SECTIONS[1:2])
    call, arguments = ALL[name]

    @each_case(("argument", "wrong"), product(parameters(name), WRONG), ids=str)
    def check(argument: str, wrong: str) -> None:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                call(**{**arguments, argument: WRONG[wrong]})
        except gb.GearbowError as error:
            text = str(error)
        except OSError:
            assert argument in ("path", "store", "checkpoint")
            return
        else:
            text = ""
        finally:
            plt.close("all")
        if argument not in OF_WRONG_TYPE.get(wrong, {argument}):
            assert text, "is accepted"
            # The functions of units begin their messages with their own name.
            assert argument in text or text.startswith(name)
        assert "\n" not in text

    check()


def test_every_public_function_and_method_is_examined():
    public = {name for name in dir(gb) if inspect.isfunction(getattr(gb, name))}
    for owner in {*dir(gb), *dir(gb.results)}:
        found = getattr(gb, owner, None) or getattr(gb.results, owner)
        if inspect.isclass(found):
            methods = inspect.getmembers(found, callable)
            public |= {f"{owner}.{name}" for name, _ in methods if not name.startswith("_")}
    assert {name for name in public if not NOT_FOR_USERS.match(name)} <= set(ALL)
