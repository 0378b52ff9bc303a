"""Internal damping of shafts at changing speed: the exponential method against rk45 at a tight tolerance.

The forward modes of a rotor with internal damping grow above their critical speed, so that an error grows with
the motion. Differences are relative to the motion at the end.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigh

import gearbow as gb
from reference.comparisons import error
from reference.machines import OIL, pair
from test_shaft_forces import rotor_of_ansys

#: Through the threshold of instability at 5000 rpm, 524 rad/s, and back.
UP = gb.SpeedProfile.ramp(0.0, 900.0, 0.1)
DOWN = gb.SpeedProfile.ramp(900.0, 100.0, 0.1)
BACKWARD = gb.SpeedProfile.ramp(0.0, -900.0, 0.1)
PROFILES = pytest.mark.parametrize("profile", [UP, DOWN, BACKWARD], ids=["up", "down", "backward"])


def rotor(internal_damping: float = 2e-4, **parts: Any) -> gb.RotorSystem:
    """Return the rotor of VM261 on a coarse mesh, which is cheap for rk45, with a bow and its weight."""
    bow = gb.Bow.half_sine(1e-4)
    system = rotor_of_ansys(bow=bow, elements=4, degree=2, internal_damping=internal_damping)
    return system.replace(gravity=9.81, **parts)


def train(**more: Any) -> gb.RotorSystem:
    """Return a pair with internal damping in both shafts, which turn in opposite senses."""
    own = {
        "input": {"internal_damping": 2e-4, "bow": gb.Bow.half_sine(5e-5)},
        "output": {"internal_damping": 1e-4},
    }
    return pair(shaft={"outer_diameter": 0.03, "elements": 2, "degree": 2}, own=own, **more)


@PROFILES
def test_a_rotor_that_passes_its_threshold(profile: gb.SpeedProfile):
    middle = ("s", 0.635)
    options: dict[str, Any] = {"initial": "static", "record": [middle], "output_step": 1e-3}
    exact = rotor().simulate(0.1, profile, method="rk45", rtol=1e-10, **options)
    exact = exact.displacement(middle)
    for rtol in (1e-4, 1e-6, 1e-8):
        found = rotor().simulate(0.1, profile, rtol=rtol, **options).displacement(middle)
        # 100: as at constant speed; couplings are neglected up to ten times the tolerance.
        assert error(found, exact) < 100 * rtol


@pytest.mark.parametrize(
    ("begin", "end", "backlash"),
    [(0.0, 900.0, None), (900.0, 50.0, 5e-5), (0.0, -900.0, 5e-5)],
    ids=["up", "down", "backward"],
)
def test_a_geared_pair(begin: float, end: float, backlash: float | None):
    # rk45 is limited by the damping β ω² of the highest mode: 10,000 times as many steps.
    duration, gears = 5e-3, ("g1", "g2")
    stiffness = gb.Stiffness.square(2e8, engagement=0.3)
    mesh = {"stiffness": stiffness, "damping_ratio": 0.05, "backlash": backlash}
    system, profile = train(mesh=mesh), gb.SpeedProfile.ramp(begin, end, duration)
    options: dict[str, Any] = {"initial": "rest", "times": np.linspace(0.0, duration, 101)}
    exact = system.simulate(duration, profile, method="rk45", rtol=1e-10, **options)
    for rtol in (1e-4, 1e-6):
        found = system.simulate(duration, profile, rtol=rtol, **options)
        for gear in gears:
            assert error(found.displacement(gear), exact.displacement(gear)) < 100 * rtol
        assert error(found.mesh(gears).force, exact.mesh(gears).force) < 100 * rtol


@pytest.mark.parametrize("beta", [2e-5, 1e-3, 5e-3])
def test_every_strength_of_damping_on_a_fine_mesh(beta: float):
    # Radau of SciPy, an implicit method, in the undamped modes; a constant force from rest.
    system = rotor_of_ansys(internal_damping=beta, elements=8, degree=2).replace(gravity=9.81)
    middle, times = ("s", 0.635), np.linspace(0.0, 0.03, 61)
    standing, turning = system.matrices(0.0), system.matrices(1.0)
    frequencies, shapes = eigh(standing.stiffness, standing.mass)
    frequencies, n = np.sqrt(frequencies), len(frequencies)
    damping, gyroscopic, circulatory = (
        shapes.T @ matrix @ shapes
        for matrix in (
            standing.damping,
            standing.gyroscopic,
            turning.stiffness - standing.stiffness,
        )
    )
    force = shapes.T @ (standing.stiffness @ system.static(speed=0.0).state)
    nothing = np.zeros((n, n))
    # The displacements are scaled by their frequencies.
    constant = np.block([[nothing, np.diag(frequencies)], [-np.diag(frequencies), -damping]])
    per_speed = np.block([[nothing, nothing], [-circulatory / frequencies, -gyroscopic]])
    load = np.concatenate([np.zeros(n), force])
    profile = gb.SpeedProfile.ramp(0.0, 900.0, 0.03)

    def matrix(t: float, _: np.ndarray) -> np.ndarray:
        return constant + 900.0 / 0.03 * t * per_speed

    exact = solve_ivp(
        lambda t, y: matrix(t, y) @ y + load,
        (0.0, 0.03),
        np.zeros(2 * n),
        method="Radau",
        jac=matrix,
        t_eval=times,
        rtol=1e-9,
        atol=1e-12 * np.abs(force / frequencies).max(),
    )
    rows = [i for i, dof in enumerate(standing.dofs) if dof[1:] in ((0.635, "v"), (0.635, "w"))]
    expected = (shapes[rows] @ (exact.y[:n] / frequencies[:, None])).T
    for rtol in (1e-4, 1e-6):
        found = system.simulate(
            0.03, profile, rtol=rtol, initial="rest", times=times, record=[middle]
        )
        assert error(found.displacement(middle), expected) < 100 * rtol


@PROFILES
def test_energy_is_accounted_for(profile: gb.SpeedProfile):
    bearings = [
        gb.Bearing("s", x, stiffness=k, damping=3e3) for x, k in ((0.0, 1.75e7), (1.27, 3e7))
    ]
    options: dict[str, Any] = {"initial": "rest", "record": ["energy"]}
    for system, duration in ((rotor(1e-3, bearings=bearings), 0.1), (train(), 0.02)):
        for rtol in (1e-4, 1e-6):
            balance = system.simulate(duration, profile, rtol=rtol, **options).energy_balance()
            assert balance.damping[-1] < -0.1 * balance.total.max()
            # The tolerance of a step.
            assert np.abs(balance.residual).max() < rtol * balance.total.max()


def test_the_promised_errors_are_kept():
    duration, profile = 0.03, gb.SpeedProfile.ramp(0.0, 600.0, 0.03)
    own = {
        "input": {"internal_damping": 2e-4, "bow": gb.Bow.half_sine(5e-5)},
        "output": {"internal_damping": 1e-4},
    }
    mesh = {"stiffness": gb.Stiffness.potential_energy(), "damping_ratio": 0.05}
    options: dict[str, Any] = {"initial": "rest", "times": np.linspace(0.0, duration, 301)}
    system = pair(shaft={"elements": None}, own=own, mesh=mesh, accuracy="reference")
    exact = system.simulate(duration, profile, **options)
    promised = {"draft": (1e-2, 1e-1), "engineering": (1e-3, 1e-2)}
    for level, (displacement, force) in promised.items():
        system = pair(shaft={"elements": None}, own=own, mesh=mesh, accuracy=level)
        found = system.simulate(duration, profile, **options)
        actual = [
            max(error(found.displacement(g), exact.displacement(g)) for g in ("g1", "g2")),
            error(found.mesh(("g1", "g2")).force, exact.mesh(("g1", "g2")).force),
        ]
        assert actual[0] < displacement
        assert actual[1] < force
        stated = found.errors()
        for kind, own_error in zip(("displacement", "mesh_force"), actual, strict=True):
            # Estimates are within a factor of three.
            assert own_error < 3.0 * stated[kind].total


def test_tables_of_bearings_and_a_continued_run():
    system = train()
    stiffness = gb.SpeedTable([0.0, 600.0], [5e7, 2e8])
    bearings = [
        gb.Bearing(b.shaft, b.position, stiffness=stiffness, damping=500.0) for b in system.bearings
    ]
    system = system.replace(bearings=bearings)
    profile = gb.SpeedProfile.ramp(0.0, 500.0, 5e-3)
    times = {"times": np.linspace(0.0, 5e-3, 101)}
    exact = system.simulate(5e-3, profile, method="rk45", rtol=1e-10, initial="rest", **times)
    found = system.simulate(5e-3, profile, rtol=1e-6, initial="rest", **times)
    assert error(found.displacement("g1"), exact.displacement("g1")) < 1e-4
    whole = system.simulate(5e-3, profile)
    part = system.simulate(5e-3 - 1.23e-3, profile, initial=system.simulate(1.23e-3, profile))
    assert part.final["state"].tobytes() == whole.final["state"].tobytes()


def test_oil_films():
    shaft = gb.Shaft(
        "r", length=0.5, outer_diameter=0.03, elements=2, degree=2, internal_damping=5e-5
    )
    films = [gb.JournalBearing("r", x, **{**OIL, "diameter": 0.03}) for x in (0.0, 0.5)]
    disk = gb.Disk("d", "r", 0.25, 5.0, 0.01, 0.02, unbalance=1e-4)
    system = gb.RotorSystem([shaft], disks=[disk], bearings=films, gravity=9.81, motion="lateral")
    profile = gb.SpeedProfile.ramp(100.0, 400.0, 0.01)
    options = {"initial": "static", "times": np.linspace(0.0, 0.01, 101), "record": ["d"]}
    exact = system.simulate(0.01, profile, method="rk45", rtol=1e-9, **options)
    for rtol in (1e-4, 1e-6):
        found = system.simulate(0.01, profile, rtol=rtol, **options)
        assert error(found.displacement("d"), exact.displacement("d")) < 100 * rtol
