"""Elastic housings: a published frame, full against reduced matrices, runs, and the rigid limit."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse

import gearbow as gb
from gearbow.exchange.universal import data_sets, read_uff
from reference import machines
from reference.elastic import system as elastic
from reference.frames import Frame


def _frame(parts: int, radius: float = 0.4) -> Frame:
    """The frame of Code_Aster SDLV132: 2 m x 0.5 m x 1 m, feet clamped, Poisson's ratio zero."""
    frame = Frame(poisson_ratio=0.0)
    for x in (0.0, 2.0):
        for y in (-0.25, 0.25):
            frame.bar((x, y, -1.0), (x, y, 0.0), radius, parts)
            frame.clamp(x, y, -1.0)
        frame.bar((x, -0.25, 0.0), (x, 0.25, 0.0), radius, parts)
    for y in (-0.25, 0.25):
        frame.bar((0.0, y, 0.0), (2.0, y, 0.0), radius, 2 * parts)
    return frame


def test_a_rotor_in_a_frame_of_beams() -> None:
    frame = _frame(16)
    mass, stiffness = frame.matrices()
    seats = {
        f"seat {x:g}": gb.Interface((x, 0.0, 0.0), rows=frame.rows(x, 0.0, 0.0)) for x in (0.0, 2.0)
    }
    housing = gb.Housing.from_matrices(
        "frame", mass=mass, stiffness=stiffness, interfaces=seats, highest_frequency=1000.0
    )
    material = gb.Material(2.1e11, 7800.0, poisson_ratio=0.0)
    shaft = gb.Shaft("rotor", length=2.0, outer_diameter=0.2, material=material)
    bearings = [
        gb.Bearing(
            "rotor", x, stiffness=1e12, axial_stiffness=1e12, support=("frame", f"seat {x:g}")
        )
        for x in (0.0, 2.0)
    ]
    system = gb.RotorSystem([shaft], bearings=bearings, housings=[housing])
    found = system.modes(count=7).frequencies_hz
    # Code_Aster, and an own beam model: other shear coefficients of bars as thick as these, whose
    # radius is 0.4 of the length of the legs, leave 1.1 %
    published = [100.717, 100.866, 221.064, 259.143, 342.981, 392.524, 397.556]
    assert found == pytest.approx(published, rel=1.1e-2)
    beams = [100.70, 100.85, 220.78, 258.95, 342.36, 391.96, 396.93]
    assert found == pytest.approx(beams, rel=1.1e-2)
    assert found[:2] == pytest.approx(published[:2], rel=6e-4)


def _two_seats(free: bool, parts: int = 4) -> tuple[Any, Any, Frame]:
    """Matrices of a portal of bars: clamped, or free with feet on springs."""
    frame = Frame()
    for x in (0.0, 0.6):
        for y in (-0.15, 0.2):
            frame.bar((x, y, -0.3), (x, y, 0.0), 0.02, parts)
            if not free:
                frame.clamp(x, y, -0.3)
        frame.bar((x, -0.15, 0.0), (x, 0.0, 0.0), 0.02, parts)
        frame.bar((x, 0.0, 0.0), (x, 0.2, 0.0), 0.02, parts)
    frame.bar((0.0, -0.15, 0.0), (0.6, -0.15, 0.0), 0.018, 2 * parts)
    frame.bar((0.0, 0.2, 0.0), (0.6, 0.2, 0.0), 0.018, 2 * parts)
    return *frame.matrices(), frame


def _on(frame: Frame, free: bool) -> dict[str, gb.Interface]:
    seats = {
        f"seat {x:g}": gb.Interface((x, 0.0, 0.0), rows=frame.rows(x, 0.0, 0.0)) for x in (0.0, 0.6)
    }
    seats["sensor"] = gb.Interface((0.0, 0.2, 0.0), rows=frame.rows(0.0, 0.2, 0.0)[:3])
    if free:
        for x in (0.0, 0.6):
            for y in (-0.15, 0.2):
                seats[f"foot {x:g} {y:g}"] = gb.Interface(
                    (x, y, -0.3),
                    rows=frame.rows(x, y, -0.3),
                    stiffness=(3e7, 4e7, 8e7),
                    damping=(200.0, 200.0, 300.0),
                )
    return seats


