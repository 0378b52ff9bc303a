"""Bearings between two shafts: closed forms of two rigid rotors, numbers of ROSS, and every analysis.

Two rigid symmetric rotors share their middle. The inner one stands on two ground bearings k₁ at ±a, and the outer one on
two bearings k₂ at ±b between both. Then translation and tilt separate, and each has two degrees of freedom.
"""

import dataclasses

import numpy as np
import pytest

import gearbow as gb
from gearbow.results import Response

RIGID = gb.Material(1e15, 1.0, poisson_ratio=0.3)
INNER_MASS, OUTER_MASS = 20.0, 12.0
INNER_INERTIA, OUTER_INERTIA = (0.5, 0.4), (0.3, 0.45)  # diametral, polar
GROUND, BETWEEN = 4e6, 3e6
A, B = 0.5, 0.25
RATIO = -1.5
SPEED = 300.0


def pair(ground=None, between=None, **options):
    """Two rigid rotors, with other bearings if given."""
    ground = ground or (lambda x: gb.Bearing("inner", x, stiffness=GROUND, damping=300.0))
    between = between or (
        lambda x, at: gb.Bearing("outer", x, stiffness=BETWEEN, damping=200.0, support=at)
    )
    given = {
        "shafts": [
            gb.Shaft("inner", length=1.0, outer_diameter=0.05, elements=4, material=RIGID),
            gb.Shaft(
                "outer",
                length=0.5,
                outer_diameter=0.2,
                inner_diameter=0.1,
                elements=2,
                material=RIGID,
                speed_ratio=RATIO,
            ),
        ],
        "disks": [
            gb.Disk("fan", "inner", 0.5, INNER_MASS, *INNER_INERTIA, unbalance=2e-3),
            gb.Disk("drum", "outer", 0.25, OUTER_MASS, *OUTER_INERTIA, unbalance=1e-3j),
        ],
        "bearings": [
            *(ground(x) for x in (0.0, 1.0)),
            *(between(x, ("inner", x + 0.25)) for x in (0.0, 0.5)),
        ],
    }
    return gb.RotorSystem(**{**given, **options})


def closed_form(speed=SPEED):
    """Mass, damping with gyroscopic moments, and stiffness of translation and of tilt."""
    # The shafts have a thousandth of the mass of the disks: their masses and inertias count too.
    area = [np.pi / 4 * 0.05**2, np.pi / 4 * (0.2**2 - 0.1**2)]
    own = [area[0] * 1.0, area[1] * 0.5]
    radii = [0.05**2 / 16, (0.2**2 + 0.1**2) / 16]
    diametral = [m * (length**2 / 12 + r) for m, length, r in zip(own, (1.0, 0.5), radii, strict=True)]
    polar = [2 * m * r for m, r in zip(own, radii, strict=True)]
    k = np.array([[2 * (GROUND + BETWEEN), -2 * BETWEEN], [-2 * BETWEEN, 2 * BETWEEN]])
    c = np.array([[2 * (300.0 + 200.0), -2 * 200.0], [-2 * 200.0, 2 * 200.0]])
    m = np.diag([INNER_MASS + own[0], OUTER_MASS + own[1]])
    g, b = GROUND * A**2, BETWEEN * B**2
    k_tilt = 2 * np.array([[g + b, -b], [-b, b]])
    g, b = 300.0 * A**2, 200.0 * B**2
    c_tilt = 2 * np.array([[g + b, -b], [-b, b]])
    m_tilt = np.diag([INNER_INERTIA[0] + diametral[0], OUTER_INERTIA[0] + diametral[1]])
    spins = np.array([1.0, RATIO]) * speed
    gyroscopic = np.diag(spins * (np.array([INNER_INERTIA[1], OUTER_INERTIA[1]]) + polar))
    return (m, c, k), (m_tilt, c_tilt - 1j * gyroscopic, k_tilt)


def quadratic(m, c, k):
    """Eigenvalues of M λ² + C λ + K."""
    n = len(m)
    inverse = np.linalg.inv(m)
    block = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ k, -inverse @ c]])
    return np.linalg.eigvals(block)


def test_modes_of_two_rigid_rotors():
    system = pair()
    translation, tilt = closed_form()
    wanted = np.concatenate([quadratic(*translation), quadratic(*tilt)])
    found = system.modes(SPEED).eigenvalues
    found = np.concatenate([found, found.conj()])
    for value in wanted:
        # The shafts are rigid to 1e-6 of their bearings.
        assert np.abs(found - value).min() < 2e-5 * abs(value)


def test_unbalance_of_one_shaft_forces_the_other_at_its_own_speed():
    system = pair()
    (m, c, k), _ = closed_form()
    speeds = np.array([150.0, 300.0, 700.0])
    response = system.synchronous(speeds)
    for source, ratio, unbalance, row in (("inner", 1.0, 2e-3, 0), ("outer", RATIO, 1e-3j, 1)):
        for i, speed in enumerate(speeds):
            spin = ratio * speed
            force = np.zeros(2, complex)
            force[row] = unbalance * spin**2
            wanted = np.linalg.solve(-(spin**2) * m + 1j * spin * c + k, force)
            for at, value in zip(("fan", "drum"), wanted, strict=True):
                found = response.displacement(at, source=source)[i]
                # v + iw of a circular orbit: v = Re, w = Im of the phasor.
                assert abs(found[0] - value) < 2e-5 * abs(value)


def test_critical_speeds_have_both_spools():
    system = pair()
    (m, c, k), _ = closed_form()
    undamped = np.sqrt(np.linalg.eigvals(np.linalg.solve(m, k)).real)
    found = system.critical_speeds(900.0)
    speeds = np.array([critical.speed for critical in found])
    for frequency in undamped:
        for ratio in (1.0, abs(RATIO)):
            wanted = frequency / ratio
            if wanted < 900.0:
                # Damping changes a critical speed in second order, below 1e-3 here.
                assert np.abs(speeds / wanted - 1.0).min() < 1e-3


def runs(system, **options):
    """Give runs by all methods."""
    for method in ("rk4", "rk45", "exponential", "etdrk4"):
        more = {"step": 2e-5} if method in ("rk4", "etdrk4") else {"rtol": 1e-8}
        yield method, system.simulate(0.05, method=method, output_step=1e-3, **more, **options)
