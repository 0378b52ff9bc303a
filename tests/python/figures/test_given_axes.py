"""Every figure can go into the panels of the user, and has speeds in rad/s or rpm."""

from __future__ import annotations

import inspect
from dataclasses import replace
from math import pi

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure

import gearbow as gb
from reference.cases import each_case
from reference.machines import hostile, jeffcott, rated
from reference.records import of_series, response
from test_tradeoff_numbers import STUDY

HOT = gb.ThermalBow("g1", 1e4, time_constant=9.0, shape=gb.Bow.half_sine(1e-6))
TIME = 1e-3 * np.arange(64)
RPM = 30.0 / pi


@pytest.fixture(scope="module")
def results() -> dict:
    """Return one result of each kind."""
    system, run = hostile(), response(TIME)
    time = 1e-3 * np.arange(6000)
    probes = [gb.Probe("input", 0.15), gb.Probe("input", 0.15, angle=1.5)]
    vectors = 1e-6 * np.array([[3.0, -3j], [4.0 - 1j, -1.0 - 4j], [5.0, -5j], [6.0, -6j]])
    measured = gb.Measurement([10.0, 50.0, 90.0, 130.0], vectors, probes)
    series = of_series(time, 1e-6 * np.cos(100.0 * time))
    runs = [of_series(1e-3 * np.arange(500), np.zeros(500), speed) for speed in (90.0, 120.0)]
    return {
        "system": system,
        "run": run,
        "modes": system.modes(count=3),
        "campbell": jeffcott(damping=4e3).campbell([0.0, 100.0, 200.0], count=4),
        "map": jeffcott().critical_speed_map([1e6, 1e7]),
        "synchronous": system.synchronous([10.0, 20.0]),
        "sensitivity": system.sensitivity("bearings[0].stiffness", system.modes(count=3)),
        "measurement": measured,
        "identification": gb.identify(system, measured, [gb.unknown.bow("input")], runout=False),
        "bearing life": rated(system).bearing_life(10.0, factor=2.0),
        "film": gb.TiltingPadBearing(
            "s", 0.0, diameter=0.1, length=0.05, clearance=1e-4, viscosity=0.02, pad_count=5
        ).coefficients(3000.0, 300.0),
        "bow limits": system.bow_limits("input", [10.0, 20.0]),
        "thermal stability": (thermal := system.thermal_bow(HOT, [10.0, 20.0])),
        "thermal spiral": thermal.spiral(10.0, 5.0),
        "efficiency": system.replace(
            meshes=[replace(mesh, friction=0.05) for mesh in system.meshes]
        ).efficiency([10.0, 20.0]),
        "response": system.frequency_response(
            [10.0, 20.0], source=gb.Force("g1", 1.0), speed=[5.0, 9.0]
        ),
        "spectrum": run.spectrum("g1"),
        "orders": series.orders("g1", "z", shaft_harmonics=1, mesh_harmonics=0),
        "waterfall": gb.waterfall(runs, "g1", "z"),
        "energy": run.energy_balance(),
        "tradeoff": STUDY,
        "steady": system.steady_state(100.0, geometry="frozen"),
        "branch": jeffcott(damping=4e3).continuation(
            "speed", 50.0, 55.0, record=["disk"], first_step=1.0
        ),
    }


