"""Representations of the parts, and error messages for mistakes in them."""

from __future__ import annotations

import copy
import math
import pickle
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference import machines
from reference.cases import each_case
from reference.machines import UNDAMPED, rotor


def pair(**mesh: Any) -> gb.RotorSystem:
    return machines.pair(**{**UNDAMPED, "mesh": {"stiffness": 2e8, **mesh}}, torque=0.0)


def test_numpy_values_become_plain_python_values():
    disk = gb.Disk(
        "wheel", "rotor", np.float64(0.5), np.int64(20), np.float32(0.25), 0.2, np.complex128(1e-4j)
    )
    bearing = gb.Bearing(
        "rotor", 0.5, stiffness=np.diag([1e8, 2e8]), damping=(1.0, np.float64(2.0))
    )
    given = disk._describe("disks[0]")
    assert given["unbalance"] == [0.0, 1e-4]
    assert {type(given[key]) for key in ("position", "diametral_inertia")} == {float}
    assert type(given["mass"]) is int
    assert bearing._describe("bearings[0]")["stiffness"] == [[1e8, 0.0], [0.0, 2e8]]
    assert bearing._describe("bearings[0]")["damping"] == [1.0, 2.0]


def test_the_core_accepts_numpy_values():
    plain = rotor(disks=[gb.Disk("wheel", "rotor", 0.5, 20.0, 0.1, 0.2, unbalance=1e-4 + 2e-4j)])
    numpy = rotor(
        shaft={"length": np.float64(1.0), "elements": np.int32(4), "shear": np.bool_(True)},
        disks=[
            gb.Disk(
                "wheel",
                "rotor",
                *np.array([0.5, 20.0, 0.1, 0.2]),
                unbalance=np.complex128(1e-4 + 2e-4j),
            )
        ],
    )
    assert (
        numpy.synchronous([100.0]).amplitudes.tobytes()
        == plain.synchronous([100.0]).amplitudes.tobytes()
    )
    assert np.abs(plain.synchronous([100.0]).amplitudes).max() > 0.0


def test_python_and_core_have_the_same_defaults():
    """The defaults of the core equal those of the signatures."""
    short = pair()
    text = short._model.to_toml()
    for line in (
        "pressure_angle",
        "profile_shift",
        "damping_ratio",
        "centre_line_angle",
        "inner_diameter",
    ):
        assert line not in text
    explicit = copy.deepcopy(short.description)
    for gear in explicit["gears"]:
        gear |= {
            "pressure_angle": math.radians(20.0),
            "profile_shift": 0.0,
            "unbalance": [0.0, 0.0],
        }
    for shaft in explicit["shafts"]:
        steel = {"youngs_modulus": 207e9, "density": 7850.0, "poisson_ratio": 0.3}
        shaft |= {"inner_diameter": 0.0, "shear": True, "material": steel}
    explicit["meshes"][0] |= {"damping_ratio": 0.0, "centre_line_angle": 0.0}
    for bearing in explicit["bearings"]:
        bearing["damping"] = 0.0
    spelt_out = gb.RotorSystem._from_description(explicit)
    for name in ("mass", "stiffness", "damping", "gyroscopic"):
        np.testing.assert_array_equal(
            getattr(short.matrices(), name), getattr(spelt_out.matrices(), name)
        )


def test_parts_keep_their_arguments():
    system = rotor()
    assert isinstance(system.shafts, tuple)
    assert system.shafts[0].length == 1.0
    assert [bearing.position for bearing in system.bearings] == [0.0, 1.0]
    assert system.gears == ()
    assert "1 shaft, 2 bearings" in repr(system)
    with pytest.raises(AttributeError):
        system.shafts[0].length = 2.0


