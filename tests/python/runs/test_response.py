"""Simulation requests: times, records, continuation, errors with partial results."""

from __future__ import annotations

import io
import signal
import threading
from contextlib import redirect_stderr

import numpy as np
import pytest

import gearbow as gb
from reference.cases import each_case
from reference.machines import bowed_pair, distance_without_play, hostile

FIELDS = (
    "deflection",
    "force",
    "stiffness",
    "pressure_angle",
    "centre_distance",
    "centre_line_angle",
    "contact_ratio",
    "pairs_in_contact",
    "thrust",
    "friction_force",
    "friction_power",
)
TERMS = (
    "kinetic",
    "shafts",
    "bearings",
    "meshes",
    "torque",
    "gravity",
    "drive",
    "unbalance",
    "teeth",
    "damping",
)


def recorded(rows: int = 5, energy: bool = True) -> gb.Response:
    """Return a response with arbitrary numbers and every kind of data."""
    numbers = np.random.default_rng(7)
    state = numbers.standard_normal(6)
    return gb.Response(
        {
            "time": 0.1 * np.arange(rows, dtype=np.float64),
            "points": [("input", 0.25, ["g1"]), ("output", 0.25, ["g2"]), ("input", 0.1, [])],
            "displacement": 1e-5 * numbers.standard_normal((rows, 3, 2)),
            "twist": numbers.standard_normal((rows, 3)),
            "bearings": [("output", 0.3), ("input", 0.0)],
            "bearing_force": numbers.standard_normal((rows, 2, 2)),
            "rolling_bearings": [],
            "sections": [("input", 0.1, "before"), ("input", 0.1, "beyond")],
            "section_force": np.random.default_rng(8).standard_normal((rows, 2, 3)),
            "section_moment": np.random.default_rng(9).standard_normal((rows, 2, 3)),
            "rolling_contact": np.empty((rows, 0, 2)),
            "meshes": [("g4", "g5"), ("g1", "g2")],
            "mesh": {name: numbers.standard_normal((rows, 2)) for name in FIELDS},
            "energy": numbers.standard_normal(rows) if energy else None,
            "energy_terms": (
                {name: numbers.standard_normal(rows) for name in TERMS} if energy else None
            ),
            "events": [(0.1 + 0.2, "g1", "g2", "separation"), (1 / 3, "g1", "g2", "contact")],
            "final": {
                "method": "rk45",
                "time": 0.1 + 0.2,
                "origin": 0.0,
                "speed": 100.0 / 3.0,
                "anchor": [0.0, 1 / 3, 1e-17],
                "geometry": "live",
                "setting": 1e-6,
                "count": 2**62 + 1,
                "elapsed": 0.1 + 0.2 - 1e-7,
                "carry": -1e-17,
                "next_step": 1e-5,
                "previous_error": float("inf"),
                "contact_modes": np.array([2**53 + 1, -1], dtype=np.int64),
                "memory": np.empty(0),
                "state": state,
            },
            "statistics": {
                "steps": 4,
                "rejected": 1,
                "evaluations": 30,
                "events": 0,
                "step_min": 1e-7,
                "step_max": float("inf"),
                "omega_max": 1e5 / 3.0,
                "limited_by": "stability",
                "condition": 1.5,
            },
        },
        speed=100.0 / 3.0,
    )


@pytest.mark.parametrize("speed", [100.0, -100.0])
def test_array_shapes_and_mesh_geometry(speed: float):
    system = hostile()
    response = system.simulate(
        2e-3, speed, output_step=1e-4, record=["gears", "meshes", "bearings", "energy"]
    )
    rows = 21
    assert response.time.shape == (rows,)
    assert response.displacement("g1").shape == (rows, 2)
    assert response.twist("g2").shape == (rows,)
    assert response.bearing_force(("output", 0.3)).shape == (rows, 2)
    assert response.energy.shape == (rows,)
    gears = {gear.name: gear for gear in system.gears}
    for given in system.meshes:
        pair = given.driver, given.driven
        mesh = response.mesh(pair)
        for field in FIELDS:
            assert getattr(mesh, field).shape == (rows,)
        rest = distance_without_play(*(gears[name] for name in pair))
        angle = given.centre_line_angle
        apart = rest * np.exp(1j * angle)
        for name, sign in zip(pair, (-1.0, 1.0), strict=True):
            # the centre of the base circle turns with the shaft and its twist
            turned = response.angle(gears[name].shaft) + response.twist(name)
            moved = response.displacement(name) @ [1.0, 1j]
            apart = apart + sign * (moved + gears[name].runout * np.exp(1j * turned))
        # round-off of an iterated centre distance
        np.testing.assert_allclose(mesh.centre_distance, np.abs(apart), rtol=1e-12)
        direction = np.exp(1j * mesh.centre_line_angle)
        np.testing.assert_allclose(direction, apart / np.abs(apart), atol=1e-12)
    assert response.speed == speed
    assert response.statistics.steps > 0
    assert response.statistics["steps"] == response.statistics.steps
    assert response.statistics.evaluations >= 4 * response.statistics.steps


