"""Couplings: two half shafts as one, misalignment, run-out, runs and errors."""

from __future__ import annotations

import re
import warnings
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import gearbow as gb
from reference.attached import Attached
from reference.cases import each_case
from reference.comparisons import assert_matrices
from reference.elements import Section
from reference.scenes import DENSITY, E, G
from reference.train import BearingSpec, RigidSpec, ShaftPart, ShaftSpec, Train

HALF, DIAMETER, SPEED = 0.4, 0.03, 220.0
SUPPORT, DAMPING = np.diag([2e6, 3e6]), 400.0 * np.eye(2)
WHEEL = (6.0, 0.02, 0.035)
UNBALANCE = 1e-4j
COUPLING = gb.Coupling(
    ("a", HALF),
    ("b", 0.0),
    lateral_stiffness=4e6,
    tilting_stiffness=900.0,
    torsional_stiffness=3e4,
    lateral_damping=60.0,
    tilting_damping=0.3,
    torsional_damping=2.0,
    offset=1e-4 - 2e-4j,
    angle=1e-3 + 5e-4j,
    runout=3e-5 + 4e-5j,
)
RUN: dict[str, Any] = {"initial": "rest", "output_step": 1e-3}


def halves(coupling: gb.Coupling = COUPLING, **more: Any) -> gb.RotorSystem:
    """Return two shafts on three bearings, joined by a coupling."""
    places = [("a", 0.0), ("a", 0.3), ("b", HALF)]
    return gb.RotorSystem(
        [
            gb.Shaft(name, length=HALF, outer_diameter=DIAMETER, elements=2, material=MATERIAL)
            for name in "ab"
        ],
        bearings=[
            gb.Bearing(*place, stiffness=np.diag(SUPPORT), damping=np.diag(DAMPING))
            for place in places
        ],
        disks=[gb.Disk("wheel", "b", 0.2, *WHEEL, unbalance=UNBALANCE)],
        couplings=[coupling],
        **more,
    )


MATERIAL = gb.Material(E, DENSITY, shear_modulus=G)


def reference(coupling: gb.Coupling = COUPLING) -> Attached:
    section = Section(DIAMETER, E, G, DENSITY)
    train = Train(
        [ShaftSpec(name, [ShaftPart(HALF, section, 2)]) for name in "ab"],
        rigid=[RigidSpec("wheel", "b", 0.2, *WHEEL, UNBALANCE)],
        bearings=[
            BearingSpec(*place, SUPPORT, DAMPING) for place in [("a", 0.0), ("a", 0.3), ("b", HALF)]
        ],
    )
    found = Attached(train)
    hubs = [("a", HALF), ("b", 0.0)]
    node = found.node(*hubs[0]) - found.node(*hubs[1])
    found.spring(
        node,
        coupling.lateral_stiffness,
        coupling.lateral_damping,
        complex(coupling.offset),
        complex(coupling.runout),
    )
    found.spring(
        found.slopes(*hubs[0]) - found.slopes(*hubs[1]),
        coupling.tilting_stiffness,
        coupling.tilting_damping,
        complex(coupling.angle),
    )
    found.spring(
        found.twist(*hubs[0]) - found.twist(*hubs[1]),
        coupling.torsional_stiffness,
        coupling.torsional_damping,
    )
    return found


def test_matrices_are_those_of_the_independent_assembly():
    assert_matrices(halves(), reference())


def test_two_half_shafts_with_a_rigid_coupling_are_one_shaft():
    rigid = gb.Coupling(
        ("a", HALF),
        ("b", 0.0),
        lateral_stiffness=1e11,
        tilting_stiffness=1e9,
        torsional_stiffness=1e9,
    )
    two = halves(rigid)
    one = gb.RotorSystem(
        [gb.Shaft("a", length=2 * HALF, outer_diameter=DIAMETER, elements=4, material=MATERIAL)],
        bearings=[
            gb.Bearing("a", x, stiffness=np.diag(SUPPORT), damping=np.diag(DAMPING))
            for x in (0.0, 0.3, 2 * HALF)
        ],
        disks=[gb.Disk("wheel", "a", HALF + 0.2, *WHEEL, unbalance=UNBALANCE)],
        motion="coupled",
    )
    # the compliance of the coupling is 2e-5 of that of the shaft
    found, expected = (s.modes(SPEED).frequencies_hz[1:10] for s in (two, one))
    np.testing.assert_allclose(found, expected, rtol=1e-4)
    np.testing.assert_allclose(two.modes(SPEED, count=8).frequencies_hz[1:], found[:7], rtol=1e-6)
    found, expected = (s.synchronous([SPEED]).displacement("wheel").sum(axis=1) for s in (two, one))
    np.testing.assert_allclose(found, expected, rtol=1e-4)
    runs = [s.simulate(0.01, SPEED, record=["wheel"], rtol=1e-9, **RUN) for s in (two, one)]
    first, second = (run.displacement("wheel") for run in runs)
    np.testing.assert_allclose(first, second, rtol=0.0, atol=1e-4 * np.abs(second).max())


