"""Sweeps over parameters: order, failures, files, executors, interruption, tables."""

# Functions of a sweep take all its parameters.
# ruff: noqa: ARG001, ARG005

from __future__ import annotations

import multiprocessing
import subprocess
import sys
import threading
import time
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import gearbow as gb
from gearbow import _parallel
from reference.cases import each_case
from reference.machines import bowed_pair
from reference.processes import python

GRID = {"torque": [100.0, 250.0, 400.0], "bow": [0.0, 1e-4]}


def pair(torque: float, bow: float) -> gb.RotorSystem:
    return bowed_pair(bow, torque=torque, shaft={"degree": 2})


def force(system: gb.RotorSystem, **_: object) -> dict[str, object]:
    """Return the mesh force of a short run, and its extremes."""
    run = system.simulate(2e-3, 100.0, output_step=1e-4, record=["meshes"], rtol=1e-6)
    forces = run.mesh(("g1", "g2")).force
    return {"force": forces, "largest": forces.max(), "samples": forces.size}


def plain(**parameters: object) -> dict[str, object]:
    """Stand for a system in tests of the sweep itself."""
    return parameters


def number(system: dict[str, float], **_: object) -> float:
    return 10.0 * system["a"] + system["b"]


def odd(system: dict[str, float], **_: object) -> float:
    if system["b"] == 1:
        raise ValueError(f"b is {system['b']}")
    return number(system)


AB = {"a": [1, 2, 3], "b": [0, 1]}


def same(one: gb.Sweep, other: gb.Sweep) -> None:
    assert [point.parameters for point in one] == [point.parameters for point in other]
    assert [point.error for point in one] == [point.error for point in other]
    for mine, others in zip(one, other, strict=True):
        assert list(mine.values or {}) == list(others.values or {})
        for name, value in (mine.values or {}).items():
            found = (others.values or {})[name]
            assert (value.dtype, value.shape) == (found.dtype, found.shape)
            assert value.tobytes() == found.tobytes()


# --- points ---------------------------------------------------------------------------------------


def test_the_last_parameter_of_a_grid_varies_fastest():
    sweep = gb.sweep(plain, AB, number)
    assert len(sweep) == 6
    assert [(point.parameters["a"], point.parameters["b"]) for point in sweep] == [
        (a, b) for a in AB["a"] for b in AB["b"]
    ]
    np.testing.assert_array_equal(sweep.values(), [[10, 11], [20, 21], [30, 31]])
    assert repr(sweep) == "Sweep(a 3 × b 2: 6 points)"
    assert sweep.parameters == {"a": (1, 2, 3), "b": (0, 1)}
    assert sweep[-1].values == {"value": 31.0}
    assert [point.values["value"] for point in sweep[1:3]] == [11.0, 20.0]
    with pytest.raises(IndexError, match="there are 6 points"):
        sweep[6]


def test_a_list_of_points_keeps_its_order():
    points = [{"a": 3, "b": 1}, {"b": 5, "a": 1}, {"a": 3, "b": 1}]
    sweep = gb.sweep(plain, points, number)
    np.testing.assert_array_equal(sweep.values("value"), [31, 15, 31])
    assert repr(sweep) == "Sweep(a, b: 3 points)"
    assert [dict(point.parameters) for point in sweep] == points


def test_numbers_of_numpy_become_those_of_python():
    def kinds(system, **parameters):
        return {name: type(value).__name__ for name, value in parameters.items()}

    given = {"a": np.linspace(0.0, 1.0, 2), "b": np.arange(2), "c": [np.float64(1.0)], "d": ["x"]}
    sweep = gb.sweep(plain, given, kinds)
    assert sweep[0].values == {"a": "float", "b": "int", "c": "float", "d": "str"}


def test_a_grid_of_a_billion_points_is_not_expanded():
    axis = range(1000)
    points = gb.sweeps.points.Points({"a": axis, "b": axis, "c": axis})
    assert len(points) == 10**9
    assert points[123456789] == {"a": 123, "b": 456, "c": 789}


