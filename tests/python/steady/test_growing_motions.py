"""Stability of steady states of linear systems with growing modes, against dense eigenvalues."""

from __future__ import annotations

import os
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference.machines import cross_coupled, whirling_rotor

#: Number of random systems; `make random` takes more.
CASES = 30 * int(os.environ.get("GEARBOW_CASES") or 1)
#: Eigenvalues of the rigid-body rotation, which are zero: the root of round-off in a double
#: eigenvalue, relative to the largest one.
ROTATION = 1e-7
#: Growth rate, relative to the largest of the eigenvalue and of the speed, from which a motion
#: counts as unstable.
GROWTH = 1e-6


def eigenvalues(system: gb.RotorSystem, speed: float) -> np.ndarray:
    """Return the eigenvalues of the dense first-order matrix in scaled coordinates [rad/s]."""
    matrices = system.matrices(speed)
    mass, rate = matrices.mass, matrices.damping + speed * matrices.gyroscopic
    root = np.linalg.cholesky(mass)
    scaled = [
        np.linalg.solve(root, np.linalg.solve(root, matrix).T).T
        for matrix in (matrices.stiffness, rate)
    ]
    size = mass.shape[0]
    first = np.block([[np.zeros((size, size)), np.eye(size)], [-scaled[0], -scaled[1]]])
    found = np.linalg.eigvals(first)
    return found[np.abs(found) > ROTATION * np.abs(found).max()]


def rotor(random: np.random.Generator) -> tuple[gb.RotorSystem, float]:
    """Return a rotor on bearings of which some push it into a whirl, and its speed [rad/s]."""
    length, speed = random.uniform(0.3, 1.0), random.uniform(60.0, 400.0)
    shaft = gb.Shaft(
        "rotor",
        length=length,
        elements=int(random.integers(2, 6)),
        outer_diameter=random.uniform(0.02, 0.06),
        bow=gb.Bow.half_sine(1e-5),
    )
    disk = gb.Disk("disk", "rotor", 0.0, random.uniform(1.0, 20.0), 0.05, 0.03, unbalance=1e-4)
    stiffness = 10 ** random.uniform(6.0, 8.0)
    cross = stiffness * 10 ** random.uniform(-3.0, -1.5)
    damping = 10 ** random.uniform(0.0, 3.0)
    bearings = [
        gb.Bearing("rotor", x, **cross_coupled(stiffness, cross, damping)) for x in (0.0, length)
    ]
    return gb.RotorSystem([shaft], disks=[disk], bearings=bearings), speed


def pair(random: np.random.Generator) -> tuple[gb.RotorSystem, float]:
    """Return a pair of gears of which one shaft stands on cross-coupled bearings."""
    speed = random.uniform(60.0, 300.0)
    shafts = [
        gb.Shaft(name, length=0.5, outer_diameter=0.04, elements=2, bow=gb.Bow.half_sine(1e-5))
        for name in ("a", "b")
    ]
    wheel = {"position": 0.25, "module": 3e-3, "face_width": 0.03}
    gears = [gb.Gear("p", "a", teeth=20, **wheel), gb.Gear("w", "b", teeth=40, **wheel)]
    soft = cross_coupled(3e7, 3e7 * 10 ** random.uniform(-2.5, -1.0), 200.0)
    bearings = [
        gb.Bearing(name, x, **(soft if name == "a" else {"stiffness": 1e8, "damping": 200.0}))
        for name in ("a", "b")
        for x in (0.0, 0.5)
    ]
    mesh = gb.Mesh("p", "w", stiffness=2e8, damping_ratio=0.05)
    torques = [gb.Torque("p", 50.0), gb.Torque.balance("w")]
    return gb.RotorSystem(shafts, gears, [mesh], bearings, torques), speed


def compare(system: gb.RotorSystem, speed: float, **options: Any) -> bool:
    """Check the stability of a steady state, and return whether it is unstable."""
    steady = system.steady_state(speed, geometry="frozen", **options)
    dense = eigenvalues(system, speed)
    scale = np.maximum(np.abs(dense), speed)
    growing = dense[dense.real > GROWTH * scale]
    assert steady.is_stable() == (growing.size == 0)
    period = options.get("period") or steady.period
    for value in growing:
        exact = np.exp(value * period)
        # the period map is integrated to 1e-9, and its eigenvalues have a residual of 1e-6
        assert np.abs(steady.multipliers() - exact).min() < 1e-6 * abs(exact)
    return bool(growing.size)


@pytest.mark.filterwarnings("ignore::gearbow.AccuracyWarning")
def test_stability_of_random_rotors_is_that_of_their_eigenvalues():
    random = np.random.default_rng(4)
    unstable = 0
    for number in range(CASES):
        system, speed = (pair if number % 3 == 2 else rotor)(random)
        # few modes leave no room for growing ones that the loads do not reach
        modes = None if number % 2 else 4
        unstable += compare(system, speed, rtol=1e-9, modes=modes, record=["gears", "disks"])
    # the test must contain both kinds
    assert CASES / 3 <= unstable <= 0.9 * CASES


