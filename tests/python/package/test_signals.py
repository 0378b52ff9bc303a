"""Signals, spectra, orders and waterfalls against closed-form responses."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import gearbow as gb
from gearbow.orders import Kinematics
from gearbow.orders.spectrum import amplitudes, channel
from reference.records import ENERGIES, KINEMATICS, MESH_UNITS, WORKS, of_series, response

SPEED = 100.0  # rad/s
#: Coefficients of the windows, sums of cosines (Heinzel, Rüdiger and Schilling, 2002; flat top of
#: ISO 18431-2).
COSINES = {
    "none": [1.0],
    "hann": [0.5, 0.5],
    "flat top": [0.21557895, 0.41663158, 0.277263158, 0.083578947, 0.006947368],
}


class TestRecords:
    """A response returns the values of a name."""

    def test_each_name_gives_its_own_series(self):
        time = 2.0 + 0.1 * np.arange(6)
        made = response(time, speed=-30.0)
        data = made._data
        for point, names in enumerate((["g1"], ["g2"], ["g3", "wheel"], [("output", 0.3)])):
            for name in names:
                np.testing.assert_array_equal(
                    made.displacement(name), data["displacement"][:, point]
                )
                np.testing.assert_array_equal(made.twist(name), data["twist"][:, point])
        for bearing, place in enumerate((("input", 0.0), ("output", 0.5))):
            np.testing.assert_array_equal(
                made.bearing_force(place), data["bearing_force"][:, bearing]
            )
        for mesh, pair in enumerate((("g1", "g2"), ("g3", "g4"))):
            for quantity in MESH_UNITS:
                np.testing.assert_array_equal(
                    getattr(made.mesh(pair), quantity), data["mesh"][quantity][:, mesh]
                )
        np.testing.assert_array_equal(made.speeds, np.full(6, -30.0))

    def test_an_energy_balance_has_the_times_and_sums_of_the_run(self):
        made = response(2.0 + 0.1 * np.arange(6))
        balance, terms = made.energy_balance(), made._data["energy_terms"]
        np.testing.assert_array_equal(balance.time, made.time)
        total = np.sum([terms[name] for name in ENERGIES], axis=0)
        work = np.sum([terms[name] for name in WORKS], axis=0)
        np.testing.assert_allclose(balance.total, total, rtol=1e-14)
        np.testing.assert_allclose(balance.work, work, rtol=1e-14)
        np.testing.assert_allclose(
            balance.residual, total - total[0] - work + work[0], rtol=0.0, atol=1e-14
        )

    @pytest.mark.parametrize(
        ("of", "quantity", "unit", "find"),
        [
            ("g2", "y", "m", lambda r: r.displacement("g2")[:, 0]),
            ("g2", "z", "m", lambda r: r.displacement("g2")[:, 1]),
            ("g2", "twist", "rad", lambda r: r.twist("g2")),
            (("output", 0.3), "z", "m", lambda r: r.displacement(("output", 0.3))[:, 1]),
            (
                ("bearing", "output", 0.5),
                "y",
                "N",
                lambda r: r.bearing_force(("output", 0.5))[:, 0],
            ),
            (
                ("bearing", "output", 0.5),
                "z",
                "N",
                lambda r: r.bearing_force(("output", 0.5))[:, 1],
            ),
            ("energy", None, "J", lambda r: r.energy),
        ],
    )
    def test_a_channel_has_its_values_and_its_unit(self, of, quantity, unit, find):
        made = response(0.1 * np.arange(6))
        found = channel(made._to_record(), of, quantity)
        assert found.unit == unit
        np.testing.assert_array_equal(found.values, find(made))

    def test_channels_of_a_mesh(self):
        made = response(0.1 * np.arange(6))
        for quantity, unit in MESH_UNITS.items():
            found = channel(made._to_record(), ("g3", "g4"), quantity)
            assert found.unit == unit
            assert found.label == f"g3/g4 {quantity.replace('_', ' ')}"
            np.testing.assert_array_equal(found.values, made._data["mesh"][quantity][:, 1])
        # without a quantity: the force of a mesh, and the first component of the others
        assert channel(made._to_record(), ("g3", "g4")).label == "g3/g4 force"
        assert channel(made._to_record(), "g3").label == "g3 y"
        assert (
            channel(made._to_record(), ("bearing", "input", 0.0)).label == "bearing input at 0 m y"
        )


class TestSpectrum:
    """Return the lines of a windowed discrete Fourier transform."""

    @pytest.mark.parametrize("count", [120, 121])
    @pytest.mark.parametrize("window", list(COSINES))
    def test_every_line_of_a_cosine_on_a_line(self, window: str, count: int):
        step, line = 2e-3, 40
        values = 4.0 + 3.0 * np.cos(2 * np.pi * line * np.arange(count) / count + 0.3)
        frequency, found = amplitudes(step * np.arange(count), values, window)
        np.testing.assert_allclose(frequency, np.arange(1, count // 2 + 1) / (count * step))
        # a window a0 - a1 cos x + a2 cos 2x ... spreads a line over its neighbours by a_n / (2 a0)
        expected = np.zeros(count // 2)
        expected[line - 1] = 3.0
        for n, a in enumerate(COSINES[window][1:], start=1):
            for neighbour in (line - n, line + n):
                expected[neighbour - 1] = 3.0 * a / (2 * COSINES[window][0])
        np.testing.assert_allclose(found, expected, atol=1e-12)

    def test_the_line_at_the_nyquist_frequency(self):
        # 3 (-1)^n; this line is its own mirror image, so it must not count twice
        time = 1e-3 * np.arange(64)
        frequency, found = amplitudes(time, 3.0 * (-1.0) ** np.arange(64), "none")
        assert frequency[-1] == pytest.approx(500.0)
        assert found[-1] == pytest.approx(3.0, rel=1e-12)
        # an odd number of times has no such line: the last one is an ordinary cosine
        time = 1e-3 * np.arange(65)
        frequency, found = amplitudes(time, 3.0 * np.cos(2 * np.pi * 32 * np.arange(65) / 65))
        assert frequency[-1] == pytest.approx(32 / 0.065)
        found = amplitudes(time, 3.0 * np.cos(2 * np.pi * 32 * np.arange(65) / 65), "none")[1]
        assert found[-1] == pytest.approx(3.0, rel=1e-12)

    def test_a_fast_sine_leaves_nothing_at_low_frequencies(self):
        # between two lines, its plain mean is 6e-3; a Hann window leaks as 1 / distance^3 only
        time = 1e-3 * np.arange(1000)
        _, found = amplitudes(time, 2.0 + np.sin(2 * np.pi * 50.5 * time), "hann")
        assert found[:10].max() < 1e-4

    @pytest.mark.parametrize("window", list(COSINES))
    def test_the_window_reaches_the_spectrum_of_a_response(self, window: str):
        time = 1e-3 * np.arange(200)
        made = of_series(time, 2e-6 * np.cos(2 * np.pi * 50.0 * time))
        found = made.spectrum("g1", "z", window=window)
        direct = amplitudes(time, made.displacement("g1")[:, 1], window)
        np.testing.assert_array_equal(found.frequencies_hz, direct[0])
        np.testing.assert_array_equal(found.amplitudes, direct[1])
        ratio = found.amplitudes[10] / found.amplitudes[9]  # line 10 is 50 Hz
        a = [*COSINES[window], 0.0]
        assert ratio == pytest.approx(a[1] / (2 * a[0]), abs=1e-9)
        assert np.abs(made.spectrum("g1", "y", window=window).amplitudes).max() == 0.0

    def test_the_default_window_is_hann(self):
        time = 1e-3 * np.arange(200)
        made = of_series(time, 2e-6 * np.cos(2 * np.pi * 50.0 * time))
        expected = amplitudes(time, made.displacement("g1")[:, 1], "hann")[1]
        direct = amplitudes(time, made.displacement("g1")[:, 1])[1]
        for found in (
            direct,
            made.spectrum("g1", "z").amplitudes,
            gb.waterfall([made], "g1", "z").amplitudes[0],
        ):
            np.testing.assert_array_equal(found, expected)

    @pytest.mark.parametrize("window", list(COSINES))
    def test_several_signals_have_one_spectrum_each(self, window: str):
        time = 1e-3 * np.arange(200)
        both = np.stack([np.cos(300.0 * time), 2.0 + np.sin(700.0 * time)], axis=1)
        found = amplitudes(time, both, window)[1]
        assert found.shape == (100, 2)
        for column in range(2):
            alone = amplitudes(time, both[:, column], window)[1]
            np.testing.assert_allclose(found[:, column], alone, atol=1e-14)

    def test_unequal_steps_are_refused(self):
        # one time in a hundred is late by 0.1 % of a step
        time = 1e-3 * np.arange(100)
        time[50] += 1e-6
        with pytest.raises(gb.GearbowError, match="equally spaced"):
            of_series(time, np.cos(time)).spectrum("g1", "z")


class TestOrders:
    """Least squares on the orders of a train."""

    def test_the_initial_time_is_skipped(self):
        # a transient that ends at 3.5 s of a record from 3 s to 6 s, and a steady order after it
        time = 3.0 + 1e-3 * np.arange(3001)
        steady = 2e-6 * np.cos(SPEED * time - 0.7)
        made = of_series(time, steady + np.where(time < 3.5, 1e-6, 0.0))
        asked = {"shaft_harmonics": 1, "mesh_harmonics": 0}
        found = made.orders("g1", "z", skip_time=0.501, **asked)
        assert found.rest < 1e-15
        assert abs(found.mean) < 1e-15
        assert found.amplitude("1× input") == pytest.approx(2e-6, rel=1e-9)
        # the fit is wrong if it includes a part of the transient
        assert made.orders("g1", "z", skip_time=0.4, **asked).rest > 1e-7
        assert made.orders("g1", "z", **asked).rest > 3e-7

    @pytest.mark.parametrize("speed", [SPEED, -SPEED])
    def test_amplitude_phase_mean_and_residual(self, speed: float):
        time = 0.37 + 1e-3 * np.arange(6000)
        amplitude = -1e-6 + 2e-6j
        angle = np.abs(response(time, speed).angle("input"))
        stray = 1e-8 * np.cos(3.33 * SPEED * time)
        series = 5e-6 + np.real(amplitude * np.exp(1j * angle)) + stray
        made = of_series(time, series, speed)
        found = made.orders("g1", "z", shaft_harmonics=2, mesh_harmonics=0)
        names = [order.names[0] for order in found.orders]
        assert np.all(found.frequencies_hz > 0.0)
        at = names.index("1× input")
        assert found.frequencies_hz[at] == pytest.approx(SPEED / (2 * np.pi), rel=1e-12)
        # the record has no whole number of periods of the additional signal: its spectral leakage
        # is a few percent
        assert found.amplitudes[at] == pytest.approx(amplitude, abs=1e-9)
        assert found.amplitude("1× input") == pytest.approx(abs(amplitude), abs=1e-9)
        assert found.mean == pytest.approx(5e-6, abs=1e-9)
        assert found.rest == pytest.approx(1e-8 / np.sqrt(2.0), rel=0.02)

    def test_the_numbers_of_harmonics_and_sidebands(self):
        time = 5e-4 * np.arange(12000)
        made = of_series(time, np.cos(SPEED * time))
        found = made.orders("g1", "z", shaft_harmonics=1, mesh_harmonics=2, sidebands=0)
        assert {name for order in found.orders for name in order.names} == {
            "1× input", "1× middle", "1× output",
            "1× mesh g1–g2", "2× mesh g1–g2", "1× mesh g3–g4", "2× mesh g3–g4",
        }  # fmt: skip
        found = made.orders("g1", "z", shaft_harmonics=3, mesh_harmonics=0, sidebands=0)
        assert {name for order in found.orders for name in order.names} == {
            f"{n}× {shaft}" for n in (1, 2, 3) for shaft in ("input", "middle", "output")
        }

    def test_the_default_orders(self):
        # four harmonics of each shaft, three of each mesh, one sideband of each of its shafts
        time = 5e-4 * np.arange(24000)
        found = of_series(time, np.cos(SPEED * time)).orders("g1", "z")
        names = {name for order in found.orders for name in order.names}
        expected = {f"{n}× {shaft}" for n in range(1, 5) for shaft in ("input", "middle", "output")}
        for pair, shafts in (("g1–g2", ("input", "middle")), ("g3–g4", ("middle", "output"))):
            for m in (1, 2, 3):
                expected.add(f"{m}× mesh {pair}")
                expected |= {f"{m}× mesh {pair} {s} 1× {shaft}" for s in "+−" for shaft in shafts}
        assert names == expected
        assert names == {name for order in KINEMATICS.orders() for name in order.names}

    @pytest.mark.parametrize("count", [7, 8])
    def test_there_are_more_times_than_unknowns(self, count: int):
        # three orders and a mean are seven unknowns
        time = np.linspace(0.0, 10.0, count)
        made = of_series(time, np.cos(2.0 * time), speed=2.0)
        with warnings.catch_warnings():
            warnings.simplefilter("error" if count == 8 else "ignore")
            found = made.orders("g1", "z", shaft_harmonics=1, mesh_harmonics=0)
        assert len(found.orders) == (3 if count == 8 else 2)

    @pytest.mark.parametrize("name", ["shaft_harmonics", "mesh_harmonics", "sidebands"])
    def test_a_negative_number_is_refused(self, name: str):
        time = 1e-3 * np.arange(100)
        with pytest.raises(gb.SceneError, match=f"{name}: must be at least 0, got -1"):
            of_series(time, time).orders("g1", "z", **{name: -1})

    def test_a_table_has_the_values_in_its_columns(self):
        time = 1e-3 * np.arange(6000)
        made = of_series(time, 3.0 * np.sin(SPEED * time) + 2.0 * np.sin(0.4 * SPEED * time))
        table = made.orders("g1", "z", shaft_harmonics=1, mesh_harmonics=0).table()
        assert table.splitlines()[1].split("  ")[:3] == [
            "order",
            "frequency [Hz]",
            "amplitude [µm]",
        ]
        first, second = (line.split()[:3] for line in table.splitlines()[2:4])
        assert [float(x) for x in first] == pytest.approx([1.0, SPEED / (2 * np.pi), 3e6], rel=1e-3)
        assert [float(x) for x in second] == pytest.approx(
            [0.4, 0.4 * SPEED / (2 * np.pi), 2e6], rel=1e-3
        )

    def test_the_record_must_be_fine_enough(self):
        # the order of 1 is 15.9 Hz: a step of half its period is the limit
        limit = np.pi / SPEED
        asked = {"shaft_harmonics": 1, "mesh_harmonics": 0}
        for step in (1.01 * limit, 1.9 * limit):
            time = step * np.arange(400)
            with pytest.warns(gb.AccuracyWarning, match="less than two samples in a period"):
                of_series(time, np.cos(SPEED * time)).orders("g1", "z", **asked)
        time = 0.99 * limit * np.arange(400)
        found = of_series(time, np.cos(SPEED * time)).orders("g1", "z", **asked)
        assert found.amplitude("1× input") == pytest.approx(1.0, rel=1e-9)
        # the largest step is decisive
        time = np.concatenate([1e-3 * np.arange(4000), [4.0 + 1.1 * limit]])
        with pytest.warns(gb.AccuracyWarning, match="less than two samples in a period"):
            of_series(time, np.cos(SPEED * time)).orders("g1", "z", **asked)

    def test_the_record_must_be_long_enough(self):
        # the closest orders are 0 and 0.16: the limit is half a period of their difference
        period = 2 * np.pi / (0.16 * SPEED)
        asked = {"shaft_harmonics": 1, "mesh_harmonics": 0}
        time = 3.0 + np.linspace(0.0, 0.49 * period, 500)
        with pytest.warns(
            gb.AccuracyWarning, match="'1× output' cannot be separated from the mean"
        ):
            of_series(time, np.cos(SPEED * time)).orders("g1", "z", **asked)
        time = np.linspace(0.0, 0.51 * period, 500)
        found = of_series(time, np.cos(SPEED * time)).orders("g1", "z", **asked)
        assert found.amplitude("1× input") == pytest.approx(1.0, rel=1e-6)


class TestKinematics:
    """Orders of a train by hand."""

    def test_every_order_and_its_names(self):
        found = {
            name: order.value
            for order in KINEMATICS.orders(shaft_harmonics=2, mesh_harmonics=2, sidebands=2)
            for name in order.names
        }
        expected = {
            f"{n}× {shaft}": n * ratio
            for n in (1, 2)
            for shaft, ratio in (("input", 1.0), ("middle", 0.4), ("output", 0.16))
        }
        for pair, tooth, shafts in (
            ("g1–g2", 20.0, {"input": 1.0, "middle": 0.4}),
            ("g3–g4", 8.0, {"middle": 0.4, "output": 0.16}),
        ):
            for m in (1, 2):
                expected[f"{m}× mesh {pair}"] = m * tooth
                for n in (1, 2):
                    for shaft, ratio in shafts.items():
                        expected[f"{m}× mesh {pair} + {n}× {shaft}"] = m * tooth + n * ratio
                        expected[f"{m}× mesh {pair} − {n}× {shaft}"] = m * tooth - n * ratio
        assert found == pytest.approx(expected, rel=1e-9)

    def test_negative_sidebands_are_omitted(self):
        few = Kinematics(shafts=(("a", 1.0), ("b", 1.0)), meshes=(("p", "q", "a", "b", 2.5),))
        values = [order.value for order in few.orders(0, 1, 4)]
        assert values == pytest.approx([0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5])

    def test_of_a_system_whose_reference_is_the_slow_shaft(self):
        system = gb.RotorSystem(
            shafts=[
                gb.Shaft(name, length=0.5, outer_diameter=0.05, elements=2)
                for name in ("fast", "slow")
            ],
            gears=[
                gb.Gear("pinion", "fast", 0.25, 20, module=3e-3, face_width=0.03),
                gb.Gear("wheel", "slow", 0.25, 50, module=3e-3, face_width=0.03),
            ],
            meshes=[gb.Mesh("pinion", "wheel", stiffness=2e8)],
            bearings=[
                gb.Bearing(shaft, x, stiffness=1e8)
                for shaft in ("fast", "slow")
                for x in (0.0, 0.5)
            ],
            reference="slow",
        )
        found = Kinematics.of(system)
        assert dict(found.shafts) == pytest.approx({"fast": -2.5, "slow": 1.0})
        ((*names, tooth),) = found.meshes
        assert names == ["pinion", "wheel", "fast", "slow"]
        assert tooth == pytest.approx(50.0)


class TestWaterfall:
    """Spectra of several runs."""

    @pytest.mark.parametrize("window", list(COSINES))
    def test_spectra_belong_to_their_speeds(self, window: str):
        # backward rotation has the same frequencies as forward rotation
        time = 1e-3 * np.arange(500)
        lines = {2 * np.pi * 70.0: 3e-6, -2 * np.pi * 20.0: 1e-6, 2 * np.pi * 40.0: 2e-6}
        runs = [of_series(time, a * np.cos(s * time), s) for s, a in lines.items()]
        found = gb.waterfall(runs, "g1", "z", window=window)
        np.testing.assert_allclose(found.speeds, 2 * np.pi * np.array([20.0, 40.0, 70.0]))
        np.testing.assert_allclose(found.frequencies_hz, 2.0 * np.arange(1, 251))
        expected = np.zeros((3, 250))
        for row, (line, a) in enumerate(((10, 1e-6), (20, 2e-6), (35, 3e-6))):
            expected[row, line - 1] = a
            for n, part in enumerate(COSINES[window][1:], start=1):
                for neighbour in (line - n, line + n):
                    expected[row, neighbour - 1] = a * part / (2 * COSINES[window][0])
        np.testing.assert_allclose(found.amplitudes, expected, atol=1e-14)
        assert (found.label, found.unit) == ("g1 z", "m")
        assert found.kinematics == KINEMATICS

    def test_runs_with_different_spectral_lines_are_refused(self):
        runs = [of_series(step * np.arange(100), np.zeros(100)) for step in (1e-3, 1.01e-3)]
        with pytest.raises(gb.GearbowError, match="different frequencies"):
            gb.waterfall(runs, "g1")
