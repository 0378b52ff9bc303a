"""A bow turns with the twist of its shaft: the gear of a stiff shaft moves like one with run-out."""

from __future__ import annotations

import numpy as np
import pytest

import gearbow as gb
from reference.machines import inertia, pair

OFFSET = 1e-4  # of the gear from the line of its bearings, m
BASE = 0.05 * np.cos(np.radians(20.0)) * np.array([1.0, 2.0])  # base radii, m
LENGTH, DIAMETER = 0.2, 0.15
INERTIA = np.array([0.04, 0.6]) + 7850.0 * np.pi * DIAMETER**4 / 32 * LENGTH  # kg m²
#: Mass of both gears along the line of action, kg.
REDUCED = 1.0 / np.sum(BASE**2 / INERTIA)


def system(offset: str, torque: float) -> gb.RotorSystem:
    """Two gears between stiff bearings; the first is off its axis by a bow of its shaft or by run-out."""
    bow = gb.Bow.half_sine(OFFSET) if offset == "bow" else None
    runout = {"runout": OFFSET} if offset == "run-out" else {}
    return pair(
        ("a", "b"),
        ("ga", "gb"),
        shaft={"length": LENGTH, "outer_diameter": DIAMETER, "elements": 4},
        own={
            "a": {"bow": bow},
            "ga": inertia(10.0, 0.02, 0.04, **runout),
            "gb": inertia(40.0, 0.3, 0.6),
        },
        gear={"module": 4e-3, "face_width": None},
        mesh={"stiffness": 1e9, "damping_ratio": 0.2},
        bearing={"stiffness": 1e10, "damping": 1e5},
        torque=torque,
    )


def first_order(offset: str, torque: float, speed: float) -> complex:
    """Amplitude of the mesh force at one per revolution of the first shaft, N."""
    period = 2 * np.pi / speed
    # Damping removes the initial transient in two revolutions.
    times = np.linspace(2 * period, 4 * period, 401)[:-1]
    run = system(offset, torque).simulate(4 * period, speed, initial="static", times=times)
    return complex(2 * np.mean(run.mesh(("ga", "gb")).force * np.exp(-1j * speed * run.time)))


# Shafts, bearings and teeth that are not rigid change the amplitudes by less than 2 %.
STIFF = 0.02


def test_without_torque_a_bow_moves_the_gears_like_a_runout():
    bow, runout = (first_order(offset, 0.0, 300.0) for offset in ("bow", "run-out"))
    assert abs(bow) == pytest.approx(REDUCED * 300.0**2 * OFFSET, rel=STIFF)
    assert runout == pytest.approx(bow, rel=1e-2)


@pytest.mark.parametrize(("torque", "speed"), [(500.0, 100.0), (2000.0, 300.0)])
def test_under_torque_a_bow_has_the_moment_of_a_runout(torque: float, speed: float):
    bow, runout = (first_order(offset, torque, speed) for offset in ("bow", "run-out"))
    force = torque / BASE[0]
    moment = REDUCED * BASE[0] / INERTIA[0] * force * OFFSET  # as a mesh force, N
    inertial = REDUCED * speed**2 * OFFSET
    assert abs(runout) == pytest.approx(np.hypot(inertial, moment), rel=STIFF)
    # Without the moment, the difference would be 40 % and 21 % of the force.
    assert abs(bow - runout) < 2e-3 * abs(runout)


def test_a_bow_and_a_runout_give_the_same_motion_where_a_drive_holds_the_rotation():
    times = np.linspace(0.0, 0.2, 401)[200:]  # damping has removed the initial transient
    twists = []
    for offset in ("bow", "run-out"):
        held = system(offset, 2000.0).replace(
            torques=[gb.Torque("gb", 4000.0)],
            drives=[gb.Drive("ga", stiffness=2e4, damping=100.0)],
        )
        run = held.simulate(0.2, 100.0, initial="static", times=times)
        twists.append(np.array([run.twist(gear) for gear in ("ga", "gb")]))
    bow, runout = twists
    # The shafts twist by 1e-3 of the motion, and the gears move as in the first test.
    assert np.abs(bow - runout).max() < 1e-2 * np.ptp(runout, axis=1).max()


def test_the_energy_balance_contains_the_work_on_the_twist():
    run = system("bow", 2000.0).simulate(
        0.05, 300.0, initial="static", record=["energy"], rtol=1e-9
    )
    balance = run.energy_balance()
    assert np.abs(balance.drive).max() > 1.0  # J
    # a hundred times the tolerance
    assert np.abs(balance.residual).max() < 1e-7 * np.abs(balance.drive).max()
