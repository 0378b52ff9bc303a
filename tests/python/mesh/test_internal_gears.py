"""Internal gears on fixed axes: geometry, limits, and every analysis against independent models."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference import independent_solution
from reference.bows import HalfSine
from reference.elements import Section
from reference.internal import InternalLaw
from reference.scenes import DENSITY, E, G
from reference.train import BearingSpec, MeshSpec, RigidSpec, ShaftPart, ShaftSpec, Train

ALPHA = np.radians(20.0)
MODULE = 3e-3
PINION, RING = 20, 60
LENGTH, DIAMETER, ELEMENTS = 0.3, 0.04, 2
BODY = {
    "pinion": {"mass": 1.5, "diametral_inertia": 7e-4, "polar_inertia": 1.2e-3},
    "ring": {"mass": 6.0, "diametral_inertia": 2.5e-2, "polar_inertia": 4.8e-2},
}
MESH_STIFFNESS, MESH_DAMPING = 2e8, 2e3
BEARING, BEARING_DAMPING = 1e8, 800.0
TORQUE, SPEED, ANGLE = 120.0, 250.0, 0.4
BOWS = {"pinion": HalfSine(6e-5, 0.3), "ring": HalfSine(4e-5, -1.0)}


def gear(name: str, **changes: Any) -> gb.Gear:
    teeth, internal = (RING, True) if name == "ring" else (PINION, False)
    given: dict[str, Any] = {
        "teeth": teeth,
        "internal": internal,
        "module": MODULE,
        "face_width": 0.025,
        **BODY[name],
    }
    return gb.Gear(name, f"{name} shaft", LENGTH / 2, **(given | changes))


def pair(
    driver: str = "pinion",
    *,
    pinion: dict[str, Any] | None = None,
    ring: dict[str, Any] | None = None,
    bows: bool = False,
    mesh: dict[str, Any] | None = None,
    damping: float = BEARING_DAMPING,
    axial: float = BEARING,
    **options: Any,
) -> gb.RotorSystem:
    driven = "ring" if driver == "pinion" else "pinion"
    given: dict[str, Any] = {
        "stiffness": MESH_STIFFNESS,
        "damping": MESH_DAMPING,
        "centre_line_angle": ANGLE,
    }
    return gb.RotorSystem(
        shafts=[
            gb.Shaft(
                f"{name} shaft",
                length=LENGTH,
                outer_diameter=DIAMETER,
                elements=ELEMENTS,
                bow=BOWS[name].package(LENGTH) if bows else None,
            )
            for name in ("pinion", "ring")
        ],
        gears=[gear("pinion", **(pinion or {})), gear("ring", **(ring or {}))],
        meshes=[gb.Mesh(driver, driven, **(given | (mesh or {})))],
        bearings=[
            gb.Bearing(
                f"{name} shaft", x, stiffness=BEARING, damping=damping, axial_stiffness=axial
            )
            for name in ("pinion", "ring")
            for x in (0.0, LENGTH)
        ],
        torques=[gb.Torque(driver, TORQUE), gb.Torque.balance(driven)],
        reference=f"{driver} shaft",
        **options,
    )


def law(driver: str = "pinion") -> InternalLaw:
    base = {"pinion": PINION, "ring": RING}
    radius = {name: MODULE * z * np.cos(ALPHA) / 2 for name, z in base.items()}
    distance = MODULE * (RING - PINION) / 2
    # The default tip of the ring is shortened to the base circle of the pinion: R - m interferes.
    limit = np.hypot(radius["ring"], distance * np.sin(ALPHA))
    tips = {"pinion": MODULE * (PINION / 2 + 1), "ring": max(MODULE * (RING / 2 - 1), limit)}
    driven = "ring" if driver == "pinion" else "pinion"
    return InternalLaw(
        base_radius_a=radius[driver],
        base_radius_b=radius[driven],
        centre_distance=distance,
        centre_line_angle=ANGLE,
        stiffness=MESH_STIFFNESS,
        damping=MESH_DAMPING,
        sigma=1.0,
        tip_radius_a=tips[driver],
        tip_radius_b=tips[driven],
        teeth_a=base[driver],
    )


def independent(driver: str) -> Train:
    """Assemble the bowed pair in NumPy."""
    teeth = {"pinion": PINION, "ring": RING}
    ratio = {name: teeth[driver] / z for name, z in teeth.items()}
    section = Section(DIAMETER, E, G, DENSITY)
    shafts = [
        ShaftSpec(
            f"{name} shaft",
            [ShaftPart(LENGTH, section, ELEMENTS)],
            ratio[name],
            BOWS[name].curve(LENGTH),
            BOWS[name].slope(LENGTH),
        )
        for name in ("pinion", "ring")
    ]
    rigid = [
        RigidSpec(name, f"{name} shaft", LENGTH / 2, *(float(x) for x in BODY[name].values()))
        for name in ("pinion", "ring")
    ]
    bearings = [
        BearingSpec(f"{name} shaft", x, np.eye(2) * BEARING, np.eye(2) * BEARING_DAMPING)
        for name in ("pinion", "ring")
        for x in (0.0, LENGTH)
    ]
    driven = "ring" if driver == "pinion" else "pinion"
    torques = [(driver, TORQUE), (driven, -TORQUE / ratio[driven])]
    return Train(shafts, rigid, bearings, [MeshSpec(driver, driven, law(driver))], torques)


@pytest.mark.parametrize("driver", ["pinion", "ring"])
def test_geometry_at_rest_is_that_of_the_closed_forms(driver: str):
    system = pair(driver)
    own = law(driver)
    mesh = system.static().mesh(("pinion", "ring"))
    # gears with speed ratios of equal sign
    assert system.speed_ratios[1] / system.speed_ratios[0] == pytest.approx(
        PINION / RING, rel=1e-15
    )
    # the load moves the centres by micrometres: without load the values are exact
    free = replace(gb.Torque(driver, 0.0))
    unloaded = system.replace(torques=[free]).static().mesh(("pinion", "ring"))
    assert float(unloaded.centre_distance) == pytest.approx(MODULE * 20, rel=1e-12)
    assert float(unloaded.pressure_angle) == pytest.approx(ALPHA, rel=1e-12)
    assert float(unloaded.contact_ratio) == pytest.approx(
        own.contact_ratio(own.centre_distance), rel=1e-12
    )
    assert float(mesh.contact_ratio) != float(unloaded.contact_ratio)


def test_the_contact_ratio_of_a_given_tip_radius_is_the_closed_form():
    tip = 29.3 * MODULE
    mesh = pair(ring={"tip_radius": tip}).replace(torques=[]).static().mesh(("pinion", "ring"))
    reach = [np.sqrt(t**2 - (z * np.cos(ALPHA) / 2) ** 2) for t, z in ((11.0, 20), (29.3, 60))]
    expected = (reach[0] - reach[1] + 20 * np.sin(ALPHA)) / (np.pi * np.cos(ALPHA))
    assert float(mesh.contact_ratio) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("driver", ["pinion", "ring"])
@pytest.mark.parametrize(("x1", "x2"), [(0.3, -0.1), (0.2, -0.6), (0.4, -0.4)])
def test_profile_shifts_give_the_working_pressure_angle_of_iso_21771(
    driver: str, x1: float, x2: float
):
    system = pair(driver, pinion={"profile_shift": x1}, ring={"profile_shift": x2})
    mesh = system.replace(torques=[]).static().mesh(("pinion", "ring"))
    angle = float(mesh.pressure_angle)

    def involute(a: float) -> float:
        return float(np.tan(a) - a)

    # signed numbers of teeth: z2 = -60
    wanted = involute(ALPHA) + 2 * (x1 + x2) * np.tan(ALPHA) / (PINION - RING)
    # round-off of tan a - a
    assert involute(angle) == pytest.approx(wanted, rel=1e-11)
    distance = MODULE * (RING - PINION) / 2 * np.cos(ALPHA) / np.cos(angle)
    assert float(mesh.centre_distance) == pytest.approx(distance, rel=1e-12)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"ring": {"tip_radius": 29.0 * MODULE}},
            r'meshes\[0\]: involute interference: the tips of "ring" reach',
        ),
        (
            {"ring": {"teeth": 24, "tip_radius": 11.3 * MODULE}, "pinion": {"teeth": 20}},
            r'meshes\[0\]: trochoid interference: the tips of "pinion" cut those of "ring"',
        ),
        ({"ring": {"teeth": 20}}, r'needs more teeth than "pinion", got 20 and 20'),
        ({"pinion": {"internal": True}}, "are both internal; one must be external"),
        (
            {"pinion": {"helix_angle": 0.2}, "ring": {"helix_angle": -0.2}},
            "an internal gear and its pinion need the same hand",
        ),
        (
            {"mesh": {"stiffness": gb.Stiffness.potential_energy()}},
            r'meshes\[0\]\.stiffness\.model: describes external teeth, and "ring" is internal',
        ),
        (
            {"ring": {"tip_radius": 0.08}},
            r"gears\[1\]\.tip_radius: 0\.08 m is inside the base circle",
        ),
        (
            {"ring": {"tip_radius": 0.095}},
            r"gears\[1\]\.tip_radius: 0\.095 m leaves no tooth inside the root radius",
        ),
        (
            {"mesh": {"centre_distance": 0.05}},
            r"meshes\[0\]\.centre_distance: 0\.05 m is not above the difference of the base radii",
        ),
        (
            {"ring": {"profile_shift": 1.5}},
            r"centre_distance: no distance is without play.*need less than.*smaller profile_shift",
        ),
    ],
)
def test_impossible_pairs_are_errors(changes: dict[str, Any], message: str):
    with pytest.raises(gb.SceneError, match=message):
        pair(**changes)


def rolled_clearance(teeth: int, tip: float) -> float:
    """Give the angle between the tips of ring and pinion where they leave each other [rad].

    Lengths are in modules. At the angle 0 of both gears, their flanks touch at the pitch point.
    """
    base, ring_base = PINION * np.cos(ALPHA) / 2, teeth * np.cos(ALPHA) / 2
    distance, inner = (teeth - PINION) / 2, PINION / 2 + 1.0
    angles = (ALPHA, np.arccos(base / inner), np.arccos(ring_base / tip))
    at_pitch, of_pinion, of_ring = (np.tan(angle) - angle for angle in angles)
    turn = np.linspace(0.0, 3.6, 200001)
    corner = distance + inner * np.exp(1j * (turn - of_pinion + at_pitch))
    enters = int(np.argmax(np.abs(corner) < tip))
    of_tip = turn[enters] * PINION / teeth - of_ring + at_pitch
    return float(of_tip - np.angle(corner[enters]))


@pytest.mark.parametrize(
    ("teeth", "tip", "cuts"),
    [(24, 11.3, True), (26, 12.3, True), (27, 12.8, False), (30, 14.2, False)],
)
def test_trochoid_interference_is_that_of_rolling_tips(teeth: int, tip: float, cuts: bool):
    assert (rolled_clearance(teeth, tip) < 0.0) == cuts
    given = {"teeth": teeth, "tip_radius": tip * MODULE}
    if cuts:
        with pytest.raises(gb.SceneError, match="trochoid interference"):
            pair(ring=given)
    else:
        assert pair(ring=given).gears[1].teeth == teeth


@pytest.mark.parametrize("driver", ["pinion", "ring"])
def test_modes_and_synchronous_response_equal_an_independent_assembly(driver: str):
    system, train = pair(driver, bows=True, axial=0.0), independent(driver)
    found = system.modes(SPEED, count=10, vibrating=True)
    expected = train.eigenvalues(SPEED)
    frequencies = np.sort(np.abs(found.eigenvalues.imag))
    assert frequencies == pytest.approx(np.abs(expected.imag)[: len(frequencies)], rel=1e-7)
    phasors = system.synchronous(SPEED).amplitudes[0]
    for found_of, own in zip(phasors, train.synchronous(SPEED), strict=True):
        for name in ("pinion", "ring"):
            at = [train.dof(f"{name} shaft", LENGTH / 2, lane) for lane in (0, 1)]
            lateral = found_of[list(system.coordinates.lateral(name))]
            # lstsq of a singular matrix, with the rotation of the train, keeps nine digits
            assert lateral == pytest.approx(own[at], abs=1e-7 * np.abs(own[at]).max())


@pytest.mark.parametrize("geometry", ["live", "frozen"])
@pytest.mark.parametrize("driver", ["pinion", "ring"])
def test_runs_follow_the_independent_solution(driver: str, geometry: str):
    train, system = independent(driver), pair(driver, bows=True, axial=0.0)
    times = np.linspace(0.0, 0.002, 41)
    live = geometry == "live"
    judged = independent_solution.from_rest(train, SPEED, times, live=live, rtol=1e-9)
    for method in ("exponential", "rk45"):
        run = system.simulate(
            times[-1],
            speed=SPEED,
            times=times,
            geometry=geometry,
            initial="rest",
            method=method,
            rtol=1e-9,
        )
        for name in ("pinion", "ring"):
            own = judged.displacement(name)
            # found: 1e-11 with the exponential method
            assert run.displacement(name)[:, :2] == pytest.approx(own, abs=1e-7 * np.abs(own).max())
        mesh, force = run.mesh(("pinion", "ring")), judged.mesh_force(0, live)
        assert mesh.force == pytest.approx(force, abs=1e-7 * np.abs(force).max())
        if live:
            assert mesh.contact_ratio == pytest.approx(judged.contact_ratio(0), abs=1e-9)


@pytest.mark.parametrize("driver", ["pinion", "ring"])
@pytest.mark.parametrize("helix", [0.0, 0.25])
def test_energy_is_conserved_without_damping(driver: str, helix: float):
    system = pair(
        driver,
        pinion={"helix_angle": helix},
        ring={"helix_angle": helix},
        bows=True,
        damping=0.0,
        mesh={"damping": 0.0, "stiffness": gb.Stiffness.square(pair=1.5e8), "backlash": 5e-5},
    )
    run = system.simulate(0.01, speed=SPEED, rtol=1e-9, record=["gears", "meshes", "energy"])
    balance = run.energy_balance()
    # the promise of the audit for a run with this tolerance
    assert np.abs(balance.residual).max() < 1e-6 * np.abs(balance.total).max()
    pairs = run.mesh(("pinion", "ring")).pairs_in_contact
    assert set(pairs) <= {0, 1, 2, 3}


def test_the_time_with_two_pairs_is_the_contact_ratio():
    square = gb.Stiffness.square(pair=1.5e8, engagement="sharp")
    for driver, teeth in (("pinion", PINION), ("ring", RING)):
        system = pair(driver, mesh={"stiffness": square}, damping=1e4)
        cycle = 2 * np.pi / teeth
        times = np.linspace(0.0, cycle, 4000, endpoint=False)
        run = system.simulate(cycle, speed=1.0, times=times, initial="static")
        mesh = run.mesh(("pinion", "ring"))
        # 4000 samples of a cycle
        assert mesh.pairs_in_contact.mean() == pytest.approx(mesh.contact_ratio.mean(), abs=2e-3)


@pytest.mark.parametrize("driver", ["pinion", "ring"])
def test_friction_dissipates_the_loss_of_the_sliding_flanks(driver: str):
    coefficient = 0.05
    system = pair(driver, mesh={"friction": coefficient})
    found = system.efficiency(SPEED)
    own = law(driver)
    mesh = system.static(speed=SPEED).mesh(("pinion", "ring"))
    # a stiffness without tooth pairs has the mean sliding of the centres at rest
    distance, angle = own.centre_distance, ALPHA
    radius = min(own.base_radius_a, own.base_radius_b)
    # positions from the base circle of the pinion: begin at the tips of the ring, end at those of the pinion
    end = np.sqrt((MODULE * (PINION / 2 + 1)) ** 2 - radius**2)
    pitch = np.pi * MODULE * np.cos(ALPHA)
    begin = end - own.contact_ratio(distance) * pitch
    s = np.linspace(begin, end, 200001)
    ratio = {"pinion": 1.0, "ring": PINION / RING}
    spins = [SPEED * ratio[name] / ratio[driver] for name in ("pinion", "ring")]
    sliding = np.abs(s - radius * np.tan(angle)) * abs(spins[0] - spins[1])
    # a pair carries its share while it touches: two pairs share equally
    single = (s > end - pitch) & (s < begin + pitch)
    share = np.where(single, 1.0, 0.5)
    mean = float(np.sum(sliding * share)) * (s[1] - s[0]) / pitch
    loss = coefficient * float(mesh.force) * mean
    # the change of sign over a tenth of the pitch lowers the loss by some tenths of a per cent
    assert float(found.loss[0, 0]) == pytest.approx(loss, rel=5e-3)


def test_limits_figures_and_files(tmp_path: Path):
    system = pair(bows=True, mesh={"backlash": 1e-4})
    limits = system.bow_limits("pinion shaft", speed=SPEED)
    text = str(limits)
    assert "contact ratio" in text
    assert "involutes end" in text
    system.plot()
    run = system.simulate(0.005, speed=SPEED)
    run.plot("mesh")
    system.save(tmp_path / "pair.toml")
    assert gb.read(tmp_path / "pair.toml").gears == system.gears
    plain = pair()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        plain.save(tmp_path / "pair.rexs")
        again = gb.read(tmp_path / "pair.rexs")
    assert [gear.internal for gear in again.gears] == [False, True]
    assert again.gears[1].teeth == RING
    assert again.speed_ratios == pytest.approx(plain.speed_ratios)
