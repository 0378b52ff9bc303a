"""Gears with profile shift: centre distance without play, play of a given one, tip shortening."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from gearbow._core import mesh_geometry
from gearbow._types import MeshGeometry
from gearbow.description.train import Train
from reference.machines import BEARING, short_pair

#: Published two-stage gearbox: teeth, normal module, profile shifts, helix angle, face width.
STAGES: dict[str, dict[str, Any]] = {
    "first": {
        "teeth": (27, 51),
        "module": 4.5e-3,
        "shifts": (0.231415, 0.231415),
        "helix": math.radians(21.0),
        "face_width": 0.05,
    },
    "second": {
        "teeth": (23, 34),
        "module": 6.5e-3,
        "shifts": (0.15074, 0.15074),
        "helix": math.radians(10.0),
        "face_width": 0.074,
    },
}
SPUR: dict[str, Any] = {"teeth": (20, 35), "module": 3e-3, "shifts": (0.3, 0.2)}


def pair(
    teeth: tuple[int, int] = (20, 35),
    shifts: tuple[float, float] = (0.0, 0.0),
    *,
    module: float = 3e-3,
    helix: float = 0.0,
    pressure_angle: float = math.radians(20.0),
    face_width: float = 0.03,
    tips: tuple[float | None, float | None] = (None, None),
    bow: gb.Bow | None = None,
    torque: float = 0.0,
    **mesh: Any,
) -> gb.RotorSystem:
    """Return two gears on stiff shafts, unloaded unless there is a torque."""
    signs = (1.0, -1.0)
    own: dict[str, dict[str, Any]] = {
        f"g{name}": {
            "helix_angle": signs[i] * helix,
            "profile_shift": shifts[i],
            "tip_radius": tips[i],
        }
        for i, name in enumerate("ab")
    }
    return short_pair(
        ("ga", "gb"),
        teeth,
        own={**own, "b": {"bow": bow}},
        gear={"module": module, "pressure_angle": pressure_angle, "face_width": face_width},
        mesh=mesh,
        bearing={**BEARING, "axial_stiffness": 1e8},
        torque=torque,
    )


def at_rest(system: gb.RotorSystem) -> MeshGeometry:
    """Return the geometry of the only mesh."""
    (found,) = mesh_geometry(system.description)
    return found


@dataclass(frozen=True)
class Teeth:
    """Independent geometry of the teeth of a pair, from the basic rack."""

    teeth: tuple[int, int]
    shifts: tuple[float, float]
    module: float
    helix: float = 0.0
    pressure_angle: float = math.radians(20.0)

    @property
    def transverse(self) -> float:
        return math.atan(math.tan(self.pressure_angle) / math.cos(self.helix))

    @property
    def radii(self) -> tuple[float, float]:
        a, b = (self.module * z / (2.0 * math.cos(self.helix)) for z in self.teeth)
        return a, b

    def operating(self, distance: float) -> tuple[float, list[float]]:
        """Return the pitch, and the tooth thicknesses on the operating pitch circles."""
        angle = math.acos(sum(self.radii) * math.cos(self.transverse) / distance)
        thicknesses = []
        for z, x, radius in zip(self.teeth, self.shifts, self.radii, strict=True):
            rack = self.module * (math.pi / 2.0 + 2.0 * x * math.tan(self.pressure_angle))
            half = rack / math.cos(self.helix) / (2.0 * radius)
            half += math.tan(self.transverse) - self.transverse - math.tan(angle) + angle
            thicknesses.append(2.0 * distance * z / sum(self.teeth) * half)
        return 2.0 * math.pi * distance / sum(self.teeth), thicknesses

    def normal_play(self, distance: float) -> float:
        """Return the gap between the flanks normal to the teeth."""
        pitch, thicknesses = self.operating(distance)
        angle = math.acos(sum(self.radii) * math.cos(self.transverse) / distance)
        base_helix = math.asin(math.sin(self.helix) * math.cos(self.pressure_angle))
        return (pitch - sum(thicknesses)) * math.cos(angle) * math.cos(base_helix)

    def contact_ratio(self, distance: float, face_width: float) -> float:
        """Return the total contact ratio of full-depth teeth."""
        bases = [radius * math.cos(self.transverse) for radius in self.radii]
        path = -math.sqrt(distance**2 - sum(bases) ** 2)
        for radius, base, x in zip(self.radii, bases, self.shifts, strict=True):
            path += math.sqrt((radius + self.module * (1.0 + x)) ** 2 - base**2)
        pitch = math.pi * self.module * math.cos(self.transverse) / math.cos(self.helix)
        return path / pitch + face_width * math.sin(self.helix) / (math.pi * self.module)


@pytest.mark.parametrize(
    ("given", "distance", "angle", "ratio"),
    [
        (STAGES["first"], 190.000e-3, 22.806, 2.74),
        (STAGES["second"], 190.000e-3, None, None),
        (SPUR, None, None, 1.515),
    ],
    ids=["first stage", "second stage", "spur"],
)
@pytest.mark.parametrize("full_depth", [False, True])
def test_published_gears_have_their_centre_distance_and_contact_ratio(
    given: dict[str, Any],
    distance: float | None,
    angle: float | None,
    ratio: float | None,
    full_depth: bool,
):
    own = {key: given[key] for key in ("teeth", "shifts", "module")}
    teeth = Teeth(**own, helix=given.get("helix", 0.0))
    tips = [r + teeth.module * (1.0 + x) for r, x in zip(teeth.radii, teeth.shifts, strict=True)]
    # Tip radii that are given are never shortened. The clearance of these gears needs no shortening.
    system = pair(**given, tips=tuple(tips) if full_depth else (None, None))
    mesh = system.static().mesh(("ga", "gb"))
    # Half a unit of the last published digit.
    if distance is not None:
        assert float(mesh.centre_distance) == pytest.approx(distance, abs=5e-7)
    if angle is not None:
        assert math.degrees(mesh.pressure_angle) == pytest.approx(angle, abs=5e-4)
    if ratio is not None:
        digits = len(str(ratio).partition(".")[2])
        assert float(mesh.contact_ratio) == pytest.approx(ratio, abs=0.5 * 10.0**-digits)
    expected = teeth.contact_ratio(float(mesh.centre_distance), given.get("face_width", 0.03))
    # The same formula: round-off.
    assert float(mesh.contact_ratio) == pytest.approx(expected, rel=1e-12)


def random_pairs(count: int) -> list[tuple[Teeth, gb.RotorSystem]]:
    """Return random pairs with positive and negative sums of profile shifts."""
    random = np.random.default_rng(7)
    found = []
    for _ in range(count):
        given: dict[str, Any] = {
            "teeth": tuple(int(z) for z in random.integers(25, 90, 2)),
            "shifts": tuple(float(x) for x in random.uniform(-0.4, 0.9, 2)),
            "module": float(10.0 ** random.uniform(-4.0, -2.0)),
            "helix": float(random.choice([0.0, random.uniform(-0.5, 0.5)])),
            "pressure_angle": float(random.uniform(0.3, 0.42)),
        }
        size = given["module"] * 10.0
        found.append((Teeth(**given), pair(**given, face_width=size)))
    return found


@pytest.mark.filterwarnings("ignore::gearbow.SceneWarning")  # sizes of shafts and undercut teeth
def test_the_default_centre_distance_is_without_play():
    negative = 0
    for teeth, system in random_pairs(150):
        found = at_rest(system)
        negative += sum(teeth.shifts) < 0.0
        distance, angle = found["centre_distance"], found["pressure_angle"]
        expected = (
            math.tan(teeth.transverse)
            - teeth.transverse
            + 2.0 * sum(teeth.shifts) * math.tan(teeth.pressure_angle) / sum(teeth.teeth)
        )
        # Round-off of tan α − α.
        assert math.tan(angle) - angle == pytest.approx(expected, rel=1e-13, abs=4e-16)
        base = sum(teeth.radii) * math.cos(teeth.transverse)
        assert distance == pytest.approx(base / math.cos(angle), rel=1e-14)
        pitch, thicknesses = teeth.operating(distance)
        # Round-off of the involutes, which the radius multiplies and the pitch divides.
        assert sum(thicknesses) == pytest.approx(pitch, rel=1e-13)
        assert (distance > sum(teeth.radii)) == (sum(teeth.shifts) > 0.0)
    assert negative > 10


@pytest.mark.parametrize("shifts", [(0.0, 0.0), (0.37, -0.37), (-0.2, 0.2)])
@pytest.mark.parametrize("helix", [0.0, 0.3])
def test_shifts_that_cancel_keep_the_sum_of_the_pitch_radii(
    shifts: tuple[float, float], helix: float
):
    radii = [3e-3 / math.cos(helix) * z / 2.0 for z in (25, 50)]
    found = at_rest(pair((25, 50), shifts, helix=helix))
    assert found["centre_distance"] == radii[0] + radii[1]
    # Such teeth are those of the basic rack at any centre distance.
    with pytest.warns(gb.SceneWarning, match="the teeth overlap"):
        closer = at_rest(pair((25, 50), shifts, helix=helix, centre_distance=sum(radii) - 0.55e-3))
    tips = tuple(r + 3e-3 * (1.0 + x) for r, x in zip(radii, shifts, strict=True))
    assert found["tip_radii"] == closer["tip_radii"] == tips


@pytest.mark.filterwarnings("error")
def test_a_published_centre_distance_has_no_play():
    """The published distances are rounded to a micrometre, the profile shifts to six digits."""
    for given in STAGES.values():
        own = {key: given[key] for key in ("teeth", "shifts", "module", "helix")}
        assert abs(Teeth(**own).normal_play(0.19)) < 1e-8
        # A backlash below the play by less than 0.1 module, or none, gives no warning.
        for backlash in (None, 0.0, 1.4e-4):
            pair(**given, centre_distance=0.19, backlash=backlash)


@pytest.mark.filterwarnings("ignore:.*(undercut|contact ratio):gearbow.SceneWarning")
@pytest.mark.parametrize("given", [*STAGES.values(), SPUR], ids=["first", "second", "spur"])
@pytest.mark.parametrize(
    ("moved", "backlash", "warns"),
    [
        (0.10, 0.0, False),  # j_n = 0.07 to 0.08 modules
        (0.16, 0.0, True),
        (0.16, 0.05, False),
        (0.16, None, False),  # a mesh that never separates has no backlash
        (-0.02, None, False),
        (-0.04, None, True),
        (-0.04, 0.5, True),
    ],
)
def test_a_centre_distance_with_too_much_or_negative_play_warns(
    given: dict[str, Any], moved: float, backlash: float | None, warns: bool
):
    own = {key: given[key] for key in ("teeth", "shifts", "module")}
    teeth = Teeth(**own, helix=given.get("helix", 0.0))
    without = at_rest(pair(**given))["centre_distance"]
    distance = without + moved * teeth.module
    clearance = None if backlash is None else backlash * teeth.module
    play = teeth.normal_play(distance)
    much = clearance is not None and play - clearance > 0.1 * teeth.module
    assert warns == (much or play < -0.02 * teeth.module)
    if not warns:
        pair(**given, centre_distance=distance, backlash=clearance)
        return
    with pytest.warns(
        gb.SceneWarning, match=r"^meshes\[0\]\.centre_distance: the normal"
    ) as caught:
        pair(**given, centre_distance=distance, backlash=clearance)
    (text,) = [str(each.message) for each in caught if "normal play" in str(each.message)]
    (found,) = re.findall(r"normal play of the flanks at \S+ m is (\S+) m, ", text)
    # Four digits are printed.
    assert float(found) == pytest.approx(play, rel=5.1e-4)
    assert f", {without:.6f} m is without play" in text
    printed = re.findall(r", backlash is (\S+) m", text)
    assert [float(each) for each in printed] == ([] if clearance is None else [clearance])


def test_shifted_gears_on_the_sum_of_the_pitch_radii_overlap():
    with pytest.warns(gb.SceneWarning, match=r"the normal play .* the teeth overlap unless"):
        pair(**SPUR, centre_distance=0.0825)


def test_a_contact_ratio_below_one_names_the_profile_shifts():
    message = (
        r"below 1: no teeth .* probable cause: the profile shifts increase the pressure angle to "
        r"32\.77°$"
    )
    with pytest.warns(gb.SceneWarning, match=message):
        pair((12, 20), (1.3, 1.2))
    # Tips below the default are the cause if they are given.
    with pytest.warns(gb.SceneWarning, match="probable cause: the tip radii are 0.023000 m and"):
        pair((12, 20), (1.3, 1.2), tips=(0.023, None))


def test_a_large_shift_shortens_the_tips():
    tall = pair((20, 35), (0.9, 0.9))
    found, (radius_a, radius_b) = at_rest(tall), (0.03, 0.0525)
    (tip_a, tip_b), (root_a, root_b) = found["tip_radii"], found["root_radii"]
    # DEDENDUM 1.25 modules of ISO 53.
    assert root_a == pytest.approx(radius_a - 3e-3 * (1.25 - 0.9), rel=1e-14)
    assert root_b == pytest.approx(radius_b - 3e-3 * (1.25 - 0.9), rel=1e-14)
    # The tip clearance is 0.1 module; full-depth teeth would have less.
    assert found["centre_distance"] - tip_a - root_b == pytest.approx(3e-4, rel=1e-11)
    assert found["centre_distance"] - tip_b - root_a == pytest.approx(3e-4, rel=1e-11)
    full = (radius_a + 3e-3 * 1.9, radius_b + 3e-3 * 1.9)
    assert tip_a < full[0] - 1e-5
    assert tip_b < full[1] - 1e-5
    # A given tip radius stays, and the other gear is still shortened.
    found = at_rest(pair((20, 35), (0.9, 0.9), tips=(full[0], None)))
    assert found["tip_radii"] == (full[0], tip_b)
    # Little shift leaves more clearance than 0.1 module.
    found = at_rest(pair(**SPUR))
    assert found["tip_radii"] == pytest.approx((0.03 + 3.9e-3, 0.0525 + 3.6e-3), rel=1e-15)


def test_the_mesh_with_the_least_clearance_shortens_the_tip():
    def train(order: tuple[str, str], distance: float) -> MeshGeometry:
        tooth = {"module": 3e-3, "face_width": 0.03}
        system = gb.RotorSystem(
            shafts=[gb.Shaft(n, length=0.2, outer_diameter=0.03, elements=2) for n in "abc"],
            gears=[
                gb.Gear("idler", "a", 0.1, 20, **tooth, profile_shift=0.9),
                gb.Gear("near", "b", 0.1, 35, **tooth, profile_shift=0.9),
                gb.Gear("far", "c", 0.1, 35, **tooth, profile_shift=0.2),
            ],
            meshes=[
                gb.Mesh("idler", name, centre_distance=None if name == "far" else distance)
                for name in order
            ],
            bearings=[gb.Bearing(n, x, stiffness=1e8) for n in "abc" for x in (0.0, 0.2)],
        )
        return mesh_geometry(system.description)[order.index("near")]

    alone = at_rest(pair((20, 35), (0.9, 0.9)))
    distance = alone["centre_distance"]
    for order in (("near", "far"), ("far", "near")):
        assert train(order, distance)["tip_radii"] == alone["tip_radii"]
        # A larger distance needs no shortening for this mesh.
        assert train(order, distance + 1.5e-3)["tip_radii"][0] > alone["tip_radii"][0] + 1e-5


def test_a_centre_distance_that_leaves_no_tooth_is_an_error():
    message = (
        r"^meshes\[0\]\.centre_distance: at 0\.0803 m, the root circle of \"gb\" leaves no tooth above "
        r"the base circle of \"ga\"; use a larger centre_distance or a smaller profile_shift"
    )
    with pytest.raises(gb.SceneError, match=message):
        pair((20, 35), (0.9, 1.2), centre_distance=0.0803)


def test_no_centre_distance_without_play_is_an_error():
    message = (
        r"^meshes\[0\]\.centre_distance: no distance is without play: the values of profile_shift of "
        r"\"ga\" and \"gb\" add up to -1\.6, and their teeth need more than -1\.126; use a larger "
        r"profile_shift, or give centre_distance$"
    )
    with pytest.raises(gb.SceneError, match=message):
        pair((20, 35), (-0.8, -0.8))
    # −55 inv 20°/(2 tan 20°): just above it, there is a solution.
    involute = math.tan(math.radians(20.0)) - math.radians(20.0)
    assert -55.0 * involute / (2.0 * math.tan(math.radians(20.0))) == pytest.approx(
        -1.126, abs=5e-4
    )
    with pytest.warns(gb.SceneWarning):
        found = at_rest(pair((20, 35), (-0.56, -0.565), tips=(0.033, 0.0555)))
    assert found["centre_distance"] > sum(found["base_radii"])


def test_a_profile_shift_without_module_is_an_error():
    gears = [
        {"name": "ga", "shaft": "a", "position": 0.1, "teeth": 20, "base_radius": 0.0282},
        {"name": "gb", "shaft": "b", "position": 0.1, "teeth": 35, "base_radius": 0.04935},
    ]
    plain = pair(centre_distance=0.084).description
    described = {**plain, "gears": [{**gear, "face_width": 0.03} for gear in gears]}
    # The play is unknown too: no warning, although this distance is 0.5 modules too large for 20°.
    gb.RotorSystem._from_description(
        {**described, "meshes": [{**described["meshes"][0], "backlash": 0.0}]}
    )
    described["gears"][0]["profile_shift"] = 0.3
    with pytest.raises(
        gb.SceneError,
        match=r"^gears\[0\]\.profile_shift: 0\.3 is a multiple of the module, which is not given; ",
    ):
        gb.RotorSystem._from_description(described)


def test_drawings_and_mode_shapes_have_the_same_centres():
    system = pair(**STAGES["first"], centre_line_angle=0.4)
    expected = 0.19 * np.array([math.cos(0.4), math.sin(0.4)])
    for layout in (
        Train.of(system.description, system.speed_ratios).layout,
        system.modes(count=2).layout,
    ):
        # The published distance has six digits.
        np.testing.assert_allclose(layout.shaft("b").origin[1:], expected, atol=5e-9)


@pytest.mark.parametrize("geometry", ["live", "frozen"])
@pytest.mark.parametrize(
    ("phase", "state"), [(0.0, gb.results.Contact.DRIVE), (math.pi, gb.results.Contact.BOTH)]
)
def test_the_contact_of_shifted_gears_follows_from_the_backlash(
    geometry: str, phase: float, state: gb.results.Contact
):
    """The bow moves the wheel away from the pinion, or into it by more than the backlash."""
    system = pair(
        **SPUR,
        bow=gb.Bow.half_sine(2e-4, phase=phase),
        torque=10.0,
        stiffness=2e8,
        damping_ratio=0.05,
        backlash=2e-5,
    )
    found = system.simulate(
        1e-5, 100.0, output_step=1e-6, record=["meshes"], geometry=geometry
    ).mesh(("ga", "gb"))
    assert found.contact[0] == state
    assert found.stiffness[0] == pytest.approx(4e8 if state == gb.results.Contact.BOTH else 2e8)


def test_stiffness_models_use_the_path_at_the_centres_without_play():
    teeth = Teeth(**SPUR)
    distance = at_rest(pair(**SPUR))["centre_distance"]
    ratio = teeth.contact_ratio(distance, 0.03)
    # ISO 6336-1 with the contact ratio of the operating centres.
    (za, zb), (xa, xb) = teeth.teeth, teeth.shifts
    flexibility = 0.04723 + 0.15551 / za + 0.25791 / zb - 0.00635 * xa - 0.11654 * xa / za
    flexibility += -0.00193 * xb - 0.24188 * xb / zb + 0.00529 * xa**2 + 0.00182 * xb**2
    expected = 0.8 / flexibility * 1e9 * 0.03 * (0.75 * ratio + 0.25)
    stiffness = pair(**SPUR).static().mesh(("ga", "gb")).stiffness
    assert float(stiffness) == pytest.approx(expected, rel=1e-12)
    # The mean number of pairs over one mesh cycle is the contact ratio.
    square = pair(**SPUR, stiffness=gb.Stiffness.square(pair=2e8, engagement="sharp"), torque=1.0)
    cycle = 2.0 * math.pi / 20.0
    run = square.simulate(
        cycle, 1.0, times=(np.arange(1000) + 0.5) * cycle / 1000, initial="static"
    )
    # One sample in 1000 at each of two edges.
    assert run.mesh(("ga", "gb")).pairs_in_contact.mean() == pytest.approx(ratio, abs=2e-3)
