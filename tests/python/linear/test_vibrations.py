"""Order and completeness of modes: `modes(count=)` beside eigenvalues that NumPy finds from the matrices."""

from __future__ import annotations

import warnings
from dataclasses import replace
from itertools import pairwise

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


with warnings.catch_warnings():
    # The free shaft swings about its only bearing.
    warnings.simplefilter("ignore", gb.SceneWarning)
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


def eigenvalues(system: gb.RotorSystem, speed: float) -> np.ndarray:
    """Return the eigenvalues of M⁻¹(K, C + ΩG) with Im λ ≥ 0, in ascending order of |λ|."""
    m = system.matrices(speed)
    n, factor = len(m.mass), np.linalg.inv(np.linalg.cholesky(m.mass))
    stiffness = factor @ m.stiffness @ factor.T
    rate = factor @ (m.damping + speed * m.gyroscopic) @ factor.T
    # Balanced by the frequency ω of the coupling between positions and velocities.
    omega = np.sqrt(np.linalg.norm(stiffness, 2))
    state = np.block([[np.zeros((n, n)), omega * np.eye(n)], [-stiffness / omega, -rate]])
    values = np.linalg.eigvals(state)
    values = values[values.imag >= 0.0]
    return values[np.argsort(np.abs(values), kind="stable")]


def vibrating(system: gb.RotorSystem, speed: float, values: np.ndarray) -> np.ndarray:
    """Tell which eigenvalues are vibrations: from the ground, and from a shaft that relaxes faster than 1/2β."""
    found = values.imag > 0.05 * np.abs(values)
    for shaft, ratio in zip(system.shafts, system.speed_ratios, strict=True):
        seen = values - 1j * abs(speed * ratio)
        relaxes = shaft.internal_damping * seen.real < -0.5
        found &= ~(relaxes & (np.abs(seen.imag) <= 0.05 * np.abs(seen)))
    return found


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("count", [1, 4, 12])
def test_vibrations_are_those_of_all_modes(name, count):
    system, speed = CASES[name], 200.0
    found = system.modes(speed, count=count, vibrating=True).eigenvalues
    every = eigenvalues(system, speed)
    # Round-off leaves 2e-6 rad/s of a rigid-body motion.
    wanted = every[vibrating(system, speed, every) & (np.abs(every) > 1e-3)][:count]
    assert len(found) == len(wanted)
    # NumPy leaves 1e-8 of the highest eigenvalues, which are up to 1e3 times the wanted ones.
    np.testing.assert_allclose(np.abs(found), np.abs(wanted), rtol=1e-5)
    assert all(np.min(np.abs(every - value)) < 1e-5 * abs(value) for value in found)


@pytest.mark.parametrize("name", ["strong dampers", "oil films", "light damping"])
def test_the_lowest_modes_are_those_of_smallest_magnitude(name):
    system, speed = CASES[name], 200.0
    wanted = np.abs(eigenvalues(system, speed))
    for count in (1, 5, 12, 20):
        found = system.modes(speed, count=count)
        np.testing.assert_allclose(np.abs(found.eigenvalues), wanted[:count], rtol=1e-5)
        assert found.residuals.max() < 1e-6


def test_strong_dampers_leave_the_vibrations_among_the_lowest_modes():
    # The dampers hold the ends, which relax with −k/c = −167 rad/s in both planes, two
    # slowly turning pairs below the first vibration. The fast
    # motions of the dampers, −1e5 rad/s, are not among the lowest modes.
    found = rotor(*stiff(3e5)).modes(200.0, count=12)
    assert np.sum(found.eigenvalues.imag > 0.05 * np.abs(found.eigenvalues)) == 10


def test_a_vibration_slower_than_the_relaxation_of_its_shaft_is_found():
    shaft = gb.Shaft("r", length=0.8, outer_diameter=0.04, elements=20, internal_damping=1e-4)
    system = gb.RotorSystem(
        shafts=[shaft],
        disks=[gb.Disk("d", "r", 0.4, mass=6.0, diametral_inertia=0.01, polar_inertia=0.02)],
        bearings=[gb.Bearing("r", x, stiffness=1e8, damping=200.0) for x in (0.0, 0.8)],
    )
    counts = []
    for speed in (0.0, 500.0, 2000.0, -2000.0):
        every = eigenvalues(system, speed)
        wanted = every[vibrating(system, speed, every)]
        found = system.modes(speed, count=6, vibrating=True).eigenvalues
        np.testing.assert_allclose(np.abs(found), np.abs(wanted[:6]), rtol=1e-5)
        counts.append(len(system.modes(speed, vibrating=True).eigenvalues))
    # The relaxations that turn with the shaft do not become vibrations.
    assert max(counts) - min(counts) <= 2


