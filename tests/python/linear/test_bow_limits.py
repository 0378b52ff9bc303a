"""Limits of the bow: closed forms of rigid shafts, and simulations 2 % below and above each limit."""

from __future__ import annotations

import math
from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy.optimize import brentq

import gearbow as gb
from gearbow.analysis.bow_motion import BowMotion
from reference.cases import each_case
from reference.machines import (
    bowed_pair,
    distance_without_play,
    hostile,
    inertia,
    pair,
    rotor,
    rotor_on_films,
)
from test_profile_shift import Teeth

MESH = {"stiffness": 2e8, "damping_ratio": 0.05}
BACKLASH = 1.5e-4


def rigid_pair(helix: float = 0.0) -> gb.RotorSystem:
    """Build a pair without load that does not deform at low speed."""
    bearing = {"stiffness": 1e12, "damping": 1e4, "axial_stiffness": 1e12 if helix else 0.0}
    own = {"input": {"bow": gb.Bow.half_sine(1e-5)}}
    own |= {"g1": {"helix_angle": helix}, "g2": {"helix_angle": -helix}}
    mesh = {**MESH, "backlash": BACKLASH}
    return pair(own=own, mesh=mesh, bearing=bearing, torque=0.0)


def bent(system: gb.RotorSystem, amplitude: float, name: str = "input") -> gb.RotorSystem:
    """Give a shaft a half sine."""
    bow = gb.Bow.half_sine(amplitude)
    shafts = [replace(s, bow=bow) if s.name == name else s for s in system.shafts]
    return system.replace(shafts=shafts)


def limit(found: gb.results.BowLimits, name: str) -> gb.results.ReachedLimit:
    """Find a limit by name."""
    return next(one for one in found.limits if one.limit == name)


def approach(backlash: float, helix: float) -> float:
    """Solve j = m_t (z₁ + z₂) cos α_t cos β_b (inv α_w − inv α_w') for the approach."""
    transverse = math.atan(math.tan(math.radians(20.0)) / math.cos(helix))
    base = math.asin(math.sin(helix) * math.cos(math.radians(20.0)))
    pitch = 3e-3 / math.cos(helix) * 75

    def involute(angle: float) -> float:
        return math.tan(angle) - angle

    low, high = 0.0, transverse
    for _ in range(200):
        angle = (low + high) / 2.0
        left = backlash - pitch * math.cos(transverse) * math.cos(base) * (
            involute(transverse) - involute(angle)
        )
        low, high = (low, angle) if left > 0.0 else (angle, high)
    return pitch / 2.0 * (1.0 - math.cos(transverse) / math.cos(angle))


@pytest.mark.parametrize("helix", [0.0, math.radians(20.0)])
def test_the_backlash_of_rigid_shafts_is_used_up_at_the_approach_of_the_involutes(helix: float):
    found = limit(rigid_pair(helix).bow_limits("input", 1.0), "backlash used up")
    # The bearings of 1e12 N/m and 72 instants a turn, of which one points to the other gear
    assert found.bow == pytest.approx(approach(BACKLASH, helix), rel=2e-4)
    assert found.bow == pytest.approx(first_order(BACKLASH, helix), rel=0.01)


def first_order(backlash: float, helix: float) -> float:
    """Give j/(2 sin α_wt cos β_b)."""
    transverse = math.atan(math.tan(math.radians(20.0)) / math.cos(helix))
    base = math.asin(math.sin(helix) * math.cos(math.radians(20.0)))
    return backlash / (2.0 * math.sin(transverse) * math.cos(base))


def test_the_bows_at_both_gears_share_the_backlash():
    system = rigid_pair()
    other = 4e-5
    shared = limit(bent(system, other, "output").bow_limits("input", 1.0), "backlash used up")
    alone = limit(system.bow_limits("input", 1.0), "backlash used up")
    # 36 phases and 72 instants meet the worst one to 1 − cos 5° of the bows
    assert shared.bow + other == pytest.approx(alone.bow, rel=5e-3)
    together = system.bow_limits(["input", "output"], 1.0, shape=gb.Bow.half_sine(1.0))
    # speeds 2:1: after half a turn of the output shaft the bows point to each other and apart
    assert limit(together, "backlash used up").bow <= 0.61 * alone.bow


