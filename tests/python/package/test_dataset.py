"""Data sets of labelled signals: contents, noise, workers, resumption, data card, errors."""

# The functions of a data set take all its labels.
# ruff: noqa: ARG001

from __future__ import annotations

import multiprocessing
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference.cases import each_case
from reference.machines import bowed_pair

xr = pytest.importorskip("xarray")
pytest.importorskip("h5netcdf")

LABELS = {"bow": [5e-5, 1e-4], "torque": [100.0, 200.0]}
SENSORS = {"y": gb.Probe("input", 0.25), "mark": gb.Tacho("output")}
ORDERS = {"shaft_harmonics": 1, "mesh_harmonics": 0, "sidebands": 0}
NOISE = {"y": 1e-6}


def make(bow: float, torque: float) -> gb.RotorSystem:
    return bowed_pair(bow, torque=torque, shaft={"degree": 2})


def run(system: gb.RotorSystem, bow: float, torque: float) -> gb.Response:
    """Run at 200 rad/s."""
    if torque < 0.0:
        raise ValueError("the torque is negative")
    return system.simulate(0.2, 200.0, output_step=1e-3, record=["g1"], rtol=1e-6)


def made(path: Path, labels: Any = LABELS, **options: Any) -> gb.Sweep:
    given = {"noise": NOISE, "orders": ORDERS, "units": {"bow": "m", "torque": "N m"}, **options}
    return gb.dataset(make, labels, run, SENSORS, path, **given)


def read(path: Path) -> Any:
    with xr.open_dataset(path, engine="h5netcdf") as data:
        return data.load()


def test_a_file_contains_signals_pulses_orders_and_labels(tmp_path):
    made(tmp_path / "pair.nc")
    data = read(tmp_path / "pair.nc")
    assert dict(data.sizes) == {"point": 4, "time": 201, "mark_pulse": 4, "segment": 1, "order": 2}
    np.testing.assert_array_equal(data.bow, [5e-5, 5e-5, 1e-4, 1e-4])
    np.testing.assert_array_equal(data.torque, [100.0, 200.0, 100.0, 200.0])
    assert (data.bow.attrs, data.torque.attrs) == ({"units": "m"}, {"units": "N m"})
    assert [data[name].attrs["units"] for name in ("time", "y", "mark")] == ["s", "m", "s"]
    assert list(data.order.values) == ["1× output", "1× input"]
    response = run(make(1e-4, 200.0), 1e-4, 200.0)
    np.testing.assert_array_equal(data.time, response.time)
    np.testing.assert_array_equal(data.mark[3], response.measure(SENSORS["mark"]))
    noise = np.random.default_rng(int(data.noise_seed[3])).standard_normal(201)
    np.testing.assert_array_equal(data.y[3], response.measure(SENSORS["y"]) + 1e-6 * noise)
    # The orders are those of the signal with noise. Their scatter is 1e-6 √(2/201), of which five
    # times is never reached.
    amplitude = data.y_orders_real[3, 0, 1] + 1j * data.y_orders_imag[3, 0, 1]
    fitted = response.orders(SENSORS["y"], **ORDERS)
    assert 0.0 < abs(amplitude - fitted.tracks[0, 1]) < 5e-7
    np.testing.assert_array_equal(data.segment_speed, np.full((4, 1), 200.0))


def test_the_noise_has_the_deviation_and_depends_on_the_seed_and_the_sample(tmp_path):
    labels = {"bow": [1e-4], "torque": [100.0] * 4}
    quiet = read_after(made, tmp_path, labels, noise=None)
    one, other = (read_after(made, tmp_path, labels, seed=seed) for seed in (0, 1))
    noise = np.concatenate([one - quiet, other - quiet])
    # 1600 numbers: the deviation scatters by 1.8 %, a correlation of 200 by 0.07.
    assert noise.std() == pytest.approx(1e-6, rel=0.07)
    correlation = np.corrcoef(noise) - np.eye(8)
    assert np.abs(correlation).max() < 0.35
    given = [{"bow": 1e-4, "torque": 100.0, "noise_seed": 7}] * 2
    same = read_after(made, tmp_path, given)
    np.testing.assert_array_equal(same[0], same[1])


