"""Every linear answer carries the residual of the equations that it solves."""

from __future__ import annotations

import numpy as np
import pytest

import gearbow as gb
from reference import scenes
from reference.machines import rotor


def uniform(alpha: float, bearings: int = 0, elements: int = 40) -> gb.RotorSystem:
    """Return a uniform shaft with damping in proportion to the mass, which may be free."""
    ends = [gb.Bearing("rotor", x, stiffness=1e7, damping=100.0) for x in (0.0, 1.0)]
    damped = {"rayleigh": (alpha, 0.0), "motion": "coupled"}
    return rotor({"elements": elements}, bearings=ends[:bearings], **damped)


def force_left(system: gb.RotorSystem, modes: gb.results.Modes) -> np.ndarray:
    """Return the force that each mode leaves, relative to its forces, from the dense matrices."""
    found, speed = system.matrices(modes.speed), modes.speed
    rate = found.damping + speed * found.gyroscopic
    left = []
    for value, shape in zip(modes.eigenvalues, modes.shapes, strict=True):
        forces = (value**2 * found.mass @ shape, value * rate @ shape, found.stiffness @ shape)
        left.append(np.linalg.norm(sum(forces)) / sum(np.linalg.norm(force) for force in forces))
    return np.array(left)


@pytest.mark.parametrize("alpha", [5.0, 5000.0])
@pytest.mark.parametrize("bearings", [0, 2])
def test_modes_of_damped_rigid_motions_satisfy_the_equations(alpha: float, bearings: int):
    # λ = 0 and λ = −α belong to each motion without stiffness; the other modes have parts of it
    system = uniform(alpha, bearings)
    modes = system.modes(100.0, count=12)
    assert len(system.dofs) > 100  # band matrices
    moving = modes.eigenvalues != 0.0
    assert (modes.eigenvalues[~moving].size, modes.whirl[0]) == (1 if bearings else 5, "rigid")
    assert np.abs(modes.eigenvalues + alpha).min() < 1e-6 * alpha
    # Round-off of a rigid motion is ε ω_max²/α² of its forces, up to 1e-7.
    assert force_left(system, modes)[moving].max() < 1e-6
    # In the energy norm it is ε ω_max/α.
    assert modes.residuals.max() < 1e-9
    few, all_modes = modes.eigenvalues, system.modes(100.0).eigenvalues
    # A double eigenvalue −α has an error of the root of ε.
    assert max(np.abs(all_modes - value).min() / abs(value) for value in few[moving]) < 1e-6


def test_the_torsion_of_a_free_rotor_with_a_damper_contains_its_rotation():
    # A drive without stiffness holds no rotation; its damper couples rotation and torsion.
    shaft = gb.Shaft("s", length=1.0, outer_diameter=0.03, elements=110)
    system = gb.RotorSystem(
        [shaft],
        disks=[gb.Disk("d", "s", 1.0, 5.0, 0.02, 0.04)],
        torques=[gb.Torque(("s", 0.0), gb.SpeedTable([0.0, 200.0], [5.0, -5.0]))],
        motion="torsion",
    )
    modes = system.modes(100.0, count=4)
    assert len(system.dofs) > 100
    assert modes.eigenvalues[1].real < 0.0 == modes.eigenvalues[1].imag
    assert force_left(system, modes)[1:].max() < 1e-6  # as above
    assert modes.residuals.max() < 1e-9


@pytest.mark.parametrize("modal_damping", [None, 0.02])
@pytest.mark.parametrize("elements", [4, 24])
def test_modes_carry_their_residuals(elements: int, modal_damping: float | None):
    # dense and band matrices, with and without modal damping
    system = scenes.Geared(elements=elements, modal_damping=modal_damping).package()
    modes = system.modes(100.0, count=8)
    assert modes.residuals.shape == modes.eigenvalues.shape
    # Spaces for modal damping end at errors of 1e-8.
    assert 0.0 < modes.residuals.max() < 1e-7


@pytest.mark.parametrize("modal_damping", [None, 0.02])
@pytest.mark.parametrize("elements", [4, 24])
def test_synchronous_responses_carry_their_residuals(elements: int, modal_damping: float | None):
    bows = {"middle": scenes.HalfSine(1e-4, 0.5)}
    system = scenes.Geared(elements=elements, modal_damping=modal_damping, bows=bows).package()
    found = system.synchronous([-300.0, 0.0, 100.0])
    assert found.residuals.shape == (3,)
    # The solvers end at 1e-11.
    assert 0.0 < found.residuals.max() < 1e-10


def test_intersections_thresholds_and_critical_speeds_carry_their_residuals():
    system = scenes.v1()
    campbell = system.campbell(np.linspace(1.0, 400.0, 5), count=6)
    assert campbell.intersections
    assert max(each.residual for each in campbell.intersections) < 1e-9
    cross = gb.SpeedTable(
        [0.0, 400.0], [[[1e7, 0.0], [0.0, 1e7]], [[1e7, 1e6], [-1e6, 1e7]]], outside="hold"
    )
    rotor = gb.RotorSystem(
        [gb.Shaft("s", length=1.0, outer_diameter=0.05)],
        disks=[gb.Disk("d", "s", 0.5, 20.0, 0.1, 0.2)],
        bearings=[gb.Bearing("s", x, stiffness=cross, damping=300.0) for x in (0.0, 1.0)],
    )
    (threshold, *_) = rotor.campbell([0.0, 200.0, 400.0], count=2).thresholds
    # The root of Re λ has the tolerance 1e-12 of the speed.
    assert 0.0 <= threshold.residual < 1e-9
    found = scenes.v2().critical_speed_map([1e6, 1e8], count=6)
    assert all(0.0 <= residual < 1e-9 for row in found.residuals for residual in row)


@pytest.mark.parametrize("elements", [8, 40])
def test_equal_overdamped_modes_do_not_oscillate_by_round_off(elements: int) -> None:
    system = rotor({"elements": elements}, bearing={"stiffness": 1e8, "damping": 1e6})
    values = system.modes(0.0, count=10).eigenvalues
    # The planes are equal, and nothing turns: eigenvalues are real in pairs. Round-off had left 1e-13 of them.
    assert not np.any((values.imag != 0.0) & (values.imag < 1e-9 * np.abs(values)))
    # Each plane relaxes at both bearings; its faster motions are not among the ten lowest.
    assert np.count_nonzero(values.imag == 0.0) == 4