def test_a_run_with_few_modes_keeps_those_that_grow():
    # few elements: rk45 has a step for each oscillation of the highest mode
    system = whirling_rotor()
    system = system.replace(shafts=[replace(system.shafts[0], elements=2, degree=2)])
    options: dict[str, Any] = {"initial": "rest", "record": ["disk"], "rtol": 1e-9}
    all_modes = system.simulate(0.1, 100.0, method="rk45", **options).displacement("disk")[-1]
    for modes in (None, 1, 3):
        few = system.simulate(0.1, 100.0, modes=modes, **options).displacement("disk")[-1]
        # what the other modes add to the whirl that has grown by e^{λt}
        assert np.abs(few - all_modes).max() < 1e-2 * np.abs(all_modes).max()


def test_a_disk_on_bearings_that_push_it_whirls():
    assert compare(whirling_rotor(), 100.0, rtol=1e-9, record=["disk"])


@pytest.mark.filterwarnings("ignore::gearbow.AccuracyWarning")
def test_a_multiplier_far_below_the_largest_is_found():
    # those of a period of 2 s are up to e^63: round-off of an integrated period hides all others
    def bearings(name: str, cross: float) -> list[gb.Bearing]:
        return [gb.Bearing(name, x, **cross_coupled(3e7, cross, 100.0)) for x in (0.0, 0.5)]

    bow = gb.Bow.half_sine(1e-5)
    shafts = [
        gb.Shaft(name, length=0.5, outer_diameter=0.04, elements=2, bow=bow) for name in ("a", "b")
    ]
    wheel = {"position": 0.25, "module": 3e-3, "face_width": 0.03}
    system = gb.RotorSystem(
        shafts,
        [gb.Gear("p", "a", teeth=20, **wheel), gb.Gear("w", "b", teeth=40, **wheel)],
        [gb.Mesh("p", "w", stiffness=2e8, damping_ratio=0.05)],
        [*bearings("a", 1e6), *bearings("b", 6e5)],
        [gb.Torque("p", 50.0), gb.Torque.balance("w")],
    )
    speed = 2.0 * np.pi
    assert compare(system, speed, record=["gears"])
    steady = system.steady_state(speed, geometry="frozen", record=["gears"])
    sizes = np.abs(steady.multipliers())
    assert sizes[0] > 1e20 * sizes[sizes > 1.1].min()
    teeth = gb.Stiffness.fourier(2e8, [2e7], [0.0])
    varying = system.replace(meshes=[gb.Mesh("p", "w", stiffness=teeth, damping_ratio=0.05)])
    with pytest.raises(gb.ConvergenceError, match="lost in the round-off of the largest one"):
        _ = varying.steady_state(
            speed, geometry="frozen", modes=8, rtol=1e-3, record=["gears"]
        ).multipliers()


def test_a_large_rotor_without_damping_has_multipliers():
    # most of its 1,200 multipliers have magnitudes near 1
    shaft = gb.Shaft(
        "rotor", length=1.0, outer_diameter=0.05, elements=150, bow=gb.Bow.half_sine(1e-5)
    )
    bearings = [gb.Bearing("rotor", x, **cross_coupled(3e7, 8e5, 300.0)) for x in (0.0, 1.0)]
    system = gb.RotorSystem([shaft], bearings=bearings)
    steady = system.steady_state(150.0, record=[("rotor", 0.5)])
    exact = np.exp(system.modes(150.0, count=6).eigenvalues * steady.period)
    growing = exact[np.abs(exact) > 1.0 + 1e-6]
    assert growing.size
    assert not steady.is_stable()
    for value in growing:
        assert np.abs(steady.multipliers() - value).min() < 1e-6 * abs(value)


def test_a_sum_of_motions_without_a_period_is_unstable_with_its_modes():
    system = whirling_rotor().replace(forces=[gb.Force("disk", 10.0, order=np.pi)])
    steady = system.steady_state(100.0, rtol=1e-8, record=["disk"])
    assert steady.method == "superposition"
    assert not steady.is_stable()


def test_a_branch_is_unstable_where_a_mode_grows():
    bow = gb.Bow.half_sine(1e-5)
    shaft = gb.Shaft("rotor", length=0.4, outer_diameter=0.04, elements=1, bow=bow)
    bearings = [gb.Bearing("rotor", x, **cross_coupled(1e7, 434838.0, 3.32)) for x in (0.0, 0.4)]
    system = gb.RotorSystem([shaft], bearings=bearings)
    branch = system.continuation(
        "bow", 1.0, 2.0, speed=100.0, first_step=1.0, record=[("rotor", 0.0)]
    )
    assert not branch.stable.any()
