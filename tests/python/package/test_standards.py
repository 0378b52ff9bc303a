"""Tables from standards, against values that are typed a second time (`reference.standards`)."""

from __future__ import annotations

import re
from itertools import pairwise
from math import pi, sqrt
from typing import Any

import pytest

import gearbow as gb
from gearbow.description.bow import DISPLACEMENTS, VELOCITIES
from gearbow.report import api617
from reference import standards
from reference.machines import bowed_pair


def test_zones_of_iso_20816_3():
    expected = {
        f"ISO 20816-3 {group} {foundation} {zone}": 1e-3 * value
        for (group, foundation), values in standards.ZONES_OF_VELOCITY.items()
        for zone, value in zip(("A/B", "B/C", "C/D"), values, strict=True)
    }
    assert pytest.approx(expected, rel=1e-12) == VELOCITIES
    for zone, value in standards.ZONES_OF_DISPLACEMENT.items():
        factor, most = DISPLACEMENTS[f"ISO 20816-3 {zone}"]
        assert factor == pytest.approx(1e-6 * value, rel=1e-12)
        assert most == float("inf")


def test_values_of_api_617():
    factor, most = DISPLACEMENTS["API 617"]
    assert factor / sqrt(3000.0) == pytest.approx(standards.API_617_AT_3000_RPM, rel=1e-12)
    assert most == standards.API_617_MOST
    # the response analysis takes twice the unbalance of one plane
    assert api617._UNBALANCE == 2.0 * standards.API_617_UNBALANCE


def test_every_designation_has_its_boundary_dimensions():
    wrong = {}
    for name, boundary in standards.BOUNDARIES.items():
        estimate: Any = gb.RollingBearing("rotor", 0.0, name).estimate
        found = [1e3 * size for size in (estimate.bore, estimate.outer, estimate.width)]
        if found != pytest.approx(boundary, rel=1e-12):
            wrong[name] = found
    assert not wrong
    assert len(standards.BOUNDARIES) == 5 * 27 + 23


def test_boundary_dimensions_grow_with_the_bore():
    for prefix in ("60", "62", "63", "320"):
        sizes = [size for name, size in standards.BOUNDARIES.items() if name.startswith(prefix)]
        for small, large in pairwise(sizes):
            assert small[0] < large[0]
            assert small[1] < large[1]
            assert small[2] <= large[2]
            # a section of less than a tenth or more than the bore is no bearing of these series
        assert all(0.1 * d < outer - d < 2.6 * d for d, outer, _ in sizes)


def test_published_dimensions_are_those_of_the_standard():
    for name, boundary in standards.PUBLISHED_BOUNDARIES.items():
        assert standards.BOUNDARIES[name] == boundary, name
    for code, diameter in standards.PUBLISHED_DIAMETERS_2.items():
        assert standards.BOUNDARIES[f"62{code:02d}"][1] == diameter, code


def test_balance_grades_are_rounded_steps_of_four_tenths_of_a_decade():
    # ISO 21940-11, 7.2: neighbouring grades differ by the factor 2.5; two digits are rounded by 1.5 %
    for fine, coarse in pairwise(standards.BALANCE_GRADES):
        assert coarse / fine == pytest.approx(10.0**0.4, rel=0.015)


def graded() -> dict[str, float]:
    """Give the examples whose header states a balance quality grade."""
    found = {}
    for name, example in gb.examples().items():
        stated = re.search(r"G (\d\.\d)", example.path.read_text(encoding="utf-8"))
        if stated and float(stated[1]) in standards.BALANCE_GRADES:
            found[name] = float(stated[1])
    return found


@pytest.mark.parametrize(("name", "grade"), graded().items())
def test_unbalances_of_examples_have_the_grade_that_they_state(name: str, grade: float):
    example = gb.examples()[name]
    system = example.load()
    ratios = dict(zip((s.name for s in system.shafts), system.speed_ratios, strict=True))
    found = [
        1e3 * abs(body.unbalance) / body.mass * abs(ratios[body.shaft] * example.speed)
        for body in (*system.gears, *system.disks)
        if body.unbalance and body.mass
    ]
    # unbalances have two or three digits
    assert max(found) == pytest.approx(grade, rel=0.03)


@pytest.mark.parametrize("shaft", ["input", "output"])
def test_life_and_displacement_are_those_at_the_speed_of_their_shaft(shaft):
    system, speed, capacity = bowed_pair(), 150.0, 44e3
    ratio = dict(zip((each.name for each in system.shafts), system.speed_ratios, strict=True))[
        shaft
    ]
    bearing = (shaft, 0.0)
    force = gb.BowLimit.bearing_force(bearing, 4e3)
    hours = standards.rated_hours(4e3, capacity, 30.0, ratio * speed)
    # with a large exponent, the mean force is nearly the largest one, for which a limit exists too
    life = gb.BowLimit.bearing_life(bearing, hours, capacity=capacity, exponent=30.0)
    zone = gb.BowLimit.displacement((shaft, 0.25), "ISO 20816-3 B/C")
    found = system.bow_limits("input", speed, limits=[force, life, zone], phase=0.0)
    texts = {one.limit: one for one in found.limits}
    assert "mean load 4000 N" in str(texts["bearing life"])
    turns = abs(ratio) * speed * 30.0 / pi
    largest = standards.ZONES_OF_DISPLACEMENT["B/C"] / sqrt(turns)
    assert texts["displacement"].why.startswith(f"{largest:.4g} µm")
