"""Rolling bearings with five degrees of freedom in systems, beside a model of their own in NumPy.

`Ring` computes the force of the rings from the positions of the groove centres, one ball or roller at a time.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.optimize import brentq

import gearbow as gb
from reference.cases import each_case

DISTANCE = 0.0464 * 0.02223
#: 218 angular contact bearing (Harris 2001, chapter 7), as in test_catalogue.py.
B218 = gb.RollingBearing(
    "rotor",
    0.05,
    elements=16,
    element_diameter=0.02223,
    pitch_diameter=0.125,
    clearance=0.0,
    contact_angle=math.radians(40.0),
    inner_groove=0.5232,
    outer_groove=0.5232,
    hertz_stiffness=896.7e6 * 0.02223**2 / DISTANCE**1.5,
    degrees_of_freedom=5,
    damping=500.0,
    axial_damping=500.0,
)
#: Tapered rollers of about the same size, and a deep groove ball bearing with a clearance.
TAPERED = replace(
    B218,
    contact="roller",
    contact_angle=math.radians(16.0),
    inner_groove=None,
    outer_groove=None,
    hertz_stiffness=6e8,
)
DEEP_GROOVE = replace(B218, contact_angle=0.0, clearance=2e-5)


@dataclass
class Ring:
    """The races of a bearing, from the formulas of Jones."""

    bearing: gb.RollingBearing
    mounted: float = 0.0

    def __post_init__(self) -> None:
        preload = self.bearing.axial_preload
        if preload:
            sense = -1.0 if self.bearing.contact_angle < 0 else 1.0

            def missing(u: float) -> float:
                self.mounted = u
                return sense * self.force(np.zeros(5), 0.0)[0] - preload

            self.mounted = brentq(missing, -1e-3, 1e-3, xtol=1e-18)

    def force(self, x: np.ndarray, cage: float) -> np.ndarray:
        """Forces over (u, v, w, B, Γ) at an angle of the cage."""
        bearing, n = self.bearing, self.bearing.elements
        return self._sum(x, cage + bearing.phase + 2 * np.pi * np.arange(n) / n)

    def mean(self, x: np.ndarray) -> np.ndarray:
        """The same averaged over the angles of the cage, from 200,000 of them."""
        count = 200_000
        angles = 2 * np.pi * (np.arange(count) + 0.5) / count
        return self._sum(x, angles) * self.bearing.elements / count

    def _sum(self, x: np.ndarray, phi: np.ndarray) -> np.ndarray:
        bearing = self.bearing
        sine, cosine = math.sin(bearing.contact_angle), math.cos(bearing.contact_angle)
        u, v, w, b, gamma = x
        radial = v * np.cos(phi) + w * np.sin(phi) - bearing.clearance / 2
        if bearing.contact == "roller":
            radius = bearing.pitch_diameter / 2
            axial = u + self.mounted + radius * (b * np.sin(phi) - gamma * np.cos(phi))
            approach = radial * cosine + axial * sine
            load = bearing.hertz_stiffness * np.maximum(approach, 0.0) ** (10 / 9)
            along, across = load * sine, load * cosine
        else:
            distance = (bearing.inner_groove + bearing.outer_groove - 1) * bearing.element_diameter
            radius = bearing.pitch_diameter / 2
            radius += (bearing.inner_groove - 0.5) * bearing.element_diameter * cosine
            axial = u + self.mounted + radius * (b * np.sin(phi) - gamma * np.cos(phi))
            line = np.array([distance * sine + axial, distance * cosine + radial])
            length = np.hypot(*line)
            load = bearing.hertz_stiffness * np.maximum(length - distance, 0.0) ** 1.5
            along, across = load * line / length
        moments = radius * np.array([along * np.sin(phi), -along * np.cos(phi)])
        return np.array(
            [
                along.sum(),
                (across * np.cos(phi)).sum(),
                (across * np.sin(phi)).sum(),
                *moments.sum(axis=1),
            ]
        )


def opposite(bearing: gb.RollingBearing, position: float) -> gb.RollingBearing:
    return replace(bearing, position=position, contact_angle=-bearing.contact_angle)


def rotor(*bearings: gb.RollingBearing, axial: float = 0.0, **options) -> gb.RotorSystem:
    return gb.RotorSystem(
        shafts=[
            gb.Shaft(
                "rotor", length=0.5, outer_diameter=0.09, elements=4, bow=gb.Bow.half_sine(2e-5)
            )
        ],
        disks=[
            gb.Disk(
                "disk",
                "rotor",
                0.2,
                mass=20.0,
                diametral_inertia=0.1,
                polar_inertia=0.2,
                unbalance=1e-4,
            )
        ],
        bearings=bearings,
        forces=[gb.Force("disk", axial=axial)] if axial else [],
        gravity=(0.0, -9.81),
        **options,
    )


def indices(system: gb.RotorSystem, position: float) -> list[int]:
    """Indices of (u, v, w, B, Γ) of the node of the rotor."""
    index = {(shaft, at, name): i for i, (shaft, at, name) in enumerate(system.dofs)}
    return [index["rotor", position, name] for name in ("u", "v", "w", "B", "G")]


def test_218_bearing_carries_a_thrust_in_a_system():
    """Harris prints the contact angle 41.6°, 1676 N on a ball and a displacement of 0.0385 mm."""
    system = gb.RotorSystem(
        shafts=[gb.Shaft("rotor", length=0.1, outer_diameter=0.09, elements=2)],
        bearings=[B218],
        forces=[gb.Force(("rotor", 0.05), axial=17800.0)],
    )
    static = system.static(speed=100.0)
    assert 1e3 * static.axial(("rotor", 0.05)) == pytest.approx(0.0385, abs=3e-4)
    assert static.axial_bearing_force(("rotor", 0.05)) == pytest.approx(17800.0, rel=1e-9)
    run = system.simulate(1e-3, speed=100.0, record=[("bearing", "rotor", 0.05)])
    contact = run.rolling(("rotor", 0.05))
    assert contact.largest_contact_force == pytest.approx(1676.0, abs=2.0)
    assert np.all(contact.loaded_elements == 16)
    # The thrust bends nothing: the equilibrium is that of the closed form.
    alone = B218.ring_coefficients(0.0, thrust=17800.0).displacement[0]
    assert static.axial(("rotor", 0.05)) == pytest.approx(alone, rel=1e-9)


def test_the_cage_turns_with_the_mean_of_the_races():
    # An element rolls on both races, whose radii are D/2 ∓ d/2 cos α, and the outer race stands.
    for bearing in (B218, TAPERED, DEEP_GROOVE):
        half = 0.5 * bearing.element_diameter * math.cos(bearing.contact_angle)
        inner_race = 0.5 * bearing.pitch_diameter - half
        assert bearing.cage_order == pytest.approx(inner_race / bearing.pitch_diameter, rel=1e-14)


@pytest.mark.parametrize("bearing", [B218, TAPERED, DEEP_GROOVE], ids=["ball", "roller", "groove"])
@pytest.mark.parametrize("sense", [1, -1])
def test_static_forces_are_those_of_the_average_over_the_cage(bearing, sense):
    bearings = [replace(one, axial_preload=400.0) for one in (bearing, opposite(bearing, 0.45))]
    system = rotor(*bearings, axial=3000.0)
    static = system.static(speed=300.0 * sense)
    assert static.residual < 1e-9
    forces = []
    for one in bearings:
        place = ("rotor", one.position)
        found = np.array([static.axial_bearing_force(place), *static.bearing_force(place)])
        wanted = Ring(one).mean(static.state[indices(system, one.position)])[:3]
        # The sum over 200,000 angles has an error of 1e-6 where the loaded zone of rollers ends.
        assert found == pytest.approx(wanted, abs=1e-5 * np.abs(wanted).max())
        forces.append(found)
    total = np.sum(forces, axis=0)
    weight = 9.81 * system.mass_properties().total_mass
    assert total == pytest.approx([3000.0, 0.0, -weight], abs=1e-6 * weight)


@pytest.mark.parametrize("bearing", [B218, TAPERED], ids=["ball", "roller"])
def test_matrices_contain_the_derivatives_at_the_equilibrium(bearing):
    bearings = [replace(one, axial_preload=2000.0) for one in (bearing, opposite(bearing, 0.45))]
    system = rotor(*bearings, axial=1000.0)
    plain = replace_bearings(system, stiffness=0.0)
    own, none = (one.matrices(200.0).stiffness for one in (system, plain))
    added, static = own - none, system.static(speed=200.0)
    for one in bearings:
        x, ring = static.state[indices(system, one.position)], Ring(one)
        steps = np.array([1e-8, 1e-8, 1e-8, 1e-7, 1e-7])
        wanted = np.array(
            [
                (ring.mean(x + h * row) - ring.mean(x - h * row)) / (2 * h)
                for h, row in zip(steps, np.eye(5), strict=True)
            ]
        )
        index = indices(system, one.position)
        found = added[np.ix_(index, index)]
        scale = np.sqrt(np.outer(np.diag(wanted), np.diag(wanted)))
        # Differences over 1e-8 m of displacements of 1e-5 m, second order.
        assert np.abs((found - wanted) / scale).max() < 2e-4


def replace_bearings(system: gb.RotorSystem, stiffness: float) -> gb.RotorSystem:
    """The system with linear bearings that keep its coordinates."""
    plain = [
        gb.Bearing(one.shaft, one.position, stiffness=stiffness, axial_stiffness=1.0)
        for one in system.bearings
    ]
    return system.replace(bearings=plain)


@pytest.mark.parametrize("bearing", [B218, TAPERED, DEEP_GROOVE], ids=["ball", "roller", "groove"])
def test_methods_agree_and_the_energy_balances(bearing):
    bearings = [replace(one, axial_preload=500.0) for one in (bearing, opposite(bearing, 0.45))]
    system = rotor(*bearings, axial=2000.0)
    request = {"speed": 500.0, "record": ["disk", "energy", ("bearing", "rotor", 0.05)]}
    exact = system.simulate(0.01, method="rk45", rtol=1e-9, **request)
    run = system.simulate(0.01, rtol=1e-7, **request)
    place = ("rotor", 0.05)
    for name in ("displacement", "axial"):
        found, wanted = (getattr(one, name)("disk") for one in (run, exact))
        # Ten times the tolerance: it holds for a step, and contacts open and close.
        assert np.abs(found - wanted).max() < 1e-6 * np.abs(wanted).max()
    for name in ("bearing_force", "axial_bearing_force"):
        found, wanted = (getattr(one, name)(place) for one in (run, exact))
        # The stiffness of the contact raises errors of displacements.
        assert np.abs(found - wanted).max() < 1e-5 * np.abs(wanted).max()
    for one, limit in ((run, 1e-6), (exact, 1e-6)):
        assert np.abs(one.energy_balance().residual).max() < limit


def test_a_run_starts_with_the_forces_of_the_balls_at_their_places():
    """The equilibrium has the mean force; a run has that of each ball at the angle of the cage."""
    bearing = replace(B218, phase=0.1, elements=3)
    system = rotor(bearing, opposite(B218, 0.45), axial=4000.0)
    # The bow and the unbalance would turn the shaft away from its equilibrium.
    system = system.replace(
        shafts=[replace(system.shafts[0], bow=None)],
        disks=[replace(system.disks[0], unbalance=0.0)],
    )
    place, static = ("rotor", 0.05), system.static(speed=400.0)
    run = system.simulate(1e-4, speed=400.0, record=[("bearing", "rotor", 0.05)])
    wanted = Ring(bearing).force(static.state[indices(system, 0.05)], 0.0)[:3]
    found = np.array([run.axial_bearing_force(place)[0], *run.bearing_force(place)[0]])
    assert found == pytest.approx(wanted, abs=1e-9 * np.abs(wanted).max())
    mean = np.array([static.axial_bearing_force(place), *static.bearing_force(place)])
    assert np.abs(found - mean).max() > 1e-6 * np.abs(mean).max()


def test_a_mirrored_machine_moves_in_the_mirror():
    """Reversing the axis of the shaft reverses contact angles, axial forces and motions along the axis."""
    bearings = [replace(one, axial_preload=300.0) for one in (B218, opposite(TAPERED, 0.45))]
    system = rotor(*bearings, axial=2500.0)
    mirrored = system.replace(
        disks=[replace(system.disks[0], position=0.3)],
        bearings=[opposite(one, 0.5 - one.position) for one in bearings],
        forces=[gb.Force("disk", axial=-2500.0)],
    )
    runs = [
        one.simulate(5e-3, speed=300.0, record=["disk"], rtol=1e-8) for one in (system, mirrored)
    ]
    lateral, along = (
        [getattr(run, name)("disk") for run in runs] for name in ("displacement", "axial")
    )
    # Both have the tolerance of the runs, times their number of steps.
    assert lateral[0] == pytest.approx(lateral[1], abs=1e-6 * np.abs(lateral[0]).max())
    assert along[0] == pytest.approx(-along[1], abs=1e-6 * np.abs(along[0]).max())


@pytest.mark.parametrize("support", ["housing", "shaft"])
def test_a_rigid_base_is_the_ground(support):
    """A ring on a housing, or between two shafts, moves with what it stands on."""
    bearings = [replace(one, axial_preload=400.0) for one in (B218, opposite(B218, 0.45))]
    ground = rotor(*bearings, axial=1500.0)
    if support == "housing":
        base = {
            "housings": [
                gb.Housing(
                    "case",
                    mass=500.0,
                    inertia=(50.0, 50.0, 50.0),
                    stiffness=1e15,
                    axial_stiffness=1e15,
                    rotational_stiffness=(1e15, 1e15, 1e15),
                    points={"front": (0.05, 0.0, 0.0), "rear": (0.45, 0.0, 0.0)},
                )
            ]
        }
        system = ground.replace(bearings=[replace(one, support="case") for one in bearings], **base)
    else:
        sleeve = gb.Shaft(
            "sleeve",
            length=0.5,
            outer_diameter=0.3,
            inner_diameter=0.2,
            elements=4,
            speed_ratio=-0.5,
        )
        holds = [
            gb.Bearing("sleeve", x, stiffness=1e13, axial_stiffness=1e13, tilting_stiffness=1e13)
            for x in (0.05, 0.45)
        ]
        on_sleeve = [replace(one, support=("sleeve", one.position)) for one in bearings]
        system = ground.replace(shafts=[*ground.shafts, sleeve], bearings=[*on_sleeve, *holds])
    wanted, found = (one.static(speed=100.0) for one in (ground, system))
    for one in bearings:
        place = ("rotor", one.position)
        assert found.axial_bearing_force(place) == pytest.approx(
            wanted.axial_bearing_force(place), rel=1e-4
        )
        assert found.bearing_force(place) == pytest.approx(
            wanted.bearing_force(place), rel=1e-4, abs=1e-3
        )


def test_a_slow_force_finds_the_derivatives_of_the_equilibrium():
    """The frequency response at 1e-3 rad/s is the change of the static forces of bearings."""
    bearings = [replace(one, axial_preload=3000.0) for one in (B218, opposite(B218, 0.45))]
    system = rotor(*bearings)
    response = system.frequency_response(
        [1e-3], source=[gb.Force("disk", 1.0), gb.Force("disk", 1.0j)]
    )
    step = 1.0
    for axis, force in enumerate((step, 1j * step)):
        after, before = (
            system.replace(forces=[gb.Force("disk", sign * force)]).static() for sign in (1, -1)
        )
        for one in bearings:
            place = ("rotor", one.position)
            wanted = (after.bearing_force(place) - before.bearing_force(place)) / (2 * step)
            found = response.bearing_force(place)[0, axis].real
            assert found == pytest.approx(wanted, abs=1e-5)


@each_case(
    ("given", "message"),
    [
        ({"degrees_of_freedom": 3}, "bearings[0].degrees_of_freedom: must be 2"),
        ({"axial_preload": -1.0}, "bearings[0].axial_preload: "),
        (
            {"degrees_of_freedom": 2, "axial_preload": 100.0},
            "bearings[0].axial_preload: needs degrees_of_freedom = 5",
        ),
        ({"axial_stiffness": 1e7}, "bearings[0].axial_stiffness: follows from"),
        ({"tilting_stiffness": 1e3}, "bearings[0].tilting_stiffness: follows from"),
    ],
)
def test_an_impossible_ring_is_refused(given, message):
    with pytest.raises(gb.SceneError, match=re.escape(message)):
        rotor(replace(B218, **given))


def test_deep_groove_bearings_are_preloaded_against_each_other():
    """With the contact angle 0, the sign of the preload gives its direction."""
    pair = [
        replace(DEEP_GROOVE, position=x, axial_preload=preload)
        for x, preload in ((0.05, 600.0), (0.45, -600.0))
    ]
    static = rotor(*pair).static(speed=10.0)
    forces = [static.axial_bearing_force(("rotor", one.position)) for one in pair]
    assert sum(forces) == pytest.approx(0.0, abs=1e-6)
    assert forces[0] > 500.0


def test_a_lifted_bearing_is_found_again():
    """A tapered bearing whose preload nothing opposes lifts, until the thrust of the radial load presses it again."""
    groove = replace(DEEP_GROOVE, position=0.45, clearance=0.0)
    system = rotor(replace(TAPERED, axial_preload=100.0), groove)
    static = system.static(speed=100.0)
    assert static.residual < 1e-9
    thrust = [static.axial_bearing_force(("rotor", x)) for x in (0.05, 0.45)]
    assert sum(thrust) == pytest.approx(0.0, abs=1e-6)
    assert thrust[0] > 0.0


def test_radial_rollers_take_no_preload():
    with pytest.raises(gb.SceneError, match=r"bearings\[0\].axial_preload: cannot press rollers"):
        rotor(replace(TAPERED, contact_angle=0.0, axial_preload=10.0))


def test_lateral_motion_excludes_rings():
    with pytest.raises(gb.SceneError, match=r'motion: "lateral" has no axial motion'):
        rotor(B218, opposite(B218, 0.45), motion="lateral")


def test_a_single_contact_that_is_not_loaded_has_no_equilibrium():
    """A thrust against the direction of the contact pushes the shaft out of its bearings."""
    with pytest.raises(gb.ConvergenceError, match="no static equilibrium"):
        rotor(B218, replace(B218, position=0.45), axial=-2000.0).static(speed=10.0)


def test_a_scene_file_keeps_the_ring(tmp_path):
    system = rotor(replace(B218, axial_preload=200.0), opposite(B218, 0.45))
    system.save(tmp_path / "ring.toml")
    again = gb.RotorSystem.load(tmp_path / "ring.toml")
    assert again.bearings[0].degrees_of_freedom == 5
    assert again.bearings[0].axial_preload == 200.0
    assert again == system or again.bearings == system.bearings


def test_a_preload_in_another_unit_is_implausible():
    with pytest.warns(gb.SceneWarning, match=r"bearings\[0\].axial_preload: axial preload over"):
        rotor(replace(B218, axial_preload=2e6), opposite(B218, 0.45))
