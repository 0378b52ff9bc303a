"""Figures show the numbers of their source objects and leave the matplotlib settings unchanged."""

from __future__ import annotations

import numpy as np
import pytest

import gearbow as gb
from gearbow.results.run_figures import PLOT_KINDS
from reference.machines import hostile
from reference.records import of_series
from test_response import recorded


def drawn(panel) -> list[np.ndarray]:
    """Return the ordinates of the lines of a panel."""
    return [np.asarray(line.get_ydata()) for line in panel.get_lines()]


@pytest.mark.parametrize("kind", list(PLOT_KINDS))
def test_every_kind_of_figure_has_labelled_axes(kind, tmp_path):
    figure = recorded().plot(kind)
    assert figure.axes
    columns = [axes for axes in figure.axes if axes.get_xlabel()]
    assert columns
    assert all(axes.get_ylabel().endswith("]") or kind == "geometry" for axes in figure.axes)
    assert all(axes.get_lines() for axes in figure.axes)
    figure.savefig(tmp_path / "figure.png")
    assert (tmp_path / "figure.png").stat().st_size > 1000


def test_an_orbit_is_the_displacement_in_micrometres():
    response = recorded()
    figure = response.plot("orbits", at=["g2"])
    (panel,) = figure.axes
    np.testing.assert_allclose(
        panel.get_lines()[0].get_xdata(), 1e6 * response.displacement("g2")[:, 0]
    )
    np.testing.assert_allclose(drawn(panel)[0], 1e6 * response.displacement("g2")[:, 1])
    assert panel.get_title() == "g2"


def test_labels_are_names_or_positions():
    response = recorded()
    assert [axes.get_title() for axes in response.plot("orbits").axes] == ["g1", "g2"]
    response._data["points"] = [(shaft, x, []) for shaft, x, _ in response._data["points"]]
    assert [axes.get_title() for axes in response.plot("orbits").axes] == [
        "input at 0.25 m",
        "output at 0.25 m",
        "input at 0.1 m",
    ]


def test_the_geometry_of_a_mesh_is_drawn_in_degrees():
    response = recorded()
    axes = np.reshape(response.plot("geometry").axes, (4, 2))
    for pair, panels in zip((("g4", "g5"), ("g1", "g2")), axes.T, strict=True):
        mesh = response.mesh(pair)
        for panel, values in zip(
            panels,
            (
                mesh.contact_ratio,
                np.degrees(mesh.pressure_angle),
                np.degrees(mesh.centre_line_angle),
                1e3 * mesh.centre_distance,
            ),
            strict=True,
        ):
            np.testing.assert_allclose(drawn(panel)[0], values)


def test_the_spectrum_of_a_sine_has_its_frequency_and_amplitude():
    response = recorded(rows=2000)
    response._data["time"] = 1e-3 * np.arange(2000)
    motion = np.zeros((2000, 3, 2))
    motion[:, 0, 0] = 5e-6 + 3e-6 * np.sin(2 * np.pi * 50.0 * response.time)
    response._data["displacement"] = motion
    (panel,) = response.plot("spectrum", at=["g1"]).axes
    line = panel.get_lines()[0]
    frequency, amplitude = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
    assert frequency[np.argmax(amplitude)] == pytest.approx(50.0)
    assert amplitude.max() == pytest.approx(3.0, rel=1e-3)


def test_the_spectrum_of_a_period_has_its_lines():
    # The second harmonic of a period is its second line, without a share of its neighbours.
    count, period = 64, 0.5
    time = period / count * np.arange(count)
    response = of_series(time, 3e-6 * np.cos(2.0 * np.pi * 2.0 * time / period))
    response.period = period
    found = response.spectrum("g1", "z")
    assert found.periodic
    np.testing.assert_allclose(found.amplitudes[:3], [0.0, 3e-6, 0.0], atol=1e-18)
    assert response.spectrum("g1", "z", window="hann").amplitudes[0] > 1e-6
    (panel,) = response.plot("spectrum", at=["g1"]).axes
    line = next(line for line in panel.get_lines() if line.get_label() == "z")
    x, y = np.array(line.get_xydata()).T
    assert x.tolist() == [4.0, 4.0, 4.0]
    assert y[1] == pytest.approx(3.0)


def test_a_spectrum_needs_equally_spaced_times():
    response = recorded()
    response._data["time"] = np.array([0.0, 0.1, 0.3, 0.4, 0.5])
    with pytest.raises(gb.GearbowError, match="equally spaced"):
        response.plot("spectrum")


def test_the_error_for_an_unknown_kind_lists_the_known_ones():
    with pytest.raises(gb.GearbowError, match="kind: must be one of orbits, history"):
        recorded().plot("pie")


def test_a_figure_without_data_is_an_error():
    response = recorded()
    response._data["meshes"] = []
    response._data["points"] = []
    with pytest.raises(gb.GearbowError, match="no mesh was recorded"):
        response.plot("mesh")
    with pytest.raises(gb.GearbowError, match="no motion was recorded"):
        response.plot("history")


