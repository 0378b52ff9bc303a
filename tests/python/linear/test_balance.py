"""Balancing of a bowed rotor: the predicted residual equals the simulated one."""

from __future__ import annotations

import numpy as np
import pytest

import gearbow as gb
from reference.machines import jeffcott, rotor_with_two_disks
from test_synchronous import BOWED


@pytest.mark.parametrize("target", ["total", "elastic"])
def test_the_balance_of_a_single_mass_is_the_closed_form(target: str):
    # z (1 − r² + 2iζr) = δ + (e + e') r²: z = 0, or z = δ
    bow, speed, eccentricity = 1e-4 * np.exp(0.5j), 120.0, 2e-5 - 1e-5j
    system = jeffcott(bow=bow, eccentricity=eccentricity)
    stiffness = 20.0 * abs(system.modes(count=1).eigenvalues[0]) ** 2
    found = system.balance(["disk"], speed, target=target, points=["disk"])
    if target == "total":
        needed = -stiffness * bow / speed**2 - 20.0 * eccentricity
    else:
        needed = (-20.0 * speed**2 + 400j * speed) * bow / speed**2 - 20.0 * eccentricity
    # the light shaft and the damping at its middle leave 1e-4
    assert found.unbalances[0] == pytest.approx(needed, rel=1e-3)
    assert found.residual_ratio < 1e-9


@pytest.mark.parametrize("target", ["total", "elastic"])
def test_the_predicted_residual_equals_that_of_a_run(target: str):
    system, speed, points = rotor_with_two_disks(), 180.0, ["a", ("s", 0.5), "b"]
    found = system.balance(["a", "b"], speed, target=target, points=points)
    assert found.residual_ratio < 0.5
    times = np.linspace(0.0, 2 * np.pi / speed, 24, endpoint=False)
    response = found.system.simulate(times[-1], speed, times=times, record=points, rtol=1e-10)
    turn = np.exp(1j * speed * times)
    for i, point in enumerate(points):
        bow = 1e-4 * np.exp(0.6j) * np.sin(np.pi * {"a": 0.3, "b": 0.7}.get(str(point), 0.5))
        taken = np.array([bow, -1j * bow]) if target == "elastic" else np.zeros(2)
        shown = response.displacement(point) - np.real(np.outer(turn, taken))
        expected = np.real(np.outer(turn, found.residual[0, i]))
        assert shown == pytest.approx(expected, abs=1e-6 * np.abs(found.before).max())


def test_balancing_the_displacement_does_not_balance_the_deflection():
    system = jeffcott(bow=1e-4, eccentricity=0.0)
    total, elastic = (
        system.balance(["disk"], 120.0, target=target, points=["disk"])
        for target in ("total", "elastic")
    )
    assert abs(total.unbalances[0] / elastic.unbalances[0]) > 2.0
    still = total.system.synchronous(120.0)
    straight = elastic.system.synchronous(120.0)
    # zero runout requires a deflection by the bow; zero deflection leaves the bow as runout
    assert np.abs(still.displacement("disk")).max() < 1e-12
    assert np.abs(still.elastic("disk")[0, 0, 0]) == pytest.approx(1e-4, rel=1e-9)
    assert np.abs(straight.elastic("disk")).max() < 1e-12
    assert np.abs(straight.displacement("disk")[0, 0, 0]) == pytest.approx(1e-4, rel=1e-9)
    # a straight shaft has bearing forces of round-off only
    assert (
        np.abs(straight.bearing_force(("s", 0.0))).max()
        < 0.1 * np.abs(still.bearing_force(("s", 0.0))).max()
    )


def test_balancing_planes_without_a_body_at_several_speeds():
    system, speeds = rotor_with_two_disks(), [100.0, 180.0, 260.0]
    found = system.balance([("s", 0.25), "b", ("s", 0.9)], speeds)
    assert found.before.shape == found.residual.shape
    assert found.before.shape[0] == 3
    assert {disk.name for disk in found.system.disks} == {
        "a",
        "b",
        "balance s 0.25",
        "balance s 0.9",
    }
    own = found.system.synchronous(speeds)
    shown = np.stack([own.displacement(point)[:, 0] for point in found.points], axis=1)
    assert shown == pytest.approx(found.residual, abs=1e-9 * np.abs(found.before).max())
    # least squares: every other correction leaves a larger residual
    best = np.linalg.norm(found.residual)
    for change in (1e-5, 1e-5j):
        disks = [
            gb.Disk(
                d.name, d.shaft, d.position, d.mass, d.diametral_inertia, d.polar_inertia,
                unbalance=d.unbalance + change * (d.name == "b"),
            )
            for d in found.system.disks
        ]  # fmt: skip
        other = found.system.replace(disks=disks).synchronous(speeds)
        left = np.stack([other.displacement(point)[:, 0] for point in found.points], axis=1)
        assert np.linalg.norm(left) > best


def test_a_rotor_of_grams_is_balanced_without_a_warning():
    # a trial unbalance of 1 kg m would move it by more than its length
    system = gb.RotorSystem(
        [gb.Shaft("s", length=0.2, outer_diameter=0.004, bow=gb.Bow.half_sine(1e-5))],
        bearings=[gb.Bearing("s", x, stiffness=1e5, damping=5.0) for x in (0.0, 0.2)],
        disks=[gb.Disk("d", "s", 0.1, 0.05, 6e-6, 1e-5, unbalance=3e-7j)],
    )
    found = system.balance(["d"], 200.0, points=["d"])
    after = found.system.synchronous(200.0).displacement("d")[0, 0]
    assert np.linalg.norm(after) < 1e-6 * np.linalg.norm(found.before)


def test_a_gear_of_a_train_is_a_balancing_plane():
    system = BOWED.package()
    found = system.balance(["g2"], 150.0, points=["g2"])
    before, after = (s.synchronous(150.0).displacement("g2")[0, 1] for s in (system, found.system))
    assert np.linalg.norm(after) < np.linalg.norm(before)
    assert after == pytest.approx(found.residual[0, 0], abs=1e-9 * np.abs(before).max())


@pytest.mark.parametrize(
    ("planes", "given", "message"),
    [
        (["a"], {"target": "half"}, "target: must be one of total, elastic, got 'half'"),
        (["c"], {}, r'planes\[0\]: no gear or disk is called "c"'),
        ([], {}, "planes: must name at least one"),
        (["a"], {"speed": 0.0}, "speed: must not be zero, got 0.0"),
    ],
)
def test_invalid_balancing_arguments(planes, given, message):
    with pytest.raises(gb.SceneError, match=message):
        rotor_with_two_disks().balance(planes, **{"speed": 100.0, **given})


def test_balancing_planes_must_be_on_one_shaft():
    with pytest.raises(gb.SceneError, match="must be one or more planes on the same shaft"):
        BOWED.package().balance(["g1", "g2"], 100.0)
