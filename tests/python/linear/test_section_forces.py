"""Section forces: closed forms of beams and bows, cuts through the hostile machine, and signs."""

from __future__ import annotations

from itertools import pairwise
from math import pi
from typing import Any

import numpy as np
import pytest
from scipy.integrate import cumulative_simpson

import gearbow as gb
from gearbow._types import Array
from reference import machines
from reference.elements import Section
from reference.train import ShaftPart, ShaftSpec, Train

E, RHO = 211e9, 7810.0
G = 9.80665
NAMES = ("axial force", "shear", "bending", "torque")
#: Points and weights of a Gauss rule over the unit interval, exact for every shape of an element.
POINTS, WEIGHTS = (
    (1.0 + x) / 2.0 if i == 0 else x / 2.0 for i, x in enumerate(np.polynomial.legendre.leggauss(6))
)


def _disk(name: str, x: float, diameter: float) -> gb.Disk:
    """A disk of steel, 70 mm long, on a shaft of 50 mm."""
    mass = RHO * pi / 4.0 * (diameter**2 - 0.05**2) * 0.07
    polar = mass * (diameter**2 + 0.05**2) / 8.0
    return gb.Disk(
        name,
        "rotor",
        x,
        **machines.inertia(mass, polar / 2.0 + mass * 0.07**2 / 12.0, polar),
    )


def _two_disks(**more: Any) -> gb.RotorSystem:
    """The rotor of Friswell et al. (2010), example 5.9.1: 1.5 m x 50 mm, disks at thirds."""
    shaft = gb.Shaft(
        "rotor",
        length=1.5,
        outer_diameter=0.05,
        material=gb.Material(E, RHO, poisson_ratio=0.3),
        elements=3,
    )
    bearings = [gb.Bearing("rotor", x, stiffness=1e6) for x in (0.0, 1.5)]
    disks = [_disk("a", 0.5, 0.28), _disk("b", 1.0, 0.35)]
    return gb.RotorSystem([shaft], disks=disks, bearings=bearings, **more)


def test_weight_of_a_rotor_with_two_disks() -> None:
    # gravity along +z, so that the part beyond pulls the part before downwards
    static = _two_disks(gravity=(0.0, G)).static()
    # reference values by equilibrium on paper: reactions, moments and shear, seven digits
    assert static.bearing_force(("rotor", 0.0))[1] == pytest.approx(494.2821, rel=1e-6)
    assert static.bearing_force(("rotor", 1.5))[1] == pytest.approx(556.1801, rel=1e-6)
    assert static.section_forces("a").bending == pytest.approx([228.3430, 0.0], rel=1e-6)
    assert static.section_forces("b").bending == pytest.approx([259.2921, 0.0], rel=1e-6)
    before, beyond = (static.section_forces("b", side).shear[1] for side in ("before", "beyond"))
    assert (before, beyond) == pytest.approx((24.302, -480.988), abs=5e-4)


def test_weight_between_the_nodes() -> None:
    # the parabola of a distributed weight is exact with elements of any length
    static = _two_disks(gravity=(G, 0.0)).static()
    weight = RHO * pi / 4.0 * 0.05**2 * G
    reaction = static.bearing_force(("rotor", 0.0))[0]
    for x in (0.1, 0.33, 0.49):
        found = static.section_forces(("rotor", x))
        assert found.shear[0] == pytest.approx(reaction - weight * x, rel=1e-9)
        # about z, with forces along +y: the part before has the moment of weight and reaction
        moment = -(reaction * x - weight * x**2 / 2.0)
        assert found.bending[1] == pytest.approx(moment, rel=1e-9)


def test_stress_of_a_rotor_with_two_disks() -> None:
    found = _two_disks(gravity=G).stresses(100.0)
    index = [section[1:] for section in found.sections].index((1.0, "before"))
    # M/W = 259.2921 N m/(π d³/32); the weight alternates once a turn
    assert found.bending[index, 1] == pytest.approx(21.1290e6, rel=1e-5)
    assert found.bending[index, 0] == pytest.approx(0.0, abs=1.0)