def _rotor(housing: gb.Housing | None, **more: Any) -> gb.RotorSystem:
    """A rotor with a disk, bow and unbalance on two bearings, all different."""
    disk = gb.Disk(
        "disk", "rotor", 0.25, **machines.inertia(6.0, 0.03, 0.05), unbalance=2e-4 * np.exp(0.4j)
    )
    shaft = gb.Shaft(
        "rotor", length=0.6, outer_diameter=0.035, elements=4, bow=gb.Bow.half_sine(5e-5, 0.3)
    )
    bearings = [
        gb.Bearing(
            "rotor",
            x,
            stiffness=k,
            damping=600.0,
            axial_stiffness=a,
            support=None if housing is None else ("housing", f"seat {x:g}"),
        )
        for x, k, a in ((0.0, (5e7, 8e7), 3e7), (0.6, (6e7, 9e7), 0.0))
    ]
    given = {"gravity": 9.81, "motion": "coupled"} | more
    return gb.RotorSystem(
        [shaft], disks=[disk], bearings=bearings, housings=[housing] if housing else [], **given
    )


def _made(free: bool, highest: float = 1500.0, **more: Any) -> gb.Housing:
    mass, stiffness, frame = _two_seats(free)
    return gb.Housing.from_matrices(
        "housing",
        mass=scipy.sparse.csr_matrix(mass),
        stiffness=stiffness,
        interfaces=_on(frame, free),
        highest_frequency=highest,
        **more,
    )


def _full(free: bool, speed: float) -> tuple[dict[str, Any], Frame, int]:
    """Matrices of the rotor and of all degrees of freedom of the frame, independent of any reduction."""
    system = _rotor(None, gravity=None)
    own = system.matrices(speed)
    mass, stiffness, frame = _two_seats(free)
    size = len(system.dofs)
    full = {
        "mass": scipy.linalg.block_diag(own.mass, mass),
        "stiffness": scipy.linalg.block_diag(own.stiffness, stiffness),
        "damping": scipy.linalg.block_diag(own.damping, 0.0 * mass),
        "gyroscopic": scipy.linalg.block_diag(own.gyroscopic, 0.0 * mass),
    }
    index = {dof: i for i, dof in enumerate(system.dofs)}
    for x, k, a in ((0.0, (5e7, 8e7), 3e7), (0.6, (6e7, 9e7), 0.0)):
        rows = [size + row for row in frame.rows(x, 0.0, 0.0)]
        for direction, at, spring, damper in (
            ("v", rows[1], k[0], 600.0),
            ("w", rows[2], k[1], 600.0),
            ("u", rows[0], a, 0.0),
        ):
            i = index["rotor", x, direction]
            for name, value in (("stiffness", spring), ("damping", damper)):
                full[name][i, at] -= value
                full[name][at, i] -= value
                full[name][at, at] += value
    if free:
        for x in (0.0, 0.6):
            for y in (-0.15, 0.2):
                rows = [size + row for row in frame.rows(x, y, -0.3)]
                for row, spring, damper in zip(
                    rows, (3e7, 4e7, 8e7), (200.0, 200.0, 300.0), strict=False
                ):
                    full["stiffness"][row, row] += spring
                    full["damping"][row, row] += damper
    return full, frame, size


@pytest.mark.parametrize("free", [False, True])
def test_reduced_beside_full_matrices(free: bool) -> None:
    speed = 250.0
    full, frame, size = _full(free, speed)
    rate = full["damping"] + speed * full["gyroscopic"]
    frequencies = 2.0 * np.pi * np.array([31.0, 180.0, 420.0, 900.0, 1400.0])
    system = _rotor(_made(free), gravity=None)
    source = gb.Force("disk", 1.0)
    response = system.frequency_response(frequencies, speed=speed, source=source)
    dofs = _rotor(None, gravity=None).dofs
    excited = dofs.index(("rotor", 0.25, "v"))
    sensor = size + frame.rows(0.0, 0.2, 0.0)[2]
    for k, omega in enumerate(frequencies):
        dynamic = full["stiffness"] + 1j * omega * rate - omega**2 * full["mass"]
        force = np.zeros(dynamic.shape[0])
        force[excited] = 1.0
        exact = np.linalg.solve(dynamic, force)
        assert response.displacement("disk")[k, 0, 0] == pytest.approx(exact[excited], rel=1e-3)
        # up to the highest frequency of interest, at a sensor that carries no force
        assert response.displacement("sensor")[k, 0, 1] == pytest.approx(exact[sensor], rel=1e-3)
    state = np.block(
        [
            [np.zeros_like(rate), np.eye(len(rate))],
            [
                -np.linalg.solve(full["mass"], full["stiffness"]),
                -np.linalg.solve(full["mass"], rate),
            ],
        ]
    )
    exact_modes = np.linalg.eigvals(state)
    exact_modes = np.sort(exact_modes[exact_modes.imag > 1.0].imag) / (2.0 * np.pi)
    found = np.sort(system.modes(speed, count=24, vibrating=True).frequencies_hz)
    found = found[found < 1500.0]
    assert found.size >= 12
    assert found == pytest.approx(exact_modes[: found.size], rel=1e-3)