@each_case(
    ("parameters", "message"),
    [
        ({}, "parameters: must name at least one parameter"),
        ([], "parameters: must have at least one entry"),
        ({"a": []}, "parameters.a: must have at least one entry"),
        ({"a": 1.0}, "parameters.a: must be a list of values, got 1.0"),
        ({"a": "half"}, "parameters.a: must be a list of values, got 'half'"),
        ({"a": bytearray(b"ab")}, "parameters.a: must be a list of values, got bytearray"),
        ({"a": np.zeros((2, 2))}, r"parameters.a: must be one list.*\(2, 2\)"),
        (3, "parameters: must be a dict of lists or a list of dicts, got 3"),
        ({1: [2]}, "parameters: the name of a parameter must be text, got 1"),
        ([{"a": 1}, 2], r"parameters\[1\]: must be a dict of the parameters of a point, got 2"),
        ([{"a": 1}, {"b": 2}], r"parameters\[1\]: must have the names a of parameters\[0\], got b"),
    ],
)
def test_invalid_parameters_are_refused(parameters, message):
    with pytest.raises(gb.SceneError, match=f"^{message}"):
        gb.sweep(plain, parameters, lambda system, **p: 1.0)


@each_case(
    ("make", "measure", "message"),
    [
        (3, number, "make: must be a function, got 3"),
        (plain, None, "measure: must be a function, got None"),
        (lambda a: a, number, "make: must take the parameters a, b by name: .*'b'"),
        (plain, lambda system, a: a, "measure: must take a system and the parameters a, b .*'b'"),
        (plain, lambda a, **rest: a, "measure: must take a system .* 'a'"),
    ],
)
def test_functions_that_do_not_take_the_parameters_are_refused(make, measure, message):
    with pytest.raises(gb.SceneError, match=f"^{message}"):
        gb.sweep(make, AB, measure)


def test_an_object_without_submit_is_no_executor():
    with pytest.raises(gb.SceneError, match=r"^executor: must be an executor .* got 4"):
        gb.sweep(plain, AB, number, executor=4)


# --- failures -------------------------------------------------------------------------------------


def test_a_failed_point_keeps_its_error_and_the_others_continue():
    sweep = gb.sweep(plain, AB, odd)
    assert [dict(point.parameters) for point in sweep.failed] == [{"a": a, "b": 1} for a in AB["a"]]
    assert [point.error for point in sweep.failed] == ["ValueError: b is 1"] * 3
    assert "in odd" in sweep.failed[0].details
    assert sweep.failed[0].values is None
    np.testing.assert_array_equal(sweep.values(), [[10, np.nan], [20, np.nan], [30, np.nan]])
    assert repr(sweep) == "Sweep(a 3 × b 2: 6 points, 3 failed)"


def test_an_invalid_system_is_a_failed_point():
    sweep = gb.sweep(pair, {"torque": [100.0, np.nan], "bow": [0.0]}, force)
    (point,) = sweep.failed
    assert point.error.startswith("SceneError: torques[0].value: must be finite")


@pytest.mark.parametrize(
    ("returned", "message"),
    [
        (None, "measure: must be a number, a text or an array of them, got None"),
        ({}, "measure: must return at least one value, got an empty dict"),
        ({1: 2.0}, "measure: the name of a value must be text, got 1"),
        ({"x": object}, "measure: 'x': must be a number, a text or an array of them"),
        ([[1.0], [1.0, 2.0]], "measure: must be a number, a text or an array of them"),
        (np.ma.masked_array([1.0], [True]), "measure: must not be a masked array"),
    ],
)
def test_a_value_that_is_no_number_fails(returned, message):
    sweep = gb.sweep(plain, {"a": [1]}, lambda system, a: returned)
    assert sweep.failed[0].error.startswith(f"SceneError: {message}")
    with pytest.raises(gb.ChannelError, match=r"^no point has a value; SceneError: measure: "):
        sweep.values()