#: Number of panels and call of each figure. The numbers of panels that do not fit follow.
FIGURES = {
    "system, side view": (1, lambda r, ax: r["system"].plot(ax=ax)),
    "system": (2, lambda r, ax: r["system"].plot(ax=ax)),
    "orbits": (2, lambda r, ax: r["run"].plot("orbits", ["g1", "g2"], ax=ax)),
    "history": (2, lambda r, ax: r["run"].plot("history", ["g1", "g2"], ax=ax)),
    "twist": (1, lambda r, ax: r["run"].plot("twist", "g1", ax=ax)),
    "mesh": (6, lambda r, ax: r["run"].plot("mesh", ax=ax)),
    "geometry": (4, lambda r, ax: r["run"].plot("geometry", ("g1", "g2"), ax=ax)),
    "bearings": (4, lambda r, ax: r["run"].plot("bearings", ax=ax)),
    "spectra": (2, lambda r, ax: r["run"].plot("spectrum", ["g1", "g2"], ax=ax)),
    "modes": (3, lambda r, ax: r["modes"].plot(count=3, ax=ax)),
    "campbell": (2, lambda r, ax: r["campbell"].plot(ax=ax)),
    "map": (1, lambda r, ax: r["map"].plot(ax=ax)),
    "sensitivity": (2, lambda r, ax: r["sensitivity"].plot(ax=ax)),
    "synchronous": (2, lambda r, ax: r["synchronous"].plot(["g1", "g2"], ax=ax)),
    "bode": (2, lambda r, ax: r["synchronous"].bode("g1", ax=ax)),
    "polar": (1, lambda r, ax: r["synchronous"].plot("g1", "polar", ax=ax)),
    "measurement": (2, lambda r, ax: r["measurement"].plot(ax=ax)),
    "identification": (5, lambda r, ax: r["identification"].plot(ax=ax)),
    "efficiency": (1, lambda r, ax: r["efficiency"].plot(ax=ax)),
    "bow limits": (1, lambda r, ax: r["bow limits"].plot(ax=ax)),
    "film": (3, lambda r, ax: r["film"].plot(ax=ax)),
    "thermal stability": (2, lambda r, ax: r["thermal stability"].plot(ax=ax)),
    "thermal spiral": (2, lambda r, ax: r["thermal spiral"].plot(ax=ax)),
    "frequency response": (2, lambda r, ax: r["response"].plot("g1", ax=ax)),
    "nyquist": (1, lambda r, ax: r["response"].plot("g1", kind="nyquist", ax=ax)),
    "map of a response": (1, lambda r, ax: r["response"].plot("g1", kind="waterfall", ax=ax)),
    "spectrum": (1, lambda r, ax: r["spectrum"].plot(ax=ax)),
    "orders": (1, lambda r, ax: r["orders"].plot(ax=ax)),
    "waterfall": (1, lambda r, ax: r["waterfall"].plot(ax=ax)),
    "energy": (3, lambda r, ax: r["energy"].plot(ax=ax)),
    "tradeoff": (1, lambda r, ax: r["tradeoff"].plot(ax=ax)),
    "branch": (1, lambda r, ax: r["branch"].plot(ax=ax)),
    "steady state": (1, lambda r, ax: r["steady"].plot("orbits", "g1", ax=ax)),
}


@pytest.mark.parametrize("name", list(FIGURES))
def test_a_figure_goes_into_given_panels(name, results):
    count, draw = FIGURES[name]
    figure = Figure(figsize=(8.0, 3.0 * count), layout="constrained")
    # the last panel stays empty
    *given, other = figure.subplots(count + 1, 1)
    size = figure.get_size_inches().tolist()
    for panel in given:
        panel.tick_params(labelsize=7.0)
    assert draw(results, given if count > 1 else given[0]) is figure
    assert figure.get_size_inches().tolist() == size
    assert figure.legends == []
    assert not other.has_data()
    for panel in given:
        assert panel.lines or panel.patches or panel.collections
        assert panel.get_xlabel()
        assert panel.get_ylabel() or name == "orders"
        assert panel.xaxis.get_major_ticks()[0].label1.get_fontsize() == 7.0
        # the texts have the size of the user's settings, not that of a new figure
        assert all(text.get_fontsize() <= mpl.rcParams["font.size"] for text in panel.texts)
    figure.draw_without_rendering()


@each_case("name", list(FIGURES))
def test_other_things_than_the_panels_are_an_error(name, results):
    count, draw = FIGURES[name]
    wanted = "1 or 2" if name.startswith("system") else str(count)
    with pytest.raises(gb.GearbowError, match=r"^ax: must be matplotlib Axes"):
        draw(results, "axes")
    with pytest.raises(gb.GearbowError, match=rf"^ax: this figure has {wanted} panel.*, got 7; "):
        draw(results, Figure().subplots(7))


def test_panels_may_be_in_an_array_or_a_subfigure(results):
    figure = Figure()
    left, right = figure.subfigures(1, 2)
    assert results["campbell"].plot(ax=left.subplots(2, 1)) is figure
    assert results["run"].plot("mesh", ax=right.subplots(3, 2)) is figure


def test_a_mode_in_space_needs_a_panel_in_three_dimensions(results):
    figure = Figure()
    panel = figure.add_subplot(projection="3d")
    assert results["modes"].plot(2, ax=panel) is figure
    assert panel.get_title().startswith("mode 2: ")
    with pytest.raises(gb.GearbowError, match=r'^ax: .*projection="3d"'):
        results["modes"].plot(2, ax=Figure().add_subplot())