def test_modes_and_synchronous_response_are_drawn(tmp_path):
    system = hostile()
    modes = system.modes(count=5)
    figure = modes.plot(count=4)
    assert len(figure.axes) == 4
    assert figure.axes[0].get_title() == "mode 1\nrigid-body rotation"
    for axes in figure.axes:
        assert max(np.abs(line).max() for line in drawn(axes)) == pytest.approx(1.0)
    synchronous = system.synchronous(np.linspace(10.0, 500.0, 20))
    drawing = synchronous.plot(["g1", ("output", 0.0)])
    lines = np.transpose(drawn(drawing.axes[0]))  # a line for each shaft
    np.testing.assert_allclose(lines, 1e6 * synchronous.orbit("g1"))
    for name, result in {"modes": figure, "synchronous": drawing}.items():
        result.savefig(tmp_path / f"{name}.png")


def test_an_energy_balance_omits_zero_terms():
    response = recorded()
    response._data["energy_terms"]["gravity"] = np.zeros(5)
    balance = response.energy_balance()
    energy, work, residual = balance.plot().axes
    assert [line.get_label() for line in energy.get_lines()] == [
        "kinetic",
        "shafts",
        "bearings",
        "meshes",
        "all",
    ]
    assert [line.get_label() for line in work.get_lines()] == [
        "torque",
        "drive",
        "unbalance",
        "teeth",
        "damping",
        "all",
    ]
    np.testing.assert_array_equal(drawn(work)[-1], balance.work)
    np.testing.assert_array_equal(drawn(residual)[0], balance.residual)
    assert all(axes.get_ylabel().endswith("[J]") for axes in (energy, work, residual))


def test_a_part_of_a_run_is_drawn():
    response = recorded(rows=10)
    first, last = float(response.time[2]), float(response.time[5])
    kinds = ("orbits", "history", "twist", "mesh", "geometry", "bearings")
    for kind in kinds[1:]:
        for panel in response.plot(kind, times=(first, last)).axes:
            np.testing.assert_array_equal(panel.get_lines()[0].get_xdata(), response.time[2:6])
    (panel, *_) = response.plot("orbits", times=(first, last)).axes
    assert panel.get_lines()[-2].get_xdata().size <= 4
    with pytest.raises(gb.SceneError, match=r"^times: .* is within the transient"):
        response.plot("mesh", times=(first, last), skip_time=float(response.time[-2]))
    with pytest.raises(gb.SceneError, match=r"^times: must be \(first, last\)"):
        response.plot("mesh", times=(first, last, last))  # type: ignore[arg-type]


def test_a_small_orbit_has_its_own_scale_and_a_place_without_twist_no_panel():
    response = recorded(rows=50)
    angle = np.linspace(0.0, 2.0 * np.pi, 50)
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    motion = np.stack([1e-4 * circle, 3e-5 * circle, 1e-6 * circle], axis=1)
    twist = np.column_stack([np.sin(angle), np.zeros(50), np.cos(angle)])
    response._data["displacement"], response._data["twist"] = motion, twist
    names = ["g1", "g2", ("input", 0.1)]
    large, middle, small = response.plot("orbits", names).axes
    assert np.ptp(large.get_xlim()) == pytest.approx(np.ptp(middle.get_xlim()))
    assert np.ptp(small.get_xlim()) == pytest.approx(1e-2 * np.ptp(large.get_xlim()))
    assert [text.get_text() for text in small.texts] == ["own scale"]
    assert not large.texts
    assert not middle.texts
    assert len(response.plot("twist", names).axes) == 3
    (panel,) = response.plot("twist").axes
    assert panel.get_ylabel() == "g1 [mrad]"


def test_round_off_is_no_line_of_a_campbell_diagram():
    shaft = gb.Shaft("rotor", length=0.5, outer_diameter=0.03, elements=4)
    bearings = [gb.Bearing("rotor", x, stiffness=1e7) for x in (0.0, 0.5)]
    diagram = gb.RotorSystem([shaft], bearings=bearings).campbell(np.linspace(0.0, 300.0, 5))
    lower = diagram.plot().axes[1]
    # Undamped modes have ratios of about 1e-17.
    assert lower.get_ylim()[1] >= 1e-3


def test_the_figure_of_a_film_has_the_journal_where_the_film_is_thinnest():
    bearing = gb.JournalBearing("s", 0.0, diameter=0.1, length=0.05, clearance=1e-4, viscosity=0.02)
    found = bearing.coefficients(load=5000.0, speed=300.0)
    across = found.plot().axes[0]
    (line,) = [line for line in across.get_lines() if line.get_label() == "journal centre"]
    (place,) = np.asarray(line.get_xdata()) + 1j * np.asarray(line.get_ydata())
    assert abs(place) == pytest.approx(found.eccentricity_ratio, rel=1e-9)
    (pad,) = found.pads
    thinnest = np.exp(1j * pad.angles[np.argmin(pad.thickness)])
    # The load is a weight. The film has a value every few degrees.
    assert place.imag < 0.0
    assert abs(np.angle(place / thinnest)) < 0.1