@pytest.mark.parametrize("speed", [100.0, -100.0])
def test_limits_of_helical_teeth_are_those_of_the_extreme_centre_distances(speed: float):
    """No two speeds have a common period, so that all angles of the shafts meet.

    The centres then reach every point of a sum of ellipses. It is convex, and its extreme distances
    are those of a support function.
    """
    system, mesh = hostile(), ("g4", "g5")
    ratio = gb.BowLimit.contact_ratio(mesh, 2.0)
    found = system.bow_limits("middle", speed, limits=[ratio], phase=0.0)
    gears = [next(gear for gear in system.gears if gear.name == name) for name in mesh]
    teeth = Teeth(
        (gears[0].teeth, gears[1].teeth),
        (gears[0].profile_shift, gears[1].profile_shift),
        3e-3,
        abs(gears[0].helix_angle),
    )
    width = min(gear.face_width for gear in gears)
    tips, roots = (
        [r + 3e-3 * (x + depth) for r, x in zip(teeth.radii, teeth.shifts, strict=True)]
        for depth in (1.0, -1.25)
    )
    reached = {
        "tips touch roots": max(tips[0] + roots[1], tips[1] + roots[0]),
        "contact ratio": brentq(lambda a: teeth.contact_ratio(a, width) - 2.0, 0.126, 0.13),
    }
    static = system.static(speed)
    at_rest = static.displacement("g5") - static.displacement("g4")
    angle = system.meshes[2].centre_line_angle
    distance = distance_without_play(*gears)
    at_rest = at_rest + distance * np.array([np.cos(angle), np.sin(angle)])
    angles = np.linspace(0.0, 2.0 * np.pi, 20001)
    directions = np.array([np.cos(angles), np.sin(angles)])
    for name, expected in reached.items():
        own = next(
            one
            for one in found.limits
            if (one.limit, one.at) == (name, "g4/g5") and one.why != "contact ratio below 1"
        )
        bow = gb.Bow.half_sine(own.bow, phase=-2.0)
        shafts = [replace(s, bow=bow) if s.name == "middle" else s for s in system.shafts]
        moved = system.replace(shafts=shafts).synchronous([speed])
        ellipses = (moved.displacement("g5") - moved.displacement("g4"))[0]
        reach = np.abs(ellipses @ directions).sum(axis=0)
        extreme = {
            "tips touch roots": (at_rest @ directions - reach).max(),
            "contact ratio": (at_rest @ directions + reach).max(),
        }
        # 72 instants of a turn meet the extreme of an ellipse to 1 - cos 2.5° of its size
        assert abs(extreme[name] - expected) < 1e-3 * reach.max(), name


@pytest.mark.parametrize(
    ("name", "event"),
    [
        ("backlash used up", "tight"),
        ("tips touch roots", "tip interference"),
        ("involutes end", "involute interference"),
        ("contact ratio", "contact ratio below 1"),
    ],
)
def test_a_simulation_reaches_a_limit_of_the_teeth_above_it_and_not_below(name: str, event: str):
    # the damping ends the transient within a few turns
    damped = {"bearing": {"stiffness": 1e8, "damping": 1e4}, "modal_damping": 0.05}
    system, speed = bowed_pair(mesh={**MESH, "backlash": BACKLASH}, **damped), 150.0
    found = limit(system.bow_limits("input", speed), name)
    if name != "backlash used up":
        # flanks that jam would keep the gears apart
        system = system.replace(meshes=[replace(system.meshes[0], backlash=None)])
    turn = 2.0 * math.pi / speed
    for part, reached in ((0.98, False), (1.02, True)):
        bow_system = bent(system, part * found.bow)
        warned = (
            pytest.warns(gb.AccuracyWarning, match='"g1" and "g2" falls below 1 at 0.0')
            if reached and name == "contact ratio"
            else nullcontext()
        )
        with warned:
            run = bow_system.simulate(8 * turn, speed, output_step=turn / 50)
        events = {one.kind for one in run.events if one.time > 4 * turn}
        assert (event in events) == reached, (part, events)


