"""Runs with shaft elements of degree p, against exact motion, and the error of the mesh force."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import gearbow as gb
from reference.bows import HalfSine
from reference.linear import LinearTrain
from reference.machines import double_stage
from reference.scenes import PAIR
from test_elements import STEPS, stepped, stepped_reference

LENGTH = sum(length for length, _, _ in STEPS)
BENT = replace(
    PAIR, elements=2, degree=3, bows={"input": HalfSine(1e-4), "output": HalfSine(5e-5, 1.0)}
)
#: Displacements and amplitude angles of a measured bow.
POINTS = (np.array([0.0, 0.1, 0.33, 0.5, 0.75]), np.array([0.0, 3e-5, -1e-4j, 5e-5, 2e-5j]))


def curvature(x: np.ndarray) -> np.ndarray:
    """Give the second derivative of the not-a-knot spline through the points."""
    return CubicSpline(*POINTS)(x, 2)


BOWS = {
    "two half waves": (
        gb.Bow.mode(2, 1e-4, phase=0.4),
        lambda x: -1e-4 * np.exp(0.4j) * (2 * np.pi / LENGTH) ** 2 * np.sin(2 * np.pi * x / LENGTH),
    ),
    "points": (
        gb.Bow.points(POINTS[0], np.abs(POINTS[1]), phases=np.angle(POINTS[1])),
        curvature,
    ),
}


def rotor(degree: int, bow: str) -> gb.RotorSystem:
    """Give a bowed, stepped shaft with a disk, in bearings, under its weight."""
    return stepped(
        degree,
        bow=BOWS[bow][0],
        bearings=[gb.Bearing("s", x, stiffness=3e8, damping=2e4) for x in (0.0, LENGTH)],
        disks=[gb.Disk("d", "s", 0.2, 3.0, 0.01, 0.02, unbalance=2e-4j)],
        gravity=[0.0, -9.81],
        rayleigh=(5.0, 1e-7),
    )


def exact(degree: int, bow: str, speed: float) -> LinearTrain:
    """Give the same rotor in another basis, in the real and then the imaginary parts."""
    reference = stepped_reference(degree)
    mass, rotary, stiffness = reference.assemble()
    damping, gyroscopic = 5.0 * mass + 1e-7 * stiffness, 2 * rotary
    load = -9.81j * (reference.weight() + 3.0 * np.eye(reference.size)[1])
    for end in (0, 3):
        stiffness[end, end] += 3e8
        damping[end, end] += 2e4
    tilt = len(reference.nodes) + 1
    mass[1, 1] += 3.0
    mass[tilt, tilt] += 0.01
    gyroscopic[tilt, tilt] += 0.02
    turning = bow_force(degree, bow)
    turning[1] += speed**2 * 2e-4j

    def planes(matrix: np.ndarray) -> np.ndarray:
        return np.kron(np.eye(2), matrix)

    def parts(force: np.ndarray) -> np.ndarray:
        return np.concatenate([force.real, force.imag])

    cross = np.kron([[0.0, 1.0], [-1.0, 0.0]], speed * gyroscopic)
    return LinearTrain(
        planes(mass),
        planes(damping) + cross,
        planes(stiffness),
        parts(load),
        [(speed, parts(turning), parts(1j * turning))],
    )


def bow_force(degree: int, bow: str) -> np.ndarray:
    """Integrate the force of a bow; the curvature of a spline has kinks at its knots."""
    return replace(stepped_reference(degree), breaks=POINTS[0]).bow_force(BOWS[bow][1])


@pytest.mark.parametrize("bow", BOWS)
@pytest.mark.parametrize("speed", [700.0, -700.0])
@pytest.mark.parametrize("degree", [2, 3])
def test_a_run_follows_the_exact_motion_in_another_basis(degree: int, speed: float, bow: str):
    times = np.linspace(0.0, 5e-3, 26)
    train = exact(degree, bow, speed)
    n = len(train.mass)
    q, _ = train.motion(times, np.zeros(n), np.zeros(n))
    wanted = q[:, [1, n // 2 + 1]]
    system = rotor(degree, bow)
    # Runge–Kutta steps meet a tolerance; the other method leaves the round-off of two assemblies.
    for options, error in (({}, 1e-9), ({"method": "rk45", "rtol": 1e-9}, 1e-7)):
        found = system.simulate(5e-3, speed, initial="rest", times=times, record=["d"], **options)
        assert np.abs(found.displacement("d") - wanted).max() < error * np.abs(wanted).max()


@pytest.mark.parametrize("motion", [None, "torsion"])
def test_a_run_of_a_train_follows_its_matrices(motion: str | None):
    scene = replace(PAIR, elements=2, degree=3, options={"motion": motion} if motion else {})
    if motion:
        package = scene.package()
        system = gb.RotorSystem(
            shafts=package.shafts, gears=package.gears, meshes=package.meshes,
            torques=package.torques, motion=motion,
        )  # fmt: skip
    else:
        system = scene.package()
    matrices = system.matrices(100.0)
    n = len(system.dofs)
    torque = np.zeros(n)
    for name, value in (("g1", 250.0), ("g2", 500.0)):
        torque[system.coordinates.twist(name)] = value
    damping = matrices.damping + 100.0 * matrices.gyroscopic
    train = LinearTrain(matrices.mass, damping, matrices.stiffness, torque)
    times = np.linspace(0.0, 2e-3, 21)
    q, _ = train.motion(times, np.zeros(n), np.zeros(n))
    wanted = q[:, system.coordinates.twist("g2")]
    for options, error in (({}, 1e-8), ({"method": "rk45", "rtol": 1e-9}, 1e-6)):
        found = system.simulate(
            2e-3, 100.0, initial="rest", geometry="frozen", times=times, record=["g2"], **options
        )
        assert np.abs(found.twist("g2") - wanted).max() < error * np.abs(wanted).max()


@pytest.mark.parametrize("method", ["rk45", "exponential"])
def test_energy_is_neither_made_nor_lost(method: str):
    system = BENT.package()
    found = system.simulate(
        0.01, 300.0, initial="rest", record=["energy"], method=method, rtol=1e-8
    )
    balance = found.energy_balance()
    scale = np.abs(balance.total).max() + np.ptp(balance.work)
    assert np.abs(balance.residual).max() <= 1e-6 * scale


@pytest.mark.parametrize("options", [{}, {"method": "rk4", "step": 1e-6}])
def test_a_run_continues_as_if_it_had_not_stopped(options: dict[str, Any]):
    system, times = BENT.package(), np.linspace(0.0, 0.004, 17)
    record = {"record": ["g1", ("g1", "g2")], **options}
    whole = system.simulate(0.004, 300.0, times=times, **record)
    first = system.simulate(0.002, 300.0, times=times[:9], **record)
    second = system.simulate(0.002, 300.0, initial=first, times=times[8:], **record)
    assert np.array_equal(second.final["state"], whole.final["state"])
    for of in (lambda response: response.displacement("g1"), lambda response: response.twist("g1")):
        assert np.array_equal(of(second)[1:], of(whole)[9:])
        # The two runs interpolate the instant at which the first one ends in different steps.
        assert of(second)[0] == pytest.approx(of(whole)[8], rel=1e-9)


def test_a_state_of_another_degree_is_refused():
    short = BENT.package().simulate(1e-4, 300.0, record=["g1"])
    with pytest.raises(
        gb.SceneError, match="initial: has 78 degrees of freedom, this system has 58"
    ):
        replace(BENT, degree=2).package().simulate(1e-4, 300.0, initial=short, record=["g1"])


def test_a_synchronous_start_stays_synchronous():
    system, speed = rotor(4, "points"), 500.0
    found = system.simulate(0.05, speed, times=np.linspace(0, 0.05, 31), record=["d"])
    amplitude = system.synchronous([speed]).displacement("d")[0, 0]
    turn = np.exp(1j * speed * found.time)
    wanted = system.static().displacement("d") + (amplitude * turn[:, None]).real
    # The motion is purely synchronous: only round-off differs.
    assert np.abs(found.displacement("d") - wanted).max() < 1e-11 * np.abs(wanted).max()


# --- accuracy of a mesh force ----------------------------------------------------------------------


def train(elements: int, degree: int) -> gb.RotorSystem:
    """Give the double-stage train of the study of accuracy and cost, with modal damping."""
    return double_stage(
        shaft={"elements": elements, "degree": degree, "bow": gb.Bow.half_sine(1.5e-4)},
        mesh={"stiffness": gb.Stiffness.potential_energy(), "damping_ratio": 0.05},
        modal_damping=0.02,
    )


TEETH = {"g1": 25, "g2": 50, "g3": 25, "g4": 50}
PAIRS = (("g1", "g2"), ("g3", "g4"))


def test_four_cubic_elements_beat_sixteen_of_degree_one_on_the_mesh_force():
    def force(elements: int, degree: int) -> np.ndarray:
        found = train(elements, degree).simulate(
            0.03, 100.0, record=["meshes"], output_step=2.5e-5, rtol=1e-6
        )
        return np.column_stack([found.mesh(pair).force for pair in PAIRS])

    reference = force(4, 5)

    def error(elements: int, degree: int) -> float:
        apart = np.sqrt(np.mean((force(elements, degree) - reference) ** 2, axis=0))
        return float(np.max(apart / reference.std(axis=0)))

    cubic, eight, sixteen = error(4, 3), error(8, 1), error(16, 1)
    assert cubic < 0.5 * sixteen < 0.25 * eight
    assert cubic < 0.02
