"""Invariants: symmetry, energy, rotated and mirrored scenes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gearbow as gb
from reference import scenes
from reference.bows import HalfSine
from reference.scenes import PAIR, GearAt, Geared

BOWED = Geared(
    bows={"input": HalfSine(2e-4, 0.3), "middle": HalfSine(3e-4, -1.2), "output": HalfSine(1e-4)},
    angles=(0.4, -1.1),
)


@pytest.mark.parametrize(
    "build",
    [
        BOWED.package,
        replace(BOWED, options={"reference": "output"}).package,
        replace(BOWED, bearing_stiffness=np.array([[1e8, 2e7], [2e7, 5e7]])).package,
        scenes.v1,
        scenes.v2,
        scenes.v3,
    ],
    ids=["demo", "other reference", "anisotropic", "Rao", "Nelson", "Friswell"],
)
def test_mass_and_stiffness_symmetric_gyroscopic_skew(build):
    matrices = build().matrices()
    for name in ("mass", "stiffness", "damping"):
        matrix = getattr(matrices, name)
        # sums of the same products in another order: a few units in the last place of the largest
        # entry
        assert np.abs(matrix - matrix.T).max() <= 1e-15 * np.abs(matrix).max(), name
    g = matrices.gyroscopic
    assert np.abs(g + g.T).max() <= 1e-15 * np.abs(g).max()
    assert np.abs(g).max() > 0
    assert np.linalg.eigvalsh(matrices.mass).min() > 0
    # no negative stiffness, up to round-off
    scale = 1 / np.sqrt(np.diag(matrices.mass))
    squares = np.linalg.eigvalsh(matrices.stiffness * np.outer(scale, scale))
    assert squares.min() > -1e-12 * squares.max()


# Undamped, zero speed, bowed shafts that start straight: the bow is released and the train
# vibrates with live geometry. No work is done, so kinetic plus elastic energy is constant.
FREE = replace(
    PAIR,
    bows={"input": HalfSine(1e-3, 0.3), "output": HalfSine(6e-4, -1.0)},
    angles=(0.5,),
    elements=2,
    torque=0.0,
    mesh_damping_ratio=0.0,
    bearing_damping=0.0,
)


def drift(system: gb.RotorSystem, torques: dict[str, float] | None = None, **how: object) -> float:
    """Return the largest change of energy minus torque work, relative to the vibration energy."""
    response = system.simulate(
        5e-3, 0.0, initial="rest", record=("energy", "gears", "meshes"), output_step=1e-4, **how
    )
    total = response.energy.copy()
    for at, torque in (torques or {}).items():
        total -= torque * response.twist(at)
    scale = max(total[0], np.ptp(response.energy))
    return float(np.abs(total - total[0]).max() / scale)


def first_step(system: gb.RotorSystem) -> float:
    response = system.simulate(1e-6, 0.0, initial="rest", method="rk45", times=[0.0])
    # a whole number of steps to each output time, 0.4 at the highest frequency
    return 1e-4 / np.ceil(1e-4 * response.statistics.omega_max / 0.4)


def test_energy_at_the_start_is_that_of_the_bow():
    train = FREE.reference()
    strain = sum(
        train.bow_shape(s, 0.0) @ train.elastic @ train.bow_shape(s, 0.0) for s in train.shafts
    )
    response = FREE.package().simulate(
        1e-5, 0.0, initial="rest", record=("energy",), times=[0.0], method="rk4"
    )
    assert response.energy[0] == pytest.approx(strain / 2, rel=1e-9)  # two assemblies, round-off


def test_works_of_an_exact_motion_are_exact():
    # A rotating bowed shaft is released: the fastest phase changes by tens of radians per sample,
    # by hundreds per step, and the bearings dissipate its energy.
    shaft = gb.Shaft("a", length=1.0, outer_diameter=0.05, elements=15, bow=gb.Bow.half_sine(1e-4))
    bearings = [gb.Bearing("a", x, stiffness=1e8, damping=500.0) for x in (0.0, 1.0)]
    system = gb.RotorSystem([shaft], bearings=bearings)
    response = system.simulate(0.05, 100.0, initial="rest", record=("energy",), output_step=1e-4)
    balance = response.energy_balance()
    assert response.statistics.step_max * response.statistics.omega_max > 100
    # two quadrature rules agree to 1e-8 of all works on each of thousands of parts; the more
    # accurate one has a much smaller error
    assert np.abs(balance.residual).max() <= 1e-9 * np.abs(balance.total).max()


def test_energy_drift_of_rk4_falls_with_the_fifth_power_of_the_step():
    system = FREE.package()
    h = first_step(system)
    drifts = [drift(system, method="rk4", step=h / 2**i) for i in range(3)]
    # |R(i x)|^2 = 1 - x^6/72: the energy loss in a given time is of fifth order, ratio 32;
    # 10 % for the higher terms at x = 0.4
    assert drifts[0] / drifts[1] > 28
    assert drifts[1] / drifts[2] > 28
    assert drifts[2] > 1e-14  # otherwise the ratio would be dominated by round-off


def test_energy_drift_of_rk45_falls_with_the_tolerance():
    system = FREE.package()
    loose, middle, tight = (drift(system, method="rk45", rtol=r) for r in (1e-5, 1e-8, 1e-11))
    assert (
        middle < loose / 30
    )  # a proportional error would give 1000; stability may limit the step at a loose tolerance
    assert tight < middle / 30
    assert tight < 1e-8


def test_energy_minus_work_of_the_torque_is_constant():
    system = replace(FREE, torque=400.0).package()
    torques = {"g1": 400.0, "g2": 800.0}
    assert drift(system, torques, method="rk45", rtol=1e-11) < 1e-8
    # the load does work, so without it the balance fails
    assert drift(system, {"g1": 400.0}, method="rk45", rtol=1e-11) > 1e-2


def test_energy_is_constant_with_live_geometry_only():
    # a bow at which the centres move by millimetres, two thirds of the way to overlapping base
    # circles
    large = replace(FREE, bows={"input": HalfSine(1.8e-3, 0.3)})
    system = large.package()
    assert drift(system, method="rk45", rtol=1e-11) < 1e-8
    response = system.simulate(5e-3, 0.0, initial="rest", method="rk45", output_step=1e-4)
    assert np.ptp(response.mesh(("g1", "g2")).pressure_angle) > np.radians(1)


def spun(scene: Geared, angle: float) -> Geared:
    """Return the scene rotated about x by an angle."""
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s], [s, c]])
    return replace(
        scene,
        angles=[a + angle for a in scene.angles],
        bows={n: HalfSine(b.amplitude, b.phase + angle) for n, b in scene.bows.items()},
        gears=[replace(g, unbalance=g.unbalance * np.exp(1j * angle)) for g in scene.gears],
        gravity=tuple(turn @ scene.gravity),
        bearing_stiffness=turn @ scene.bearing_stiffness @ turn.T,
        bearing_damping=turn @ scene.bearing_damping @ turn.T,
    )


UNEQUAL = replace(
    BOWED,
    gravity=(2.0, -9.81),
    bearing_stiffness=np.array([[1e8, 1e7], [1e7, 4e7]]),
    bearing_damping=np.array([[500.0, 50.0], [50.0, 900.0]]),
    gears=[
        GearAt("g1", "input", 0.25, 25, unbalance=2e-3),
        GearAt("g2", "middle", 0.125, 50, unbalance=1e-3j),
        GearAt("g3", "middle", 0.375, 25),
        GearAt("g4", "output", 0.25, 50, unbalance=-3e-3 + 1e-3j),
    ],
)
NAMES = ("g1", "g2", "g3", "g4")
RUNS = {
    "rk4 from rest": {"method": "rk4", "initial": "rest"},
    "rk4 from synchronous": {"method": "rk4", "initial": "synchronous"},
    "frozen": {"method": "rk4", "initial": "rest", "geometry": "frozen"},
}


def run(scene: Geared, speed: float, **how: object) -> gb.Response:
    return scene.package().simulate(4e-3, speed, output_step=1e-4, **how)


@pytest.mark.parametrize("how", RUNS.values(), ids=RUNS.keys())
def test_rotated_scene_has_the_rotated_motion(how: dict[str, str]):
    angle, speed = 0.83, 150.0
    first, second = run(UNEQUAL, speed, **how), run(spun(UNEQUAL, angle), speed, **how)
    for name in NAMES:
        u = first.displacement(name) @ np.array([1, 1j])
        turned = second.displacement(name) @ np.array([1, 1j])
        # the same steps in rotated coordinates: round-off, multiplied by the phase of the stiffest
        # mode
        assert np.abs(turned - u * np.exp(1j * angle)).max() < 1e-9 * np.abs(u).max()
        twist = first.twist(name)
        assert np.abs(second.twist(name) - twist).max() < 1e-9 * np.abs(twist).max()
    for pair in UNEQUAL.meshes:
        a, b = first.mesh(pair), second.mesh(pair)
        assert np.abs(b.force - a.force).max() < 1e-8 * np.abs(a.force).max()
        assert b.contact_ratio == pytest.approx(a.contact_ratio, rel=1e-9)


def mirrored(scene: Geared) -> Geared:
    """Return the scene mirrored in the xz plane: y and all senses of rotation change sign."""
    flip = np.diag([-1.0, 1.0])
    return replace(
        scene,
        angles=[np.pi - a for a in scene.angles],
        bows={n: HalfSine(b.amplitude, np.pi - b.phase) for n, b in scene.bows.items()},
        gears=[replace(g, unbalance=-np.conj(g.unbalance)) for g in scene.gears],
        gravity=(-scene.gravity[0], scene.gravity[1]),
        torque=-scene.torque,
        bearing_stiffness=flip @ scene.bearing_stiffness @ flip,
        bearing_damping=flip @ scene.bearing_damping @ flip,
    )


@pytest.mark.parametrize("how", RUNS.values(), ids=RUNS.keys())
def test_mirrored_scene_with_opposite_spin_has_the_mirrored_motion(how: dict[str, str]):
    speed = 150.0
    first, second = run(UNEQUAL, speed, **how), run(mirrored(UNEQUAL), -speed, **how)
    for name in NAMES:
        u, other = first.displacement(name), second.displacement(name)
        assert np.abs(other - u * [-1, 1]).max() < 1e-9 * np.abs(u).max()  # as above
        twist = first.twist(name)
        assert np.abs(second.twist(name) + twist).max() < 1e-9 * np.abs(twist).max()
    for pair in UNEQUAL.meshes:
        a, b = first.mesh(pair), second.mesh(pair)
        # the driver drives in both: the same tooth force, of the same sign
        assert np.mean(a.force) > 0
        assert np.abs(b.force - a.force).max() < 1e-8 * np.abs(a.force).max()


@pytest.mark.parametrize("speed", [80.0, -80.0])
def test_modes_of_rotated_and_mirrored_scenes(speed: float):
    expected = UNEQUAL.package().modes(speed=speed)
    for scene, sense in ((spun(UNEQUAL, -1.9), 1.0), (mirrored(UNEQUAL), -1.0)):
        found = scene.package().modes(speed=sense * speed)
        # round-off of the eigensolver; the rigid-body rotation is 0
        assert found.frequencies_hz[:40] == pytest.approx(
            expected.frequencies_hz[:40], rel=1e-8, abs=1e-6
        )
        assert found.damping_ratios[1:40] == pytest.approx(
            expected.damping_ratios[1:40], rel=1e-6, abs=1e-10
        )


def test_a_bowed_shaft_at_rest_does_not_move():
    # the start already has the bow shape: nothing moves, although the bow force is large
    scene = replace(FREE, elements=4)
    response = scene.package().simulate(
        2e-3, 0.0, initial="synchronous", geometry="frozen", output_step=1e-4, method="rk45"
    )
    for name, bow in (("g1", 1e-3 * np.exp(0.3j)), ("g2", 6e-4 * np.exp(-1.0j))):
        u = response.displacement(name) @ np.array([1, 1j])
        # the bow is zero at the bearings and the train rotates freely: the gear has the bow
        # displacement
        assert np.abs(u - bow).max() < 1e-8 * abs(bow)
