"""Mesh geometry: contact ratio, pressure angle, separation under load, effect of rotating bows."""

from __future__ import annotations

import warnings
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import gearbow as gb
from reference import closed_forms
from reference.bows import HalfSine
from reference.machines import short_pair
from reference.mesh_law import MeshLaw
from reference.scenes import PAIR, GearAt, Geared

# Shafts are stiffer than any material.
pytestmark = pytest.mark.implausible

ALPHA = np.radians(20)

# Rigid shafts: the bow and the bearings determine the position of each gear centre.
STIFF = gb.Material(youngs_modulus=1e16, density=7850.0, poisson_ratio=0.3)
AMPLITUDE = 2e-4


def stiff_pair(
    bow: dict[str, gb.Bow] | None = None,
    *,
    teeth: tuple[int, int] = (25, 50),
    module: float = 3e-3,
    bearing: float = 1e9,
    torque: float = 0.0,
    angle: float = 0.0,
    centre_distance: float | None = None,
) -> gb.RotorSystem:
    shaft = {"outer_diameter": 0.05, "material": STIFF if bow is None else gb.STEEL}
    return short_pair(
        ("ga", "gb"),
        teeth,
        shaft=shaft,
        own={name: {"bow": shape} for name, shape in (bow or {}).items()},
        gear={"module": module, "face_width": 0.02},
        mesh={
            "stiffness": 2e8,
            "damping_ratio": 0.1,
            "centre_line_angle": angle,
            "centre_distance": centre_distance,
        },
        bearing={"stiffness": bearing, "damping": 2e4},
        torque=torque,
    )


def law(teeth: tuple[int, int], module: float, distance: float | None = None) -> MeshLaw:
    a, b = (closed_forms.full_depth_gear(z, module) for z in teeth)
    return MeshLaw(
        base_radius_a=a["base"],
        base_radius_b=b["base"],
        centre_distance=distance or a["pitch"] + b["pitch"],
        centre_line_angle=0.0,
        stiffness=2e8,
        tip_radius_a=a["tip"],
        tip_radius_b=b["tip"],
        teeth_a=teeth[0],
    )


@pytest.mark.parametrize(
    ("teeth", "module", "ratio"), [((25, 50), 3e-3, 1.68316), ((62, 62), 2e-3, 1.7897799)]
)
def test_contact_ratio_at_rest(teeth: tuple[int, int], module: float, ratio: float):
    mesh = stiff_pair(teeth=teeth, module=module).static().mesh(("ga", "gb"))
    digits = 1e-5 if module == 3e-3 else 1e-7
    assert float(mesh.contact_ratio) == pytest.approx(ratio, abs=digits / 2)
    own = law(teeth, module)
    # same formula: round-off
    assert float(mesh.contact_ratio) == pytest.approx(
        own.contact_ratio(own.centre_distance), rel=1e-12
    )
    assert float(mesh.pressure_angle) == pytest.approx(ALPHA, rel=1e-12)
    assert float(mesh.centre_distance) == pytest.approx(own.centre_distance, rel=1e-12)


@pytest.mark.parametrize("factor", [0.99, 1.01])
def test_mounted_centre_distance_sets_the_pressure_angle(factor: float):
    distance = factor * 0.1125
    mesh = stiff_pair(centre_distance=distance).static().mesh(("ga", "gb"))
    own = law((25, 50), 3e-3, distance)
    assert float(mesh.pressure_angle) == pytest.approx(own.angle_at_rest, rel=1e-12)
    assert float(mesh.contact_ratio) == pytest.approx(own.contact_ratio(distance), rel=1e-12)


def test_derivatives_by_centre_distance():
    # loads of both signs move the centres to both sides of the mean
    low, high = (stiff_pair(torque=t, bearing=2e8).static().mesh(("ga", "gb")) for t in (10, 1000))
    rise = float(high.centre_distance - low.centre_distance)
    assert rise > 2e-5
    middle = float(high.centre_distance + low.centre_distance) / 2
    alpha = np.arccos(law((25, 50), 3e-3).sum_of_radii / middle)
    pitch = np.pi * 3e-3 * np.cos(ALPHA)
    # a secant against the tangent at its middle: second order, (rise / C tan^2 alpha)^2 = 3e-6
    slope = float(high.contact_ratio - low.contact_ratio) / rise
    assert slope == pytest.approx(-1 / (pitch * np.sin(alpha)), rel=1e-5)
    slope = float(high.pressure_angle - low.pressure_angle) / rise
    assert slope == pytest.approx(1 / (middle * np.tan(alpha)), rel=1e-5)
    assert -1 / (pitch * np.sin(ALPHA)) == pytest.approx(-330.13, abs=5e-3)


