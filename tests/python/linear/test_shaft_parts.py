"""Shafts of several materials, cones and sleeves, against closed forms and finer models."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import gearbow as gb

TITANIUM = gb.Material(114e9, 4430.0, poisson_ratio=0.34)
LENGTH = 0.5
#: Discretisation error of the lowest modes with elements of degree 6.
DEGREE = 6


def free(segments, *, sleeves=(), shear=True, degree=DEGREE, **options):
    """Give the lowest frequencies of bending and of torsion of a free shaft [Hz]."""
    shaft = gb.Shaft("s", segments=segments, shear=shear, degree=degree, **options)
    system = gb.RotorSystem([shaft], sleeves=sleeves, motion="coupled")
    modes = system.modes()
    classes = np.array(modes.whirl)
    bending = modes.frequencies_hz[np.isin(classes, ("planar", "coupled"))]
    return np.concatenate(
        [bending[bending > 1.0][:4], modes.frequencies_hz[classes == "torsion"][:2]]
    )


def test_a_segment_of_another_material_moves_the_modes_as_its_rigidity_does():
    # Two segments of one material in two descriptions: that of the shaft, and that of each segment.
    own = [gb.Segment(0.2, 0.05, elements=1), gb.Segment(0.3, 0.04, elements=1)]
    by_shaft = free(own, material=TITANIUM)
    by_segment = free([replace(each, material=TITANIUM) for each in own])
    np.testing.assert_array_equal(by_segment, by_shaft)
    # E, G and ρ times the same factor in one segment is a segment with all its rigidities times it.
    assert free([own[0], replace(own[1], material=TITANIUM)])[0] < free(own)[0]


def test_waves_pass_from_one_material_to_another():
    # Torsion of a free shaft of two halves: tan(ωl/c₁)·√(Gρ)₁ + tan(ωl/c₂)·√(Gρ)₂ = 0.
    system = gb.RotorSystem(
        [
            gb.Shaft(
                "s",
                segments=[
                    gb.Segment(0.4, 0.05, elements=1),
                    gb.Segment(0.4, 0.05, elements=1, material=TITANIUM),
                ],
                degree=8,
            )
        ],
        motion="torsion",
    )
    shear = [207e9 / 2.6, 114e9 / 2.68]
    density = [7850.0, 4430.0]
    found = 2.0 * math.pi * system.modes().frequencies_hz[1]
    terms = [
        math.sqrt(g * rho) * math.tan(found * 0.4 * math.sqrt(rho / g))
        for g, rho in zip(shear, density, strict=True)
    ]
    # The tangents are about 1e7 times as large as their change by the error of degree 8.
    assert abs(sum(terms)) < 1e-6 * abs(terms[0])


@pytest.mark.parametrize("shear", [True, False])
def test_a_clamped_cone_has_the_frequencies_of_many_steps(shear: bool):
    def clamped(segments, degree):
        shaft = gb.Shaft("s", segments=segments, shear=shear, degree=degree)
        held = gb.Bearing("s", 0.0, stiffness=1e12, tilting_stiffness=1e10)
        return (
            gb.RotorSystem([shaft], bearings=[held], motion="lateral").modes().frequencies_hz[:6:2]
        )

    def stepped(count):
        middles = (np.arange(count) + 0.5) / count
        steps = [gb.Segment(LENGTH / count, 0.06 - 0.03 * x, elements=1) for x in middles]
        return clamped(steps, 1)

    # Steps have an error of second order: Richardson's extrapolation leaves 2e-7.
    expected = (4.0 * stepped(200) - stepped(100)) / 3.0
    cone = gb.Segment(LENGTH, 0.06, elements=2, end_outer_diameter=0.03)
    np.testing.assert_allclose(clamped([cone], DEGREE), expected, rtol=1e-5)
    coarse = replace(cone, elements=8)
    np.testing.assert_allclose(clamped([coarse], 1)[:1], expected[:1], rtol=1e-4)


@pytest.mark.parametrize("shear", [True, False])
def test_the_motion_within_a_long_cone_is_that_of_many_short_ones(shear: bool):
    # Static solutions are the shape functions, so that a load at a node leaves no error between.
    def deflected(elements):
        cone = gb.Segment(LENGTH, 0.06, elements=elements, end_outer_diameter=0.02)
        system = gb.RotorSystem(
            [gb.Shaft("s", segments=[cone], shear=shear, degree=1)],
            bearings=[gb.Bearing("s", 0.0, stiffness=1e9, tilting_stiffness=1e7)],
            disks=[gb.Disk("end", "s", LENGTH, 0.0, 0.0, 0.0)],
            forces=[gb.Force("end", (300.0, 500.0))],
            torques=[gb.Torque("end", 200.0)],
            drives=[gb.Drive(("s", 0.0), 1e6)],
            motion="coupled",
        )
        found = system.static()
        # 0.3 and 0.8 of the length are nodes of many elements only.
        places = [("s", share * LENGTH) for share in (0.3, 0.8)]
        return [[*found.displacement(at), found.twist(at)] for at in places]

    np.testing.assert_allclose(deflected(1), deflected(10), rtol=1e-9)


# The round-off of a sharp tip stays below the digits of the published number.
@pytest.mark.filterwarnings("ignore:natural frequencies range")
def test_a_cantilever_cone_bends_as_the_closed_form_of_mabie_and_rogers():
    # ω = 8.719 √(EI₀/ρA₀)/l² for a complete cone. At 1/100 of the diameter at the clamp, the tip changes ω by 1e-4.
    radii = np.geomspace(0.03, 0.0003, 9)
    segments = [
        gb.Segment((a - b) / 0.03 * 2.0, 2.0 * a, elements=1, end_outer_diameter=2.0 * b)
        for a, b in pairwise(radii)
    ]
    shaft = gb.Shaft("s", segments=segments, shear=False, degree=8)
    held = gb.Bearing("s", 0.0, stiffness=1e11, tilting_stiffness=1e10)
    system = gb.RotorSystem([shaft], bearings=[held], motion="lateral")
    scale = math.sqrt(207e9 * 0.03**2 / 4.0 / 7850.0) / 2.0**2
    found = 2.0 * math.pi * system.modes().frequencies_hz[0]
    # Rotary inertia takes less than (r/l)², and the published number has four digits.
    assert abs(found / (8.719 * scale) - 1.0) < 2e-4


def test_a_conical_bore_and_both_directions_agree():
    cone = gb.Segment(0.4, 0.06, 0.02, elements=3, end_outer_diameter=0.08, end_inner_diameter=0.05)
    mirrored = gb.Segment(
        0.4, 0.08, 0.05, elements=3, end_outer_diameter=0.06, end_inner_diameter=0.02
    )
    np.testing.assert_allclose(free([mirrored]), free([cone]), rtol=1e-9)


def test_a_cone_of_equal_ends_is_a_cylinder():
    cylinder = gb.Segment(LENGTH, 0.05, elements=3)
    np.testing.assert_array_equal(
        free([replace(cylinder, end_outer_diameter=0.05)]), free([cylinder])
    )
    # The matrices of a cone come from quadrature, also if its end diameters are almost equal.
    slight = replace(cylinder, end_outer_diameter=0.05 * (1.0 + 1e-10))
    np.testing.assert_allclose(free([slight]), free([cylinder]), rtol=1e-8)


def test_a_run_on_a_cone_has_the_forces_of_its_matrices():
    # Runge–Kutta methods take forces from strains, the exponential method takes matrices.
    shaft = gb.Shaft(
        "s",
        segments=[gb.Segment(LENGTH, 0.06, elements=3, end_outer_diameter=0.03)],
        bow=gb.Bow.half_sine(1e-4),
    )
    bearings = [gb.Bearing("s", x, stiffness=1e8, damping=1e3) for x in (0.0, LENGTH)]
    system = gb.RotorSystem([shaft], bearings=bearings)
    middle = ("s", system.dofs[4][1])
    runs = [
        system.simulate(0.02, 200.0, initial="rest", record=[middle], output_step=1e-3, **options)
        for options in ({}, {"method": "rk45", "rtol": 1e-9})
    ]
    first, second = (run.displacement(middle) for run in runs)
    np.testing.assert_allclose(first, second, atol=1e-5 * np.abs(second).max())


def test_layers_with_stiffness_equal_one_shaft_with_the_sums():
    segment = gb.Segment(LENGTH, 0.04, elements=2)
    around = gb.Sleeve("s", 0.0, LENGTH, 0.06, 0.04, stiffness="full")
    whole = gb.Segment(LENGTH, 0.06, elements=2)
    np.testing.assert_allclose(
        free([segment], sleeves=[around], shear=False), free([whole], shear=False), rtol=1e-9
    )


def test_a_fraction_of_the_stiffness_acts():
    segment = gb.Segment(LENGTH, 0.04, elements=2)

    def bending(stiffness):
        sleeve = gb.Sleeve("s", 0.0, LENGTH, 0.06, 0.04, stiffness=stiffness)
        return free([segment], sleeves=[sleeve], shear=False)

    # A material with other rigidities and the density of the sum has the same modes, except for rotary inertia, which
    # all have alike.
    second, outer = 0.04**4, 0.06**4 - 0.04**4
    for stiffness, fraction in (("none", 0.0), (0.25, 0.25), ("full", 1.0)):
        squared = (bending(stiffness) / bending("full")) ** 2
        np.testing.assert_allclose(
            squared, (second + fraction * outer) / (second + outer), rtol=1e-9
        )


def test_the_ends_of_a_sleeve_are_nodes():
    shaft = gb.Shaft("s", length=LENGTH, outer_diameter=0.04, elements=1)
    system = gb.RotorSystem([shaft], sleeves=[gb.Sleeve("s", 0.1, 0.2, 0.06, 0.04)])
    assert sorted({x for _, x, kind in system.dofs if kind == "twist"}) == [0.0, 0.1, 0.2, LENGTH]


def test_errors_name_the_entry():
    shaft = gb.Shaft("s", length=LENGTH, outer_diameter=0.04)
    cases = [
        ([gb.Sleeve("s", 0.2, 0.1, 0.06, 0.04)], r"sleeves\[0\]\.end: must exceed begin"),
        ([gb.Sleeve("s", 0.1, 0.2, 0.04, 0.06)], r"sleeves\[0\]\.inner_diameter: 0\.06 m does not"),
        ([gb.Sleeve("s", 0.1, 0.2, 0.06, 0.03)], r"inner_diameter: 0\.03 m is less than the dia"),
        ([gb.Sleeve("s", 0.1, 0.9, 0.06, 0.04)], r"sleeves\[0\]\.end: 0\.9 m is outside"),
        ([gb.Sleeve("s", 0.1, 0.2, 0.06, 0.04, stiffness=1.5)], r"stiffness: must be \"none\""),
        ([gb.Sleeve("s", 0.1, 0.2, 0.06, 0.04, stiffness="half")], r"sleeves\[0\]\.stiffness"),
        ([gb.Sleeve("t", 0.1, 0.2, 0.06, 0.04)], r"sleeves\[0\]\.shaft: no shaft is called"),
        ([gb.Sleeve("s", 0.1, 0.2, 0.06, 0.04)] * 2, r"sleeves\[1\]\.begin: another sleeve"),
    ]
    for sleeves, message in cases:
        with pytest.raises(gb.SceneError, match=message):
            gb.RotorSystem([shaft], sleeves=sleeves)
    segments = [
        (gb.Segment(0.1, 0.04, end_outer_diameter=0.0), r"segments\[0\]\.end_outer_diameter"),
        (gb.Segment(0.1, 0.04, 0.02, end_outer_diameter=0.01), r"end_outer_diameter: 0\.02 m does"),
        (gb.Segment(0.1, 0.04, 0.0, end_inner_diameter=0.05), r"end_inner_diameter: 0\.05 m does"),
        (
            gb.Segment(0.1, 0.04, material=gb.Material(-1.0, 7850.0, poisson_ratio=0.3)),
            r"segments\[0\]\.material\.youngs_modulus",
        ),
    ]
    for segment, message in segments:
        with pytest.raises(gb.SceneError, match=message):
            gb.RotorSystem([gb.Shaft("s", segments=[segment])])


def test_scene_files_hold_the_parts(tmp_path):
    cone = gb.Segment(0.3, 0.06, end_outer_diameter=0.04, material=TITANIUM)
    shaft = gb.Shaft("s", segments=[gb.Segment(0.2, 0.06), cone])
    sleeve = gb.Sleeve("s", 0.05, 0.15, 0.09, 0.06, TITANIUM, stiffness=0.5)
    system = gb.RotorSystem([shaft], sleeves=[sleeve])
    system.save(tmp_path / "scene.toml")
    again = gb.RotorSystem.load(tmp_path / "scene.toml")
    assert again.sleeves == system.sleeves
    assert again.description == system.description
    text = (tmp_path / "scene.toml").read_text(encoding="utf-8")
    (tmp_path / "units.toml").write_text(text.replace("= 0.05\n", '= "50 mm"\n'), encoding="utf-8")
    assert gb.RotorSystem.load(tmp_path / "units.toml").description == system.description


def test_implausible_materials_of_segments_and_sleeves_are_reported():
    dense = gb.Material(207e9, 7.85, poisson_ratio=0.3)
    shaft = gb.Shaft("s", segments=[gb.Segment(0.2, 0.06, material=dense)])
    with pytest.warns(gb.SceneWarning, match=r"shafts\[0\]\.segments\[0\]\.material\.density"):
        gb.RotorSystem([shaft])


def test_the_answer_at_a_place_within_a_layered_element_is_that_of_a_node():
    # The shape functions of an element follow from the shear length of all layers.
    shaft = gb.Shaft("s", length=LENGTH, outer_diameter=0.04, elements=1, degree=1)
    sleeve = gb.Sleeve("s", 0.1, 0.4, 0.1, 0.04, stiffness="full")
    bearings = [gb.Bearing("s", x, stiffness=1e8) for x in (0.0, LENGTH)]
    force = [gb.Force(("s", LENGTH), 1e3)]
    coarse = gb.RotorSystem([shaft], bearings=bearings, sleeves=[sleeve], forces=force)
    split = coarse.replace(disks=[gb.Disk("d", "s", 0.2, 0.0, 0.0, 0.0)])
    found, expected = (system.static().displacement(("s", 0.2)) for system in (coarse, split))
    # Static displacements are exact.
    np.testing.assert_allclose(found, expected, rtol=1e-9)