# --- values ---------------------------------------------------------------------------------------


def mixed(system: dict[str, float], **_: object) -> dict[str, object]:
    if system["b"] == 1 and system["a"] == 2:
        raise ValueError
    return {
        "whole": np.int32(system["a"]),
        "flag": system["a"] > 1,
        "phasor": 1j * system["a"],
        "text": "x" * system["a"],
        "array": system["a"] + np.arange(6, dtype=np.float32).reshape(2, 3),
    }


def test_values_have_the_axes_of_the_grid_and_their_own():
    sweep = gb.sweep(plain, AB, mixed)
    assert sweep.values("array").shape == (3, 2, 2, 3)
    assert sweep.values("array").dtype == np.float32
    assert sweep.values("whole").dtype == np.float64  # one point has no value
    assert np.isnan(sweep.values("phasor")[1, 1])
    assert sweep.values("text").tolist() == [["x", "x"], ["xx", ""], ["xxx", "xxx"]]
    np.testing.assert_array_equal(sweep.values("flag"), [[0, 0], [1, np.nan], [1, 1]])
    with pytest.raises(gb.ChannelError, match="there is more than one value; the values are whole"):
        sweep.values()
    with pytest.raises(gb.ChannelError, match="'fase': is no value"):
        sweep.values("fase")


def test_values_of_different_shapes_have_no_array():
    sweep = gb.sweep(plain, AB, lambda system, **p: np.zeros(system["a"]))
    with pytest.raises(
        gb.GearbowError, match=r"value: has the shape \(1,\) at point 0 and \(2,\) at point 2"
    ):
        sweep.values()
    assert sweep[5].values["value"].shape == (3,)


def test_the_data_set_has_a_dimension_for_each_parameter():
    pytest.importorskip("xarray")
    data = gb.sweep(plain, AB, mixed).to_xarray()
    assert data.sizes == {"a": 3, "b": 2, "array_0": 2, "array_1": 3}
    assert data["array"].dims == ("a", "b", "array_0", "array_1")
    assert float(data["whole"].sel(a=3, b=1)) == 3.0
    assert np.isnan(data["phasor"].sel(a=2, b=1))
    points = [{"a": 1, "b": "first"}, {"a": 5, "b": "second"}]
    data = gb.sweep(plain, points, lambda system, a, b: a).to_xarray()
    assert data["value"].dims == ("point",)
    assert data["b"].values.tolist() == ["first", "second"]


def test_the_table_has_a_row_for_each_point():
    pytest.importorskip("pandas")
    table = gb.sweep(plain, AB, odd).to_dataframe()
    assert list(table.columns) == ["a", "b", "value", "error"]
    assert table["b"].tolist() == [0, 1, 0, 1, 0, 1]
    assert table["value"].isna().tolist() == [False, True] * 3
    assert table["error"].tolist() == ["", "ValueError: b is 1"] * 3
    table = gb.sweep(plain, AB, mixed).to_dataframe()
    assert "array[1, 2]" in table.columns
    assert table["array[1, 2]"][4] == 3.0 + 5.0
    assert table["array[0, 1]"][4] == 3.0 + 1.0


def test_a_value_with_the_name_of_a_parameter_has_no_table():
    pytest.importorskip("xarray")
    sweep = gb.sweep(plain, AB, lambda system, **p: {"a": 1.0})
    assert sweep.values("a").shape == (3, 2)
    for convert in (sweep.to_xarray, sweep.to_dataframe):
        with pytest.raises(gb.GearbowError, match="a: is the name of a parameter and of a value"):
            convert()


# --- executors ------------------------------------------------------------------------------------


def test_every_executor_gives_the_same_bits():
    one = gb.sweep(pair, GRID, force, ThreadPoolExecutor(1))
    two = gb.sweep(pair, GRID, force, ThreadPoolExecutor(2))
    with ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as processes:
        apart = gb.sweep(pair, GRID, force, processes)
    assert not one.failed
    same(one, two)
    same(one, apart)
    same(one, gb.sweep(pair, GRID, force))