def test_the_error_falls_as_more_modes_are_kept() -> None:
    full, frame, size = _full(False, 250.0)
    rate = full["damping"] + 250.0 * full["gyroscopic"]
    omega = 2.0 * np.pi * 120.0
    dynamic = full["stiffness"] + 1j * omega * rate - omega**2 * full["mass"]
    force = np.zeros(dynamic.shape[0])
    force[_rotor(None, gravity=None).dofs.index(("rotor", 0.25, "v"))] = 1.0
    exact = np.linalg.solve(dynamic, force)[size + frame.rows(0.0, 0.2, 0.0)[2]]
    errors = []
    for highest in (60.0, 150.0, 500.0):
        system = _rotor(_made(False, highest), gravity=None)
        source = gb.Force("disk", 1.0)
        response = system.frequency_response([omega], speed=250.0, source=source)
        errors.append(abs(response.displacement("sensor")[0, 0, 1] / exact - 1.0))
    assert errors[0] > 3.0 * errors[1] > 9.0 * errors[2]


def _reducer_in_a_box(highest: float) -> gb.RotorSystem:
    """The coaxial reducer in three walls of bars with 2,088 degrees of freedom, on four feet."""
    radius, parts = 0.035, 8
    walls, sides, heights = (0.665, 0.774, 0.9), (-0.15, 0.35), (-0.2, 0.2)
    frame = Frame()
    for x in walls:
        for y in sides:
            frame.bar((x, y, heights[0]), (x, y, 0.0), radius, parts)
            frame.bar((x, y, 0.0), (x, y, heights[1]), radius, parts)
        for z in heights:
            frame.bar((x, sides[0], z), (x, sides[1], z), radius, 2 * parts)
        for ends in pairwise((sides[0], 0.0, 0.19, sides[1])):
            frame.bar((x, ends[0], 0.0), (x, ends[1], 0.0), radius, parts)
    for begin, end in pairwise(walls):
        for y in sides:
            for z in (*heights, 0.0):
                frame.bar((begin, y, z), (end, y, z), radius, parts)
    # the bearings of three shafts have places of their own beside the walls
    for begin, end, y in ((0.774, 0.775, 0.0), (0.774, 0.773, 0.0), (0.9, 0.895, 0.19)):
        frame.bar((begin, y, 0.0), (end, y, 0.0), 0.05, 1)
    # in the order of the bearings of the reducer
    places = (0.665, 0.0), (0.775, 0.0), (0.665, 0.19), (0.895, 0.19), (0.773, 0.0), (0.9, 0.0)
    seats = {
        f"seat {number}": gb.Interface((x, y, 0.0), rows=frame.rows(x, y, 0.0))
        for number, (x, y) in enumerate(places)
    }
    seats["sensor"] = gb.Interface((0.9, 0.35, 0.2), rows=frame.rows(0.9, 0.35, 0.2)[:3])
    for x in (0.665, 0.9):
        for y in sides:
            seats[f"foot {x:g} {y:g}"] = gb.Interface(
                (x, y, -0.2),
                rows=frame.rows(x, y, -0.2),
                stiffness=(3e7, 4e7, 6e7),
                damping=(2e3, 2e3, 2e3),
            )
    mass, stiffness = map(scipy.sparse.csr_matrix, frame.matrices())
    assert mass.shape == (2088, 2088)
    housing = gb.Housing.from_matrices(
        "housing",
        mass=mass,
        stiffness=stiffness,
        interfaces=seats,
        highest_frequency=highest,
        damping_ratio=0.01,
    )
    reducer = gb.examples()["coaxial_reducer"].load()
    ground = [bearing for bearing in reducer.bearings if bearing.support is None]
    on_housing = [bearing for bearing in reducer.bearings if bearing.support is not None]
    seated = [
        replace(bearing, support=("housing", f"seat {number}"))
        for number, bearing in enumerate(on_housing)
    ]
    return reducer.replace(bearings=[*ground, *seated], housings=[housing])