@each_case(
    ("slip", "text"),
    [
        (
            lambda: gb.RotorSystem(shafts=["input"]),
            r"^shafts\[0\]: must be a gb.Shaft, got 'input'",
        ),
        (lambda: gb.RotorSystem(shafts=gb.Shaft("a")), r"^shafts: must be a list of gb.Shaft"),
        (lambda: rotor(gears=gb.Gear("g", "rotor", 0.5, 20)), r"^gears: must be a list of gb.Gear"),
        (lambda: rotor(disks=[gb.Gear("g", "rotor", 0.5, 20)]), r"^disks\[0\]: must be a gb.Disk"),
        (lambda: rotor(shaft={"bow": 1e-4}), r"^shafts\[0\].bow: must be a gb.Bow, got 0.0001"),
        (
            lambda: rotor(shaft={"material": "steel"}),
            r"^shafts\[0\].material: must be a gb.Material",
        ),
        (
            lambda: rotor(disks=[gb.Disk(object(), "rotor", 0.5, 1.0, 1.0, 1.0)]),
            r"^disks\[0\].name: must be",
        ),
        (lambda: rotor(gravity=object()), r"^gravity: must be a number"),
        (lambda: rotor(shaft={"length": "long"}), r"^shafts\[0\].length"),
        (lambda: rotor(shaft={"length": math.nan}), r"^shafts\[0\].length"),
        (
            lambda: rotor(shaft={"bow": gb.Bow.half_sine(math.nan)}),
            r"^shafts\[0\].bow.amplitude: .*nan",
        ),
        (lambda: rotor(motion="sideways"), r"^motion"),
        (
            lambda: rotor(disks=[gb.Disk("d", "rotr", 0.5, 1.0, 1.0, 1.0)]),
            r"^disks\[0\].shaft: .*rotr",
        ),
        (lambda: rotor(torques=[gb.Torque(("rotor", 2.0), 1.0)]), r"^torques\[0\].at"),
    ],
)
def test_the_error_names_the_place_of_a_mistake(slip, text):
    with pytest.raises(gb.SceneError, match=text) as caught:
        slip()
    assert isinstance(caught.value, ValueError)
    assert isinstance(caught.value, gb.GearbowError)


def test_a_probable_mistake_is_a_warning_at_its_line():
    with pytest.warns(gb.SceneWarning, match="base") as caught:
        gb.RotorSystem(
            shafts=[
                gb.Shaft(name, length=0.5, outer_diameter=0.05, elements=2) for name in ("a", "b")
            ],
            gears=[
                gb.Gear("g1", "a", 0.25, 328, base_radius=0.5086, tip_radius=0.55, face_width=0.1),
                gb.Gear("g2", "b", 0.25, 23, base_radius=0.0360, tip_radius=0.042, face_width=0.1),
            ],
            meshes=[gb.Mesh("g1", "g2", stiffness=1e8)],
        )
    assert caught[0].filename == __file__


class TestBowFunction:
    """A curve given as a function is evaluated once the shaft length is known."""

    def test_it_equals_its_closed_form(self):
        curve = gb.Bow.function(lambda x: 1e-4 * np.exp(0.7j) * np.sin(np.pi * x))
        sampled = rotor(shaft={"bow": curve}).synchronous([100.0]).displacement(("rotor", 0.5))
        exact = rotor(shaft={"bow": gb.Bow.half_sine(1e-4, phase=0.7)}).synchronous([100.0])
        expected = exact.displacement(("rotor", 0.5))
        assert np.abs(expected).min() > 1e-5
        np.testing.assert_allclose(sampled, expected, rtol=1e-9)

    def test_it_is_called_at_each_of_1001_points(self):
        seen: list[float] = []

        def curve(x: float) -> complex:
            seen.append(x)
            return 0j

        rotor(shaft={"bow": gb.Bow.function(curve)})
        np.testing.assert_allclose(seen, np.linspace(0.0, 1.0, 1001), atol=1e-15)

    def test_it_covers_all_segments(self):
        seen: list[float] = []
        segments = [gb.Segment(0.4, 0.05, elements=2), gb.Segment(0.6, 0.06, elements=2)]
        gb.RotorSystem(
            shafts=[
                gb.Shaft(
                    "rotor", segments=segments, bow=gb.Bow.function(lambda x: seen.append(x) or 0j)
                )
            ],
            bearings=[gb.Bearing("rotor", x, stiffness=1e8) for x in (0.0, 1.0)],
        )
        assert (seen[0], seen[-1]) == (0.0, 1.0)

    @each_case("value", [math.nan, math.inf, complex(0.0, math.nan), "bent", None, [1.0, 2.0]])
    def test_the_error_names_a_result_that_is_not_finite(self, value):
        curve = gb.Bow.function(lambda x: value if x > 0.4995 else 0.0)
        with pytest.raises(
            gb.SceneError, match=r"^shafts\[0\].bow.function: .* at x = 0.5 m"
        ) as caught:
            rotor(shaft={"bow": curve})
        assert repr(value) in str(caught.value)

    def test_an_exception_of_the_function_is_passed_on(self):
        with pytest.raises(ZeroDivisionError):
            rotor(shaft={"bow": gb.Bow.function(lambda x: 1.0 / x)})