def test_functions_that_no_process_can_import_are_refused():
    with (
        ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as processes,
        pytest.raises(gb.SceneError, match="cannot be sent to another process") as caught,
    ):
        gb.sweep(lambda **p: p, AB, number, processes)
    assert caught.value.sweep.computed == 0


class Counting(Executor):
    """Runs calls one by one, the last submitted first, and counts those that wait."""

    def __init__(self) -> None:
        self.waiting: list[tuple[Future, tuple]] = []
        self.most = 0
        self.lock = threading.Lock()
        threading.Thread(target=self.run, daemon=True).start()

    def submit(self, function, /, *arguments):
        future: Future = Future()
        with self.lock:
            self.waiting.append((future, (function, arguments)))
            self.most = max(self.most, len(self.waiting))
        return future

    def run(self):
        while True:
            with self.lock:
                entry = self.waiting.pop() if self.waiting else None
            if entry is None:
                time.sleep(1e-4)
                continue
            future, (function, arguments) = entry
            future.set_result(function(*arguments))


def test_the_number_of_submitted_points_is_limited(monkeypatch):
    monkeypatch.setattr(_parallel, "PENDING", 20)
    executor = Counting()
    sweep = gb.sweep(plain, {"a": range(30), "b": range(10)}, number, executor)
    assert 1 < executor.most <= 20
    np.testing.assert_array_equal(sweep.values(), 10 * np.arange(30)[:, None] + np.arange(10))


def die(system: object, a: int) -> int:
    import os

    if a == 1:
        os._exit(1)
    return a


def test_the_end_of_a_worker_process_is_an_error():
    with (
        ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as processes,
        pytest.raises(gb.GearbowError, match="executor: its workers have ended") as caught,
    ):
        gb.sweep(plain, {"a": [0, 1, 2]}, die, processes)
    assert caught.value.sweep.computed < 3


def test_a_closed_or_broken_executor_is_refused():
    closed = ThreadPoolExecutor(1)
    closed.shutdown()
    with pytest.raises(
        gb.GearbowError, match=r"^executor: does not accept calls: .*shutdown; give"
    ):
        gb.sweep(plain, AB, number, closed)
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as broken:
        for _ in range(2):  # the second sweep begins with an executor that is broken already
            with pytest.raises(gb.GearbowError, match=r"^executor: "):
                gb.sweep(plain, {"a": [1]}, die, broken)


TERMINATED = """
import multiprocessing, os, sys, time
from concurrent.futures import ProcessPoolExecutor
import gearbow as gb
from test_sweep import plain, sleep

if __name__ == "__main__":
    with ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as processes:
        gb.sweep(plain, {"a": range(100), "folder": [sys.argv[1]]}, sleep, processes)
"""


def sleep(system: object, a: int, folder: str) -> None:
    import os

    (Path(folder) / str(os.getpid())).touch()
    time.sleep(600.0)


@pytest.mark.skipif(sys.platform == "win32", reason="sends a signal")
def test_a_terminated_sweep_leaves_no_worker_processes(tmp_path):
    import os

    script, folder = tmp_path / "script.py", tmp_path / "workers"
    script.write_text(TERMINATED, encoding="utf-8")
    folder.mkdir()
    here = str(Path(__file__).parents[1])
    path = os.pathsep.join(filter(None, [here, os.environ.get("PYTHONPATH")]))
    with subprocess.Popen(
        [sys.executable, script, folder], env={**os.environ, "PYTHONPATH": path}
    ) as main:
        while len(workers := list(folder.iterdir())) < 2:
            assert main.poll() is None
            time.sleep(0.05)
        main.terminate()
    left = [int(worker.name) for worker in workers]
    end = time.monotonic() + 30.0
    while left and time.monotonic() < end:
        time.sleep(0.05)
        left = [number for number in left if runs(number)]
    assert not left