def test_a_reducer_in_a_box_up_to_its_highest_frequency() -> None:
    frequencies = 2.0 * np.pi * np.linspace(20.0, 4000.0, 40)

    def motion(highest: float) -> Any:
        response = _reducer_in_a_box(highest).frequency_response(
            frequencies, speed=129.22, source=gb.Force("z3", 1.0)
        )
        return [response.displacement(at)[:, 0] for at in ("z3", "sensor")]

    exact = motion(8000.0)
    errors = {
        highest: [
            np.abs(own - all_modes).max() / np.abs(all_modes).max()
            for own, all_modes in zip(motion(highest), exact, strict=True)
        ]
        for highest in (1000.0, 4000.0)
    }
    # 1e-3 up to the highest frequency, and ten times more with the modes of a quarter of it
    assert max(errors[4000.0]) < 1e-3
    assert min(errors[1000.0]) > 10.0 * max(errors[4000.0])


def test_a_run_beside_the_full_matrices() -> None:
    """20 ms at constant speed from rest: bow and unbalance turn, and the housing follows."""

    speed = 250.0
    full, frame, size = _full(True, speed)
    plain = _rotor(None, gravity=None)
    forces = plain.synchronous([speed])
    # the force of bow and unbalance follows from the response of the rotor on rigid ground
    own = plain.matrices(speed)
    rate = own.damping + speed * own.gyroscopic
    dynamic = own.stiffness + 1j * speed * rate - speed**2 * own.mass
    phasor = np.zeros(len(full["mass"]), dtype=complex)
    phasor[:size] = dynamic @ forces.amplitudes[0, 0]
    inverse = np.linalg.inv(full["mass"])
    rates = inverse @ full["stiffness"], inverse @ (full["damping"] + speed * full["gyroscopic"])
    load = inverse @ phasor

    # exact steps of the linear system, to which the turning load adds two states cos Ωt and sin Ωt
    count = len(phasor)
    state = np.zeros((2 * count + 2, 2 * count + 2))
    state[:count, count : 2 * count] = np.eye(count)
    state[count : 2 * count, :count] = -rates[0]
    state[count : 2 * count, count : 2 * count] = -rates[1]
    state[count : 2 * count, -2] = load.real
    state[count : 2 * count, -1] = -load.imag
    state[-2, -1], state[-1, -2] = -speed, speed
    end = 0.02
    times = np.linspace(0.0, end, 9)
    step = scipy.linalg.expm(state * times[1])
    exact = [np.concatenate([np.zeros(2 * count), [1.0, 0.0]])]
    for _ in times[1:]:
        exact.append(step @ exact[-1])
    values = np.array(exact).T
    system = _rotor(_made(True, 4000.0), gravity=None)
    run = system.simulate(
        end, speed, initial="rest", times=times, record=["disk", "sensor"], rtol=1e-7
    )
    disk = plain.dofs.index(("rotor", 0.25, "v"))
    largest = np.abs(values[disk]).max()
    assert np.abs(run.displacement("disk")[:, 0] - values[disk]).max() < 1e-3 * largest
    sensor = size + frame.rows(0.0, 0.2, 0.0)[1]
    largest = np.abs(values[sensor]).max()
    assert np.abs(run.displacement("sensor")[:, 0] - values[sensor]).max() < 3e-3 * largest


