"""Quantities derived from complex amplitudes, against orbits evaluated point by point."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gearbow as gb
from reference import scenes
from reference.bows import HalfSine
from reference.machines import BEARING, jeffcott, pair_on_housing, rotor_on_pedestal
from test_synchronous import BOWED

SPEEDS = np.array([60.0, 250.0])


def test_the_semi_axis_is_the_largest_distance_from_the_centre():
    found = BOWED.package().synchronous(SPEEDS)
    turn = np.exp(1j * np.linspace(0.0, 2 * np.pi, 20001))
    for speed in range(2):
        for source in range(2):
            v, w = (np.real(a * turn) for a in found.displacement("g2")[speed, source])
            largest = np.hypot(v, w).max()
            # the trace has a point within 1.6e-4 rad of the largest distance
            assert found.orbit("g2")[speed, source] == pytest.approx(largest, rel=1e-7)


def test_the_phase_is_the_angle_of_the_high_spot():
    scene = scenes.Geared(bows={"output": HalfSine(1e-4, 0.7)}, angles=(0.3, 1.0))
    system = scene.package()
    found = system.synchronous(SPEEDS)
    v, w = np.moveaxis(found.displacement("g4")[:, 2], -1, 0)
    # the part that rotates with the shaft: the mean of (v + iw) exp(-i angle) over one revolution
    turn = np.exp(1j * np.linspace(0.0, 2 * np.pi, 64, endpoint=False))
    traced = np.real(np.outer(v, turn)) + 1j * np.real(np.outer(w, turn))
    expected = np.angle(np.mean(traced * turn.conj(), axis=1))
    assert found.phase("g4")[:, 2] == pytest.approx(expected, abs=1e-9)
    assert np.all(np.isnan(found.phase("g4")[:, 0]))  # the input shaft is straight


def test_the_force_on_each_bearing_follows_from_its_motion():
    scene = replace(BOWED, bearing_stiffness=np.array([[1e8, 2e7], [1e7, 6e7]]))
    found = scene.package().synchronous(SPEEDS)
    for shaft in scene.shafts:
        for x in (0.0, 0.5):
            motion = found.displacement((shaft, x))
            for source, ratio in enumerate(scene.ratios[:2]):
                velocity = 1j * ratio * SPEEDS[:, np.newaxis] * motion[:, source]
                expected = motion[:, source] @ scene.bearing_stiffness.T + 2e4 * velocity
                force = found.bearing_force((shaft, x))[:, source]
                scale = np.abs(expected).max()
                # the same product with displacements of the same solution: round-off
                assert np.abs(force - expected).max() < 1e-7 * scale


@pytest.mark.parametrize("excitation", ["both", "bow", "unbalance"])
def test_the_bow_is_subtracted_on_its_own_shaft_only(excitation: str):
    found = BOWED.package().synchronous(SPEEDS, excitation=excitation)
    bow = 7e-5 * np.exp(1.1j) * np.sin(np.pi * 0.25 / 0.5)  # bow of the output shaft at g2
    expected = found.displacement("g2").copy()
    if excitation != "unbalance":
        # v + iw = b exp(i angle): v = Re(b exp(i angle)) and w = Re(-i b exp(i angle))
        expected[:, 1] -= [bow, -1j * bow]
    assert found.elastic("g2") == pytest.approx(expected, abs=1e-12)


def test_the_twist_agrees_with_an_independent_assembly():
    found = BOWED.package().synchronous(SPEEDS)
    train = BOWED.reference()
    dofs = [(shaft, round(x, 9), direction) for shaft, x, direction in found.coordinates.dofs]
    at = dofs.index(("output", 0.25, "twist"))
    lateral = dofs.index(("output", 0.25, "v"))
    assert at != lateral
    for row, speed in enumerate(SPEEDS):
        independent = train.synchronous(speed)
        for source in range(2):
            expected = independent[source][train.dof("output", 0.25, 4)]
            scale = np.abs(expected)
            assert abs(found.twist("g2")[row, source] - expected) < 1e-6 * scale


@pytest.mark.parametrize("excitation", ["both", "bow", "unbalance"])
def test_slow_roll_subtraction_uses_the_excitation(excitation: str):
    system = BOWED.package()
    found = system.synchronous(SPEEDS, excitation=excitation)
    slow = system.synchronous([8.0], excitation=excitation)
    less = found.subtract_slow_roll(8.0)
    expected = found.displacement("g1") - slow.displacement("g1")
    assert less.displacement("g1") == pytest.approx(expected, abs=1e-18)
    # the run-out contains the bow: it must be subtracted once only
    assert less.elastic("g1") == pytest.approx(expected, abs=1e-18)


@pytest.mark.parametrize("factor", [2.4, 2.6, 3.4, 4.0, 10.0])
@pytest.mark.parametrize("speed", [60.0, 140.0])
def test_the_required_margin_of_api_684(factor: float, speed: float):
    # below an amplification factor of 2.5 nothing is required; above the operating speeds 10 % more
    width = speed / factor
    peak = gb.results.Peak(speed, 1e-5, speed - 0.4 * width, speed + 0.6 * width, (90.0, 110.0))
    assert peak.amplification_factor == pytest.approx(factor)
    margin = 17 * (1 - 1 / (factor - 1.5)) + (10 if speed > 100 else 0)
    assert peak.required_margin == pytest.approx(0.0 if factor < 2.5 else margin)
    # percent of the operating speed that is nearest
    distance = 100 * 30 / (90 if speed < 100 else 110)
    assert peak.separation_margin == pytest.approx(distance)
    assert peak.acceptable == (factor < 2.5 or distance >= margin)


@pytest.mark.parametrize("operating", [700.0, (650.0, 700.0)])
def test_peaks_keep_the_operating_speeds(operating: float | tuple[float, float]):
    # speeds in any order, and twice
    system = jeffcott()
    critical = abs(system.modes(count=1).eigenvalues[0])
    speeds = critical * np.linspace(0.2, 3.0, 30)
    given = np.concatenate([speeds[::-1], speeds[:3]])
    (peak,) = system.synchronous(given).peaks("disk", operating=operating)
    assert peak.operating == (operating if isinstance(operating, tuple) else (700.0, 700.0))
    assert peak.speed == pytest.approx(critical, rel=1e-2)
    assert peak.lower < peak.speed < peak.upper


def test_the_force_on_a_bearing_follows_from_its_displacement_on_its_base():
    # a housing that turns about a point beside both shafts, and supports
    found = pair_on_housing().synchronous(SPEEDS)
    stiffness = np.broadcast_to(BEARING["stiffness"], 2)
    for shaft in ("input", "output"):
        for x in (0.0, 0.4):
            moved = found.bearing_displacement((shaft, x))
            assert np.abs(moved - found.displacement((shaft, x))).max() > 0.01 * np.abs(moved).max()
            rates = 1j * SPEEDS[:, None] * np.array([1.0, -0.5])
            expected = moved * (stiffness + BEARING["damping"] * rates[..., None])
            force = found.bearing_force((shaft, x))
            # round-off of displacements that are larger than their difference
            assert force == pytest.approx(expected, abs=1e-7 * np.abs(expected).max())
    at = ("rotor", 0.05)
    found = rotor_on_pedestal().frequency_response([300.0], source=gb.Force("left", 1.0))
    assert found.bearing_force(at) == pytest.approx(1e8 * found.bearing_displacement(at))
    with pytest.raises(gb.ChannelError, match=r"^at: no bearing at \('rotor', 0.3\)"):
        found.bearing_displacement(("rotor", 0.3))


def test_sensors_on_a_housing_measure_the_synchronous_motion():
    # a run of a linear train contains the motion of every shaft
    system = pair_on_housing()
    probe = gb.Probe("input", 0.4, angle=0.4, support="corner", runout=2e-6j)
    felt = gb.Accelerometer("corner", angle=1.1)
    found = system.synchronous(SPEEDS)
    rates = SPEEDS[:, None] * np.array([1.0, -0.5])
    direction = np.array([np.cos(0.4), np.sin(0.4)])
    moved = found.displacement(("input", 0.4)) - found.displacement("corner")
    runout = np.array([2e-6j * np.exp(-0.4j), 0.0])
    assert found.measure(probe) == pytest.approx(moved @ direction + runout)
    direction = np.array([np.cos(1.1), np.sin(1.1)])
    expected = -(rates**2) * (found.displacement("corner") @ direction)
    assert found.measure(felt) == pytest.approx(expected)
    assert found.velocity("g1") == pytest.approx(1j * rates[..., None] * found.displacement("g1"))
    # run-out is the same at slow roll
    slow = found.subtract_slow_roll(1.0)
    expected = found.measure(probe) - system.synchronous([1.0]).measure(probe)
    assert slow.measure(probe) == pytest.approx(expected, abs=1e-15)
    (line, *_) = slow.bode(probe).axes[1].get_lines()
    assert line.get_ydata() == pytest.approx(1e6 * np.abs(expected[:, 0]))
    with pytest.raises(gb.GearbowError, match=r"^sensor: the run-out of a probe must be a complex"):
        found.measure(gb.Probe("input", 0.4, runout=np.cos))
    with pytest.raises(gb.SceneError, match=r"^sensor: must be a gb.Probe or gb.Accelerometer"):
        found.measure(gb.Tacho("input"))


def test_amplitudes_are_zero_to_peak():
    # an unbalance of U in a disk of mass m far above the critical speed moves it by U/m
    system = jeffcott(damping=4e3, eccentricity=1e-5)
    critical = abs(system.modes(count=1).eigenvalues[0])
    found = system.synchronous([100.0 * critical])
    assert found.orbit("disk")[0, 0] == pytest.approx(1e-5, rel=1e-2)


def test_a_polar_plot_has_amplitude_and_phase():
    system = jeffcott(damping=4e3, eccentricity=1e-5)
    critical = abs(system.modes(count=1).eigenvalues[0])
    found = system.synchronous(critical * np.linspace(0.5, 2.0, 31))
    expected = 1e6 * found.orbit("disk")[:, 0] * np.exp(1j * found.phase("disk")[:, 0])
    for figure in (found.plot("polar"), found.plot("disk", "polar", source="s")):
        (panel,) = figure.axes
        assert panel.get_lines()[0].get_xydata() @ [1.0, 1j] == pytest.approx(expected)
        assert panel.get_xlabel() == "real part [µm]"
        speeds = [float(text.get_text().partition(" ")[0]) for text in panel.texts]
        largest = found.speeds[np.argmax(np.abs(expected))]
        assert speeds == pytest.approx([found.speeds[0], largest, found.speeds[-1]], rel=1e-3)
    with pytest.raises(gb.SceneError, match=r"^kind: must be one of orbit, bode, polar, got 'x'"):
        found.plot("disk", "x")


def test_a_peak_without_an_amplification_factor_says_why():
    system = jeffcott(damping=400.0, eccentricity=1e-5)
    critical = abs(system.modes(count=1).eigenvalues[0])
    cases = {(0.2, 1.5): None, (0.99, 1.2): "no N₁", (0.2, 1.01): "no N₂"}
    for ends, missing in cases.items():
        found = system.synchronous(critical * np.linspace(*ends, 400))
        (peak,) = peaks = found.peaks("disk")
        assert peak.missing == missing
        assert np.isnan(peak.amplification_factor) == (missing is not None)
        assert (f"peak 1: {missing}, because the amplitude stays above" in str(peaks)) == (
            missing is not None
        )
        texts = [text.get_text() for text in found.bode("disk").axes[1].texts]
        assert texts == ([missing] if missing else [f"AF {peak.amplification_factor:.3g}"])
