"""Measured vibration from arrays, files and signals."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import gearbow as gb
from reference.cases import each_case
from reference.machines import pair
from test_identify import MICRON, PROBES, SEED, SPEEDS, WANTED, bent_pair, noisy, unbent, vectors

HEAD = "speed [rpm]; shaft; position [mm]; angle [deg]; amplitude [um]; phase [deg]"


def write(path: Path, *lines: str) -> Path:
    """Write lines of a file."""
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def rows(measured: gb.Measurement, sign: float = 1.0) -> list[str]:
    """Write a measurement as lines."""
    return [
        f"{speed * 30 / np.pi:.12g}; {probe.shaft}; {1e3 * probe.position:g}; "
        f"{np.degrees(probe.angle):.12g}; {1e6 * abs(a):.12g}; {sign * np.degrees(np.angle(a)):.12g}"
        for speed, vector in zip(measured.speeds, measured.amplitudes, strict=True)
        for probe, a in zip(measured.probes, vector, strict=True)
    ]


@pytest.mark.parametrize(
    ("sign", "head"), [(1.0, HEAD), (-1.0, HEAD.replace("phase", "phase_lag"))]
)
def test_a_file_gives_what_was_written(sign, head, tmp_path):
    exact = gb.Measurement(SPEEDS, vectors(bent_pair(), SPEEDS, PROBES), PROBES)
    found = gb.Measurement.read_csv(write(tmp_path / "a.csv", head, *rows(exact, sign)))
    np.testing.assert_allclose(found.amplitudes, exact.amplitudes, rtol=1e-10)
    np.testing.assert_allclose(found.speeds, exact.speeds, rtol=1e-11)
    assert found.speed_unit == "rpm"
    assert found.labels == exact.labels


def test_named_probes_and_complex_amplitudes(tmp_path):
    lines = ["speed, probe, reference, real [um], imaginary [um]", "10, A, output, 3, 4"]
    lines.append("20, A, output, 5, 6")
    probe = gb.Probe("input", 0.1)
    found = gb.Measurement.read_csv(write(tmp_path / "a.csv", *lines), {"A": probe})
    assert found.references == ("output",)
    np.testing.assert_allclose(found.amplitudes[:, 0], [3e-6 + 4e-6j, 5e-6 + 6e-6j])
    assert found.labels == ("probe input at 0.1 m, 0°, 1× output",)


def test_missing_lines_are_a_warning_with_the_first_of_them(tmp_path):
    exact = gb.Measurement(SPEEDS, vectors(bent_pair(), SPEEDS, PROBES), PROBES)
    lines = rows(exact)
    del lines[4]
    path = write(tmp_path / "a.csv", HEAD, *lines)
    with pytest.warns(gb.AccuracyWarning, match="1 of 36 amplitudes are missing, .*input at 0.15"):
        found = gb.Measurement.read_csv(path)
    identified = gb.identify(unbent(bent_pair()), found, WANTED, noise=MICRON)
    np.testing.assert_allclose(identified.values[0], 60e-6 * np.exp(0.7j), rtol=1e-5)


WRONG = {
    "no speed": ("shaft, position, amplitude, phase", ["a, 0, 1, 0"], 'needs the column "speed"'),
    "no phase": (
        "speed, shaft, position, amplitude",
        ["1, a, 0, 1"],
        'one of "phase" and "phase_lag"',
    ),
    "degrees": (
        "speed, shaft, position, amplitude, phase",
        ["1, a, 0, 1e-6, 270"],
        r"no unit, .* reaches 270; write \"phase \[deg\]\"",
    ),
    "twice": (
        "speed, shaft, position, amplitude, phase",
        ["1, a, 0, 1e-6, 0", "2, a, 0, 1e-6, 0", "1, a, 0, 2e-6, 0"],
        "line 2 and line 4: probe a at 0 m, 0° occurs twice at 1 rad/s",
    ),
    "negative": (
        "speed, shaft, position, amplitude, phase",
        ["1, a, 0, -1e-6, 0"],
        "must not be negative, got -1e-06 m",
    ),
    "place": (
        "speed, probe, amplitude, phase",
        ["1, A, 1e-6, 0"],
        "the place of probe 'A' is unknown",
    ),
    "no place": (
        "speed, amplitude, phase",
        ["1, 1e-6, 0"],
        'needs the columns "shaft" and "position"',
    ),
    "text": (
        "speed, shaft, position, amplitude, phase",
        ["1, a, 0, x, 0"],
        'column "amplitude": must be a number',
    ),
}


@each_case("name", list(WRONG))
def test_wrong_files_are_errors(name, tmp_path):
    head, lines, message = WRONG[name]
    with pytest.raises(gb.SceneError, match=message):
        gb.Measurement.read_csv(write(tmp_path / "a.csv", head, *lines))


ONE = {"speeds": [1.0, 2.0], "amplitudes": np.ones((2, 1)), "probes": [gb.Probe("input", 0.1)]}
ARGUMENTS = [
    ({"speeds": [0.0, 1.0]}, r"speeds\[0\]: must not be zero"),
    (
        {"amplitudes": np.ones((3, 1))},
        r"amplitudes: must have the shape .* = \(2, 1\), got \(3, 1\)",
    ),
    ({"amplitudes": [[np.inf], [1.0]]}, "amplitudes: must be finite"),
    ({"probes": [gb.Probe("input", 0.1, axial=True)]}, r"probes\[0\]: must be a lateral gb.Probe"),
    ({"references": ["a", "b"]}, "references: must be one shaft for each of 1 probes, got 2"),
]


@each_case(("change", "message"), ARGUMENTS)
def test_wrong_arrays_are_errors(change, message):
    with pytest.raises(gb.SceneError, match=message):
        gb.Measurement(**{**ONE, **change})


def test_opposite_phases_are_a_warning_with_the_evidence():
    exact = noisy(vectors(bent_pair(), SPEEDS, PROBES), 1).conj()
    measured = gb.Measurement(SPEEDS, exact, PROBES)
    with pytest.warns(
        gb.AccuracyWarning, match="phases of the opposite sign, .* % of the residual"
    ):
        gb.identify(unbent(bent_pair()), measured, WANTED)


def test_slow_roll_amplitudes_change_only_the_run_out():
    exact = vectors(bent_pair(), SPEEDS, PROBES)
    measured = gb.Measurement(SPEEDS, exact, PROBES).subtract_slow_roll(60.0)
    assert measured.slow_roll == 60.0
    assert measured.speeds.size == SPEEDS.size - 1
    found = gb.identify(unbent(bent_pair()), measured, WANTED, noise=MICRON)
    np.testing.assert_allclose(found.values[0], 60e-6 * np.exp(0.7j), rtol=1e-5)
    np.testing.assert_allclose(found.values[2:], -exact[0] * [1.0, 1j, 1.0], atol=1e-9)
    with pytest.raises(gb.SceneError, match="slow-roll amplitudes were subtracted"):
        gb.identify(unbent(bent_pair()), measured, WANTED, runout=False)


def test_trial_weights_are_further_measurements():
    bent = bent_pair()
    tried = bent.replace(
        gears=[replace(bent.gears[0], unbalance=bent.gears[0].unbalance + 3e-4), bent.gears[1]]
    )
    measured = [
        gb.Measurement(SPEEDS, vectors(bent, SPEEDS, PROBES), PROBES),
        gb.Measurement(SPEEDS, vectors(tried, SPEEDS, PROBES), PROBES, trial_weights={"g1": 3e-4}),
    ]
    found = gb.identify(unbent(bent), measured, WANTED, noise=MICRON)
    np.testing.assert_allclose(found.values[1], 4e-4 * np.exp(1.5j), rtol=1e-5)
    assert len(found.probes) == 3


def test_pulses_at_another_angle_turn_the_phase():
    speeds, angle = np.array([40.0, 80.0]), 0.6
    system = bent_pair()
    # The reference shaft turns forwards: the phase at its angle β leads by β.
    exact = vectors(system, speeds, PROBES)
    measured = gb.Measurement(speeds, exact * np.exp(1j * angle), PROBES, phase_angle=angle)
    plain = gb.Measurement(speeds, exact, PROBES)
    found = [
        gb.identify(unbent(system), each, [gb.unknown.bow("input")], runout=False, noise=MICRON)
        for each in (measured, plain)
    ]
    np.testing.assert_allclose(found[0].values, found[1].values, rtol=1e-9)


def test_a_simulated_run_gives_the_same_bow():
    """Live geometry, errors of the teeth and backlash, sampled at 25.6 kHz with a tachometer."""
    error = gb.TransmissionError(tooth=[(2e-6, 0.0), (1e-6, 1.2)])
    system = bent_pair(
        mesh={"stiffness": 2e8, "damping_ratio": 0.05, "backlash": 4e-5, "error": error}
    )
    probes = PROBES[:2]
    nodes = [gb.Disk("node", "input", 0.15, 0.0, 0.0, 0.0)]
    run = system.replace(disks=nodes)
    measured = []
    for speed in (150.0, 400.0, 700.0, 1000.0):
        times = 0.1 + np.arange(7680) / 25600.0
        response = run.simulate(0.4, speed, times=times, record=[("input", 0.15)])
        signals = {probe: response.measure(probe) for probe in probes}
        tacho = gb.Tacho("input", angle=0.8)
        pulses = {tacho: response.measure(tacho)}
        measured.append(gb.Measurement.from_signals(response.time, signals, pulses, revolutions=4))
    # The linear response lacks what a loaded mesh adds as its line of action turns: at 250 N m this
    # changes the amplitudes by up to 0.9 µm. The noise stands for it.
    found = gb.identify(unbent(system), measured, WANTED, runout=False, noise=MICRON)
    bow = 60e-6 * np.exp(0.7j)
    for value, (lower, upper) in zip((bow.real, bow.imag), found.intervals[:2], strict=True):
        assert lower < value < upper
    assert found.half_widths[0, 0] < 2e-6


def test_the_bow_agrees_with_a_dial_gauge_series(tmp_path):
    """Two half waves from vibration, and readings of a dial gauge on the shaft at rest."""
    length = bent_pair().shafts[0].length
    sizes = (60e-6 * np.exp(0.7j), 15e-6 * np.exp(-0.4j))

    def shape(x: float) -> complex:
        return sum(a * np.sin((i + 1) * np.pi * x / length) for i, a in enumerate(sizes))

    system = pair(own={"input": {"bow": gb.Bow.function(shape)}})
    measured = gb.Measurement(SPEEDS, noisy(vectors(system, SPEEDS, PROBES), 5), PROBES)
    wanted = [gb.unknown.bow("input", shapes=2)]
    found = gb.identify(unbent(system), measured, wanted, runout=False, noise=MICRON)

    # The gauge reads its distance from the straight axis, with 1 µm of noise, at eight angles.
    positions = np.linspace(0.0, length, 9)
    bow = np.array([shape(x) for x in positions])
    angles = np.arange(8) * np.pi / 4
    numbers = np.random.default_rng([SEED, 6])
    readings = np.real(bow[:, None] * np.exp(-1j * angles))
    readings = readings + MICRON * numbers.standard_normal(readings.shape)
    once = 2.0 * (readings * np.exp(1j * angles)).mean(axis=1)
    lines = [
        f"{1e3 * x}; {2e6 * abs(o)}; {np.degrees(np.angle(o))}"
        for x, o in zip(positions, once, strict=True)
    ]
    head = "position [mm]; total_run_out [um]; phase [deg]"
    gauge = gb.Bow.read_table(write(tmp_path / "gauge.csv", head, *lines))

    place = ("input", length / 2.0)

    def at(bow: gb.Bow) -> complex:
        bare = unbent(system)
        shafts = [replace(bare.shafts[0], bow=bow), bare.shafts[1]]
        disks = [gb.Disk("middle", *place, 0.0, 0.0, 0.0)]
        moved = bare.replace(shafts=shafts, disks=disks).synchronous(1e-3).displacement(place)
        return complex(moved[0, 0, 0])

    difference = at(found.system.shafts[0].bow) - at(gauge)
    # Half of the readings are one component of the gauge: its deviation is 1 µm √(2/8) = 0.5 µm.
    assert abs(difference) < found.half_widths[0, 0] + found.half_widths[1, 0] + 4 * 0.5 * MICRON