@pytest.mark.parametrize("angle", [0.0, 0.7, np.pi, -2.4])
@pytest.mark.parametrize("torque", [5.0, -5.0])
def test_separation_under_load(angle: float, torque: float):
    bearing = 5e7
    still = stiff_pair(torque=torque, bearing=bearing, angle=angle).static(speed=1.0)
    mesh = still.mesh(("ga", "gb"))
    base = closed_forms.full_depth_gear(25, 3e-3)["base"]
    force = torque / base  # counter-clockwise rotation; negative: the gear brakes
    # the tooth force follows from the driver's torque alone: round-off of a Newton iteration
    assert float(mesh.force) == pytest.approx(force, rel=1e-9)
    apart = float(mesh.centre_distance) - 0.1125
    # two bearings each; second order: (F/k)^2 / C cos^2 alpha ~ 1.4e-6 * 1.4e-6 / 0.1 of 1e-6 m;
    # flexibility of the shafts: 48 EI / L^3 = 2e13 N/m against 1e8
    assert apart == pytest.approx(2 * force * np.sin(ALPHA) / (2 * bearing), rel=1e-4)
    # each centre moves by F/k, along the line of action: the driver is pushed back
    n = np.cos(ALPHA) * np.array([-np.sin(angle), np.cos(angle)]) + np.sin(ALPHA) * np.array(
        [np.cos(angle), np.sin(angle)]
    )
    moved = np.asarray(still.displacement("ga"))
    assert moved == pytest.approx(-force / (2 * bearing) * n, abs=1e-4 * abs(force / bearing))
    moved = np.asarray(still.displacement("gb"))
    assert moved == pytest.approx(force / (2 * bearing) * n, abs=1e-4 * abs(force / bearing))


TURNING = replace(PAIR, torque=0.0, bearing_damping=0.0, mesh_damping_ratio=0.0)


@pytest.mark.parametrize("speed", [0.0, 150.0])
def test_frequencies_of_one_mesh_do_not_depend_on_its_angles(speed: float):
    expected = TURNING.package().modes(speed=speed).frequencies_hz[:30]
    for scene in (
        replace(TURNING, angles=(1.1,)),
        replace(TURNING, angles=(-2.9,)),
        # other pressure angles on the same base circles: other reference circles and masses would
        # follow, so only the mounting changes
        replace(TURNING, centre_distance_factor=1.01),
        replace(TURNING, centre_distance_factor=1.015, angles=(0.6,)),
    ):
        found = scene.package().modes(speed=speed).frequencies_hz[:30]
        # an orthogonal change of coordinates: round-off of the eigensolver; 0 Hz is within 1e-3 Hz
        assert found == pytest.approx(expected, rel=1e-8, abs=1e-3)


def test_frequencies_depend_on_the_angles_with_anisotropic_bearings():
    scene = replace(TURNING, bearing_stiffness=np.diag([1e8, 2e7]))
    first = scene.package().modes().frequencies_hz[:30]
    other = replace(scene, angles=(1.1,)).package().modes().frequencies_hz[:30]
    assert np.max(np.abs(other[1:] / first[1:] - 1)) > 1e-3


def test_frequencies_of_two_meshes_depend_on_their_relative_angle():
    scene = Geared(torque=0.0, bearing_damping=0.0, mesh_damping_ratio=0.0, angles=(0.2, 1.0))
    expected = scene.package().modes(speed=100.0).frequencies_hz[:40]
    turned = replace(scene, angles=(0.2 - 1.7, 1.0 - 1.7)).package()
    found = turned.modes(speed=100.0).frequencies_hz[:40]
    assert found == pytest.approx(expected, rel=1e-8, abs=1e-3)  # round-off of the eigensolver
    other = replace(scene, angles=(0.2, 1.9)).package().modes(speed=100.0).frequencies_hz[:40]
    assert np.max(np.abs(other[1:] / expected[1:] - 1)) > 1e-3


@pytest.mark.parametrize("scene", [PAIR, Geared()], ids=["pair", "double stage"])
@pytest.mark.parametrize("speed", [0.0, 200.0, -200.0])
def test_exactly_one_rigid_body_rotation(scene: Geared, speed: float):
    modes = scene.package().modes(speed=speed)
    assert list(modes.whirl).count("rigid") == 1
    assert modes.frequencies_hz[0] == 0.0  # removed analytically, not computed by the solver
    assert modes.frequencies_hz[1] > 1.0
    # no mode is unstable
    assert np.min(modes.damping_ratios[1:]) > -1e-9