@pytest.mark.parametrize("ratio", [-0.6, 0.6, 1.7])
def test_a_half_sine_bow_bends_the_shaft_by_its_inertia(ratio: float) -> None:
    """M = EI (π/L)² b r²/(1 − r²) in the middle, constant in the frame of the shaft."""
    amplitude, phase, length = 2e-4, 0.7, 1.0
    shaft = gb.Shaft(
        "rotor",
        length=length,
        outer_diameter=0.02,
        elements=8,
        degree=3,
        shear=False,
        bow=gb.Bow.half_sine(amplitude, phase),
    )
    bearings = [gb.Bearing("rotor", x, stiffness=1e12) for x in (0.0, length)]
    system = gb.RotorSystem([shaft], bearings=bearings, motion="lateral")
    material = shaft.material
    stiffness = material.youngs_modulus * pi * 0.02**4 / 64.0
    mass = material.density * pi * 0.02**2 / 4.0
    first = (pi / length) ** 2 * np.sqrt(stiffness / mass)
    speed = ratio * first
    forces = system.synchronous([speed]).section_forces(("rotor", length / 2.0))
    about_y, about_z = forces.bending[0, 0]
    # with the shaft: M_y + iM_z = i M_phi, where M_phi is the moment of the plane of the bow
    forward = (about_y + 1j * about_z) / 2.0
    backward = np.conj(about_y - 1j * about_z) / 2.0
    r = abs(ratio)
    exact = stiffness * (pi / length) ** 2 * amplitude * r**2 / (1.0 - r**2)
    # The bow lets the beam carry its inertia: M = EI u'' - EI b'' with u = b/(1 - r²). Rotary
    # inertia changes the critical speed by (π d/4L)² = 2.5e-4, times r²/|1 − r²| at most 2.
    assert abs(forward) == pytest.approx(abs(exact), rel=1.5e-3)
    expected = -1j * exact * np.exp(1j * phase)
    assert np.angle(forward / expected) == pytest.approx(0.0, abs=1e-3)
    assert abs(backward) < 1e-6 * abs(exact)


def test_a_free_bent_shaft_has_no_forces() -> None:
    bow = gb.Bow.points([0.0, 0.2, 0.7, 1.0], [0.0, 1e-4, 2e-4, 0.0], [0.0, 0.3, 1.8, 0.0])
    shaft = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, bow=bow)
    bearings = [gb.Bearing("rotor", x, stiffness=1e7) for x in (0.0, 1.0)]
    system = gb.RotorSystem([shaft], bearings=bearings)
    slow = system.synchronous([1e-3]).section_forces("rotor").values
    fast = system.synchronous([100.0]).section_forces("rotor").values
    assert np.abs(slow).max() < 1e-6 * np.abs(fast).max()


@pytest.mark.parametrize("helix_angle", [0.0, 0.3])
def test_a_pair_of_gears_under_torque(helix_angle: float) -> None:
    torque, position, length = 250.0, 0.2, 0.5
    system = machines.pair(
        position=position,
        gear={"helix_angle": helix_angle},
        own={"g2": {"helix_angle": -helix_angle}},
        bearing={**machines.BEARING, "axial_stiffness": 1e8},
        torques=[gb.Torque(("input", 0.0), torque), gb.Torque(("output", 0.5), "balance")],
    )
    static = system.static(1.0, geometry="frozen")
    before, beyond = (static.section_forces("g1", side).values for side in ("before", "beyond"))
    # the torque enters at the begin; the part before g1 is in equilibrium with the part beyond
    assert before[5] == pytest.approx(-torque, rel=1e-9)
    assert beyond[5] == pytest.approx(0.0, abs=1e-9 * torque)
    load = -(beyond[1:3] - before[1:3])
    reach = position * (length - position) / length
    radius = torque / np.hypot(*load) if helix_angle == 0.0 else None
    if radius is not None:
        # M = F a b/L in both planes, up to the compliance of the bearings, which is symmetric
        assert np.hypot(*before[3:5]) == pytest.approx(np.hypot(*load) * reach, rel=1e-6)
        assert before[3:5] == pytest.approx(beyond[3:5], rel=1e-9)
    else:
        # an axial force at the pitch radius lets the moment jump
        thrust = abs(static.mesh(("g1", "g2")).thrust)
        pitch = 25 * 3e-3 / np.cos(helix_angle) / 2.0
        jump = np.hypot(*(beyond[3:5] - before[3:5]))
        assert abs(beyond[0] - before[0]) == pytest.approx(thrust, rel=1e-9)
        assert jump == pytest.approx(thrust * pitch, rel=1e-9)


