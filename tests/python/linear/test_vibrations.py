"""`modes(count=, vibrating=True)` beside all modes from dense matrices, where many motions are overdamped."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gearbow as gb

FILM = {"diameter": 0.05, "length": 0.02, "clearance": 5e-5, "viscosity": 0.02}


def rotor(*bearings, internal_damping: float = 0.0) -> gb.RotorSystem:
    return gb.RotorSystem(
        shafts=[
            gb.Shaft(
                "s",
                length=1.0,
                outer_diameter=0.05,
                elements=40,
                internal_damping=internal_damping,
            )
        ],
        disks=[gb.Disk("d", "s", 0.4, mass=20.0, diametral_inertia=0.1, polar_inertia=0.2)],
        bearings=bearings,
        gravity=9.81,
    )


def stiff(damping: float) -> list[gb.Bearing]:
    return [gb.Bearing("s", x, stiffness=5e7, damping=damping) for x in (0.0, 1.0)]


CASES = {
    "internal damping": rotor(*stiff(1e3), internal_damping=1e-4),
    "strong internal damping": rotor(*stiff(1e3), internal_damping=2e-3),
    "strong dampers": rotor(*stiff(3e5)),
    "oil films": rotor(*(gb.JournalBearing("s", x, **FILM) for x in (0.0, 1.0))),
    "light damping": rotor(*stiff(100.0)),
    "no damping": rotor(*stiff(0.0)),
    "one free shaft": rotor(
        replace(stiff(1e3)[0], tilting_stiffness=0.0), internal_damping=1e-4
    ).replace(gravity=0.0),
}


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("count", [1, 4, 12])
def test_vibrations_are_those_of_all_modes(name, count):
    system, speed = CASES[name], 200.0
    found = system.modes(speed, count=count, vibrating=True).eigenvalues
    every = system.modes(speed).eigenvalues
    every = every[every.imag > 0.05 * np.abs(every)]
    wanted = every[np.argsort(every.imag)][:count]
    assert len(found) == count
    # The dense eigensolver leaves 1e-8 where the damping of the highest modes is much larger.
    assert np.abs(found.imag - wanted.imag).max() < 1e-6 * np.abs(wanted).max()
    assert np.abs(found.real - wanted.real).max() < 1e-6 * np.abs(wanted).max()