@cache
def one_turn(bowed: str, speed: float = 20.0, points: int = 720) -> gb.results.MeshResponse:
    """Simulate one slow revolution of the bowed shaft from the synchronous state."""
    system = stiff_pair({bowed: gb.Bow.half_sine(AMPLITUDE, phase=0.4)})
    period = 2 * np.pi / speed / (1.0 if bowed == "a" else 0.5)
    response = system.simulate(
        period, speed, times=np.arange(points) * period / points, initial="synchronous"
    )
    return response.mesh(("ga", "gb"))


@pytest.mark.parametrize("bowed", ["a", "b"])
def test_mean_and_peak_to_peak_values_with_a_rotating_bow(bowed: str):
    mesh = one_turn(bowed)
    c_0, pitch, b = 0.1125, np.pi * 3e-3 * np.cos(ALPHA), AMPLITUDE
    sin, tan = np.sin(ALPHA), np.tan(ALPHA)
    # b / C tan^2 alpha = 1.3e-2 is the next term of each peak-to-peak value; its square, 2e-4, that
    # of each mean. The start leaves a free motion of about (20 rad/s over 1e4 rad/s)^2 of the bow
    # in the peak-to-peak values, and its square in the means; bearings of 1e9 N/m constrain the
    # bow.
    close, closer = 2e-2, 2e-3
    assert np.mean(mesh.centre_distance) - c_0 == pytest.approx(b**2 / (4 * c_0), rel=close)
    assert np.ptp(mesh.centre_distance) == pytest.approx(2 * b, rel=closer)
    own = law((25, 50), 3e-3)
    shift = b**2 * np.cos(2 * ALPHA) / (4 * pitch * c_0 * sin**3)
    assert np.mean(mesh.contact_ratio) - own.contact_ratio(c_0) == pytest.approx(shift, rel=close)
    shift = -(b**2) / (4 * c_0**2 * tan * sin**2)
    assert np.mean(mesh.pressure_angle) - ALPHA == pytest.approx(shift, rel=close)
    assert np.ptp(mesh.contact_ratio) == pytest.approx(2 * b / (pitch * sin), rel=closer)
    assert np.ptp(mesh.pressure_angle) == pytest.approx(2 * b / (c_0 * tan), rel=closer)


def test_mean_shift_is_the_same_whichever_gear_is_bowed():
    means = [np.mean(one_turn(bowed).contact_ratio) for bowed in ("a", "b")]
    rest = law((25, 50), 3e-3).contact_ratio(0.1125)
    assert means[0] - rest == pytest.approx(means[1] - rest, rel=2e-2)  # as above


@pytest.mark.parametrize(("bowed", "sense"), [("a", -1.0), ("b", 1.0)])
@pytest.mark.parametrize("phase", [0.0, 2.0])
def test_a_bow_at_a_fixed_phase_shifts_the_geometry_to_first_order(
    bowed: str, sense: float, phase: float
):
    angle = 0.5
    system = stiff_pair({bowed: gb.Bow.half_sine(AMPLITUDE, phase=phase)}, angle=angle)
    mesh = system.simulate(1e-4, 0.0, initial="synchronous", times=[0.0]).mesh(("ga", "gb"))
    opened = sense * AMPLITUDE * np.cos(phase - angle)
    # the next term is (b sin)^2 / 2C: 2e-7 m
    assert float(mesh.centre_distance[0]) - 0.1125 == pytest.approx(opened, abs=4e-7)
    alpha = ALPHA + opened / (0.1125 * np.tan(ALPHA))
    # second-order term, half of alpha'' times the squared change of centre distance: 3e-5 rad of
    # 5e-3
    assert float(mesh.pressure_angle[0]) == pytest.approx(alpha, abs=5e-5)


def test_share_of_tooth_pairs_is_the_contact_ratio():
    # stiff and unloaded, seven tooth periods at 500 points each
    system = stiff_pair({})
    period = 2 * np.pi / 25 / 50.0
    times = np.arange(3500) * period / 500 + 1e-7
    mesh = system.simulate(7 * period, 50.0, times=times).mesh(("ga", "gb"))
    assert set(np.unique(mesh.pairs_in_contact)) == {1, 2}
    # one sample in 500 at each of two edges
    assert np.mean(mesh.pairs_in_contact) == pytest.approx(1.68316, abs=4e-3)