def runs(process: int) -> bool:
    import os

    try:
        os.kill(process, 0)
        # A process that has ended may wait for a parent that asks for its code.
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except ProcessLookupError:
        return False
    except FileNotFoundError:
        return not Path("/proc/self").exists()


# --- progress and interruption --------------------------------------------------------------------


def test_progress_counts_the_points(capsys):
    fractions: list[float] = []
    gb.sweep(plain, AB, odd, progress=fractions.append)
    assert fractions == [i / 6 for i in range(7)]
    gb.sweep(plain, AB, number, progress=True)
    assert "6/6 points" in capsys.readouterr().err


def test_an_exception_of_progress_keeps_the_computed_points(tmp_path):
    class EnoughError(Exception):
        pass

    def enough(fraction):
        if fraction > 0.4:
            raise EnoughError

    with pytest.raises(EnoughError) as caught:
        gb.sweep(plain, AB, number, ThreadPoolExecutor(1), tmp_path / "map.sweep", enough)
    kept = caught.value.sweep
    assert 3 <= kept.computed <= 6
    same(kept, gb.Sweep.load(tmp_path / "map.sweep"))


INTERRUPTED = """
import os, signal, sys, threading, time
import gearbow as gb
from test_sweep import pair

signal.signal(signal.SIGINT, signal.default_int_handler)

def measure(system, torque, bow):
    if torque == 100.0:
        return 1.0
    threading.Timer(0.3, os.kill, [os.getpid(), signal.SIGINT]).start()
    return system.simulate(1e4, 100.0, output_step=1.0, record=["meshes"], rtol=1e-6).time.size

grid = {"torque": [100.0, 200.0], "bow": [1e-4]}
try:
    gb.sweep(pair, grid, measure, store=sys.argv[1])
except KeyboardInterrupt as error:
    print(repr(error.sweep), error.sweep[0].values["value"])
    begin = time.monotonic()
while any(thread.name.startswith("gearbow") for thread in threading.enumerate()):
    time.sleep(0.01)
print(repr(gb.Sweep.load(sys.argv[1])))
"""


@pytest.mark.skipif(sys.platform == "win32", reason="sends a signal")
def test_ctrl_c_stops_the_runs_in_threads_and_keeps_the_others(tmp_path):
    # the interrupted run takes hours: the test ends only if the run stops
    ended = python(INTERRUPTED, tmp_path / "map.sweep")
    text = "Sweep(torque 2 × bow 1: 2 points, 1 not computed)"
    assert ended.stdout == f"{text} 1.0\n{text}\n", ended.stderr


EVERY = """
import os, signal, threading, time
import numpy as np
import gearbow as gb
from test_sweep import pair

signal.signal(signal.SIGINT, signal.default_int_handler)
speeds = np.linspace(1.0, 500.0, 1_000_000)
# every second speed has a peak
samples = [(speed, float(index % 2)) for index, speed in enumerate(speeds[:100_000].tolist())]

def rotor(elements):
    shaft = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=elements)
    bearings = [gb.Bearing("rotor", x, stiffness=1e8, damping=1e3) for x in (0.0, 1.0)]
    disk = gb.Disk("disk", "rotor", 0.5, 10.0, 0.1, 0.2, unbalance=1e-4)
    return gb.RotorSystem([shaft], bearings=bearings, disks=[disk])

def forever(call):
    while True:
        call()

small, train = rotor(4), pair(100.0, 1e-4)
long = {"output_step": 1.0, "record": ["meshes"], "rtol": 1e-6}
calls = {
    "campbell": lambda: small.campbell(speeds),
    "synchronous": lambda: small.synchronous(speeds),
    "peaks": lambda: small._model.peaks(samples, 0, 0, "both", None),
    "balance": lambda: small.balance(["disk"], speeds[:300_000]),
    "map": lambda: small.critical_speed_map(speeds[:100_000], count=4),
    "static": lambda: forever(small.static),
    "simulate_many": lambda: train.simulate_many([{}], 1e4, 100.0, **long),
    "continuation": lambda: forever(
        lambda: train.continuation("torque", 1.0, 2.0, speed=100.0, first_step=1e-4, max_points=10_000)
    ),
    "modes": lambda: rotor(400).modes(),
}

for name, call in calls.items():
    def measure(system, name):
        threading.Timer(0.3, os.kill, [os.getpid(), signal.SIGINT]).start()
        call()
        return 1.0

    try:
        gb.sweep(lambda name: small, [{"name": name}], measure)
    except KeyboardInterrupt:
        workers = [each for each in threading.enumerate() if each.name.startswith("gearbow")]
        for worker in workers:
            worker.join(20.0)
        print(name, any(worker.is_alive() for worker in workers), flush=True)
os._exit(0)  # a decomposition of `modes` may go on
"""