@pytest.mark.parametrize("film", [False, True])
def test_a_stiff_housing_is_a_rigid_one(film: bool) -> None:
    """A free body with no modes below 30 kHz moves as the rigid body of its mass and inertia."""
    mass, inertia = 40.0, (1.0, 2.0, 2.5)
    centre = np.array([0.3, 0.0, 0.1])
    body = np.diag([mass] * 3 + list(inertia))
    k = {"stiffness": (2e7, 3e7), "axial_stiffness": 1e7, "rotational_stiffness": (1e6, 2e6, 3e6)}
    stiffness = np.diag([1e7, 2e7, 3e7, 1e6, 2e6, 3e6])

    def rows(position: Any) -> Any:
        x, y, z = np.array(position) - centre
        return np.block(
            [
                [np.eye(3), np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])],
                [np.zeros((3, 3)), np.eye(3)],
            ]
        )

    seats = {
        f"seat {x:g}": gb.Interface((x, 0.0, 0.0), rows=rows((x, 0.0, 0.0))) for x in (0.0, 0.6)
    }
    seats["sensor"] = gb.Interface((0.1, 0.2, 0.3), rows=rows((0.1, 0.2, 0.3)))
    elastic = gb.Housing.from_matrices(
        "housing", mass=body, stiffness=stiffness, interfaces=seats, highest_frequency=3e4
    )
    rigid = gb.Housing(
        "housing",
        mass=mass,
        inertia=inertia,
        position=tuple(centre),
        points={"sensor": (0.1, 0.2, 0.3)},
        **k,
    )
    seated = _rotor(elastic, gravity=None)
    bearings = [replace(bearing, support="housing") for bearing in seated.bearings]
    systems = [seated, seated.replace(housings=[rigid], bearings=bearings)]
    if film:
        size = {"diameter": 0.1, "length": 0.02, "clearance": 1e-4, "viscosity": 0.02}

        def on_films(system: gb.RotorSystem) -> gb.RotorSystem:
            ring = gb.SqueezeFilm(mass=2.0, stiffness=5e6, **size)
            changed = [
                replace(each, support=replace(ring, support=each.support))
                for each in system.bearings
            ]
            return system.replace(bearings=changed)

        systems = [on_films(system) for system in systems]
    one, other = (system.modes(200.0, count=16) for system in systems)
    assert one.frequencies_hz == pytest.approx(other.frequencies_hz, rel=1e-6)
    one, other = (system.synchronous([200.0]).acceleration("sensor") for system in systems)
    assert one == pytest.approx(other, rel=1e-6)
    one, other = (
        system.simulate(0.01, 200.0, record=["sensor", "acceleration"]).acceleration("sensor")
        for system in systems
    )
    assert np.abs(one - other).max() < 1e-6 * np.abs(other).max()


def test_a_free_body_keeps_six_motions_and_its_mass() -> None:
    housing = _made(True)
    assert np.count_nonzero(np.array(housing.elastic.frequencies) == 0.0) == 6
    mass, _, frame = _two_seats(True)
    total = sum(mass[row, row] for node in range(len(frame.nodes)) for row in [6 * node])
    assert housing.mass == pytest.approx(total, rel=1e-9)
    weight = _rotor(housing).static().bearing_force(("rotor", 0.0))
    ground = _rotor(None).static().bearing_force(("rotor", 0.0))
    assert weight == pytest.approx(ground, rel=1e-6)
    # the feet carry the weight of rotor and housing: the sensor sinks
    sunk = _rotor(housing).static().displacement("sensor")[1]
    rotor = _rotor(None).mass_properties().mass[-1]
    assert sunk == pytest.approx(-(total + rotor) * 9.81 / (4 * 8e7), rel=0.5)


def test_interfaces_are_places_of_results() -> None:
    housing = _made(True)
    system = _rotor(housing)
    run = system.simulate(5e-3, 200.0, record=["sensor", "seat 0", "velocity", "acceleration"])
    for at in ("sensor", "seat 0"):
        assert run.displacement(at).shape == (run.time.size, 2)
        assert run.axial(at).shape == run.time.shape
    moved = run.measure(gb.Accelerometer("sensor", angle=0.5))
    expected = run.acceleration("sensor") @ [np.cos(0.5), np.sin(0.5)]
    assert moved == pytest.approx(expected)
    response = system.synchronous([200.0])
    relative = response.bearing_displacement(("rotor", 0.0))
    own = response.displacement(("rotor", 0.0)) - response.displacement("seat 0")
    assert relative == pytest.approx(own)
    assert response.axial_displacement("sensor").shape == (1, 1)
    modes = system.modes(count=6)
    assert modes.displacement("sensor").shape == (6, 2)
    assert "modes" in modes.table() or "housing" in modes.table()
    ground = system.frequency_response([100.0], source=gb.GroundMotion(1.0))
    assert np.abs(ground.displacement("sensor")).max() > 0.0