@pytest.mark.parametrize("speed", [120.0, -120.0])
@pytest.mark.parametrize("method", ["exponential", "rk45"])
def test_forces_jump_by_what_acts_at_a_node(method: Any, speed: float) -> None:
    system = machines.hostile()
    record: Any = ["nodes", "bearings", "section_forces"]
    run = system.simulate(5e-3, speed, method=method, rtol=1e-7, record=record)
    forced = {(shaft, x) for shaft, x, names in run._to_record().data["points"] if names}
    forced |= {("input", 0.36), ("input", 0.07), ("output", 0.17)}
    bearings = run._to_record().data["bearings"]
    checked = 0
    for shaft in system.shafts:
        along = run.section_forces(shaft.name)
        size = np.abs(along.values).max(axis=(0, 1))
        for i in np.flatnonzero(np.diff(along.positions) == 0.0):
            at = (shaft.name, float(along.positions[i]))
            if at in forced:
                continue
            jump = along.values[:, i + 1] - along.values[:, i]
            if at in bearings:
                jump[:, 1:3] -= run.bearing_force(at)
            # A round-off of 1e-16 of the stiffest spring of an element, 1e10 N/m, at 1e-4 m. The
            # idler carries hardly any axial force, relative to which round-off is larger.
            limit = 1e-9 * size + 1e-8
            assert (np.abs(jump).max(axis=0) <= limit).all(), (at, jump)
            checked += 1
        last = along.values[:, -1]
        end = (shaft.name, float(along.positions[-1]))
        if end in bearings and end not in forced:
            assert last[:, 1:3] == pytest.approx(-run.bearing_force(end), rel=1e-8, abs=1e-6)
    assert checked >= 7


class Pieces:
    """Axial and lateral forces on the pieces of the shafts of the hostile machine in a run, shape (20, 3) [N]."""

    def __init__(self, system: gb.RotorSystem, speed: float) -> None:
        random = np.random.default_rng(8)
        self.system, self.speed = system, speed
        options: Any = {"rtol": 1e-7, "times": np.sort(random.uniform(1e-3, 9e-3, 20))}
        nodes = system.simulate(1e-2, speed, record=["nodes"], **options)
        self.ends: dict[str, list[float]] = {}
        places = []
        for shaft in system.shafts:
            own = {x for name, x, _ in nodes._to_record().data["points"] if name == shaft.name}
            # a cut anywhere, beside those at the nodes
            ends = sorted({*own, random.uniform(0.0, shaft.length)})
            self.ends[shaft.name] = ends
            places += [(shaft.name, x) for x in ends]
            places += [(shaft.name, a + (b - a) * x) for a, b in pairwise(ends) for x in POINTS]
        record: Any = [*places, "acceleration", "bearings", "section_forces"]
        self.run = system.simulate(1e-2, speed, record=record, **options)

    def acceleration(self, shaft: str, x: float) -> Array:
        lateral = self.run.acceleration((shaft, x))
        return np.column_stack([self.run.axial_acceleration((shaft, x)), lateral])

    def inertia(self, shaft: gb.Shaft, a: float, b: float) -> Array:
        """Change of the momentum of a piece per unit time."""
        area = pi / 4.0 * (shaft.outer_diameter**2 - shaft.inner_diameter**2)
        mean = sum(
            weight * self.acceleration(shaft.name, a + (b - a) * x)
            for x, weight in zip(POINTS, WEIGHTS, strict=True)
        )
        return shaft.material.density * area * (b - a) * mean

    def section(self, shaft: str, x: float, side: Any) -> Array:
        """Forces of the part beyond a section on the part before it; none beyond the ends."""
        if x == self.ends[shaft][0 if side == "before" else -1]:
            return np.zeros((20, 3))
        return self.run.section_forces((shaft, x), side).values[:, :3]

    def bearings(self, shaft: str, x: float) -> Array:
        """Forces of the bearings at a node."""
        total = np.zeros((20, 3))
        for bearing in self.system.bearings:
            own = (bearing.shaft, bearing.position)
            lateral = self.run.bearing_force(own)
            along = self.run.axial_bearing_force(own) if bearing.axial_stiffness else np.zeros(20)
            for place, sign in ((own, -1.0), (bearing.support, 1.0)):
                if place is not None and place[0] == shaft and abs(place[1] - x) < 1e-9:
                    total += sign * np.column_stack([along, lateral])
        return total

    def gear(self, gear: gb.Gear, x: float) -> Array:
        """Change of the momentum of a gear per unit time, with its unbalance."""
        ratios = zip((s.name for s in self.system.shafts), self.system.speed_ratios, strict=True)
        spin = dict(ratios)[gear.shaft] * self.speed
        diameter = gear.module * gear.teeth / np.cos(gear.helix_angle)
        mass = 7850.0 * pi / 4.0 * diameter**2 * gear.face_width
        turned = gear.unbalance * spin**2 * np.exp(1j * spin * self.run.time)
        rotating = np.column_stack([np.zeros(20), turned.real, turned.imag])
        return mass * self.acceleration(gear.shaft, x) - rotating


