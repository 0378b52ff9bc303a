"""Parametric resonance of a torsional pair: Meissner's equation (square stiffness) and Mathieu's
(one harmonic).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from reference.teeth import Toothed, begin, tips

PAIR = 1.5e8
RATIO = 1.6
BARE = Toothed()
MEISSNER = replace(
    BARE,
    gear={"tip_radius": tips(BARE, RATIO)},
    mesh={"stiffness": {"model": "square", "pair": PAIR, "engagement": "sharp"}},
)
OMEGA_1, OMEGA_2 = (np.sqrt(k / BARE.effective_mass) for k in (PAIR, 2 * PAIR))


def monodromy(speed: float) -> np.ndarray:
    period = 2 * np.pi / (speed * BARE.teeth[0])
    parts = []
    for omega, share in ((OMEGA_1, 2 - RATIO), (OMEGA_2, RATIO - 1)):
        c, s = np.cos(omega * share * period), np.sin(omega * share * period)
        parts.append(np.array([[c, s / omega], [-omega * s, c]]))
    return parts[1] @ parts[0]


def criterion(speed: float) -> float:
    period = 2 * np.pi / (speed * BARE.teeth[0])
    a, b = OMEGA_1 * (2 - RATIO) * period, OMEGA_2 * (RATIO - 1) * period
    ratio = OMEGA_1 / OMEGA_2 + OMEGA_2 / OMEGA_1
    return abs(2 * np.cos(a) * np.cos(b) - ratio * np.sin(a) * np.sin(b))


def boundaries() -> list[float]:
    """Return the speeds where the criterion is 2, in descending order: instability regions at 2
    omega / 1, / 2, ...
    """
    speeds = np.geomspace(3.0, 0.5, 4001) * (OMEGA_1 + OMEGA_2) / 2 / BARE.teeth[0]
    excess = np.array([criterion(s) - 2 for s in speeds])
    at = np.flatnonzero(np.diff(np.sign(excess)))
    return [brentq(lambda s: criterion(s) - 2, speeds[i], speeds[i + 1]) for i in at]


def log_amplitude(scene: Toothed, speed: float, cycles: int) -> np.ndarray:
    """Return the logarithm of the largest deflection of each mesh cycle, from a small initial
    deflection.
    """
    system = scene.package()
    n = len(system.dofs)
    y = np.zeros(2 * n)
    y[:2] = 1e-5  # both ends of the shaft of the driver
    options = {"rtol": 1e-9}
    period = 2 * np.pi / (speed * scene.teeth[0])
    found = system.simulate(
        cycles * period,
        speed,
        initial=begin(system, speed, y, **options),
        times=(np.arange(cycles * 40) + 0.5) * period / 40,
        record=["meshes"],
        **options,
    )
    deflection = found.mesh(("ga", "gb")).deflection.reshape(cycles, 40)
    return np.log(np.abs(deflection).max(axis=1) / (1e-5 * scene.law().base_radius_a))


def test_the_criterion_is_the_trace_of_the_monodromy_matrix():
    for speed in np.linspace(300.0, 2000.0, 50):
        assert criterion(speed) == pytest.approx(abs(np.trace(monodromy(speed))), rel=1e-12)


@pytest.mark.parametrize("tongue", [0, 1, 2, 3])
@pytest.mark.parametrize("off", [-4e-3, 4e-3])
def test_growth_and_decay_on_both_sides_of_the_stability_boundary(tongue: int, off: float):
    speed = boundaries()[tongue] * (1 + off)
    multiplier = np.abs(np.linalg.eigvals(monodromy(speed))).max()
    cycles = 150
    found = log_amplitude(MEISSNER, speed, cycles)
    if criterion(speed) > 2:
        assert multiplier > 1.01
        # the second multiplier is negligible after the first third
        rate = (found[-1] - found[cycles // 3]) / (cycles - 1 - cycles // 3)
        assert rate == pytest.approx(np.log(multiplier), rel=5e-3)
    else:
        # near a boundary the motion has beats but does not grow
        states = np.array([[1.0, 0.0]])
        for _ in range(cycles):
            states = np.vstack([states, monodromy(speed) @ states[-1]])
        # between whole cycles it may be larger by the change of energy within one cycle
        assert found.max() < np.log(np.hypot(states[:, 0], states[:, 1] / OMEGA_1).max()) + np.log(
            2
        )
        assert found[cycles // 2 :].max() - found[: cycles // 2].max() < 0.1


@pytest.mark.parametrize("excess", [-0.1, 0.1])
@pytest.mark.parametrize("zeta", [0.005, 0.02])
def test_mathieu_threshold_at_the_principal_resonance(zeta: float, excess: float):
    mean = 2e8
    h = 4 * zeta * (1 + excess)
    fourier = {"model": "fourier", "mean": mean, "amplitudes": [h * mean], "phase": "prescribed"}
    scene = replace(BARE, mesh={"stiffness": fourier, "damping_ratio": zeta})
    omega = np.sqrt(mean / BARE.effective_mass)
    cycles = int(6 / zeta)
    found = log_amplitude(scene, 2 * omega / BARE.teeth[0], cycles)
    # (h/4 - zeta) omega, over half a period; the next terms are of order h^2
    half = cycles // 2
    rate = (found[-1] - found[half]) / (cycles - 1 - half)
    assert rate == pytest.approx((h / 4 - zeta) * np.pi, abs=2 * zeta**2 * np.pi)
    assert np.sign(rate) == np.sign(excess)
