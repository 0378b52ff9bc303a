"""Identification of bow, unbalance, run-out and parameters: coverage, known systems, separation."""

from __future__ import annotations

import json
import os
import secrets
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from gearbow.identification.fit import fit, student
from gearbow.identification.responses import LinearModel
from reference.machines import double_stage, helical_pair, pair, rotor_with_two_disks

MICRON = 1e-6
SPEEDS = np.linspace(60.0, 1400.0, 12)
TIMES = os.environ.get("GEARBOW_CASES")
#: `make random` has more trials, with seeds of its own.
TRIALS = 200 * int(TIMES or "1")
SEED = secrets.randbits(32) if TIMES else 0


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
    numbers = np.random.default_rng([SEED, seed])
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


#: Systems, probes, the unknown shaft and plane, speeds [rad/s] and a bearing stiffness to find.
SCENES = {
    "pair": (bent_pair, PROBES, "g1", SPEEDS),
    "stepped speeds": (bent_pair, PROBES[:2], "g1", np.array([100.0, 400.0, 900.0, 1200.0])),
    "helical pair": (helical_pair, [*PROBES[:2], gb.Probe("input", 0.3)], "g1", SPEEDS),
    "rotor": (
        rotor_with_two_disks,
        [gb.Probe("s", 0.3), gb.Probe("s", 0.3, angle=1.6), gb.Probe("s", 0.7)],
        "a",
        np.linspace(40.0, 500.0, 15),
    ),
    "double stage": (
        lambda: double_stage(
            own={"input": {"bow": gb.Bow.half_sine(5e-5)}, "g1": {"unbalance": 3e-4j}}
        ),
        PROBES,
        "g1",
        SPEEDS,
    ),
}
UNKNOWN = {
    "without run-out": [],
    "with run-out": [gb.unknown.runout()],
    "with a bearing": ["bearings[0].stiffness"],
}


class Kept(dict):
    """Every answer of a model, by the values of its parameters: trials begin with the same ones."""

    def clear(self) -> None:
        """Forget nothing."""


@pytest.mark.parametrize(
    ("scene", "case"),
    [
        (scene, case)
        for scene in SCENES
        for case in UNKNOWN
        # a trial with a parameter takes a hundred analyses
        if TIMES or case != "with a bearing" or scene in ("helical pair", "rotor")
    ],
)
def test_intervals_contain_the_truth(scene, case):
    make, probes, plane, speeds = SCENES[scene]
    system = make()
    shaft = probes[0].shaft
    more = [
        # The rotor has bearings that differ along y and z.
        gb.unknown.parameter(f"{each}[0]" if scene == "rotor" else each)
        if isinstance(each, str)
        else each
        for each in UNKNOWN[case]
    ]
    wanted = [gb.unknown.bow(shaft), gb.unknown.unbalance(plane), *more]
    exact = vectors(system, speeds, probes)
    model = LinearModel.of(system, [gb.Measurement(speeds, exact, probes)], wanted)
    # Enough vibration that the answer is linear in the stiffness over its interval.
    noise = 0.02 * MICRON if model.parameters else MICRON
    truth = fit(model, noise)
    deviations = np.sqrt(np.diag(truth.covariance))
    count = TRIALS // 8 if model.parameters else TRIALS
    errors, kept = [], Kept()
    for seed in range(count):
        again = replace(model, measured=noisy(model.measured, seed, noise), last=kept)
        found = fit(again, noise)
        moved = np.log(found.parameters / truth.parameters)
        errors.append(np.concatenate([found.values - truth.values, moved]))
    ratios = np.array(errors) / deviations
    # Two components of an unknown are independent. The standard errors of scatter and coverage are
    # those of `independent` numbers.
    independent = 2 * count
    assert abs(np.sqrt(np.mean(ratios**2)) - 1.0) < 4.0 / np.sqrt(2.0 * independent)
    inside = np.mean(np.abs(ratios) < student(np.inf))
    assert abs(inside - 0.95) < 4.0 * np.sqrt(0.95 * 0.05 / independent)


