"""Representations of all public objects: short, without arrays, and a table in notebooks."""

from __future__ import annotations

import contextlib
import inspect
import re
from dataclasses import replace
from enum import Enum
from functools import cache

import numpy as np

import gearbow as gb
from reference.cases import each_case
from reference.machines import rated

#: Longest representation [characters], and longest table in HTML [rows].
LONGEST, MOST_ROWS = 350, 12

MANY = np.linspace(0.0, 1000.0, 300)


@cache
def objects() -> dict[str, object]:
    """Give an object of every public class that makes objects, with long arrays where possible."""
    shafts = [
        gb.Shaft(
            f"shaft {i}", length=0.5, outer_diameter=0.05, elements=4, bow=gb.Bow.half_sine(1e-4)
        )
        for i in range(13)
    ]
    gears = [
        gb.Gear(
            f"gear {i}", shaft.name, 0.25, teeth=25 + 25 * (i % 2), module=3e-3, face_width=0.03
        )
        for i, shaft in enumerate(shafts)
    ]
    meshes = [
        gb.Mesh(f"gear {i}", f"gear {i + 1}", stiffness=2e8, damping_ratio=0.05) for i in range(12)
    ]
    table = gb.SpeedTable(MANY, 1e8 + MANY, outside="hold")
    bearings = [
        gb.Bearing(shaft.name, x, stiffness=table, damping=500.0)
        for shaft in shafts
        for x in (0.0, 0.5)
    ]
    torques = [gb.Torque("gear 0", 100.0), gb.Torque.balance("gear 12")]
    system = gb.RotorSystem(shafts, gears, meshes, bearings, torques)
    pair = gb.RotorSystem(
        shafts[:2], gears[:2], meshes[:1], bearings[:4], [torques[0], gb.Torque.balance("gear 1")]
    )
    response = pair.simulate(0.1, 100.0, record=["gears", "meshes", "energy"], output_step=1e-4)
    campbell = pair.campbell([10.0, 20.0, 30.0], count=12)
    synchronous = pair.synchronous(MANY[1:])
    frequency = pair.frequency_response(MANY[1:], source=gb.Force("gear 0", 1.0))
    curve = gb.results.MeasuredCurve("gear 0", "y", "velocity", MANY[1:], 1j * MANY[1:])
    bent = gb.Shaft("s", length=1.0, outer_diameter=0.05, elements=4, bow=gb.Bow.half_sine(1e-4))
    soft = [gb.Bearing("s", x, stiffness=1e8, damping=1e4) for x in (0.0, 1.0)]
    rotor = gb.RotorSystem([bent], bearings=soft)
    journal = gb.JournalBearing("a", 0.0, diameter=0.1, length=0.03, clearance=1e-4, viscosity=0.1)
    rolling = gb.RollingBearing(
        "a", 0.0, elements=9, element_diameter=0.0127, pitch_diameter=0.065, clearance=1e-5
    )
    force = np.zeros((300, 2))
    tradeoff = pair.tradeoff(
        1e-3,
        100.0,
        methods="exponential",
        tolerances=[1e-2, 1e-4],
        modes=[],
        degrees=[],
        frozen=False,
        elements=[],
        repeats=1,
    )
    sweep = gb.sweep(dict, {"number": list(range(300))}, lambda system, number: number)  # noqa: ARG005
    measured = gb.Measurement(MANY[1:], np.ones(MANY.size - 1), [gb.Probe("s", 0.5)])
    identified = gb.identify(rotor, measured, [gb.unknown.bow("s")], runout=False, noise=1.0)
    found = [
        measured,
        identified,
        identified.probes[0],
        identified.balance(("s", 0.5), 100.0),
        gb.results.TrialInfluence(("s",) * 300, ("probe",) * 300, MANY, 1j * MANY, 1j * MANY, MANY),
        system,
        *shafts,
        *gears,
        *meshes,
        *bearings,
        *torques,
        table,
        gb.STEEL,
        shafts[0].bow,
        gb.Bow.points(MANY, MANY),
        gb.Bow.function(abs),
        gb.Segment(0.1, 0.05),
        gb.Segment(0.1, 0.05, end_outer_diameter=0.04, material=gb.STEEL),
        gb.Sleeve("s", 0.1, 0.2, 0.08, 0.05),
        gb.Shaft("s", segments=[gb.Segment(0.1, 0.05 + 1e-5 * i) for i in range(300)]),
        gb.Disk("d", "a", 0.1, 1.0, 1.0, 1.0),
        gb.Support(mass=1.0, stiffness=1e8),
        gb.Housing(
            "h", mass=1.0, stiffness=1e8, points={f"p{i}": (0.0, 0.0, 0.0) for i in range(300)}
        ),
        gb.Interface((0.1, 0.2, 0.3), [MANY, MANY, MANY]),
        gb.Surface([[0, 1, 2]] * 300, [[0.0, 0.0, 1e-4]] * 300),
        gb.Notch("s", 0.5, bending=1.5),
        gb.StrainGauge(("s", 0.5), "bending"),
        gb.RingSensor("ring", angle=0.5),
        pair.static(20.0).section_forces("shaft 0"),
        system.stresses(20.0),
        gb.Coupling(("a", 0.0), ("b", 0.0), torsional_stiffness=4.0),
        gb.Drive("g", 1e5),
        gb.Force("g", gb.TimeSeries(MANY, MANY)),
        gb.TimeSeries(MANY, MANY),
        gb.SpeedProfile.table(MANY, MANY),
        gb.Stiffness.table(1e8 + MANY),
        gb.TipRelief(1e-5, 1e-3),
        gb.MeshFriction(0.05),
        gb.RingGear("ring", 72, "output", module=3e-3),
        gb.PlanetaryStage(
            "sun", "ring", 3, planet=gears[0], bearing=[gb.Bearing("pin", 0.0, stiffness=1e8)]
        ),
        gb.TransmissionError(table=MANY),
        journal,
        gb.Pad(0.2, 2.5),
        gb.TiltingPadBearing(
            "a", 0.0, diameter=0.1, length=0.03, clearance=1e-4, viscosity=0.1, pad_count=5
        ),
        damper := gb.SqueezeFilm(diameter=0.1, length=0.03, clearance=1e-4, viscosity=0.1),
        damper.coefficients(0.4),
        rolling,
        journal.coefficients(500.0, 150.0),
        journal.coefficients(500.0, 150.0).pads[0],
        rolling.coefficients(500.0),
        gb.RollingBearing("a", 0.0, "6308"),
        gb.RollingBearing("a", 0.0, "6308").estimate,
        gb.RollingBearing("a", 0.0, "32008X").ring_coefficients(500.0, thrust=200.0),
        gb.results.BearingMotion(force, eccentricity_ratio=MANY, attitude_angle=MANY),
        pair.matrices(20.0),
        gb.examples()["gearbox"],
        pair.mass_properties(),
        gb.ThermalBow("g1", 1e4, time_constant=9.0, shape=gb.Bow.points(MANY, MANY)),
        thermal := gb.results.ThermalStability("g1", MANY, 9.0, MANY + 0j, MANY + 0j, MANY + 0j),
        thermal.spiral(float(MANY[1]), 5.0),
        pair.replace(meshes=[replace(mesh, friction=0.05) for mesh in pair.meshes]).efficiency(
            MANY[1:]
        ),
        system.discretisation,
        system.discretisation.shafts["shaft 0"],
        pair.modes(20.0),
        campbell,
        campbell.lines[0],
        pair.campbell(MANY[:100:20], count=6).intersections[0],
        gb.results.StabilityThreshold(1, 264.273, 42.046, "forward", "unstable", 1e-9),
        pair.replace(
            bearings=[gb.Bearing(b.shaft, b.position, stiffness=1e8) for b in bearings[:4]]
        ).critical_speed_map(np.linspace(1e7, 1e8, 12), count=4),
        pair.sensitivity(
            [f"bearings[{i}].damping" for i in range(4)] * 20, pair.modes(20.0, count=8)
        ),
        synchronous,
        gb.MeshExcitation("gear 0/gear 1"),
        gb.GroundMotion(1e-6),
        gb.ShaftExcitation("shaft 0"),
        frequency,
        frequency.compare([curve]),
        curve,
        pair.modes(20.0, count=20).compare(pair.modes(20.0, count=20)),
        gb.results.MeasuredShapes(tuple(f"gear {i}" for i in range(2)), MANY, np.ones((3, 2, 2))),
        pair.sensitivity([f"bearings[{i}].damping" for i in range(4)], synchronous, at="gear 0"),
        rotor.synchronous(MANY[1:]).peaks(("s", 0.5)),
        rotor.synchronous(MANY[1:]).peaks(("s", 0.5))[0],
        life := rated(pair).bearing_life(20.0),
        life.bearings[0],
        life.cases[0],
        rotor.bow_limits("s", 100.0, limits=[gb.BowLimit.displacement(("s", 0.5), 1e-4)]),
        gb.BowLimit.displacement(("s", 0.5), 1e-4),
        gb.results.ReachedLimit("backlash used up", "gear 0/gear 1", 100.0, 2e-4),
        pair.static(speed=100.0),
        pair.static(speed=100.0).mesh(("gear 0", "gear 1")),
        response,
        response.statistics,
        gb.results.ErrorEstimate(2e-3, 0.0, 1e-4, 2e-3),
        response.mesh(("gear 0", "gear 1")),
        response.energy_balance(),
        response.spectrum("gear 0"),
        response.orders("gear 0"),
        response.orders("gear 0").orders[0],
        gb.waterfall([response, pair.simulate(0.1, 120.0, output_step=1e-4)], "gear 0"),
        gb.results.Event(0.1, "gear 0", "gear 1", "contact"),
        gb.results.ContactShares(0.9, 0.02, 0.0, 0.08),
        tradeoff,
        tradeoff.trials[0],
        gb.results.Skipped("rk4", "full", "above the stability limit"),
        tradeoff.recommend(error=1.0),
        sweep,
        sweep[0],
        pair.balance("gear 0", 50.0, points="gear 0"),
    ]
    found += [
        getattr(gb, name)(*given)
        for name, given in (("Accelerometer", ["foot"]), ("Probe", ["a", 0.1]), ("Tacho", ["a"]))
        if hasattr(gb, name)
    ]
    found += [
        gb.results.LoadCase(1, 150.0, {f"load {i}": 50.0 for i in range(300)}),
        gb.results.MissingValue("bearings", "B1", "ball bearing at 0.1 m", ("stiffness",)),
        gb.results.RexsContents(
            "example 1", "1.4", "input", (), (), ("a shaft has no material",) * 300
        ),
        rotor.steady_state(100.0, record=[("s", 0.5)]),
        rotor.continuation("bow", 0.5, 1.0, speed=100.0, record=[("s", 0.5)], first_step=1.0),
    ]
    with contextlib.suppress(gb.MissingExtraError):
        found.append(pair.matrices(20.0, sparse=True))
    return {type(one).__name__: one for one in reversed(found) if one is not None}


