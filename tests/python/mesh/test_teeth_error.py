"""Mesh excitation other than stiffness: transmission error, run-out, tip relief."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from reference.teeth import TeethLaw, Toothed

K, ZETA, SPEED = 2e8, 0.08, 500.0
HARMONICS: dict[str, list[tuple[float, float]]] = {
    "tooth": [(2e-6, 0.4), (5e-7, -1.0)],
    "driver": [(1e-5, 0.0), (0.0, 0.0), (4e-6, 2.0)],
    "driven": [(8e-6, 1.0)],
}


def settled(scene: Toothed, speed: float = SPEED, **more: Any) -> Any:
    """Run until the transients are exp(-0.08 * 2e4 * 0.03) = 1e-21."""
    times = 0.03 + np.linspace(0.0, 2 * np.pi / abs(speed), 400)
    options = {"times": times, "rtol": 1e-10} | more
    return scene.package().simulate(times[-1], speed, **options)


@pytest.mark.parametrize(
    "given", [*({key: value} for key, value in HARMONICS.items()), HARMONICS], ids="+".join
)
@pytest.mark.parametrize("speed", [SPEED, -SPEED, 820.0])
def test_harmonic_error_against_the_linear_response(given: dict[str, Any], speed: float):
    """m d'' + c d' + k d = load - m e'': a force on the pair of m omega^2 times each harmonic."""
    torque = 60.0 * np.sign(speed)
    scene = Toothed(mesh={"stiffness": K, "damping_ratio": ZETA, "error": given}, torque=torque)
    found = settled(scene, speed)
    m, law = scene.effective_mass, scene.law()
    c = 2 * ZETA * np.sqrt(K * m)
    expected = np.full(len(found.time), abs(torque) / law.base_radius_a / K)
    rate = np.zeros_like(expected)
    for key, order in (("tooth", 25.0), ("driver", 1.0), ("driven", -0.5)):
        for n, (amplitude, phase) in enumerate(given.get(key, []), start=1):
            # e = amplitude cos(n order angle + phase) of a shaft that may rotate backwards
            omega = n * order * speed
            response = m * omega**2 * amplitude / (K - m * omega**2 + 1j * c * omega)
            turning = response * np.exp(1j * (omega * found.time + phase))
            expected, rate = expected + turning.real, rate + (1j * omega * turning).real
    mesh = found.mesh(("ga", "gb"))
    scale = np.ptp(expected)
    # rtol is 1e-10 of the whole motion, which is larger than the vibration
    assert mesh.deflection == pytest.approx(expected, abs=1e-6 * scale)
    assert mesh.force == pytest.approx(K * expected + c * rate, abs=1e-6 * K * scale)


def test_a_table_is_interpolated_by_a_cubic():
    grid = np.arange(32) / 32
    table = 2e-6 * np.cos(2 * np.pi * grid + 0.4) + 5e-7 * np.cos(4 * np.pi * grid - 1.0)
    forces = []
    for error in ({"table": table.tolist()}, {"tooth": HARMONICS["tooth"]}):
        scene = Toothed(mesh={"stiffness": K, "damping_ratio": ZETA, "error": error}, torque=60.0)
        forces.append(settled(scene).mesh(("ga", "gb")).force)
    # a cubic through 16 points a period of the second harmonic
    assert forces[0] == pytest.approx(forces[1], abs=2e-4 * np.ptp(forces[1]))


@pytest.mark.parametrize("out", [(3e-5, 0.0), (0.0, 4e-5j), (2e-5 + 1e-5j, -3e-5)])
def test_runout_moves_the_centres(out: tuple[complex, complex]):
    """At low speed, run-out moves the gear centre on a circle; compare the geometry and the
    resulting twist.
    """
    speed = 0.5
    scene = Toothed(mesh={"stiffness": K, "damping_ratio": 0.3}, gear={"runout": out}, torque=60.0)
    times = np.linspace(0.02, 4 * np.pi / speed, 100)
    found = scene.package().simulate(times[-1], speed, times=times, initial="static", rtol=1e-7)
    mesh, law = found.mesh(("ga", "gb")), scene.law()
    twist = (found.twist("ga"), found.twist("gb"))
    angles = (speed * times, -speed / 2 * times)
    e_a, e_b = (o * np.exp(1j * (a + t)) for o, a, t in zip(out, angles, twist, strict=True))
    centres = law.centre_distance + e_b - e_a
    assert mesh.centre_distance == pytest.approx(np.abs(centres), rel=1e-12)
    assert mesh.centre_line_angle == pytest.approx(np.angle(centres), abs=1e-12)
    assert mesh.contact_ratio == pytest.approx(
        [law.contact_ratio(d) for d in np.abs(centres)], rel=1e-12
    )
    # the tooth force equals the static one up to the small inertia force at 2 Hz, so the deflection
    # is constant
    load = 60.0 / law.base_radius_a
    assert mesh.force == pytest.approx(load, rel=1e-3)
    rolled = law.base_radius_a * twist[0] + law.base_radius_b * twist[1]
    alpha, alpha_0 = np.arccos(law.sum_of_radii / np.abs(centres)), law.angle_at_rest
    turned = law.sum_of_radii * np.angle(centres)
    opened = law.sum_of_radii * (np.tan(alpha) - alpha - np.tan(alpha_0) + alpha_0)
    assert rolled == pytest.approx(load / K + turned + opened, abs=1e-3 * load / K)


@pytest.mark.parametrize(("shape", "exponent"), [("linear", 1), ("parabolic", 2)])
@pytest.mark.parametrize("torque", [30.0, 150.0])
def test_load_shared_by_relieved_pairs(shape: str, exponent: int, torque: float):
    """Two equal pairs with reliefs r: k(d - r1) + k(d - r2) = F with both in contact, k(d - r) = F
    with one.
    """
    pair, speed = 1.5e8, 0.4
    amount, length = (
        3e-5,
        3e-3,
    )  # the relief exceeds the deflection, so that pairs enter and leave without load
    mesh = {
        "stiffness": {"model": "square", "pair": pair, "engagement": "sharp"},
        "tip_relief": {"amount": amount, "length": length, "shape": shape},
        "damping_ratio": 0.05,
    }
    scene = Toothed(mesh=mesh, torque=torque)
    law = scene.law()
    period = 2 * np.pi / (speed * scene.teeth[0])
    times = 0.05 + np.linspace(0.0, period, 73)
    found = scene.package().simulate(times[-1], speed, times=times, rtol=1e-7).mesh(("ga", "gb"))
    low, high = TeethLaw(law).path(law.centre_distance)
    load = torque / law.base_radius_a
    expected, touching = [], []
    for t in times:
        s = law.base_radius_a * (speed * t + law.angle_at_rest)
        places = [s + j * law.base_pitch for j in range(-8, 8)]
        reliefs = sorted(
            amount * sum(max(1 - left / length, 0.0) ** exponent for left in (at - low, high - at))
            for at in places
            if low <= at <= high
        )
        alone = load / pair + reliefs[0]
        both = len(reliefs) == 2 and reliefs[1] < alone
        expected.append((load / pair + sum(reliefs)) / 2 if both else alone)
        touching.append(1 + both)
    # quasi-static: damping changes the deflection by 2 zeta / omega times the rate, 5e-6 s * 1e-4
    # m/s
    assert found.deflection == pytest.approx(expected, abs=2e-3 * np.ptp(expected))
    assert found.force == pytest.approx(load, rel=2e-3)
    # number of pairs in contact, except where a change is near
    assert np.mean(np.round(found.stiffness / pair) == touching) > 0.95
