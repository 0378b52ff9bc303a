"""Labels, units and scales of all figures against a hand-written table."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gearbow as gb
from gearbow.plotting import campbell, orders
from gearbow.plotting.style import quantity
from reference import scenes
from reference.bows import HalfSine
from reference.figure_texts import check_texts
from reference.machines import jeffcott
from reference.records import MESH_UNITS, of_series, response

TIME = 1e-3 * np.arange(64)


def labels(figure) -> list[tuple[str, str]]:
    """Return the labels (x, y) of all panels."""
    return [(panel.get_xlabel(), panel.get_ylabel()) for panel in figure.axes]


def curves(panel) -> dict[str, np.ndarray]:
    """Return the points of the labelled lines of a panel, shape (k, 2)."""
    return {
        str(line.get_label()): np.asarray(line.get_xydata())
        for line in panel.get_lines()
        if not str(line.get_label()).startswith("_")
    }


class TestResponse:
    """Figures of a time history."""

    def test_orbits(self):
        made = response(TIME)
        figure = made.plot("orbits", ["g2", ("output", 0.3)])
        assert labels(figure) == [("y [µm]", "z [µm]")] * 2
        assert [panel.get_title() for panel in figure.axes] == ["g2", "output at 0.3 m"]
        path, end = figure.axes[0].get_lines()
        np.testing.assert_allclose(path.get_xydata(), 1e6 * made.displacement("g2"))
        np.testing.assert_allclose(end.get_xydata(), 1e6 * made.displacement("g2")[-1:])
        # all panels have axes of one length, which contain the orbits
        spans = [
            np.ptp(limits)
            for panel in figure.axes
            for limits in (panel.get_xlim(), panel.get_ylim())
        ]
        assert spans == pytest.approx([spans[0]] * 4)
        widest = max(
            np.ptp(1e6 * made.displacement(at), axis=0).max() for at in ("g2", ("output", 0.3))
        )
        assert widest < spans[0] < 1.2 * widest

    def test_the_transient_of_an_orbit_is_grey(self):
        made = response(TIME)
        early, late, _ = made.plot("orbits", ["g1"], skip_time=0.02).axes[0].get_lines()
        np.testing.assert_allclose(early.get_xydata(), 1e6 * made.displacement("g1")[:21])
        np.testing.assert_allclose(late.get_xydata(), 1e6 * made.displacement("g1")[20:])
        assert early.get_color() == "0.75"
        # the slowest shaft turns once in 2π/16 s = 0.393 s
        made = of_series(1e-3 * np.arange(501), np.zeros(501))
        early, late, _ = made.plot("orbits", ["g1"]).axes[0].get_lines()
        assert late.get_xydata().shape[0] == 393

    def test_history(self):
        made = response(TIME)
        figure = made.plot("history", ["g1", "wheel"])
        assert labels(figure) == [("", "g1 [µm]"), ("time [s]", "wheel [µm]")]
        for panel, name in zip(figure.axes, ("g1", "wheel"), strict=True):
            motion = 1e6 * made.displacement(name)
            mean = motion.mean(axis=0)
            for component, label in enumerate(("y − mean", "z − mean")):
                expected = np.column_stack([TIME, (motion - mean)[:, component]])
                np.testing.assert_allclose(curves(panel)[label], expected, atol=1e-9)
            v, w = (quantity(1e-6 * value, "m") for value in mean)
            assert panel.get_title(loc="right") == f"mean y {v}, z {w}"

    def test_twist(self):
        made = response(TIME)
        figure = made.plot("twist", ["g3"])
        assert labels(figure) == [("time [s]", "g3 [mrad]")]
        (line,) = figure.axes[0].get_lines()
        np.testing.assert_allclose(
            line.get_xydata(), np.column_stack([TIME, 1e3 * made.twist("g3")])
        )

    def test_the_transient_of_a_history_is_shaded(self):
        figure = response(TIME).plot("history", ["g1", "wheel"], skip_time=0.02)
        for panel in figure.axes:
            (shade,) = panel.patches
            assert shade.get_extents().transformed(panel.transData.inverted()).x1 == pytest.approx(
                0.02
            )

    def test_mesh(self):
        made = response(TIME)
        figure = made.plot("mesh", [("g3", "g4")])
        assert labels(figure) == [
            ("", "force [N]"),
            ("", "deflection [µm]"),
            ("time [s]", "stiffness [N/µm]"),
        ]
        assert figure.axes[0].get_title(loc="left") == "g3 – g4"
        mesh = made.mesh(("g3", "g4"))
        expected = (mesh.force, 1e6 * mesh.deflection, 1e-6 * mesh.stiffness)
        for panel, values in zip(figure.axes, expected, strict=True):
            np.testing.assert_allclose(panel.get_lines()[0].get_ydata(), values)

    def test_geometry(self):
        made = response(TIME)
        figure = made.plot("geometry", [("g3", "g4")])
        assert labels(figure) == [
            ("", "contact ratio"),
            ("", "pressure angle [°]"),
            ("", "line of centres [°]"),
            ("time [s]", "centre distance [mm]"),
        ]
        mesh = made.mesh(("g3", "g4"))
        degrees = 180.0 / np.pi
        expected = (
            mesh.contact_ratio,
            degrees * mesh.pressure_angle,
            degrees * mesh.centre_line_angle,
            1e3 * mesh.centre_distance,
        )
        for panel, values in zip(figure.axes, expected, strict=True):
            np.testing.assert_allclose(panel.get_lines()[0].get_ydata(), values)

    def test_bearings(self):
        made = response(TIME)
        figure = made.plot("bearings", ("output", 0.5))
        assert labels(figure) == [("time [s]", f"force along {axis} [N]") for axis in "yz"]
        assert figure.axes[0].get_title(loc="left") == "output at 0.5 m"
        for component, panel in enumerate(figure.axes):
            expected = np.column_stack([TIME, made.bearing_force(("output", 0.5))[:, component]])
            np.testing.assert_allclose(panel.get_lines()[0].get_xydata(), expected)
        assert len(made.plot("bearings").axes) == 4

    @pytest.mark.parametrize("kind", ["mesh", "bearings", "history", "twist"])
    def test_the_settled_part_sets_the_scale(self, kind: str):
        # the slowest shaft turns once in 2π/16 s = 0.393 s: the first 0.1 s precede the last turn
        time = 1e-3 * np.arange(501)
        signal = np.sin(100.0 * time)
        signal[:50] *= 1000.0
        made = response(
            time,
            mesh=dict.fromkeys(MESH_UNITS, np.column_stack([signal, signal])),
            bearing_force=np.tile(signal[:, np.newaxis, np.newaxis], (1, 2, 2)),
            displacement=1e-6 * np.tile(signal[:, np.newaxis, np.newaxis], (1, 4, 2)),
            twist=1e-3 * np.tile(signal[:, np.newaxis], (1, 4)),
        )
        for panel in made.plot(kind).axes:
            late = panel.get_lines()[0].get_ydata()[110:]
            assert np.ptp(late) < np.ptp(panel.get_ylim()) < 2.3 * np.ptp(late)
            assert "earlier −" in panel.get_title(loc="right")
        check_texts(made.plot(kind))
        for panel in made.plot(kind, skip_time=0.0).axes:
            values = panel.get_lines()[0].get_ydata()
            assert panel.get_ylim()[0] < values.min() < values.max() < panel.get_ylim()[1]
            assert "earlier" not in panel.get_title(loc="right")

    def test_spectrum(self):
        # y: 2 µm at 125 Hz, z: 5 µm at 250 Hz, both at spectral lines of the record
        motion = np.zeros((TIME.size, 4, 2))
        motion[:, 0, 0] = 2e-6 * np.cos(2 * np.pi * 125.0 * TIME)
        motion[:, 0, 1] = 5e-6 * np.cos(2 * np.pi * 250.0 * TIME)
        figure = response(TIME, displacement=motion).plot("spectrum", ["g1"])
        assert labels(figure) == [("frequency [Hz]", "g1 [µm]")]
        for label, frequency, amplitude in (("y", 125.0, 2.0), ("z", 250.0, 5.0)):
            line = curves(figure.axes[0])[label]
            assert line[np.argmax(line[:, 1])] == pytest.approx([frequency, amplitude])

    def test_energy_balance(self):
        balance = response(TIME).energy_balance()
        figure = balance.plot()
        assert labels(figure) == [
            ("", "energy [J]"),
            ("", "work [J]"),
            ("time [s]", "residual [J]"),
        ]
        energy, work, residual = (curves(panel) for panel in figure.axes)
        for drawn, terms, total in (
            (energy, ("kinetic", "shafts", "bearings", "meshes"), balance.total),
            (
                work,
                ("torque", "gravity", "drive", "unbalance", "teeth", "damping"),
                balance.work,
            ),
            (residual, (), balance.residual),
        ):
            assert set(drawn) == {*terms, "all"}
            for name in terms:
                np.testing.assert_array_equal(drawn[name][:, 1], getattr(balance, name))
            np.testing.assert_array_equal(drawn["all"][:, 1], total)


class TestOrders:
    """Figures of spectra, orders and waterfalls."""

    def test_spectrum(self):
        found = response(TIME).spectrum(("g1", "g2"), "stiffness")
        figure = found.plot()
        assert labels(figure) == [("frequency [Hz]", "g1/g2 stiffness [N/m]")]
        (line,) = figure.axes[0].get_lines()
        np.testing.assert_array_equal(
            line.get_xydata(), np.column_stack([found.frequencies_hz, found.amplitudes])
        )

    def test_bars_show_the_largest_orders(self):
        time = 1e-3 * np.arange(6000)
        content = {0.16: 5e-6, 0.4: 1e-6, 1.0: 3e-6}  # of output, middle, input
        made = of_series(time, sum(a * np.cos(100 * r * time) for r, a in content.items()))
        figure = made.orders("g1", "z", shaft_harmonics=2, mesh_harmonics=0).plot(2)
        (panel,) = figure.axes
        assert panel.get_xlabel() == "amplitude of g1 z [µm]"
        assert [bar.get_width() for bar in panel.patches] == pytest.approx([5.0, 3.0])
        hertz = 100.0 / (2 * np.pi)
        assert [text.get_text() for text in panel.get_yticklabels()] == [
            f"1× output ({0.16 * hertz:.4g} Hz)",
            f"1× input ({hertz:.4g} Hz)",
        ]

    def test_waterfall(self):
        speeds = 2 * np.pi * np.array([20.0, 40.0])
        time = 1e-3 * np.arange(500)
        runs = [of_series(time, 1e-6 * np.cos(s * time), s) for s in speeds]
        figure = gb.waterfall(runs, "g1", "z").plot(60.0)
        panel, bar = figure.axes
        assert labels(figure)[0] == ("frequency [Hz]", "speed of the reference shaft [rad/s]")
        assert bar.get_ylabel() == "g1 z [µm]"
        assert panel.get_xlim() == (0.0, 60.0)
        # a cell reaches half of the distance of the speeds beyond its own, and the lines cross it;
        # at 10 and 50 revolutions per second the input shaft is at 10 Hz and 50 Hz, the middle one
        # at 4 Hz and 20 Hz
        turns = np.array([10.0, 50.0])
        lines = [line.get_xydata() for line in panel.get_lines()]
        for ratio in (1.0, 0.4, 0.16):
            slope = 2 * np.pi / ratio
            own = [
                line for line in lines if np.allclose(*(line[~np.isnan(line[:, 0])] * [slope, 1]).T)
            ]
            assert len(own) == 1, ratio
            assert own[0][[0, -1], 1] == pytest.approx(2 * np.pi * turns)
            # only the input shaft is excited: its line does not cover its peaks at 20 Hz and 40 Hz
            hidden = np.isnan(own[0][:, 0])
            at = own[0][:, 1] / (2 * np.pi)
            assert hidden[np.abs(at - 20.0) < 0.5].all() == (ratio == 1.0)
            assert hidden.any() == (ratio == 1.0)
        # An order that leaves the panel at the right has its name inside, on its line.
        inside = gb.waterfall(runs, "g1", "z").plot(30.0).axes[0]
        (name,) = [text for text in inside.texts if text.get_text() == "1× input"]
        assert 0.0 < name.xy[0] < 30.0
        assert name.xy[1] == pytest.approx(2 * np.pi * name.xy[0])


class TestSpeed:
    """Figures over the speed."""

    def test_campbell(self):
        # large damping, so that 0.4 and 40 differ clearly
        system = jeffcott(damping=4e3)
        found = system.campbell([0.0, 100.0, 200.0, 300.0], count=4)
        figure = found.plot()
        assert labels(figure) == [
            ("", "frequency [Hz]"),
            ("speed of the reference shaft [rad/s]", "damping ratio [%]"),
        ]
        upper, lower = figure.axes
        drawn = np.concatenate([np.ravel(line.get_ydata()) for line in lower.get_lines()])
        for value in found.damping_ratios.flat:
            assert np.abs(drawn - 100.0 * value).min() <= 1e-12 * abs(100.0 * value)
        # the excitation by the shaft ends at 300 rad/s, which is 47.7 Hz
        ends = [
            tuple(line.get_xydata()[-1]) for line in upper.get_lines() if len(line.get_xdata()) == 2
        ]
        assert any(end == pytest.approx((300.0, 300.0 / (2 * np.pi))) for end in ends)

    @pytest.mark.parametrize("count", [1, 3])
    def test_critical_speed_map(self, count: int):
        found = scenes.v2().critical_speed_map([1e6, 1e7], order=2.0)
        figure = found.plot(count)
        assert labels(figure) == [
            ("stiffness of every bearing [N/m]", "critical speed of the reference shaft [rad/s]")
        ]
        assert figure.axes[0].get_title() == "excitation of the order 2"
        # forward and backward, and the stiffness of the system
        assert len(figure.axes[0].get_lines()) == 2 * count + 1
        for label in ("forward", "backward"):
            expected = np.column_stack([[1e6, 1e7], found.lines(label)[:, 0]])
            np.testing.assert_array_equal(curves(figure.axes[0])[label], expected)

    def test_bode(self):
        # the unbalance is at -2.5 rad: near the critical speed the phase passes -180 degrees
        system = jeffcott(eccentricity=1e-5 * np.exp(-2.5j))
        critical = abs(system.modes(count=1).eigenvalues[0])
        found = system.synchronous(critical * np.linspace(0.5, 2.0, 60))
        figure = found.bode(["disk"])
        assert labels(figure) == [
            ("", "phase [°]"),
            ("speed of the reference shaft [rad/s]", "amplitude [µm]"),
        ]
        phase = figure.axes[0].get_lines()[0].get_ydata()
        assert np.abs(np.diff(phase)).max() < 180.0
        ends = np.degrees(-2.5 + np.array([0.0, -np.pi]))
        assert phase[[0, -1]] == pytest.approx(ends, abs=2.0)  # damping of 0.8 %: 1.2° at 0.5 and 2
        # further points lie at the peak and its half-power points
        curve = figure.axes[1].get_lines()[0].get_xydata()
        amplitude = curve[np.isin(curve[:, 0], found.speeds), 1]
        np.testing.assert_allclose(amplitude, 1e6 * found.orbit("disk")[:, 0])

    def test_a_shaft_as_the_named_source(self):
        system = scenes.Geared(bows={"middle": HalfSine(1e-4, 0.5)}).package()
        found = system.synchronous(np.linspace(10.0, 300.0, 12))
        lower = found.bode(["g1"], source="middle").axes[1]
        np.testing.assert_allclose(lower.get_lines()[0].get_ydata(), 1e6 * found.orbit("g1")[:, 1])

    def test_synchronous(self):
        bows = {"input": HalfSine(1e-4), "output": HalfSine(5e-5)}
        found = scenes.Geared(bows=bows).package().synchronous([50.0, 100.0, 150.0])
        figure = found.plot(["g1", "g4"])
        assert labels(figure) == [
            ("", "g1 [µm]"),
            ("speed of the reference shaft [rad/s]", "g4 [µm]"),
        ]
        for panel, name in zip(figure.axes, ("g1", "g4"), strict=True):
            drawn = curves(panel)
            assert set(drawn) == {"input", "output"}
            for shaft, label in ((0, "input"), (2, "output")):
                expected = np.column_stack([found.speeds, 1e6 * found.orbit(name)[:, shaft]])
                np.testing.assert_allclose(drawn[label], expected)


def test_mode_shapes():
    # soft along y: the first bending mode moves along y, the second one along z
    rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=4)
    bearings = [gb.Bearing("rotor", x, stiffness=(1e7, 1e9)) for x in (0.0, 1.0)]
    modes = gb.RotorSystem([rotor], bearings=bearings, motion="lateral").modes(count=2)
    figure = modes.plot(count=2)
    assert labels(figure) == [("position [m]", "y (z dashed)")] * 2
    for mode, panel in enumerate(figure.axes):
        solid, dashed = panel.get_lines()
        assert (solid.get_linestyle(), dashed.get_linestyle()) == ("-", "--")
        moving, still = (solid, dashed) if mode == 0 else (dashed, solid)
        np.testing.assert_allclose(moving.get_xdata(), np.linspace(0.0, 1.0, 49))
        assert np.max(moving.get_ydata()) == pytest.approx(1.0)
        assert np.abs(still.get_ydata()).max() < 1e-6
        # one half wave, symmetric about the middle
        np.testing.assert_allclose(moving.get_ydata(), moving.get_ydata()[::-1], atol=1e-6)


@pytest.mark.parametrize(
    ("value", "unit", "digits", "text"),
    [
        (1.25e-3, "m", 3, "1.25 mm"),
        (70e-6, "m", 3, "70 µm"),
        (999.96e-6, "m", 3, "1 mm"),
        (4600.0, "m", 3, "4.6e+03 m"),
        (-1273.2, "N m", 4, "−1.273 kN m"),
        (490.0, "N m", 4, "490 N m"),
        (0.0, "N", 4, "0 N"),
        (3e-12, "s", 3, "0.003 ns"),
    ],
)
def test_quantities_have_the_prefix_of_their_magnitude(value, unit, digits, text):
    assert quantity(value, unit, digits) == text


def test_titles_of_modes_say_what_does_not_oscillate():
    rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=2)
    bearings = [gb.Bearing("rotor", x, stiffness=1e7) for x in (0.0, 1.0)]
    modes = gb.RotorSystem([rotor], bearings=bearings).modes(count=4)
    values = np.array([0.0, -50.0, 20.0, -10.0 + 2e4j])
    changed = replace(
        modes,
        eigenvalues=values,
        frequencies_hz=np.abs(values.imag) / (2.0 * np.pi),
        damping_ratios=np.array([1.0, 1.0, -1.0, 5e-4]),
        whirl=("rigid", "forward", "forward", "forward"),
    )
    figure = changed.plot(count=4)
    first = [panel.get_title().split("\n")[0] for panel in figure.axes]
    assert first == [
        "mode 1",
        "mode 2: overdamped, time constant 20 ms",
        "mode 3: growth without oscillation, time constant 50 ms",
        "mode 4: 3.183 kHz, forward, damping 0.05 %",
    ]
    check_texts(figure)


def test_what_is_not_excited_has_no_entry_in_a_bode_plot():
    system = scenes.Geared(bows={"middle": HalfSine(1e-4, 0.5)}).package()
    figure = system.synchronous([50.0, 100.0]).bode(["g1", "g2", "g4"])
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["g2"]
    assert figure.axes[0].get_title(loc="right") == "not excited: g1, g4"
    check_texts(figure)


@pytest.mark.parametrize("slopes", [(1.0, 0.5, 30.0, 30.0), (20.0, 21.0, 22.0, 23.0, 400.0)])
def test_names_of_excitation_lines_do_not_overlap(slopes: tuple[float, ...]):
    lines = [(f"{n}× teeth of pinion {n}–wheel {n}", slope) for n, slope in enumerate(slopes)]
    speeds, modes = np.array([10.0, 20.0, 30.0]), np.ones((3, 1))
    figure = campbell.campbell(
        speeds,
        50.0 * modes,
        0.01 * modes,
        np.full((3, 1), "forward"),
        lines=lines,
        intersections=(),
    )
    check_texts(figure)
    named = "\n".join(text.get_text() for text in figure.axes[0].texts)
    for name, slope in lines:
        # the line enters the panel, which begins at 10 rad/s and ends at 54 Hz
        assert (name in named) == (10.0 * slope / (2.0 * np.pi) < 54.0)


def test_critically_damped_modes_do_not_set_the_scale():
    speeds = np.array([10.0, 20.0])
    ratios = np.array([[0.01, 0.03, 0.9], [0.012, 0.03, 0.8]])
    kinds = np.full((2, 3), "forward")
    figure = campbell.campbell(speeds, 1e3 * ratios, ratios, kinds, lines=(), intersections=())
    lower = figure.axes[1]
    assert lower.get_ylim()[0] == 0.0
    assert 3.0 < lower.get_ylim()[1] < 4.0
    assert lower.get_title(loc="right") == "damping ratios above 20 % are beyond the scale"


def test_a_spectrum_names_only_orders_that_it_resolves():
    # lines at a distance of 1 Hz: tones closer than 2 Hz have one peak
    frequencies = np.arange(1.0, 200.0)
    amplitudes = np.full(199, 1e-6)
    amplitudes[[19, 99, 149]] = 1.0, 0.5, 0.2
    found = (
        ("1× input", 20.0),
        ("2× output", 21.5),
        ("1× mesh a–b", 100.0),
        # a sideband that is too close belongs to its tooth frequency
        ("1× mesh a–b + 1× output", 101.0),
        ("1× mesh c–d", 150.0),
        ("1× mesh c–d − 1× output", 148.0),
    )
    figure = orders.spectrum(frequencies, amplitudes, "g1 y [m]", orders=found)
    (panel,) = figure.axes
    assert {text.get_text() for text in panel.texts} == {"1× mesh\na–b ± sidebands", "1× mesh\nc–d"}
    assert panel.get_title(loc="right") == "orders closer than 2 Hz have no name of their own"
    check_texts(figure)


def test_a_spectrum_ends_60_db_below_its_largest_line():
    frequencies = np.arange(1.0, 200.0)
    amplitudes = np.full(199, 1e-9)
    amplitudes[[19, 59, 149]] = 1.0, 2e-3, 1e-4
    (panel,) = orders.spectrum(frequencies, amplitudes, "g1 y [m]", periodic=True).axes
    assert panel.get_ylim()[0] == pytest.approx(1e-3)
    assert panel.get_xlim()[1] == pytest.approx(1.1 * 60.0)


def test_long_names_leave_the_bars_most_of_a_figure():
    names = [
        f"1× mesh Cylindrical gear [{n}]–Cylindrical gear [{n + 1}] + 1× shaft" for n in (1, 3)
    ]
    figure = orders.orders(names, np.array([1.0, 0.5]), "amplitude [µm]")
    figure.draw_without_rendering()
    (panel,) = figure.axes
    assert panel.get_position().width > 0.55
    check_texts(figure)
