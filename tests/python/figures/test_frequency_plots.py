"""Figures over speed and in space show the numbers of their source objects."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import gearbow as gb
from gearbow.description.train import Train
from gearbow.plotting.orders import orders
from reference import scenes
from reference.bows import HalfSine


def named(panel, label: str) -> list[np.ndarray]:
    """Return the ordinates of the lines with this label in a panel."""
    lines = [line for line in panel.get_lines() if line.get_label() == label]
    return [np.asarray(line.get_ydata()) for line in lines]


def test_a_campbell_diagram_draws_frequencies_lines_and_intersections(tmp_path):
    campbell = scenes.v1().campbell(np.linspace(0.0, 200.0, 9), count=5)
    figure = campbell.plot()
    upper, lower = figure.axes
    drawn = np.concatenate(
        [np.asarray(line.get_ydata(), dtype=float) for line in upper.get_lines()]
    )
    for values in campbell.frequencies_hz.flat:
        assert np.abs(drawn - values).min() == 0.0
    met = upper.get_lines()[-1].get_xydata()
    assert met[:, 0] == pytest.approx([m.speed for m in campbell.intersections])
    names = {name for text in upper.texts for name in text.get_text().split("\n")}
    assert names == {line.name for line in campbell.lines}
    assert lower.get_ylabel() == "damping ratio [%]"
    figure.savefig(tmp_path / "figure.png", dpi=40)


def test_a_critical_speed_map_draws_both_whirl_senses():
    found = scenes.v2().critical_speed_map([1e6, 1e7])
    (panel,) = found.plot(count=2).axes
    np.testing.assert_array_equal(named(panel, "forward")[0], found.lines("forward")[:, 0])
    # two lines for each whirl, and the stiffness of the system
    assert len(panel.get_lines()) == 5
    assert panel.get_xscale() == panel.get_yscale() == "log"


def test_lines_of_a_critical_speed_map_have_no_gaps():
    """Each mode is drawn between all neighbouring stiffnesses, also where its whirl changes."""
    system = gb.examples()["idler_train"].load()
    found = system.critical_speed_map(np.logspace(7.0, 8.8, 9), count=5)
    modes = [dict(zip(*row, strict=True)) for row in zip(found.line, found.speeds, strict=True)]
    whirl = [dict(zip(*row, strict=True)) for row in zip(found.line, found.whirl, strict=True)]
    pairs = {
        (i, modes[i][line], modes[i + 1][line])
        for i in range(len(modes) - 1)
        for line in modes[i].keys() & modes[i + 1].keys()
    }
    # the machine has modes whose whirl changes
    assert any(a[line] != b[line] for a, b in pairwise(whirl) for line in a.keys() & b.keys())
    (panel,) = found.plot(count=20).axes
    drawn = {
        (i, *ends)
        for line in panel.get_lines()
        if len(line.get_ydata()) == len(modes)
        for i, ends in enumerate(pairwise(line.get_ydata()))
        if np.isfinite(ends).all()
    }
    assert drawn == pairs


def test_bode_draws_amplitude_and_phase():
    system = scenes.Geared(bows={"middle": HalfSine(1e-4, 0.5)}).package()
    response = system.synchronous(np.linspace(10.0, 300.0, 12))
    upper, lower = response.bode(["g2", "g3"]).axes
    assert named(upper, "g2")[0] == pytest.approx(np.degrees(response.phase("g2")[:, 1]))
    assert lower.get_lines()[1].get_ydata() == pytest.approx(1e6 * response.orbit("g3")[:, 1])
    source = response.bode("g1", source="middle").axes[1].get_lines()[0].get_ydata()
    assert source == pytest.approx(1e6 * response.orbit("g1")[:, 1])


@pytest.mark.parametrize("number", [1, 2, 5])
def test_a_mode_shape_figure_has_a_title(number: int, tmp_path):
    modes = scenes.Geared().package().modes(speed=100.0, count=6)
    figure = modes.plot(number)
    title = figure.get_suptitle()
    frequency = f": {modes.frequencies_hz[number - 1]:.4g} Hz" if number > 1 else ""
    assert title.startswith(f"mode {number}{frequency}")
    assert modes.whirl[number - 1] in title
    assert title.endswith(modes.names()[number - 1])
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.texts] == ["input", "middle", "output"]
    figure.savefig(tmp_path / "figure.png", dpi=40)


def test_shaft_positions_follow_from_the_meshes():
    angles = (0.3, 2.0)
    system = scenes.Geared(angles=angles).package()
    found = Train.of(system.description, system.speed_ratios).layout
    places = {shaft.name: shaft.origin for shaft in found.shafts}
    distance = 0.003 * (25 + 50) / 2
    assert places["input"] == pytest.approx(np.zeros(3))
    # meshing gears share a plane: 0.25 on the input shaft is 0.125 on the middle one
    first = [0.125, distance * np.cos(0.3), distance * np.sin(0.3)]
    assert places["middle"] == pytest.approx(first)
    second = [0.125, distance * np.cos(2.0), distance * np.sin(2.0)]
    assert places["output"] == pytest.approx(np.add(first, second))


def test_a_mode_number_out_of_range_is_an_error():
    modes = scenes.v3().modes(count=4)
    with pytest.raises(gb.GearbowError, match="there is no mode 5; there are 4, from 1"):
        modes.plot(5)


@pytest.mark.parametrize("smallest", [0.5, 1e-3])
def test_the_longest_bar_of_orders_leaves_room_for_its_value(smallest: float):
    (panel,) = orders(["1x", "2x"], np.array([1.0, smallest]), "amplitude [m]").axes
    assert panel.get_xscale() == ("linear" if smallest == 0.5 else "log")
    begin, end = panel.transData.inverted().transform(panel.transAxes.transform([(0, 0), (1, 0)]))
    assert begin[0] == pytest.approx(panel.get_xlim()[0])
    (top, _), (low, _) = panel.transAxes.inverted().transform(
        panel.transData.transform([(1.0, 0.0), (smallest, 0.0)])
    )
    assert 0.8 < top < 0.95
    assert 0.05 < low < top
    assert end[0] > 1.0
