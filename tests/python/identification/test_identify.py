"""Identification of bow, unbalance, run-out and parameters: coverage, known systems, separation."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from gearbow.identification.fit import fit, student
from gearbow.identification.responses import LinearModel
from reference.machines import pair

MICRON = 1e-6
SPEEDS = np.linspace(60.0, 1400.0, 12)
#: `make random` multiplies the number of trials.
TRIALS = 40 * int(os.environ.get("GEARBOW_CASES", "1"))


def bent_pair(**more: Any) -> gb.RotorSystem:
    """Build a pair with a bowed input shaft and an unbalanced pinion."""
    own = {
        "input": {"bow": gb.Bow.half_sine(60 * MICRON, phase=0.7)},
        "g1": {"unbalance": 4e-4 * np.exp(1.5j)},
    }
    return pair(own=own, **more)


def unbent(system: gb.RotorSystem) -> gb.RotorSystem:
    """Remove bows and unbalances."""
    return system.replace(
        shafts=[replace(shaft, bow=None) for shaft in system.shafts],
        gears=[replace(gear, unbalance=0.0) for gear in system.gears],
    )


def vectors(
    system: gb.RotorSystem, speeds: np.ndarray, probes: list[gb.Probe], source: int = 0
) -> np.ndarray:
    """Compute measured amplitudes at positive speeds from the response of a shaft, with run-out.

    A shaft that turns backwards has the conjugate amplitudes over a phase that grows in time.
    """
    nodes = [
        gb.Disk(f"node {i}", probe.shaft, probe.position, 0.0, 0.0, 0.0)
        for i, probe in enumerate(probes)
    ]
    response = system.replace(disks=[*system.disks, *nodes]).synchronous(speeds)
    columns = []
    for probe in probes:
        towards = np.array([np.cos(probe.angle), np.sin(probe.angle)])
        own = response.displacement((probe.shaft, probe.position))[:, source] @ towards
        own = own + complex(probe.runout or 0.0) * np.exp(-1j * probe.angle)
        columns.append(own if system.speed_ratios[source] > 0.0 else own.conj())
    return np.stack(columns, axis=1)


def noisy(exact: np.ndarray, seed: int, noise: float = MICRON) -> np.ndarray:
    """Add normal noise to both components."""
    numbers = np.random.default_rng(seed)
    return exact + noise * (
        numbers.standard_normal(exact.shape) + 1j * numbers.standard_normal(exact.shape)
    )


PROBES = [gb.Probe("input", 0.15), gb.Probe("input", 0.15, angle=np.pi / 2), gb.Probe("input", 0.4)]
RUNOUTS = [replace(probe, runout=r) for probe, r in zip(PROBES, (5e-6, 3e-6j, -4e-6), strict=True)]
WANTED = [gb.unknown.bow("input"), gb.unknown.unbalance("g1")]


def test_known_values_are_found_with_run_out():
    exact = vectors(bent_pair(), SPEEDS, RUNOUTS)
    measured = gb.Measurement(SPEEDS, exact, PROBES)
    found = gb.identify(unbent(bent_pair()), measured, WANTED, noise=MICRON)
    assert found.names[:2] == ("bow of input, half wave 1", "unbalance of g1")
    # The unit responses are small differences of nothing: round-off remains.
    np.testing.assert_allclose(found.values[0], 60e-6 * np.exp(0.7j), rtol=1e-6)
    np.testing.assert_allclose(found.values[1], 4e-4 * np.exp(1.5j), rtol=1e-6)
    np.testing.assert_allclose(found.values[2:], [5e-6, 3e-6j, -4e-6], atol=1e-11)
    again = found.system.synchronous(SPEEDS).amplitudes
    np.testing.assert_allclose(
        again, bent_pair().synchronous(SPEEDS).amplitudes, rtol=1e-5, atol=1e-11
    )


CASES = {
    "without run-out": (WANTED, False),
    "with run-out": (WANTED, True),
    "two half waves": ([gb.unknown.bow("input", 2), gb.unknown.unbalance("g1")], True),
    "points": ([gb.unknown.bow("input", points=[0.2, 0.35]), gb.unknown.unbalance("g1")], False),
}


@pytest.mark.parametrize("case", CASES)
def test_intervals_contain_the_truth(case):
    wanted, runout = CASES[case]
    wanted = [*wanted, gb.unknown.runout()] if runout else wanted
    exact = vectors(bent_pair(), SPEEDS, RUNOUTS if runout else PROBES)
    model = LinearModel.of(unbent(bent_pair()), [gb.Measurement(SPEEDS, exact, PROBES)], wanted)
    truth = fit(model, MICRON)
    deviations = np.sqrt(np.diag(truth.covariance))
    errors = np.array(
        [
            fit(replace(model, measured=noisy(model.measured, seed)), MICRON).values - truth.values
            for seed in range(TRIALS)
        ]
    )
    ratios = errors / deviations
    # Components of one unknown are independent: 40 trials of 2 or more unknowns give at least 160
    # numbers, whose scatter has a standard error of 6 %, and whose coverage one of 1.7 %.
    assert abs(np.sqrt(np.mean(ratios**2)) - 1.0) < 0.15
    assert abs(np.mean(np.abs(ratios) < student(np.inf)) - 0.95) < 0.05


def test_an_unknown_bearing_stiffness_is_found():
    true = bent_pair(bearing={"stiffness": 4e7, "damping": 500.0})
    exact = vectors(true, SPEEDS, PROBES)
    measured = gb.Measurement(SPEEDS, noisy(exact, 3), PROBES)
    soft = gb.unknown.parameter("bearings[*].stiffness", prior=(6e7, 0.5))
    found = gb.identify(unbent(bent_pair()), measured, [*WANTED, soft], runout=False, noise=MICRON)
    assert found.units[-1] == "N/m"
    lower, upper = found.intervals[-1]
    assert lower < 4e7 < upper
    assert upper - lower < 1e7
    assert all(one.probability > 0.01 for one in found.probes)
    assert found.system.bearings[0].stiffness == pytest.approx(found.values[-1].real)
    json.dumps(found.to_dict())


def test_one_analysis_serves_one_unknown_of_every_shaft(monkeypatch):
    calls = []
    original = gb.RotorSystem.synchronous

    def counted(self, *args, **options):
        calls.append(args)
        return original(self, *args, **options)

    exact = vectors(bent_pair(), SPEEDS, PROBES)
    monkeypatch.setattr(gb.RotorSystem, "synchronous", counted)
    wanted = [*WANTED, gb.unknown.bow("output"), gb.unknown.unbalance("g2")]
    model = LinearModel.of(unbent(bent_pair()), [gb.Measurement(SPEEDS, exact, PROBES)], wanted)
    model.rows_of(model.base)
    assert len(calls) == 3  # what is known, and two for each of two shafts


def test_a_shaft_that_turns_backwards_has_its_own_order_and_phase():
    own = {"output": {"bow": gb.Bow.half_sine(40 * MICRON, phase=-0.4)}}
    system = pair(own=own)
    assert system.speed_ratios[1] < 0.0
    probes = [gb.Probe("output", 0.15, angle=0.3), gb.Probe("output", 0.4, runout=2e-6j)]
    exact = vectors(system, SPEEDS, probes, source=1)
    measured = gb.Measurement(SPEEDS, exact, [replace(probe, runout=None) for probe in probes])
    found = gb.identify(unbent(system), measured, [gb.unknown.bow("output")], noise=MICRON)
    np.testing.assert_allclose(found.values[0], 40e-6 * np.exp(-0.4j), rtol=1e-6)
    np.testing.assert_allclose(found.values[2], 2e-6j, atol=1e-11)
