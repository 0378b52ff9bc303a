"""Invalid scenes: each is a `SceneError` whose message begins with the location."""

from __future__ import annotations

import copy
import math
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import gearbow as gb
from reference.cases import each_case
from reference.invalid_scenes import KINDS, SCENE, build, numbers, with_value, written

COUNTS = ("elements", "teeth", "number")


def refused(scene: dict[str, Any], where: str) -> str:
    with pytest.raises(gb.SceneError) as caught:
        build(scene)
    assert isinstance(caught.value, ValueError)
    text = str(caught.value)
    assert text.startswith(where), f"{text!r} does not begin with {where!r}"
    assert len(text) > len(where) + 3  # and the message names the fault
    return text


def test_the_unchanged_scene_is_valid():
    assert build(SCENE).speed_ratios == pytest.approx([1, -0.5, 0.5 * 50 / 30])


def stem(path: tuple[str | int, ...]) -> str:
    """Return the path up to its last name: array entries can have names or not."""
    while isinstance(path[-1], int) and path[-2] not in KINDS and path[-2] != "shafts":
        path = path[:-1]
    return written(path)


@each_case("bad", [math.nan, math.inf, -math.inf], ids=["nan", "inf", "-inf"])
@each_case("path", numbers(SCENE), ids=written)
def test_a_number_that_is_not_finite(path: tuple[str | int, ...], bad: float):
    text = refused(with_value(list(path), bad), stem(path))
    if path[-1] not in COUNTS:
        assert str(bad).strip("-") in text.lower()


def test_a_message_has_path_rule_and_value():
    text = refused(
        with_value(["shafts", 1, "bow", 1, "amplitude"], math.nan), "shafts[1].bow.amplitude"
    )
    assert text == "shafts[1].bow.amplitude: must be finite, got nan"


POSITIVE = [
    ("shafts", 0, "length"),
    ("shafts", 0, "outer_diameter"),
    ("shafts", 0, "elements"),
    ("shafts", 0, "material", "youngs_modulus"),
    ("shafts", 0, "material", "density"),
    ("shafts", 2, "segments", 0, "length"),
    ("shafts", 2, "segments", 1, "outer_diameter"),
    ("gears", 0, "teeth"),
    ("gears", 0, "module"),
    ("gears", 0, "face_width"),
    ("gears", 0, "tip_radius"),
    ("gears", 2, "base_radius"),
    ("meshes", 0, "stiffness"),
    ("meshes", 0, "centre_distance"),
]
NOT_NEGATIVE = [
    ("shafts", 0, "inner_diameter"),
    ("gears", 0, "mass"),
    ("gears", 0, "diametral_inertia"),
    ("gears", 0, "polar_inertia"),
    ("meshes", 0, "damping_ratio"),
    ("meshes", 1, "damping"),
    ("disks", 0, "mass"),
    ("disks", 0, "diametral_inertia"),
    ("disks", 0, "polar_inertia"),
    ("modal_damping",),
]


@each_case("path", POSITIVE, ids=written)
@each_case("bad", [0, -1])
def test_a_size_that_is_not_positive(path: tuple[str | int, ...], bad: int):
    kind = int if path[-1] in COUNTS else float
    refused(with_value(list(path), kind(bad)), written(path))


@each_case("path", NOT_NEGATIVE, ids=written)
def test_a_size_that_is_negative(path: tuple[str | int, ...]):
    refused(with_value(list(path), -1e-3), written(path))


