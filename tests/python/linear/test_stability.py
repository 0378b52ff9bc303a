"""Stability thresholds, and warnings of steady responses at unstable speeds."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import gearbow as gb
from gearbow.results.campbell import unstable_ranges
from reference.machines import inertia, rigid_rotor

STIFFNESS, DAMPING, SLOPE = 1e6, 500.0, 1e3  # N/m, N s/m, N s/m of each seal


def on_seals(cross: gb.SpeedTable | list, damping: float = DAMPING) -> gb.RotorSystem:
    """Return a stiff rotor on two equal seals with the stiffness matrix `cross`."""
    disk = inertia(20.0, 0.02, 0.02, unbalance=1e-4)
    return rigid_rotor(disk, {"stiffness": cross, "damping": damping})


def matrix(cross: float) -> list[list[float]]:
    return [[STIFFNESS, cross], [-cross, STIFFNESS]]


def rising() -> gb.SpeedTable:
    """Return a cross stiffness that is proportional to the speed."""
    speeds = [0.0, 100.0, 200.0, 400.0]
    return gb.SpeedTable(speeds, [matrix(SLOPE * speed) for speed in speeds])


def threshold_of_a_rigid_rotor(system: gb.RotorSystem) -> float:
    """Return the speed at which the cross force equals the damping force, q(Ω) = c ω."""
    mass = system.matrices().mass
    dofs = [direction == "v" for _, _, direction in system.dofs]
    total = mass[np.ix_(dofs, dofs)].sum()
    return DAMPING * np.sqrt(2.0 * STIFFNESS / total) / SLOPE


def test_a_threshold_agrees_with_the_closed_form():
    system = on_seals(rising())
    (found,) = system.campbell(np.linspace(0.0, 220.0, 5), count=2).thresholds
    # The shaft is 1e4 times stiffer than the seals.
    assert found.speed == pytest.approx(threshold_of_a_rigid_rotor(system), rel=1e-3)
    assert (found.whirl, found.above) == ("forward", "unstable")
    modes = system.modes(found.speed)
    nearest = np.abs(modes.frequencies_hz - found.frequency_hz).argmin()
    assert abs(modes.damping_ratios[nearest]) < 1e-10


@pytest.mark.parametrize("steps", [2, 3, 17])
def test_a_threshold_does_not_depend_on_the_speeds(steps: int):
    system = on_seals(rising())
    found = [
        system.campbell(np.linspace(0.0, 220.0, count), count=2).thresholds[0].speed
        for count in (5, steps)
    ]
    assert found[0] == pytest.approx(found[1], rel=1e-10)


def test_a_mode_may_become_stable_again():
    speeds = np.array([0.0, 100.0, 200.0, 300.0, 400.0])
    table = gb.SpeedTable(speeds, [matrix(q) for q in (0.0, 0.0, 3e5, 0.0, 0.0)])
    diagram = on_seals(table).campbell(np.linspace(0.0, 400.0, 9), count=2)
    first, second = diagram.thresholds
    assert (first.above, second.above) == ("unstable", "stable")
    assert diagram.unstable_ranges == ((first.speed, second.speed),)
    rows = diagram.table().splitlines()
    assert sum("itself: unstable above" in row for row in rows) == 1
    assert sum("itself: stable above" in row for row in rows) == 1
    assert "stability thresholds" in repr(diagram)


def test_speeds_that_are_unstable_throughout_have_no_threshold():
    diagram = on_seals(matrix(3e5)).campbell([100.0, 200.0], count=2)
    assert diagram.thresholds == ()
    assert diagram.unstable_ranges == ((100.0, 200.0),)


def test_growth_below_the_round_off_of_a_mode_is_no_instability():
    # 1e-6 of the eigenvalue: the growth of the second mode is below, that of the third above it
    values = np.tile([-1.0 + 1e4j, 9e-3 + 1e4j, 11e-3 + 1e4j], (3, 1))
    speeds = np.array([10.0, 20.0, 40.0])
    assert unstable_ranges(speeds, values[:, :2], ()) == ()
    assert unstable_ranges(speeds, values, ()) == ((10.0, 40.0),)


def test_no_mode_of_a_passive_system_has_a_threshold():
    diagram = on_seals([2e6, 1e6], damping=0.0).campbell(np.linspace(0.0, 400.0, 9), count=4)
    assert diagram.thresholds == diagram.unstable_ranges == ()


def test_oil_whirl_begins_at_the_threshold():
    film = {"diameter": 0.05, "length": 0.025, "clearance": 5e-5, "viscosity": 0.03}
    system = gb.RotorSystem(
        [gb.Shaft("rotor", length=0.3, outer_diameter=0.05, elements=4)],
        disks=[gb.Disk("disk", "rotor", 0.15, 10.0, 0.01, 0.02, unbalance=1e-5)],
        bearings=[gb.JournalBearing("rotor", x, **film) for x in (0.0, 0.3)],
        gravity=9.81,
    )
    (found,) = system.campbell(np.linspace(400.0, 1600.0, 7), count=4).thresholds
    assert found.above == "unstable"
    assert 2.0 * np.pi * found.frequency_hz == pytest.approx(0.5 * found.speed, rel=0.05)
    for factor, stable in ((0.999, True), (1.001, False)):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            system.synchronous(factor * found.speed)
        assert any("unstable" in str(one.message) for one in caught) != stable


def test_the_warning_names_the_unstable_speeds():
    system = on_seals(rising())
    (threshold,) = system.campbell([0.0, 400.0], count=2).thresholds
    speeds = np.linspace(1.0, 399.0, 200)
    first = speeds[speeds > threshold.speed][0]
    rpm = 30.0 / np.pi
    text = f"from {first:.4g} to 399 rad/s ({first * rpm:.4g} to {399.0 * rpm:.4g} rpm)"
    for given in (speeds, speeds[::-1]):
        with pytest.warns(gb.AccuracyWarning) as caught:
            system.synchronous(given)
        (warning,) = caught
        assert f"speeds: the motion is unstable {text}" in str(warning.message)
        assert "thresholds" in str(warning.message)


def test_a_peak_at_an_unstable_speed_is_not_acceptable():
    cross = [[3e7, 2e7], [-2e7, 3e7]]
    rotor = gb.RotorSystem(
        [gb.Shaft("r", length=1.0, outer_diameter=0.05)],
        disks=[gb.Disk("d", "r", 0.5, 20.0, 0.1, 0.2, unbalance=1e-4)],
        bearings=[gb.Bearing("r", x, stiffness=cross, damping=2e3) for x in (0.0, 1.0)],
    )
    for speeds in (np.linspace(200.0, 400.0, 9), -np.linspace(200.0, 400.0, 9)):
        with pytest.warns(gb.AccuracyWarning, match="unstable from"):
            response = rotor.synchronous(speeds)
        for peak in response.peaks("d", operating=2.0 * speeds[-1]):
            assert peak.separation_margin > peak.required_margin
            assert not peak.stable
            assert not peak.acceptable


def test_a_stable_system_has_no_warning_and_stable_peaks(recwarn):
    # The cross stiffness stays below that of the threshold.
    system = on_seals(matrix(1e4))
    response = system.synchronous(np.linspace(100.0, 600.0, 30))
    (peak,) = response.peaks("disk", operating=2000.0)
    assert peak.stable
    assert peak.acceptable
    assert not recwarn.list


def test_a_torque_that_rises_with_the_speed_is_unstable():
    def turbine(*torques: float) -> gb.RotorSystem:
        table = gb.SpeedTable([0.0, 1000.0], torques)
        return on_seals(matrix(0.0)).replace(
            torques=[gb.Torque("disk", table)], drives=[gb.Drive("disk", stiffness=1e3)]
        )

    with pytest.warns(gb.AccuracyWarning, match="unstable at 100 rad/s"):
        turbine(0.0, 50.0).synchronous(100.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        turbine(50.0, 0.0).synchronous(100.0)


def test_the_figure_marks_thresholds_and_unstable_speeds(tmp_path):
    diagram = on_seals(rising()).campbell(np.linspace(0.0, 220.0, 9), count=4)
    figure = diagram.plot(speed_unit="rpm", operating=100.0)
    upper, lower = figure.axes
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.texts][-3:] == [
        "stability threshold",
        "unstable",
        "operating speed",
    ]
    (threshold,) = diagram.thresholds
    expected = [threshold.speed * 30.0 / np.pi, threshold.frequency_hz]
    assert any(
        np.allclose(line.get_xydata(), [expected])
        for line in upper.get_lines()
        if len(line.get_xdata()) == 1
    )
    assert len(lower.patches) == 1
    figure.savefig(tmp_path / "campbell.png")
    boxes = [
        label.get_window_extent()
        for label, place in zip(lower.get_yticklabels(), lower.get_yticks(), strict=True)
        if label.get_text() and lower.get_ylim()[0] <= place <= lower.get_ylim()[1]
    ]
    assert len(boxes) > 3
    assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])


def test_curves_pass_intersections_and_thresholds():
    diagram = on_seals(rising()).campbell([0.0, 110.0, 220.0], count=4)
    upper, lower = diagram.plot().axes
    points = [(one.speed, one.frequency_hz) for one in diagram.intersections]
    points += [(one.speed, one.frequency_hz) for one in diagram.thresholds]
    drawn = np.concatenate(
        [line.get_xydata() for line in upper.get_lines() if len(line.get_xdata()) > 15]
    )
    for point in points:
        assert np.abs(drawn - point).max(axis=1).min() < 1e-9 * max(point)
    drawn = np.concatenate(
        [line.get_xydata() for line in lower.get_lines() if len(line.get_xdata()) > 15]
    )
    (threshold,) = diagram.thresholds
    assert np.abs(drawn - [threshold.speed, 0.0]).max(axis=1).min() < 1e-9 * threshold.speed


def test_the_curve_is_the_monotone_cubic():
    from gearbow.plotting.style import smooth

    interpolate = pytest.importorskip("scipy.interpolate")
    x, y = np.array([3.0, 0.0, 1.0, 4.5, 7.0, 1.0]), np.array([2.0, 1.0, 4.0, 2.5, 9.0, 4.0])
    places, values = smooth(x, y)
    order = np.array([1, 2, 0, 3, 4])
    pchip = interpolate.PchipInterpolator(x[order], y[order])
    inner = (places >= 1.0) & (places <= 4.5)
    # The slopes at the ends are those of the secants.
    assert values[inner] == pytest.approx(pchip(places[inner]), rel=1e-12)
    assert np.all(np.diff(values[places >= 3.0]) > 0.0)
    assert smooth(x[:2], y[:2])[0].tolist() == [0.0, 3.0]