def test_points_accept_one_phase_for_all():
    given = gb.Bow.points(np.array([0.0, 0.5, 1.0]), [0.0, 1e-4, 0.0], 0.3)._describe("bow")
    assert given["phases"] == [0.3, 0.3, 0.3]
    assert gb.Bow.points([0.0, 1.0], [0.0, 0.0])._describe("bow")["phases"] == [0.0, 0.0]


def test_copies_describe_the_same_system():
    system = rotor(
        shaft={"bow": gb.Bow.half_sine(1e-4, phase=0.3)},
        torques=[gb.Torque(("rotor", 0.5), 2.0), gb.Torque.balance(("rotor", 0.0))],
        disks=[gb.Disk("wheel", "rotor", 0.5, 20.0, 0.1, 0.2, unbalance=1e-4j)],
        modal_damping=0.01,
    )
    for other in (copy.copy(system), copy.deepcopy(system), pickle.loads(pickle.dumps(system))):
        assert other.description == system.description
        assert other.disks == system.disks
        assert other.torques == system.torques
        np.testing.assert_array_equal(other.matrices().stiffness, system.matrices().stiffness)


def test_motion_chooses_the_degrees_of_freedom():
    kinds = {
        motion: {dof[2] for dof in rotor(motion=motion).dofs}
        for motion in ("lateral", "torsion", "coupled")
    }
    assert kinds["lateral"] == {"v", "w", "B", "G"}
    assert kinds["torsion"] == {"twist"}
    assert kinds["coupled"] == {"v", "w", "B", "G", "twist"}
    with pytest.raises(gb.GearbowError, match="lateral motion"):
        rotor(motion="torsion").synchronous([1.0]).displacement(("rotor", 0.5))


def test_the_text_of_a_system_lists_what_it_assumes():
    gear = {"module": 3e-3, "face_width": 0.03}
    known = {"tip_radius": 0.08, "mass": 3.0, "diametral_inertia": 0.01, "polar_inertia": 0.02}
    system = gb.RotorSystem(
        shafts=[gb.Shaft(name, length=0.5, outer_diameter=0.05) for name in ("a", "b")],
        gears=[gb.Gear("g1", "a", 0.25, 25, **gear), gb.Gear("g2", "b", 0.25, 50, **gear, **known)],
        meshes=[gb.Mesh("g1", "g2", stiffness=gb.Stiffness.square(2e8))],
        bearings=[gb.Bearing(s, x, stiffness=1e8) for s in ("a", "b") for x in (0.0, 0.5)],
    )
    first, *assumed = str(system).splitlines()
    assert first == repr(system)
    assert assumed == [
        "  assumed for shafts: steel with E = 207 GPa, ν = 0.3, ρ = 7850 kg/m³",
        "  assumed for gears: tip radius of full-depth teeth (g1)",
        "  assumed for gears: mass and inertia of solid steel disks (g1)",
        "  assumed for meshes: tooth pairs engage over 0.1 of the base pitch",
        "  assumed for meshes: no damping",
        "  assumed for meshes: contact on both flanks, without backlash",
    ]
    given = gb.Stiffness.square(2e8, engagement="sharp")
    mesh = gb.Mesh("g1", "g2", stiffness=given, damping_ratio=0.05, backlash=1e-4)
    text = str(system.replace(meshes=[mesh]))
    assert "engage" not in text
    assert "no damping in separation" in text
