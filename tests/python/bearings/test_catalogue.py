"""Rolling bearings from designations and boundary dimensions, and rings of five degrees of freedom."""

import math
from dataclasses import replace

import numpy as np
import pytest

import gearbow as gb
from gearbow.plotting.symbols import bearing_kind

#: Boundary dimensions of ISO 15 and ISO 355 [mm].
BOUNDARIES = {
    "6000": (10, 26, 8),
    "6008": (40, 68, 15),
    "6030": (150, 225, 35),
    "6203": (17, 40, 12),
    "6209": (45, 85, 19),
    "6220": (100, 180, 34),
    "6303": (17, 47, 14),
    "6308": (40, 90, 23),
    "N204": (20, 47, 14),
    "NU209": (45, 85, 19),
    "nu 210": (50, 90, 20),
    "32004X": (20, 42, 15),
    "32008": (40, 68, 19),
    "32020 X": (100, 150, 32),
}
#: Number and diameter [mm] of the balls of published bearings: 6203 and 6205 in the data of the Case Western Reserve University
#: bearing data centre, 209 and 218 in Harris (2001), 6204, 6206 and 6308 in papers on vibration of bearings.
PUBLISHED = {
    "6203": (8, 6.746),
    "6204": (8, 7.938),
    "6205": (9, 7.938),
    "6206": (9, 9.525),
    "6209": (9, 12.7),
    "6308": (8, 15.081),
}


@pytest.mark.parametrize("name", BOUNDARIES)
def test_designations_have_their_boundary_dimensions(name):
    estimate = gb.RollingBearing("rotor", 0.0, name).estimate
    found = (estimate.bore, estimate.outer, estimate.width)
    assert found == pytest.approx([length / 1000 for length in BOUNDARIES[name]])


@pytest.mark.parametrize("name", PUBLISHED)
def test_estimates_of_balls_are_near_published_ones(name):
    count, diameter = PUBLISHED[name]
    estimate = gb.RollingBearing("rotor", 0.0, name).estimate
    # What `estimate` says: one ball, and 6 % of the diameter.
    assert abs(estimate.elements - count) <= 1
    assert 1e3 * estimate.element_diameter == pytest.approx(diameter, rel=0.06)
    given = gb.RollingBearing(
        "rotor",
        0.0,
        elements=count,
        element_diameter=diameter / 1000,
        pitch_diameter=estimate.pitch_diameter,
        clearance=0.0,
    )
    stiffness = [
        bearing.coefficients(1000.0).stiffness[1, 1]
        for bearing in (given, gb.RollingBearing("rotor", 0.0, name))
    ]
    assert stiffness[1] == pytest.approx(stiffness[0], rel=estimate.stiffness_uncertainty)


def test_estimates_of_the_angular_contact_and_roller_bearings_of_harris():
    ball = gb.RollingBearing.from_dimensions(
        "rotor", 0.0, bore=0.09, outer=0.16, width=0.03, kind="angular_contact"
    ).estimate
    assert (ball.elements, ball.pitch_diameter) == (16, pytest.approx(0.125))
    assert ball.element_diameter == pytest.approx(0.02223, rel=0.06)
    roller = gb.RollingBearing("rotor", 0.0, "NU209").estimate
    assert (roller.elements, roller.element_diameter) == (14, pytest.approx(0.01))
    assert roller.roller_length == pytest.approx(0.0096, rel=0.02)


def test_given_entries_replace_the_estimate():
    bearing = gb.RollingBearing("rotor", 0.0, "6308", elements=7, clearance=1e-5)
    assert bearing.ball_pass_order == pytest.approx(7 * bearing.cage_order)
    assert bearing.coefficients(100.0).contact_forces.size == 7


def rotor(*bearings):
    return gb.RotorSystem(
        [gb.Shaft("rotor", length=0.4, outer_diameter=0.04, elements=4)],
        disks=[gb.Disk("disk", "rotor", 0.2, 10.0, 0.02, 0.04, unbalance=1e-4)],
        bearings=bearings,
        gravity=9.81,
    )


