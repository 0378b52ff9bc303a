"""Static equilibrium against closed forms of levers, torsion and gears."""

from __future__ import annotations

import numpy as np
import pytest

import gearbow as gb
from reference import scenes


def test_bearing_forces_follow_the_law_of_the_lever():
    # a shaft with a disk at a quarter of its length, gravity in both directions
    mass, stiffness, gravity = 40.0, 1e7, np.array([3.0, -9.0])
    system = gb.RotorSystem(
        [gb.Shaft("s", length=2.0, outer_diameter=0.05, elements=4)],
        disks=[gb.Disk("disk", "s", 0.5, mass, 0.1, 0.2)],
        bearings=[gb.Bearing("s", x, stiffness=stiffness) for x in (0.0, 2.0)],
        gravity=list(gravity),
        motion="lateral",
    )
    static = system.static()
    shaft = scenes.DENSITY * np.pi / 4 * 0.05**2 * 2.0
    for x, share in ((0.0, 0.75), (2.0, 0.25)):
        expected = (share * mass + shaft / 2) * gravity
        assert static.bearing_force(("s", x)) == pytest.approx(expected, rel=1e-9)
        assert static.displacement(("s", x)) == pytest.approx(expected / stiffness, rel=1e-9)


def test_a_torque_twists_a_shaft():
    torque, length, diameter = 50.0, 0.8, 0.03
    system = gb.RotorSystem(
        [gb.Shaft("s", length=length, outer_diameter=diameter, elements=4)],
        bearings=[gb.Bearing("s", x, stiffness=1e8) for x in (0.0, length)],
        torques=[gb.Torque(("s", length), torque), gb.Torque.balance(("s", 0.0))],
    )
    static = system.static()
    shear_modulus = scenes.E / (2 * (1 + scenes.NU))
    expected = torque * length / (shear_modulus * np.pi * diameter**4 / 32)
    twist = static.twist(("s", length)) - static.twist(("s", 0.0))
    assert twist == pytest.approx(expected, rel=1e-9)


def test_each_mesh_has_its_own_force():
    scene = scenes.Geared(torque=1.0)
    static = scene.package().static()
    radius = 0.5 * scene.module * 25 * np.cos(scene.pressure_angle)  # base radius of both drivers
    for pair, torque in ((("g1", "g2"), 1.0), (("g3", "g4"), 2.0)):
        mesh = static.mesh(pair)
        # the line of action moves with the centres, by 1e-5 at this torque
        assert mesh.force == pytest.approx(torque / radius, rel=1e-4)
        assert mesh.deflection == pytest.approx(torque / radius / scene.mesh_stiffness, rel=1e-4)
        assert mesh.stiffness == pytest.approx(scene.mesh_stiffness)
        assert mesh.pressure_angle == pytest.approx(scene.pressure_angle, rel=1e-4)
        assert mesh.centre_distance == pytest.approx(0.5 * scene.module * 75, rel=1e-4)


def test_the_speed_comes_first():
    system = gb.RotorSystem([gb.Shaft("s", length=1.0, outer_diameter=0.05, elements=1)])
    with pytest.raises(gb.SceneError, match=r"^speed: must be a number, got 'frozen'"):
        system.static("frozen")  # type: ignore[arg-type]
    with pytest.raises(gb.SceneError, match=r"^geometry: must be text, got 155.0"):
        system.static(geometry=155.0)  # type: ignore[arg-type]