def test_reported_geometry_is_that_of_the_reported_centres():
    scene = Geared(
        bows={"input": HalfSine(1e-3), "middle": HalfSine(8e-4, 1.0)}, angles=(0.4, -1.0)
    )
    system = scene.package()
    for geometry in ("live", "frozen"):
        r = system.simulate(3e-3, 120.0, geometry=geometry, output_step=5e-5, method="rk4")
        for i, (driver, driven) in enumerate(scene.meshes):
            mesh, own = r.mesh((driver, driven)), scene.law(i)
            u_a, u_b = r.displacement(driver), r.displacement(driven)
            centres = np.array([own.centres(a, b) for a, b in zip(u_a, u_b, strict=True)])
            assert np.ptp(centres[:, 0]) > 1e-5
            # round-off; the reported angle may differ by whole revolutions
            assert mesh.centre_distance == pytest.approx(centres[:, 0], rel=1e-12)
            assert mesh.pressure_angle == pytest.approx(centres[:, 1], rel=1e-11)
            assert np.cos(mesh.centre_line_angle - centres[:, 2]) == pytest.approx(1, abs=1e-12)
            ratio = [own.contact_ratio(c) for c in centres[:, 0]]
            assert mesh.contact_ratio == pytest.approx(np.array(ratio), rel=1e-11)


@pytest.mark.parametrize("teeth", [(17, 17), (25, 50), (40, 23)])
def test_gear_data_follow_from_teeth_and_module(teeth: tuple[int, int]):
    module, width = 2.5e-3, 0.02
    system = gb.RotorSystem(
        shafts=[
            gb.Shaft(n, length=0.2, outer_diameter=0.03, elements=2, material=gb.STEEL)
            for n in "ab"
        ],
        gears=[
            gb.Gear(f"g{n}", shaft=n, position=0.1, teeth=z, module=module, face_width=width)
            for n, z in zip("ab", teeth, strict=True)
        ],
        meshes=[gb.Mesh("ga", "gb", stiffness=1e8)],
        bearings=[gb.Bearing(n, position=x, stiffness=1e8) for n in "ab" for x in (0.0, 0.2)],
    )
    gears = tuple(GearAt(f"g{n}", n, 0.1, z) for n, z in zip("ab", teeth, strict=True))
    own = Geared(
        shafts=("a", "b"),
        gears=gears,
        meshes=(("ga", "gb"),),
        ratios=(1.0, -teeth[0] / teeth[1]),
        angles=(0.0,),
        module=module,
        face_width=width,
        length=0.2,
        diameter=0.03,
        elements=2,
        mesh_stiffness=1e8,
        mesh_damping_ratio=0.0,
        bearing_damping=0.0,
    ).reference()
    matrices = system.matrices()
    # mass and inertia of a solid steel disk on the pitch circle
    assert matrices.mass == pytest.approx(own.mass, rel=1e-12, abs=1e-15)


def test_frozen_geometry_runs_where_the_base_circles_overlap():
    """With fixed geometry, quantities without a value are reported as NaN."""
    shafts = [gb.Shaft(name, length=0.5, outer_diameter=0.05, elements=4) for name in "ab"]
    system = gb.RotorSystem(
        shafts=shafts,
        gears=[
            gb.Gear("g1", "a", 0.25, teeth=25, module=3e-3, face_width=0.03),
            gb.Gear("g2", "b", 0.25, teeth=50, module=3e-3, face_width=0.03),
        ],
        meshes=[gb.Mesh("g1", "g2", stiffness=2e8, damping_ratio=0.05)],
        # The weight presses the first gear, on soft bearings, into the second.
        bearings=[
            gb.Bearing(shaft, x, stiffness=stiffness, damping=500.0)
            for shaft, stiffness in (("a", 5e3), ("b", 1e8))
            for x in (0.0, 0.5)
        ],
        gravity=(9.81, 0.0),
    )
    with pytest.raises(gb.ContactError):
        system.static(geometry="live")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gb.SceneWarning)
        rest = system.static(geometry="frozen")
        run = system.simulate(1e-3, 100.0, geometry="frozen", initial="static")
    mesh, moving = rest.mesh(("g1", "g2")), run.mesh(("g1", "g2"))
    apart = system_distance(rest)
    assert mesh.centre_distance == pytest.approx(apart, rel=1e-12)
    assert moving.centre_distance[0] == pytest.approx(apart, rel=1e-12)
    for state in (mesh, moving):
        assert np.isnan(state.pressure_angle).all()
        assert np.isnan(state.contact_ratio).all()
        assert np.isfinite(state.force).all()
    assert all(np.isfinite(event.time) for event in run.events)


def system_distance(static: gb.results.Static) -> float:
    """Return the distance of the centres of g1 and g2, 112.5 mm along y at rest."""
    apart = static.displacement("g2") - static.displacement("g1")
    return float(np.hypot(0.1125 + apart[0], apart[1]))