def test_an_unknown_bearing_stiffness_is_found():
    true = bent_pair(bearing={"stiffness": 4e7, "damping": 500.0})
    exact = vectors(true, SPEEDS, PROBES)
    measured = gb.Measurement(SPEEDS, noisy(exact, 3), PROBES)
    soft = gb.unknown.parameter("bearings[*].stiffness", prior=(6e7, 0.5))
    found = gb.identify(unbent(bent_pair()), measured, [*WANTED, soft], runout=False, noise=MICRON)
    assert found.units[-1] == "N/m"
    # Parameters keep their sign, as of a cross-coupled stiffness; phasors have an amplitude.
    for sign in (1.0, -1.0):
        sizes = replace(found, values=sign * found.values).to_dataframe()["size"].to_numpy()
        assert sizes == pytest.approx([*np.abs(found.values[:-1]), sign * found.values[-1].real])
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
    fit(model, MICRON)
    assert len(calls) == 3  # what is known, and two for each of two shafts
    # Another trial of the same measurement solves nothing but the least-squares problem.
    fit(replace(model, measured=noisy(model.measured, 1)), MICRON)
    assert len(calls) == 3


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


@pytest.mark.parametrize(
    ("path", "text"),
    [
        ("bearings[0].stifness", r"unknowns\[0\]: bearings\[0\]: has no 'stifness'.*\"stiffness\""),
        ("bearings[9].stiffness", r"bearings: has no \[9\], only \[0\] to \[3\]"),
        ("disks[*].mass", r"disks: has no \[\*\], only none"),
        ("bearings[*].name", r"bearings\[0\]: has no 'name'"),
        ("gears[*].teeth", r"gears\[0\].teeth: is a whole number"),
        ("bearing[0].stiffness", "must begin with one of shafts"),
    ],
)
def test_the_path_of_an_unknown_parameter_is_checked(path: str, text: str):
    measured = gb.Measurement(SPEEDS, vectors(bent_pair(), SPEEDS, PROBES), PROBES)
    with pytest.raises(gb.SceneError, match=text):
        gb.identify(bent_pair(), measured, [*WANTED, gb.unknown.parameter(path)][2:])


@pytest.mark.parametrize("prior", [None, 1e-4])
def test_fewer_numbers_than_unknowns_say_what_is_missing(prior):
    # two amplitudes are four numbers; three half waves and a run-out are eight
    speeds, probes = np.array([300.0, 600.0]), PROBES[:1]
    measured = gb.Measurement(speeds, noisy(vectors(bent_pair(), speeds, probes), 1), probes)
    wanted = [gb.unknown.bow("input", 3, prior=prior)]
    with pytest.raises(gb.GearbowError, match="4 measured numbers do not give the noise"):
        gb.identify(unbent(bent_pair()), measured, wanted)
    found = gb.identify(unbent(bent_pair()), measured, wanted, noise=MICRON)
    assert found.inseparable
    assert np.isfinite(found.estimates).all()
    # only the priors limit the intervals
    assert np.isfinite(found.half_widths[:3]).all() == (prior is not None)
    # as many unknowns as numbers leave nothing that a test could judge
    assert "does not agree with the noise" not in str(found)


def test_a_wrong_model_is_not_called_noise():
    measured = gb.Measurement(SPEEDS, noisy(vectors(bent_pair(), SPEEDS, PROBES), 1), PROBES)
    system = unbent(bent_pair())
    soft = system.replace(
        bearings=[replace(each, stiffness=4e7) for each in system.bearings]  # of 1e8 N/m
    )
    with pytest.warns(gb.AccuracyWarning, match="^noise: the residual of .* alike at neighbouring"):
        found = gb.identify(soft, measured, WANTED)
    # the noise is 1 µm
    assert found.noise.min() > 5.0 * MICRON
    # with the noise given, the test of the residual says it
    assert (
        min(one.probability for one in gb.identify(soft, measured, WANTED, noise=MICRON).probes)
        < 1e-6
    )


def test_noise_is_not_called_a_wrong_model():
    exact, system = vectors(bent_pair(), SPEEDS, PROBES), unbent(bent_pair())
    # a probability of 0.1 % each; every warning is an error
    for seed in range(20):
        gb.identify(system, gb.Measurement(SPEEDS, noisy(exact, 100 + seed), PROBES), WANTED)
