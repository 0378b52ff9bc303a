"""Mesh resonance of a spur pair: jumps and hysteresis occur only if the flanks separate."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference.teeth import Toothed, tips

TEETH, ZETA, ERROR = 50, 0.05, 2e-6
STEEL = Toothed(teeth=(TEETH, TEETH))
# gears of 50 teeth, module 3 mm, 20 mm wide, solid disks on the pitch circle
INERTIA = 7850 * np.pi / 2 * 0.075**4 * 0.02


def pair(torque: float, stiffness: Any, contact_ratio: float = 2.0) -> gb.RotorSystem:
    tip = tips(STEEL, contact_ratio)
    error = {"tooth": [(ERROR, 0.0)]}
    mesh = {"stiffness": stiffness, "damping_ratio": ZETA, "backlash": 1e-4, "error": error}
    scene = Toothed(
        teeth=(TEETH, TEETH),
        gear={"tip_radius": tip},
        mesh=mesh,
        torque=torque,
        inertia=(INERTIA, INERTIA),
    )
    return scene.package()


def sweep(system: gb.RotorSystem, speeds: Iterable[float]) -> np.ndarray:
    """Return the RMS deflection about its mean and the smallest deflection; each speed continues
    the run before it.
    """
    last: Any = "static"
    found = []
    for speed in speeds:
        cycle = 2 * np.pi / (speed * TEETH)
        begin = 0.0 if isinstance(last, str) else last.final["time"]
        times = begin + (120 + np.arange(400) / 40) * cycle
        last = system.simulate(130 * cycle, speed, initial=last, times=times, record=["meshes"])
        deflection = last.mesh(("ga", "gb")).deflection
        found.append((np.std(deflection), np.min(deflection)))
    return np.array(found)


@pytest.mark.parametrize(
    "stiffness",
    [
        {"model": "potential_energy", "bore_radii": (0.025, 0.025), "phase": "prescribed"},
        {"model": "square", "mean": 4.5e8, "engagement": 0.1, "phase": "prescribed"},
    ],
    ids=lambda given: given["model"],
)
def test_softening_jump_and_hysteresis_under_light_load_alone(stiffness: dict[str, Any]):
    ratios = np.linspace(0.66, 1.14, 17)
    curves = {}
    for torque in (100.0, 2000.0):
        system = pair(torque, stiffness)
        omega = 2 * np.pi * system.modes().frequencies_hz.max()
        speeds = ratios * omega / TEETH
        curves[torque] = sweep(system, speeds), sweep(system, speeds[::-1])[::-1]
    up, down = curves[100.0]
    # two motions exist at the same speed below resonance; flanks separate in the larger one only
    two = np.abs(up[:, 0] - down[:, 0]) > 0.05 * down[:, 0]
    assert np.count_nonzero(two) >= 3
    assert np.all(ratios[two] < 0.95)
    assert np.all(down[two, 0] > 2 * up[two, 0])
    assert np.all(down[two, 1] < 0)
    assert np.all(up[two, 1] > 0)
    assert up[~two, 0] == pytest.approx(down[~two, 0], rel=1e-3)
    # with rising speed the amplitude more than doubles in one step of the sweep
    assert np.max(up[1:, 0] / up[:-1, 0]) > 2
    # the heavy load exceeds the dynamic force: the flanks stay in contact and there is one motion
    up, down = curves[2000.0]
    assert up[:, 1].min() > 0
    assert up[:, 0] == pytest.approx(down[:, 0], rel=1e-3)
    assert np.max(up[1:, 0] / up[:-1, 0]) < 2
    assert 0.97 < ratios[np.argmax(up[:, 0])] < 1.03


def test_heavily_loaded_peak_is_the_linear_one():
    """With constant stiffness only the transmission error excites the pair, and the peak is known."""
    system = pair(1000.0, {"model": "constant", "mean": 4.5e8})
    omega = 2 * np.pi * system.modes().frequencies_hz.max()
    ratios = np.array([0.7, 0.9, 1.0, 1.1])
    found = sweep(system, ratios * omega / TEETH / np.sqrt(1 - ZETA**2))
    # frequencies_hz are damped ones: omega_n sqrt(1 - zeta^2)
    linear = ERROR * ratios**2 / np.hypot(1 - ratios**2, 2 * ZETA * ratios) / np.sqrt(2)
    # tolerance of 1e-6 per step, and the transient of the previous speed
    assert found[:, 0] == pytest.approx(linear, rel=1e-4)


def test_parametric_part_scales_with_the_load():
    """Without transmission error the motion is proportional to the load, also with separation, up
    to the backlash.
    """
    curves = []
    for torque in (100.0, 300.0):
        scene = Toothed(
            teeth=(TEETH, TEETH),
            mesh={
                "stiffness": {
                    "model": "potential_energy",
                    "bore_radii": (0.025, 0.025),
                    "phase": "prescribed",
                },
                "damping_ratio": ZETA,
                "backlash": 1e-3,
            },
            torque=torque,
            inertia=(INERTIA, INERTIA),
        )
        system = scene.package()
        omega = 2 * np.pi * system.modes().frequencies_hz.max()
        curves.append(sweep(system, np.array([1.1, 1.0, 0.9]) * omega / TEETH) / torque)
        assert curves[-1][:, 1].min() < 0
    assert curves[0] == pytest.approx(curves[1], rel=1e-6)
