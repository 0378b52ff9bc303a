"""Synchronous response: its parts, simulated steady state, and peaks as API RP 684 defines them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gearbow as gb
from reference import scenes
from reference.bows import HalfSine
from reference.cases import each_case
from reference.machines import jeffcott
from reference.scenes import PAIR, GearAt

BOWED = replace(
    PAIR,
    bows={"input": HalfSine(1e-4, 0.3), "output": HalfSine(7e-5, 1.1)},
    gears=(
        GearAt("g1", "input", 0.25, 25, unbalance=2e-4 + 1e-4j),
        GearAt("g2", "output", 0.25, 50, unbalance=-5e-4j),
    ),
    torque=0.0,
    bearing_stiffness=np.diag([1e8, 6e7]),
    bearing_damping=2e4,
)


def test_bow_and_unbalance_superpose():
    system = BOWED.package()
    both, bow, unbalance = (
        system.synchronous([50.0, 300.0], excitation=part) for part in ("both", "bow", "unbalance")
    )
    scale = np.abs(both.amplitudes).max()
    # round-off of two sums of solutions of one linear system, 1e-16 times its condition number
    assert bow.amplitudes + unbalance.amplitudes == pytest.approx(both.amplitudes, abs=1e-9 * scale)
    assert np.abs(bow.displacement("g1")).max() > 0.0
    assert np.abs(unbalance.displacement("g1")).max() > 0.0
    with pytest.raises(gb.SceneError, match="excitation: must be"):
        system.synchronous(1.0, excitation="gravity")


@pytest.mark.parametrize("speed", [90.0, -140.0])
@pytest.mark.parametrize("method", ["exponential", "rk45"])
def test_a_run_from_the_synchronous_motion_has_no_transient_of_run_out(speed: float, method: str):
    # without torque, a bilateral mesh with the line of action at rest is linear
    system = BOWED.package()
    first, second = system.gears
    error = gb.TransmissionError(driver=[(5e-6, 0.8)], driven=[(3e-6, -1.0)])
    system = system.replace(
        gears=[replace(first, runout=3e-5 + 1e-5j), replace(second, runout=-2e-5j)],
        meshes=[replace(system.meshes[0], error=error)],
    )
    found, times = system.synchronous(speed), np.linspace(0.0, 0.02, 40)
    response = system.simulate(
        0.02, speed, method=method, geometry="frozen", rtol=1e-8, times=times, record=["gears"]
    )
    turns = np.exp(1j * np.outer(times, system.speed_ratios * speed))
    for gear in ("g1", "g2"):
        expected = np.real(np.einsum("ts,sd->td", turns, found.displacement(gear)[0]))
        # in a run, run-out moves the teeth to second order too: e_r²/r_b is 2e-8 m
        assert response.displacement(gear) == pytest.approx(expected, abs=2e-8)


@pytest.mark.parametrize("speed", [90.0, -140.0])
def test_a_simulation_converges_to_the_synchronous_response(speed: float):
    # with the line of action of the centres at rest a bilateral mesh is linear
    system = BOWED.package()
    found = system.synchronous(speed)
    times = 8.0 + np.linspace(0.0, 0.05, 40)
    # the run starts at rest; its transient has decayed by then, and 1e-6 is far above round-off
    response = system.simulate(
        8.05,
        speed,
        initial="rest",
        geometry="frozen",
        rtol=1e-9,
        times=times,
        record=["gears", "bearings"],
    )
    turns = np.exp(1j * np.outer(times, system.speed_ratios * speed))
    for gear in ("g1", "g2"):
        expected = np.real(np.einsum("ts,sd->td", turns, found.displacement(gear)[0]))
        scale = np.abs(found.displacement(gear)).max()
        assert response.displacement(gear) == pytest.approx(expected, abs=1e-6 * scale)
    for shaft, position in (("input", 0.0), ("output", 0.5)):
        amplitude = found.bearing_force((shaft, position))[0]
        expected = np.real(np.einsum("ts,sd->td", turns, amplitude))
        assert response.bearing_force((shaft, position)) == pytest.approx(
            expected, abs=1e-6 * np.abs(amplitude).max()
        )


def test_phase_decreases_by_180_degrees_through_a_critical_speed():
    system = jeffcott()
    critical = abs(system.modes(count=1).eigenvalues[0])
    phase = system.synchronous(critical * np.array([1e-3, 1.0, 1e3])).phase("disk")[:, 0]
    # the phase of the high spot is 0, then −90° and −180°; its tangent is 2ζ times the ratio
    assert phase == pytest.approx([0.0, -np.pi / 2, -np.pi], abs=1e-3)


def test_the_elastic_deflection_is_the_displacement_minus_the_bow():
    bow = 1e-4 * np.exp(0.4j)
    system = jeffcott(bow=bow, eccentricity=0.0)
    found = system.synchronous([1e-3, 150.0])
    slow, fast = found.elastic("disk")[:, 0, 0]
    assert abs(slow) < 1e-6 * abs(bow)  # a slow shaft shows its bow only; cΩ/k is 1e-7
    assert fast == pytest.approx(found.displacement("disk")[1, 0, 0] - bow, rel=1e-12)


def test_peaks_agree_with_the_closed_form():
    system = jeffcott()
    critical = abs(system.modes(count=1).eigenvalues[0])
    damping_ratio = 400.0 / (2 * 20.0 * critical)
    found = system.synchronous(np.linspace(0.2, 3.0, 30) * critical)
    (peak,) = found.peaks("disk", operating=1.5 * critical)
    # |x| = r²/√((1 − r²)² + (2ζr)²) has its maximum at 1/√(1 − 2ζ²), where it is 1/(2ζ√(1 − ζ²))
    z = damping_ratio
    # the moving mass of the shaft is 0.5 g, 2.5e-5 of the disk; a maximum has zero slope
    assert peak.speed == pytest.approx(critical / np.sqrt(1 - 2 * z**2), rel=1e-5)
    highest = 1 / (2 * z * np.sqrt(1 - z**2))
    assert peak.amplitude == pytest.approx(1e-5 * highest, rel=1e-4)
    # and 1/√2 of it where u = 1/r² solves (u − 1)² + 4ζ²u = 2/highest²
    b = 1 - 2 * z**2
    spread = np.sqrt(b**2 - 1 + 2 / highest**2)
    expected = critical / np.sqrt([b + spread, b - spread])
    assert [peak.lower, peak.upper] == pytest.approx(expected, rel=1e-5)
    factor = peak.speed / np.diff(expected)[0]
    assert peak.amplification_factor == pytest.approx(factor, rel=1e-3)
    below = 100 * (1.5 * critical - peak.speed) / (1.5 * critical)
    assert peak.separation_margin == pytest.approx(below, rel=1e-9)
    assert peak.required_margin == pytest.approx(17 * (1 - 1 / (factor - 1.5)), rel=1e-3)
    assert peak.acceptable


def test_separation_margin_above_within_and_without_operating_speeds():
    def peak(speed: float, width: float, operating=(90.0, 110.0)) -> gb.results.Peak:
        return gb.results.Peak(speed, 1.0, speed - width / 2, speed + width / 2, operating)

    assert peak(132.0, 13.2).separation_margin == pytest.approx(20.0)
    assert peak(132.0, 13.2).required_margin == pytest.approx(10 + 17 * (1 - 1 / 8.5))
    assert not peak(132.0, 13.2).acceptable
    assert peak(100.0, 10.0).separation_margin == 0.0
    assert not peak(100.0, 10.0).acceptable
    assert peak(100.0, 50.0).required_margin == 0.0  # AF 2: critically damped
    assert peak(100.0, 50.0).acceptable
    open_end = gb.results.Peak(100.0, 1.0, np.nan, 110.0, (150.0, 150.0))
    assert np.isnan(open_end.amplification_factor)
    assert not open_end.acceptable
    assert np.isnan(gb.results.Peak(100.0, 1.0, 95.0, 105.0).required_margin)


def test_slow_roll_subtraction_removes_the_bow():
    system = jeffcott(bow=1e-4, eccentricity=2e-5)
    speeds = np.array([5.0, 100.0, 150.0])
    whole = system.synchronous(speeds)
    less = whole.subtract_slow_roll(5.0)
    assert np.all(less.displacement("disk")[0] == 0.0)
    assert less.displacement("disk") == pytest.approx(
        whole.displacement("disk") - whole.displacement("disk")[:1], abs=1e-18
    )
    # the peaks are those of the remaining response
    speeds = np.linspace(20.0, 600.0, 60)
    less = system.synchronous(speeds).subtract_slow_roll(5.0)
    (peak,) = less.peaks("disk")
    at = system.synchronous([peak.speed]).subtract_slow_roll(5.0)
    assert at.orbit("disk")[0, 0] == pytest.approx(peak.amplitude, rel=1e-9)
    assert less.bearing_force(("s", 0.0)) == pytest.approx(
        system.synchronous(speeds).bearing_force(("s", 0.0)), rel=1e-15
    )


def test_peaks_of_a_train_name_their_shaft():
    system = scenes.Geared(bows={"middle": HalfSine(1e-4, 0.0)}).package()
    found = system.synchronous(np.linspace(100.0, 4000.0, 60), excitation="bow")
    (first, *_) = found.peaks("g1", source="middle")
    at = system.synchronous(first.speed).orbit("g1")[0, 1]
    assert at == pytest.approx(first.amplitude, rel=1e-9)
    assert found.peaks("g1") == []  # its own shaft is straight
    with pytest.raises(gb.GearbowError, match="no shaft is called 'other'"):
        found.peaks("g1", source="other")
    with pytest.raises(gb.ChannelError, match="no bearing at"):
        found.bearing_force(("input", 0.1))


class TestBackwards:
    """A shaft without mesh that rotates backwards is the mirror image of one that rotates forwards."""

    SPEEDS = np.linspace(20.0, 600.0, 60)

    def pairs(self, speeds, operating):
        system = jeffcott(damping=2000.0, bow=1e-4)
        mirrored = tuple(-speed for speed in operating)
        forwards = system.synchronous(speeds).peaks("disk", operating=operating)
        backwards = system.synchronous(-speeds).peaks("disk", operating=mirrored)
        return list(zip(forwards, reversed(backwards), strict=True))

    @pytest.mark.parametrize("operating", [(300.0, 400.0), (150.0, 290.0), (100.0, 120.0)])
    def test_backward_rotation_has_the_mirrored_peaks(self, operating):
        (pair,) = self.pairs(self.SPEEDS, operating)
        forwards, backwards = pair
        assert forwards.amplification_factor > 2.5
        # the same search finds both: they differ by round-off
        for name in ("speed", "lower", "upper"):
            assert getattr(backwards, name) == pytest.approx(-getattr(forwards, name), rel=1e-7)
        for name in ("amplitude", "amplification_factor", "separation_margin", "required_margin"):
            assert getattr(backwards, name) == pytest.approx(getattr(forwards, name), rel=1e-7)
        assert backwards.acceptable == forwards.acceptable

    def test_a_speed_range_through_zero_has_the_peaks_of_both_senses(self):
        system = jeffcott(damping=2000.0, bow=1e-4)
        peaks = system.synchronous(np.linspace(-600.0, 600.0, 121)).peaks(
            "disk", operating=(300, 400)
        )
        low, high = peaks
        assert low.speed == pytest.approx(-high.speed, rel=1e-7)
        assert abs(low.lower) < abs(low.speed) < abs(low.upper)
        # the other sense of rotation is far from where it operates
        assert low.separation_margin == pytest.approx(100.0 * (300.0 - low.speed) / 300.0)
        assert low.acceptable

    def test_a_half_power_speed_lies_on_the_side_of_its_peak(self):
        # with this bow and damping the response at zero speed is more than 1/√2 of the peak
        system = jeffcott(damping=6000.0, bow=1e-4, eccentricity=0.0)
        (_, peak) = system.synchronous(np.linspace(-600.0, 600.0, 121)).peaks("disk")
        assert np.isnan(peak.lower)
        assert peak.upper > peak.speed > 0.0


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_no_peak_inside_the_operating_range_is_acceptable(sense):
    for speed in (200.0, 450.0, 700.0):
        peak = gb.results.Peak(
            sense * speed,
            1.0,
            sense * (speed - 10.0),
            sense * (speed + 10.0),
            (sense * 200.0, sense * 700.0),
        )
        assert peak.amplification_factor == pytest.approx(speed / 20.0)
        assert peak.separation_margin == 0.0
        assert peak.required_margin > 10.0
        assert not peak.acceptable


def test_backward_operating_speeds_may_ascend_either_way():
    below, above = (
        gb.results.Peak(-100.0, 1.0, -95.0, -105.0, span) for span in ((-700, -200), (-200, -700))
    )
    assert below == above
    assert below.operating == (-200.0, -700.0)


@each_case(
    ("operating", "text"),
    [
        ((700.0, 200.0), "lowest speed comes first"),
        (0.0, "above 0"),
        ((0.0, 100.0), "above 0"),
        ((-100.0, 100.0), "above 0"),
        (np.nan, "finite"),
        ((100.0, np.nan), "finite"),
        (np.inf, "finite"),
        ((1.0, 2.0, 3.0), "one speed or"),
        ((), "one speed or"),
        ("fast", "must be a number"),
    ],
)
def test_invalid_operating_speeds_are_refused(operating, text):
    with pytest.raises(gb.SceneError, match=f"operating: .*{text}"):
        gb.results.Peak(100.0, 1.0, 95.0, 105.0, operating)
    response = jeffcott().synchronous([1.0, 2.0])  # has no peak
    with pytest.raises(gb.SceneError, match=f"operating: .*{text}"):
        response.peaks("disk", operating=operating)


def test_a_peak_without_width_is_undamped():
    peak = gb.results.Peak(100.0, 1.0, 100.0, 100.0, (150.0, 150.0))
    assert peak.amplification_factor == np.inf
    assert peak.required_margin == 17.0


@pytest.mark.parametrize("part", ["both", "bow", "unbalance"])
def test_only_a_bow_in_the_excitation_is_subtracted(part):
    # the sum of the parts is the whole, in displacement and in deflection; the bow counts once
    bow = 1e-4 * np.exp(0.4j)
    found = jeffcott(bow=bow).synchronous([150.0, -90.0], excitation=part)
    taken = found.displacement("disk") - found.elastic("disk")
    expected = np.zeros(2) if part == "unbalance" else bow * np.array([1.0, -1.0j])
    assert taken[:, 0] == pytest.approx(np.tile(expected, (2, 1)), abs=1e-18)


def test_a_plot_takes_one_place_or_several():
    found = jeffcott(bow=1e-4).synchronous(np.linspace(10.0, 100.0, 5))
    for draw in (found.plot, found.bode):
        for names in ("disk", ("s", 0.5), ["disk"], [("s", 0.5)], ("disk", ("s", 0.5))):
            assert draw(names).axes
    assert len(found.plot("disk").axes) == 1
    assert len(found.plot(["disk", ("s", 0.5)]).axes) == 2