def test_a_simulation_reaches_the_limits_of_probes_and_bearings():
    system, speed, bearing = bowed_pair(mesh=MESH), 150.0, ("input", 0.0)
    probe, capacity = ("input", 0.25), 44e3
    given = [
        gb.BowLimit.displacement(probe, "ISO 20816-3 B/C"),
        gb.BowLimit.velocity("g2", 2e-3),
        gb.BowLimit.bearing_force(bearing, 4e3),
        gb.BowLimit.bearing_life(bearing, 20e3, capacity=capacity, exponent=3.0),
    ]
    found = system.bow_limits("input", speed, limits=given, phase=0.0)
    rpm = speed * 30.0 / math.pi
    angles = np.radians(np.arange(180.0))
    directions = np.array([np.cos(angles), np.sin(angles)])

    def values(bow: float) -> dict[str, float]:
        run = (
            bent(system, bow)
            .steady_state(
                speed,
                record=[probe, "g2", "velocity", ("bearing", *bearing)],
                output_step=2.0 * math.pi / speed / 360,
                geometry="frozen",
            )
            .response
        )
        force = np.hypot(*run.bearing_force(bearing).T)[:-1]
        mean = np.mean(force**3) ** (1 / 3)
        return {
            "displacement": np.ptp(run.displacement(probe) @ directions, axis=0).max()
            / 9000e-6
            * rpm**0.5,
            "velocity": np.linalg.eigvalsh(np.cov(run.velocity("g2")[:-1].T)).max() ** 0.5 / 2e-3,
            "bearing force": force.max() / 4e3,
            "bearing life": 20e3 * 60.0 * rpm / 1e6 * (mean / capacity) ** 3,
        }

    for one in found.limits:
        if one.limit in ("displacement", "velocity", "bearing force", "bearing life"):
            below, above = (values(part * one.bow)[one.limit] for part in (0.98, 1.02))
            assert below < 1.0 < above, one


def test_a_steady_state_reaches_the_limit_of_the_mesh_force():
    system = bowed_pair(mesh=MESH)
    added = gb.BowLimit.mesh_force("g1/g2", 1.01)
    found = limit(system.bow_limits("input", 300.0, limits=[added]), "mesh force")
    static = system.static().mesh("g1/g2").force
    for part, reached in ((0.98, False), (1.02, True)):
        steady = bent(system, part * found.bow).steady_state(300.0)
        assert (steady.response.mesh("g1/g2").force.max() > 1.01 * static) == reached


def test_a_steady_state_reaches_the_limit_of_the_oil_film():
    disk = gb.Disk("d", "r", 0.25, **inertia(40.0, 0.5, 0.3))
    system, bearing = rotor_on_films(disks=[disk]), ("r", 0.0)
    found = system.bow_limits("r", 200.0, limits=[gb.BowLimit.film(bearing, 1.5e-5)], phase=0.0)
    for part, reached in ((0.98, False), (1.02, True)):
        bow = part * found.limits[0].bow
        steady = bent(system, bow, "r").steady_state(200.0, record=["bearings"])
        ratio = steady.response.journal(bearing).eccentricity_ratio.max()
        assert (5e-5 * (1.0 - ratio) < 1.5e-5) == reached


def on_rolling_bearings(**more: object) -> gb.RotorSystem:
    """Build a pair on ball bearings with a radial gap of 10 µm; the input shaft is on a pedestal."""
    size = {"elements": 9, "element_diameter": 0.0127, "pitch_diameter": 0.065, "clearance": 2e-5}
    system = bowed_pair(mesh=MESH)
    bearings = [
        gb.RollingBearing(
            each.shaft,
            each.position,
            damping=300.0,
            support="pedestal" if each.shaft == "input" else None,
            **size,
        )
        for each in system.bearings
    ]
    pedestal = gb.Support("pedestal", mass=10.0, stiffness=1e8, damping=1e3)
    return system.replace(bearings=bearings, supports=[pedestal], **more)


def test_a_shaft_moves_through_the_clearance_of_a_rolling_bearing():
    """The displacement relative to the pedestal reaches the gap of 10 µm and the approach."""
    system, speed, bearing, approach = on_rolling_bearings(), 150.0, ("input", 0.0), 4e-5
    given = [gb.BowLimit.clearance(bearing, approach)]
    found = limit(system.bow_limits("input", speed, limits=given, phase=0.0), "clearance")

    def largest(bow: float) -> float:
        bow_system = bent(system, bow)
        static, turning = bow_system.static(speed), bow_system.synchronous(speed)
        phasor = turning.displacement(bearing) - turning.displacement("pedestal")
        turns = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 361))
        rest = static.displacement(bearing) - static.displacement("pedestal")
        return np.hypot(*(rest[:, None] + np.real(phasor[0, 0][:, None] * turns))).max()

    assert largest(0.98 * found.bow) < 1e-5 + approach < largest(1.02 * found.bow)