@pytest.mark.parametrize("speed", [120.0, -120.0])
def test_forces_of_both_sides_of_a_cut_balance(speed: float) -> None:
    """Newton's law of every piece of the hostile machine at random instants of a run.

    What remains at the gears of a mesh is opposite on both shafts.
    """
    system = machines.hostile()
    pieces = Pieces(system, speed)
    teeth: dict[str, Array] = {}
    for shaft in system.shafts:
        ends = pieces.ends[shaft.name]
        size = max(np.abs(pieces.section(shaft.name, x, "before")).max() for x in ends)
        for a, b in pairwise(ends):
            before, beyond = (
                pieces.section(shaft.name, x, side) for x, side in ((b, "before"), (a, "beyond"))
            )
            change = pieces.inertia(shaft, a, b)
            assert np.abs(before - beyond - change).max() < 1e-9 * size
        for x in ends:
            jump = pieces.section(shaft.name, x, "beyond") - pieces.section(shaft.name, x, "before")
            left = jump + pieces.bearings(shaft.name, x)
            for gear in system.gears:
                if gear.shaft == shaft.name and abs(gear.position - x) < 1e-9:
                    left = teeth[gear.name] = pieces.gear(gear, x) - left
                    break
            else:
                assert np.abs(left).max() < 1e-9 * size, (shaft.name, x)
    largest = max(np.abs(force).max() for force in teeth.values())
    # the idler meshes with two gears
    for meshed in (("g1", "g2", "g3"), ("g4", "g5")):
        total = sum(teeth[name] for name in meshed)
        assert np.abs(total).max() < 1e-9 * largest, meshed


@pytest.mark.parametrize("speed", [120.0, -120.0])
def test_harmonic_forces_and_moments_balance_on_both_sides_of_a_cut(speed: float) -> None:
    """Newton's laws of every element of the hostile machine, by element matrices of another program.

    The ends of an element carry its inertia, damping, gyroscopic and elastic forces. Moments of both
    sides of a node are equal where no gear stands.
    """
    system, frequency = machines.hostile(), 900.0
    sources = [gb.Force("g4", (100.0 + 50j, -30j)), gb.Torque("g5", 40.0)]
    response = system.frequency_response([frequency], source=sources, speed=speed)
    geared = {(gear.shaft, gear.position) for gear in system.gears}
    loaded = {*geared, *((b.shaft, b.position) for b in system.bearings)}
    loaded |= {b.support for b in system.bearings if isinstance(b.support, tuple)}
    loaded |= {torque.at for torque in system.torques if isinstance(torque.at, tuple)}
    alpha, beta = system.rayleigh or (0.0, 0.0)
    checked = 0
    for shaft, ratio in zip(system.shafts, system.speed_ratios, strict=True):
        material = shaft.material
        section = Section(
            shaft.outer_diameter,
            material.youngs_modulus,
            material.shear_modulus
            or material.youngs_modulus / 2.0 / (1.0 + material.poisson_ratio),
            material.density,
            shaft.inner_diameter,
        )
        nodes = sorted({x for name, x, _ in system.dofs if name == shaft.name})

        def motion(x: float, name: str = shaft.name) -> Any:
            at = [system.dofs.index((name, x, c)) for c in ("v", "w", "B", "G", "twist")]
            return response._motion[0][:, at]

        def section_force(x: float, side: Any, name: str = shaft.name) -> Any:
            # the order of the coordinates: forces along y and z, moments about y, z and x
            return response.section_forces((name, x), side).values[0][:, 1:]

        ends = [(section_force(x, "before"), section_force(x, "beyond")) for x in nodes]
        size = np.max([np.abs(each) for each in ends], axis=(0, 1, 2))
        for (a, b), (start, end) in zip(pairwise(nodes), pairwise(ends), strict=True):
            free = Train([ShaftSpec(shaft.name, [ShaftPart(b - a, section)], float(ratio))])
            stiffness, _ = free.linear()
            damping = alpha * free.mass + beta * stiffness + speed * free.gyroscopic
            dynamic = stiffness + 1j * frequency * damping - frequency**2 * free.mass
            force = np.hstack([motion(a), motion(b)]) @ dynamic.T
            found = np.hstack([-start[1], end[0]])
            assert (np.abs(force - found) <= 1e-9 * np.tile(size, 2)).all(), (shaft.name, a)
            checked += 1
        for x, (before, beyond) in zip(nodes[1:-1], ends[1:-1], strict=True):
            jump = np.abs(beyond - before)
            if (shaft.name, x) not in geared:
                assert (jump[:, 2:4] <= 1e-9 * size[2:4]).all(), (shaft.name, x)
            if (shaft.name, x) not in loaded:
                assert (jump <= 1e-9 * size).all(), (shaft.name, x)
    assert checked >= 11