def test_universal_files_of_modes_have_the_interfaces(tmp_path: Path) -> None:
    system = elastic("housing", sensor=True)
    modes = system.modes(count=8)
    modes.save(tmp_path / "modes.uff")
    nodes, *sets = data_sets(tmp_path / "modes.uff")
    (housing,) = system.housings
    assert housing.elastic is not None
    own = housing.elastic.interfaces
    # the interfaces are the last nodes, with their motion along x too
    last = [line for line in nodes.lines() if line.strip()][-1]
    assert [float(x) for x in last.split()] == list(own[list(own)[-1]]["position"])
    at = [i for i, (name, _, _) in enumerate(modes.dofs) if name == "housing"]
    x = modes.shapes[:, at] @ np.array(own["sensor"]["rows"][0])
    numbers = {name: len(modes._nodes()) + 1 + i for i, name in enumerate(own)}
    for mode, given in enumerate(sets):
        lines = given.lines()
        line = lines[lines.index(f"{numbers['sensor']:10d}", 8) + 1].split()
        moved = [float(line[i]) + 1j * float(line[i + 1]) for i in (0, 2, 4)]
        expected = [x[mode], *modes.displacement("sensor")[mode]]
        # five digits of the format
        assert moved == pytest.approx(expected, rel=1e-5, abs=1e-12)
    found = modes.compare(tmp_path / "modes.uff")
    assert "sensor" in read_uff(tmp_path / "modes.uff", None, modes._places()).places
    moves = modes._translations(modes._places()).any(axis=(1, 2))  # others move along the axis only
    assert moves.sum() >= 3
    assert np.diag(found.mac)[moves] == pytest.approx(np.ones(moves.sum()), abs=1e-9)


@pytest.mark.parametrize("speed", [250.0, -250.0])
def test_the_radiated_power_is_that_of_the_velocity_along_the_normal(
    speed: float, tmp_path: Path
) -> None:
    _, _, frame = _two_seats(True)
    # the nodes of interfaces, whose motion is known, with normals in all directions
    names = {"sensor": (0.0, 0.2, 0.0), "seat 0": (0.0, 0.0, 0.0), "foot 0.6 0.2": (0.6, 0.2, -0.3)}
    areas = np.array([[0.01, -0.02, 0.005], [-0.003, 0.001, 0.04], [0.002, 0.003, 0.0]])
    rows = [frame.rows(*place)[:3] for place in names.values()]
    system = _rotor(_made(True, surface=gb.Surface(rows, areas)), gravity=None)
    system.save(tmp_path / "scene.toml")
    sources = {
        "frequency": lambda given: given.frequency_response(
            [200.0, 900.0], source=gb.Force("disk", (1.0, 2.0j)), speed=speed
        ),
        "synchronous": lambda given: given.synchronous([speed, 2.0 * speed]),
    }
    for name, analysis in sources.items():
        response = analysis(system)
        rates = np.array([200.0, 900.0] if name == "frequency" else [speed, 2.0 * speed])[:, None]
        expected = 0.0
        for place, area in zip(names, areas, strict=True):
            lateral, axial = response.displacement(place), response.axial_displacement(place)
            normal = area / np.linalg.norm(area)
            moved = normal[0] * axial + lateral @ normal[1:]
            expected = expected + np.linalg.norm(area) * np.abs(rates * moved) ** 2
        power = response.radiated_power("housing", density=1.2, sound_speed=340.0)
        # round-off of the modes
        assert power == pytest.approx(1.2 * 340.0 / 2.0 * expected, rel=1e-9)
        assert power.min() > 0.0
        read = analysis(gb.RotorSystem.load(tmp_path / "scene.toml"))
        kept = read.radiated_power("housing", density=1.2, sound_speed=340.0)
        assert kept == pytest.approx(power, rel=1e-12)


def test_errors_of_surfaces() -> None:
    for rows, areas, message in (
        ([[0, 1]], [[0.0, 0.0]], "must have the shape"),
        ([[0, 1, 2]], [[0.0, 0.0, 1.0]] * 2, "must have the shape"),
        ([[0, 1, 2], [0, 1, 10**6]], [[0.0, 0.0, 1.0]] * 2, r"surface.rows\[1\]: must be whole"),
        ([[0, 1, 2], [0, 1, 2]], [[0.0, 0.0, 1.0], [0.0] * 3], r"surface.areas\[1\]: must not"),
    ):
        with pytest.raises(gb.SceneError, match=message):
            _made(True, surface=gb.Surface(rows, areas))
    with pytest.raises(gb.SceneError, match=r"surface: must be a gb\.Surface"):
        _made(True, surface=[[0, 1, 2]])
    response = _rotor(_made(True), gravity=None).synchronous([100.0])
    with pytest.raises(gb.SceneError, match="no housing of this system has a surface"):
        response.radiated_power("housing")