@pytest.mark.parametrize(("speed", "missed", "met"), [(270.0, 0.9, 1.2), (390.0, 0.5, 0.8)])
def test_a_run_reaches_the_clearance_earlier_where_twice_the_speed_is_a_natural_frequency(
    speed: float, missed: float, met: float
):
    """One ball bearing carries a disk; its contacts vibrate at twice the speed, 822 rad/s being natural."""
    size = {"elements": 9, "element_diameter": 0.0127, "pitch_diameter": 0.065, "clearance": 2e-5}
    system = rotor(
        {"name": "input", "length": 0.6, "outer_diameter": 0.06},
        gravity=9.81,
        disks=[gb.Disk("d", "input", 0.25, 30.0, 0.1, 0.2)],
        bearings=[
            gb.RollingBearing("input", 0.0, damping=1e3, **size),
            gb.Bearing("input", 0.6, stiffness=1e8, damping=1e3),
        ],
    )
    bearing, approach, turn = ("input", 0.0), 1e-5, 2.0 * math.pi / speed
    given = [gb.BowLimit.clearance(bearing, approach)]
    found = limit(bent(system, 1e-5).bow_limits("input", speed, limits=given), "clearance")
    for part, reached in ((missed, False), (met, True)):
        run = bent(system, part * found.bow).simulate(
            50 * turn, speed, record=[bearing], output_step=turn / 60
        )
        moved = run.displacement(bearing)[run.time > 35 * turn]
        assert (np.hypot(*moved.T).max() > 1e-5 + approach) == reached


def test_the_worst_phase_is_the_worst_of_all_phases():
    disk = inertia(20.0, 0.2, 0.3, unbalance=1e-3)
    system = rotor(disk=disk, bearing={"stiffness": 1e7, "damping": 1e3})
    probe = gb.BowLimit.displacement("disk", 2e-4)
    worst = system.bow_limits("rotor", 150.0, limits=[probe])
    bows = [
        system.bow_limits("rotor", 150.0, limits=[probe], phase=phase).limits[0].bow
        for phase in np.linspace(0.0, 2.0 * np.pi, 73)
    ]
    # the given phases are twice as fine
    assert worst.limits[0].bow == pytest.approx(min(bows), rel=5e-3)
    assert min(bows) < 0.9 * max(bows)
    at = system.bow_limits("rotor", 150.0, limits=[probe], phase=worst.limits[0].phase)
    assert at.limits[0].bow == pytest.approx(worst.limits[0].bow, rel=1e-9)


def test_phases_of_several_shafts_are_searched_until_none_improves():
    def margin(_: float, phases: np.ndarray) -> np.ndarray:
        first, second = phases.T
        return 3.0 - np.cos(first - second) - np.cos(first - 2.0) - np.cos(second - 2.0)

    motion: Any = SimpleNamespace(
        variants=SimpleNamespace(phases=None), _bowed=[0, 1], _free=[0, 1]
    )
    smallest, phases = BowMotion.worst(motion, margin, 1.0)
    # one pass leaves 0.7; both phases come within two of their 36 steps of 2 rad, where it is 0
    assert smallest < 0.1
    assert np.abs(phases - 2.0).max() < 0.4


def test_limits_that_are_not_reached_say_why():
    straight = rigid_pair().replace(meshes=[gb.Mesh("g1", "g2", **MESH)])
    found = limit(straight.bow_limits("input", 1.0), "backlash used up")
    assert (found.bow, found.why) == (math.inf, "the mesh has no backlash")
    unloaded = rigid_pair().bow_limits("input", 1.0, limits=[gb.BowLimit.mesh_force("g1/g2", 1.5)])
    found = limit(unloaded, "mesh force")
    assert (found.bow, found.why) == (math.inf, "the mesh carries no static force")
    probe = gb.BowLimit.displacement("g2", 1e-4)
    still = bowed_pair(mesh=MESH).bow_limits("input", 10.0, limits=[probe])
    assert limit(still, "displacement").is_reached
    unbalanced = rotor(disk=inertia(20.0, 0.2, 0.3, unbalance=1e-1))
    probe = gb.BowLimit.displacement("disk", 1e-6)
    found = unbalanced.bow_limits("rotor", 100.0, limits=[probe])
    assert found.deciding is not None
    assert (found.deciding.bow, found.margin) == (0.0, 0.0)
    assert found.deciding.why.endswith("exceeded without this bow")
    empty = rotor().bow_limits("rotor", 10.0)
    assert empty.deciding is None
    assert "none" in str(empty)


