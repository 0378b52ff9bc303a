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


def test_a_balanced_run_has_the_predicted_residual():
    """The machine is run in time with the weights, and measured with probes and a tachometer."""
    probes = [gb.Probe("input", 0.4), gb.Probe("input", 0.4, angle=np.pi / 2)]
    found = identified(1).balance("g1", AT, points=POINTS[1:])
    machine = balanced({"g1": found.unbalances[0]})
    for i, speed in enumerate(AT):
        run = machine.simulate(0.3, speed, output_step=1e-4, record=[POINTS[1]], rtol=1e-6)
        signals = {probe: run.measure(probe) for probe in probes}
        pulses = {gb.Tacho("input"): run.measure(gb.Tacho("input"))}
        again = gb.Measurement.from_signals(run.time, signals, pulses, revolutions=8)
        y, z = again.amplitudes[-1]
        orbit = (abs(y + 1j * z) + abs(y - 1j * z)) / 2.0
        # Four standard deviations; the load turns the line of action, by up to 0.9 µm of the motion.
        middle, width = (found.lower + found.upper)[i, 0] / 2, (found.upper - found.lower)[i, 0]
        assert abs(orbit - middle) < width + MICRON
        assert orbit < 0.9 * found.before[i, 0]


def test_trial_runs_give_the_influence_of_the_model_beside_their_own():
    bent, weight = bent_pair(), 3e-4 * np.exp(0.3j)
    tried = balanced({"g1": weight})
    exact = vectors(bent, SPEEDS, PROBES)
    measured = [
        gb.Measurement(SPEEDS, noisy(exact, 1), PROBES),
        gb.Measurement(
            1.005 * SPEEDS[:3],
            noisy(vectors(tried, 1.005 * SPEEDS[:3], PROBES), 2),
            PROBES,
            trial_weights={"g1": weight},
        ),
    ]
    found = gb.identify(unbent(bent), measured, WANTED, runout=False, noise=MICRON)
    trials = found.balance("g1", AT).trials
    assert trials.planes == ("g1",) * 9
    np.testing.assert_allclose(trials.speeds, np.repeat(1.005 * SPEEDS[:3], 3))
    np.testing.assert_allclose(trials.half_widths, found.factor * np.sqrt(2) * MICRON / 3e-4)
    # 18 components: four half widths of 95 % are eight standard deviations.
    assert (np.abs(trials.measured - trials.model) < 4.0 * trials.half_widths).all()
    unit = unbent(bent)
    alone = unit.replace(gears=[replace(unit.gears[0], unbalance=1e-3 + 0j), unit.gears[1]])
    # Between two speeds the bow does not cancel completely: 0.5 % of the speed.
    wanted = 1e3 * vectors(alone, 1.005 * SPEEDS[:3], PROBES).ravel()
    assert (
        np.abs(trials.model - wanted).max() < 0.1 * trials.half_widths[0] + 0.05 * abs(wanted).max()
    )
    assert "influence coefficients of trial runs differ" in str(found.balance("g1", AT))
    assert "trial run [µm/(g mm)]" in str(trials)
    phase, amplitude = trials.plot(speed_unit="rpm").axes
    assert phase.get_ylabel() == "phase [°]"
    assert amplitude.get_ylabel() == "influence [µm/(g mm)]"
    (points, *_) = amplitude.containers[0].lines[:1]
    own = [i for i, probe in enumerate(trials.probes) if probe == trials.probes[0]]
    np.testing.assert_allclose(points.get_xdata(), trials.speeds[own] * 30.0 / np.pi)
    np.testing.assert_allclose(points.get_ydata(), np.abs(trials.measured[own]))
    assert identified(1).balance("g1", AT).trials is None


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