def test_the_end_view_shows_interfaces_without_bearings() -> None:
    view = elastic("housing", sensor=True).plot().axes[1]
    assert "sensor" in {text.get_text() for text in view.texts}
    (low, high) = view.get_ylim()
    assert low < 0.2 < high  # its height


def test_scenes_keep_an_elastic_housing() -> None:
    system = _rotor(_made(True))
    twin = gb.RotorSystem.from_dict(system.description)
    assert twin.housings == system.housings
    assert twin.modes(count=4).frequencies_hz == pytest.approx(
        system.modes(count=4).frequencies_hz, rel=1e-12
    )


def _small(**changes: Any) -> gb.Housing:
    given: dict[str, Any] = {
        "mass": 5.0 * np.eye(3),
        "stiffness": 1e6 * np.eye(3),
        "interfaces": {"seat": gb.Interface((0.0, 0.0, 0.0), rows=[0, 1, 2])},
        "highest_frequency": 1000.0,
    }
    return gb.Housing.from_matrices("housing", **{**given, **changes})


def test_errors_of_matrices_and_interfaces() -> None:
    cases: list[tuple[dict[str, Any], str]] = [
        ({"mass": np.ones((2, 3))}, r"mass: must be a square matrix, got the shape \(2, 3\)"),
        ({"mass": np.triu(np.ones((3, 3)))}, "mass: must be symmetric"),
        ({"stiffness": np.full((3, 3), np.nan)}, "stiffness: every entry must be finite"),
        ({"stiffness": 1e6 * np.eye(4)}, "stiffness: must have the shape of mass"),
        ({"stiffness": np.diag([0.0, 1e6, 1e6])}, "stiffness: leaves 1 rigid-body motions free"),
        ({"highest_frequency": -1.0}, "highest_frequency: must be positive"),
        ({"interfaces": {}}, "interfaces: must be a dict of gb.Interface"),
        (
            {"interfaces": {"seat": gb.Interface((0.0, 0.0, 0.0), rows=[0, 1])}},
            r"interfaces\['seat'\].rows: must have 3 displacements",
        ),
        (
            {"interfaces": {"seat": gb.Interface((0.0, 0.0, 0.0), rows=[0, 1, 7])}},
            r"interfaces\['seat'\].rows\[2\]: must be below the 3 degrees of freedom",
        ),
    ]
    for changes, message in cases:
        with pytest.raises(gb.SceneError, match=message):
            _small(**changes)
    mass, stiffness, frame = _two_seats(True)
    seats = _on(frame, True)
    moved = gb.Interface((0.1, 0.0, 0.0), rows=frame.rows(0.0, 0.0, 0.0))
    with pytest.raises(gb.SceneError, match="positions and rows do not fit"):
        gb.Housing.from_matrices(
            "housing",
            mass=mass,
            stiffness=stiffness,
            interfaces={**seats, "seat 0": moved},
            highest_frequency=500.0,
        )


def test_errors_of_bearings_on_interfaces() -> None:
    housing = _made(True)
    system = _rotor(housing)

    def on(support: Any, x: float = 0.0) -> None:
        first = gb.Bearing("rotor", x, stiffness=5e7, support=support)
        system.replace(bearings=[first, system.bearings[1]])

    with pytest.raises(gb.SceneError, match="name an interface of the elastic housing"):
        on("housing")
    with pytest.raises(gb.SceneError, match='the housing has no interface "seat 1"'):
        on(("housing", "seat 1"))
    with pytest.raises(gb.SceneError, match=r"the bearing is at .* from the interface"):
        on(("housing", "seat 0"), 0.2)
    with pytest.raises(gb.SceneError, match='no support or housing is called "box"'):
        on(("box", "seat 0"))
    clamped = _rotor(_made(False))
    with pytest.raises(gb.SceneError, match="clamped in its matrices"):
        clamped.frequency_response([100.0], source=gb.GroundMotion(1.0))
