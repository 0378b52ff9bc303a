"""Damping ratios of single modes and over the frequency."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import gearbow as gb


def rotor(ratio: object, **changed) -> gb.RotorSystem:
    shaft = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=8, **changed)
    return gb.RotorSystem(
        [shaft],
        bearings=[gb.Bearing("rotor", x, stiffness=(1e8, 5e7)) for x in (0.0, 1.0)],
        modal_damping=ratio,
    )


def machine(ratio: object) -> gb.RotorSystem:
    return gb.examples()["helical_gear"].load().replace(modal_damping=ratio)


def test_modes_at_rest_have_the_ratios_of_their_numbers():
    found = rotor({1: 0.02, 3: 0.05, "other": 0.03}).modes(count=6).damping_ratios
    # At rest the damped modes are the undamped ones.
    np.testing.assert_allclose(found, [0.02, 0.03, 0.05, 0.03, 0.03, 0.03], rtol=1e-9)


def test_other_modes_have_no_damping_by_default():
    found = rotor({2: 0.01}).modes(count=3).damping_ratios
    np.testing.assert_allclose(found, [0.0, 0.01, 0.0], atol=1e-12)


def test_rigid_body_modes_have_no_number():
    system = gb.RotorSystem(
        [gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=8)],
        torques=[gb.Torque(("rotor", 0.0), 1.0), gb.Torque.balance(("rotor", 1.0))],
        modal_damping={1: 0.02},
    )
    np.testing.assert_allclose(system.modes(count=3).damping_ratios, [0.0, 0.02, 0.0], atol=1e-12)


def test_a_function_gives_the_damping_of_rayleigh():
    # ζ = α/2ω + βω/2 is Rayleigh damping of the whole system, here of two shafts on rigid bearings.
    alpha, beta = 8.0, 8e-6
    system = rotor(lambda w: alpha / (2.0 * w) + beta * w / 2.0)
    modes = system.modes(count=8)
    omega = 2.0 * np.pi * rotor(None).modes(count=8).frequencies_hz
    # The table has cubics between 50 points for a decade.
    np.testing.assert_allclose(
        modes.damping_ratios, alpha / (2.0 * omega) + beta * omega / 2.0, rtol=1e-5
    )


def test_a_table_is_constant_outside():
    omega = 2.0 * np.pi * rotor(None).modes(count=6).frequencies_hz
    table = {"frequencies": [1.5 * omega[0], 0.7 * omega[5]], "ratios": [0.01, 0.04]}
    found = rotor(table).modes(count=6).damping_ratios
    np.testing.assert_allclose(found[[0, 5]], [0.01, 0.04], rtol=1e-9)


def test_equal_ratios_are_one_ratio():
    exact = machine(0.01).modes(100.0)
    for ratio in ({"other": 0.01}, {"frequencies": [1.0, 1e5], "ratios": [0.01, 0.01]}):
        found = machine(ratio).modes(100.0)
        np.testing.assert_array_equal(found.eigenvalues, exact.eigenvalues)
        np.testing.assert_array_equal(found.shapes, exact.shapes)


def test_responses_have_the_ratio_of_their_mode():
    ratio = {1: 0.1, 2: 0.03, "other": 0.01}
    bow = gb.Bow.half_sine(1e-4)
    system = rotor(ratio, bow=bow)
    speed = 0.97 * 2.0 * np.pi * system.modes().frequencies_hz[0]
    amplitude = np.abs(system.synchronous([speed]).displacement(("rotor", 0.5))[0])
    plain = np.abs(rotor(0.01, bow=bow).synchronous([speed]).displacement(("rotor", 0.5))[0])
    assert np.abs(amplitude - plain).max() > 0.1 * plain.max()


@pytest.mark.parametrize("count", [None, 30])
def test_runs_decay_with_the_ratio_of_the_mode(count: int | None):
    # The bearings are softer along z.
    system = rotor({1: 0.02, "other": 0.2}).replace(
        forces=[gb.Force(("rotor", 0.5), lambda t: 100j * np.exp(-t / 1e-3))]
    )
    response = system.simulate(
        0.2, speed=0.0, output_step=1e-4, modes=count, record=[("rotor", 0.5)]
    )
    mode = rotor(None).modes(count=2)
    motion = response.displacement(("rotor", 0.5))[:, 1]
    period = 1.0 / mode.frequencies_hz[0]
    late = [
        np.abs(motion[(response.time > t) & (response.time < t + period)]).max()
        for t in (0.1, 0.15)
    ]
    rate = np.log(late[0] / late[1]) / 0.05
    assert rate == pytest.approx(0.02 * 2.0 * np.pi * mode.frequencies_hz[0], rel=0.05)


def test_files_and_descriptions_keep_the_ratios(tmp_path: Path):
    table = {"frequencies": (10.0, 1e4), "ratios": (0.01, 0.02)}
    for ratio in ({1: 0.02, 12: 0.01, "other": 0.03}, table):
        system = rotor(ratio)
        system.save(tmp_path / "rotor.toml")
        for same in (
            gb.RotorSystem.load(tmp_path / "rotor.toml"),
            gb.RotorSystem.from_dict(system.description),
            system.replace(gravity=None),
        ):
            assert same.modal_damping == ratio
            assert same.description == system.description


def test_wrong_ratios_say_what_is_wrong():
    cases = [
        ({0: 0.1}, r"modal_damping: the number of a mode: must be at least 1, got 0"),
        ({1.5: 0.1}, r"must be a whole number, got 1.5"),
        ({"first": 0.1}, r'modal_damping: a key must be the number .* or "other", got "first"'),
        ({1: -0.1}, r"modal_damping.1: must not be negative"),
        ({"other": -0.1}, r"modal_damping.other: must not be negative"),
        ({5000: 0.1}, r"modal_damping: mode 5000 does not exist: the model has \d+ modes"),
        ({"frequencies": [1.0]}, "needs the keys frequencies and ratios"),
        ({"frequencies": [2.0, 1.0], "ratios": [0.1, 0.1]}, r"frequencies\[1\]: must be above"),
        ({"frequencies": [1.0, 2.0], "ratios": [0.1, -0.1]}, r"ratios\[1\]: must not be negative"),
        (lambda w: np.nan * w, r"the function gives nan at 10 rad/s"),
        (lambda _: "much", "the function must give a number"),
        ("much", "modal_damping: must be a number"),
    ]
    for ratio, message in cases:
        with pytest.raises(gb.SceneError, match=message):
            rotor(ratio)


@pytest.mark.parametrize(
    "ratio",
    [
        0.05,
        {1: 0.02, 3: 0.1, "other": 0.03},
        {25: 0.1, "other": 0.01},
        {"frequencies": [10.0, 100.0, 1e5], "ratios": [0.01, 0.05, 0.1]},
    ],
)
def test_bearings_over_the_speed_have_the_damping_of_the_modes_of_each_speed(ratio: object):
    # All modes of this machine have damping, which changes in the space of a few displacements.
    given = gb.examples()["overhung_rotor"].load()
    (shaft,) = given.shafts
    segments = [replace(segment, elements=5) for segment in shaft.segments]
    shaft = replace(shaft, segments=segments, degree=2)
    system = given.replace(shafts=[shaft], modal_damping=ratio)
    speeds = np.array([30.0, 90.0, 200.0])
    found = system.synchronous(speeds)
    free = system.replace(modal_damping=None)
    bare_responses = free.synchronous(speeds).amplitudes
    for speed, x, bare in zip(speeds, found.amplitudes, bare_responses, strict=True):
        matrices = system.matrices(speed)
        modal = matrices.damping - free.matrices(speed).damping
        dynamic = matrices.stiffness - speed**2 * matrices.mass
        dynamic = dynamic + 1j * speed * (matrices.damping + speed * matrices.gyroscopic)
        wanted = bare[0] - np.linalg.solve(dynamic, 1j * speed * (modal @ bare[0]))
        # The space of the change leaves 2e-10 with a table over the frequency, which has kinks.
        assert np.abs(x[0] - wanted).max() <= 1e-9 * np.abs(wanted).max()
