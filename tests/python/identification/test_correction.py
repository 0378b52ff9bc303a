"""Balancing of an identified system: the residual is that which was predicted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gearbow as gb
from test_identify import MICRON, PROBES, SPEEDS, TRIALS, WANTED, bent_pair, noisy, unbent, vectors

AT = [300.0, 900.0]
POINTS = [("input", 0.15), ("input", 0.4)]


def balanced(weights: dict) -> gb.RotorSystem:
    """Put weights on the true system."""
    bent = bent_pair()
    gears = [replace(g, unbalance=g.unbalance + weights.get(g.name, 0.0)) for g in bent.gears]
    disks = [gb.Disk(f"p{i}", *at, 0.0, 0.0, 0.0) for i, at in enumerate(POINTS)]
    return bent.replace(gears=gears, disks=disks)


def orbits(system: gb.RotorSystem) -> np.ndarray:
    """Return semi-axes that the input shaft causes, (speeds, points)."""
    response = system.synchronous(AT)
    return np.stack([response.orbit(at)[:, 0] for at in POINTS], axis=1)


def identified(seed: int) -> gb.results.Identification:
    """Identify bow and unbalance from noisy vibration."""
    exact = vectors(bent_pair(), SPEEDS, PROBES)
    measured = gb.Measurement(SPEEDS, noisy(exact, seed), PROBES)
    return gb.identify(unbent(bent_pair()), measured, WANTED, noise=MICRON)


def test_a_balanced_system_has_the_predicted_residual():
    inside = total = 0
    for seed in range(TRIALS // 20):
        found = identified(seed).balance("g1", AT, points=POINTS)
        left = orbits(balanced({"g1": found.unbalances[0]}))
        inside += int(((found.lower <= left) & (left <= found.upper)).sum())
        total += left.size
        rms = np.sqrt(np.mean(left**2))
        # The interval of 95 % is missed in a few trials; four times its width never.
        low, high = found.interval
        middle, width = (low + high) / 2, high - low
        assert abs(rms - middle) < 2.0 * width
    # Points of one trial are not independent: as if there were ten trials, one sigma is 7 %.
    assert inside / total > 0.8


def test_exact_data_give_the_weights_of_the_true_system():
    exact = gb.Measurement(SPEEDS, vectors(bent_pair(), SPEEDS, PROBES), PROBES)
    found = gb.identify(unbent(bent_pair()), exact, WANTED, noise=MICRON).balance("g1", AT)
    true = balanced({}).balance("g1", AT, points=POINTS)
    np.testing.assert_allclose(found.unbalances, true.unbalances, rtol=1e-5)
    np.testing.assert_allclose(
        found.remaining, orbits(balanced({"g1": true.unbalances[0]})), rtol=1e-4
    )
    np.testing.assert_allclose(found.influence, true.influence, rtol=1e-8)
    assert found.system.gears[0].unbalance == pytest.approx(
        bent_pair().gears[0].unbalance + true.unbalances[0], rel=1e-5
    )
    assert found.remaining_share == pytest.approx(true.residual_ratio, rel=0.05)
    # At one speed, a weight compensates the bow at one place.
    one = gb.identify(unbent(bent_pair()), exact, WANTED, noise=MICRON)
    assert one.balance("g1", 300.0, points=POINTS[:1]).remaining_share < 0.1 < found.remaining_share


def test_an_unknown_parameter_widens_the_intervals():
    exact = gb.Measurement(SPEEDS, vectors(bent_pair(), SPEEDS, PROBES), PROBES)
    system = unbent(bent_pair())
    stiff = gb.unknown.parameter("bearings[*].stiffness")
    widths = [
        gb.identify(system, exact, wanted, noise=MICRON).balance("g1", AT).half_widths[0, 0]
        for wanted in (WANTED, [*WANTED, stiff])
    ]
    assert widths[1] > 1.01 * widths[0]


def test_what_is_said_about_a_correction():
    found = identified(1).balance("g1", gb.rpm([3000, 9000]))
    assert "balance at 3000, 9000 rpm: from " in str(found)
    assert "no weights in these planes can remove" in str(found)
    assert list(found.to_dataframe().columns)[:2] == ["plane", "unbalance [kg m]"]


def test_wrong_planes_are_errors():
    with pytest.raises(gb.SceneError, match="points: no probe is beside output; give the points"):
        identified(1).balance("g2", AT)
    with pytest.raises(gb.SceneError, match=r'planes\[0\]: no gear or disk is called "g3"'):
        identified(1).balance("g3", AT)
    with pytest.raises(gb.SceneError, match="planes: must be different"):
        identified(1).balance(["g1", "g1"], AT)