@each_case(
    ("path", "value", "where"),
    [
        (("shafts", 0, "inner_diameter"), 0.05, "shafts[0]"),
        (("shafts", 0, "inner_diameter"), 0.06, "shafts[0]"),
        (("shafts", 2, "segments", 0, "inner_diameter"), 0.06, "shafts[2].segments[0]"),
        (("shafts", 0, "material", "poisson_ratio"), 0.6, "shafts[0].material"),
        (("shafts", 0, "material", "poisson_ratio"), -1.0, "shafts[0].material"),
        (("shafts", 0, "material", "shear_modulus"), 8e10, "shafts[0].material"),  # and nu
        (("shafts", 1, "name"), "input", "shafts[1]"),  # given twice
        (("gears", 1, "name"), "g1", "gears[1]"),
        (("disks", 0, "name"), "g1", "disks[0]"),
        (("shafts", 0, "segments"), [{"length": 1.0, "outer_diameter": 0.1}], "shafts[0]"),
        (("shafts", 2, "segments"), [], "shafts[2]"),
        (("gears", 0, "shaft"), "nowhere", "gears[0].shaft"),
        (("disks", 0, "shaft"), "nowhere", "disks[0].shaft"),
        (("bearings", 0, "shaft"), "nowhere", "bearings[0].shaft"),
        (("meshes", 0, "driver"), "g9", "meshes[0].driver"),
        (("meshes", 0, "driven"), "wheel", "meshes[0].driven"),  # a disk has no teeth
        (("torques", 0, "at"), "g9", "torques[0].at"),
        (("torques", 1, "at"), ("nowhere", 0.5), "torques[1].at"),
        (("torques", 1, "at"), ("output", 0.6), "torques[1].at"),
        (("reference",), "nowhere", "reference"),
        (("gears", 0, "position"), 0.51, "gears[0].position"),
        (("gears", 0, "position"), -0.01, "gears[0].position"),
        (("disks", 0, "position"), 0.51, "disks[0].position"),
        (("bearings", 2, "position"), 0.51, "bearings[2].position"),
        (("bearings", 5, "position"), -1e-3, "bearings[5].position"),
        (("bearings", 0, "stiffness"), (1e8, 1e8, 1e8), "bearings[0].stiffness"),
        (("bearings", 0, "stiffness"), [[1e8], [1e8]], "bearings[0].stiffness"),
        (("bearings", 0, "stiffness"), "stiff", "bearings[0].stiffness"),
        (("bearings", 0, "stiffness"), -1e8, "bearings[0].stiffness"),
        (("shafts", 2, "bow", 1, "amplitudes"), [0.0, 1e-4], "shafts[2].bow"),
        (("shafts", 2, "bow", 1, "positions"), [0.0, 0.2, 0.2], "shafts[2].bow.positions"),
        (("shafts", 2, "bow", 1, "positions"), [0.0, 0.3, 0.2], "shafts[2].bow.positions"),
        (("shafts", 2, "bow", 1, "positions"), [0.0, 0.2, 0.7], "shafts[2].bow.positions"),
        (("shafts", 1, "bow"), ("mode", {"number": 0, "amplitude": 1e-4}), "shafts[1].bow.number"),
        (("gears", 0, "pressure_angle"), 0.0, "gears[0].pressure_angle"),
        (("gears", 0, "pressure_angle"), 1.6, "gears[0].pressure_angle"),
        (("gears", 0, "tip_radius"), 0.03, "gears[0].tip_radius"),  # inside the base circle
        (("gears", 0, "module"), None, "gears[0]"),  # neither
        (("meshes", 0, "damping"), 100.0, "meshes[0]"),  # and a ratio
        (("meshes", 0, "driven"), "g1", "meshes[0]"),  # with itself
        (
            ("meshes", 0, "centre_distance"),
            0.1,
            "meshes[0].centre_distance",
        ),  # base circles overlap
        (("meshes", 0, "backlash"), math.nan, "meshes[0].backlash"),
        (("meshes", 0, "backlash"), -1e-5, "meshes[0].backlash"),
        (("gravity",), [1.0, 2.0, 3.0], "gravity"),
        (("rayleigh",), [1.0], "rayleigh"),
        (("motion",), "sideways", "motion"),
        (("shafts",), [], "shafts"),
    ],
    ids=lambda x: written(x) if isinstance(x, tuple) and x and x[0] in SCENE else None,
)
def test_invalid_scenes_are_errors(path: tuple[str | int, ...], value: Any, where: str):
    scene = with_value(list(path), value)
    if path[-1] == "segments" and value:
        scene["shafts"][0]["segments"] = value  # beside a length
    refused(scene, where)


@pytest.mark.parametrize(
    ("gear", "change"),
    [
        ("g2", {"module": 2e-3}),
        ("g2", {"pressure_angle": 0.4}),
        ("g3", {"base_radius": 30 * 1.5e-3 * math.cos(0.35) * 1.06}),
    ],
    ids=["module", "pressure angle", "base pitch off by 6 %"],
)
def test_incompatible_gears_are_an_error(gear: str, change: dict[str, float]):
    scene = copy.deepcopy(SCENE)
    index = {"g2": 1, "g3": 2}[gear]
    scene["gears"][index].update(change)
    refused(scene, "meshes[1]" if gear == "g3" else "meshes[0]")


@pytest.mark.parametrize("factor", [0.96, 1.04])
def test_rounded_published_radii_give_a_warning(factor: float):
    scene = copy.deepcopy(SCENE)
    scene["gears"][2]["base_radius"] *= factor
    with pytest.warns(gb.SceneWarning, match=r"meshes\[1\]"):
        system = build(scene)
    # the ratio follows from the numbers of teeth
    assert system.speed_ratios == pytest.approx([1, -0.5, 0.5 * 50 / 30], rel=1e-15)