def test_a_place_is_found_by_name_and_by_position():
    response = bowed_pair().simulate(
        1e-3, 100.0, record=["g1", ("input", 0.5), ("input", np.float64(0.25))]
    )
    np.testing.assert_array_equal(
        response.displacement(("input", 0.25 + 1e-13)), response.displacement("g1")
    )
    assert not np.array_equal(response.displacement(("input", 0.5)), response.displacement("g1"))
    assert "g1" in response.recorded
    assert ("input", 0.5) in response.recorded


@each_case(
    ("ask", "record"),
    [
        (lambda r: r.displacement("wheel"), "record=['wheel', ...]"),
        (lambda r: r.twist(("input", 0.2)), "record=[('input', 0.2), ...]"),
        (lambda r: r.bearing_force(("input", 0.5)), "record=[('bearing', 'input', 0.5), ...]"),
        (lambda r: r.mesh(("g1", "g3")), "record=[('g1', 'g3'), ...]"),
        (lambda r: r.energy, "record=['energy', ...]"),
        (lambda r: r.energy_balance(), "record=['energy', ...]"),
    ],
)
def test_the_error_says_how_to_record_a_missing_quantity(ask, record):
    with pytest.raises(gb.ChannelError) as caught:
        ask(recorded(energy=False))
    assert record in str(caught.value)
    listed = "'g1', 'g2', ('input', 0.1), ('g4', 'g5'), ('g1', 'g2'), ('bearing', 'output', 0.3)"
    assert listed in str(caught.value)
    assert isinstance(caught.value, KeyError)
    assert isinstance(caught.value, gb.GearbowError)


def test_a_mesh_has_its_gears_in_either_order():
    response = recorded()
    force = response.mesh(("g1", "g2")).force
    for at in (("g2", "g1"), "g1/g2", "g2/g1", ["g1", "g2"]):
        np.testing.assert_array_equal(response.mesh(at).force, force)
        assert response.spectrum(at).label == "g1/g2 force"
    with pytest.raises(gb.SceneError, match=r'^at: must be \(driver, driven\) or "driver/driven"'):
        response.mesh("g1")
    with pytest.raises(gb.SceneError, match=r"^at: must be \(shaft, position\), got 'g1'"):
        response.bearing_force("g1")  # type: ignore[arg-type]
    with pytest.raises(gb.SceneError, match=r"^at: must be a name or \(shaft, position\)"):
        response.displacement(("g1", "g2"))  # type: ignore[arg-type]


def test_events_belong_to_one_mesh():
    response = recorded()
    assert len(set(response.mesh("g1/g2").contact)) == 3
    assert len(set(response.mesh("g4/g5").contact)) == 1
    assert response.contact_shares("g4/g5").drive == 1.0


def test_a_recorded_quantity_can_be_requested_again():
    system = hostile()
    first = system.simulate(
        1e-3, -100.0, record=["gears", "meshes", "bearings", "energy", ("input", 0.0)]
    )
    again = system.simulate(1e-3, -100.0, record=first.recorded)
    assert set(again.recorded) == set(first.recorded)
    assert len(first.recorded) == 5 + 3 + 8 + 1 + 1