@pytest.mark.parametrize("name", ["campbell", "synchronous", "bode", "waterfall", "map"])
def test_speeds_are_in_the_given_unit(name, results):
    draw = {
        "campbell": results["campbell"].plot,
        "synchronous": lambda **unit: results["synchronous"].plot("g1", **unit),
        "bode": lambda **unit: results["synchronous"].bode("g1", **unit),
        "waterfall": results["waterfall"].plot,
        "map": results["map"].plot,
    }[name]
    radians, turns = (draw(speed_unit=unit).axes[0] for unit in ("rad/s", "rpm"))
    upright = name in ("map", "waterfall")
    for first, second in zip(radians.get_lines(), turns.get_lines(), strict=True):
        if name == "map" and first.get_label() == "stiffness of the system":
            continue
        get = "get_ydata" if upright else "get_xdata"
        np.testing.assert_allclose(
            getattr(second, get)(), RPM * np.array(getattr(first, get)()), rtol=1e-12
        )
        get = "get_xdata" if upright else "get_ydata"
        np.testing.assert_allclose(getattr(second, get)(), getattr(first, get)(), rtol=1e-12)
    below = draw(speed_unit="rpm").axes
    label = below[0].get_ylabel() if upright else [panel.get_xlabel() for panel in below][-1]
    assert label.endswith("[rpm]")
    with pytest.raises(gb.GearbowError, match=r"^speed_unit: must be one of rad/s, rpm, got 'Hz'"):
        draw(speed_unit="Hz")


def test_a_campbell_diagram_shades_the_operating_speeds(results):
    # the excitation lines reach the operating speed beyond the last computed one
    upper, lower = results["campbell"].plot(operating=(280.0, 300.0), speed_unit="rpm").axes
    for panel in (upper, lower):
        (shade,) = panel.patches
        box = shade.get_extents().transformed(panel.transData.inverted())
        assert [box.x0, box.x1] == pytest.approx([280.0 * RPM, 300.0 * RPM])
        assert panel.get_xlim() == pytest.approx((0.0, 300.0 * RPM))
    ends = [line.get_xdata()[-1] for line in upper.get_lines() if len(line.get_xdata()) == 2]
    assert 300.0 * RPM in [pytest.approx(end) for end in ends]
    with pytest.raises(gb.SceneError, match="operating"):
        results["campbell"].plot(operating=0.0)


def test_damping_ratios_that_differ_much_have_a_logarithmic_scale(results):
    assert results["campbell"].plot().axes[1].get_yscale() == "linear"
    # ratios up to 15 %: larger ones do not set the scale
    soft = results["campbell"].damping_ratios.copy()
    soft *= 0.15 / soft.max()
    soft[:, 0] /= 100.0
    from gearbow.plotting import campbell

    def draw(ratios):
        found = results["campbell"]
        return campbell.campbell(
            found.speeds, found.frequencies_hz, ratios, found.whirl, lines=(), intersections=()
        ).axes[1]

    assert draw(soft).get_yscale() == "log"
    # an unstable mode has to be visible
    soft[:, 1] *= -1.0
    panel = draw(soft)
    assert panel.get_yscale() == "symlog"
    assert panel.get_ylim()[0] < 100.0 * soft.min()


def test_a_critical_speed_map_marks_the_stiffness_of_the_system():
    shaft = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=4)

    def drawn(*bearings):
        return gb.RotorSystem([shaft], bearings=bearings).critical_speed_map([1e6, 1e8], count=2)

    def bearing(x, stiffness):
        return gb.Bearing("rotor", x, stiffness=stiffness)

    found = drawn(bearing(0.0, 2e7), bearing(1.0, [[1e7, 1e5], [1e5, 4e7]]))
    assert found.actual == (2e7, 1e7, 4e7)
    panel = found.plot().axes[0]
    (shade,) = panel.patches
    assert shade.get_label() == "stiffness of the system"
    box = shade.get_extents().transformed(panel.transData.inverted())
    assert [box.x0, box.x1] == pytest.approx([1e7, 4e7])
    found = drawn(bearing(0.0, 2e7), bearing(1.0, 2e7))
    (line,) = [
        line for line in found.plot().axes[0].get_lines() if line.get_label().startswith("stiff")
    ]
    assert line.get_xdata() == [2e7, 2e7]
    table = gb.SpeedTable([0.0, 100.0], [1e7, 2e7])
    found = drawn(bearing(0.0, table), bearing(1.0, table))
    assert found.actual == ()
    assert not list(found.plot().axes[0].patches)