def test_power_through_a_cut_changes_the_energy_beyond_it() -> None:
    """Work of the section forces on an overhung disk is the change of its kinetic energy."""
    disk = gb.Disk("disk", "rotor", 0.6, **machines.inertia(4.0, 0.0, 0.02))
    shaft = gb.Shaft("rotor", length=0.6, outer_diameter=0.03, elements=2)
    bearings = [gb.Bearing("rotor", x, stiffness=1e7, damping=2e3) for x in (0.0, 0.4)]
    system = gb.RotorSystem(
        [shaft],
        disks=[disk],
        bearings=bearings,
        drives=[gb.Drive(("rotor", 0.0), stiffness=1e3, damping=1.0)],
        forces=[gb.Force(("rotor", 0.4), 300.0 + 100j)],
        torques=[gb.Torque(("rotor", 0.4), 20.0)],
    )
    record: Any = ["disk", "velocity", "section_forces"]
    run = system.simulate(0.02, 90.0, initial="rest", rtol=1e-9, output_step=2e-6, record=record)
    forces, velocity, rate = (
        run.section_forces("disk"),
        run.velocity("disk"),
        run.twist_rate("disk"),
    )
    # without diametral inertia, the bending moment is the gyroscopic one, which does no work
    power = -np.sum(forces.shear * velocity, axis=1) - forces.torque * rate
    energy = 0.5 * 4.0 * np.sum(velocity**2, axis=1) + 0.5 * 0.02 * rate**2
    work = cumulative_simpson(power, x=run.time, initial=0.0)
    change = energy - energy[0]
    assert np.abs(work - change).max() < 1e-5 * np.abs(change).max()


def test_methods_agree_and_record_the_same_forces() -> None:
    system = machines.hostile()
    options: Any = {"rtol": 1e-9, "record": [("middle", 0.3), "g4", "section_forces"]}
    exponential, rk45 = (
        system.simulate(4e-3, 120.0, method=method, **options) for method in ("exponential", "rk45")
    )
    for at in (("middle", 0.3), "g4"):
        one, other = (run.section_forces(at).values for run in (exponential, rk45))
        # both methods have a relative error of 1e-9 of the motion; stiff shafts amplify it
        assert np.abs(one - other).max() < 1e-5 * np.abs(other).max()


def test_forces_do_not_depend_on_the_number_of_outputs_in_a_step() -> None:
    """Forces of several outputs are evaluated together, also across contact changes and pieces of a speed."""
    system = machines.separating_pair(3.5e-4, 1e-4)
    table = gb.SpeedProfile.table([0.0, 1.5e-2, 5e-2], [100.0, 130.0, 90.0])
    for speed in (100.0, table):
        fine, *others = (
            system.simulate(
                5e-2, speed, record=["gears", "section_forces"], output_step=every * 2e-5
            )
            for every in (1, 5, 20)
        )
        assert len(fine.events) > 50
        expected = fine.section_forces("pinion").values
        for every, run in zip((5, 20), others, strict=True):
            error = np.abs(run.section_forces("pinion").values - expected[::every])
            assert error.max() < 1e-12 * np.abs(expected).max()


