"""Bearings that stand off their places, against beams and the forces that have the same effect."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gearbow as gb

LENGTH, DIAMETER, STIFFNESS, OFF = 2.0, 0.05, 1e8, 20e-6 + 35e-6j


def rotor(off: complex = 0j, forces: Any = (), **middle: Any) -> gb.RotorSystem:
    """Give a slender shaft on three bearings, of which the middle one is off."""
    bearings = [
        gb.Bearing("rotor", 0.0, stiffness=STIFFNESS, damping=200.0),
        gb.Bearing("rotor", 1.0, stiffness=STIFFNESS, damping=200.0, misalignment=off, **middle),
        gb.Bearing("rotor", LENGTH, stiffness=STIFFNESS, damping=200.0),
    ]
    shafts = [gb.Shaft("rotor", length=LENGTH, outer_diameter=DIAMETER, elements=8)]
    if "support" in middle:
        shafts.append(
            gb.Shaft("tube", length=1.0, outer_diameter=0.1, inner_diameter=0.08, speed_ratio=1.0)
        )
        bearings += [gb.Bearing("tube", x, stiffness=STIFFNESS, damping=200.0) for x in (0.0, 1.0)]
    return gb.RotorSystem(shafts=shafts, bearings=bearings, forces=forces, rayleigh=(30.0, 0.0))


def test_a_shaft_on_three_bearings_is_bent_by_the_one_that_is_off():
    """The forces are those of a beam on springs, F = e/(l³/48EI + l/4κGA + 3/2k)."""
    found = rotor(OFF).static()
    inertia, area = np.pi / 64 * DIAMETER**4, np.pi / 4 * DIAMETER**2
    shear = 207e9 / 2.6 * area * 6 * 1.3 / (7 + 6 * 0.3)
    compliance = LENGTH**3 / (48 * 207e9 * inertia) + LENGTH / (4 * shear) + 1.5 / STIFFNESS
    expected = OFF / compliance
    # the bearing pushes the shaft to where it stands
    assert complex(*found.bearing_force(("rotor", 1.0))) == pytest.approx(-expected, rel=2e-5)
    assert complex(*found.bearing_force(("rotor", 0.0))) == pytest.approx(expected / 2, rel=2e-5)


@pytest.mark.parametrize("base", [None, ("tube", 0.5)])
def test_it_moves_the_shaft_as_a_pair_of_forces_does(base: Any):
    force = STIFFNESS * OFF
    forces = [gb.Force(("rotor", 1.0), force)]
    named: dict[str, Any] = {}
    if base is not None:
        forces.append(gb.Force(base, -force))
        named = {"support": base}
    off, pushed = rotor(OFF, **named), rotor(0j, forces, **named)
    found, expected = off.static(), pushed.static()
    assert found.state == pytest.approx(expected.state, rel=1e-9, abs=1e-15)
    apart = found.bearing_force(("rotor", 1.0)) - expected.bearing_force(("rotor", 1.0))
    assert complex(*apart) == pytest.approx(-force, rel=1e-9)
    assert off.modes(count=6).eigenvalues == pytest.approx(pushed.modes(count=6).eigenvalues)


def test_a_run_from_rest_keeps_the_energy_and_ends_in_the_equilibrium():
    train = rotor(OFF)
    still = train.static()
    run = train.simulate(
        1.5, 0.0, initial="rest", record=[("rotor", 1.0), "bearings", "energy"], output_step=0.01
    )
    end = run.bearing_force(("rotor", 1.0))[-1]
    assert end == pytest.approx(still.bearing_force(("rotor", 1.0)), rel=1e-2)
    balance = run.energy_balance()
    assert np.abs(balance.residual).max() < 1e-7 * balance.total.max()


@pytest.mark.parametrize(
    "middle",
    [
        {"stiffness": gb.SpeedTable([0.0, 100.0], [1e8, 2e8])},
        {"stiffness": STIFFNESS, "damping": gb.SpeedTable([0.0, 100.0], [1e2, 2e2])},
    ],
)
def test_coefficients_that_depend_on_the_speed_are_an_error(middle: dict[str, Any]):
    shaft = gb.Shaft("rotor", length=1.0, outer_diameter=0.05)
    bearings = [
        gb.Bearing("rotor", 0.0, stiffness=1e8),
        gb.Bearing("rotor", 1.0, **middle, misalignment=1e-5),
    ]
    with pytest.raises(gb.SceneError, match=r"bearings\[1\]\.misalignment: is that of a linear"):
        gb.RotorSystem(shafts=[shaft], bearings=bearings)
