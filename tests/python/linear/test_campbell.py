"""Campbell diagrams: each line follows one mode, and critical speeds agree with the modes."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference import published, scenes
from reference.cases import each_case
from reference.machines import (
    LIGHT,
    OIL,
    hostile,
    inertia,
    mirrored,
    pair_with_two_ranges,
    rotor,
    rotor_on_films,
)

RPM = 2 * np.pi / 60


def same_as_modes(system: gb.RotorSystem, intersection: gb.results.Intersection) -> None:
    """Check that an intersection is a mode of the system at its speed and lies on its excitation
    line.
    """
    modes = system.modes(speed=intersection.speed)
    apart = np.abs(modes.frequencies_hz - intersection.frequency_hz)
    # both have an error of eps times the ratio of the highest frequency to this one
    assert apart.min() < 1e-9 * intersection.frequency_hz
    assert modes.whirl[int(apart.argmin())] == intersection.whirl
    assert modes.damping_ratios[int(apart.argmin())] == pytest.approx(
        intersection.damping_ratio, abs=1e-9
    )
    line = intersection.line.order * intersection.speed / (2 * np.pi)
    assert line == pytest.approx(intersection.frequency_hz, rel=1e-12)


def test_critical_speeds_of_nelson_and_mcvaugh():
    system = scenes.v2()
    campbell = system.campbell(np.linspace(0.0, 1.1e5 * RPM, 12), count=8)
    found = campbell.criticals[:6]
    assert [m.whirl for m in found] == [whirl for _, whirl in published.V2_CRITICALS_RPM]
    # the printed geometry is rounded: within 1 %
    assert [m.speed / RPM for m in found] == pytest.approx(
        [rpm for rpm, _ in published.V2_CRITICALS_RPM], rel=1e-2
    )
    for intersection in found:
        same_as_modes(system, intersection)


@pytest.mark.parametrize("order", [1.0, 0.5, 4.0])
def test_the_map_has_the_critical_speeds_of_the_diagram(order: float):
    # the diagram uses Newton's method on the modes; the map solves one Hermitian eigenproblem
    system = scenes.v2()
    found = system.critical_speed_map([published.V2_BEARING_STIFFNESS], order=order)
    for speed, whirl in list(zip(found.speeds[0], found.whirl[0], strict=True))[:6]:
        modes = system.modes(speed=speed)
        apart = np.abs(2 * np.pi * modes.frequencies_hz / (order * speed) - 1.0)
        assert apart.min() < 1e-9  # see `same_as_modes`
        assert modes.whirl[int(apart.argmin())] == whirl
    if order == 1.0:
        criticals = [m.speed for m in system.campbell([0.0, 5e3, 1.1e4], count=8).criticals[:6]]
        assert found.speeds[0][:6] == pytest.approx(criticals, rel=1e-9)


def test_the_map_runs_from_a_free_shaft_to_a_pinned_one():
    system = scenes.v2()
    rising = system.critical_speed_map(np.geomspace(1e5, 1e12, 8))
    forward, backward = rising.lines("forward"), rising.lines("backward")
    # stiffness never lowers a critical speed (Rayleigh), and forward lies above backward
    assert np.all(np.diff(forward[:, :3], axis=0) > 0.0)
    assert np.all(np.diff(backward[:, :3], axis=0) > 0.0)
    assert np.all(forward[:, :3] > backward[:, :3])
    # a rotor on soft bearings is rigid: critical speeds follow the root of the stiffness within 1 %
    soft = system.critical_speed_map([1e2, 4e2]).lines("forward")
    assert soft[1, 0] / soft[0, 0] == pytest.approx(2.0, rel=1e-2)
    with pytest.raises(gb.GearbowError, match="torsion"):
        rising.lines("torsion")


def test_a_flat_disk_has_no_forward_critical_speed_of_tilting():
    def tilting(polar: float) -> list[str]:
        shaft = {"length": 0.5, "outer_diameter": 0.02, "elements": 2, "material": LIGHT}
        system = rotor(shaft, inertia(10.0, 1.0, polar), {"stiffness": 1e7})
        return list(system.critical_speed_map([1e7]).whirl[0][:4])

    # translation, then tilt: I_d − I_p is the tilting inertia in synchronous forward whirl
    assert sorted(tilting(0.5)) == ["backward", "backward", "forward", "forward"]
    assert tilting(1.5)[:3].count("backward") == 2
    assert tilting(1.5)[:3].count("forward") == 1


def test_mode_lines_pass_the_frequencies_of_friswell():
    campbell = scenes.v3().campbell(np.linspace(0.0, 4000 * RPM, 5), count=5)
    found = 2 * np.pi * campbell.frequencies_hz
    # one unit of the last printed digit
    assert found[0] == pytest.approx(published.V3_AT_REST, abs=1e-2)
    assert np.sort(found[-1]) == pytest.approx(published.V3_AT_4000_RPM, abs=1e-2)
    assert set(campbell.whirl[0]) == {"planar"}
    assert list(campbell.whirl[-1]) == published_whirl(campbell)


def published_whirl(campbell: gb.results.Campbell) -> list[str]:
    order = np.argsort(np.argsort(campbell.frequencies_hz[-1]))
    names = ["backward", "forward", "backward", "forward", "backward"]
    return [names[i] for i in order]


def test_every_intersection_of_a_geared_pair_is_a_mode_there():
    system = scenes.v1()
    campbell = system.campbell(np.linspace(10.0, 400.0, 9), count=13, harmonics=1)
    names = {intersection.line.name for intersection in campbell.criticals}
    assert names <= {"1× rotor1", "1× rotor2"}
    assert campbell.lines[1].order == pytest.approx(328 / 23, rel=1e-15)
    assert campbell.lines[2].order == 328
    assert len(campbell.intersections) >= 13
    for intersection in campbell.intersections:
        same_as_modes(system, intersection)
    # the frequencies printed at 1500 rpm lie on the diagram's lines there
    at = system.campbell([100.0, published.V1_SPEED], count=13)
    assert np.sort(at.frequencies_hz[-1]) == pytest.approx(published.V1_HZ, rel=1e-4)


def test_each_mode_keeps_its_shape_through_a_crossing():
    # torsion at 650.41 rad/s meets the backward bending mode that falls from 716.8
    system = scenes.v3(motion="coupled")
    speeds = np.linspace(0.0, 4000 * RPM, 6)
    campbell = system.campbell(speeds, count=6)
    twisting = np.flatnonzero(campbell.whirl[-1] == "torsion")
    assert twisting.size == 1
    torsion = 2 * np.pi * campbell.frequencies_hz[:, twisting[0]]
    assert torsion == pytest.approx(published.V3_TORSION, abs=1e-2)
    falling = 2 * np.pi * campbell.frequencies_hz[:, campbell.frequencies_hz[0].argmax()]
    assert falling[0] > torsion[0]
    assert falling[-1] < torsion[-1]
    assert np.all(np.diff(falling) < 0.0)


def veering(anisotropy: float, steps: int) -> gb.results.Campbell:
    """Return a rotor whose forward mode approaches the backward mode of the next pair."""
    system = scenes.v3()
    bearings = [
        gb.Bearing("shaft", bearing.position, stiffness=(1e6, anisotropy * 1e6))
        for bearing in system.bearings
    ]
    return system.replace(bearings=bearings).campbell(np.linspace(500.0, 2500.0, steps), count=6)


def test_forward_and_backward_modes_cross_on_isotropic_bearings():
    campbell = veering(1.0, 11)
    for mode in range(6):
        assert len(set(campbell.whirl[:, mode])) == 1
    order = np.argsort(campbell.frequencies_hz, axis=1)
    assert np.any(order[0] != order[-1])  # the lines cross


def test_modes_in_veering_never_cross():
    # a finer speed grid gives the same lines, because coarse intervals are halved
    coarse, fine = veering(1.5, 11), veering(1.5, 81)
    assert coarse.frequencies_hz == pytest.approx(fine.frequencies_hz[::8], rel=1e-9)
    swapped = {tuple(row) for row in coarse.whirl.T}
    assert any(len(set(row)) > 1 for row in swapped)  # the modes exchange their whirl directions
    # veering modes keep their order; with isotropic bearings they cross
    gaps = np.diff(np.sort(fine.frequencies_hz, axis=1), axis=1)
    assert gaps.min() > 0.0


def test_intersections_do_not_depend_on_the_speed_grid():
    system = scenes.Geared().package()
    coarse = system.campbell(np.linspace(0.0, 2000.0, 5), count=6)
    fine = system.campbell(np.linspace(0.0, 2000.0, 14), count=6)
    assert [m.line.name for m in coarse.intersections] == [m.line.name for m in fine.intersections]
    assert [m.speed for m in coarse.intersections] == pytest.approx(
        [m.speed for m in fine.intersections], rel=1e-10
    )


@pytest.mark.parametrize("seed", range(4))
def test_intersections_are_modes_on_bearings_of_every_kind(seed: int):
    # different and cross-coupled bearings; some rotors have a third of critical damping
    noise = np.random.default_rng(seed)
    cross = 1e6 * noise.uniform(-1.0, 1.0, (2, 2)) * (1.0 - np.eye(2))
    scene = replace(
        scenes.PAIR,
        elements=2,
        bearing_stiffness=np.diag(10.0 ** noise.uniform(6.0, 8.5, 2)) + cross,
        bearing_damping=np.diag(10.0 ** noise.uniform(1.0, 5.0, 2)),
        angles=(noise.uniform(0.0, 6.0),),
        modal_damping=0.3 if seed % 2 else None,
    )
    system = scene.package()
    coarse, fine = (system.campbell(np.linspace(0.0, 3000.0, count), count=8) for count in (6, 41))
    assert len(coarse.intersections) > 5
    # intersections of a tracked mode do not depend on the speed grid
    intersections = [
        sorted((m.line.name, m.speed) for m in c.intersections) for c in (coarse, fine)
    ]
    assert [name for name, _ in intersections[0]] == [name for name, _ in intersections[1]]
    assert [x for _, x in intersections[0]] == pytest.approx(
        [x for _, x in intersections[1]], rel=1e-8
    )
    for intersection in coarse.intersections:
        frequency = 2 * np.pi * intersection.frequency_hz
        ratio = intersection.damping_ratio
        value = frequency * (1j - ratio / np.sqrt(1.0 - ratio**2))
        # damped eigenvalues are less well conditioned than those of `same_as_modes`
        assert np.abs(system.modes(intersection.speed).eigenvalues - value).min() < 1e-7 * frequency


@pytest.mark.implausible
def test_every_intersection_of_an_isotropic_rotor_satisfies_its_equations():
    # on bearings without damping, a step of Newton's method from the root has a singular matrix
    residuals = [
        crossing.residual
        for elements in range(1, 8)
        for degree in range(3, 9)
        for crossing in gb.RotorSystem(
            [gb.Shaft("r", length=1.0, outer_diameter=0.05, elements=elements, degree=degree)],
            bearings=[gb.Bearing("r", x, stiffness=1e8) for x in (0.0, 1.0)],
        )
        .campbell([0.0, 1000.0], count=2)
        .intersections
    ]
    assert len(residuals) == 2 * 7 * 6
    assert max(residuals) < 1e-10  # 1e-13 is reached


def test_the_nutation_of_a_free_disk_starts_at_zero_frequency():
    # a symmetric free rigid body nutates forward at Ω I_p/I_d
    shaft = gb.Shaft(
        "s",
        length=0.1,
        outer_diameter=0.2,
        elements=2,
        material=gb.Material(1e15, 1.0, poisson_ratio=0.3),
    )
    disk = gb.Disk("disk", "s", 0.05, 10.0, 1.0, 1.7)
    free = gb.RotorSystem([shaft], disks=[disk])
    campbell = free.campbell([0.0, 100.0, 200.0], count=1)
    # the shaft adds 3e-4 of the inertia
    assert 2 * np.pi * campbell.frequencies_hz[:, 0] == pytest.approx([0.0, 170.0, 340.0], rel=1e-3)
    assert campbell.whirl[-1, 0] == "forward"


@each_case(
    ("given", "message"),
    [
        (
            {"speeds": [1.0, 1.0]},
            r"speeds\[1\]: must be farther from zero than the previous speed, got 1",
        ),
        (
            {"speeds": [-1.0, 1.5]},
            r"speeds\[0\]: must have the sign of the last speed, 1.5, got -1",
        ),
        ({"speeds": [-2.0, -1.0]}, r"speeds\[1\]: must be farther from zero .* got -1"),
        ({"speeds": [0.0, np.nan]}, r"speeds\[1\]: must be finite, got nan"),
        ({"speeds": [0.0, 1.0], "count": 0}, "count: must be at least 1"),
        ({"speeds": [0.0, 1.0], "harmonics": -1}, "harmonics: must be at least 0"),
    ],
)
def test_invalid_arguments_are_errors(given, message):
    with pytest.raises(gb.SceneError, match=message):
        scenes.v3().campbell(**given)


def test_a_map_needs_an_order():
    with pytest.raises(gb.SceneError, match="order: must not be zero"):
        scenes.v3().critical_speed_map([1e6], order=0.0)


def whirling(**changes: Any) -> gb.RotorSystem:
    """Build the hostile machine with internal damping, and seals whose cross-coupling grows."""
    system = hostile(**changes)
    seal = [[[0.0, k], [-k, 0.0]] for k in (0.0, 6e6, 6e7)]
    shafts = [replace(shaft, internal_damping=2e-6) for shaft in system.shafts]
    added = gb.Bearing("output", 0.17, stiffness=gb.SpeedTable([0.0, 150.0, 600.0], seal, "hold"))
    return system.replace(shafts=shafts, bearings=[*system.bearings, added])


class TestSensesOfRotation:
    """A machine at negative speeds has its own modes: those of its mirror image at positive ones."""

    @pytest.fixture(scope="class")
    @staticmethod
    def diagrams() -> dict[float, list[gb.results.Campbell]]:
        """Diagrams of the machine and of its image, by the sign of the speeds of the former."""
        speeds, machine = np.linspace(0.0, 600.0, 7), whirling()
        return {
            sense: [
                system.campbell(sign * speeds, count=8, harmonics=2)
                for system, sign in ((machine, sense), (mirrored(machine), -sense))
            ]
            for sense in (1.0, -1.0)
        }

    @pytest.mark.parametrize("sense", [1.0, -1.0])
    def test_the_mirrored_machine_has_the_same_diagram(self, sense: float, diagrams):
        own, image = diagrams[sense]
        scale = np.abs(own.eigenvalues)
        # round-off of the highest mode in the damping of the lowest ones
        assert np.abs(image.eigenvalues - own.eigenvalues).max() < 1e-8 * scale.max()
        assert np.array_equal(image.whirl[1:], own.whirl[1:])
        assert len(own.thresholds) == len(image.thresholds) > 0

        def points(found: gb.results.Campbell) -> list[tuple[float, float, float]]:
            rows = [
                (-one.line.order, -one.speed, one.frequency_hz)
                for one in found.intersections
                if one.damping_ratio < 0.1
            ]
            return sorted(rows + [(0.0, -one.speed, one.frequency_hz) for one in found.thresholds])

        mine = [(-order, -speed, rate) for order, speed, rate in points(own)]
        assert np.array(sorted(mine)) == pytest.approx(np.array(points(image)), rel=1e-7)
        assert image.unstable_ranges == pytest.approx(-np.array(own.unstable_ranges), rel=1e-7)

    def test_the_senses_differ(self, diagrams):
        (forward, _), (backward, _) = diagrams[1.0], diagrams[-1.0]
        apart = backward.eigenvalues - forward.eigenvalues
        assert np.abs(apart.imag).max() > 10.0
        assert np.abs(apart.real).max() > 1.0

    def test_a_diagram_of_negative_speeds_has_the_modes_there(self, diagrams):
        machine, found = whirling(), diagrams[-1.0][0]
        for one in found.intersections[::7]:
            assert one.speed < 0.0
            same_as_modes(machine, one)
        speeds = [abs(one.speed) for one in found.intersections]
        assert speeds == sorted(speeds)

    def test_the_map_of_a_negative_order_has_negative_speeds(self):
        machine = hostile()
        image = mirrored(machine)
        found = {}
        for order in (1.0, -1.0):
            own, other = (
                system.critical_speed_map([2e8], order=sign, count=3).speeds[0]
                for system, sign in ((machine, order), (image, -order))
            )
            assert np.all(order * own > 0.0)
            assert np.all(np.diff(np.abs(own)) >= 0.0)
            assert own == pytest.approx(-other, rel=1e-9)
            found[order] = own
        assert np.abs(found[1.0] + found[-1.0]).max() > 1.0

    def test_tables_are_searched_in_both_senses(self):
        machine = pair_with_two_ranges({"a": (0.0, 400.0), "b": (0.0, 300.0)}, "hold")
        uneven = gb.SpeedTable([0.0, 350.0], [(5e6, 9e6), (2e7, 3e7)], outside="hold")
        bearings = [replace(machine.bearings[0], stiffness=uneven), *machine.bearings[1:]]
        (mesh,) = machine.meshes
        machine = machine.replace(bearings=bearings, meshes=[replace(mesh, centre_line_angle=0.4)])
        own, other, forward = (
            np.array([speed for speed, _ in system._model.critical_speeds(order, 4)])
            for system, order in ((machine, -2.0), (mirrored(machine), 2.0), (machine, 2.0))
        )
        assert own.max() < 0.0
        assert own == pytest.approx(-other, rel=1e-9)
        assert np.abs(own + forward).max() > 1e-3

    def test_films_with_offset_lobes_have_the_modes_of_their_sense(self):
        films = [
            gb.JournalBearing(
                "r", x, **{**OIL, "profile": "three-lobe", "preload": 0.3, "offset": 0.6}
            )
            for x in (0.0, 0.5)
        ]
        system = rotor_on_films(bearings=films)
        speeds = [-300.0, -600.0]
        found = system.campbell(speeds, count=2, harmonics=0)
        other = system.campbell([300.0, 600.0], count=2, harmonics=0)
        for row, speed in zip(found.eigenvalues, speeds, strict=True):
            own = system.modes(speed, vibrating=True, count=2).eigenvalues
            assert np.sort_complex(row) == pytest.approx(np.sort_complex(own), rel=1e-8)
        assert np.abs(found.eigenvalues - other.eigenvalues).max() > 1.0


def test_the_table_has_a_line_for_each_intersection():
    campbell = scenes.v2().campbell(np.linspace(0.0, 5e3, 5), count=6)
    assert len(campbell.table().splitlines()) == 2 + len(campbell.intersections)
    assert len(campbell.to_dataframe()) == len(campbell.intersections)
    assert campbell.lines[0].name == "1× shaft"
    assert scenes.v1().campbell([1.0, 2.0], count=1).lines[2].name == "1× teeth of wheel–pinion"


def all_lines(found: gb.results.CriticalSpeedMap) -> np.ndarray:
    """Return the lines of every whirl, shape (stiffnesses, lines)."""
    whirls = sorted({name for names in found.whirl for name in names})
    return np.concatenate([found.lines(whirl) for whirl in whirls], axis=1)


@pytest.mark.implausible
def test_the_lines_of_the_map_follow_shapes_through_a_crossing():
    """Two shafts that a soft mesh hardly couples: the modes of a slender one cross those of the other."""
    diameters = {"slender": 0.02, "stout": 0.1}

    def system(*names: str) -> gb.RotorSystem:
        shafts = [gb.Shaft(n, length=1.0, outer_diameter=diameters[n], elements=4) for n in names]
        gear = {"base_radius": 0.04, "mass": 1.0, "diametral_inertia": 1e-3, "polar_inertia": 2e-3}
        return gb.RotorSystem(
            shafts=shafts,
            gears=[gb.Gear(f"gear {n}", n, 0.5, 25, **gear) for n in names],
            meshes=[gb.Mesh(f"gear {a}", f"gear {b}", stiffness=1e-3) for a, b in pairwise(names)],
            bearings=[gb.Bearing(n, x, stiffness=1e7) for n in names for x in (0.0, 1.0)],
            motion="lateral" if len(names) == 1 else "coupled",
        )

    stiffnesses = np.geomspace(1e3, 1e9, 7)
    train = system(*diameters).critical_speed_map(stiffnesses, count=12)
    for name in diameters:
        own = all_lines(system(name).critical_speed_map(stiffnesses))[:, 0]
        lines = all_lines(train)
        apart = np.nanmax(np.abs(lines / own[:, np.newaxis] - 1.0), axis=0)
        assert np.nanmin(apart) < 1e-6, name


def test_no_line_of_the_map_of_a_train_jumps():
    found = scenes.Geared().package().critical_speed_map(np.geomspace(1e6, 1e10, 13), count=12)
    whirls = {name for names in found.whirl for name in names}
    ratios = np.concatenate(
        [(found.lines(whirl)[1:] / found.lines(whirl)[:-1]).ravel() for whirl in sorted(whirls)]
    )
    # A critical speed grows at most as the root of the stiffness, 10^(1/6) = 1.47 for each step.
    assert np.nanmax(ratios) < 1.48
    assert np.nanmin(ratios) > 0.999


def test_the_figure_has_a_style_for_every_whirl_of_the_core():
    from gearbow._core import whirl_classes
    from gearbow.plotting.style import MARKS

    assert list(MARKS) == whirl_classes()
    assert len({mark for _, _, mark in MARKS.values()}) == len(MARKS)


def test_a_diagram_follows_the_oscillations_among_many_overdamped_modes():
    # internal damping makes more than 50 modes of 110 degrees of freedom overdamped
    shaft = gb.Shaft("s", length=0.8, outer_diameter=0.04, elements=20, internal_damping=1e-4)
    rotor = gb.RotorSystem(
        [shaft],
        disks=[gb.Disk("d", "s", 0.6, 10.0, diametral_inertia=0.05, polar_inertia=0.1)],
        bearings=[
            gb.Bearing("s", x, stiffness=5e7, damping=2e3, axial_stiffness=1e8) for x in (0.0, 0.5)
        ],
    )
    speeds = np.linspace(50.0, 500.0, 5)
    found = rotor.campbell(speeds, count=5)
    for speed, values in zip(speeds, found.eigenvalues, strict=True):
        modes = rotor.modes(speed)
        assert np.sum(modes.damping_ratios > 0.9) > 50
        lightly = modes.eigenvalues[(modes.eigenvalues.imag > 0.0) & (modes.damping_ratios < 0.5)]
        # the search ends at round-off
        np.testing.assert_allclose(np.sort_complex(values), np.sort_complex(lightly[:5]), rtol=1e-9)