def test_the_offset_loads_the_bearings_as_a_spring_between_two_levers():
    # Rigid shafts on stiff bearings: only the coupling gives way.
    stiff = 1e12
    system = halves(replace(COUPLING, angle=0.0, runout=0.0)).replace(
        bearings=[gb.Bearing(n, x, stiffness=stiff) for n in "ab" for x in (0.0, HALF)]
    )
    static = system.static()
    # The hubs stand on bearings, so the whole offset stretches the coupling.
    force = 4e6 * (-1e-4 + 2e-4j)
    found = static.bearing_force(("a", HALF))
    np.testing.assert_allclose(found, [-force.real, -force.imag], rtol=1e-3)
    np.testing.assert_allclose(static.bearing_force(("b", 0.0)), -found, rtol=1e-3)


def test_statics_and_synchronous_response_are_those_of_the_independent_assembly():
    system, expected = halves(), reference()
    kept = np.array([direction != "twist" for *_, direction in system.dofs])
    q = np.zeros(expected.size)
    q[kept] = np.linalg.solve(expected.stiffness[np.ix_(kept, kept)], expected.steady[kept])
    wheel = expected.node("b", 0.2)
    np.testing.assert_allclose(system.static().displacement("wheel"), wheel @ q, rtol=1e-9)
    answer = system.synchronous([SPEED])
    total = answer.displacement("wheel")[0].sum(axis=0)
    np.testing.assert_allclose(total, wheel @ expected.synchronous(SPEED), rtol=1e-9)


@pytest.mark.parametrize(
    "options",
    [
        {"method": "exponential", "rtol": 1e-9},
        {"method": "rk45", "rtol": 1e-10},
        {"method": "rk4", "step": 2e-6},
        {"method": "etdrk4", "step": 1e-4},
    ],
    ids=lambda options: options["method"],
)
def test_every_method_gives_the_exact_motion(options: dict[str, Any]):
    system, expected = halves(), reference()
    run = system.simulate(0.02, SPEED, record=["wheel", ("a", HALF), "energy"], **RUN, **options)
    zero = np.zeros(expected.size)
    q, _ = expected.linear(SPEED).motion(run.time, zero, zero)
    for name, place in (("wheel", ("b", 0.2)), (("a", HALF), ("a", HALF))):
        exact = q @ expected.node(*place).T
        # the tolerance of the explicit methods
        np.testing.assert_allclose(
            run.displacement(name), exact, rtol=0.0, atol=3e-7 * np.abs(exact).max()
        )
    # the quadrature of the powers within a step
    assert np.abs(run.energy_balance().residual).max() < 1e-6 * run.energy.max()


def test_a_run_up_turns_the_runout_with_the_shaft():
    system = halves()
    ramp = gb.SpeedProfile.ramp(100.0, 300.0, 0.03)
    runs = [
        system.simulate(0.03, ramp, method=method, rtol=rtol, record=["wheel", "energy"], **RUN)
        for method, rtol in (("exponential", 1e-8), ("rk45", 1e-10))
    ]
    first, second = (run.displacement("wheel") for run in runs)
    np.testing.assert_allclose(first, second, rtol=0.0, atol=1e-6 * np.abs(second).max())
    for run in runs:
        assert np.abs(run.energy_balance().residual).max() < 1e-7 * run.energy.max()


def test_a_coupling_connects_speed_ratios_torques_and_loaded_flanks():
    shafts = [gb.Shaft(n, length=0.2, outer_diameter=0.04, elements=2) for n in "abc"]
    system = gb.RotorSystem(
        shafts,
        [gb.Gear(n, s, 0.1, teeth=z, module=3e-3, face_width=0.02) for n, s, z in GEARS],
        [gb.Mesh("g", "h", stiffness=2e8)],
        [gb.Bearing(n, x, stiffness=1e8) for n in "abc" for x in (0.0, 0.2)],
        [gb.Torque(("a", 0.0), -40.0), gb.Torque.balance("h")],
        couplings=[
            gb.Coupling(
                ("a", 0.2),
                ("b", 0.0),
                lateral_stiffness=1e6,
                tilting_stiffness=1e3,
                torsional_stiffness=1e5,
            )
        ],
        reference="c",
    )
    np.testing.assert_array_equal(system.speed_ratios, [-2.0, -2.0, 1.0])
    static = system.static(speed=-100.0)
    radius = 3e-3 * 25 / 2 * np.cos(np.radians(20.0))
    np.testing.assert_allclose(abs(static.mesh(("g", "h")).force), 40.0 / radius, rtol=1e-9)
    twist = static.twist(("b", 0.0)) - static.twist(("a", 0.2))
    np.testing.assert_allclose(twist, 40.0 / 1e5, rtol=1e-9)
    assert system.modes().names()[0] == "rigid-body rotation"


GEARS = [("g", "b", 25), ("h", "c", 50)]


def test_round_trip_in_a_file(tmp_path: Any):
    file = tmp_path / "scene.toml"
    halves().save(file)
    assert gb.RotorSystem.load(file).couplings == (COUPLING,)
    assert gb.RotorSystem.from_dict(halves().description).couplings == (COUPLING,)