def test_a_spectrum_names_the_orders_at_its_peaks():
    time = 1e-3 * np.arange(4000)
    # shafts at 1, 0.4 and 0.16 times 100 rad/s, mesh g1/g2 at 20 times
    values = 1e-5 * np.cos(100.0 * time) + 1e-6 * np.cos(2000.0 * time)
    values += 3e-7 * np.cos(1900.0 * time)
    figure = of_series(time, values).spectrum("g1", "z").plot()
    (panel,) = figure.axes
    assert {text.get_text() for text in panel.texts} == {
        "1× input",
        "1× mesh",
        "1× mesh − 1× input",
    }
    assert {line.get_label() for line in panel.get_lines()[1:]} == {
        "shaft order",
        "mesh order",
        "sideband order",
    }
    # the frequency ends above the last peak, far below half of the sampling rate
    assert 2000.0 / (2 * pi) < panel.get_xlim()[1] < 1.2 * 2000.0 / (2 * pi)
    # the names lie within the panel
    figure.draw_without_rendering()
    for text in panel.texts:
        assert text.get_window_extent().y1 < 1.02 * panel.bbox.y1


def test_bars_of_similar_orders_begin_at_zero():
    from gearbow.plotting.orders import orders

    (panel,) = orders(["1× input", "2× input"], np.array([2.0, 1.0]), "x [m]").axes
    assert panel.get_xscale() == "linear"
    assert panel.get_xlim()[0] == 0.0
    assert [text.get_text() for text in panel.texts] == ["2", "1"]
    # round-off does not widen a logarithmic scale
    (panel,) = orders(["1× input", "2× input"], np.array([2.0, 1e-18]), "x [m]").axes
    assert panel.get_xscale() == "log"
    assert panel.get_xlim()[0] == pytest.approx(1e-5)


@pytest.mark.parametrize(
    ("skip_time", "message"),
    [(-1.0, "must be from 0"), (0.063, "must be from 0"), (np.nan, "must be finite")],
)
def test_an_invalid_skip_time_is_an_error(skip_time, message):
    with pytest.raises(gb.SceneError, match=f"^skip_time: {message}"):
        response(TIME).plot("history", skip_time=skip_time)


def test_bearings_of_a_figure_are_places():
    run = response(TIME)
    with pytest.raises(gb.SceneError, match=r"^at\[0\]: must be \(shaft, position\), got 'g1'"):
        run.plot("bearings", ["g1"])
    run._data["bearings"] = []
    with pytest.raises(gb.GearbowError, match="no bearing was recorded"):
        run.plot("bearings")


def test_axes_are_given_by_keyword_everywhere():
    public = [getattr(module, name) for module in (gb, gb.results) for name in dir(module)]
    figures = {each.plot for each in public if hasattr(each, "plot")}
    assert len(figures) >= 10
    for figure in figures:
        kind = inspect.signature(figure).parameters["ax"].kind
        assert kind is inspect.Parameter.KEYWORD_ONLY, figure


def test_figures_of_a_frequency_response_have_the_unit_of_the_speeds():
    system, hit = hostile(), gb.Force(("input", 0.1), 1.0)
    speeds = np.array([50.0, 100.0])
    several = system.frequency_response([100.0, 400.0], source=hit, speed=gb.rpm(speeds * RPM))
    assert several.speed_unit == "rpm"
    upright = several.plot("g1", kind="waterfall").axes[0]
    assert upright.get_ylabel() == "speed of the reference shaft [rpm]"
    # the cells of the map reach half a distance beyond its speeds
    assert upright.get_ylim() == pytest.approx((25.0 * RPM, 125.0 * RPM))
    assert several.plot("g1", kind="waterfall", speed_unit="rad/s").axes[0].get_ylim() == (
        pytest.approx((25.0, 125.0))
    )
    labels = [line.get_label() for line in several.plot("g1").axes[0].get_lines()]
    assert [label.rpartition(", ")[2] for label in labels] == ["477.465 rpm", "954.93 rpm"]
    orders = system.frequency_response(source=hit, order=2.0, speeds=speeds)
    for unit, factor in (("rad/s", 1.0), ("rpm", RPM)):
        below = orders.plot("g1", speed_unit=unit).axes[-1]
        assert below.get_xlabel().endswith(f"[{unit}]")
        assert below.get_lines()[0].get_xdata() == pytest.approx(factor * speeds)
    with pytest.raises(gb.GearbowError, match=r"^speed_unit: must be one of rad/s, rpm, got 'Hz'"):
        orders.plot("g1", speed_unit="Hz")