#: Names of the public classes whose objects users see.
KINDS = sorted(
    {
        name
        for module in (gb, gb.results)
        for name in dir(module)
        # Errors and enumerations have the representation of Python.
        if inspect.isclass(kind := getattr(module, name)) and not issubclass(kind, Exception | Enum)
    }
)


def test_every_public_class_has_an_object_here():
    assert set(KINDS) - set(objects()) == set()


@each_case("name", KINDS)
def test_a_representation_is_short(name: str):
    one = objects()[name]
    text = repr(one)
    assert len(text) <= LONGEST, text
    assert text.count("\n") == 0
    assert text.startswith(f"{name}(")
    assert not re.search(r"\barray\(", text)
    assert "object at 0x" not in text
    # at most ten modes, speeds or frequencies in a list
    assert len(re.findall(r"\d, ", text)) <= 24


@each_case("name", KINDS)
def test_a_notebook_shows_a_table(name: str):
    one = objects()[name]
    text = one._repr_html_()
    assert "<table>" in text
    assert text.count("<tr>") <= MOST_ROWS
    assert len(text) < 6000
    columns = {row.count("<td>") + row.count("<th>") for row in text.splitlines() if "<tr>" in row}
    assert len(columns - {0}) <= 1 or "colspan" in text


def test_representations_name_what_matters():
    found = {name: repr(one) for name, one in objects().items()}
    assert "13 shafts, 13 gears, 12 meshes" in found["RotorSystem"]
    assert "speed ratios 1, -0.5, " in found["RotorSystem"]
    assert ", …; " in found["RotorSystem"]
    assert found["Modes"].startswith("Modes(")
    assert " at 20 rad/s: 0, " in found["Modes"]
    assert "at 100 rad/s" in found["Response"]
    assert found["Shaft"].startswith(
        "Shaft(name='shaft 0', length=0.5, outer_diameter=0.05, elements=4"
    )
    table = objects()["Response"]._repr_html_()
    assert f"tooth frequency gear 0/gear 1: {2500 / (2 * np.pi):.6g} Hz" in table
    system = objects()["RotorSystem"]._repr_html_()
    assert "<td>shaft 1</td><td>-0.5</td><td>gear 1 (50)</td><td>25</td>" in system


def test_text_is_escaped_in_html():
    shaft = gb.Shaft("<b>a & b</b>", length=1.0, outer_diameter=0.05)
    assert "<b>" not in shaft._repr_html_()
    assert "&lt;b&gt;a &amp; b&lt;/b&gt;" in shaft._repr_html_()


def test_the_identity_of_a_function_contains_all_digits_of_the_parts_in_a_set():
    from gearbow.sweeps.points import identity

    def function(value):
        materials = frozenset({gb.Material(value, 7850.0, 0.3)})
        return lambda: materials

    first, same, other = (identity(function(e)) for e in (2.07e11, 2.07e11, 2.07e11 + 1.0))
    assert first == same
    assert first != other
