"""The gearbox of docs/gearbox.md: hand calculations, and copies of its scene that must agree."""

from __future__ import annotations

import runpy
from math import cos, pi, radians, tan
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import gearbow as gb

ROOT = Path(__file__).parents[3]
EXAMPLE = ROOT / "examples" / "gearbox.py"

pytestmark = pytest.mark.skipif(not EXAMPLE.is_file(), reason="the examples are not installed")


@pytest.fixture(scope="module")
def example() -> SimpleNamespace:
    pytest.importorskip("matplotlib")
    return SimpleNamespace(**runpy.run_path(str(EXAMPLE), run_name="gearbox"))


@pytest.fixture(scope="module")
def system(example) -> gb.RotorSystem:
    return example.gearbox()


@pytest.fixture(scope="module")
def static(example, system):
    return system.static(speed=example.SPEED)


def forces_by_hand(example, system):
    """Tangential, radial and axial force of both stages, N."""
    gears = {gear.name: gear for gear in system.gears}
    torque = example.POWER / example.SPEED
    return [
        example.tooth_forces(torque * ratio, gears[name])
        for name, ratio in (("pinion 1", 1.0), ("pinion 2", 61.0 / 23.0))
    ]


def test_the_document_and_the_benchmark_have_the_scene_of_the_example(system):
    source = EXAMPLE.read_text(encoding="utf-8")
    scene = source[source.index("def gearbox()") : source.index("def straight")].strip()
    assert scene in (ROOT / "docs" / "gearbox.md").read_text(encoding="utf-8")
    stored = gb.RotorSystem.load(ROOT / "benches" / "gearbox.toml")
    assert stored.description == system.description


def test_mesh_forces_are_those_of_the_torque(example, system, static):
    for pair, helix, (tangential, _, _) in zip(
        example.STAGES, (20.0, 12.0), forces_by_hand(example, system), strict=True
    ):
        normal = tangential / (cos(radians(20.0)) * cos(radians(helix)))
        # Live geometry: the centres move by 0.1 mm or less, which changes the lever arm by less than 1e-3.
        assert static.mesh(pair).force == pytest.approx(normal, rel=1e-3)


def test_locating_bearings_carry_the_thrusts(example, system, static):
    first, second = (forces[2] for forces in forces_by_hand(example, system))
    found = [
        static.axial_bearing_force(place)
        for place in (("input", 0.28), ("intermediate", 0.02), ("output", 0.03))
    ]
    # The coupling takes 12 N of the first one, 0.5 % of it, because the shaft yields to the thrust.
    np.testing.assert_allclose(found, (first, second - first, -second), rtol=0.01)
    total = sum(found) + static.axial_bearing_force(("motor", 0.05))
    assert abs(total) < 1e-3 * first


def test_bearings_of_the_intermediate_shaft_carry_a_beam(example, system, static):
    (t1, r1, a1), (t2, r2, a2) = forces_by_hand(example, system)
    gears = {gear.name: gear for gear in system.gears}
    arms = [example.reference_radius(gears[name]) for name in ("wheel 1", "pinion 2")]
    tilt = (a1 * arms[0] + a2 * arms[1]) / 0.18
    share = np.array([(gears[name].position - 0.02) / 0.18 for name in ("wheel 1", "pinion 2")])
    right = (np.array([[r1, -r2], [t1, t2]]) @ share) - [tilt, 0.0]
    left = (np.array([[r1, -r2], [t1, t2]]) @ (1.0 - share)) + [tilt, 0.0]
    # The weight of 130 N is missing along z; 10 N are for the lever arms of the moving centres.
    for x, by_hand in ((0.02, left), (0.20, right)):
        y, z = static.bearing_force(("intermediate", x)) - by_hand
        assert abs(y) < 10.0
        assert -100.0 < z < -30.0


def test_journals_carry_their_load_on_a_film(static):
    for x in (0.03, 0.21):
        film = static.journal(("output", x))
        assert 0.5 < film.eccentricity_ratio < 0.8


def test_the_bent_shaft_moves_its_gears_by_the_bow_relative_to_its_bearings(example, system):
    response = system.synchronous([example.SPEED])
    bow = lambda x: example.BOW * np.sin(pi * x / 0.22)  # noqa: E731
    for name, x in (("wheel 1", 0.07), ("pinion 2", 0.145)):
        line = np.interp(x, (0.02, 0.20), (bow(0.02), bow(0.20)))
        # 1 %: the mesh and the bearings resist a little.
        assert response.orbit(name)[0, 2] == pytest.approx(bow(x) - line, rel=0.01)


def test_thrust_is_the_tangential_force_times_the_tangent_of_the_helix(example, system):
    for (tangential, _, axial), helix in zip(
        forces_by_hand(example, system), (20.0, 12.0), strict=True
    ):
        assert axial == pytest.approx(tangential * tan(radians(helix)))


def test_the_error_of_component_modes_is_that_of_a_stable_reduction(example, system):
    # Oil films need all component modes, those with a small share too. Recorded bearings add many of them.
    record = ["gears", "meshes", "housings", "bearings"]
    options = {"output_step": 1e-3, "record": record}
    run = system.simulate(0.1, example.SPEED, accuracy="draft", **options)
    displacement, force = run.statistics.modes_error
    assert displacement < 1e-2
    assert force < 0.1
    # The orders of the cages are too close to others in 0.1 s.
    with pytest.warns(gb.AccuracyWarning, match="too close to each other"):
        run.orders("accelerometer", bearing_harmonics=1)
