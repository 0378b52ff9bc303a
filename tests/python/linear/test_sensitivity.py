"""Derivatives with respect to parameters, against closed forms and differences of analyses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import gearbow as gb
from reference.cases import each_case
from reference.machines import (
    bowed_pair,
    double_stage,
    hostile,
    inertia,
    rigid_rotor,
    rotor,
    rotor_on_films,
    rotor_on_pedestal,
    stepped_rotor,
)

#: Largest error over the largest derivative of its kind; differences of complete analyses have
#: errors of about 1e-8.
TOLERANCE = 2e-6


def part(key: str, i: int, field: str) -> Callable[[gb.RotorSystem, float], gb.RotorSystem]:
    """Return a function that multiplies a field of a part."""

    def change(system: gb.RotorSystem, factor: float) -> gb.RotorSystem:
        parts = list(getattr(system, key))
        parts[i] = replace(parts[i], **{field: factor * getattr(parts[i], field)})
        return system.replace(**{key: parts})

    return change


def diameter(system: gb.RotorSystem, factor: float) -> gb.RotorSystem:
    """Multiply the diameter of the second segment of the first shaft."""
    shaft = system.shafts[0]
    segments = list(shaft.segments)
    segments[1] = replace(segments[1], outer_diameter=factor * segments[1].outer_diameter)
    return system.replace(shafts=[replace(shaft, segments=segments), *system.shafts[1:]])


def random_train() -> gb.RotorSystem:
    """Return a train with fixed random numbers."""
    random = np.random.default_rng(5)
    shafts = [
        gb.Shaft(name, length=0.5, outer_diameter=random.uniform(0.03, 0.07), elements=3, degree=3)
        for name in ("a", "b")
    ]
    gears = [
        gb.Gear(f"g{shaft.name}", shaft.name, x, teeth, module=3e-3, face_width=0.03)
        for shaft, x, teeth in zip(shafts, random.uniform(0.2, 0.3, 2), (23, 41), strict=True)
    ]
    bearings = [
        gb.Bearing(
            shaft.name,
            x,
            stiffness=random.uniform(1e7, 1e8, (2, 2)) * [[1.0, 0.2], [-0.1, 1.0]],
            damping=random.uniform(1e2, 1e4),
        )
        for shaft in shafts
        for x in (0.0, 0.5)
    ]
    mesh = gb.Mesh("ga", "gb", stiffness=2e8, damping_ratio=0.05, centre_line_angle=0.7)
    return gb.RotorSystem(shafts, gears, [mesh], bearings)


#: Function that makes a system, path of a parameter, and function that gives the same system with the parameter
#: multiplied by a factor.
CASES: dict[str, tuple[Callable[[], gb.RotorSystem], str, Callable[[Any, float], Any]]] = {
    "bearing": (hostile, "bearings[1].stiffness", part("bearings", 1, "stiffness")),
    "diameter": (hostile, "shafts['middle'].outer_diameter", part("shafts", 2, "outer_diameter")),
    "derived mass": (hostile, "gears['g4'].face_width", part("gears", 3, "face_width")),
    "damping": (hostile, "bearings[7].damping", part("bearings", 7, "damping")),
    "mesh": (hostile, "meshes[2].stiffness", part("meshes", 2, "stiffness")),
    "modal damping": (
        lambda: bowed_pair(modal_damping=0.02),
        "modal_damping",
        lambda system, factor: system.replace(modal_damping=factor * system.modal_damping),
    ),
    "segment": (stepped_rotor, "shafts['s'].segments[1].outer_diameter", diameter),
    "oil film": (rotor_on_films, "bearings[0].clearance", part("bearings", 0, "clearance")),
    "load of a film": (rotor_on_films, "disks['d'].mass", part("disks", 0, "mass")),
    "position": (
        lambda: double_stage(shaft={"elements": 3, "degree": 4}),
        "gears['g3'].position",
        part("gears", 2, "position"),
    ),
    "random bearing": (random_train, "bearings[2].damping", part("bearings", 2, "damping")),
    "random position": (random_train, "gears['ga'].position", part("gears", 0, "position")),
}


def differences(values: Callable[[float], np.ndarray], step: float) -> np.ndarray:
    """Return the derivative at 1 from central differences with two steps, extrapolated."""
    fine, coarse = ((values(1.0 + h) - values(1.0 - h)) / (2.0 * h) for h in (step, 4.0 * step))
    return (16.0 * fine - coarse) / 15.0


@each_case("name", CASES)
def test_derivatives_of_modes_are_differences_of_complete_analyses(name: str):
    make, path, change = CASES[name]
    system = make()

    def values(factor: float) -> np.ndarray:
        modes = change(system, factor).modes(150.0, count=10)
        return np.array([modes.frequencies_hz, modes.damping_ratios])

    found = system.sensitivity(path, system.modes(150.0, count=10))
    expected = differences(values, 2e-4)
    for own, slopes in zip((found.derivatives, found.damping_ratios), expected, strict=True):
        moving = np.isfinite(own[0])
        assert moving.sum() >= 9
        error = found.parameter_values[0] * own[0, moving] - slopes[moving]
        assert np.max(np.abs(error)) < TOLERANCE * np.max(np.abs(slopes))


@each_case("name", [name for name in CASES if "film" not in name and name != "modal damping"])
def test_derivatives_of_critical_speeds_are_differences_of_campbell_diagrams(name: str):
    make, path, change = CASES[name]
    system, speeds = make(), np.linspace(0.0, 1200.0, 7)

    def values(factor: float) -> np.ndarray:
        crossings = change(system, factor).campbell(speeds, count=6).intersections
        return np.array([(each.speed, each.damping_ratio) for each in crossings]).T

    found = system.sensitivity([path], system.campbell(speeds, count=6))
    assert len(found.outputs) >= 2
    expected = differences(values, 2e-4)
    own = (found.derivatives[0], found.damping_ratios[0])
    # The step of 2e-4 divides the round-off of the differences: 1e-13 of the speeds, and of damping ratios of 1e-6 to 1e-3.
    round_off = (1e-13 * speeds[-1] / 2e-4, 1e-9)
    for derivatives, slopes, least in zip(own, expected, round_off, strict=True):
        error = found.parameter_values[0] * derivatives - slopes
        assert np.max(np.abs(error)) < TOLERANCE * np.max(np.abs(slopes)) + least


# Bearings that are soft enough for a rigid rotor are implausible.
@pytest.mark.filterwarnings("ignore::gearbow.SceneWarning")
def test_a_rigid_rotor_on_springs_has_closed_forms():
    # ω = √(2k/m) of the translation: dω/dk of each bearing is ω/4k, dω/dm is -ω/2m.
    mass, stiffness = 100.0, 1e6
    system = rigid_rotor(inertia(mass, 0.3, 0.3), {"stiffness": stiffness}, motion="lateral")
    modes = system.modes(count=2)
    paths = ["bearings[0].stiffness", "bearings[1].stiffness", "disks[0].mass"]
    found = system.sensitivity(paths, modes)
    assert found.equal == ((1, 2),)
    whole = mass + np.pi / 4.0 * 0.1**2 * 0.2 * 7850.0
    expected = np.array([[0.25], [0.25], [-0.5 * mass / whole]]) * [1.0, 1.0]
    # The elasticity of the shaft is below 1e-3 of that of the bearings.
    assert_allclose(found.relative, expected, rtol=1e-3)


def test_relative_derivatives_of_all_stiffnesses_and_masses_add_up_to_a_half():
    # ω scales with the root of all stiffnesses, and with the inverse root of all masses.
    system = stepped_rotor().replace(
        bearings=[gb.Bearing("s", x, stiffness=(1e6, 2e6)) for x in (0.0, 0.8)]
    )
    stiff = [f"bearings[{i}].stiffness[{j}]" for i in (0, 1) for j in (0, 1)]
    paths = ["shafts[0].material.youngs_modulus", *stiff]
    masses = [
        "shafts[0].material.density",
        *(f"disks[0].{name}" for name in ("mass", "diametral_inertia")),
    ]
    found = system.sensitivity([*paths, *masses], system.modes(0.0, count=6)).relative
    assert_allclose(found[:5].sum(axis=0), 0.5, rtol=1e-8)
    assert_allclose(found[5:].sum(axis=0), -0.5, rtol=1e-8)


def test_equal_eigenvalues_have_the_derivatives_of_their_small_matrix():
    # A stiffer bearing along y separates the two equal modes: the one along z stays.
    system = rotor(bearing={"stiffness": (1e7, 1e7)}, motion="lateral")
    found = system.sensitivity("bearings[0].stiffness[0]", system.modes(count=2))
    other = system.replace(
        bearings=[replace(system.bearings[0], stiffness=(1.001e7, 1e7)), system.bearings[1]]
    )
    assert found.derivatives[0, 0] == pytest.approx(0.0, abs=1e-9 * found.derivatives[0, 1])
    rise = other.modes(count=2).frequencies_hz[1] - system.modes(count=2).frequencies_hz[1]
    assert found.derivatives[0, 1] * 1e4 == pytest.approx(rise, rel=1e-3)
    with pytest.raises(gb.GearbowError, match="mode 1 has the same eigenvalue as another mode"):
        system.sensitivity("bearings[0].stiffness[0]", system.modes(count=1))


def test_a_parameter_of_the_value_zero_has_a_derivative():
    system = rotor(bearing={"stiffness": (1e7, 2e7)}, motion="lateral")
    found = system.sensitivity("bearings[0].damping", system.modes(count=4))
    damped = system.replace(bearings=[replace(system.bearings[0], damping=1.0), system.bearings[1]])
    assert_allclose(found.damping_ratios[0], damped.modes(count=4).damping_ratios, rtol=1e-6)
    assert_allclose(found.derivatives[0], 0.0, atol=1e-9)


def test_a_bow_has_no_effect_on_modes_and_a_rigid_motion_has_no_derivative():
    system = bowed_pair()
    found = system.sensitivity("shafts['input'].bow.amplitude", system.modes(count=4))
    assert np.isnan(found.derivatives[0, 0])
    assert_allclose(found.derivatives[0, 1:], 0.0, atol=1e-6)


def test_chosen_elements_stay_while_a_parameter_changes():
    system = rotor_on_pedestal()
    paths = ["disks['left'].position", "bearings[0].position", "bearings[0].support.mass"]
    found = system.sensitivity(paths, system.modes(count=6))

    def frequency(shift: float) -> np.ndarray:
        disks = [replace(system.disks[0], position=0.4 + shift), system.disks[1]]
        return system.replace(disks=disks).modes(count=6).frequencies_hz

    rise = (frequency(1e-3) - frequency(-1e-3)) / 2e-3
    assert_allclose(found.derivatives[0], rise, atol=1e-4 * np.max(np.abs(rise)))


@each_case(
    ("path", "text"),
    [
        ("bearing[0].stiffness", r"parameters\[0\]: .* must begin with one of .*\"bearings\""),
        ("bearings[9].stiffness", r"parameters\[0\]: bearings: has no \[9\], only \[0\] to \[3\]"),
        ("bearings[0].stifness", "has no 'stifness', only shaft, .*; did you mean \"stiffness\""),
        ("gears['g9'].position", "gears: has no 'g9', only 'g1', 'g2'"),
        ("gears['g1'].teeth", "gears.'g1'..teeth: is a whole number"),
        ("gears['g1'].mass", "gears.'g1'..mass: is not given; give the system a number"),
        ("gears['g1']", r"must be one real number, .*; continue with one of .name"),
        ("bearings[0", "must be a path such as"),
        ("modal_damping", "modal_damping: is not given"),
        ("bearings[0].stiffness.values", "has no 'values'"),
        ("shafts[0].length", "the nodes change with it: 30 degrees of freedom become"),
        ("bearings[1].position", 'outside the shaft "input"'),
    ],
)
def test_a_wrong_path_is_an_error(path: str, text: str):
    system = bowed_pair()
    with pytest.raises(gb.GearbowError, match=text):
        system.sensitivity(path, system.modes(count=2))


def test_results_of_another_system_are_an_error():
    system = bowed_pair()
    with pytest.raises(gb.SceneError, match="mode 2 is no mode of this system"):
        system.sensitivity("bearings[0].stiffness", bowed_pair(modal_damping=0.1).modes(count=3))
    with pytest.raises(gb.SceneError, match="of: must be a result of modes, campbell,"):
        system.sensitivity("bearings[0].stiffness", system)  # type: ignore[arg-type]
    with pytest.raises(gb.SceneError, match="at: name the place, mesh or sensor"):
        system.sensitivity("bearings[0].stiffness", system.synchronous([1.0]))  # type: ignore[call-overload]
    with pytest.raises(gb.SceneError, match="at: belongs to responses"):
        system.sensitivity("bearings[0].stiffness", system.modes(count=2), at="g1")  # type: ignore[call-overload]
    unbalanced = bowed_pair(modal_damping=0.1).synchronous([1.0])
    with pytest.raises(gb.SceneError, match="of: is no response of this system"):
        system.sensitivity("bearings[0].stiffness", unbalanced, at="g1")


def test_the_table_and_the_figure_name_parameters_and_units():
    system = bowed_pair()
    paths = ["bearings[0].stiffness", "shafts['input'].outer_diameter"]
    found = system.sensitivity(paths, system.modes(gb.rpm(900), count=3))
    table = found.table()
    assert "derivatives of natural frequencies at 900 rpm" in table
    assert "shafts['input'].outer_diameter" in table
    frame = found.to_dataframe()
    assert len(frame) == 6
    per_unit = found.damping_ratios * np.array(found.parameter_values)[:, np.newaxis]
    assert frame["damping ratio for 1 %"].to_numpy() == pytest.approx(
        0.01 * per_unit.T.ravel(), nan_ok=True
    )
    panels = found.plot().axes
    assert [panel.get_title() for panel in panels] == ["mode 2 (coupled)", "mode 3 (forward)"]
    assert panels[0].yaxis_inverted()
    assert panels[0].get_yticklabels()[0].get_text() == "shafts['input'].outer_diameter"