def test_the_table_has_the_worst_speed_and_the_frame_all_of_them():
    found = bowed_pair(mesh={**MESH, "backlash": BACKLASH}).bow_limits("input", gb.rpm([600, 1500]))
    printed = str(found)
    assert printed.startswith("limits of the bow of input at 600 rpm to 1500 rpm, worst phase")
    assert printed.endswith(f"at {1e6 * found.deciding.bow:.4g} µm")
    assert "phase [°]  why" in printed
    frame = found.to_dataframe()
    assert len(frame) == 8
    assert frame["bow [m]"].min() == found.deciding.bow
    assert np.allclose(frame["margin [m]"], frame["bow [m]"] - 1e-4)
    assert isinstance(found.plot(), Figure)
    assert "decides: backlash used up" in repr(found)


@each_case(
    ("message", "given"),
    [
        ("shaft: must be one of input, output", {"shaft": "middle"}),
        ("shaft: name at least one shaft", {"shaft": []}),
        ("shape: the amplitude must be positive", {"shape": gb.Bow.half_sine(0.0)}),
        (r"limits\[0\]: must be a gb.BowLimit", {"limits": [1.0]}),
        ("no mesh of 'g1' with 'g3'", {"limits": [gb.BowLimit.contact_ratio("g1/g3", 1.2)]}),
        ("no journal bearing", {"limits": [gb.BowLimit.film(("input", 0.0), 1e-5)]}),
        ("is no RollingBearing", {"limits": [gb.BowLimit.clearance(("input", 0.0), 1e-5)]}),
    ],
)
def test_wrong_arguments(message: str, given: dict):
    with pytest.raises(gb.GearbowError, match=message):
        bowed_pair(mesh=MESH).bow_limits(**{"shaft": "input", "speed": 10.0, **given})


@each_case(("message", "value"), [("must be positive", -1.0), ("must be one of ISO", "API 618")])
def test_wrong_limits(message: str, value: object):
    with pytest.raises(gb.SceneError, match=message):
        gb.BowLimit.displacement("g1", value)


# --- everything that turns -------------------------------------------------------------------------


def rigid_gears(
    teeth: tuple[int, int], position: float | None = None, **own: dict
) -> gb.RotorSystem:
    """Build an unloaded pair with bows of both shafts that does not deform at low speed."""
    shapes = {name: {"bow": gb.Bow.half_sine(1e-5)} for name in ("input", "output")}
    bearing = {"stiffness": 1e12, "damping": 1e4}
    mesh = {**MESH, "backlash": BACKLASH}
    return pair(
        ("input", "output"),
        ("g1", "g2"),
        teeth,
        own={**shapes, **own},
        mesh=mesh,
        bearing=bearing,
        torque=0.0,
        position=position,
    )


def used_up(system: gb.RotorSystem, shaft: object = ("input", "output"), **how: object) -> float:
    """Give the bow at which the backlash is used up."""
    return limit(system.bow_limits(shaft, 1.0, **how), "backlash used up").bow


def test_the_run_out_of_gears_uses_up_its_part_of_the_backlash():
    # The centres approach by bow and run-out: a phase of 36 and an instant of 72 meet the worst one
    # to 0.5 % of both.
    straight = rigid_gears((25, 50), output={"bow": None})
    wanted = used_up(straight, "input")
    for gear in ("g1", "g2"):
        own = {gear: {"runout": 4e-5 * np.exp(0.7j)}, "output": {"bow": None}}
        bow = used_up(rigid_gears((25, 50), **own), "input")
        assert bow + 4e-5 == pytest.approx(wanted, rel=5e-3), gear


@pytest.mark.parametrize("source", ["runout", "error"])
def test_a_simulation_with_eccentric_gears_jams_above_the_limit_and_not_below(source: str):
    damped = {"bearing": {"stiffness": 1e8, "damping": 1e4}, "modal_damping": 0.05}
    mesh, own = {**MESH, "backlash": BACKLASH}, {}
    if source == "runout":
        own = {"g1": {"runout": 3e-5j}, "g2": {"runout": 2e-5}}
    else:
        mesh["error"] = gb.TransmissionError(driver=[(3e-5, 0.4)], driven=[(2e-5, 1.0)])
    system, speed = pair(own={"input": {}, **own}, mesh=mesh, **damped), 150.0
    shape = gb.Bow.half_sine(1e-4)
    found = limit(system.bow_limits("input", speed, shape=shape, phase=0.0), "backlash used up")
    turn = 2.0 * math.pi / speed
    for part, reached in ((0.97, False), (1.03, True)):
        run = bent(system, part * found.bow).simulate(8 * turn, speed, output_step=turn / 50)
        jams = any(one.kind == "tight" and one.time > 4 * turn for one in run.events)
        assert jams == reached, part


