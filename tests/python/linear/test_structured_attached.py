"""Band matrices with a housing, a coupling, a drive and loads, against dense linear algebra and complete runs."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference.comparisons import error
from test_structured_solver import (
    assert_lowest_modes,
    assert_response_with_modal_damping,
    round_off,
    through_dense_matrices,
)

pytestmark = pytest.mark.implausible

HOUSING = gb.Housing(
    "box",
    mass=40.0,
    stiffness=[[8e7, 1e7], [1e7, 6e7]],
    damping=(900.0, 700.0),
    inertia=(0.8, 1.4, 1.9),
    position=(0.2, 0.05, -0.1),
    rotational_stiffness=(2e6, 9e6, 7e6),
    rotational_damping=(30.0, 20.0, 10.0),
)
PEDESTAL = gb.Support("pedestal", mass=3.0, stiffness=(4e7, 2e7), damping=150.0)
COUPLING = gb.Coupling(
    ("motor", 0.3),
    ("input", 0.0),
    lateral_stiffness=1e7,
    tilting_stiffness=2e3,
    torsional_stiffness=1e5,
    lateral_damping=40.0,
    tilting_damping=1.0,
    torsional_damping=3.0,
)
DRIVE = gb.Drive(("motor", 0.0), stiffness=4e4, damping=5.0)
TABLE = gb.SpeedTable([0.0, 100.0, 300.0, 600.0], [-260.0, -250.0, -210.0, -120.0])


def train(
    *,
    elements: int = 9,
    damping: float = 300.0,
    stiffness: Any = ((1e8, 1.01e7), (0.99e7, 8e7)),
    housing: gb.Housing = HOUSING,
    **more: Any,
) -> gb.RotorSystem:
    """Return a motor, a coupling and a pair of gears in a housing, with more than 150 coordinates."""
    tooth = {"module": 3e-3, "face_width": 0.03}
    places = [("input", 0.05), ("input", 0.4), ("output", 0.0), ("output", 0.4)]
    bearing = {"stiffness": stiffness, "damping": damping}
    parts: dict[str, Any] = {
        "gears": [
            gb.Gear("g1", "input", 0.25, 25, **tooth, unbalance=1e-4),
            gb.Gear("g2", "output", 0.2, 50, **tooth),
        ],
        "meshes": [gb.Mesh("g1", "g2", stiffness=2e8, damping_ratio=0.05 if damping else 0.0)],
        "torques": [gb.Torque("g2", -250.0)],
        "gravity": (1.0, -9.0),
        "couplings": [COUPLING],
        "drives": [DRIVE],
    }
    return gb.RotorSystem(
        shafts=[
            gb.Shaft(name, length=length, outer_diameter=0.05, elements=elements, degree=1)
            for name, length in (("motor", 0.3), ("input", 0.4), ("output", 0.4))
        ],
        bearings=[
            *(gb.Bearing(*place, **bearing, support="box") for place in places),
            gb.Bearing("motor", 0.1, **bearing, support="pedestal"),
            gb.Bearing("motor", 0.25, **bearing),
        ],
        supports=[PEDESTAL if damping else replace(PEDESTAL, damping=0.0)],
        housings=[housing],
        **{**parts, **more},
    )


def undamped() -> gb.RotorSystem:
    none = (0.0, 0.0, 0.0)
    return train(
        damping=0.0,
        stiffness=(1e8, 8e7),
        housing=replace(HOUSING, damping=0.0, rotational_damping=none),
        couplings=[
            replace(COUPLING, lateral_damping=0.0, tilting_damping=0.0, torsional_damping=0.0)
        ],
        drives=[replace(DRIVE, damping=0.0)],
    )


SYSTEMS: dict[str, Any] = {
    "damped": train,
    "undamped": undamped,
    "strongly damped": lambda: train(damping=1e5, stiffness=(1e8, 8e7)),
    "torque over the speed": lambda: train(torques=[gb.Torque("g2", TABLE)]),
    "bearing over the speed": lambda: train(
        stiffness=gb.SpeedTable([0.0, 500.0], [5e7, 2e8]), damping=300.0
    ),
    "no drive": lambda: train(drives=[], torques=[gb.Torque("g1", 50.0), gb.Torque.balance("g2")]),
    "free to turn": lambda: train(
        housing=replace(HOUSING, rotational_stiffness=(0.0, 0.0, 0.0)),
        couplings=[
            replace(COUPLING, lateral_damping=0.0, tilting_damping=0.0, torsional_damping=0.0)
        ],
    ),
}


@pytest.mark.parametrize("name", SYSTEMS)
def test_the_lowest_modes_are_those_of_dense_matrices(name: str):
    system = SYSTEMS[name]()
    assert len(system.dofs) >= 150
    for speed in (0.0, 230.0):
        assert_lowest_modes(system, speed)


@pytest.mark.parametrize("name", ["damped", "torque over the speed", "bearing over the speed"])
def test_the_campbell_diagram_is_that_of_dense_matrices(name: str):
    system = SYSTEMS[name]()
    speeds = np.linspace(0.0, 450.0, 3)
    found = system.campbell(speeds, count=6)
    wanted = through_dense_matrices(system).campbell(speeds, count=6)
    highest = np.abs(system.modes(0.0).eigenvalues).max()
    size = np.abs(wanted.eigenvalues)
    assert np.all(np.abs(found.eigenvalues - wanted.eigenvalues) <= round_off(highest, size) * size)
    assert len(found.intersections) == len(wanted.intersections) > 2
    for one, other in zip(found.intersections, wanted.intersections, strict=True):
        assert (one.mode, one.line) == (other.mode, other.line)
        assert one.speed == pytest.approx(other.speed, rel=1e-8)
        # A mode has the frequency of the line at the speed of the intersection.
        modes = system.modes(one.speed, count=10).eigenvalues
        assert np.abs(modes.imag - one.line.order * one.speed).min() < 1e-8 * one.speed


def test_the_critical_speeds_are_those_of_dense_matrices():
    for system, stiffness in ((train(), 1e6), (SYSTEMS["no drive"](), 1e9)):
        highest = 100 * np.abs(system.modes(0.0).eigenvalues).max()
        found = system.critical_speed_map([stiffness], count=7)
        wanted = system.critical_speed_map([stiffness])
        for one, other in zip(found.speeds, wanted.speeds, strict=True):
            assert np.all(np.abs(one - other[:7]) <= round_off(highest, other[:7]) * other[:7])


@pytest.mark.parametrize("name", SYSTEMS)
def test_the_synchronous_response_is_that_of_dense_matrices(name: str):
    if name == "free to turn":
        pytest.skip("the dense inverse of a free body has the round-off of its zero frequency")
    system = SYSTEMS[name]().replace(modal_damping=0.02)
    assert_response_with_modal_damping(system, [17.0, 150.0, 400.0])


@pytest.mark.parametrize("name", ["damped", "torque over the speed", "no drive"])
def test_sparse_matrices_are_the_dense_ones(name: str):
    system = SYSTEMS[name]()
    sparse, dense = system.matrices(150.0, sparse=True), system.matrices(150.0)
    for key in ("mass", "stiffness", "damping", "gyroscopic"):
        wanted = getattr(dense, key)
        found = getattr(sparse, key).toarray()
        assert np.abs(found - wanted).max() <= 1e-15 * np.abs(wanted).max()


def test_the_equilibrium_is_that_of_dense_matrices():
    system = train()
    matrices = system.matrices()
    load = np.zeros(len(matrices.dofs))
    for index, (_, position, direction) in enumerate(matrices.dofs):
        if position is not None and direction in ("v", "w"):
            load[index] = system.gravity["vw".index(direction)]
    load = matrices.mass @ load
    load[matrices.dofs.index(("output", 0.2, "twist"))] -= 250.0
    wanted = np.linalg.solve(matrices.stiffness, load)
    found = system.static(geometry="frozen").state
    # round-off of the dense solution: the condition of K, whose highest frequency is 1e4 times the lowest
    assert np.abs(found - wanted).max() <= 1e-8 * np.abs(wanted).max()


def test_a_housing_without_stiffness_about_its_own_axis():
    """Bearings on the axis of the housing leave its rotation about this axis free of any force."""

    def static(stiffness: float) -> np.ndarray:
        box = gb.Housing(
            "box",
            mass=9.0,
            stiffness=1e7,
            inertia=(0.1, 0.2, 0.2),
            position=(0.2, 0.0, 0.0),
            rotational_stiffness=(stiffness, 1e6, 1e6),
        )
        system = gb.RotorSystem(
            [gb.Shaft("s", length=0.4, outer_diameter=0.04, elements=30, degree=1)],
            bearings=[gb.Bearing("s", x, stiffness=1e8, support="box") for x in (0.0, 0.4)],
            housings=[box],
            gravity=9.81,
            motion="coupled",
        )
        return system.static().state

    # the same motion, but for the round-off of the weights
    wanted = static(1e5)
    assert np.abs(static(0.0) - wanted).max() <= 1e-9 * np.abs(wanted).max()


RAMP = gb.SpeedProfile.ramp(180.0, 220.0, 0.3)


# the shafts give their numbers of elements
@pytest.mark.filterwarnings("ignore:accuracy:gearbow.AccuracyWarning")
@pytest.mark.parametrize("speed", [200.0, RAMP], ids=["constant", "ramp"])
@pytest.mark.parametrize("name", ["damped", "torque over the speed"])
def test_a_reduced_run_has_the_signals_of_the_complete_one(name: str, speed: Any):
    system = SYSTEMS[name]().replace(
        meshes=[gb.Mesh("g1", "g2", stiffness=gb.Stiffness.square(pair=2e8), damping_ratio=0.05)],
        forces=[gb.Force(("motor", 0.0), 300.0, order=1.0), gb.Force("g2", 2e3, order=0.5)],
        shafts=[replace(shaft, elements=18) for shaft in train().shafts],
        # Undamped modes represent strong dampers badly.
        drives=[replace(DRIVE, damping=0.1)],
        couplings=[replace(COUPLING, tilting_damping=0.05, torsional_damping=0.03)],
    )
    assert len(system.dofs) >= 250
    exact = system.simulate(0.1, speed, rtol=1e-6, output_step=2e-4)
    found = system.simulate(0.31, speed, accuracy="engineering", times=exact.time)
    assert found.statistics.modes < 0.9 * len(system.dofs)

    # Twice the error that the level permits: the estimate of the error has an uncertainty of a factor of two.
    for gear in ("g1", "g2"):
        assert error(found.displacement(gear), exact.displacement(gear)) < 2e-3
    assert error(found.mesh(("g1", "g2")).force, exact.mesh(("g1", "g2")).force) < 2e-2


def test_powers_of_links_and_loads_balance_the_energy():
    # the first shaft has no bow, and the second one has
    shafts = [replace(shaft, elements=4) for shaft in train().shafts]
    shafts[1] = replace(shafts[1], bow=gb.Bow.half_sine(1e-4, phase=0.4))
    system = train(elements=4).replace(
        shafts=shafts,
        torques=[gb.Torque("g2", TABLE)],
        couplings=[replace(COUPLING, offset=2e-5 + 1e-5j, angle=1e-4j, runout=3e-5)],
        forces=[
            gb.Force("g1", 40.0 - 10j),
            gb.Force("g1", 60.0, order=1.0),
            gb.Force(("input", 0.1), 30.0, order=2.0),
        ],
    )
    options = {"initial": "rest", "output_step": 1e-3, "record": ["g1", "energy"]}
    one = system.simulate(0.02, 150.0, method="exponential", rtol=1e-9, **options)
    other = system.simulate(0.02, 150.0, method="rk45", rtol=1e-9, **options)
    for run in (one, other):
        assert np.abs(run.energy_balance().residual).max() < 1e-7 * run.energy.max()
