"""The default machine of the tests beside its independent statement: matrices, responses, runs, both senses of rotation."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import gearbow as gb
from reference.helical import HelicalTrain
from reference.machines import hostile

SPEEDS = [100.0, -250.0]


@cache
def both(speed: float) -> tuple[gb.RotorSystem, HelicalTrain, np.ndarray]:
    """Return the machine, its independent statement, and the place of each coordinate in the latter."""
    system = hostile()
    whole = HelicalTrain.of(system, speed)
    dofs = [(shaft, round(x, 9), kind) for shaft, x, kind in whole.dofs()]
    return system, whole, np.array([dofs.index((s, round(x, 9), k)) for s, x, k in system.dofs])


@pytest.mark.parametrize("speed", SPEEDS)
def test_matrices_and_responses(speed: float):
    system, whole, at = both(speed)
    assert system.speed_ratios == pytest.approx([1.0, -23 / 31, 23 / 47, -23 * 29 / (47 * 53)])
    stiffness, damping = whole.linear()
    found = system.matrices(speed)
    for name, exact in (
        ("mass", whole.mass),
        ("stiffness", stiffness),
        ("damping", damping),
        ("gyroscopic", whole.gyroscopic),
    ):
        # entries are sums of a few products
        expected = exact[np.ix_(at, at)]
        gap = np.abs(getattr(found, name) - expected).max()
        assert gap < 1e-13 * np.abs(expected).max(), name
    amplitudes = system.synchronous([speed]).amplitudes[0]
    for source, (spin, at_0, at_90) in enumerate(whole.turning_force(speed)):
        expected = whole.response(spin, speed, at_0 - 1j * at_90)[at]
        # round-off times the condition of the matrix with a free rotation
        assert amplitudes[source] == pytest.approx(expected, abs=1e-7 * np.abs(expected).max())
    place = [system.dofs.index(("middle", 0.35, kind)) for kind in ("u", "v", "w")]
    force = np.zeros(len(at), dtype=complex)
    force[place] = 3.0, 2.0 - 1.0j, 0.5j
    source = gb.Force("g4", (2.0 - 1.0j, 0.5j), axial=3.0)
    moved = system.frequency_response([-700.0], source=source, speed=speed).phasors[0, 0]
    own = np.zeros(len(at), dtype=complex)
    own[at] = force
    expected = whole.response(-700.0, speed, own)[at]
    assert moved == pytest.approx(expected, abs=1e-7 * np.abs(expected).max())


@pytest.mark.parametrize("live", [True, False], ids=["live", "frozen"])
@pytest.mark.parametrize("speed", SPEEDS)
def test_a_run_from_rest(speed: float, live: bool):
    system, whole, _ = both(speed)
    times = np.linspace(0.0, 1e-4, 6)
    q, forces = whole.from_rest(speed, times, live)
    geometry = "live" if live else "frozen"
    run = system.simulate(1.1e-4, speed, initial="rest", times=times, geometry=geometry, rtol=1e-9)

    # The arm of the thrust about the axis contains the run-out in the independent statement only:
    # 1e-3 of the arm, times a tilt of 1e-3 of the deflection.
    def alike(found: np.ndarray, exact: np.ndarray) -> None:
        assert found == pytest.approx(exact, abs=1e-5 * np.ptp(exact, axis=0).max())

    for i, mesh in enumerate(system.meshes):
        alike(run.mesh((mesh.driver, mesh.driven)).force, forces[:, i])
    for gear in system.gears:
        place = (gear.shaft, gear.position)
        v = whole.train.dof(*place, 0)
        alike(run.displacement(gear.name), q[:, v : v + 2])
        alike(run.twist(gear.name), q[:, v + 4])
        alike(run.axial(gear.name), q[:, whole.axial(*place)])