@pytest.mark.skipif(sys.platform == "win32", reason="sends a signal")
def test_ctrl_c_stops_every_analysis_in_threads():
    # each call would take minutes
    names = ["campbell", "synchronous", "peaks", "balance", "map", "static", "simulate_many"]
    names += ["continuation", "modes"]
    ended = python(EVERY)
    assert ended.stdout.splitlines() == [f"{name} False" for name in names], ended.stderr


def test_an_interrupt_does_not_stop_unrelated_threads():
    _parallel._stopped.add("outer")
    try:
        # the choice of elements is an analysis too
        for function in (pair(100.0, 1e-4).static, lambda: pair(100.0, 1e-4)):
            with pytest.raises(KeyboardInterrupt):
                _parallel._call(("outer", "inner"), function, ())
        _parallel._call(("other",), pair(100.0, 1e-4).static, ())
        pair(100.0, 1e-4).static()
    finally:
        _parallel._stopped.discard("outer")


def test_a_sweep_is_drawn_over_one_or_two_parameters():
    one = gb.sweep(lambda x: x, {"x": [2.0, 1.0]}, lambda s, x: {"y": 3.0 * x})
    (panel,) = one.plot("y").axes
    assert panel.get_lines()[0].get_xydata().tolist() == [[1.0, 3.0], [2.0, 6.0]]
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("x", "y")
    grid = {"a": [1.0, 2.0], "b": [5.0], "c": [1.0, 3.0, 2.0]}
    two = gb.sweep(lambda a, b, c: a, grid, lambda s, a, b, c: {"y": a + c, "text": "t"})
    panel, bar = two.plot("y").axes
    assert panel.collections[0].get_array().tolist() == [[2.0, 3.0], [3.0, 4.0], [4.0, 5.0]]
    assert (panel.get_xlabel(), panel.get_ylabel(), bar.get_ylabel()) == ("a", "c", "y")
    with pytest.raises(gb.GearbowError, match=r"^plot: text is not one number"):
        two.plot("text")
    speeds = {"speed": gb.rpm([1000.0, 2000.0]), "amplitude": [2e-5, 5e-5]}
    sized = gb.sweep(lambda speed, amplitude: speed, speeds, lambda s, speed, amplitude: amplitude)
    panel, bar = sized.plot(units={"value": "m"}).axes
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("speed [rpm]", "amplitude [µm]")
    assert panel.get_xlim()[1] > 2000.0
    assert bar.get_ylabel() == "value [µm]"
    np.testing.assert_allclose(panel.collections[0].get_array()[:, 0], [20.0, 50.0])
    sizes = {"outer_diameter": [0.04, 0.05], "phase": [0.0, np.pi], "speed": [10.0, 20.0]}
    sized = gb.sweep(lambda **_: 1, sizes, lambda s, **_: 2.0)
    first = sized.plot().axes[0]
    assert (first.get_xlabel(), first.get_ylabel()) == ("phase [°]", "speed [rad/s]")
    assert first.get_title() == "outer_diameter [mm] = 40"
    points = gb.sweep(lambda x: x, [{"x": 1.0}], lambda s, x: x)
    with pytest.raises(gb.GearbowError, match=r"^plot: needs a sweep over a grid"):
        points.plot("value")
