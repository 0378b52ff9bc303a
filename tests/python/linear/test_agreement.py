"""Modes, static equilibrium, synchronous response and simulated motion of a linear system agree, with modal damping too.

The machines of the fleet are made linear: teeth of constant stiffness, and lines of action that do not move. A run that begins
in the static equilibrium is the sum of the equilibrium, the synchronous response and a decaying motion in the modes.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gearbow as gb
from fleet import FOLDER, Machine
from fleet_analyses import places, turn

pytestmark = pytest.mark.skipif(not FOLDER.is_dir(), reason="the examples are not installed")

#: Promised error of displacements at the accuracy "engineering", relative to their RMS; 1e-5 is reached.
PROMISED = 1e-3


def linear(system: gb.RotorSystem) -> gb.RotorSystem:
    """Return a machine with constant stiffnesses and without tooth errors.

    Twist turns the bows, which is of second order: there are no torques, and the bows are small.
    """
    meshes = [
        gb.Mesh(
            mesh.driver,
            mesh.driven,
            stiffness=4e8,
            damping_ratio=mesh.damping_ratio,
            centre_distance=mesh.centre_distance,
        )
        for mesh in system.meshes
    ]
    bearings = [
        bearing
        if isinstance(bearing, gb.Bearing)
        else gb.Bearing(
            bearing.shaft,
            bearing.position,
            stiffness=2e8,
            damping=1e3,
            axial_stiffness=bearing.axial_stiffness,
            support=bearing.support,
        )
        for bearing in system.bearings
    ]
    gears = [replace(gear, runout=0.0) for gear in system.gears]
    shafts = [
        replace(shaft, bow=shaft.bow and replace(shaft.bow, amplitude=0.01 * shaft.bow.amplitude))
        for shaft in system.shafts
    ]
    parts = {"shafts": shafts, "gears": gears, "meshes": meshes, "bearings": bearings}
    return system.replace(**parts, torques=[], drives=[])


@pytest.mark.parametrize(
    "name",
    [
        "bowed_rotor",
        "geared_pair",
        "overhung_rotor",
        "helical_gear",
        "double_stage_train",
        pytest.param("idler_train", marks=pytest.mark.slow),
        pytest.param("coaxial_reducer", marks=pytest.mark.slow),
    ],
)
def test_a_run_is_the_sum_of_equilibrium_synchronous_response_and_modes(name: str) -> None:
    machine = Machine(name)
    system, speed = linear(machine.system), machine.speed
    times = np.linspace(0.0, 0.25 * turn(system, speed), 60)
    run = system.simulate(
        float(times[-1]),
        speed,
        initial="static",
        geometry="frozen",
        record=places(system),
        times=times,
    )
    spins = system.speed_ratios * speed
    phasors = system.synchronous(speed).amplitudes[0]
    modes = system.modes(speed)
    # The conjugate of an oscillating mode is a mode, too.
    oscillating = modes.eigenvalues.imag > 0.0
    values = np.append(modes.eigenvalues, modes.eigenvalues[oscillating].conj())
    shapes = np.vstack([modes.shapes, modes.shapes[oscillating].conj()]).T
    states = np.vstack([shapes, shapes * values])
    sizes = np.linalg.norm(states, axis=0)
    # The run begins without the synchronous motion, which the decaying motion cancels.
    begin = -np.append(phasors.sum(axis=0).real, (1j * spins @ phasors).real)
    parts = np.linalg.lstsq(states / sizes, begin.astype(complex), rcond=None)[0] / sizes
    decaying = (shapes * parts) @ np.exp(np.outer(values, times))
    turning = phasors.T @ np.exp(1j * np.outer(spins, times))
    motion = (
        system.static(speed=speed, geometry="frozen").state[:, None] + (turning + decaying).real
    )
    at = {place: list(system.coordinates.lateral(place)) for place in places(system)}
    pairs = [(run.displacement(place)[:, :2], motion[at[place]].T) for place in at]
    scale = max(np.sqrt(np.mean((found - found.mean(axis=0)) ** 2)) for found, _ in pairs)
    for found, expected in pairs:
        assert np.sqrt(np.mean((found - expected) ** 2)) < PROMISED * scale
