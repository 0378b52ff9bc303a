"""Figures of plotly that are made of figures of matplotlib: the same places, lines, areas and texts."""

from __future__ import annotations

import numpy as np
import pytest

from reference.machines import hostile

pytest.importorskip("matplotlib")
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, Rectangle

from gearbow.plotting.interactive import WIDTH, converted, scene
from gearbow.plotting.shapes import parts


def figure() -> tuple[Figure, list]:
    made = Figure(figsize=(8.0, 6.0), dpi=100)
    return made, list(made.subplots(2, 1, sharex=True))


def traces(found: dict, **wanted: object) -> list[dict]:
    return [
        one for one in found["data"] if all(one.get(key) == value for key, value in wanted.items())
    ]


def test_lines_axes_and_legend():
    made, (upper, lower) = figure()
    x = np.linspace(1.0, 3.0, 20)
    upper.plot(x, x**2, "--", color="red", linewidth=2.0, label="square")
    lower.semilogy(x, 10.0**x, "o", color="blue")
    upper.set(ylabel="size [m]", title="top")
    made.legend(*upper.get_legend_handles_labels())
    found = converted(made)
    layout = found["layout"]
    # 8 of the 12 inches of a page
    assert (layout["width"], layout["height"]) == (2.0 / 3.0 * WIDTH, 0.5 * WIDTH)
    (line,) = traces(found, xaxis="x", legendgroup="square")
    np.testing.assert_allclose(line["x"], x, atol=2.0**-17 * np.ptp(x))  # rounded to steps
    np.testing.assert_allclose(line["y"], x**2, atol=2.0**-17 * np.ptp(x**2))
    assert (line["mode"], line["line"]["dash"]) == ("lines", "dash")
    assert line["line"]["color"] == "rgba(255,0,0,1)"
    assert line["line"]["width"] == pytest.approx(2.0 * WIDTH / (72.0 * 12.0))
    assert "square" in line["hovertemplate"]
    assert "size [m]" in line["hovertemplate"]
    # an entry of the legend hides the lines of its group
    (entry,) = traces(found, name="square", showlegend=True)
    assert entry["legendgroup"] == "square"
    (marks,) = traces(found, xaxis="x2")
    assert (marks["mode"], marks["marker"]["symbol"]) == ("markers", "circle")
    np.testing.assert_allclose(marks["y"], 10.0**x, rtol=2.0**-17)
    axis = layout["yaxis2"]
    assert axis["type"] == "log"
    assert axis["range"] == pytest.approx(np.log10(lower.get_ylim()))
    assert layout["xaxis2"]["matches"] == "x"
    box = upper.get_position()
    assert layout["yaxis"]["domain"] == pytest.approx([box.y0, box.y1])
    assert "top" in [text["text"] for text in layout["annotations"]]


def test_a_scale_that_plotly_lacks_keeps_its_values():
    made, (upper, _) = figure()
    upper.set_yscale("symlog", linthresh=1.0)
    values = np.array([-100.0, 0.0, 0.5, 100.0])
    upper.plot(np.arange(4.0), values)
    found = converted(made)
    (line,) = traces(found, xaxis="x")
    np.testing.assert_allclose(line["customdata"], values)
    placed = upper.yaxis.get_transform().transform(values)
    np.testing.assert_allclose(line["y"], placed, atol=2.0**-17 * np.ptp(placed))  # of steps
    assert len(found["layout"]["yaxis"]["tickvals"]) == len(found["layout"]["yaxis"]["ticktext"])


def test_areas_spans_and_arrows():
    made, (upper, lower) = figure()
    upper.add_patch(Rectangle((1.0, 2.0), 3.0, 4.0, facecolor="green", edgecolor="none"))
    upper.add_patch(FancyArrowPatch((0.0, 0.0), (2.0, 1.0), arrowstyle="-|>", color="black"))
    upper.axvspan(0.5, 0.7, color="grey")
    upper.set(xlim=(0.0, 5.0), ylim=(0.0, 7.0))
    lower.axhline(3.0, color="black")
    lower.set(ylim=(2.0, 4.0))
    found = converted(made)
    rectangle = next(one for one in found["data"] if one["fillcolor"] == "rgba(0,128,0,1)")
    assert (np.nanmin(rectangle["x"]), np.nanmax(rectangle["x"])) == pytest.approx((1.0, 4.0))
    assert (np.nanmin(rectangle["y"]), np.nanmax(rectangle["y"])) == pytest.approx((2.0, 6.0))
    fills = [one["fillcolor"] for one in traces(found, fill="toself")]
    assert "rgba(0,0,0,0)" in fills  # the shaft of the arrow
    assert "rgba(0,0,0,1)" in fills  # its head
    span, line = found["layout"]["shapes"]
    assert (span["x0"], span["x1"]) == pytest.approx((0.5, 0.7))
    assert (span["type"], span["yref"], span["y0"], span["y1"]) == ("rect", "y domain", 0.0, 1.0)
    assert (line["type"], line["xref"], line["yref"]) == ("line", "x2 domain", "y2")
    assert line["y0"] == line["y1"] == pytest.approx(3.0)


def test_a_dense_line_keeps_its_shape_with_fewer_points():
    made, (upper, _) = figure()
    x = np.linspace(0.0, 1.0, 200_001)
    y = np.sin(40.0 * x) + 0.5 * np.sin(3.0 * x)
    upper.plot(x, y)
    (line,) = traces(converted(made), xaxis="x")
    assert len(line["x"]) < 10_000
    # a quarter of a ninth of a pixel of 600: the simplification of matplotlib at fourfold size
    assert np.abs(np.interp(x, line["x"], line["y"]) - y).max() < 1e-3 * np.ptp(y)
    assert (line["x"][0], line["x"][-1]) == pytest.approx((0.0, 1.0))


def test_a_dense_line_on_a_logarithmic_scale_keeps_its_values():
    made, (upper, _) = figure()
    x = np.linspace(0.0, 1.0, 2_001)
    upper.semilogy(x, 10.0 ** (4.0 * x - 2.0))
    (line,) = traces(converted(made), xaxis="x")
    np.testing.assert_allclose(line["y"], 10.0 ** (4.0 * np.array(line["x"]) - 2.0), rtol=1e-2)


def test_a_mode_in_space():
    modes = hostile().modes(100.0, count=3)
    title, shape, dofs = modes._drawn(2)
    found = scene(parts(shape, dofs, modes.layout), title)
    kinds = [one["type"] for one in found["data"]]
    assert (kinds.count("surface"), kinds.count("mesh3d")) == (4, 5)  # shafts and gears
    named = [one["name"] for one in traces(found, showlegend=True)]
    assert named == ["input", "idler", "middle", "output"]
    drawn = modes.plot(2).axes[0]
    lines = [one for one in found["data"] if one["type"] == "scatter3d"]
    assert len(lines) == len(drawn.get_lines())
    for one, line in zip(lines, drawn.get_lines(), strict=True):
        x = np.array(line.get_data_3d()[0])
        if x.size:
            np.testing.assert_allclose(one["x"], x, atol=1e-6)  # places are rounded to 1 µm