def read_after(function: Any, folder: Path, labels: Any, **options: Any) -> Any:
    function(folder / "pair.nc", labels, **options)
    return read(folder / "pair.nc").y.values


def test_any_number_of_workers_gives_the_same_files(tmp_path):
    pools = {
        "one": ThreadPoolExecutor(1),
        "two": ThreadPoolExecutor(2),
        "processes": ProcessPoolExecutor(2, multiprocessing.get_context("spawn")),
    }
    files = []
    for name, pool in pools.items():
        folder = tmp_path / name
        folder.mkdir()
        with pool:
            made(folder / "pair.nc", executor=pool)
        files.append([(folder / f"pair.{end}").read_bytes() for end in ("nc", "md")])
    assert files[0] == files[1] == files[2]


def test_an_interrupted_data_set_continues(tmp_path, monkeypatch):
    path, store = tmp_path / "pair.nc", tmp_path / "pair.sweep"

    def stop(fraction: float) -> None:
        if fraction > 0.4:
            raise KeyboardInterrupt

    usual, runs = gb.RotorSystem.simulate, iter(range(4))

    def waiting(system: gb.RotorSystem, *args: Any, **options: Any) -> gb.Response:
        if next(runs) == 2:
            # The third sample takes longer than the interruption after the second one.
            time.sleep(1.0)
        return usual(system, *args, **options)

    with monkeypatch.context() as slow:
        slow.setattr(gb.RotorSystem, "simulate", waiting)
        with pytest.raises(KeyboardInterrupt), ThreadPoolExecutor(1) as pool:
            made(path, store=store, progress=stop, executor=pool)
    assert not path.exists()
    begun = gb.Sweep.load(store).computed
    assert 0 < begun < 4
    fractions: list[float] = []
    made(path, store=store, progress=fractions.append)
    assert fractions[0] == begun / 4
    made(tmp_path / "again.nc")
    whole = read(tmp_path / "again.nc")
    xr.testing.assert_identical(read(path).assign_attrs(title=""), whole.assign_attrs(title=""))
    with pytest.raises(gb.SceneError, match="belongs to a sweep with"):
        made(path, store=store, noise={"y": 2e-6})


def test_a_failed_sample_has_its_error_in_file_and_card(tmp_path):
    found = made(tmp_path / "pair.nc", {"bow": [1e-4], "torque": [100.0, -1.0]})
    assert len(found.failed) == 1
    data = read(tmp_path / "pair.nc")
    assert list(data.error.values) == ["", "ValueError: the torque is negative"]
    assert np.isfinite(data.y[0]).all()
    assert np.isnan(data.y[1]).all()
    assert np.isnan(data.mark[1]).all()
    card = (tmp_path / "pair.md").read_text(encoding="utf-8")
    assert "1 of them failed" in card
    assert "'torque': -1.0" in card
    with pytest.raises(gb.GearbowError, match="no sample has signals: all 1 failed") as caught:
        made(tmp_path / "none.nc", {"bow": [1e-4], "torque": [-1.0]})
    assert len(caught.value.sweep.failed) == 1
    assert not (tmp_path / "none.nc").exists()


def test_the_card_names_what_was_simulated(tmp_path):
    made(tmp_path / "pair.nc", description="To tell pairs apart.")
    card = (tmp_path / "pair.md").read_text(encoding="utf-8")
    for text in (
        "# pair\n",
        "To tell pairs apart.",
        "4 simulated samples in `pair.nc`",
        "| `y` | point 4 × time 201 | m | probe input at 0.25 m, 0° |",
        "| bow | m | 5e-05, 0.0001 |",
        "| torque | N m | 100, 200 |",
        "standard deviation 1e-06 m",
        "RotorSystem(2 shafts, 2 gears, 1 mesh, ",
        "| `run` | `run` | Run at 200 rad/s. |",
        f"gearbow {gb.__version__}, NumPy {np.__version__}",
        "computed, not measured",
    ):
        assert text in card, text


