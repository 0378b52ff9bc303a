"""Helical gears: axial motion, thrust and tilting, against closed forms and an independent statement."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import gearbow as gb
from gearbow.cli.main import main
from reference.cases import each_case
from reference.helical import HelicalTrain
from reference.machines import helical_pair, uneven_train
from test_structured_solver import (
    assert_lowest_modes,
    assert_same_response,
    through_dense_matrices,
)

HELIX = np.radians(20.0)
BEARING = {"stiffness": 1e8, "damping": 500.0, "axial_stiffness": 3e7, "axial_damping": 400.0}
TEETH = {"module": 3e-3, "face_width": 0.03}


# --- Exact frequencies of two rigid gears on springs


def rigid_pair() -> gb.RotorSystem:
    """Return two rigid gears whose shafts have almost no mass and no stiffness."""
    nothing = gb.Material(youngs_modulus=1e5, density=1e-6, poisson_ratio=0.3)
    bodies = {"a": (25, 1.5, 1e-3, 1.8e-3), "b": (50, 6.0, 1.6e-2, 3e-2)}
    gears = [
        gb.Gear(
            name,
            f"shaft {name}",
            0.01,
            teeth,
            module=3e-3,
            helix_angle=sign * HELIX,
            mass=mass,
            diametral_inertia=diametral,
            polar_inertia=polar,
        )
        for sign, (name, (teeth, mass, diametral, polar)) in zip(
            (1, -1), bodies.items(), strict=True
        )
    ]
    return gb.RotorSystem(
        shafts=[
            gb.Shaft(
                f"shaft {name}",
                length=0.02,
                outer_diameter=0.05,
                material=nothing,
                elements=1,
                degree=1,
            )
            for name in bodies
        ],
        gears=gears,
        meshes=[gb.Mesh("a", "b", stiffness=3e8)],
        bearings=[
            gb.Bearing(
                f"shaft {name}", 0.01, stiffness=2e8, axial_stiffness=5e7, tilting_stiffness=2e5
            )
            for name in bodies
        ],
    )


def rank_one_frequencies() -> np.ndarray:
    """Give the roots of 1 + k Σ n²/(k_i − m_i ω²) = 0 and the frequencies of free coordinates."""
    radii = np.array([25, 50]) * 3e-3 / np.cos(HELIX) / 2
    angle = np.radians(20.0)
    normal = np.array([np.cos(angle) * np.sin(HELIX), np.sin(angle), np.cos(angle) * np.cos(HELIX)])
    terms = []
    for side, radius, mass, diametral, polar in (
        (1.0, radii[0], 1.5, 1e-3, 1.8e-3),
        (-1.0, radii[1], 6.0, 1.6e-2, 3e-2),
    ):
        arm = np.array([0.0, side * radius, 0.0])
        moment = np.cross(arm, normal)
        stiffness = (5e7, 2e8, 2e8, 0.0, 2e5, 2e5)
        inertia = (mass, mass, mass, polar, diametral, diametral)
        terms += zip(np.concatenate([normal, moment]) ** 2, stiffness, inertia, strict=True)
    moved = [(g, k, m) for g, k, m in terms if g > 1e-20]
    free = [np.sqrt(k / m) for g, k, m in terms if g <= 1e-20]

    def secular(square: float) -> float:
        return 1.0 + 3e8 * sum(g / (k - m * square) for g, k, m in moved)

    poles = sorted({k / m for _, k, m in moved})
    found = []
    for low, high in zip(poles, [*poles[1:], 1e11], strict=True):
        inside = (low + 1e-9 * high, high * (1.0 - 1e-12))
        found.append(np.sqrt(brentq(secular, *inside, xtol=1e-6, rtol=1e-14)))
    # coordinates with equal frequencies keep all but one of them
    repeated = [np.sqrt(pole) for pole in poles for _, k, m in moved if k / m == pole]
    for pole in poles:
        repeated.remove(np.sqrt(pole))
    return np.sort(np.concatenate([found, free, repeated])) / (2 * np.pi)


@pytest.mark.implausible
def test_rigid_gears_on_springs_have_the_frequencies_of_a_rank_one_update():
    published = [
        *(0.0, 453.350, 546.574, 562.698, 803.762, 918.881, 918.881),
        *(1429.359, 1837.763, 2182.997, 2250.791, 4031.408),
    ]
    exact = rank_one_frequencies()
    assert exact == pytest.approx(published, abs=6e-4)  # half of the last printed digit
    # round-off of the shafts, whose frequencies are a thousand times as high
    found = rigid_pair().modes(count=12).frequencies_hz
    assert found == pytest.approx(exact, rel=1e-8)


@pytest.mark.implausible
def test_the_stiffness_matrix_is_that_of_the_unit_normal_at_the_pitch_point():
    system, angle = rigid_pair(), np.radians(20.0)
    normal = np.array([np.cos(angle) * np.sin(HELIX), np.sin(angle), np.cos(angle) * np.cos(HELIX)])
    radii = np.array([25, 50]) * 3e-3 / np.cos(HELIX) / 2
    gradient = np.zeros(len(system.dofs))
    for shaft, arm, sign in (("shaft a", radii[0], 1.0), ("shaft b", -radii[1], -1.0)):
        # a right-hand driver that turns counter-clockwise is pushed towards +x by its teeth, against δ
        n = sign * normal * [-1.0, 1.0, 1.0]
        roll, tilt_y, tilt_z = np.cross([0.0, arm, 0.0], n)
        values = {"u": n[0], "v": n[1], "w": n[2], "B": tilt_y, "G": tilt_z, "twist": roll}
        for direction, value in values.items():
            gradient[system.dofs.index((shaft, 0.01, direction))] = value
    assert np.linalg.norm(normal) == pytest.approx(1.0, rel=1e-15)
    rigid = system.replace(meshes=[gb.Mesh("a", "b", stiffness=6e8)])
    mesh = rigid.matrices().stiffness - system.matrices().stiffness
    assert np.abs(mesh - 3e8 * np.outer(gradient, gradient)).max() < 1e-6


# --- Axial rods


def rod(
    *, elements: int = 1, degree: int = 8, end_mass: float = 0.0, inner: float = 0.0
) -> gb.RotorSystem:
    disks = [gb.Disk("end", "rod", 1.0, end_mass, 1e-3, 2e-3)] if end_mass else []
    return gb.RotorSystem(
        shafts=[
            gb.Shaft(
                "rod",
                length=1.0,
                outer_diameter=0.05,
                inner_diameter=inner,
                elements=elements,
                degree=degree,
            )
        ],
        disks=disks,
        bearings=[gb.Bearing("rod", x, stiffness=1e7, tilting_stiffness=1e3) for x in (0.0, 1.0)],
        forces=[gb.Force(("rod", 0.0), axial=1e-3)],
    )


def axial_frequencies(system: gb.RotorSystem, count: int) -> np.ndarray:
    modes = system.modes()
    axial = [w == "axial" for w in modes.whirl]
    return modes.frequencies_hz[axial][:count]


@pytest.mark.parametrize("inner", [0.0, 0.03])
def test_a_free_rod_has_the_frequencies_of_its_axial_waves(inner: float):
    wave = np.sqrt(gb.STEEL.youngs_modulus / gb.STEEL.density)
    found = axial_frequencies(rod(elements=4, inner=inner), 4)
    assert found == pytest.approx([n * wave / 2 for n in (1, 2, 3, 4)], rel=1e-9)
    assert "rigid" in rod().modes().whirl


def test_a_rod_with_an_end_mass_has_the_roots_of_its_frequency_equation():
    wave = np.sqrt(gb.STEEL.youngs_modulus / gb.STEEL.density)
    ratio = 2.0 / (gb.STEEL.density * np.pi * 0.025**2)
    # free-mass: tan(k) = −(end mass/rod mass) k
    roots = [
        brentq(lambda k: np.sin(k) + ratio * k * np.cos(k), (n - 0.5) * np.pi, n * np.pi)
        for n in (1, 2, 3)
    ]
    found = axial_frequencies(rod(elements=4, end_mass=2.0), 3)
    assert found == pytest.approx(np.array(roots) * wave / (2 * np.pi), rel=1e-9)


def test_statics_of_a_stepped_rod_are_exact():
    parts = [gb.Segment(0.3, 0.04), gb.Segment(0.5, 0.06, inner_diameter=0.02)]
    system = gb.RotorSystem(
        shafts=[gb.Shaft("rod", segments=parts)],
        bearings=[
            gb.Bearing("rod", 0.0, stiffness=1e8, axial_stiffness=2e7),
            gb.Bearing("rod", 0.8, stiffness=1e8),
        ],
        forces=[gb.Force(("rod", 0.8), axial=1000.0)],
    )
    areas = np.pi / 4 * np.array([0.04**2, 0.06**2 - 0.02**2])
    stretch = 1000.0 / gb.STEEL.youngs_modulus * np.array([0.3, 0.5]) / areas
    static = system.static()
    assert static.axial(("rod", 0.3)) == pytest.approx(5e-5 + stretch[0], rel=1e-12)
    assert static.axial(("rod", 0.8)) == pytest.approx(5e-5 + stretch.sum(), rel=1e-12)
    assert static.axial_bearing_force(("rod", 0.0)) == pytest.approx(1000.0, rel=1e-12)
    assert static.axial_bearing_force(("rod", 0.8)) == 0.0


# --- Statics


def thrusts(system: gb.RotorSystem) -> dict[tuple[str, float], float]:
    static = system.static(geometry="frozen")
    places = [(bearing.shaft, bearing.position) for bearing in system.bearings]
    return {place: static.axial_bearing_force(place) for place in places}


@pytest.mark.parametrize("helix", [HELIX, -HELIX, 0.3])
def test_bearings_carry_thrust_radial_force_and_tilting_moment(helix: float):
    system = helical_pair(helix, mesh={"centre_line_angle": 0.0})
    radius, angle = 25 * 3e-3 / np.cos(helix) / 2, np.radians(20.0)
    tangential = 200.0 / radius
    thrust, radial = tangential * np.tan(helix), tangential * np.tan(angle) / np.cos(helix)
    static = system.static(geometry="frozen")
    mesh = static.mesh(("g1", "g2"))
    assert mesh.force == pytest.approx(tangential / np.cos(angle) / np.cos(helix), rel=1e-12)
    assert mesh.deflection == pytest.approx(mesh.force / 2e8, rel=1e-12)
    assert mesh.stiffness == pytest.approx(2e8, rel=1e-12)
    # a right-hand driver that turns counter-clockwise is pushed towards +x, the driven gear towards −x
    along = {
        shaft: sum(static.axial_bearing_force((shaft, x)) for x in (0.0, 0.4))
        for shaft in ("input", "output")
    }
    assert along["input"] == pytest.approx(thrust, rel=1e-10)
    assert along["output"] == pytest.approx(-thrust, rel=1e-10)
    assert mesh.thrust == pytest.approx(-thrust, rel=1e-12)
    for shaft, side, arm in (("input", 1.0, radius), ("output", -1.0, 2 * radius)):
        left, right = (static.bearing_force((shaft, x)) for x in (0.0, 0.4))
        assert left + right == pytest.approx([-side * radial, -side * tangential], rel=1e-9)
        # moments about the left bearing: the force at the gear, and the thrust ±F_a at ±r_w along y
        assert right[0] * 0.4 == pytest.approx(-side * radial * 0.15 - thrust * arm, rel=1e-9)
        assert right[1] * 0.4 == pytest.approx(-side * tangential * 0.15, rel=1e-9)


def test_opposite_helices_on_one_shaft_cancel_the_thrust():
    # the thrust of a torque M is 2 M sin β/(z m_n): half the teeth need half the sine
    second, shafts = np.arcsin(np.sin(HELIX) / 2), ("input", "middle", "output")
    gears = [
        gb.Gear("g1", "input", 0.2, 25, **TEETH, helix_angle=HELIX),
        gb.Gear("g2", "middle", 0.1, 50, **TEETH, helix_angle=-HELIX),
        gb.Gear("g3", "middle", 0.3, 25, **TEETH, helix_angle=-second),
        gb.Gear("g4", "output", 0.2, 50, **TEETH, helix_angle=second),
    ]
    system = gb.RotorSystem(
        shafts=[gb.Shaft(name, length=0.4, outer_diameter=0.05) for name in shafts],
        gears=gears,
        meshes=[gb.Mesh("g1", "g2", stiffness=2e8), gb.Mesh("g3", "g4", stiffness=2e8)],
        bearings=[gb.Bearing(name, x, **BEARING) for name in shafts for x in (0.0, 0.4)],
        torques=[gb.Torque("g1", 200.0), gb.Torque.balance("g4")],
    )
    found = thrusts(system)
    total = {name: found[name, 0.0] + found[name, 0.4] for name in shafts}
    thrust = 200.0 * 2 * np.sin(HELIX) / (25 * 3e-3)
    assert total["input"] == pytest.approx(thrust, rel=1e-9)
    assert abs(total["middle"]) < 1e-9 * thrust
    assert total["output"] == pytest.approx(-total["input"], rel=1e-9)


# --- Motion


def ranged(found: np.ndarray, exact: np.ndarray) -> float:
    return float(np.abs(found - exact).max() / np.ptp(exact, axis=0).max())


@pytest.mark.parametrize("live", [True, False], ids=["live", "frozen"])
def test_a_helical_pair_moves_as_an_independent_program_says(live: bool):
    system = helical_pair(bearing={"tilting_stiffness": 1e5})
    times = np.linspace(0.0, 1.5e-3, 31)
    whole = HelicalTrain.of(system, 100.0)
    q, forces = whole.from_rest(100.0, times, live)
    geometry = "live" if live else "frozen"
    for how in ({"method": "rk45", "rtol": 1e-9}, {"method": "exponential", "rtol": 1e-9}):
        run = system.simulate(
            1.6e-3,
            100.0,
            initial="rest",
            times=times,
            geometry=geometry,
            record=["gears", "meshes", "bearings"],
            **how,
        )
        assert ranged(run.mesh(("g1", "g2")).force, forces[:, 0]) < 1e-6
        for name in ("g1", "g2"):
            place = whole.train.place(name)
            v = whole.train.dof(*place, 0)
            assert ranged(run.displacement(name), q[:, v : v + 2]) < 1e-6
            assert ranged(run.twist(name), q[:, v + 4]) < 1e-6
            assert ranged(run.axial(name), q[:, whole.axial(*place)]) < 1e-6


@pytest.mark.parametrize("live", [True, False], ids=["live", "frozen"])
def test_a_helical_pair_is_damped_in_separation(live: bool):
    # a light torque, and a backlash that the back flanks do not reach
    mesh = {"backlash": 1e-3, "damping_in_separation": True}
    torques = [gb.Torque("g1", 20.0), gb.Torque.balance("g2")]
    system = helical_pair(bearing={"tilting_stiffness": 1e5}, mesh=mesh, torques=torques)
    times = np.linspace(0.0, 1.5e-3, 31)
    whole = HelicalTrain.of(system, 300.0)
    _, forces = whole.from_rest(300.0, times, live)
    geometry = "live" if live else "frozen"
    for how in ({"method": "rk45", "rtol": 1e-9}, {"method": "exponential", "rtol": 1e-9}):
        run = system.simulate(
            1.6e-3, 300.0, initial="rest", times=times, geometry=geometry, record=["meshes"], **how
        )
        found = run.mesh(("g1", "g2"))
        assert (found.stiffness == 0.0).any()
        assert (found.stiffness > 0.0).any()
        # the independent solution does not end a step at a contact change
        assert ranged(found.force, forces[:, 0]) < 1e-5


def test_live_and_frozen_geometry_differ():
    times = np.linspace(0.0, 3e-3, 31)
    runs = [
        helical_pair().simulate(3e-3, 100.0, initial="rest", times=times, geometry=geometry)
        for geometry in ("live", "frozen")
    ]
    assert ranged(runs[0].axial("g1"), runs[1].axial("g1")) > 1e-4


def undamped(**changes: Any) -> gb.RotorSystem:
    mesh = {"damping_ratio": 0.0} | changes.pop("mesh", {})
    return helical_pair(mesh=mesh, bearing={"damping": 0.0, "axial_damping": 0.0}, **changes)


def test_a_free_undamped_motion_conserves_energy():
    straight = [
        gb.Shaft(name, length=0.4, outer_diameter=0.05, elements=2) for name in ("input", "output")
    ]
    system = undamped(torques=[], shafts=straight)
    loaded = undamped(shafts=straight)
    first = loaded.simulate(1e-4, 0.0, initial="static", method="rk45", rtol=1e-6).final
    run = system.simulate(
        5e-3, 0.0, initial=first, method="rk45", rtol=1e-10, record=["energy", "gears"]
    )
    assert np.ptp(run.axial("g1")) > 1e-6
    assert np.ptp(run.energy) < 1e-8 * run.energy.max()


@pytest.mark.parametrize(
    "mesh",
    [
        {},
        {"backlash": 2e-5, "stiffness": gb.Stiffness.square(2e8)},
        {
            "backlash": 2e-6,
            "damping_in_separation": True,
            "error": gb.TransmissionError(tooth=[(2e-5, 0.1)]),
        },
        {"stiffness": gb.Stiffness.parabolic(2e8, phase="twist")},
        {"stiffness": gb.Stiffness.square(2e8, engagement="sharp")},
        {"error": gb.TransmissionError(tooth=[(2e-6, 0.1)])},
    ],
    ids=["constant", "backlash", "damping in separation", "phase of the twist", "sharp", "error"],
)
def test_the_energy_balance_closes(mesh: dict[str, Any]):
    gears = helical_pair().gears
    out = [gb.Gear("g1", "input", 0.15, 25, **TEETH, helix_angle=HELIX, runout=2e-5), gears[1]]
    for parts in (gears, out):
        system = helical_pair(mesh=mesh, gears=parts)
        run = system.simulate(5e-3, 200.0, method="rk45", rtol=1e-9, record=["energy", "meshes"])
        balance = run.energy_balance()
        scale = np.abs(balance.total - balance.total[0]).max()
        # steps cross the kinks of a sharp engagement, which the audit integrates to second order
        tolerance = 1e-4 if "sharp" in str(mesh) else 1e-5
        assert np.abs(balance.residual).max() < tolerance * max(scale, run.energy.max())
        other = system.simulate(5e-3, 200.0, method="exponential", rtol=1e-8, times=run.time)
        force = run.mesh(("g1", "g2")).force
        assert ranged(other.mesh(("g1", "g2")).force, force) < 1e-5


def test_a_vanishing_helix_is_a_spur_gear():
    axial = gb.Force("g1", axial=1e-30)  # the spur gears have axial coordinates too
    spur, helical = helical_pair(0.0, forces=[axial]), helical_pair(1e-9, forces=[axial])
    assert spur.dofs == helical.dofs
    frequencies = [system.modes(50.0).frequencies_hz[1:] for system in (spur, helical)]
    assert frequencies[0] == pytest.approx(frequencies[1], rel=1e-9)
    for stiffness in (2e8, gb.Stiffness.parabolic(2e8), gb.Stiffness.potential_energy(), None):
        forces = [
            helical_pair(helix, mesh={"stiffness": stiffness}, forces=[axial])
            .simulate(2e-3, 200.0, method="rk4")
            .mesh(("g1", "g2"))
            .force
            for helix in (0.0, 1e-9)
        ]
        # the difference grows with β: the thrust does work on the axial motion
        assert ranged(forces[0], forces[1]) < 1e-8


def test_a_spur_scene_has_five_degrees_of_freedom():
    spur = helical_pair(0.0, bearing={"axial_stiffness": 0.0, "axial_damping": 0.0})
    assert {direction for *_, direction in spur.dofs} == {"v", "w", "B", "G", "twist"}
    run = spur.simulate(1e-3, 100.0)
    with pytest.raises(gb.GearbowError, match="no axial motion; helical gears"):
        run.axial("g1")
    with pytest.raises(gb.GearbowError, match="no axial motion"):
        spur.static().axial("g1")
    names = [
        direction for shaft, x, direction in helical_pair().dofs if (shaft, x) == ("input", 0.15)
    ]
    assert names == ["u", "v", "w", "B", "G", "twist"]


# --- Contact lines


def stiffness_over_cycle(system: gb.RotorSystem, samples: int = 400) -> np.ndarray:
    """Give the mesh stiffness at equal steps of one mesh cycle, in frozen geometry."""
    speed = 10.0
    period = 2 * np.pi / (25 * speed)
    times = np.arange(1, samples + 1) * period / samples
    run = system.simulate(
        1.001 * period, speed, times=times, geometry="frozen", method="exponential", rtol=1e-4
    )
    return run.mesh(("g1", "g2")).stiffness


def overlapping(overlap: float, stiffness: gb.Stiffness) -> gb.RotorSystem:
    """Return the pair with the face width that gives an overlap ratio."""
    width = overlap * np.pi * 3e-3 / np.sin(HELIX)
    gears = [
        gb.Gear(name, shaft, 0.15, teeth, module=3e-3, face_width=width, helix_angle=helix)
        for name, shaft, teeth, helix in (
            ("g1", "input", 25, HELIX),
            ("g2", "output", 50, -HELIX),
        )
    ]
    shafts = [gb.Shaft(n, length=0.4, outer_diameter=0.05, elements=2) for n in ("input", "output")]
    return helical_pair(gears=gears, shafts=shafts, mesh={"stiffness": stiffness})


@pytest.mark.parametrize("engagement", [0.1, "sharp"])
@pytest.mark.parametrize("overlap", [1.0, 2.0])
def test_an_integer_overlap_has_a_constant_stiffness(overlap: float, engagement: float | str):
    system = overlapping(overlap, gb.Stiffness.square(2e8, engagement=engagement))
    values = stiffness_over_cycle(system, 50)
    assert values == pytest.approx(2e8, rel=1e-12)


def transverse_contact_ratio() -> float:
    """Give ε_α of the pair with the centres at rest."""
    radii = np.array([25, 50]) * 3e-3 / np.cos(HELIX) / 2
    alpha = np.arctan(np.tan(np.radians(20.0)) / np.cos(HELIX))
    base = radii * np.cos(alpha)
    reach = np.sqrt((radii + 3e-3) ** 2 - base**2).sum() - radii.sum() * np.sin(alpha)
    return float(reach / (2 * np.pi * base[0] / 25))


@pytest.mark.parametrize("overlap", [0.3, 0.8, 1.4])
def test_the_stiffness_is_the_length_of_the_contact_lines(overlap: float):
    pair_stiffness, transverse = 1.4e8, transverse_contact_ratio()
    system = overlapping(overlap, gb.Stiffness.square(pair=pair_stiffness, engagement="sharp"))
    values = np.sort(stiffness_over_cycle(system))
    # the lines of pair j cover the sections at s + j + ξ ε_β between 0 and ε_α, in base pitches
    starts, first = np.arange(400) / 400, np.arange(-5, 5)[:, np.newaxis]
    begin = np.clip(starts + first, 0.0, transverse)
    end = np.clip(starts + first + overlap, 0.0, transverse)
    covered = (end - begin).sum(axis=0) / overlap
    # the samples of both cycles begin at other positions, so that sorted values differ by one step
    assert values == pytest.approx(pair_stiffness * np.sort(covered), rel=2e-2)
    assert values.min() == pytest.approx(pair_stiffness * covered.min(), rel=1e-2)
    assert values.max() == pytest.approx(pair_stiffness * covered.max(), rel=1e-2)
    # sums over the cycle are exact for piecewise linear functions up to their kinks
    assert values.mean() == pytest.approx(pair_stiffness * transverse, rel=1e-4)


def test_overlap_makes_the_variation_smaller():
    ranges = [
        np.ptp(stiffness_over_cycle(overlapping(overlap, gb.Stiffness.parabolic(2e8)), 100))
        for overlap in (0.1, 0.3, 0.7, 1.0)
    ]
    assert np.all(np.diff(ranges) < 0.0)


def test_the_stiffness_of_iso_6336_is_that_of_the_transverse_section():
    found = helical_pair(mesh={"stiffness": None}).static().mesh(("g1", "g2")).stiffness
    z = np.array([25, 50]) / np.cos(HELIX) ** 3
    single = 0.8 / (0.04723 + 0.15551 / z[0] + 0.25791 / z[1]) * 1e9 * np.cos(HELIX)
    ratio = transverse_contact_ratio()
    base_helix = np.arcsin(np.sin(HELIX) * np.cos(np.radians(20.0)))
    wanted = single * (0.75 * ratio + 0.25) * 0.03 / np.cos(base_helix) ** 2
    assert found == pytest.approx(wanted, rel=1e-12)
    overlap = 0.03 * np.sin(HELIX) / (np.pi * 3e-3)
    total = helical_pair().static(geometry="frozen").mesh(("g1", "g2")).contact_ratio
    # the static centres are a little further apart than at rest
    assert total == pytest.approx(ratio + overlap, rel=2e-2)


# --- Linear analyses


def fine(**changes: Any) -> gb.RotorSystem:
    shafts = [
        gb.Shaft(name, length=0.4, outer_diameter=0.05, elements=13, degree=1, bow=bow)
        for name, bow in (("input", gb.Bow.half_sine(1e-4)), ("output", None))
    ]
    return helical_pair(shafts=shafts, **changes)


def test_band_matrices_have_the_modes_of_dense_matrices():
    assert len(fine().dofs) > 150
    for speed in (0.0, 230.0):
        assert_lowest_modes(fine(), speed)


def test_the_synchronous_response_is_that_of_dense_matrices():
    assert_same_response(fine(), np.array([0.0, 150.0, 900.0]))


def test_the_campbell_diagram_and_critical_speeds_are_those_of_dense_matrices():
    system, speeds = fine(), np.linspace(0.0, 400.0, 3)
    found = system.campbell(speeds, count=6)
    wanted = through_dense_matrices(system).campbell(speeds, count=6)
    scale = np.abs(wanted.eigenvalues).max()
    assert np.abs(found.eigenvalues - wanted.eigenvalues).max() < 1e-7 * scale
    few, all_of_them = (system.critical_speed_map([5e7], count=count) for count in (6, None))
    assert few.speeds[0] == pytest.approx(all_of_them.speeds[0][:6], rel=1e-7)
    soft = system.replace(bearings=[replace(b, axial_stiffness=1e5) for b in system.bearings])
    other = soft.critical_speed_map([5e7], count=6).speeds[0]
    assert np.abs(other - few.speeds[0]).max() > 1.0


def test_a_reduced_model_follows_the_complete_one():
    system = fine(mesh={"stiffness": gb.Stiffness.parabolic(2e8)})
    whole = system.simulate(0.02, 300.0, method="exponential", rtol=1e-6)
    reduced = system.simulate(0.02, 300.0, method="exponential", rtol=1e-6, modes=80)
    for name in ("g1", "g2"):
        assert ranged(reduced.axial(name), whole.axial(name)) < 0.02
    assert ranged(reduced.mesh(("g1", "g2")).force, whole.mesh(("g1", "g2")).force) < 0.02


def test_a_run_up_agrees_between_methods():
    profile = gb.SpeedProfile.ramp(100.0, 200.0, 0.01)
    times = np.linspace(0.0, 0.01, 101)
    runs = [
        helical_pair().simulate(
            0.01, profile, initial="rest", times=times, method=method, rtol=1e-8
        )
        for method in ("rk45", "exponential")
    ]
    assert ranged(runs[1].axial("g1"), runs[0].axial("g1")) < 1e-5


def test_shapes_have_the_axial_part_and_a_name():
    modes = rod().modes()
    number = modes.whirl.index("axial")
    assert modes.names()[number] == "rod x"
    shares = modes.energy_shares()
    assert shares["rod", "u"][number] == pytest.approx(1.0, abs=1e-9)


# --- Bearings, couplings and housings


def test_a_coupling_transmits_thrust():
    shafts = [gb.Shaft(name, length=0.3, outer_diameter=0.05) for name in ("left", "right")]
    system = gb.RotorSystem(
        shafts=shafts,
        couplings=[
            gb.Coupling(
                ("left", 0.3),
                ("right", 0.0),
                axial_stiffness=2e6,
                lateral_stiffness=1e8,
                tilting_stiffness=1e4,
                torsional_stiffness=1e5,
            )
        ],
        bearings=[
            gb.Bearing("left", 0.0, stiffness=1e8, axial_stiffness=1e7),
            gb.Bearing("left", 0.2, stiffness=1e8),
            gb.Bearing("right", 0.1, stiffness=1e8),
            gb.Bearing("right", 0.3, stiffness=1e8),
        ],
        forces=[gb.Force(("right", 0.0), axial=-500.0)],
    )
    static = system.static()
    assert static.axial_bearing_force(("left", 0.0)) == pytest.approx(-500.0, rel=1e-12)
    gap = static.axial(("right", 0.0)) - static.axial(("left", 0.3))
    assert gap == pytest.approx(-500.0 / 2e6, rel=1e-12)


def test_a_bearing_in_a_turning_housing_pushes_it_over():
    housing = gb.Housing(
        "box",
        mass=10.0,
        stiffness=1e9,
        inertia=(1.0, 1.0, 1.0),
        position=(0.0, 0.0, -0.2),
        rotational_stiffness=(1e6, 2e6, 3e6),
    )
    system = gb.RotorSystem(
        shafts=[gb.Shaft("rotor", length=0.4, outer_diameter=0.05)],
        housings=[housing],
        bearings=[
            gb.Bearing("rotor", 0.0, stiffness=1e9, axial_stiffness=1e8, support="box"),
            gb.Bearing("rotor", 0.4, stiffness=1e9, tilting_stiffness=10.0, support="box"),
        ],
        forces=[gb.Force(("rotor", 0.0), axial=1000.0)],
    )
    static = system.static()
    # the thrust turns the housing about y with its lever of 0.2 m; weak springs carry the rest
    tilt = static.state[system.dofs.index(("box", 0.0, "B"))]
    assert tilt == pytest.approx(1000.0 * 0.2 / 2e6, rel=0.2)
    expected = 1000.0 / 1e8 + tilt * 0.2
    assert static.axial(("rotor", 0.0)) == pytest.approx(expected, rel=1e-9)


# --- Files and errors


def test_descriptions_and_runs_come_back_from_files(tmp_path: Any):
    system = helical_pair(
        bearing={"tilting_stiffness": 2e4, "tilting_damping": 3.0},
        forces=[gb.Force("g1", 10j, axial=5.0)],
    )
    assert gb.RotorSystem.from_dict(system.description).description == system.description
    system.save(tmp_path / "scene.toml")
    assert gb.RotorSystem.load(tmp_path / "scene.toml").description == system.description
    run = system.simulate(1e-3, 100.0, record=["gears", "bearings", "energy"])
    for suffix in ("npz",):
        run.save(tmp_path / f"run.{suffix}")
        back = gb.Response.load(tmp_path / f"run.{suffix}")
        assert np.array_equal(back.axial("g1"), run.axial("g1"))
        found = back.axial_bearing_force(("input", 0.0))
        assert np.array_equal(found, run.axial_bearing_force(("input", 0.0)))
    later = system.simulate(1e-3, 100.0, initial=run, record=["gears"])
    assert later.axial("g1")[0] == pytest.approx(run.axial("g1")[-1], rel=1e-9)


def test_axial_forces_on_bearings_are_those_of_their_springs():
    run = helical_pair().simulate(2e-3, 100.0, record=["bearings", ("input", 0.0)], initial="rest")
    u = run.axial(("input", 0.0))
    rate = np.gradient(u, run.time, edge_order=2)
    force = run.axial_bearing_force(("input", 0.0))
    assert ranged(3e7 * u + 400.0 * rate, force) < 5e-3


@pytest.mark.parametrize("geometry", ["live", "frozen"])
def test_the_recorded_thrust_is_the_axial_part_of_the_mesh_force(geometry: str):
    run = helical_pair().simulate(2e-3, 100.0, geometry=geometry, record=["meshes"])
    mesh = run.mesh(("g1", "g2"))
    # sin β_b = sin β cos α_n with the pressure angle α_n = 20° normal to the teeth
    axial = np.sin(HELIX) * np.cos(np.radians(20.0))
    np.testing.assert_allclose(mesh.thrust, -mesh.force * axial, rtol=1e-12)
    spur = helical_pair(0.0).simulate(1e-3, 100.0, record=["meshes"]).mesh(("g1", "g2"))
    assert not spur.thrust.any()


@each_case(
    ("change", "message"),
    [
        (
            {"gears": "same hand"},
            r'cannot mesh: "g1" has helix_angle 0\.349.*opposite hands.*: give "g2" helix_angle=-0\.349',
        ),
        ({"gears": "degrees"}, r"gears\[0\].helix_angle: must be between -π/3 and π/3 rad \(is it"),
        (
            {
                "mesh": {
                    "tip_relief": gb.TipRelief(1e-5, 1e-3),
                    "stiffness": gb.Stiffness.square(2e8),
                }
            },
            r"meshes\[0\].tip_relief: helical teeth take none",
        ),
        (
            {"mesh": {"stiffness": gb.Stiffness.potential_energy(foundation="shared")}},
            r'meshes\[0\].stiffness.foundation: "shared" has no helical teeth; use "separate"',
        ),
        ({"bearing": {"axial_stiffness": -1.0}}, r"bearings\[0\].axial_stiffness: must not be neg"),
        (
            {"bearing": {"tilting_stiffness": np.nan}},
            r"bearings\[0\].tilting_stiffness: must be fin",
        ),
        ({"forces": [gb.Force("g1", axial=np.inf)]}, r"forces\[0\].axial: must be finite"),
    ],
)
def test_impossible_helical_scenes_are_refused(change: dict[str, Any], message: str):
    angle = {"same hand": HELIX, "degrees": 20.0}.get(change.get("gears", ""))
    if angle is not None:
        gears = [
            gb.Gear(name, shaft, 0.15, z, **TEETH, helix_angle=angle)
            for name, shaft, z in (("g1", "input", 25), ("g2", "output", 50))
        ]
        change = {"gears": gears}
    with pytest.raises(gb.SceneError, match=message):
        helical_pair(**change)


def test_a_shaft_without_axial_bearing_is_named():
    loose = helical_pair(bearing={"axial_stiffness": 0.0, "axial_damping": 0.0})
    message = (
        r'shafts\[\d\]: no static equilibrium: "(input|output)" is unconstrained along its axis: .* '
        r'gb.Bearing\("(input|output)", position, stiffness=\.\.\., axial_stiffness=\.\.\.\)'
    )
    with pytest.raises(gb.SceneError, match=message):
        loose.static()
    with pytest.raises(gb.SceneError, match=message):
        loose.simulate(1e-3, 100.0)
    assert loose.modes().whirl.count("rigid") > 1
    held = [
        gb.Bearing(s, x, **BEARING | ({"axial_stiffness": 0.0} if s == "output" else {}))
        for s in ("input", "output")
        for x in (0.0, 0.4)
    ]
    with pytest.raises(gb.SceneError, match=r'shafts\[1\]: .*"output" is unconstrained along'):
        helical_pair(bearings=held).static()


def test_motions_without_axial_coordinates_are_refused_or_left_out():
    with pytest.raises(gb.SceneError, match=r'motion: "lateral" has no axial motion'):
        rod().replace(motion="lateral")
    twisting = helical_pair(
        motion="torsion",
        shafts=[gb.Shaft(n, length=0.4, outer_diameter=0.05) for n in ("input", "output")],
        gears=[
            gb.Gear("g1", "input", 0.15, 25, **TEETH, helix_angle=HELIX),
            gb.Gear("g2", "output", 0.15, 50, **TEETH, helix_angle=-HELIX),
        ],
    )
    assert {direction for *_, direction in twisting.dofs if direction[0] != "t"} == set()
    mesh = twisting.static().mesh(("g1", "g2"))
    tangential = 200.0 / (25 * 3e-3 / np.cos(HELIX) / 2)
    assert mesh.force == pytest.approx(
        tangential / np.cos(np.radians(20)) / np.cos(HELIX), rel=1e-9
    )


# --- Figures


def test_the_campbell_diagram_of_a_helical_train_is_drawn(tmp_path):
    system = helical_pair()
    campbell = system.campbell([0.0, 100.0, 200.0], count=30)
    assert "axial" in campbell.whirl
    campbell.plot().savefig(tmp_path / "method.png")
    system.save(tmp_path / "scene.toml")
    command = ["campbell", str(tmp_path / "scene.toml"), "--to", "200", "--points", "3"]
    with pytest.raises(SystemExit) as ended:
        main([*command, "--count", "30", "--out", str(tmp_path / "command.png")])
    assert not ended.value.code
    assert (tmp_path / "command.png").stat().st_size > 1000


def test_the_narrower_gear_determines_the_overlap():
    system = uneven_train()
    gears = {gear.name: gear for gear in system.gears}
    static = system.static()
    for driver, driven in (("pinion", "idler"), ("idler", "wheel")):
        teeth = np.array([gears[name].teeth for name in (driver, driven)])
        width = min(float(gears[name].face_width or 0.0) for name in (driver, driven))
        helix = abs(gears[driver].helix_angle)
        radii = teeth * 3e-3 / np.cos(helix) / 2
        base = radii * np.cos(np.arctan(np.tan(np.radians(20.0)) / np.cos(helix)))
        tips = np.sqrt((radii + 3e-3) ** 2 - base**2).sum()
        mesh = static.mesh((driver, driven))
        # ε_α at the pressure angle of the moved centres, and ε_β = b sin β/(π m_n)
        along = base.sum() * np.tan(mesh.pressure_angle)
        transverse = (tips - along) / (2 * np.pi * base[0] / teeth[0])
        overlap = width * np.sin(helix) / (np.pi * 3e-3)
        assert mesh.contact_ratio == pytest.approx(transverse + overlap, rel=1e-9)
