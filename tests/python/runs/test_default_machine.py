"""The default machine of the tests beside its independent statement: matrices, responses, runs, both senses of rotation."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import gearbow as gb
from reference.equations import Balance
from reference.helical import HelicalMesh, HelicalTrain
from reference.machines import hostile, without_tooth_errors

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
    amplitudes = without_tooth_errors(system).synchronous([speed]).amplitudes[0]
    for source, (spin, at_0, at_90) in enumerate(whole.turning_force(speed)):
        expected = whole.response(spin, speed, at_0 - 1j * at_90)[at]
        # The limit is round-off times the condition number: the matrix has a free rotation.
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


@pytest.mark.parametrize("speed", SPEEDS)
def test_a_transmission_error_of_one_mesh_moves_all(speed: float):
    system, whole, _ = both(speed)
    w, error = 900.0, 1e-6 * np.exp(0.4j)
    source = gb.MeshExcitation("g4/g5", error)
    found = system.frequency_response([w], source=source, speed=speed)

    def impedance(mesh: HelicalMesh) -> complex:
        return mesh.stiffness + 1j * w * mesh.damping

    linear = [
        (mesh, at, replace(mesh, runout=(0j, 0j)).linear(np.zeros(14), live=False)[1][:12])
        for mesh, at, _ in whole.meshes
    ]
    force = np.zeros(whole.size, dtype=complex)
    mesh, at, gradient = linear[2]
    force[at] = impedance(mesh) * np.cos(mesh.base) * error * gradient
    q = whole.response(w, speed, force)
    forces = [impedance(mesh) * (gradient @ q[at]) for mesh, at, gradient in linear]
    forces[2] -= impedance(mesh) * np.cos(mesh.base) * error
    for name, expected in zip(("g1/g2", "g2/g3", "g4/g5"), forces, strict=True):
        # The limit is round-off times the condition number: the matrix has a free rotation.
        scale = 1e-7 * abs(impedance(mesh) * error)
        assert found.mesh_force(name)[0, 0] == pytest.approx(expected, abs=scale), name


@pytest.mark.parametrize("speed", SPEEDS)
def test_deflections_and_bearing_forces(speed: float):
    system, whole, at = both(speed)
    found = system.synchronous([speed])
    for source, (spin, *_) in enumerate(whole.turning_force(speed)):
        q = np.zeros(whole.size, dtype=complex)
        q[at] = found.amplitudes[0, source]
        for bearing in whole.train.bearings:
            places = [(bearing.shaft, bearing.position), bearing.support]
            v, *base = (whole.train.dof(*place, 0) for place in places if place)
            apart = q[v : v + 2] - sum(q[i : i + 2] for i in base)
            expected = (bearing.stiffness + 1j * spin * bearing.damping) @ apart
            force = found.bearing_force(places[0])[0, source]
            # round-off of differences of displacements
            assert force == pytest.approx(expected, rel=1e-9)
        for name in ("g3", "g5"):
            shaft, x = whole.train.place(name)
            own = next(s for s in whole.train.shafts if s.name == shaft)
            bow = (
                own.bow(x) * np.array([1.0, -1.0j]) if system.shafts[source].name == shaft else 0.0
            )
            expected = found.displacement(name)[0, source] - bow
            assert found.elastic(name)[0, source] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("target", ["total", "elastic"])
def test_a_balance_away_from_the_reference_shaft(target: str):
    system, whole, _ = both(100.0)
    system = without_tooth_errors(system)
    found = system.balance(["g3", "g4"], 100.0, target=target, points=["g3", "g4"])
    assert found.shaft == "middle"
    spin, at_0, at_90 = whole.turning_force(100.0)[2]
    force = at_0 - 1j * at_90
    rows = [whole.train.dof(*whole.train.place(name), 0) for name in ("g3", "g4")]
    for row, unbalance in zip(rows, found.unbalances, strict=True):
        force[row : row + 2] += spin**2 * unbalance * np.array([1.0, -1.0j])
    q = whole.response(spin, 100.0, force)
    middle = whole.train.shafts[2]
    for i, row in enumerate(rows):
        bow = middle.bow((0.12, 0.35)[i]) * np.array([1.0, -1.0j]) * (target == "elastic")
        # The limit is round-off times the condition number of the matrix.
        scale = 1e-6 * np.abs(found.before).max()
        assert found.residual[0, i] == pytest.approx(q[row : row + 2] - bow, abs=scale)


@pytest.mark.parametrize("speed", SPEEDS)
def test_forces_at_rest_balance_on_each_shaft(speed: float):
    system = hostile(gravity=9.81)
    static = system.static(speed)
    balance = Balance(system, static, speed)
    for shaft in system.shafts:
        # iteration ends at 1e-10 of the load
        assert balance.residual(shaft.name) < 1e-8
    table = static.table().splitlines()
    for bearing in system.bearings:
        place = (bearing.shaft, bearing.position)
        row = next(line for line in table if f"{place[0]} at {place[1]:g} m" in line)
        force, axial = np.hypot(*static.bearing_force(place)), static.axial_bearing_force(place)
        # numbers of four digits, and round-off as 0
        shown = [float(word) for word in row.split()[-5:-3]]
        assert shown == pytest.approx([force, axial], rel=1e-3, abs=1e-6)


def test_a_superposed_steady_state_is_the_sum_of_the_linear_responses():
    speed, system = -100.0, hostile()
    # run-out varies the coefficients of the mesh
    system = system.replace(gears=[replace(system.gears[0], runout=0.0), *system.gears[1:]])
    steady = system.steady_state(speed, geometry="frozen", record=["g1", "g5"])
    assert steady.method == "superposition"
    whole, time = HelicalTrain.of(system, speed), steady.response.time
    mesh, at, ratios = whole.meshes[2]
    gradient = mesh.linear(np.zeros(14), live=False)[1][:12]
    sources = []
    error = system.meshes[2].error
    orders = [29 * ratios[0], *ratios]
    for order, harmonics in zip(orders, (error.tooth, error.driver, error.driven), strict=True):
        ((amplitude, phase),) = harmonics
        force = np.zeros(whole.size, dtype=complex)
        impedance = mesh.stiffness + 1j * order * speed * mesh.damping
        force[at] = impedance * np.cos(mesh.base) * amplitude * np.exp(1j * phase) * gradient
        sources.append((order * speed, force))
    sources += [(spin, at_0 - 1j * at_90) for spin, at_0, at_90 in whole.turning_force(speed)]
    static = system.static(speed, geometry="frozen")
    for name in ("g1", "g5"):
        v = whole.train.dof(*whole.train.place(name), 0)
        expected = static.displacement(name) + sum(
            np.real(np.outer(np.exp(1j * w * time), whole.response(w, speed, force)[v : v + 2]))
            for w, force in sources
        )
        # the tolerance of the steady state is 1e-5
        error = np.abs(steady.response.displacement(name) - expected).max()
        assert error < 1e-5 * np.ptp(expected)


@pytest.mark.parametrize("live", [True, False], ids=["live", "frozen"])
@pytest.mark.parametrize("speed", SPEEDS)
def test_a_run_from_rest(speed: float, live: bool):
    system, whole, _ = both(speed)
    times = np.linspace(0.0, 1e-4, 6)
    q, forces = whole.from_rest(speed, times, live)
    geometry = "live" if live else "frozen"
    ends = [(b.shaft, b.position) for b in whole.train.bearings]
    ends += [b.support for b in whole.train.bearings if b.support]
    record = ["gears", "meshes", "bearings", *ends, "velocity"]
    how = {"initial": "rest", "times": times, "geometry": geometry, "rtol": 1e-9}
    run = system.simulate(1.1e-4, speed, record=record, **how)

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
    for bearing, spec in zip(system.bearings, whole.train.bearings, strict=True):
        place = (spec.shaft, spec.position)
        sides = [(place, 1.0), *([(spec.support, -1.0)] if spec.support else [])]
        apart, rate, along, along_rate = (
            sum(sign * measure(at) for at, sign in sides)
            for measure in (run.displacement, run.velocity, run.axial, run.axial_velocity)
        )
        alike(run.bearing_force(place), apart @ spec.stiffness.T + rate @ spec.damping.T)
        if bearing.axial_stiffness:
            expected = bearing.axial_stiffness * along + bearing.axial_damping * along_rate
            alike(run.axial_bearing_force(place), expected)