def test_samples_with_other_times_are_refused(tmp_path):
    def longer(system: gb.RotorSystem, bow: float, torque: float) -> gb.Response:
        return system.simulate(1e-3 * torque, 200.0, output_step=1e-3, record=["g1"], rtol=1e-6)

    with pytest.raises(gb.GearbowError, match=r"time: that of sample 1 .* differs from") as caught:
        gb.dataset(make, LABELS, longer, SENSORS, tmp_path / "pair.nc")
    assert caught.value.sweep.computed == 4


@each_case(
    ("change", "message"),
    [
        ({"sensors": {}}, "sensors: must be a dict of names and sensors"),
        ({"sensors": {"y": "input"}}, r"sensors\['y'\]: must be a Probe"),
        ({"sensors": {"bow": SENSORS["y"]}}, r"sensors\['bow'\]: is the name of"),
        ({"sensors": {"mark": SENSORS["mark"]}}, "only tachometers"),
        ({"noise": {"yy": 1.0}}, r"noise\['yy'\]: is no sensor.*y"),
        ({"noise": {"y": -1.0}}, "must not be negative, got -1"),
        ({"noise": 1e-6}, "noise: must be a dict"),
        ({"orders": {"harmonics": 1}}, r"orders\['harmonics'\]: is no argument"),
        ({"orders": {"mesh_harmonics": None}}, "must be a number"),
        ({"units": {"load": "N"}}, r"units\['load'\]: is no label"),
        ({"seed": -1}, "seed"),
        ({"path": "pair.csv"}, "path: must end with .nc"),
        ({"parameters": {"noise_seed": [1]}}, "at least one label besides"),
        (
            {"parameters": {"bow": [1e-4], "torque": [1.0], "noise_seed": [-1]}},
            "parameters.noise_seed",
        ),
        ({"make": lambda bow: bow}, "make: must take the parameters bow, torque by name"),
        ({"run": lambda system: system}, "run: must take a system and the parameters bow"),
    ],
)
def test_wrong_arguments_are_errors(change, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("gearbow.studies.dataset.sweep", None)  # before anything is computed
    given = {"make": make, "parameters": LABELS, "run": run, "sensors": SENSORS, "path": "pair.nc"}
    with pytest.raises(gb.SceneError, match=message):
        gb.dataset(**{**given, **change})


def test_a_run_must_return_a_response(tmp_path):
    with pytest.raises(gb.GearbowError, match="run: must return a Response"):
        gb.dataset(make, LABELS, lambda system, **_: system, SENSORS, tmp_path / "pair.nc")


def test_the_noise_of_the_sensors_is_independent(tmp_path):
    sensors = {name: gb.Probe("input", 0.25) for name in ("first", "second", "third")}
    noise = dict.fromkeys(sensors, 1e-6)
    labels = {"bow": [5e-5], "torque": [100.0, 200.0]}
    gb.dataset(make, labels, run, sensors, tmp_path / "noisy.nc", noise=noise)
    gb.dataset(make, labels, run, sensors, tmp_path / "exact.nc")
    noisy, exact = read(tmp_path / "noisy.nc"), read(tmp_path / "exact.nc")
    scatter = [(noisy[name] - exact[name]).values[point] for name in sensors for point in (0, 1)]
    correlation = np.corrcoef(scatter)[np.triu_indices(6, 1)]
    # of 201 independent numbers, a correlation has the standard deviation 0.07
    assert np.abs(correlation).max() < 0.3
    assert np.std(scatter, axis=1) == pytest.approx(1e-6, rel=0.2)