def test_a_system_has_the_bearing_of_its_estimate(tmp_path):
    by_name = rotor(*(gb.RollingBearing("rotor", x, "6308", damping=300.0) for x in (0.0, 0.4)))
    estimate = by_name.bearings[0].estimate
    same = [
        gb.RollingBearing(
            "rotor",
            x,
            elements=estimate.elements,
            element_diameter=estimate.element_diameter,
            pitch_diameter=estimate.pitch_diameter,
            clearance=0.0,
            damping=300.0,
        )
        for x in (0.0, 0.4)
    ]
    by_numbers = rotor(*same)
    for system in (by_name, by_numbers):
        system.modes(100.0)
    np.testing.assert_allclose(
        by_name.modes(100.0).eigenvalues, by_numbers.modes(100.0).eigenvalues, rtol=1e-12
    )
    run = by_name.simulate(0.02, 100.0, record=["bearings"])
    assert run.rolling(("rotor", 0.0)).loaded_elements.max() <= 8
    by_name.save(tmp_path / "rotor.toml")
    assert gb.RotorSystem.load(tmp_path / "rotor.toml").bearings == by_name.bearings
    needle = gb.RollingBearing.from_dimensions(
        "rotor", 0.0, bore=0.04, outer=0.045, width=0.02, kind="needle_cage", clearance=1e-5
    )
    system = rotor(needle, by_name.bearings[1])
    system.save(tmp_path / "needle.toml")
    assert gb.RotorSystem.load(tmp_path / "needle.toml").bearings == system.bearings
    assert [bearing_kind(each) for each in system.bearings] == ["roller bearing", "ball bearing"]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (
            {"designation": "6399"},
            'designation: "6399" is not known; known are 6000 to 6030, 6200 to 6230, ',
        ),
        ({"designation": "6308-2RS"}, "not known; known are .* 32004 to 32030, without suffixes"),
        ({"designation": "6308", "kind": "deep_groove"}, "kind: belongs to the designation"),
        ({"designation": "6308", "boundary": (0.04, 0.09, 0.02)}, "boundary: belongs to"),
        ({"designation": "6308", "contact": "roller"}, "contact: differs"),
        ({"kind": "deep_groove"}, "needs a designation"),
        ({"boundary": (0.04, 0.09, 0.02)}, "missing field `kind`"),
        (
            {"kind": "deep_groove", "boundary": (0.09, 0.04, 0.02)},
            "boundary.1.: must be above the bore",
        ),
        ({"kind": "deep_groove", "boundary": (0.04, 0.09)}, "3 numbers .bore, outer, width."),
        ({"kind": "plain", "boundary": (0.04, 0.09, 0.02)}, "kind: unknown"),
        ({}, "needs a designation such as"),
    ],
)
def test_errors_of_the_catalogue(given, message):
    with pytest.raises(gb.SceneError, match=message):
        rotor(gb.RollingBearing("rotor", 0.0, **given))


# --- rings ----------------------------------------------------------------------------------------

#: 218 angular contact bearing (Harris 2001, chapter 7): 16 balls of 22.23 mm, B = f_i + f_o − 1 = 0.0464, K 896.7 N/mm².
BALL, SUM_OF_GROOVES, AXIAL_CONSTANT, ANGLE = 0.02223, 0.0464, 896.7e6, math.radians(40.0)
DISTANCE = SUM_OF_GROOVES * BALL
B218 = gb.RollingBearing(
    "rotor",
    0.0,
    elements=16,
    element_diameter=BALL,
    pitch_diameter=0.125,
    clearance=0.0,
    contact_angle=ANGLE,
    inner_groove=0.5 + SUM_OF_GROOVES / 2,
    outer_groove=0.5 + SUM_OF_GROOVES / 2,
    # Q = K d² (cos α₀/cos α − 1)^1.5 = K d² (δ/A)^1.5
    hertz_stiffness=AXIAL_CONSTANT * BALL**2 / DISTANCE**1.5,
)


def test_218_bearing_under_thrust():
    found = B218.ring_coefficients(0.0, thrust=17800.0)
    # The digits that Harris prints.
    assert np.degrees(found.contact_angles) == pytest.approx(41.6, abs=0.05)
    assert found.contact_forces == pytest.approx(1676.0, abs=2.0)
    # Harris computes the displacement with the angle rounded to 41.6°.
    assert 1e3 * found.displacement[0] == pytest.approx(0.0385, abs=3e-4)
    rounded = DISTANCE * math.sin(math.radians(1.6)) / math.cos(math.radians(41.6))
    assert 1e3 * rounded == pytest.approx(0.0385, abs=5e-5)
    assert found.force == pytest.approx([17800.0, 0, 0, 0, 0], abs=1e-6)
    # The equation of the contact angle: F/(Z d² K) = sin α (cos α₀/cos α − 1)^1.5.
    angle = found.contact_angles[0]
    approach = math.cos(ANGLE) / math.cos(angle) - 1
    wanted = 17800.0 / (16 * BALL**2 * AXIAL_CONSTANT)
    assert math.sin(angle) * approach**1.5 == pytest.approx(wanted, rel=1e-9)


