"""Springs far stiffer than their shaft: every analysis has the limit of a rigid one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg

import gearbow as gb
from reference.machines import hostile, rotor

# The tests check results that come with an accuracy warning.
pytestmark = [
    pytest.mark.implausible,
    pytest.mark.filterwarnings("ignore::gearbow.AccuracyWarning"),
]

PLACE = ("middle", 0.0)
STIFFNESSES = (1e12, 1e20, 1e60, 1e100)


def held(stiffness: float) -> gb.RotorSystem:
    """Return the hostile machine with another stiffness of one bearing."""
    system = hostile()
    return system.replace(
        bearings=[
            replace(bearing, stiffness=stiffness)
            if (bearing.shaft, bearing.position) == PLACE
            else bearing
            for bearing in system.bearings
        ]
    )


def pinned(speed: float) -> np.ndarray:
    """Return the eigenvalues with Im λ > 0 of the machine whose shaft cannot move across the axis at the bearing."""
    system = hostile()
    m = system.matrices(speed)
    free = [i for i, (on, x, kind) in enumerate(m.dofs) if (on, x) != PLACE or kind not in "vw"]
    mass, stiffness, rate = (
        matrix[np.ix_(free, free)]
        for matrix in (m.mass, m.stiffness, m.damping + speed * m.gyroscopic)
    )
    zero, one = np.zeros_like(mass), np.eye(len(mass))
    values = scipy.linalg.eig(
        np.block([[zero, one], [-stiffness, -rate]]),
        np.block([[one, zero], [zero, mass]]),
        right=False,
    )
    values = values[values.imag > 1.0]
    return values[np.argsort(np.abs(values))]


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("stiffness", STIFFNESSES)
def test_modes_are_those_of_a_pinned_shaft(stiffness: float, sense: float):
    wanted = pinned(200.0 * sense)[:6]
    for count in (8, None):
        found = held(stiffness).modes(200.0 * sense, count=count).eigenvalues
        found = found[found.imag > 1.0][:6]
        # 1e12 N/m are 1e4 times the stiffness of the shaft; dense decompositions leave 1e-7.
        np.testing.assert_allclose(found, wanted, rtol=1e-4 if stiffness < 1e15 else 1e-6)


@pytest.mark.parametrize("stiffness", [1e20, 1e60, 1e100])
def test_equilibrium_response_and_run_are_those_of_a_stiff_bearing(stiffness: float):
    def results(stiffness: float) -> list[np.ndarray]:
        system, place = held(stiffness), ("middle", 0.2)
        static, response = system.static(200.0), system.synchronous([-200.0, 200.0])
        run = system.simulate(2e-3, 200.0, record=[place, ("bearing", *PLACE)], times=[1e-3, 2e-3])
        return [
            static.displacement(place),
            static.bearing_force(PLACE),
            response.displacement(place),
            run.displacement(place),
            run.bearing_force(PLACE),
        ]

    for found, wanted in zip(results(stiffness), results(1e14), strict=True):
        # 1e14 N/m are 1e6 times the stiffness of the shaft, and runs have a tolerance of 1e-6.
        np.testing.assert_allclose(found, wanted, atol=1e-5 * np.abs(wanted).max())


def test_one_rigid_direction_leaves_the_other_one():
    soft, rigid = (
        rotor(bearing={"stiffness": stiffness}).modes(0.0, count=2).frequencies_hz
        for stiffness in ((1e8, 1e8), (1e8, 1e60))
    )
    assert rigid[0] == pytest.approx(soft[0], rel=1e-9)
    assert rigid[1] > 1.01 * soft[1]


def test_a_table_a_housing_a_coupling_and_a_drive_are_limited_alike():
    shafts = [gb.Shaft(name, length=0.5, outer_diameter=0.05, elements=3) for name in "ab"]

    def lowest(stiffness: float) -> np.ndarray:
        table = gb.SpeedTable([0.0, 100.0], [stiffness, stiffness])
        base = gb.Housing("base", mass=10.0, stiffness=stiffness)
        system = gb.RotorSystem(
            shafts,
            bearings=[
                gb.Bearing("a", 0.0, stiffness=table, damping=10.0),
                gb.Bearing("a", 0.5, stiffness=1e8, support="base"),
                gb.Bearing("b", 0.5, stiffness=1e8, axial_stiffness=stiffness),
            ],
            housings=[base],
            couplings=[
                gb.Coupling(
                    ("a", 0.5),
                    ("b", 0.0),
                    torsional_stiffness=stiffness,
                    lateral_stiffness=stiffness,
                    tilting_stiffness=1e5,
                    axial_stiffness=1e6,
                )
            ],
            drives=[gb.Drive(("a", 0.0), stiffness=stiffness)],
        )
        return system.modes(50.0, count=6).eigenvalues

    np.testing.assert_allclose(np.abs(lowest(1e60)), np.abs(lowest(1e14)), rtol=1e-4)