class TestTimes:
    """Times of the user are returned unchanged."""

    def test_outputs_have_the_order_of_the_times(self):
        system = hostile()
        wanted = [1e-3, 0.0, 3.3333e-4, 1e-3, 7.7e-4, 0.0]
        response = system.simulate(
            1e-3, 100.0, times=wanted, record=["gears", "meshes", "bearings", "energy"]
        )
        np.testing.assert_array_equal(response.time, wanted)
        ordered = system.simulate(
            1e-3, 100.0, times=sorted(set(wanted)), record=["gears", "meshes", "energy"]
        )
        rows = np.searchsorted(ordered.time, wanted)
        np.testing.assert_array_equal(response.displacement("g1"), ordered.displacement("g1")[rows])
        np.testing.assert_array_equal(response.energy, ordered.energy[rows])
        np.testing.assert_array_equal(
            response.energy_balance().drive, ordered.energy_balance().drive[rows]
        )
        np.testing.assert_array_equal(
            response.mesh(("g1", "g2")).force, ordered.mesh(("g1", "g2")).force[rows]
        )
        assert np.unique(ordered.displacement("g1"), axis=0).shape[0] == 4

    @pytest.mark.parametrize(
        ("duration", "step", "start", "count"),
        [
            (0.3, 0.1, 0.0, 4),
            (0.7, 0.1, 0.0, 8),
            (1e-3, 3e-4, 0.0, 4),
            (0.3, 0.1, 1e6, 4),
            (1.0, 1.0, 0.0, 2),
        ],
    )
    def test_a_time_grid_contains_its_end_if_a_step_ends_there(self, duration, step, start, count):
        from gearbow._times import grid

        times = grid(start, duration, step)
        assert times.size == count
        np.testing.assert_array_equal(times[:-1], start + step * np.arange(count - 1))
        assert times[-1] <= start + duration

    def test_the_end_is_recorded(self):
        response = bowed_pair().simulate(3e-4, 100.0, output_step=1e-4, start=0.5)
        np.testing.assert_allclose(response.time, [0.5, 0.5001, 0.5002, 0.5003], rtol=0, atol=1e-15)

    def test_times_and_output_step_exclude_each_other(self):
        with pytest.raises(gb.SceneError, match=r"^times: .*output_step"):
            bowed_pair().simulate(1e-3, 100.0, times=[0.0], output_step=1e-4)

    @pytest.mark.parametrize("step", [0.0, -1e-4, float("nan"), float("inf")])
    def test_an_invalid_output_step_is_an_error(self, step):
        with pytest.raises(gb.SceneError, match=r"^output_step"):
            bowed_pair().simulate(1e-3, 100.0, output_step=step)

    @pytest.mark.parametrize("duration", [-1.0, float("nan"), float("inf")])
    def test_an_invalid_duration_is_an_error(self, duration):
        with pytest.raises(gb.SceneError, match=r"^duration"):
            bowed_pair().simulate(duration, 100.0)

    def test_a_run_of_zero_duration_gives_its_initial_state(self):
        response = bowed_pair().simulate(0.0, 100.0, start=0.5)
        np.testing.assert_array_equal(response.time, [0.5])
        assert np.hypot(*response.displacement("g1")[0]) > 1e-5

    @pytest.mark.parametrize("times", [[-1e-4], [2e-3], [0.0, float("nan")]])
    def test_times_outside_the_run(self, times):
        with pytest.raises(gb.SceneError, match=r"^times"):
            bowed_pair().simulate(1e-3, 100.0, times=times)


@each_case(
    ("options", "text"),
    [
        ({"speed": "fast"}, "^speed: must be a number, .* got 'fast'"),
        ({"duration": None}, "^duration: must be a number"),
        ({"output_step": "fine"}, "^output_step: must be a number"),
        ({"times": ["never"]}, r"^times\[0\]: must be a number"),
        ({"initial": 5}, "^initial: must be a name or a response, got 5"),
        ({"initial": "middle"}, "^initial: must be .*middle"),
        ({"start": "now"}, "^start: must be a number"),
        ({"step": "small"}, "^step: must be a number"),
        ({"rtol": 0.0}, "^rtol"),
        ({"method": "euler"}, "^method: .*euler"),
        ({"geometry": "round"}, "^geometry: .*round"),
        ({"record": ["g9"]}, r"^record\[0\]: .*g9"),
    ],
)
def test_the_error_names_the_invalid_argument(options, text):
    with pytest.raises(gb.SceneError, match=text):
        bowed_pair().simulate(**{"duration": 1e-3, "speed": 100.0, **options})


class TestContinuation:
    """Continuation of a run from a response."""

    def test_two_halves_equal_the_whole_run(self):
        system = hostile()
        whole = system.simulate(2e-3, 100.0, output_step=1e-4, rtol=1e-9)
        half = system.simulate(1e-3, 100.0, output_step=1e-4, rtol=1e-9)
        rest = system.simulate(1e-3, 100.0, output_step=1e-4, rtol=1e-9, initial=half)
        np.testing.assert_allclose(rest.time, whole.time[10:], rtol=1e-12)
        scale = np.ptp(whole.displacement("g1"))
        assert scale > 0.0
        error = np.abs(rest.displacement("g1") - whole.displacement("g1")[10:]).max()
        assert error < 1e-6 * scale

    def test_the_final_state_is_sufficient(self):
        system = hostile()
        half = system.simulate(1e-3, 100.0)
        a, b = (system.simulate(1e-3, 100.0, initial=initial) for initial in (half, half.final))
        assert a.displacement("g1").tobytes() == b.displacement("g1").tobytes()

    def test_a_continued_run_has_no_start_argument(self):
        system = bowed_pair()
        half = system.simulate(1e-3, 100.0)
        with pytest.raises(gb.SceneError, match=r"^start"):
            system.simulate(1e-3, 100.0, initial=half, start=0.0)