def test_an_unconnected_shaft_is_an_error():
    scene = copy.deepcopy(SCENE)
    scene["meshes"] = scene["meshes"][:1]
    scene["torques"] = []
    text = refused(scene, "shafts[2]")
    assert "third" in text


def test_a_loop_with_inconsistent_ratios_is_an_error():
    # g4 and g5 close the loop input -> output -> third -> input
    def closed(teeth: int) -> dict[str, Any]:
        scene = copy.deepcopy(SCENE)
        common = {"module": 3e-3, "face_width": 0.03, "pressure_angle": 0.35}
        scene["gears"] += [
            {"name": "g4", "shaft": "third", "position": 0.4, "teeth": teeth, **common},
            {"name": "g5", "shaft": "input", "position": 0.4, "teeth": 30, **common},
        ]
        scene["meshes"].append({"driver": "g4", "driven": "g5", "stiffness": 1e8})
        return scene

    # the third shaft rotates at +5/6; three external meshes in a ring would reverse the input
    # the error can name any mesh of the loop
    text = refused(closed(36), "meshes[")
    assert "ratio" in text.lower()
    refused(closed(40), "meshes[")


def test_a_loop_with_consistent_ratios_is_valid():
    scene = copy.deepcopy(SCENE)
    common = {"module": 3e-3, "face_width": 0.03, "pressure_angle": 0.35, "position": 0.125}
    scene["gears"] += [
        {"name": "g4", "shaft": "input", "teeth": 20, **common},
        {"name": "g5", "shaft": "output", "teeth": 40, **common},
    ]
    mesh = {"driver": "g4", "driven": "g5", "stiffness": 1e8}
    mesh |= {"centre_line_angle": 0.2, "centre_distance": 0.113 * 60 / 75}
    scene["meshes"].append(mesh)
    assert build(scene).speed_ratios == pytest.approx([1, -0.5, 0.5 * 50 / 30])


def test_two_balancing_torques_are_an_error():
    scene = copy.deepcopy(SCENE)
    scene["torques"].append({"at": "g2", "balance": True})
    refused(scene, "torques")


def test_numpy_numbers_and_arrays_are_accepted():
    scene = copy.deepcopy(SCENE)
    scene["shafts"][0]["length"] = np.float64(0.5)
    scene["shafts"][0]["elements"] = np.int64(4)
    scene["shafts"][1]["outer_diameter"] = np.array(0.05)
    scene["gears"][0]["teeth"] = np.int32(25)
    scene["gears"][0]["unbalance"] = np.complex128(1e-4 + 1e-5j)
    scene["bearings"][1]["stiffness"] = np.array([1e8, 2e8])
    scene["bearings"][2]["stiffness"] = np.array([[1e8, 1e6], [1e6, 1e8]])
    scene["bearings"][2]["damping"] = 500.0 * np.eye(2, dtype=np.float32)
    scene["meshes"][0]["stiffness"] = np.float64(2e8)
    scene["gravity"] = np.array([0.0, -9.81])
    scene["torques"][1]["at"] = ("output", np.float64(0.5))
    scene["torques"][0]["value"] = np.int64(100)
    points = scene["shafts"][2]["bow"][1]
    for key in points:
        points[key] = np.array(points[key])
    plain, taken = build(SCENE).matrices(), build(scene).matrices()
    assert np.array_equal(plain.stiffness, taken.stiffness)
    assert np.array_equal(plain.mass, taken.mass)


# --- arbitrary numbers ----------------------------------------------------------------------------


@settings(max_examples=100, deadline=None, derandomize=True)
@given(
    path=st.sampled_from(numbers(SCENE)),
    value=st.one_of(
        st.floats(),
        st.sampled_from([0.0, -0.0, 5e-324, 1e-300, 1e300, -1e300, 1.7976931348623157e308]),
    ),
)
@pytest.mark.implausible
def test_every_number_is_accepted_or_refused_with_a_message(path, value):
    """No other exception and no crash occurs; accepted scenes can be assembled."""
    count = path[-1] in COUNTS and abs(value) < 50
    try:
        system = build(with_value(list(path), int(value) if count else value))
    except gb.SceneError as error:
        assert re.match(r"(shafts|gears|disks|meshes|bearings|torques|gravity|modal)", str(error))  # noqa: PT017
        return
    try:
        mass = system.matrices().mass
    except gb.GearbowError:
        assert not 1e-6 < abs(value) < 1e6  # very large numbers can overflow with an error message
        return
    assert np.isfinite(mass).all() or not 1e-6 < abs(value) < 1e6
