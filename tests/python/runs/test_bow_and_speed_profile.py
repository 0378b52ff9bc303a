"""Compare speed profiles and bows with the formulas in their documentation."""

from __future__ import annotations

import numpy as np
import pytest

import gearbow as gb
from gearbow.description.bow import Bow

TIMES = np.array([0.0, 1.0, 1.5, 2.0, 4.0, 9.0])


def test_a_ramp():
    run = gb.SpeedProfile.ramp(10.0, -30.0, 4.0, begin=1.0)
    np.testing.assert_allclose(run(TIMES), [10.0, 10.0, 5.0, 0.0, -20.0, -30.0])


def test_a_table():
    run = gb.SpeedProfile.table([1.0, 2.0, 5.0], [7.0, 3.0, 9.0])
    np.testing.assert_allclose(run(TIMES), [7.0, 7.0, 5.0, 3.0, 7.0, 9.0])


def test_a_polynomial():
    # 2 + 3 s - s² + 0.5 s³ from 1 s, then 4 - s from 3 s, with s the time since then
    run = gb.SpeedProfile([1.0, 3.0, 4.0], [[0.5, 0.0], [-1.0, 0.0], [3.0, -1.0], [2.0, 8.0]])
    np.testing.assert_allclose(run([1.0, 2.0, 2.5, 3.5, 9.0]), [2.0, 4.5, 5.9375, 7.5, 7.0])


def test_a_function():
    run = gb.SpeedProfile.function(lambda t: 50.0 * np.cos(3.0 * t), 2.0, begin=1.0)
    times = np.linspace(1.0, 3.0, 1001)
    np.testing.assert_allclose(run(times), 50.0 * np.cos(3.0 * times), atol=5e-9)
    np.testing.assert_allclose(run([0.0, 9.0]), 50.0 * np.cos([3.0, 9.0]), atol=5e-9)


def curve_of(bow: Bow, length: float, where: np.ndarray) -> np.ndarray:
    """Return the slow-roll shape of a shaft on stiff bearings at its ends."""
    shaft = gb.Shaft("s", length=length, outer_diameter=0.05, elements=8, bow=bow)
    bearings = [gb.Bearing("s", x, stiffness=1e10) for x in (0.0, length)]
    system = gb.RotorSystem([shaft], bearings=bearings, motion="lateral")
    found = system.synchronous([1e-2])
    return np.array([found.displacement(("s", float(x)))[0, 0, 0] for x in where])


LENGTH = 0.5  # the length is not 1 m, so that positions and relative positions differ
WHERE = LENGTH * np.arange(1, 8) / 8
SHAPES = {
    "half_sine": (Bow.half_sine(1e-4, phase=0.6), 1e-4 * np.exp(0.6j) * np.sin(np.pi * WHERE / LENGTH)),
    "mode": (Bow.mode(3, 1e-4, phase=-1.0), 1e-4 * np.exp(-1j) * np.sin(3 * np.pi * WHERE / LENGTH)),
    "function": (
        Bow.function(lambda x: 1e-3 * x * (LENGTH - x) * np.exp(2j * x)),
        1e-3 * WHERE * (LENGTH - WHERE) * np.exp(2j * WHERE),
    ),
    "points": (
        Bow.points(LENGTH * np.arange(9) / 8, 1e-4 * np.sin(np.pi * np.arange(9) / 8), phases=0.8),
        1e-4 * np.exp(0.8j) * np.sin(np.pi * WHERE / LENGTH),
    ),
}  # fmt: skip


@pytest.mark.parametrize("shape", SHAPES)
def test_a_slow_shaft_shows_its_bow(shape: str):
    bow, expected = SHAPES[shape]
    # a spline meets its points, here the nodes; the speed is 1e-5 of the first critical speed
    assert curve_of(bow, LENGTH, WHERE) == pytest.approx(expected, abs=1e-9)


def test_sag_is_the_deflection_under_its_own_weight():
    # 16/5 (ξ - 2 ξ³ + ξ⁴) of a slender beam on two supports; shear adds a term of order (d/L)²
    shaft_ratio = WHERE / LENGTH
    expected = 1e-4 * np.exp(0.6j) * 16 / 5 * (shaft_ratio - 2 * shaft_ratio**3 + shaft_ratio**4)
    found = curve_of(Bow.sag(1e-4, phase=0.6), LENGTH, WHERE)
    assert np.abs(found[3]) == pytest.approx(1e-4, rel=1e-6)
    assert np.angle(found) == pytest.approx(np.full(7, 0.6), abs=1e-6)
    # half a sine, the nearest other shape, is 6e-7 m away from it at an eighth of the length
    assert found == pytest.approx(expected, abs=3e-7)