class TestProgress:
    """Progress reports, and partial results of a run that ends early."""

    def test_a_callback_receives_the_fraction(self):
        seen: list[float] = []
        bowed_pair().simulate(0.3, 100.0, output_step=1e-2, progress=seen.append)
        assert len(seen) >= 1
        assert seen == sorted(seen)
        assert all(0.0 <= fraction <= 1.0 for fraction in seen)

    def test_progress_true_shows_a_bar(self):
        with redirect_stderr(io.StringIO()) as text:
            bowed_pair().simulate(1e-2, 100.0, progress=True)
        assert "100%" in text.getvalue()
        assert "/0.01 s" in text.getvalue()

    def test_an_error_in_the_callback_keeps_the_results(self):
        class EnoughError(Exception):
            pass

        def stop(fraction: float) -> None:
            if fraction > 0.0:
                raise EnoughError

        wanted = np.linspace(1000.0, 0.0, 10001)
        with pytest.raises(EnoughError) as caught:
            bowed_pair().simulate(1000.0, 100.0, times=wanted, progress=stop)
        response = caught.value.response
        assert isinstance(response, gb.Response)
        assert 0 < response.time.size < wanted.size
        assert response.time[-1] == 0.0
        assert np.all(np.diff(response.time) < 0.0)
        assert response.displacement("g1").shape == (response.time.size, 2)
        assert not hasattr(caught.value, "partial")

    def test_ctrl_c_keeps_the_results(self):
        timer = threading.Timer(0.3, signal.raise_signal, [signal.SIGINT])

        def begin(_: float) -> None:  # before the first step there is no result
            if not timer.ident:
                timer.start()

        try:
            with pytest.raises(KeyboardInterrupt) as caught:
                bowed_pair().simulate(1e3, 100.0, output_step=1e-3, progress=begin)
        finally:
            timer.cancel()
        response = caught.value.response
        assert 0 < response.time.size < 1_000_001
        assert response.statistics.steps > 0

    def test_an_error_of_a_run_contains_a_response_or_none(self):
        with pytest.raises(gb.StabilityError) as caught:
            bowed_pair().simulate(1e-2, 100.0, method="rk4", step=1e-2)
        assert caught.value.response is None or isinstance(caught.value.response, gb.Response)
        assert gb.SceneError("x").response is None


def test_tables_have_units_in_their_columns():
    response = recorded()
    table = response.to_dataframe()
    assert table.index.name == "time [s]"
    assert table.shape == (5, 3 * 3 + 2 * len(FIELDS) + 2 * 2 + 2 * 6 + 1 + len(TERMS))
    np.testing.assert_array_equal(table["g2 z [m]"], response.displacement("g2")[:, 1])
    np.testing.assert_array_equal(table["input@0.1 twist [rad]"], response.twist(("input", 0.1)))
    np.testing.assert_array_equal(
        table["g1/g2 pressure_angle [rad]"], response.mesh(("g1", "g2")).pressure_angle
    )
    np.testing.assert_array_equal(
        table["input@0 force_z [N]"], response.bearing_force(("input", 0.0))[:, 1]
    )
    np.testing.assert_array_equal(table["energy [J]"], response.energy)
    balance = response.energy_balance()
    np.testing.assert_array_equal(table["energy meshes [J]"], balance.meshes)
    np.testing.assert_array_equal(table["work damping [J]"], balance.damping)
    means = {
        "g4/g5 contact ratio": response.mesh("g4/g5").contact_ratio,
        "g1/g2 contact ratio": response.mesh("g1/g2").contact_ratio,
        "bearing input at 0 m force": np.hypot(*response.bearing_force(("input", 0.0)).T),
    }
    rows = {row[:30].strip(): row[30:].split() for row in response.table().splitlines()[2:]}
    for name, values in means.items():
        # the table has four digits
        assert float(rows[name][0]) == pytest.approx(values.mean(), rel=1e-3)


