"""Frequency-domain analyses with band matrices against dense linear algebra of the same matrices."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest
from test_random_scenes import Drawn, scenes

import gearbow as gb

pytestmark = pytest.mark.implausible

ROTORS = sorted((Path(__file__).parents[2] / "examples/rotors").glob("*.toml"))


def tolerance(system: gb.RotorSystem) -> float:
    """Return 1e-9, or ten times the relative round-off of the slowest mode in dense matrices."""
    frequencies = system.modes().frequencies_hz
    elastic = frequencies[frequencies > 1e-6 * frequencies[-1]]
    return max(1e-9, 10 * np.finfo(float).eps * (frequencies[-1] / elastic[0]) ** 2)




def undamped_by(system: gb.RotorSystem) -> gb.RotorSystem:
    """Return the system with a modal damping that is below round-off, which takes dense matrices."""
    return system.replace(modal_damping=1e-300)


@scenes(30)
def test_the_synchronous_response_is_that_of_dense_matrices(scene: Drawn):
    system = scene.system()
    speeds = [-300.0, 0.0, 17.0, 150.0, 900.0]
    found = system.synchronous(speeds).amplitudes
    wanted = undamped_by(system).synchronous(speeds).amplitudes
    part = tolerance(system)
    for one, other in zip(found, wanted, strict=True):
        assert np.abs(one - other).max() <= part * max(np.abs(other).max(), 1e-12)


@pytest.mark.parametrize("path", ROTORS, ids=lambda path: path.stem)
def test_published_rotors_have_the_response_of_dense_matrices(path: Path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gb.SceneWarning)
        system = gb.RotorSystem.load(path)
    speeds = np.linspace(0.0, 2000.0, 21)
    found = system.synchronous(speeds).amplitudes
    wanted = undamped_by(system).synchronous(speeds).amplitudes
    scale = np.abs(wanted).max(axis=(1, 2), keepdims=True)
    assert np.all(np.abs(found - wanted) <= tolerance(system) * np.maximum(scale, 1e-12))