@pytest.mark.parametrize("teeth", [(49, 50), (24, 25), (25, 49)])
def test_bows_of_hunting_shafts_meet_in_every_position(teeth: tuple[int, int]):
    # Each pair of tooth numbers has another centre distance: the judge is the pair with one bow.
    system = rigid_gears(teeth)
    alone = used_up(rigid_gears(teeth, output={"bow": None}), "input")
    # 24/25 meets to half of 15°, 0.9 %; the limit is that of the closest position.
    for phase in (None, 0.0, [1.0, 4.0]):
        assert 2.0 * used_up(system, phase=phase) == pytest.approx(alone, rel=0.01), phase


def test_each_named_shaft_has_its_own_worst_phase():
    system = rigid_gears((25, 25))
    alone = used_up(rigid_gears((25, 25), output={"bow": None}), "input")
    both = system.bow_limits(("input", "output"), 1.0)
    assert "phase input [°]  phase output [°]  why" in str(both)
    found = limit(both, "backlash used up")
    assert 2.0 * found.bow == pytest.approx(alone, rel=5e-3)
    # At equal and opposite speeds the bows point to each other once in a turn or never: 0.4 % for
    # the instants and phases.
    assert used_up(system, phase=list(found.phases)) == pytest.approx(found.bow, rel=5e-3)
    assert used_up(system, phase=[0.0, math.pi]) == pytest.approx(found.bow, rel=5e-3)
    assert math.isinf(used_up(system, phase=0.0))
    # Another source that hardly excites changes nothing.
    nearly = rigid_gears((25, 25), g1={"unbalance": 1e-12})
    assert used_up(nearly) == pytest.approx(found.bow, rel=5e-3)
    with pytest.raises(gb.SceneError, match="one for each of the 2 shafts"):
        system.bow_limits(("input", "output"), 1.0, phase=[0.0, 1.0, 2.0])


def test_turning_forces_are_no_part_of_the_bow():
    force = gb.Force(("input", 0.3), 50.0, order=1)
    system = bowed_pair(mesh=MESH, forces=[force])
    probe = gb.BowLimit.displacement(("input", 0.25), 2e-4)
    found = limit(system.bow_limits("input", 100.0, limits=[probe], phase=0.0), "displacement")
    orbit = bent(system, found.bow).synchronous(100.0).displacement(("input", 0.25))[0]
    turns = np.exp(1j * np.outer(np.linspace(0.0, 4.0 * np.pi, 721), system.speed_ratios))
    angles = np.radians(np.arange(180.0))
    moved = np.real(turns @ orbit) @ np.array([np.cos(angles), np.sin(angles)])
    assert np.ptp(moved, axis=0).max() == pytest.approx(2e-4, rel=2e-3)


def test_loads_at_places_of_their_own_keep_their_nodes():
    loads = {
        "torques": [gb.Torque(("input", 0.01), 200.0), gb.Torque.balance("g2")],
        "forces": [gb.Force(("output", 0.013), 10.0)],
    }
    mesh = {**MESH, "backlash": BACKLASH}
    found = bowed_pair(mesh=mesh, **loads).bow_limits("input", 100.0)
    assert limit(found, "backlash used up").is_reached


def test_the_life_of_a_bearing_between_shafts_counts_relative_turns():
    shafts = [
        gb.Shaft("inner", length=1.0, outer_diameter=0.03),
        gb.Shaft("outer", length=0.6, outer_diameter=0.1, inner_diameter=0.08, speed_ratio=-0.5),
    ]
    at = ("inner", 0.8)
    bearings = [
        gb.Bearing("inner", 0.0, stiffness=1e8),
        gb.Bearing(*at, stiffness=1e8, support=("outer", 0.3)),
        gb.Bearing("outer", 0.0, stiffness=1e8),
        gb.Bearing("outer", 0.6, stiffness=1e8),
    ]
    system = gb.RotorSystem(shafts=shafts, bearings=bearings)
    hours, capacity = 2e4, 1e4
    life = gb.BowLimit.bearing_life(at, hours, capacity=capacity, exponent=3.0)
    found = system.bow_limits("inner", gb.rpm(1000), limits=[life]).limits[0]
    force = capacity * (1e6 / (60.0 * hours * 1500.0)) ** (1.0 / 3.0)
    assert f"mean load {force:.4g} N" in found.why
