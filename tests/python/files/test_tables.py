"""Tables of all results: numbers and units against closed forms, and one way to print and save."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from matplotlib.figure import Figure

import gearbow as gb
from reference import scenes
from reference.machines import bowed_pair, hostile, inertia, jeffcott, rated, rigid_rotor
from reference.records import of_series
from test_tradeoff_numbers import STUDY

#: Names of `results`.
RESULTS = [
    *(
        "modes",
        "campbell",
        "map",
        "synchronous",
        "peaks",
        "life",
        "limits",
        "sensitivity",
        "static",
        "run",
        "energy",
        "spectrum",
    ),
    *("waterfall", "orders", "balance", "steady", "branch", "sweep", "tradeoff"),
    *("measurement", "identification", "correction"),
]

MASS = 50.0 + scenes.DENSITY * np.pi / 4 * 0.1**2 * 0.2  # of disk and shaft


def block(
    stiffness: tuple[float, float], damping: float = 0.0, moment: float = 0.05
) -> gb.RotorSystem:
    """Return a disk of 50 kg amid a short shaft that is 1e3 times stiffer than its two bearings."""
    bearing = {"stiffness": stiffness, "damping": damping}
    return rigid_rotor(inertia(50.0, moment, moment), bearing, "s", motion="lateral")


def rows(table: str) -> list[list[str]]:
    """Return the words of the rows of a table, which follow a heading and the names of the columns."""
    return [line.split() for line in table.splitlines()[2:]]


def test_frequencies_and_damping_of_modes_in_all_their_forms():
    # a mass on two bearings: ω² = 2k/m, ζ = c/√(2km), up to the flexibility of the shaft
    system = block((1e6, 2e6), damping=2e3)
    modes = system.modes(count=2)
    for mode, k in enumerate((1e6, 2e6)):
        undamped, ratio = np.sqrt(2 * k / MASS), 2e3 / np.sqrt(2 * k * MASS)
        frequency = undamped * np.sqrt(1 - ratio**2) / (2 * np.pi)
        assert modes.damping_ratios[mode] == pytest.approx(ratio, rel=1e-2)
        assert modes.frequencies_hz[mode] == pytest.approx(frequency, rel=1e-2)
    frame = modes.to_dataframe()
    np.testing.assert_array_equal(frame["frequency [Hz]"], modes.frequencies_hz)
    np.testing.assert_array_equal(frame["damping ratio"], modes.damping_ratios)
    heading, head = modes.table().splitlines()[:2]
    assert heading == "modes at 0 rad/s"
    assert "frequency [Hz]  damping [%]" in head
    for number, words in enumerate(rows(modes.table())):
        assert words[0] == str(number + 1)
        assert float(words[1]) == pytest.approx(modes.frequencies_hz[number], abs=5.1e-4)
        assert float(words[2]) == pytest.approx(100 * modes.damping_ratios[number], abs=5.1e-4)


def test_energy_shares_of_a_mode_follow_its_motion():
    # softer along y: the first mode moves along y; nothing moves along z
    shares = block((1e6, 2e6)).modes(count=2).energy_shares()
    assert shares["s", "v"] == pytest.approx([1.0, 0.0], abs=1e-9)
    assert shares["s", "w"] == pytest.approx([0.0, 1.0], abs=1e-9)
    # tilting about the centre has rotary inertia only, of bending in the same plane
    tilting = block((1e6, 2e6), moment=5.0).modes(count=2)
    assert tilting.energy_shares()["s", "v"] == pytest.approx([1.0, 0.0], abs=1e-9)
    assert tilting.names() == ["s y", "s z"]
    # a circle has half of its energy in each direction
    whirling = scenes.v3().modes(speed=300.0, count=2)
    assert whirling.whirl == ("backward", "forward")
    (shaft,) = {name for name, _ in whirling.energy_shares()}
    for direction in ("v", "w"):
        assert whirling.energy_shares()[shaft, direction] == pytest.approx([0.5, 0.5], abs=1e-6)


def test_intersections_in_all_their_forms():
    # damped by 16 %: the modulus of the eigenvalue is far from its imaginary part
    system = jeffcott(damping=4e3)
    found = system.campbell(np.linspace(0.0, 500.0, 6), count=2)
    modes = system.modes(speed=300.0, count=2)
    at = found.frequencies_hz[3]
    assert np.sort(at) == pytest.approx(np.sort(modes.eigenvalues.imag / (2 * np.pi)), rel=1e-9)
    eigenvalue = modes.eigenvalues[0]
    expected = -eigenvalue.real / abs(eigenvalue)
    assert expected > 0.1
    assert found.damping_ratios[3].min() == pytest.approx(expected, rel=1e-3)
    assert found.intersections
    for intersection in found.intersections:
        assert intersection.frequency_hz == pytest.approx(
            intersection.speed / (2 * np.pi), rel=1e-9
        )
        assert intersection.damping_ratio == pytest.approx(expected, rel=1e-3)
    frame = found.to_dataframe()
    for column, name in (
        ("speed [rad/s]", "speed"),
        ("frequency [Hz]", "frequency_hz"),
        ("damping ratio", "damping_ratio"),
        ("whirl", "whirl"),
    ):
        assert list(frame[column]) == [getattr(m, name) for m in found.intersections]
    assert list(frame["mode"]) == [m.mode + 1 for m in found.intersections]
    assert list(frame["order"]) == [1.0] * len(found.intersections)
    heading, head = found.table().splitlines()[:2]
    assert heading == "intersections and stability thresholds, 0 to 500 rad/s"
    assert "speed [rad/s]  frequency [Hz]  damping [%]" in head
    for words, intersection in zip(rows(found.table()), found.intersections, strict=True):
        assert float(words[0]) == pytest.approx(intersection.speed, abs=5.1e-3)
        assert float(words[1]) == pytest.approx(intersection.frequency_hz, abs=5.1e-4)
        assert float(words[2]) == pytest.approx(100 * intersection.damping_ratio, abs=5.1e-4)
        assert words[3] == intersection.whirl
        assert int(words[4]) == intersection.mode + 1


def test_lines_of_a_diagram():
    system = scenes.PAIR.package()
    found = system.campbell([100.0, 2000.0], count=6, harmonics=3)
    expected = {"1× input": 1.0, "1× output": 0.5}
    expected |= {f"{m}× teeth of g1–g2": 25.0 * m for m in (1, 2, 3)}
    assert {line.name: line.order for line in found.lines} == pytest.approx(expected)
    assert found.criticals == tuple(m for m in found.intersections if "teeth" not in m.line.name)
    assert len(found.intersections) > len(found.criticals) > 0
    none = system.campbell([100.0, 2000.0], count=6, harmonics=0)
    assert {line.name for line in none.lines} == {"1× input", "1× output"}


@pytest.mark.parametrize("order", [1.0, 2.0])
def test_critical_speeds_of_a_rigid_rotor(order: float):
    # two bearings of stiffness k carry the mass: the critical speed is √(2k/m) over the order
    found = block((3e5, 7e5)).critical_speed_map([1e5, 4e5], order=order)
    assert found.order == order
    expected = np.sqrt(2 * np.array([1e5, 4e5]) / MASS) / order
    # up to the flexibility of the shaft
    assert [speeds[0] for speeds in found.speeds] == pytest.approx(expected, rel=1e-2)


def overdamped() -> gb.RotorSystem:
    """Return a disk on two bearings that are critically damped along y and hardly along z."""
    damping = (1e8, 1e2)
    return gb.RotorSystem(
        [gb.Shaft("s", length=0.2, outer_diameter=0.1, elements=2)],
        disks=[gb.Disk("disk", "s", 0.1, 50.0, 0.05, 0.05)],
        bearings=[gb.Bearing("s", x, stiffness=1e6, damping=damping) for x in (0.0, 0.2)],
        motion="lateral",
    )


def test_a_table_has_the_modes_in_the_order_of_their_eigenvalues():
    modes = overdamped().modes(count=6)
    assert np.all(np.diff(np.abs(modes.eigenvalues)) > 0.0)
    frame = modes.to_dataframe()
    still = frame["frequency [Hz]"].to_numpy() == 0.0
    assert 0 < still.sum() < len(frame)
    # the number of a mode is that of `plot` and of the arrays
    for number, frequency in zip(frame["mode"], frame["frequency [Hz]"], strict=True):
        assert modes.frequencies_hz[number - 1] == frequency


def test_a_table_tells_how_to_leave_overdamped_modes_out():
    hint = r"(\d) of 6 modes are overdamped; modes\(count=, vibrating=True\)"
    few = overdamped().modes(count=6)
    count = int(re.search(hint, few.table())[1])
    assert count == sum(few.frequencies_hz == 0.0) > 0
    assert f"{count} of 6 modes are overdamped" in few._repr_html_()
    vibrating = overdamped().modes(count=6, vibrating=True)
    assert len(vibrating.whirl) == 6
    assert "overdamped" not in vibrating.table()
    np.testing.assert_allclose(vibrating.frequencies_hz[: 6 - count], few.frequencies_hz[count:])


def test_no_table_has_a_negative_zero():
    from gearbow._result import plain_text

    assert [plain_text(x, ".3f") for x in (-1e-9, -0.0, 0.0, -0.001)] == [
        "0.000",
        "0.000",
        "0.000",
        "-0.001",
    ]
    assert plain_text(-1e-300, ".4g") == "-1e-300"
    assert plain_text(np.nan, ".3f") == "–"


@cache
def results() -> dict[str, Any]:
    """Return one result of each kind, by name; speeds are given in rpm."""
    system, speed = hostile(), gb.rpm(1500)
    run = system.simulate(0.02, speed, output_step=1e-4, record=["gears", "meshes", "energy"])
    speeds, time = gb.rpm(np.linspace(100.0, 3000.0, 20)), 1e-3 * np.arange(6000)
    synchronous = jeffcott(damping=5e2).synchronous(gb.rpm(np.linspace(500.0, 9000.0, 90)))
    measured = gb.Measurement(
        gb.rpm([100.0, 500.0, 900.0]), [[3e-6], [4e-6j], [5e-6]], [gb.Probe("input", 0.25)]
    )
    identified = gb.identify(system, measured, [gb.unknown.bow("input")], runout=False)
    sweep = gb.sweep(dict, {"a": list(range(20))}, lambda system, a: 2.0 * a)  # noqa: ARG005
    return {
        "modes": system.modes(speed),
        "campbell": system.campbell(speeds, count=6, harmonics=3),
        "map": jeffcott().critical_speed_map([1e6, 1e7, 1e8]),
        "synchronous": system.synchronous(speeds),
        "peaks": synchronous.peaks("disk", operating=gb.rpm(4000)),
        "life": rated(system).bearing_life(speed),
        "limits": system.bow_limits("input", speeds[:4]),
        "sensitivity": system.sensitivity(
            [f"bearings[{i}].stiffness" for i in range(4)], system.modes(speed, count=5)
        ),
        "static": system.static(speed),
        "run": run,
        "energy": run.energy_balance(),
        "spectrum": run.spectrum("g1"),
        "waterfall": gb.waterfall([run], "g1"),
        "orders": of_series(time, 1e-6 * np.cos(100.0 * time)).orders(
            "g1", "z", shaft_harmonics=1, mesh_harmonics=0
        ),
        "balance": jeffcott(damping=4e3).balance(["disk"], gb.rpm(2000), points=["disk"]),
        "steady": bowed_pair().steady_state(100.0, geometry="frozen"),
        "branch": jeffcott(damping=4e3).continuation(
            "speed", 50.0, 55.0, record=["disk"], first_step=1.1
        ),
        "sweep": sweep,
        "tradeoff": STUDY,
        "measurement": measured,
        "identification": identified,
        "correction": identified.balance("g1", speed),
    }


@pytest.mark.parametrize("name", RESULTS)
def test_every_result_is_printed_converted_and_saved_in_one_way(name: str, tmp_path: Path):
    result = results()[name]
    # all rows in the table, a dozen and the number of the others in print
    lines, printed = result.table().splitlines(), str(result).splitlines()
    left = [line for line in printed if line.startswith("… and ")]
    count = len(result._columns()[0].values)
    assert len(left) == (count > 12)
    if left:
        assert left[0].split()[2] == str(count - 12)
        assert len(printed) == len(lines) - (count - 12) + 1
    else:
        assert printed == lines
    assert len(result.table(1).splitlines()) == len(lines) - max(0, count - 1)
    assert "-0.0" not in re.sub(r"-0\.0*[1-9]", "", result.table())
    # the same columns in a data frame and in a file of text
    frame = result.to_dataframe()
    result.save(tmp_path / "table.csv")
    read = pd.read_csv(tmp_path / "table.csv", index_col=0 if frame.index.name else None)
    assert list(read.columns) == list(frame.columns)
    assert len(read) == len(frame) > 0
    result.save(tmp_path / "table.nc")
    assert (tmp_path / "table.nc").stat().st_size > 0
    assert isinstance(result.plot("value") if name == "sweep" else result.plot(), Figure)
    with pytest.raises(gb.SceneError, match=r"^path: must end with .*\.csv"):
        result.save(tmp_path / "table.txt")


def test_a_table_of_any_result_is_a_data_set_with_units(tmp_path: Path):
    modes = results()["modes"]
    modes.save(tmp_path / "modes.nc")
    with xr.open_dataset(tmp_path / "modes.nc", engine="h5netcdf") as data:
        np.testing.assert_array_equal(data["frequency"], modes.to_dataframe()["frequency [Hz]"])
        assert data["frequency"].units == "Hz"
        assert list(data["whirl"].values) == list(modes.to_dataframe()["whirl"])


def test_a_table_of_any_result_is_a_sheet_of_excel(tmp_path: Path):
    pytest.importorskip("openpyxl")
    modes = results()["modes"]
    modes.save(tmp_path / "modes.xlsx")
    read = pd.read_excel(tmp_path / "modes.xlsx")
    assert list(read.columns) == list(modes.to_dataframe().columns)
    np.testing.assert_allclose(read["frequency [Hz]"], modes.to_dataframe()["frequency [Hz]"])


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("modes", "modes at 1500 rpm"),
        ("campbell", "100 to 3000 rpm"),
        ("synchronous", "100 to 3000 rpm"),
        ("peaks", "operating speed 4000 rpm"),
        ("static", "at 1500 rpm"),
        ("run", "run at 1500 rpm"),
        ("spectrum", "at 1500 rpm"),
        ("waterfall", "1500 rpm"),
        ("balance", "at 2000 rpm"),
    ],
)
def test_headings_have_the_speed_in_the_given_unit(name: str, text: str):
    result = results()[name]
    assert text in result.table()
    assert text not in result.table(speed_unit="rad/s")
    assert "rad/s" in result.table(speed_unit="rad/s")
    with pytest.raises(gb.SceneError, match=r"^speed_unit: must be one of rad/s, rpm, got 'Hz'"):
        result.table(speed_unit="Hz")


def test_a_table_without_speeds_refuses_their_unit():
    for name in ("energy", "sweep"):
        with pytest.raises(gb.GearbowError, match=r"^speed_unit: this result has no speeds"):
            results()[name].table(speed_unit="rpm")


def test_the_unit_of_the_speed_is_that_of_the_scene_and_of_the_file(tmp_path: Path):
    bearing = 'stiffness = { speeds = ["0 rpm", "3000 rpm"], values = ["1e7 N/m", "2e7 N/m"] }'
    scene = tmp_path / "scene.toml"
    scene.write_text(
        '[[shafts]]\nname = "rotor"\nlength = "1 m"\nouter_diameter = "50 mm"\n'
        'bow = { shape = "half_sine", amplitude = "0.1 mm" }\n'
        + "".join(
            f'[[bearings]]\nshaft = "rotor"\nposition = "{x} m"\n{bearing}\n' for x in (0, 1)
        ),
        encoding="utf-8",
    )
    system = gb.RotorSystem.load(scene)
    assert system.modes(100.0, count=2).table().startswith("modes at 954.93 rpm")
    assert system.replace(gravity=9.81).modes(100.0, count=2).speed_unit == "rpm"
    run = system.simulate(1e-3, 100.0, record=[("rotor", 0.0)])
    run.save(tmp_path / "run.npz")
    assert gb.Response.load(tmp_path / "run.npz").speed_unit == "rpm"
    # numbers of any unit are those of rad/s
    assert gb.rpm(1500) == pytest.approx(50.0 * np.pi)
    assert jeffcott().modes(100.0, count=2).speed_unit == "rad/s"


def test_results_of_results_have_the_unit_of_the_speed(tmp_path: Path):
    rotor, hit = jeffcott(damping=5e2), gb.Force("disk", 1.0)
    response = rotor.frequency_response(source=hit, order=1.0, speeds=gb.rpm([500.0, 900.0]))
    assert "  500.00" in response.table()
    assert "speeds=500 to 900 rpm" in repr(response)
    synchronous = rotor.synchronous(gb.rpm(np.linspace(500.0, 9000.0, 9)))
    assert "slow_roll=50 rpm" in repr(synchronous.subtract_slow_roll(gb.rpm(50)))
    assert synchronous.peaks("disk").speed_unit == "rpm"
    run = rotor.simulate(0.5, gb.rpm(1500), output_step=1e-3, record=["disk"])
    assert run.orders("disk").speed_unit == "rpm"
    assert rotor.simulate(1e-3, 100.0, initial=run, record=["disk"]).speed_unit == "rpm"
    # the segments of one run, too
    assert "rpm" in gb.waterfall(run, "disk", revolutions=4.0).table()
    state = rotor.steady_state(gb.rpm(1500), record=["disk"])
    state.save(tmp_path / "state.npz")
    loaded = gb.SteadyState.load(tmp_path / "state.npz")
    assert {loaded.speed_unit, loaded.response.speed_unit, state.response.speed_unit} == {"rpm"}
    assert gb.results.Modes.speed_unit == "rad/s"


def test_an_interrupted_run_has_the_unit_of_the_speed():
    def stop(share: float) -> None:
        if share > 0.1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as stopped:
        jeffcott().simulate(1.0, gb.rpm(1500), record=["disk"], progress=stop)
    assert stopped.value.response.speed_unit == "rpm"


def test_peaks_are_a_sequence_with_verdicts():
    peaks = results()["peaks"]
    assert len(peaks) == 1
    assert isinstance(peaks[0], gb.results.Peak)
    assert peaks[0].verdict == ("acceptable" if peaks[0].acceptable else "too close")
    assert peaks[0].verdict in peaks.table()
    far = jeffcott(damping=4e3).synchronous([1.0, 2.0, 3.0]).peaks("disk")
    assert list(far) == []
    assert far.table().splitlines()[-1] == "none"


def test_a_table_of_a_grid_has_the_parameters_of_each_point():
    grid = {"a": [1.0, 2.0], "b": [3.0, 4.0, 5.0]}
    sweep = gb.sweep(dict, grid, lambda system, a, b: 10.0 * a + b)  # noqa: ARG005
    found = [[float(word) for word in line] for line in rows(sweep.table())]
    assert found == [[a, b, 10.0 * a + b] for a in grid["a"] for b in grid["b"]]


def test_a_run_without_recorded_signals_is_printed():
    run = gb.examples()["turbine_rotor"].load().simulate(1e-3, 300.0, record=[])
    assert "signal" in str(run)
    assert len(run.to_dataframe()) == run.time.size