def test_a_run_up_records_the_forces_of_its_coordinates() -> None:
    system = machines.hostile(
        shafts=[
            *(
                gb.Shaft(
                    s.name,
                    length=s.length,
                    outer_diameter=s.outer_diameter,
                    elements=s.elements,
                    internal_damping=2e-6,
                    bow=s.bow,
                )
                for s in machines.hostile().shafts
            ),
        ]
    )
    speed = gb.SpeedProfile.ramp(80.0, 160.0, duration=8e-3)
    options: Any = {"rtol": 1e-8, "record": ["g4", ("output", 0.2), "section_forces"]}
    # The ramp ends later: there the angular acceleration has two values, of which a method may record either.
    runs = [system.simulate(7.9e-3, speed, method=m, **options) for m in ("exponential", "rk45")]
    for at in ("g4", ("output", 0.2)):
        one, other = (run.section_forces(at).values for run in runs)
        assert np.abs(one - other).max() < 1e-4 * np.abs(other).max()


def test_synchronous_forces_are_those_of_a_run() -> None:
    """A rotor without gears moves synchronously: phasors and series are the same motion."""
    bow = gb.Bow.half_sine(1e-4, 0.4)
    shaft = {"bow": bow, "elements": 5, "internal_damping": 1e-5}
    disk = {**machines.inertia(12.0, 0.05, 0.09), "unbalance": 3e-4 * np.exp(0.3j), "position": 0.3}
    system = machines.rotor(shaft, disk, {"stiffness": (3e6, 9e6), "damping": 800.0})
    speed = 130.0
    response = system.synchronous([speed])
    run = system.simulate(0.05, speed, record=["nodes", "section_forces"], rtol=1e-8)
    phasors = response.section_forces("rotor").values[0, 0]
    turned = np.exp(1j * speed * run.time)
    expected = np.real(phasors * turned[:, np.newaxis, np.newaxis])
    found = run.section_forces("rotor").values
    # The initial state is the synchronous motion, which the exponential method keeps exactly.
    assert np.abs(found - expected).max() < 1e-7 * np.abs(expected).max()


def test_torque_between_inertias_is_stiffness_times_twist() -> None:
    """A torsional chain without mass of its shaft: alternating torque, also with damping."""
    disks = [
        gb.Disk(name, "line", x, **machines.inertia(1.0, 0.1, j))
        for name, x, j in (("motor", 0.0, 0.4), ("load", 1.0, 1.1))
    ]
    beta = 3e-5
    shaft = gb.Shaft(
        "line",
        length=1.0,
        outer_diameter=0.03,
        material=machines.LIGHT,
        elements=1,
        internal_damping=beta,
    )
    system = gb.RotorSystem([shaft], disks=disks, motion="torsion")
    stiffness = machines.LIGHT.youngs_modulus / 2.6 * pi * 0.03**4 / 32.0
    frequencies = np.array([5.0, 200.0, 900.0])
    found = system.frequency_response(frequencies, source=gb.Torque("load", 1.0))
    twist = found.twist("load") - found.twist("motor")
    expected = stiffness * (1.0 + 1j * beta * frequencies[:, np.newaxis]) * twist
    torque = found.section_forces(("line", 0.4)).torque
    # the shaft has 8e-5 of the inertia of the motor
    assert torque == pytest.approx(expected, rel=2e-4)
    # far below resonance at 147 rad/s, the shaft transmits what accelerates the motor
    assert np.abs(torque[0, 0]) == pytest.approx(0.4 / 1.5, rel=2e-3)


def test_loss_factor_and_axial_force_are_in_equilibrium() -> None:
    """Forces beyond one end of an element equal those before the next, with every kind of force."""
    shaft = gb.Shaft(
        "rotor",
        segments=[
            gb.Segment(0.4, 0.06, end_outer_diameter=0.04),
            gb.Segment(0.5, 0.04, inner_diameter=0.01),
        ],
        axial_force=2e4,
        loss_factor=0.02,
        internal_damping=0.0,
    )
    bearings = [gb.Bearing("rotor", x, stiffness=(2e7, 5e7), damping=300.0) for x in (0.0, 0.9)]
    disks = [gb.Disk("disk", "rotor", 0.55, **machines.inertia(9.0, 0.03, 0.05))]
    system = gb.RotorSystem([shaft], disks=disks, bearings=bearings, rayleigh=(3.0, 1e-6))
    source = gb.Force("disk", 1.0)
    response = system.frequency_response([400.0, 900.0], speed=150.0, source=source)
    along = response.section_forces("rotor")
    size = np.abs(along.values).max()
    jumps = 0
    for i in np.flatnonzero(np.diff(along.positions) == 0.0):
        if along.positions[i] in (0.55,):
            continue
        jump = along.values[..., i + 1, :] - along.values[..., i, :]
        assert np.abs(jump).max() < 1e-9 * size
        jumps += 1
    assert jumps >= 1
    # a section between nodes continues both ends of its element
    ends = [float(x) for x in np.unique(along.positions)[:2]]
    near = response.section_forces(("rotor", ends[0] + 1e-7)).values
    assert near == pytest.approx(along.values[..., 0, :], rel=1e-4, abs=1e-6 * size)
    near = response.section_forces(("rotor", ends[1] - 1e-7)).values
    assert near == pytest.approx(along.values[..., 1, :], rel=1e-4, abs=1e-6 * size)


