"""Rating life of bearings: values of standards and catalogues, loads of elements summed by hand, spectra, errors."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import gearbow as gb
from gearbow.description.load_rating import (
    LoadRating,
    rating_of,
    reliability_factor,
)
from reference.cases import each_case
from reference.machines import hostile, pair, rated
from reference.standards import rated_hours

SPEED = gb.rpm(1500)
RIGID = gb.Material(1e14, 100.0, poisson_ratio=0.3)


def rotor(*bearings: Any, **parts: Any) -> gb.RotorSystem:
    """Build a stiff shaft of 0.5 m on bearings."""
    shaft = gb.Shaft("rotor", length=0.5, outer_diameter=0.1, elements=2, material=RIGID)
    return gb.RotorSystem([shaft], bearings=bearings, **parts)


def carrying(
    first: Any, radial: float, axial: float = 0.0, **parts: Any
) -> gb.results.RatedBearing:
    """Give the life of a bearing that carries a radial and an axial force, beside a linear one."""
    other = gb.Bearing("rotor", 0.5, stiffness=1e8)
    force = gb.Force(("rotor", 0.0), -1j * radial, axial=axial)
    system = rotor(first, other, forces=[force], **parts)
    return system.static(SPEED).bearing_life().bearing(("rotor", 0.0))


# --- ratings ---------------------------------------------------------------------------------------

#: Factor f_c of ISO 281:2007 by D_w cos α/D_pw: balls (table 2), rollers (table 7).
BALL_FACTORS = {0.05: 46.7, 0.10: 55.5, 0.14: 58.8, 0.18: 59.9, 0.20: 59.9, 0.26: 58.2, 0.30: 56.0}
ROLLER_FACTORS = {0.01: 52.1, 0.05: 74.1, 0.10: 84.2, 0.16: 88.5, 0.20: 88.7, 0.30: 83.8}


def of_ratio(gamma: float, diameter: float, **fields: Any) -> gb.RollingBearing:
    """Build a bearing of 7 elements with D_w cos α/D_pw = γ."""
    sizes = {"elements": 7, "element_diameter": diameter, "clearance": 0.0}
    return gb.RollingBearing("rotor", 0.0, pitch_diameter=diameter / gamma, **sizes, **fields)


@pytest.mark.parametrize(("gamma", "factor"), BALL_FACTORS.items())
def test_rating_of_balls_is_that_of_the_table(gamma: float, factor: float):
    for diameter, power in ((0.012, 12.0**1.8), (0.030, 3.647 * 30.0**1.4)):
        found = rating_of(of_ratio(gamma, diameter))
        wanted = 1.3 * factor * 7 ** (2 / 3) * power
        # the table has three digits
        assert found.dynamic == pytest.approx(wanted, rel=1.2e-3)
        assert (found.source, found.exponent) == ("computed", 3.0)


@pytest.mark.parametrize(("gamma", "factor"), ROLLER_FACTORS.items())
def test_rating_of_rollers_is_that_of_the_table(gamma: float, factor: float):
    found = rating_of(of_ratio(gamma, 0.01, contact="roller", roller_length=0.012))
    wanted = 1.1 * factor * 12.0 ** (7 / 9) * 7**0.75 * 10.0 ** (29 / 27)
    assert found.dynamic == pytest.approx(wanted, rel=1.2e-3)
    assert found.static == pytest.approx(44 * (1 - gamma) * 7 * 12 * 10, rel=1e-12)


#: Factor f₀ of ISO 76:2006, table 1.
STATIC_FACTORS = {
    0.0001: 14.7,
    0.05: 15.7,
    0.08: 16.3,
    0.12: 15.9,
    0.15: 15.2,
    0.20: 14.0,
    0.25: 12.8,
}


@pytest.mark.parametrize(("gamma", "factor"), STATIC_FACTORS.items())
def test_static_rating_of_balls_is_that_of_the_table(gamma: float, factor: float):
    found = rating_of(replace(of_ratio(gamma, 0.012), contact_angle=0.0))
    # the ellipse of Brewe and Hamrock
    assert found.static == pytest.approx(factor * 7 * 144.0, rel=0.017)


#: Calculation factor f₀ of SKF bearings (General catalogue 6000 EN, tables of bearings with a snap ring groove).
SKF_FACTORS = {
    "6004": 14,
    "6204": 13,
    "6304": 12,
    "6205": 14,
    "6305": 12,
    "6006": 15,
    "6206": 14,
    "6306": 13,
    "6007": 15,
    "6207": 14,
    "6307": 13,
    "6008": 15,
    "6208": 14,
    "6308": 13,
}


@pytest.mark.parametrize(("name", "factor"), SKF_FACTORS.items())
def test_static_factor_of_designations_is_that_of_the_catalogue(name: str, factor: int):
    found = rating_of(gb.RollingBearing("rotor", 0.0, name))
    # the catalogue rounds it, and the elements are estimates
    assert found._f0 == pytest.approx(factor, abs=1.0)


def designations() -> list[str]:
    codes = [*range(23), 24, 26, 28, 30]
    return [f"{series}{code:02}" for series in (60, 62, 63) for code in codes]


@pytest.mark.parametrize("name", designations())
def test_ratings_of_the_catalogue_are_near_the_computed_ones(name: str):
    """A wrong digit of the table would differ more than the estimated elements do."""
    bearing = gb.RollingBearing("rotor", 0.0, name)
    own = bearing.estimate
    found = rating_of(bearing)
    elements = gb.RollingBearing(
        "rotor",
        0.0,
        elements=own.elements,
        element_diameter=own.element_diameter,
        pitch_diameter=own.pitch_diameter,
        clearance=0.0,
    )
    computed = rating_of(elements)
    assert (found.source, computed.source) == ("catalogue", "computed")
    # ball diameters are estimated within 6 %, their rating within 1.8 times as much, and their number within one
    assert computed.dynamic == pytest.approx(found.dynamic, rel=0.16)
    assert computed.static == pytest.approx(found.static, rel=0.20)


def test_a_given_rating_wins():
    own = gb.RollingBearing("rotor", 0.0, "6308", dynamic_rating=50e3)
    found = rating_of(own)
    assert (found.dynamic, found.source, found.static) == (50e3, "given", 24e3)
    assert rating_of(replace(own, static_rating=30e3)).static == 30e3
    assert rating_of(gb.RollingBearing("rotor", 0.0, "6308")).dynamic == 42.3e3
    # a file may have dimensions in place of the designation
    sizes = {"bore": 0.04, "outer": 0.09, "width": 0.023}
    by_size = gb.RollingBearing.from_dimensions("rotor", 0.0, **sizes)
    assert rating_of(by_size).dynamic == 42.3e3
    of_balls = gb.RollingBearing.from_dimensions("rotor", 0.0, **sizes, kind="angular_contact")
    assert rating_of(of_balls).source == "computed"
    assert rating_of(gb.RollingBearing("rotor", 0.0, "NU209")).source == "computed"
    assert rating_of(gb.Bearing("rotor", 0.0, stiffness=1e8)) is None
    # rollers whose length is not known, and a thrust bearing, have no formula of a radial bearing
    rollers = of_ratio(0.1, 0.01, contact="roller", hertz_stiffness=6e8)
    assert rating_of(rollers) is None
    assert rating_of(of_ratio(0.1, 0.01, contact_angle=1.0)) is None


# --- equivalent loads ------------------------------------------------------------------------------

#: (f₀ F_a/C₀, e, Y) of deep groove ball bearings (SKF 17000/1 EN, table 9, as ISO 281), X = 0.56.
THRUSTS = [
    *[(0.172, 0.19, 2.30), (0.345, 0.22, 1.99), (0.689, 0.26, 1.71), (1.03, 0.28, 1.55)],
    *[
        (1.38, 0.30, 1.45),
        (2.07, 0.34, 1.31),
        (3.45, 0.38, 1.15),
        (5.17, 0.42, 1.04),
        (6.89, 0.44, 1.00),
    ],
]


@pytest.mark.parametrize(("relative", "limit", "factor"), THRUSTS)
def test_deep_groove_bearing_with_thrust(relative: float, limit: float, factor: float):
    rating = rating_of(gb.RollingBearing("rotor", 0.0, "6308"))
    thrust = relative * rating.static / rating._f0
    radial = 0.5 * thrust / limit
    assert rating.equivalent_load(radial, thrust) == pytest.approx(0.56 * radial + factor * thrust)
    assert rating.equivalent_load(radial, -thrust) == rating.equivalent_load(radial, thrust)
    # below e, thrust does not count
    radial = 1.01 * thrust / limit
    assert rating.equivalent_load(radial, thrust) == radial
    assert rating.static_load(0.0, thrust) == 0.5 * thrust


def test_deep_groove_bearing_in_a_system_with_thrust():
    # 6308 under 3 kN radial and 2 kN axial: f₀ F_a/C₀ = 1.1, e = 0.284, Y = 1.53 by interpolation
    bearing = gb.RollingBearing("rotor", 0.0, "6308", axial_stiffness=1e8)
    found = carrying(bearing, 3000.0, 2000.0)
    assert (found.radial_force, found.axial_force) == pytest.approx((3000.0, 2000.0), rel=1e-6)
    relative = rating_of(bearing)._f0 * 2000.0 / 24e3
    factor = np.interp(relative, [1.03, 1.38], [1.55, 1.45])
    load = 0.56 * 3000.0 + factor * 2000.0
    assert found.equivalent_load == pytest.approx(load, rel=1e-6)
    assert found.hours == pytest.approx(rated_hours(load, 42.3e3, 3.0, SPEED), rel=1e-6)
    assert found.static_safety == pytest.approx(24e3 / 3000.0, rel=1e-6)


def test_example_of_the_skf_catalogue():
    """SKF 17000/1 EN, example 1: 6309 at 3000 rpm under 10 kN has 169 million turns, 940 h."""
    bearing = gb.RollingBearing("rotor", 0.0, "6309")
    other = gb.Bearing("rotor", 0.5, stiffness=1e8)
    system = rotor(bearing, other, forces=[gb.Force(("rotor", 0.0), -10e3j)])
    found = system.bearing_life(gb.rpm(3000)).shortest
    assert round(found.revolutions) == 169
    assert found.hours == pytest.approx(940.0, abs=1.0)


def of_angle(degrees: float, *, rolls: bool) -> LoadRating:
    return LoadRating(3e4, 2e4, "given", rolls, math.radians(degrees), None)


SLOPE = math.tan(math.radians(15.0))

#: (α, f₀ F_a/C₀, X, Y) of inclined balls, whose relative loads are listed for each angle.
INCLINED = [
    (10.0, 0.350, 0.46, 1.71),
    (10.0, 3.50, 0.46, 1.10),
    (15.0, 0.357, 0.44, 1.40),
    (15.0, 1.43, 0.44, 1.19),
    (15.0, 5.35, 0.44, 1.00),
]


@each_case("degrees relative x y", INCLINED)
def test_inclined_balls_with_thrust(degrees: float, relative: float, x: float, y: float):
    rating = of_angle(degrees, rolls=False)
    thrust = relative * rating.static / rating._f0
    # the relative loads have three digits
    assert rating.equivalent_load(thrust, thrust) == pytest.approx((x + y) * thrust, rel=1e-3)


@each_case(
    "given thrust dynamic static",
    [
        (of_angle(40, rolls=False), 1500.0, 0.35 * 1e3 + 0.57 * 1500.0, 1e3),
        (of_angle(40, rolls=False), 1130.0, 1e3, 1e3),
        (of_angle(30, rolls=False), 4e3, 0.39 * 1e3 + 0.76 * 4e3, 0.5 * 1e3 + 0.33 * 4e3),
        # half way between the columns of 30° and 35°
        (of_angle(32.5, rolls=False), 4e3, 0.38 * 1e3 + 0.71 * 4e3, 0.5 * 1e3 + 0.31 * 4e3),
        (of_angle(15, rolls=True), 1.4 * SLOPE * 1e3, 1e3, 1e3),
        (of_angle(15, rolls=True), 1e3, 0.4 * 1e3 + 0.4 / SLOPE * 1e3, 0.5e3 + 0.22 / SLOPE * 1e3),
        (of_angle(0, rolls=True), 500.0, 1e3, 1e3),
    ],
)
def test_inclined_contacts(given: LoadRating, thrust: float, dynamic: float, static: float):
    """Single-row bearings of ISO 281 and ISO 76 under 1 kN radial."""
    assert given.equivalent_load(1e3, thrust) == pytest.approx(dynamic)
    assert given.static_load(1e3, thrust) == pytest.approx(static)


@pytest.mark.parametrize("reliability", [0.95, 0.96, 0.97, 0.98, 0.99, 0.995, 0.999, 0.9995])
def test_reliability_is_that_of_a_distribution_of_weibull(reliability: float):
    """Exponent 1.5 and a smallest life of 0.05 (ISO/TR 1281-2:2008); the table has two digits."""
    ratio = math.log(reliability) / math.log(0.9)
    expected = 0.95 * ratio ** (2.0 / 3.0) + 0.05
    assert reliability_factor(reliability) == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize(
    ("contact", "power", "means", "factors", "limit"),
    [
        ("ball", 1.5, (3.0, 10 / 3), (0.407, 0.389), 1.5e-3),
        # Harris (2001) prints integrals that were evaluated with few digits
        ("roller", 1.1, (4.0, 4.5), (0.378, 0.364), 4e-3),
    ],
)
def test_factors_of_the_ratings_of_rings_are_integrals(contact, power, means, factors, limit):
    """The load of a contact that has the mean effect, J_r/J₁ and J_r/J₂, with half of the circumference loaded."""
    psi = np.linspace(-np.pi / 2, np.pi / 2, 20001)
    load = np.cos(psi) ** power

    def mean(values: np.ndarray) -> float:
        return float(np.sum(values) * (psi[1] - psi[0]) / (2.0 * np.pi))

    for factor, exponent in zip(factors, means, strict=True):
        found = mean(load * np.cos(psi)) / mean(load**exponent) ** (1.0 / exponent)
        assert found == pytest.approx(factor, rel=limit), contact


def test_linear_bearing_that_stands_for_a_rolling_bearing():
    own = gb.Bearing("rotor", 0.0, stiffness=1e8, dynamic_rating=20e3, static_rating=10e3)
    found = carrying(own, 1000.0)
    assert (found.hours, found.static_safety) == pytest.approx(
        (rated_hours(1e3, 20e3, 3.0, SPEED), 10.0), rel=1e-6
    )
    rollers = replace(own, contact="roller", contact_angle=math.radians(15.0), axial_stiffness=1e8)
    found = carrying(rollers, 1000.0, 800.0)
    load = 0.4 * 1e3 + 0.4 / SLOPE * 800.0
    assert found.hours == pytest.approx(rated_hours(load, 20e3, 10.0 / 3.0, SPEED), rel=1e-6)
    # without a static rating, the factor Y of a small thrust, which is the largest one
    unknown = replace(own, static_rating=None, axial_stiffness=1e8)
    assert carrying(unknown, 1e3, 500.0).equivalent_load == pytest.approx(
        0.56e3 + 2.3 * 500.0, rel=1e-6
    )


# --- loads of the elements: ISO/TS 16281 -----------------------------------------------------------

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
    degrees_of_freedom=5,
    axial_preload=800.0,
)
TAPERED = gb.RollingBearing("rotor", 0.05, "32014X", degrees_of_freedom=5, axial_preload=800.0)


def summed(bearing: gb.RollingBearing, moved: np.ndarray, *, outer_turns: bool = False) -> float:
    """Sum the life [million turns] over the elements of rings that moved by (u, v, w, B, G)."""
    own = bearing.estimate or bearing
    alpha, d, pitch, count = (
        abs(bearing.contact_angle or own.contact_angle),
        *(own.element_diameter, own.pitch_diameter, own.elements),
    )
    side = -1.0 if (bearing.contact_angle or 0.0) < 0.0 else 1.0
    u, v, w, b, g = moved
    # angles of the elements while the cage turns
    phi = 2.0 * np.pi * np.arange(2000) / 2000
    e_y, e_z = np.cos(phi), np.sin(phi)
    rolls = own.roller_length is not None
    arm = pitch / 2 + (0.0 if rolls else (bearing.inner_groove - 0.5) * d * np.cos(alpha))
    radial = v * e_y + w * e_z
    axial = side * (u - arm * (g * e_y - b * e_z))
    if rolls:
        mounted = brentq(
            lambda x: count * bearing.stiffness_of_contact * (x * np.sin(alpha)) ** (10 / 9)
            * np.sin(alpha) - bearing.axial_preload, 0.0, 1e-3, xtol=1e-14)  # fmt: skip
        approach = radial * np.cos(alpha) + (axial + mounted) * np.sin(alpha)
        load = bearing.stiffness_of_contact * np.maximum(approach, 0.0) ** (10 / 9)
        powers, slope, factors, total = (4.0, 4.5), 1.038, (0.378, 0.364), (4.5, 8 / 9)
        weak = 143 / 108
    else:
        distance = (2 * bearing.inner_groove - 1) * d

        def load_at(radial: Any, axial: Any) -> Any:
            line = np.hypot(distance * np.cos(alpha) + radial, distance * np.sin(alpha) + axial)
            return bearing.stiffness_of_contact * np.maximum(line - distance, 0.0) ** 1.5

        def thrust(x: float) -> float:
            part = np.arctan2(distance * np.sin(alpha) + x, distance * np.cos(alpha))
            return count * load_at(0.0, x) * np.sin(part) - bearing.axial_preload

        mounted = brentq(thrust, 0.0, 1e-3, xtol=1e-14)
        load = load_at(radial, axial + mounted)
        powers, slope, factors, total = (3.0, 10 / 3), 1.044, (0.407, 0.389), (10 / 3, 0.9)
        weak = 1.72
    gamma = d * np.cos(alpha) / pitch
    ratio = (slope * ((1 - gamma) / (1 + gamma)) ** weak) ** total[0]
    rating = rating_of(bearing).dynamic / (count * np.cos(alpha))
    inner = rating / factors[0] * (1 + ratio) ** (1 / total[0])
    outer = rating / factors[1] * (1 + 1 / ratio) ** (1 / total[0])
    of_outer = powers[0] if outer_turns else powers[1]
    on_inner = np.mean(load ** powers[0]) ** (1 / powers[0])
    on_outer = np.mean(load**of_outer) ** (1 / of_outer)
    return float(((inner / on_inner) ** -total[0] + (outer / on_outer) ** -total[0]) ** -total[1])


def moved_by(static: gb.results.Static, place: tuple[str, float]) -> np.ndarray:
    """Give (u, v, w, B, G) of a place."""
    dofs = static.coordinates.dofs
    rows = [dofs.index((*place, name)) for name in ("u", "v", "w", "B", "G")]
    return static.state[rows]


@pytest.mark.parametrize("kind", [B218, TAPERED], ids=["balls", "rollers"])
def test_life_of_rings_is_the_sum_over_their_elements(kind: gb.RollingBearing):
    angle = kind.contact_angle or kind.estimate.contact_angle
    other = replace(kind, position=0.45, contact_angle=-angle)
    force = gb.Force(("rotor", 0.15), 3000.0 - 12000j, axial=5000.0)
    system = rotor(kind, other, forces=[force])
    static = system.static(SPEED)
    life = static.bearing_life()
    for bearing in (kind, other):
        at = ("rotor", bearing.position)
        found = life.bearing(at)
        assert found.method == "ISO/TS 16281"
        # K of the core is that of the sums, the means over 720 and 2000 angles differ
        wanted = summed(bearing, moved_by(static, at))
        assert found.revolutions == pytest.approx(wanted, rel=2e-5)
        assert found.hours == pytest.approx(1e6 * wanted / (60.0 * 1500.0), rel=2e-5)


@pytest.mark.parametrize("kind", [B218, TAPERED], ids=["balls", "rollers"])
def test_rings_under_pure_radial_load_have_the_life_of_the_equivalent_load(
    kind: gb.RollingBearing,
):
    """Half of the elements are loaded, for which ISO 281 holds, and the thrusts balance each other."""
    angle = kind.contact_angle or kind.estimate.contact_angle
    rating = rating_of(kind)
    without = replace(kind, axial_preload=0.0)
    other = replace(without, position=0.45, contact_angle=-angle)
    # At a load near C, the exponents 4 of ISO/TS 16281 and 10/3 of ISO 281 give the same life of rollers. The contact angle of
    # balls rises with the load.
    share = 0.9 if rating.rolls else 0.02
    force = gb.Force(("rotor", 0.25), -2j * share * rating.dynamic)
    found = rotor(without, other, forces=[force]).static(SPEED).bearing_life().bearings
    induced = [one.axial_force / one.radial_force for one in found]
    assert induced[0] == pytest.approx(induced[1], rel=1e-6)
    # Sjövall's integrals for half of the elements loaded, and the rule F_r/(2Y) of catalogues for rollers
    phi, power = np.linspace(-np.pi / 2, np.pi / 2, 2001), 10 / 9 if rating.rolls else 1.5
    ratio = np.sum(np.cos(phi) ** power) / np.sum(np.cos(phi) ** (power + 1))
    assert induced[0] == pytest.approx(ratio * math.tan(angle), rel=0.02)
    if rating.rolls:
        assert induced[0] == pytest.approx(0.5 / 0.4 * math.tan(angle), rel=0.05)
    for one in found:
        assert one.equivalent_load == pytest.approx(one.radial_force, rel=0.02)


# --- speeds ----------------------------------------------------------------------------------------


def spools(ratio: float, bearing: Any) -> gb.RotorSystem:
    """Build two coaxial shafts with a bearing between them."""
    shafts = [
        gb.Shaft("low", length=1.0, outer_diameter=0.05, elements=2),
        gb.Shaft(
            "high",
            length=0.5,
            outer_diameter=0.2,
            inner_diameter=0.15,
            elements=2,
            speed_ratio=ratio,
        ),
    ]
    bearings = [
        *(gb.Bearing("low", x, stiffness=1e8) for x in (0.0, 1.0)),
        gb.RollingBearing("high", 0.0, "6216"),
        replace(bearing, shaft="high", position=0.4, support=("low", 0.5)),
    ]
    return gb.RotorSystem(shafts, bearings=bearings, gravity=9.81)


@pytest.mark.parametrize(("ratio", "relative"), [(-1.5, 2.5), (2.0, 1.0), (0.25, 0.75), (1.0, 0.0)])
def test_bearing_between_shafts_counts_relative_turns(ratio: float, relative: float):
    found = spools(ratio, gb.RollingBearing("high", 0.4, "NU210")).bearing_life(SPEED)
    own = found.bearing(("high", 0.4))
    assert abs(own.speed) == pytest.approx(relative * SPEED)
    wanted = (
        rated_hours(own.radial_force, own.dynamic_rating, 10 / 3, own.speed)
        if relative
        else math.inf
    )
    assert own.hours == pytest.approx(wanted)
    ground = found.bearing(("high", 0.0))
    assert ground.speed == pytest.approx(ratio * SPEED)
    assert ground.hours == pytest.approx(
        rated_hours(ground.radial_force, 72.8e3, 3.0, ratio * SPEED)
    )


def test_rings_that_both_turn_have_the_means_of_rotating_rings():
    bearing = replace(B218, clearance=2e-5, contact_angle=0.0, axial_preload=0.0)
    system = spools(-1.5, bearing)
    static = system.static(SPEED)
    at = ("high", 0.4)
    moved = moved_by(static, at) - moved_by(static, ("low", 0.5))
    forces = static._contact_forces(at)
    rating = rating_of(bearing)
    turning = rating.revolutions_of_elements(forces, (True, True))
    assert static.bearing_life().bearing(at).revolutions == turning
    # the mean of the power 3 is below that of the power 10/3
    assert turning > rating.revolutions_of_elements(forces, (True, False))
    assert np.abs(moved).max() > 0.0


def test_a_housing_at_rest_does_not_turn():
    support = gb.Support("block", mass=5.0, stiffness=1e8)
    bearing = gb.RollingBearing("rotor", 0.0, "6308")
    plain, supported = (
        carrying(one, 2000.0) for one in (bearing, replace(bearing, support=support))
    )
    assert supported.speed == SPEED
    assert supported.hours == pytest.approx(plain.hours, rel=1e-6)


# --- modified life and spectra ---------------------------------------------------------------------


def test_modified_life():
    # ISO 281:2007, table 12
    for reliability, factor in ((0.9, 1.0), (0.95, 0.64), (0.99, 0.25), (0.999, 0.093)):
        assert reliability_factor(reliability) == pytest.approx(factor, rel=1e-12)
    # between its values, a Weibull distribution through both neighbours
    slope = math.log(0.64) / math.log(math.log(0.95) / math.log(0.9))
    wanted = (math.log(0.93) / math.log(0.9)) ** slope
    assert reliability_factor(0.93) == pytest.approx(wanted, rel=1e-12)
    system = rotor(*(gb.RollingBearing("rotor", x, "6208") for x in (0.0, 0.5)), gravity=9.81)
    plain = system.bearing_life(SPEED)
    found = system.bearing_life(SPEED, factor=2.5, reliability=0.95)
    np.testing.assert_allclose(found.hours, plain.hours, rtol=1e-12)
    for one in found.bearings:
        assert one.modified_hours == pytest.approx(2.5 * 0.64 * one.hours)
    assert "lubrication and contamination" in str(plain)
    assert "reliability 0.95, given factor 2.5" in str(found)


def geared(**parts: Any) -> gb.RotorSystem:
    """Build a pair on rolling bearings, with gravity."""
    bearings = [
        gb.RollingBearing(shaft, x, "6309", damping=500.0)
        for shaft in ("input", "output")
        for x in (0.0, 0.5)
    ]
    return pair(bearings=bearings, gravity=9.81, **parts)


def test_spectrum_is_the_sum_of_palmgren_and_miner():
    cases = [(gb.rpm(1500), 250.0, 0.2), ("3000 rpm", "100 N m", "30 %"), (gb.rpm(600), 400.0, 0.5)]
    found = geared(torque=250.0).bearing_life(spectrum=cases)
    assert (found.torque_at, found.speed_unit) == ("g1", "rpm")
    values = [(gb.rpm(1500), 250.0, 0.2), (gb.rpm(3000), 100.0, 0.3), (gb.rpm(600), 400.0, 0.5)]
    single = [geared(torque=torque).bearing_life(speed) for speed, torque, _ in values]
    shares = np.array([share for *_, share in values])
    hours = 1.0 / np.sum(shares[:, None] / np.array([one.hours for one in single]), axis=0)
    # the equilibria are found to 1e-6 of the loads
    np.testing.assert_allclose(found.hours, hours, rtol=1e-5)
    turns = sum(
        share * 60 * rpm for (_, _, share), rpm in zip(values, (1500, 3000, 600), strict=True)
    )
    for one in found.bearings:
        ratio = 1.0 if one.at[0] == "input" else 0.5
        assert one.revolutions == pytest.approx(1e-6 * one.hours * turns * ratio)
        assert one.equivalent_load == pytest.approx(55.3e3 * one.revolutions ** (-1 / 3))
        assert one.static_safety == min(each.bearing(one.at).static_safety for each in single)
    frame = found.to_dataframe()
    assert len(frame) == 12
    damage = frame.groupby("bearing")["share of damage"].sum()
    np.testing.assert_allclose(damage, 1.0)
    # a spectrum of the torque of the system is its life
    alone = geared(torque=250.0).bearing_life(spectrum=[(gb.rpm(1500), 250.0, 1.0)])
    np.testing.assert_allclose(alone.hours, single[0].hours, rtol=1e-9)


def test_a_table_has_the_columns_of_the_forces_that_act():
    life = rated(hostile()).bearing_life(-SPEED)
    head = {column.name: column for column in life._columns()}
    # every bearing of the spur gears carries a radial force only
    plain = {column.name for column in geared(torque=250.0).bearing_life(SPEED)._columns()}
    assert "radial force" in plain
    assert "axial force" not in plain
    for name, column in head.items():
        if name.endswith(" force"):
            own = [getattr(one, name.replace(" ", "_")) for one in life.bearings]
            assert list(column.values) == own
    assert {"radial force", "axial force"} <= set(head)


def test_standstill_uses_up_no_life():
    system = geared(torque=250.0)
    running = system.bearing_life(SPEED)
    half = system.bearing_life(spectrum=[(SPEED, 250.0, 0.5), (0.0, 250.0, 0.5)])
    np.testing.assert_allclose(half.hours, 2.0 * running.hours, rtol=1e-5)


def test_spectrum_scales_all_constant_torques():
    """A branch that takes a tenth of the torque does so in every case."""
    torques = [gb.Torque("g2", -50.0), gb.Torque("g1", 250.0), gb.Torque.balance(("output", 0.5))]
    system = geared(torque=0.0, torques=torques)
    half = [replace(torques[0], value=-25.0), replace(torques[1], value=125.0), torques[2]]
    found = system.bearing_life(spectrum=[(SPEED, 125.0, 1.0)])
    wanted = system.replace(torques=half).bearing_life(SPEED)
    assert found.torque_at == "g1"  # the first one on the reference shaft
    np.testing.assert_allclose(found.hours, wanted.hours, rtol=1e-9)


# --- machines --------------------------------------------------------------------------------------


def mirrored(system: gb.RotorSystem) -> gb.RotorSystem:
    """Mirror a machine, y to -y: all rotations change their sense."""
    flip = np.array([[1.0, -1.0], [-1.0, 1.0]])

    def turned(bearing: Any) -> Any:
        if isinstance(bearing, gb.JournalBearing):
            return bearing
        changes: dict[str, Any] = {}
        for name in ("stiffness", "damping"):
            value = getattr(bearing, name, None)
            if np.ndim(value) == 2 if not isinstance(value, gb.SpeedTable) else False:
                changes[name] = np.array(value) * flip
            if isinstance(value, gb.SpeedTable) and np.ndim(value.values) == 3:
                values = np.array(value.values) * flip
                changes[name] = gb.SpeedTable(value.speeds, values, value.outside)
        return replace(bearing, **changes)

    return system.replace(
        gears=[replace(one, helix_angle=-one.helix_angle) for one in system.gears],
        meshes=[
            replace(one, centre_line_angle=math.pi - one.centre_line_angle) for one in system.meshes
        ],
        bearings=[turned(one) for one in system.bearings],
        torques=[
            one if one.value == "balance" else replace(one, value=-one.value)
            for one in system.torques
        ],
        forces=[replace(one, value=-np.conj(one.value)) for one in system.forces],
        couplings=[
            replace(one, offset=-np.conj(one.offset), angle=-np.conj(one.angle))
            for one in system.couplings
        ],
        housings=[
            replace(one, position=(one.position[0], -one.position[1], one.position[2]))
            for one in system.housings
        ],
    )


def rolling_machines() -> list[str]:
    return [
        name
        for name, machine in gb.examples().items()
        if any(
            word in machine.path.read_text()
            for word in ("designation", "element_diameter", "boundary")
        )
    ]


@pytest.mark.parametrize("name", ["hostile", *rolling_machines()])
def test_mirrored_machine_has_the_same_life(name: str):
    system = rated(hostile()) if name == "hostile" else gb.examples()[name].load()
    speed = 200.0 if name == "hostile" else gb.examples()[name].speed
    found = system.static(speed).bearing_life()
    image = mirrored(system).static(-speed).bearing_life()
    assert [one.at for one in image.bearings] == [one.at for one in found.bearings]
    # the forces are balanced to 1e-6, and the life has their third power
    np.testing.assert_allclose(image.hours, found.hours, rtol=1e-5)
    np.testing.assert_allclose(
        [-one.speed for one in image.bearings], [one.speed for one in found.bearings]
    )
    for one in found.bearings:
        wanted = rated_hours(one.equivalent_load, one.dynamic_rating, one.exponent, one.speed)
        assert one.hours == pytest.approx(wanted, rel=1e-9)


# --- the same formula for the limit of a bow -------------------------------------------------------


def test_limit_of_a_bow_by_the_life_has_the_same_formula():
    bearing = gb.RollingBearing("rotor", 0.0, "6308", axial_stiffness=1e8)
    other = gb.RollingBearing("rotor", 0.5, "NU208")
    # a thrust that counts
    force = gb.Force(("rotor", 0.2), -3000j, axial=2500.0)
    system = rotor(bearing, other, forces=[force])
    life = system.bearing_life(SPEED)
    for one in life.bearings:
        for part, is_reached in ((0.999, False), (1.001, True)):
            limit = gb.BowLimit.bearing_life(one.at, part * one.hours)
            found = system.bow_limits("rotor", SPEED, limits=[limit]).limits[0]
            # without a bow, the limit is exceeded or not
            assert (found.bow == 0.0) == is_reached, (one.at, part)


# --- files, figures and errors ---------------------------------------------------------------------


def test_ratings_are_kept_in_files(tmp_path: Path):
    bearings = [
        gb.RollingBearing("rotor", 0.0, "6308", dynamic_rating=41e3, static_rating=24e3),
        gb.Bearing(
            "rotor", 0.5, stiffness=1e8, dynamic_rating=6e4, contact="roller", contact_angle=0.2
        ),
    ]
    system = rotor(*bearings, gravity=9.81)
    path = tmp_path / "rotor.toml"
    system.save(path)
    assert gb.RotorSystem.load(path).bearings == tuple(bearings)
    text = path.read_text().replace("dynamic_rating = 41000", 'dynamic_rating = "41 kN" #')
    path.write_text(text)
    assert gb.RotorSystem.load(path).bearings[0].dynamic_rating == 41e3


def test_results(tmp_path: Path):
    pytest.importorskip("matplotlib")
    system = rotor(
        gb.RollingBearing("rotor", 0.0, "6308"),
        gb.Bearing("rotor", 0.5, stiffness=1e8),
        gravity=9.81,
    )
    found = system.bearing_life(SPEED, factor=2.0)
    text = str(found)
    assert "at 1500 rpm" in text
    assert "no life of rotor at 0.5 m: its dynamic_rating is not given" in text
    assert repr(found).startswith("BearingLife(1 bearing; shortest ")
    found.save(tmp_path / "life.csv")
    assert "life [h]" in (tmp_path / "life.csv").read_text()
    bars = found.plot().axes[0].patches
    assert [bar.get_width() for bar in bars] == pytest.approx(
        [found.hours[0], found.bearings[0].modified_hours]
    )
    bowed = system.replace(shafts=[replace(system.shafts[0], bow=gb.Bow.half_sine(1e-4))])
    assert "excitation left out: bow" in str(bowed.static(SPEED).bearing_life())
    rollers = rotor(
        gb.RollingBearing("rotor", 0.0, "NU208", axial_stiffness=1e8),
        gb.RollingBearing("rotor", 0.5, "6208"),
        forces=[gb.Force(("rotor", 0.2), -500j, axial=300.0)],
    )
    assert "P is without the thrust, which its rollers do not carry" in str(
        rollers.bearing_life(SPEED)
    )
    with pytest.raises(gb.ChannelError, match="no bearing at"):
        found.bearing(("rotor", 0.5))


def test_bearings_at_one_place_share_a_force():
    bearings = [gb.RollingBearing("rotor", x, "6308") for x in (0.0, 0.0, 0.5)]
    found = rotor(*bearings, gravity=9.81).bearing_life(SPEED)
    assert [one.at for one in found.bearings] == [("rotor", 0.5)]
    assert "several bearings share its force" in found.notes[0]


@each_case(
    "options error",
    [
        ({}, r"speed: give either a speed or a spectrum"),
        ({"speed": 1.0, "spectrum": []}, r"speed: give either a speed or a spectrum"),
        ({"speed": 0.0}, r"speed: must not be zero"),
        ({"speed": np.nan}, r"speed: must be finite, got nan"),
        ({"speed": 10.0, "factor": 0.0}, r"factor: must be positive"),
        (
            {"speed": 10.0, "reliability": 0.8},
            r"reliability: must be between 0.9 and 0.9995, got 0.8",
        ),
        ({"spectrum": "1500 rpm"}, r"spectrum: must be a list of \(speed, torque, share\)"),
        ({"spectrum": [(1.0, 2.0)]}, r"spectrum\[0\]: must be \(speed, torque, share\)"),
        ({"spectrum": []}, r"spectrum: the shares of the time must sum to 1, got 0"),
        (
            {"spectrum": [(1.0, 2.0, 0.5), (2.0, 1.0, 0.4)]},
            r"spectrum: the shares of the time must sum to 1, got 0.9; add a case with speed 0",
        ),
        (
            {"spectrum": [(1.0, 2.0, 1.5), (2.0, 1.0, -0.5)]},
            r"spectrum\[1\].share: must not be neg",
        ),
        ({"spectrum": [("1500 Hz", 2.0, 1.0)]}, r"spectrum\[0\].speed: 'Hz' is not a known unit"),
        ({"spectrum": [("1500 rpm", "2 N", 1.0)]}, r"spectrum\[0\].torque: must have a unit"),
        ({"spectrum": [(1.0, math.inf, 1.0)]}, r"spectrum\[0\].torque: must be finite, got inf"),
    ],
)
def test_wrong_arguments(options: dict[str, Any], error: str):
    with pytest.raises(gb.SceneError, match=error):
        geared(torque=250.0).bearing_life(**options)


def test_wrong_systems():
    none = rotor(*(gb.Bearing("rotor", x, stiffness=1e8) for x in (0.0, 0.5)), gravity=9.81)
    with pytest.raises(gb.SceneError, match="bearings: no bearing has a dynamic rating; give"):
        none.bearing_life(SPEED)
    twisting = rotor(gb.RollingBearing("rotor", 0.0, "6208"), motion="torsion")
    with pytest.raises(gb.SceneError, match='motion: "torsion" has no forces on bearings'):
        twisting.bearing_life(SPEED)
    limit = gb.BowLimit.bearing_life(("rotor", 0.0), 1e4)
    with pytest.raises(
        gb.GearbowError, match="has no dynamic rating; give capacity= and exponent="
    ):
        none.bow_limits("rotor", SPEED, limits=[limit])
    one_case = [(SPEED, 10.0, 1.0)]
    rolling = rotor(*(gb.RollingBearing("rotor", x, "6208") for x in (0.0, 0.5)), gravity=9.81)
    with pytest.raises(gb.SceneError, match="torques: a spectrum needs a constant torque"):
        rolling.bearing_life(spectrum=one_case)
    changing = [gb.Torque("g1", lambda t: 5.0 * t), gb.Torque.balance("g2")]
    with pytest.raises(gb.SceneError, match=r"torques\[0\].value: a spectrum scales constant"):
        geared(torque=0.0, torques=[changing[0]]).bearing_life(spectrum=one_case)
    idle = [gb.Torque("g1", 0.0), changing[1]]
    with pytest.raises(gb.SceneError, match=r"torques\[0\].value: must not be zero"):
        geared(torque=0.0, torques=idle).bearing_life(spectrum=one_case)


@each_case(
    "bearing error",
    [
        (
            gb.RollingBearing("rotor", 0.0, "6308", dynamic_rating=0.0),
            "dynamic_rating: must be positive",
        ),
        (gb.RollingBearing("rotor", 0.0, "6308", static_rating=math.nan), "static_rating: must be"),
        (
            gb.Bearing("rotor", 0.0, stiffness=1e8, dynamic_rating=1e4, contact_angle=40.0),
            "contact_angle: must be between -pi/2 and pi/2 rad, got 40; is it in degrees",
        ),
    ],
)
def test_wrong_ratings(bearing: Any, error: str):
    with pytest.raises(gb.SceneError, match=rf"bearings\[0\].{error}"):
        rotor(bearing, gb.Bearing("rotor", 0.5, stiffness=1e8))


def test_a_rating_in_kilonewtons_is_a_warning():
    other = gb.Bearing("rotor", 0.5, stiffness=1e8)
    for name in ("dynamic_rating", "static_rating"):
        bearing = gb.RollingBearing("rotor", 0.0, "6308", **{name: 42.3})
        with pytest.warns(gb.SceneWarning, match=rf"bearings\[0\].{name}: .* is it in kN\?"):
            rotor(bearing, other)


def test_an_oil_film_has_no_rating():
    plain = rotor(
        gb.JournalBearing("rotor", 0.0, diameter=0.1, length=0.05, clearance=1e-4, viscosity=0.02),
        gb.Bearing("rotor", 0.5, stiffness=1e8),
    ).description
    plain["bearings"][0]["dynamic_rating"] = 1e4
    with pytest.raises(gb.SceneError, match=r"bearings\[0\].dynamic_rating: is that of a rolling"):
        gb.RotorSystem.from_dict(plain)
