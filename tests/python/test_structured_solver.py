"""Frequency-domain analyses with band matrices against dense linear algebra of the same matrices."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import gearbow as gb
from test_random_scenes import Drawn, scenes

pytestmark = pytest.mark.implausible

ROTORS = sorted((Path(__file__).parents[2] / "examples/rotors").glob("*.toml"))


def tolerance(system: gb.RotorSystem, speed: float = 0.0) -> float:
    """Return 1e-9, or ten times the relative round-off of the slowest motion in dense matrices.

    The round-off of K, the square of the highest frequency, acts on the slowest elastic mode and, at a
    speed, on the rigid-body rotation, whose only dynamic stiffness is the square of a spin.
    """
    frequencies = 2 * np.pi * system.modes().frequencies_hz
    slowest = frequencies[frequencies > 1e-6 * frequencies[-1]][0]
    if speed:
        slowest = min(slowest, np.abs(speed * system.speed_ratios).min())
    return max(1e-9, 10 * np.finfo(float).eps * (frequencies[-1] / slowest) ** 2)


def assert_same_response(system: gb.RotorSystem, speeds: np.ndarray) -> None:
    found = system.synchronous(speeds).amplitudes
    wanted = through_dense_matrices(system).synchronous(speeds).amplitudes
    for speed, one, other in zip(speeds, found, wanted, strict=True):
        scale = max(np.abs(other).max(), 1e-12)
        assert np.abs(one - other).max() <= tolerance(system, speed) * scale


def through_dense_matrices(system: gb.RotorSystem) -> gb.RotorSystem:
    """Return the system with a modal damping that is below round-off, which takes dense matrices."""
    return system.replace(modal_damping=1e-300)


@scenes(30)
def test_the_synchronous_response_is_that_of_dense_matrices(scene: Drawn):
    assert_same_response(scene.system(), np.array([-300.0, 0.0, 17.0, 150.0, 900.0]))


@pytest.mark.parametrize("path", ROTORS, ids=lambda path: path.stem)
def test_published_rotors_have_the_response_of_dense_matrices(path: Path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gb.SceneWarning)
        system = gb.RotorSystem.load(path)
    assert_same_response(system, np.linspace(0.0, 2000.0, 21))


def refined(scene: Drawn) -> gb.RotorSystem:
    """Return the scene with so many elements that a few of its modes take band matrices."""
    elements = tuple(max(10, 30 // len(scene.lengths)) for _ in scene.lengths)
    return replace(scene, elements=elements).system()


@scenes(10)
def test_the_lowest_modes_are_those_of_dense_matrices(scene: Drawn):
    system = refined(scene)
    found, wanted = system.modes(scene.speed, count=8), system.modes(scene.speed)
    size = np.abs(wanted.eigenvalues[:8])
    round_off = (
        np.finfo(float).eps * (np.abs(wanted.eigenvalues).max() / np.maximum(size, 1e-9)) ** 2
    )
    difference = np.abs(found.eigenvalues - wanted.eigenvalues[:8])
    assert np.all(difference <= np.maximum(1e-9, 10 * round_off) * size)