@pytest.mark.implausible
@pytest.mark.parametrize("damping", [0.0, 1.0, 1e12])
@pytest.mark.parametrize("ratio", [1e-6, 1.0, 1e6, 1e12])
def test_an_extreme_coupling_has_the_torsion_of_the_closed_form(ratio: float, damping: float):
    """Two shafts with a disk at their outer ends; the ratio is that of coupling to shaft stiffness."""
    inertia, polar = 0.035, np.pi * DIAMETER**4 / 32.0
    shaft = G * polar / HALF
    spring = ratio * shaft
    system = gb.RotorSystem(
        [
            gb.Shaft(name, length=HALF, outer_diameter=DIAMETER, elements=4, material=MATERIAL)
            for name in "ab"
        ],
        disks=[
            gb.Disk("first", "a", 0.0, 6.0, 0.02, inertia),
            gb.Disk("last", "b", HALF, 6.0, 0.02, inertia),
        ],
        couplings=[
            gb.Coupling(
                ("a", HALF),
                ("b", 0.0),
                lateral_stiffness=1e6,
                tilting_stiffness=1e3,
                torsional_stiffness=spring,
                torsional_damping=damping,
            )
        ],
        torques=[gb.Torque("first", 10.0), gb.Torque("last", -10.0)],
        motion="torsion",
    )

    def torque(omega: float) -> float:
        """Torque at the hub of the mode in which the disks oppose each other, by the wave equation."""
        k = omega * np.sqrt(DENSITY / G)
        disk = inertia * omega**2 / (G * polar * k)
        hub = np.cos(k * HALF) - disk * np.sin(k * HALF)
        slope = -k * np.sin(k * HALF) - disk * k * np.cos(k * HALF)
        return float(G * polar * slope + 2.0 * spring * hub)

    lowest = np.sqrt(2.0 / (2.0 / shaft + 1.0 / spring) / inertia)
    expected = brentq(torque, 0.9 * lowest, 1.1 * lowest, xtol=1e-13, rtol=1e-13)
    extreme = 1e12 in (ratio, damping)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        static = system.static()
        run = system.simulate(1e-3, 100.0, output_step=1e-4, initial="static", record=["disks"])
        try:
            found = system.modes().frequencies_hz[1] * 2.0 * np.pi
        except gb.ConvergenceError as error:
            assert extreme
            assert "stiffnesses or masses of very different size" in str(error)  # noqa: PT017
            found = None
    warned = any("couplings[0]" in str(each.message) for each in caught)
    assert extreme or not warned
    # Springs in series; a damper does not act at rest. The limits are the round-off of the solution.
    twist = static.twist("first") - static.twist("last")
    assert twist == pytest.approx(10.0 * (2.0 / shaft + 1.0 / spring), rel=1e-8)
    if found is not None and damping == 0.0:
        # Four elements for 1/100 of a wave.
        assert found == pytest.approx(expected, rel=1e-6)
    moved = run.twist("first") - run.twist("last")
    assert warned or moved == pytest.approx(np.full(moved.size, twist), rel=1e-5)


@each_case(
    ("changes", "message"),
    [
        ({"a": ("c", 0.0)}, 'couplings[0].a: no shaft is called "c"'),
        ({"a": "whel"}, 'couplings[0].a: no gear or disk is called "whel"; did you mean "wheel"'),
        ({"b": ("a", 0.0)}, 'couplings[0].b: is on "a", as a is; a coupling joins two shafts'),
        ({"b": ("b", 0.9)}, "couplings[0].b: "),
        *(
            (
                {f"{direction}_{kind}": -1.0},
                f"couplings[0].{direction}_{kind}: must not be negative",
            )
            for direction in ("axial", "lateral", "tilting", "torsional")
            for kind in ("stiffness", "damping")
        ),
        ({"torsional_stiffness": (1.0, 2.0)}, "couplings[0].torsional_stiffness: must be a number"),
        ({"offset": complex(0, np.inf)}, "couplings[0].offset: must be finite"),
    ],
)
def test_an_invalid_coupling(changes: dict[str, Any], message: str):
    with pytest.raises(gb.SceneError, match="^" + re.escape(message)):
        halves(replace(COUPLING, **changes))


def test_a_coupling_between_shafts_of_different_speed():
    shafts = [gb.Shaft(n, length=0.2, outer_diameter=0.04, elements=2) for n in "bc"]
    with pytest.raises(gb.SceneError, match=r"^couplings\[0\]: joins \"b\" and \"c\", whose speed"):
        gb.RotorSystem(
            shafts,
            [gb.Gear(n, s, 0.1, teeth=z, module=3e-3, face_width=0.02) for n, s, z in GEARS],
            [gb.Mesh("g", "h", stiffness=2e8)],
            couplings=[
                gb.Coupling(
                    ("b", 0.2),
                    ("c", 0.0),
                    lateral_stiffness=1e6,
                    tilting_stiffness=1e3,
                    torsional_stiffness=1e5,
                )
            ],
        )
