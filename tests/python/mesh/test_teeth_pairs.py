"""Tooth pairs on the path of contact: number, duration, stiffness; clearance with a larger centre
distance.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference.teeth import TeethLaw, Toothed, begin, body_compliance, pair_stiffness, tips

SPEED, CYCLES, PER_CYCLE = 20.0, 4, 1000
MEAN = 2e8
RATIOS = [0.9, 1.0, 1.02, 1.5, 1.98, 2.0, 2.3, 3.0]


def with_ratio(contact_ratio: float, **mesh: Any) -> Toothed:
    scene = Toothed(mesh=mesh)
    return replace(scene, gear={"tip_radius": tips(scene, contact_ratio)})


def over_cycles(scene: Toothed, count: int = CYCLES, **options: Any) -> gb.Response:
    """Sample the mesh cycle at equal distances between the switching phases, so that counts are
    exact to one sample.
    """
    period = 2 * np.pi / (SPEED * scene.teeth[0])
    times = (np.arange(count * PER_CYCLE) + 0.5) * period / PER_CYCLE
    options = {"initial": "rest", "times": times} | options
    return scene.package().simulate(count * period, SPEED, **options)


@pytest.mark.parametrize("method", ["rk45", "rk4"])
@pytest.mark.parametrize("contact_ratio", RATIOS)
def test_mean_number_of_pairs_is_the_contact_ratio(contact_ratio: float, method: str):
    square = {"model": "square", "mean": MEAN, "engagement": "sharp"}
    mesh = over_cycles(with_ratio(contact_ratio, stiffness=square), method=method).mesh(
        ("ga", "gb")
    )
    assert mesh.contact_ratio == pytest.approx(contact_ratio, abs=1e-12)
    # the ratios are whole numbers of 1/1000 of a cycle, so that the count is exact
    assert np.mean(mesh.pairs_in_contact) == pytest.approx(contact_ratio, abs=1e-6)
    assert np.mean(mesh.stiffness) == pytest.approx(MEAN, rel=1e-6)
    # the stiffness at every instant is that of the counted pairs
    pair = MEAN / contact_ratio
    assert mesh.stiffness == pytest.approx(pair * mesh.pairs_in_contact, abs=1e-9 * MEAN)
    assert np.abs(np.diff(mesh.stiffness)).max() < pair * (1 + 1e-9)


@pytest.mark.parametrize("width", [0.02, 0.1, 0.5])
@pytest.mark.parametrize("contact_ratio", RATIOS)
def test_smooth_engagement_keeps_the_mean_and_never_jumps(contact_ratio: float, width: float):
    square = {"model": "square", "mean": MEAN, "engagement": width, "phase": "prescribed"}
    mesh = over_cycles(with_ratio(contact_ratio, stiffness=square), count=1).mesh(("ga", "gb"))
    # error of the mean of a periodic curve with two derivatives: (1/1000)^3 times the jump of its
    # third, 60/width^3
    assert np.mean(mesh.stiffness) == pytest.approx(MEAN, rel=1e-6)
    # the ramp 6x^5 - 15x^4 + 10x^3 has a slope of at most 15/8 over its width; two pairs are never
    # on their ramps at once
    rise = 2 * 15 / 8 / (width * PER_CYCLE) * MEAN / contact_ratio
    assert np.abs(np.diff(mesh.stiffness)).max() < rise


def test_mean_of_a_parabolic_pair():
    scene = {"model": "parabolic", "mean": MEAN, "end_ratio": 0.5}
    sharp = over_cycles(with_ratio(1.6, stiffness={**scene, "engagement": "sharp"})).mesh(
        ("ga", "gb")
    )
    # midpoint rule, with jumps between two samples
    assert np.mean(sharp.stiffness) == pytest.approx(MEAN, rel=1e-6)
    pair = MEAN / 1.6 / (0.5 + 0.5 * 2 / 3)  # the mean of a parabola that decreases to 1/2 is 5/6
    assert np.max(sharp.stiffness) < 2 * pair
    # single contact in the middle of the path, where the parabola is flat
    single = sharp.stiffness[sharp.pairs_in_contact == 1]
    assert np.max(single) == pytest.approx(pair, rel=1e-5)
    smooth = over_cycles(
        with_ratio(1.6, stiffness={**scene, "engagement": 0.1, "phase": "prescribed"})
    )
    assert np.mean(smooth.mesh(("ga", "gb")).stiffness) == pytest.approx(MEAN, rel=1e-6)


@pytest.mark.parametrize("opened", [0.0, 3e-4, 8e-4, -2e-4])
def test_share_of_time_of_each_number_of_pairs_follows_the_centre_distance(opened: float):
    scene = Toothed(mesh={"stiffness": {"model": "square", "pair": 1.2e8, "engagement": "sharp"}})
    law = scene.law()
    opened_scene = replace(
        scene, mesh={**scene.mesh, "centre_distance": law.centre_distance + opened}
    )
    mesh = over_cycles(opened_scene).mesh(("ga", "gb"))
    ratio = law.contact_ratio(law.centre_distance + opened)
    assert mesh.contact_ratio == pytest.approx(ratio, abs=1e-12)
    assert 1 < ratio < 2
    # one of the thousand samples of a cycle at each end
    assert np.mean(mesh.pairs_in_contact == 2) == pytest.approx(ratio - 1, abs=1.01 / PER_CYCLE)
    assert np.mean(mesh.pairs_in_contact == 1) == pytest.approx(2 - ratio, abs=1.01 / PER_CYCLE)
    assert np.mean(mesh.stiffness) == pytest.approx(1.2e8 * ratio, rel=1.01 / PER_CYCLE)


@pytest.mark.parametrize("opened", [0.0, 3e-4, 1e-3])
def test_a_larger_centre_distance_widens_the_clearance_of_both_flanks(opened: float):
    """Run-out increases the centre distance; the clearance of both flanks follows from the force."""
    backlash, turn = 1e-4, 0.02
    scene = Toothed(
        mesh={"stiffness": MEAN, "backlash": backlash}, gear={"runout": (None, opened or None)}
    )
    system, law = scene.package(), scene.law()
    alpha_0 = law.angle_at_rest
    alpha = np.arccos(law.sum_of_radii / (law.centre_distance + opened))
    wider = 2 * law.sum_of_radii * (np.tan(alpha) - alpha - np.tan(alpha_0) + alpha_0)
    lost = []
    for sign in (1, -1):
        y = np.zeros(2 * len(system.dofs))
        y[:2] = sign * turn  # both ends of the shaft of the driver
        found = system.simulate(0.0, 0.0, initial=begin(system, 0.0, y), times=[0.0]).mesh(
            ("ga", "gb")
        )
        assert found.centre_distance == pytest.approx(law.centre_distance + opened, rel=1e-14)
        assert np.sign(found.force) == [sign]
        lost.append(turn * law.base_radius_a - abs(found.force[0]) / MEAN)
    # round-off of deflections of 0.7 mm
    assert lost[0] == pytest.approx(wider / 2, abs=1e-16)
    assert sum(lost) == pytest.approx(backlash + wider, abs=1e-16)


def test_iso_6336_is_the_default_stiffness():
    scene = Toothed(teeth=(25, 50), face_width=0.03)
    mesh = over_cycles(scene, count=1).mesh(("ga", "gb"))
    # q' 0.0586086, c' 13.65 and c_gamma 20.64 N/(mm um), times 30 mm, each with four digits
    assert mesh.stiffness == pytest.approx(20.64e9 * 0.03, rel=3e-4)
    assert 0.8 / 0.0586086 == pytest.approx(13.65, abs=5e-3)
    exact = (
        0.8
        / (0.04723 + 0.15551 / 25 + 0.25791 / 50)
        * (0.75 * mesh.contact_ratio + 0.25)
        * 1e9
        * 0.03
    )
    assert mesh.stiffness == pytest.approx(exact, rel=1e-14)


PAIRS = [
    ((25, 50), 3e-3, (0.01, 0.02)),
    ((50, 50), 3e-3, (0.025, 0.025)),
    ((19, 48), 3.2e-3, (0.01, 0.018)),
]


@pytest.mark.parametrize(("teeth", "module", "bores"), PAIRS)
def test_potential_energy_against_an_independent_quadrature(
    teeth: tuple[int, int], module: float, bores: tuple[float, float]
):
    width = 0.02
    stiffness = {"model": "potential_energy", "engagement": "sharp", "bore_radii": bores}
    scene = Toothed(teeth=teeth, module=module, face_width=width, mesh={"stiffness": stiffness})
    law = scene.law()
    mesh = over_cycles(scene, count=1).mesh(("ga", "gb"))
    tangent = law.centre_distance * np.sin(law.angle_at_rest)
    low = tangent - np.sqrt(law.tip_radius_b**2 - law.base_radius_b**2)
    high = np.sqrt(law.tip_radius_a**2 - law.base_radius_a**2)
    period = 2 * np.pi / (SPEED * teeth[0])
    phases = (np.arange(PER_CYCLE) + 0.5) * period / PER_CYCLE * SPEED
    errors = []
    for i in range(0, PER_CYCLE, 20):
        s = law.base_radius_a * (phases[i] + law.angle_at_rest)
        places = [s + j * law.base_pitch for j in range(-6, 6)]
        expected = width * sum(
            pair_stiffness(teeth, module, bores, tangent, at) for at in places if low <= at <= high
        )
        errors.append(mesh.stiffness[i] / expected - 1)
    # the package interpolates the stiffness of the pair by a cubic
    assert np.abs(errors).max() < 2e-9


@pytest.mark.parametrize(("teeth", "module", "bores"), PAIRS)
def test_pairs_that_share_the_gear_bodies(
    teeth: tuple[int, int], module: float, bores: tuple[float, float]
):
    width = 0.02
    stiffness = {"model": "potential_energy", "engagement": "sharp", "bore_radii": bores}
    stiffness["foundation"] = "shared"
    scene = Toothed(teeth=teeth, module=module, face_width=width, mesh={"stiffness": stiffness})
    law = scene.law()
    mesh = over_cycles(scene, count=1).mesh(("ga", "gb"))
    tangent = law.centre_distance * np.sin(law.angle_at_rest)
    low, high = TeethLaw(law).path(law.centre_distance)
    period = 2 * np.pi / (SPEED * teeth[0])
    phases = (np.arange(PER_CYCLE) + 0.5) * period / PER_CYCLE * SPEED
    counts = set()
    for i in range(0, PER_CYCLE, 20):
        s = law.base_radius_a * (phases[i] + law.angle_at_rest)
        places = [at for j in range(-6, 6) if low <= (at := s + j * law.base_pitch) <= high]
        counts.add(len(places))
        bodies = np.array(
            [
                body_compliance(teeth[0], module, bores[0], at)
                + body_compliance(teeth[1], module, bores[1], tangent - at)
                for at in places
            ]
        )
        alone = [1 / pair_stiffness(teeth, module, bores, tangent, at) for at in places] - bodies
        # every pair deflects by its own force and by the deflection of the gear bodies under all
        # forces
        yields = np.diag(alone) + np.sqrt(np.outer(bodies, bodies))
        expected = width * np.linalg.solve(yields, np.ones(len(places))).sum()
        assert mesh.stiffness[i] == pytest.approx(
            expected, rel=1e-8
        )  # interpolation error of the tables
    assert counts == {1, 2}
    # linear analyses use the mean stiffness; jumps lie between two samples
    mean = float(scene.package().static().mesh(("ga", "gb")).stiffness)
    assert mesh.stiffness.mean() == pytest.approx(mean, rel=2 / PER_CYCLE)


def test_the_standard_stiffness_lies_between_shared_and_separate_gear_bodies():
    scene = Toothed(face_width=0.03)
    # N/(mm um): the larger of two pairs in contact, for gears on shafts of 50 mm
    found = {}
    for foundation in ("separate", "shared"):
        model = {"model": "potential_energy", "bore_radii": (0.025, 0.025), "engagement": "sharp"}
        teeth = replace(scene, mesh={"stiffness": model | {"foundation": foundation}})
        mesh = over_cycles(teeth, count=1).mesh(("ga", "gb"))
        found[foundation] = mesh.stiffness[mesh.pairs_in_contact == 2].max() / 0.03e9
    assert found["separate"] == pytest.approx(21.5, abs=0.1)
    assert found["shared"] == pytest.approx(13.4, abs=0.1)


def test_gear_bodies_outside_the_fitted_range_warn():
    def build(bores: tuple[float, float]) -> None:
        gb.RotorSystem(
            shafts=[gb.Shaft(name, length=0.2, outer_diameter=0.03, elements=2) for name in "ab"],
            gears=[
                gb.Gear(f"g{name}", name, 0.1, teeth=z, module=3e-3, face_width=0.03)
                for name, z in zip("ab", (25, 50), strict=True)
            ],
            meshes=[gb.Mesh("ga", "gb", stiffness=gb.Stiffness.potential_energy(bores))],
        )

    build((0.024, 0.05))  # 1.41 and 1.43; a warning is an error here
    message = r"^meshes\[0\]\.stiffness\.bore_radii\[1\]: .*\"gb\" is 1\.295 times .* 1\.4 to 7"
    with pytest.warns(gb.SceneWarning, match=message):
        build((0.024, 0.055))
    with pytest.warns(gb.SceneWarning, match=r"\"ga\" is 8\.438 times"):
        build((0.004, 0.05))


def test_shared_gear_bodies_and_tip_relief_exclude_each_other():
    stiffness = {"model": "potential_energy", "foundation": "shared"}
    scene = Toothed(mesh={"stiffness": stiffness, "tip_relief": {"amount": 1e-5, "length": 2e-3}})
    with pytest.raises(gb.SceneError, match=r"^meshes\[0\]\.stiffness\.foundation: \"shared\""):
        scene.package()


def test_potential_energy_has_the_published_shape():
    bores = (0.025, 0.025)
    stiffness = {"model": "potential_energy", "engagement": "sharp", "bore_radii": bores}
    scene = Toothed(teeth=(50, 50), face_width=0.02, mesh={"stiffness": stiffness})
    mesh = over_cycles(scene, count=1).mesh(("ga", "gb"))
    single = mesh.stiffness[mesh.pairs_in_contact == 1]
    double = mesh.stiffness[mesh.pairs_in_contact == 2]
    # steel pairs: 10 to 20 N/(mm um) each, softest at the ends of the path, where two pairs share
    # the load
    assert 10e9 * 0.02 < single.min() < single.max() < 20e9 * 0.02
    assert 1.3 * single.max() < double.min() < double.max() < 2 * single.max()
    # equal gears: symmetric about the pitch point, and stiffest there in single contact
    assert single == pytest.approx(single[::-1], rel=1e-2)
    middle = np.argmax(single) / len(single)
    assert 0.4 < middle < 0.6
