"""Frequency response: closed forms, reciprocity, simulated amplitudes, synchronous response, modes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gearbow as gb
from reference.machines import helical_pair, hostile, two_disks_in_torsion
from reference.receptance import Beam

#: Names, and springs at the left and the right end, of a beam.
ENDS = {
    "free-free": ((0.0, 0.0), (0.0, 0.0)),
    "pinned": ((1e11, 0.0), (1e11, 0.0)),
    "cantilever": ((1e10, 1e7), (0.0, 0.0)),
}


def beam_system(beam: Beam, **options):
    """Return the beam as a system of elements of degree 6."""
    bearings = [
        gb.Bearing("s", x, stiffness=lateral, tilting_stiffness=tilting)
        for x, (lateral, tilting) in zip((0.0, beam.length), beam.springs, strict=True)
        if lateral
    ]
    shaft = gb.Shaft(
        "s",
        length=beam.length,
        outer_diameter=beam.diameter,
        material=gb.Material(beam.youngs_modulus, beam.density, poisson_ratio=0.3),
        shear=False,
        **({"elements": 20, "degree": 6} | options),
    )
    return gb.RotorSystem(
        [shaft], bearings=bearings, rayleigh=beam.rayleigh, motion="lateral", accuracy="reference"
    )


@pytest.mark.parametrize("ends", ENDS)
@pytest.mark.parametrize("spin", [0.0, 400.0])
def test_receptance_is_that_of_a_rayleigh_beam(ends: str, spin: float):
    beam = Beam(springs=ENDS[ends], rayleigh=(3.0, 4e-6), spin=spin)
    system = beam_system(beam)
    # ten bending modes; the free beam without rotary inertia has the highest frequencies
    wave = 10.5 * np.pi / beam.length
    tenth = wave**2 * np.sqrt(beam.youngs_modulus / beam.density) * beam.diameter / 4.0
    frequencies = np.linspace(30.0, tenth, 40)
    if spin:
        frequencies = np.concatenate([-frequencies, frequencies])
    # nodes and places between nodes, of the force and of the response
    for force_at, at in ((0.4, 0.9), (0.437, 0.437), (1.17, 0.013)):
        source = gb.Force(("s", force_at), (1.0, -1j))
        found = system.frequency_response(frequencies, source=source, speed=spin)
        u = found.displacement(("s", at))[:, 0]
        exact = [beam.receptance(at, force_at, w) for w in frequencies]
        # The element in which a force acts lacks a part of its static deflection: degree 6 leaves less than 2 % of
        # l³/(192 EI) = 8.5e-12 m/N.
        lacking = 0.02 * 8.5e-12 if at == force_at else 0.0
        assert u[:, 0] == pytest.approx(exact, rel=1e-6, abs=lacking + 1e-6 * np.abs(exact).min())
        # a forward rotation: w = −i v
        assert u[:, 1] == pytest.approx(-1j * u[:, 0], rel=1e-9, abs=1e-9 * np.abs(u).max())


def tip_receptances(x: float, ends: str) -> list[float]:
    """Receptances at a free end and between both ends, times EI λ³, of a thin beam with λL = x.

    R. E. D. Bishop, D. C. Johnson, *The mechanics of vibration* (1960), table 7.1(c).
    """
    even, odd = np.cos(x) * np.cosh(x), np.cos(x) * np.sinh(x) - np.sin(x) * np.cosh(x)
    if ends == "cantilever":
        return [-odd / (even + 1.0), 0.0]
    return [-odd / (even - 1.0), (np.sin(x) - np.sinh(x)) / (even - 1.0)]


@pytest.mark.parametrize("ends", ["free-free", "cantilever"])
# Such a thin shaft is implausible, and the clamp is 1e9 times as stiff.
@pytest.mark.filterwarnings("ignore::gearbow.SceneWarning")
@pytest.mark.filterwarnings("ignore::gearbow.AccuracyWarning")
def test_receptances_of_a_thin_shaft_are_those_of_bishop_and_johnson(ends: str):
    beam = Beam(length=1.0, diameter=1e-4, rayleigh=(0.0, 0.0))
    stiffness = beam.youngs_modulus * np.pi / 64.0 * beam.diameter**4
    # A bearing 1e9 times as stiff as the beam moves it by 1e-9.
    clamp = (1e9 * stiffness, 1e9 * stiffness) if ends == "cantilever" else (0.0, 0.0)
    system = beam_system(replace(beam, springs=((0.0, 0.0), clamp)))
    for x in (1.0, 3.3, 6.5, 9.0):
        w = x**2 * beam.diameter / 4.0 * np.sqrt(beam.youngs_modulus / beam.density)
        found = system.frequency_response([w], source=gb.Force(("s", 0.0), 1.0))
        exact = np.array(tip_receptances(x, ends)) / (stiffness * x**3)
        at_ends = [found.displacement(("s", at))[0, 0, 0] for at in (0.0, 1.0)]
        # Rotary inertia and the bearing are below 1e-7 of it.
        assert at_ends == pytest.approx(exact, rel=1e-6, abs=1e-6 * abs(exact[0]))


def test_torsion_at_engine_orders_is_that_of_two_disks():
    system = two_disks_in_torsion()
    orders, speeds = [0.5, 1.0, 1.5, 4.0], np.array([50.0, 180.0, 400.0])
    found = system.frequency_response(order=orders, speeds=speeds, source=gb.Torque("d0", 3.0))
    assert found.axes == ("speed", "order")
    k = 207e9 / 2.6 * np.pi * 0.03**4 / 32.0 / 0.5
    for i, speed in enumerate(speeds):
        for j, order in enumerate(orders):
            w2 = (order * speed) ** 2
            exact = np.linalg.solve([[k - 0.02 * w2, -k], [-k, k - 0.05 * w2]], [3.0, 0.0])
            twist = [found.twist(f"d{n}")[i, j, 0] for n in range(2)]
            # the shaft has a millionth of the inertia
            assert twist == pytest.approx(exact, rel=1e-5)


def train(**options):
    """Return two geared shafts with unsymmetric bearings, one of them on a pedestal."""
    shafts = [
        gb.Shaft("in", length=0.4, outer_diameter=0.045, elements=4),
        gb.Shaft("out", length=0.5, outer_diameter=0.05, elements=4, bow=gb.Bow.half_sine(5e-5)),
    ]
    gears = [
        gb.Gear("pinion", "in", 0.15, teeth=23, module=3e-3, face_width=0.03, unbalance=2e-5),
        gb.Gear("wheel", "out", 0.2, teeth=46, module=3e-3, face_width=0.03, unbalance=5e-5j),
    ]
    bearings = [
        gb.Bearing("in", 0.0, stiffness=(8e7, 5e7), damping=(2e3, 1e3)),
        gb.Bearing("in", 0.4, stiffness=[[6e7, 1e7], [1e7, 9e7]], damping=1.5e3),
        gb.Bearing("out", 0.0, stiffness=1e8, damping=2e3, support="pedestal"),
        gb.Bearing("out", 0.5, stiffness=1e8, damping=2e3),
    ]
    given = {
        "shafts": shafts,
        "gears": gears,
        "meshes": [gb.Mesh("pinion", "wheel", stiffness=2e8, damping_ratio=0.06)],
        "bearings": bearings,
        "supports": [gb.Support("pedestal", mass=30.0, stiffness=2e8, damping=4e3)],
        "drives": [gb.Drive(("in", 0.4), stiffness=2e4, damping=20.0)],
        "rayleigh": (20.0, 1e-6),
    }
    return gb.RotorSystem(**(given | options))


def test_a_response_is_reciprocal():
    system = train()
    places = [("in", 0.07), ("out", 0.33), "pinion"]
    directions = [1.0, 1j]
    sources = [gb.Force(at, direction) for at in places for direction in directions]
    frequencies = np.array([300.0, 1234.0, 5000.0])

    def receptance(speed: float) -> np.ndarray:
        found = system.frequency_response(frequencies, source=sources, speed=speed)
        return np.concatenate([found.displacement(at) for at in places], axis=-1)

    rest = receptance(0.0)
    scale = 1e-9 * np.abs(rest).max()
    assert rest == pytest.approx(np.swapaxes(rest, 1, 2), rel=1e-9, abs=scale)
    # The flanks in contact change with the sense of rotation: without meshes H_ij(Ω) = H_ji(−Ω).
    coupling = gb.Coupling(
        ("in", 0.4), ("out", 0.0), lateral_stiffness=1e7, torsional_stiffness=1e4
    )
    system = train(meshes=(), gears=(), couplings=[coupling])
    places.pop()
    sources = [gb.Force(at, direction) for at in places for direction in directions]
    forward, backward = receptance(600.0), receptance(-600.0)
    assert forward == pytest.approx(np.swapaxes(backward, 1, 2), rel=1e-9, abs=scale)
    assert np.abs(forward - np.swapaxes(forward, 1, 2)).max() > 1e-3 * np.abs(forward).max()


def test_negative_frequencies_give_conjugate_responses():
    system = train()
    source = [gb.Force("pinion", 1.0), gb.Torque("wheel", 2.0), gb.MeshExcitation("pinion/wheel")]
    found = system.frequency_response([-800.0, 800.0], source=source, speed=90.0)
    assert found.phasors[0] == pytest.approx(np.conj(found.phasors[1]), rel=1e-9, abs=1e-18)
    force = found.mesh_force("wheel/pinion")
    assert force[0] == pytest.approx(np.conj(force[1]), rel=1e-9)


def test_unbalance_and_bow_at_order_one_are_the_synchronous_response():
    system, speeds = train(), np.array([-250.0, 40.0, 300.0])
    known = system.synchronous(speeds)
    for index, (shaft, ratio) in enumerate(zip(("in", "out"), system.speed_ratios, strict=True)):
        found = system.frequency_response(
            order=ratio, speeds=speeds, source=gb.ShaftExcitation(shaft)
        )
        # one linear system, solved with the same factors
        scale = 1e-12 * np.abs(known.amplitudes).max()
        assert found.phasors[:, 0] == pytest.approx(known.amplitudes[:, index], abs=scale)
        for at in (("in", 0.4), ("out", 0.0)):
            assert found.bearing_force(at)[:, 0] == pytest.approx(
                known.bearing_force(at)[:, index], rel=1e-9
            )


def test_residues_are_those_of_the_modes():
    system = beam_system(Beam(springs=ENDS["pinned"], rayleigh=(2.0, 0.0)), elements=4, degree=3)
    modes, speed = system.modes(0.0), 0.0
    at, matrices = ("s", 0.6), system.matrices(0.0)
    index = system.coordinates.lateral(at)[0]
    w = 700.0
    found = system.frequency_response([w], source=gb.Force(at, 1.0), speed=speed)
    # Complex modes with symmetric matrices: H = Σ φφᵀ/(a(iω − λ)) + conjugate, a = φᵀ(2λM + C)φ.
    total = 0.0
    for value, shape in zip(modes.eigenvalues, modes.shapes, strict=True):
        a = shape @ (2.0 * value * matrices.mass + matrices.damping) @ shape
        term = shape[index] ** 2 / a
        total += term / (1j * w - value) + np.conj(term) / (1j * w - np.conj(value))
    # Equal modes of both planes have arbitrary shapes, which the sum over both does not depend on.
    assert found.displacement(at)[0, 0, 0] == pytest.approx(total, rel=1e-6)


def test_a_settled_run_has_the_amplitude_of_the_response():
    random = np.random.default_rng(7)
    system = train(
        shafts=[
            gb.Shaft("in", length=0.4, outer_diameter=0.045, elements=3, degree=4),
            gb.Shaft("out", length=0.5, outer_diameter=0.05, elements=3, degree=4),
        ],
        gears=[
            gb.Gear("pinion", "in", 0.15, teeth=23, module=3e-3, face_width=0.03),
            gb.Gear("wheel", "out", 0.2, teeth=46, module=3e-3, face_width=0.03),
        ],
        rayleigh=(200.0, 2e-5),
    )
    for _ in range(8):
        speed, w = random.uniform(-300.0, 300.0), random.uniform(300.0, 4000.0)
        # The force acts at a node of the run. The response is that of any place between nodes.
        place = ("in", float(random.choice([0.15, 0.4])))
        shafts = [("in", random.uniform(0.0, 0.4)), ("out", random.uniform(0.0, 0.5))]
        force = complex(*random.normal(size=2))
        series = gb.Force(place, lambda t, w=w, force=force: force * np.cos(w * t))
        run = system.replace(forces=[series]).simulate(
            0.12, speed, geometry="frozen", rtol=1e-9, record=shafts, output_step=2e-5
        )
        found = system.frequency_response([w], source=gb.Force(place, force), speed=speed)
        kept = run.time > 0.09
        t = run.time[kept]
        columns = np.stack([np.cos(w * t), -np.sin(w * t), np.ones_like(t)], axis=1)
        for at in shafts:
            a, b, _ = np.linalg.lstsq(columns, run.displacement(at)[kept], rcond=None)[0]
            u = found.displacement(at)[0, 0]
            # transients decay by e^{-200·0.09/2} at least; force samples of the run
            assert a + 1j * b == pytest.approx(u, rel=1e-4, abs=1e-4 * np.abs(u).max())
            twist = np.linalg.lstsq(columns, run.twist(at)[kept], rcond=None)[0]
            assert complex(*twist[:2]) == pytest.approx(found.twist(at)[0, 0], rel=1e-3)


def settled(run: gb.Response, frequency: float, values: np.ndarray) -> np.ndarray:
    """Return the phasors of signals (times, ...) at a frequency after the transients of 0.15 s."""
    kept = run.time > 0.15
    t = frequency * run.time[kept]
    columns = np.stack([np.cos(t), -np.sin(t), np.ones_like(t)], axis=1)
    found = np.linalg.lstsq(columns, values[kept].reshape(t.size, -1), rcond=None)[0]
    return (found[0] + 1j * found[1]).reshape(values.shape[1:])


def test_every_quantity_of_a_helical_pair_is_that_of_a_settled_run():
    pair = helical_pair(
        mesh={"damping_ratio": 0.1},
        bearing={"damping": 5e3, "axial_damping": 2e4, "support": "foot"},
        supports=[gb.Support(stiffness=2e8, damping=2e4, mass=5.0, name="foot")],
        rayleigh=(80.0, 2e-5),
    )
    pair = pair.replace(
        shafts=[replace(shaft, bow=None) for shaft in pair.shafts],
        gears=[replace(gear, unbalance=0.0) for gear in pair.gears],
    )
    w, speed, force = 900.0, 50.0, 3.0 - 2.0j
    source = gb.Force("g1", lambda t: force * np.cos(w * t))
    run = pair.replace(forces=[source]).simulate(
        0.25,
        speed,
        geometry="frozen",
        rtol=1e-9,
        record=["gears", "meshes", "bearings", "velocity", "acceleration"],
        output_step=1e-4,
    )
    found = pair.frequency_response([w], source=gb.Force("g1", force), speed=speed)
    sensors = [gb.Accelerometer("g1", angle=0.3), gb.Probe("output", 0.15, angle=-0.7)]
    pairs = [
        (run.mesh("g1/g2").force, found.mesh_force("g1/g2")),
        *((run.measure(sensor), found.measure(sensor)) for sensor in sensors),
        *(
            (run.bearing_force(at), found.bearing_force(at))
            for at in [(bearing.shaft, bearing.position) for bearing in pair.bearings]
        ),
    ]
    for gear in ("g1", "g2"):
        pairs += [
            (run.displacement(gear), found.displacement(gear)),
            (run.velocity(gear), found.velocity(gear)),
            (run.twist(gear), found.twist(gear)),
            (run.axial(gear), found.axial_displacement(gear)),
        ]
    for values, phasors in pairs:
        # The force is sampled by the run, with errors of 1e-5; transients decay by e^-6 at least.
        assert settled(run, w, values) == pytest.approx(
            phasors[0, 0], rel=1e-4, abs=1e-4 * np.abs(phasors).max()
        )
    values = pair.sensitivity("meshes[0].damping_ratio", found, at="g1/g2").values[0, 0]
    assert values == pytest.approx(found.mesh_force("g1/g2")[0], rel=1e-9)


def test_a_place_between_nodes_moves_as_a_node_there_would():
    beam = Beam(springs=ENDS["pinned"], rayleigh=(2.0, 1e-6))
    coarse = beam_system(beam, elements=4, degree=8)
    fine = coarse.replace(
        bearings=[*coarse.bearings, gb.Bearing("s", 0.41, stiffness=0.0)],
        shafts=[replace(coarse.shafts[0], elements=4, degree=8)],
    )
    at = ("s", 0.41)
    first, second = (system.modes(count=6).displacement(at) for system in (coarse, fine))
    # shapes of equal modes of both planes are arbitrary: the sums over each pair are not
    sizes = [
        np.sum(np.abs(shapes.reshape(3, 2, 2)) ** 2, axis=(1, 2)) for shapes in (first, second)
    ]
    assert sizes[0] == pytest.approx(sizes[1], rel=1e-6)
    unbalanced = [system.synchronous([100.0]) for system in (coarse, fine)]
    assert unbalanced[0].displacement(at).shape == (1, 1, 2)
    with pytest.raises(gb.SceneError, match=r"reaches from 0 to 1\.2 m"):
        unbalanced[0].displacement(("s", 1.3))


def test_mesh_forces_of_all_shafts_accelerate_the_last_shaft():
    system, speeds = hostile(), np.array([50.0, 120.0, -80.0])
    response = system.synchronous(speeds)
    found = response.mesh_force("g4/g5")
    assert found.shape == (3, 4)
    # Newton's second law of the rotation of "output", which the teeth of g5 alone turn: with the
    # base radius of ISO 21771, the force has the arm r_b cos β_b.
    transverse = np.arctan(np.tan(np.radians(20.0)) / np.cos(0.2))
    radius = 0.5 * 53 * 3e-3 / np.cos(0.2) * np.cos(transverse)
    arm = radius * np.sqrt(1.0 - (np.sin(0.2) * np.cos(np.radians(20.0))) ** 2)
    twists = [i for i, dof in enumerate(system.dofs) if dof[0] == "output" and dof[2] == "twist"]
    rates = speeds[:, np.newaxis] * system.speed_ratios
    inertia = system.matrices(50.0).mass[twists].sum(axis=0)
    torques = -(rates**2) * (response.amplitudes @ inertia)
    # The drive flanks turn the wheel in its sense of rotation.
    sense = np.sign(rates[:, 3:])
    # Differences of the twists between the nodes leave round-off of 1e-10.
    np.testing.assert_allclose(torques, sense * arm * found, rtol=1e-8)
    # Slow roll has no part in forces.
    np.testing.assert_array_equal(response.subtract_slow_roll(5.0).mesh_force("g5/g4"), found)
    only = system.synchronous(speeds, excitation="unbalance").mesh_force("g4/g5")
    source = gb.ShaftExcitation("middle", "unbalance")
    order = abs(system.speed_ratios[2])
    alone = system.frequency_response(source=source, order=order, speeds=speeds)
    np.testing.assert_allclose(np.abs(only[:, 2]), np.abs(alone.mesh_force("g4/g5")[:, 0]))
    with pytest.raises(gb.ChannelError, match="g1"):
        response.mesh_force("g1/g5")
