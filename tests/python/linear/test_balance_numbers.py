"""Numbers and text that a balance result reports."""

from __future__ import annotations

import numpy as np
import pytest

from reference.machines import rotor_with_two_disks

SPEEDS = np.array([100.0, 180.0])


def test_a_balance_contains_its_arguments():
    found = rotor_with_two_disks().balance(
        ["b", ("s", 0.25)], SPEEDS, target="elastic", points=["a", ("s", 0.5)]
    )
    assert found.planes == ("b", ("s", 0.25))
    assert found.points == ("a", ("s", 0.5))
    assert found.target == "elastic"
    np.testing.assert_array_equal(found.speeds, SPEEDS)
    assert found.unbalances.shape == (2,)
    assert found.before.shape == found.residual.shape == (2, 2, 2)


def test_the_initial_deflection_is_that_of_the_system():
    system = rotor_with_two_disks()
    own = system.synchronous(SPEEDS)
    for target, read in (("total", own.displacement), ("elastic", own.elastic)):
        found = system.balance(["a"], SPEEDS, target=target, points=["a", ("s", 0.5)])
        expected = np.stack([read(point)[:, 0] for point in ("a", ("s", 0.5))], axis=1)
        assert found.before == pytest.approx(expected, abs=1e-15)


def test_all_nodes_are_measured_by_default():
    # six elements between 0 and 1 m, the disks at 0.3 m and 0.7 m, and the plane
    found = rotor_with_two_disks().balance([("s", 0.25)], SPEEDS)
    nodes = {x for _, x, _ in found.system.dofs}
    assert {0.0, 0.25, 0.3, 0.7, 1.0} <= nodes
    assert {x for _, x in found.points} == nodes
    assert len(found.points) == len(nodes)
    assert found.target == "total"


def test_the_correction_is_added_to_the_existing_unbalance():
    system = rotor_with_two_disks()
    found = system.balance(["a", "b"], SPEEDS)
    for name, correction in zip(("a", "b"), found.unbalances, strict=True):
        (before,) = (disk for disk in system.disks if disk.name == name)
        (after,) = (disk for disk in found.system.disks if disk.name == name)
        assert after.unbalance == pytest.approx(before.unbalance + correction, rel=1e-15)
        assert (after.mass, after.position) == (before.mass, before.position)


def test_the_residual_ratio_is_residual_over_initial_response():
    found = rotor_with_two_disks().balance(["a"], SPEEDS)
    expected = np.sqrt(np.sum(np.abs(found.residual) ** 2) / np.sum(np.abs(found.before) ** 2))
    assert found.residual_ratio == pytest.approx(expected, rel=1e-12)
    assert expected < 1.0


def test_a_plane_without_a_body_has_no_mass():
    found = rotor_with_two_disks().balance([("s", 0.25)], SPEEDS)
    (plane,) = (disk for disk in found.system.disks if disk.name == "balance s 0.25")
    assert (plane.shaft, plane.position) == ("s", 0.25)
    assert (plane.mass, plane.diametral_inertia, plane.polar_inertia) == (0.0, 0.0, 0.0)
    assert plane.unbalance == pytest.approx(found.unbalances[0], rel=1e-15)