def test_stiffness_of_a_ring_couples_thrust_and_radial_load():
    found = B218.ring_coefficients(5000.0, thrust=10000.0)
    size = np.abs(found.stiffness).max()
    assert np.abs(found.stiffness - found.stiffness.T).max() < 1e-12 * size
    assert found.stiffness[0, 2] != 0.0
    h = 1.0
    other = [B218.ring_coefficients(5000.0, thrust=10000.0 + s * h).displacement for s in (-1, 1)]
    moved = (other[1] - other[0])[:3] / (2 * h)
    wanted = np.linalg.solve(found.stiffness[:3, :3], [1.0, 0.0, 0.0])
    # Central differences of second order in h over the load.
    assert moved == pytest.approx(wanted, rel=1e-5)


def test_a_tilt_gives_a_moment():
    tilted = B218.ring_coefficients(0.0, thrust=10000.0, tilt=(1e-5, 0.0))
    straight = B218.ring_coefficients(0.0, thrust=10000.0)
    assert tilted.force[3] == pytest.approx(
        1e-5 * straight.stiffness[3, 3]
        + straight.stiffness[3, :3] @ (tilted.displacement - straight.displacement)[:3],
        rel=1e-3,
    )


@pytest.mark.parametrize(("axial", "radial"), [(0.0, 1.0), (0.4, 1.0), (1.0, 0.7), (2.0, 0.1)])
def test_tapered_rollers_have_the_load_distribution_of_the_integral(axial, radial):
    """Compare 200 rollers with the integral over the loaded zone, Q = K (δ_a sin α + δ_r cos α cos ψ)^(10/9)."""
    angle, stiffness, count = math.radians(15.0), 2e8, 200
    bearing = gb.RollingBearing(
        "rotor",
        0.0,
        elements=count,
        element_diameter=0.0008,
        pitch_diameter=0.055,
        clearance=0.0,
        contact="roller",
        contact_angle=angle,
        hertz_stiffness=stiffness,
    )
    axial, radial = 5e-6 * axial, 20e-6 * radial
    psi = (np.arange(200000) + 0.5) * 2 * np.pi / 200000
    approach = axial * math.sin(angle) + radial * math.cos(angle) * np.cos(psi)
    load = stiffness * np.maximum(approach, 0.0) ** (10 / 9)
    thrust = count * math.sin(angle) * load.mean()
    weight = count * math.cos(angle) * (load * np.cos(psi)).mean()
    found = bearing.ring_coefficients(weight, thrust=thrust)
    # The sum of 200 rollers against the integral; a loaded zone that ends has an error of the power 1 + 10/9 of 1/200.
    assert -found.displacement[2] == pytest.approx(radial, rel=1e-3)
    assert found.displacement[0] == pytest.approx(axial, rel=1e-3, abs=1e-3 * radial)


def test_a_radial_ring_has_the_coefficients_of_a_radial_bearing():
    bearing = replace(B218, contact_angle=0.0, clearance=2e-5)
    ring, radial = bearing.ring_coefficients(800.0), bearing.coefficients(800.0, cage_angle=0.0)
    # A ball that is displaced across its line turns the line: of the order of δ/A.
    assert ring.displacement[2] == pytest.approx(radial.displacement[1], rel=1e-3)
    assert ring.stiffness[2, 2] == pytest.approx(radial.stiffness[1, 1], rel=1e-2)


def test_a_ring_refuses_what_it_cannot_carry():
    with pytest.raises(gb.ConvergenceError, match="load"):
        gb.RollingBearing("rotor", 0.0, "NU209").ring_coefficients(100.0, thrust=1000.0)
    with pytest.raises(gb.SceneError, match="tilt: must be two rotations"):
        B218.ring_coefficients(100.0, tilt=0.1)
