"""Axes have plain numbers, the units of the other figures, and no panel of round-off."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.figure import Figure

import gearbow as gb
from gearbow.plotting.analyses import bow_limits
from gearbow.plotting.style import log_scale
from reference.cases import each_case
from reference.machines import bowed_rotor, jeffcott


def test_a_direction_of_round_off_has_the_scale_of_the_other():
    system = bowed_rotor().replace(gravity=9.81)
    across, down = system.static(speed=100.0).plot().axes
    sag = np.ptp(down.get_ylim())
    assert np.ptp(across.get_ylim()) > sag
    (line, *_) = across.get_lines()
    assert np.abs(line.get_ydata()).max() < 1e-9 * sag


@each_case("kind", ["bode", "nyquist", "waterfall"])
def test_responses_to_a_force_are_in_micrometres(kind: str):
    found = jeffcott(damping=4e3).frequency_response(
        [10.0, 20.0, 30.0], source=gb.Force("disk", 1.0), speed=[5.0, 9.0]
    )
    panel, *others = found.plot("disk", direction="y", kind=kind).axes
    motion = 1e6 * found.displacement("disk")[0, :, 0, 0]
    if kind == "bode":
        assert panel.get_ylabel() == "displacement [µm]"
        np.testing.assert_allclose(panel.get_lines()[0].get_ydata(), np.abs(motion))
    elif kind == "nyquist":
        assert panel.get_xlabel() == "real part [µm]"
        np.testing.assert_allclose(panel.get_lines()[0].get_xdata(), motion.real)
    else:
        assert others[0].get_ylabel() == "disk, y [µm]"
        np.testing.assert_allclose(panel.collections[0].get_array()[0], np.abs(motion))


@each_case("speeds", [np.linspace(100.0, 900.0, 9), np.linspace(-900.0, -100.0, 9)])
def test_the_curve_of_a_response_passes_through_its_peaks(speeds):
    response = bowed_rotor().synchronous(speeds)
    at = ("rotor", 0.5)
    (peak, *_) = response.peaks(at)
    curve = response.bode(at).axes[1].get_lines()[0].get_xydata()
    assert np.all(np.diff(curve[:, 0]) > 0.0)
    assert curve[:, 1].max() == pytest.approx(1e6 * peak.amplitude)
    for side in (peak.lower, peak.upper):
        found = np.interp(side, *curve.T)
        assert found == pytest.approx(1e6 * peak.amplitude / np.sqrt(2.0))


@each_case("ends", [(2.0, 7.0), (60.0, 95.0), (12.0, 900.0), (1e-3, 2e3), (1e5, 3e9)])
def test_labels_of_a_logarithmic_axis_do_not_overlap(ends):
    figure = Figure(figsize=(6.0, 3.2))
    panel = figure.subplots()
    panel.plot([0.0, 1.0], ends)
    log_scale(panel)
    figure.draw_without_rendering()
    shown = [
        text
        for kind in ("majorTicks", "minorTicks")
        for tick in panel.yaxis._update_ticks()
        if tick in getattr(panel.yaxis, kind) and (text := tick.label1).get_text()
    ]
    boxes = sorted((text.get_window_extent() for text in shown), key=lambda box: box.y0)
    assert len(boxes) >= 2
    assert all(low.y1 < high.y0 for low, high in pairwise(boxes))
    if ends[1] < 1e3 * ends[0]:
        assert not any("mathdefault" in text.get_text() for text in shown)


def test_limits_without_a_curve_keep_the_range_of_speeds():
    lines = {"displacement": np.zeros(2)}
    figure = bow_limits(np.array([100.0, 200.0]), lines, 1e-5, label="bow of rotor")
    assert figure.axes[0].get_xlim() == (100.0, 200.0)


def test_limits_at_one_speed_are_bars():
    lines = {"teeth": np.array([2e-4]), "force": np.array([5e-5]), "play": np.array([np.inf])}
    (panel,) = bow_limits(np.array([100.0]), lines, 1e-4, label="bow of rotor").axes
    assert [bar.get_width() for bar in panel.patches] == pytest.approx([200.0, 50.0])
    assert [text.get_text() for text in panel.get_yticklabels()] == ["teeth", "force"]
    # a limit that the present bow exceeds has the colour of a warning
    assert panel.patches[0].get_facecolor() != panel.patches[1].get_facecolor()
    assert panel.get_xlabel() == "bow of rotor [µm], at 100 rad/s"
    assert panel.get_title(loc="right") == "1 further limit is above, or not reached"


@each_case(("damping", "scale"), [(2e2, "log"), (2e4, "linear")])
def test_a_response_with_a_sharp_peak_has_a_logarithmic_axis(damping, scale):
    system = jeffcott(damping=damping)
    response = system.synchronous(np.linspace(10.0, 1500.0, 60))
    assert response.bode().axes[1].get_yscale() == scale


def test_small_logarithmic_labels_have_whole_exponents():
    figure = Figure()
    panel = figure.subplots()
    panel.plot([0.0, 1.0], [2e-6, 3e-5])
    log_scale(panel)
    figure.draw_without_rendering()
    texts = [text.get_text() for text in panel.get_yticklabels(which="both")]
    assert any("2\\times 10^{-5}" in text for text in texts)
    assert not any("." in text for text in texts if "^" in text)


def test_round_off_is_no_damping():
    modes = jeffcott().modes(count=2)
    ratios = np.array([-6e-17, 0.02])
    figure = replace(modes, damping_ratios=ratios).plot(count=2)
    ends = [panel.get_title().splitlines()[0].split("damping ")[1] for panel in figure.axes]
    assert ends == ["0 %", "2 %"]