def test_static_tension_is_part_of_the_axial_force() -> None:
    shaft = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, axial_force=5e3)
    bearings = [gb.Bearing("rotor", x, stiffness=1e7) for x in (0.0, 1.0)]
    static = gb.RotorSystem([shaft], bearings=bearings, gravity=G).static()
    assert static.section_forces(("rotor", 0.5)).axial_force == 5e3


def test_the_result_is_an_array_with_names() -> None:
    static = _two_disks(gravity=G).static()
    forces = static.section_forces("a")
    assert np.asarray(forces).shape == forces.shape == (6,)
    assert forces[4] == forces.bending[1]
    along = static.section_forces("rotor")
    assert along.shape == (6, 6)
    assert along.sides == ("beyond", "before", "beyond", "before", "beyond", "before")
    table = along.to_dataframe()
    assert list(table.columns)[2:] == [
        *("axial force [N]", "shear y [N]", "shear z [N]"),
        *("moment y [N m]", "moment z [N m]", "torque [N m]"),
    ]
    assert "moment y" in along.table()
    assert len(along.plot().axes) == 4
    assert len(static.plot("section forces").axes) == 4
    with pytest.raises(gb.GearbowError, match="one section has no course"):
        forces.plot()


def test_errors_name_the_place() -> None:
    static = _two_disks().static()
    with pytest.raises(gb.GearbowError, match="side: must be one of before, beyond, got 'left'"):
        static.section_forces("a", "left")  # type: ignore[arg-type]
    with pytest.raises(gb.GearbowError, match=r"reaches from 0 to 1\.5 m"):
        static.section_forces(("rotor", 2.0))
    with pytest.raises(gb.GearbowError, match="no gear, disk, support or housing is called"):
        static.section_forces("c")
    run = _two_disks().simulate(1e-3, 10.0, record=["a"])
    with pytest.raises(gb.ChannelError, match=r'record=\["section_forces"|section_forces'):
        run.section_forces("a")
    with pytest.raises(gb.SceneError, match=r"section_forces.*recorded places"):
        _two_disks().simulate(1e-3, 10.0, record=["section_forces"])
    response = _two_disks().synchronous([10.0]).subtract_slow_roll(1.0)
    with pytest.raises(gb.GearbowError, match="slow roll was subtracted"):
        response.section_forces("a")


def test_files_keep_section_forces(tmp_path: Any) -> None:
    system = machines.hostile()
    run = system.simulate(1e-3, 120.0, record=["g4", ("input", 0.1), "section_forces"])
    run.save(tmp_path / "run.npz")
    loaded = gb.Response.load(tmp_path / "run.npz")
    for at in ("g4", ("input", 0.1)):
        one, other = (each.section_forces(at) for each in (run, loaded))
        assert np.array_equal(one.values, other.values)
        assert one.sides == other.sides
    assert loaded.recorded == run.recorded
    assert "g4" not in run.to_dataframe().columns


def test_orders_of_torque_are_those_of_shafts_and_teeth() -> None:
    system = machines.hostile()
    run = system.simulate(1.0, 120.0, record=["g4", "section_forces"], output_step=4e-4)
    spectrum = run.resample(400.0).spectrum("g4", "torque")
    assert spectrum.unit == "N m"
    # higher harmonics of the teeth are left to the rest
    with pytest.warns(gb.AccuracyWarning, match="RMS of g4 torque"):
        found = run.orders("g4", "torque", skip_time=0.2, mesh_harmonics=1, shaft_harmonics=1)
    assert "1× mesh g4–g5" in str(found)
    assert "1× middle" in str(found)