class TestEnergyBalance:
    """Energies and works of a run."""

    def test_totals_are_the_sums_of_their_terms(self):
        response = recorded()
        balance = response.energy_balance()
        assert balance.time is response.time
        terms = response._data["energy_terms"]
        np.testing.assert_allclose(balance.total, sum(terms[name] for name in TERMS[:4]))
        np.testing.assert_allclose(balance.work, sum(terms[name] for name in TERMS[4:]))
        change = balance.total - balance.total[0] - (balance.work - balance.work[0])
        np.testing.assert_allclose(balance.residual, change)

    def test_the_energy_balance_of_a_damped_train_closes(self):
        response = bowed_pair().simulate(
            0.02, 100.0, rtol=1e-9, initial="static", record=["energy"], output_step=1e-4
        )
        balance = response.energy_balance()
        np.testing.assert_allclose(balance.total, response.energy, rtol=1e-12)
        assert balance.damping[0] == 0.0
        assert np.all(np.diff(balance.damping) < 0.0)
        assert np.ptp(balance.drive) > 0.0
        assert np.all(balance.gravity == 0.0)
        assert np.abs(balance.residual).max() < 1e-6 * np.ptp(balance.total)

    def test_the_residual_starts_at_the_first_recorded_time(self):
        response = bowed_pair().simulate(
            0.02, 100.0, rtol=1e-9, initial="static", record=["energy"], times=[0.01, 0.015, 0.02]
        )
        balance = response.energy_balance()
        assert balance.work[0] != 0.0
        assert balance.residual[0] == 0.0
        assert np.abs(balance.residual).max() < 1e-6 * np.ptp(balance.total)

    def test_a_table_has_the_terms_and_their_sums(self):
        balance = recorded().energy_balance()
        table = balance.to_dataframe()
        assert table.index.name == "time [s]"
        names = [*TERMS, "total", "work", "residual"]
        assert list(table.columns) == [f"{name} [J]" for name in names]
        for name in names:
            np.testing.assert_array_equal(table[f"{name} [J]"], getattr(balance, name))


class TestEvents:
    """Mesh quantities between the recorded times."""

    def test_events_have_names(self):
        events = recorded().events
        assert isinstance(events, tuple)
        assert events[0] == (0.1 + 0.2, "g1", "g2", "separation")
        assert events[1].kind == "contact"
        assert events[1].driven == "g2"

    def test_a_mesh_without_contact_changes_has_no_events(self):
        assert bowed_pair().simulate(1e-3, 100.0).events == ()


def test_mode_names_tell_where_they_move():
    modes = bowed_pair().modes()
    shares = np.array(list(modes.energy_shares().values()))
    np.testing.assert_allclose(shares.sum(axis=0), 1.0, rtol=1e-9)
    names = modes.names()
    assert modes.whirl[0] == "rigid"
    assert names[0] == "rigid-body rotation"
    assert names.count("rigid-body rotation") == 1
    assert any(name.startswith("twist of") for name in names)
    assert any(name.startswith(("input y", "input z", "output y", "output z")) for name in names)
    lines = modes.table(count=3).splitlines()
    assert len(lines) == 5
    assert lines[2].endswith("rigid-body rotation")
    assert len(str(modes).splitlines()) > 5
    frame = modes.to_dataframe()
    np.testing.assert_array_equal(frame["frequency [Hz]"], modes.frequencies_hz)


def test_static_answers_by_name():
    static = bowed_pair().static()
    mesh = static.mesh(("g1", "g2"))
    force = 250.0 / (0.5 * 3e-3 * 25 * np.cos(np.radians(20.0)))
    assert mesh.force == pytest.approx(force, rel=1e-6)
    assert static.displacement("g1").shape == (2,)
    assert np.hypot(*static.displacement("g1")) > 1e-6
    assert isinstance(static.twist("g1"), float)
    total = sum(static.bearing_force(("input", x)) for x in (0.0, 0.5))
    assert np.hypot(*total) == pytest.approx(force, rel=1e-6)
    assert static.mesh("g2/g1").force == mesh.force
    with pytest.raises(
        gb.ChannelError, match=r"no mesh of 'g1' with 'g3'; there are \('g1', 'g2'\)"
    ):
        static.mesh(("g1", "g3"))
    with pytest.raises(gb.ChannelError, match=r"no bearing at .*; there are \('input', 0.0\), "):
        static.bearing_force(("input", 0.1))


def test_an_error_in_the_last_progress_report_keeps_the_results():
    def stop(fraction: float) -> None:
        if fraction == 1.0:
            raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough") as caught:
        bowed_pair().simulate(1e-3, 100.0, output_step=1e-4, progress=stop)
    assert caught.value.response.time[-1] == pytest.approx(1e-3)