def test_internal_damping_without_other_speed_dependence_has_modal_damping():
    # Nothing but the internal damping depends on the speed: no bearing adds a motion to the space of the modes.
    system = rotor(*stiff(1e3), internal_damping=1e-6).replace(modal_damping=0.01)
    assert len(system.dofs) > 100
    assert system.modes(200.0, count=6, vibrating=True).residuals.max() < 1e-6
    disk = replace(system.disks[0], unbalance=1e-4)
    assert np.isfinite(system.replace(disks=[disk]).synchronous([200.0]).displacement("d")).all()


def test_a_panic_of_the_core_is_an_error_to_report():
    from gearbow import _core

    with pytest.raises(
        gb.GearbowError, match=r"internal error of gearbow .*src.*background\.rs:.*planted.*report"
    ):
        _core.panic_in_analysis("planted")


@pytest.mark.parametrize("elements", [2, 40])
def test_no_vibration_is_an_empty_result(elements):
    # dense and band matrices; damping in proportion to mass and stiffness that is far above critical
    shaft = gb.Shaft("s", length=1.0, outer_diameter=0.05, elements=elements)
    system = gb.RotorSystem([shaft], bearings=stiff(1e3), rayleigh=(1e5, 1e-2))
    found, every = system.modes(0.0, vibrating=True), system.modes(0.0)
    assert found.eigenvalues.size == 0 < every.eigenvalues.size
    text = str(found) + repr(found)
    assert "overdamped" not in text
    assert len(found.whirl) == len(found.names()) == 0
    for one, other in ((found, found), (found, every), (every, found)):
        compared = one.compare(other)
        assert compared.mac.shape == (len(one.whirl), len(other.whirl))
        assert compared.pairs == ()
        assert len(compared.to_dataframe()) == 0
        str(compared), repr(compared), compared.plot()
    found.plot()


def random_train(seed: int) -> tuple[gb.RotorSystem, float]:
    """Return a train of one to three shafts with weak and strong dampers, and a speed."""
    random = np.random.default_rng(seed)
    count, elements = int(random.integers(1, 4)), int(random.choice([2, 8, 16]))
    shafts = [
        gb.Shaft(
            name,
            length=random.uniform(0.2, 1.0),
            outer_diameter=random.uniform(0.02, 0.08),
            elements=elements,
            internal_damping=random.choice([0.0, 1e-6, 1e-4]),
        )
        for name in "abc"[:count]
    ]
    helix = random.choice([0.0, 0.2])
    bearings = [
        gb.Bearing(
            shaft.name,
            x,
            stiffness=stiffness * np.array([[1.0, 0.1], [-0.05, 1.3]]),
            damping=random.choice([0.0, 300.0, 1e4, 3e5]),
            axial_stiffness=stiffness / 3.0,
            tilting_stiffness=random.choice([0.0, 1e4]),
        )
        for shaft in shafts
        for x in (0.0, shaft.length)
        for stiffness in [10.0 ** random.uniform(6.0, 9.0)]
    ]
    gears, meshes = [], []
    for first, second in pairwise(shafts):
        pair = [f"{first.name}{second.name}", f"{second.name}{first.name}"]
        for name, shaft, sense in zip(pair, (first, second), (1.0, -1.0), strict=True):
            x, teeth = shaft.length * random.uniform(0.2, 0.8), int(random.choice([17, 31, 53]))
            body = {"module": 3e-3, "face_width": 0.03, "helix_angle": sense * helix}
            gears.append(gb.Gear(name, shaft.name, x, teeth, **body))
        meshes.append(
            gb.Mesh(*pair, stiffness=10.0 ** random.uniform(7.5, 8.7), damping_ratio=0.05)
        )
    speed = random.choice([0.0, 150.0, -400.0, 900.0, -2500.0])
    return gb.RotorSystem(shafts, gears, meshes, bearings), speed


@pytest.mark.parametrize("seed", range(8))
def test_random_trains_have_the_modes_of_dense_matrices(seed: int):
    system, speed = random_train(seed)
    every = eigenvalues(system, speed)
    # Round-off leaves 5e-3 rad/s of rigid-body motions; dampers relax with k/c above 3 rad/s.
    every = every[np.abs(every) > 0.1]
    vibrations = every[vibrating(system, speed, every)]
    for count in (1, 10, 25):
        for vibrates, motions in ((False, every), (True, vibrations)):
            found = system.modes(speed, count=count, vibrating=vibrates).eigenvalues
            moving = found[found != 0.0]
            wanted = motions[: count - len(found) + len(moving)]
            assert len(moving) == len(wanted)
            # NumPy leaves 1e-8 of the highest eigenvalues, which are up to 1e3 times the wanted ones.
            np.testing.assert_allclose(np.abs(moving), np.abs(wanted), rtol=1e-5)
            assert all(np.min(np.abs(every - value)) < 1e-5 * abs(value) for value in moving)
