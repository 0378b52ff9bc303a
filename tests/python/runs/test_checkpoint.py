"""Checkpoint files: an interrupted run continues to a bitwise equal result."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from gearbow.recording import container as storage
from test_exponential_runs import SCENES, SHARP, SMOOTH, with_mesh
from test_persistence import assert_same

RECORD = ["gears", "meshes", "energy", "bearings"]
SMOOTH_GAP = with_mesh(stiffness=SMOOTH, backlash=5e-6)
RAMP = ([0.0, 0.02, 1.0], [500.0, 600.0, 600.0])
# Each method, with and without changes of the contact mode, and the simulated time, s.
RUNS: dict[str, tuple[Any, float, dict[str, Any]]] = {
    "smooth": (with_mesh(stiffness=SMOOTH), 0.06, {}),
    "rattling": (SCENES["rattling, live"][0], 0.045, {}),
    "sharp, frozen": (with_mesh(stiffness=SHARP), 0.05, {"geometry": "frozen"}),
    "etdrk4": (SCENES["etdrk4"][0], 0.016, SCENES["etdrk4"][1]),
    "rk45": (SMOOTH_GAP, 0.1, {"method": "rk45"}),
    "rk4": (with_mesh(stiffness=SHARP), 0.3, {"method": "rk4"}),
    "changing": (with_mesh(stiffness=SMOOTH), 0.12, {"speed": RAMP}),
    "synchronous": (SMOOTH_GAP, 0.045, {"initial": "synchronous"}),
}


def asked(name: str) -> dict[str, Any]:
    _, duration, own = RUNS[name]
    # times off every step grid, unordered, one of them repeated
    times = np.random.default_rng(7).uniform(0.0, duration, 40)
    given = {"speed": 600.0, "initial": "rest", "record": RECORD, "times": [*times, times[3]]}
    return {"duration": duration, **given, **own}


def short() -> tuple[gb.RotorSystem, dict[str, Any]]:
    """Simulate a run that ends before the first interrupt check."""
    return RUNS["smooth"][0].package(), {"duration": 1e-3, "speed": 600.0, "output_step": 1e-4}


class EnoughError(Exception):
    pass


class Pause:
    """Delay the first check longer than the check interval, so that the next check follows after a
    few steps.
    """

    left = 6

    def __call__(self, _: float) -> None:
        if self.left > 0:
            self.left -= 1
            time.sleep(0.06)


class Stop:
    """Stop a run after its first step."""

    def __init__(self, pause: Pause) -> None:
        self.pause = pause
        self.begun: float | None = None

    def __call__(self, fraction: float) -> None:
        self.pause(fraction)
        self.begun = fraction if self.begun is None else self.begun
        if self.begun < fraction < 1.0:
            raise EnoughError


@pytest.fixture
def writings(monkeypatch):
    """Count the writes."""
    count: list[int] = []
    write = storage.save

    def counted(run: Any, *args: Any, **more: Any) -> None:
        count.append(run.data["time"].size)
        write(run, *args, **more)

    monkeypatch.setattr(storage, "save", counted)
    return count


# --- equal bits -------------------------------------------------------------------------------


@pytest.mark.parametrize("name", RUNS)
def test_a_run_that_is_interrupted_often_equals_the_whole_run(name, tmp_path, writings):
    system, path = RUNS[name][0].package(), tmp_path / "run.npz"
    whole = system.simulate(**asked(name))
    # the run is interrupted at every interrupt check, first within one call,
    found = system.simulate(
        **asked(name), checkpoint=path, checkpoint_interval=1e-9, progress=Pause()
    )
    assert_same(found, whole)
    assert_same(gb.Response.load(path), whole)
    assert len(writings) > 2
    # then between calls
    path.unlink()
    pause = Pause()
    for _ in range(100):
        try:
            found = system.simulate(**asked(name), checkpoint=path, progress=Stop(pause))
            break
        except EnoughError as error:
            done = np.unique(error.response.time)  # type: ignore[attr-defined]
            assert np.array_equal(done, gb.Response.load(path).time)
            assert done.size < whole.time.size
    else:
        pytest.fail("it has not come to its end")
    assert_same(found, whole)
    assert os.listdir(tmp_path) == ["run.npz"]  # noqa: PTH208


def test_a_run_that_is_complete_is_read(tmp_path, monkeypatch):
    system, options = short()
    path = tmp_path / "run.npz"
    first = system.simulate(**options, checkpoint=path)
    assert first.accuracy.startswith("engineering")
    monkeypatch.setattr("gearbow.system.simulation._run", None)  # no simulation runs
    again = system.simulate(**options, checkpoint=path)
    assert_same(again, first)
    assert again.accuracy == first.accuracy
    assert again.errors() == first.errors()


# --- killed processes -----------------------------------------------------------------------------

KILLED = """
import os, pathlib, signal, sys
from test_checkpoint import RUNS, Pause, asked

count, replace = [], pathlib.Path.replace

def twice(self, target):
    count.append(target)
    if len(count) == int(sys.argv[2]):  # the file is complete under its temporary name
        os.kill(os.getpid(), signal.SIGKILL)
    return replace(self, target)

pathlib.Path.replace = twice
often = {"checkpoint_interval": 1e-9, "progress": Pause()}
RUNS["rattling"][0].package().simulate(**asked("rattling"), checkpoint=sys.argv[1], **often)
"""


@pytest.mark.skipif(os.name != "posix", reason="signals")
@pytest.mark.parametrize("writing", [2, 3])
def test_a_process_that_is_killed_while_writing_leaves_the_previous_file(tmp_path, writing):
    path = tmp_path / "run.npz"
    folder = Path(__file__).parents[1]
    command = [sys.executable, "-c", KILLED, path, str(writing)]
    ended = subprocess.run(command, cwd=folder, check=False)
    assert ended.returncode == -signal.SIGKILL
    # a killed process leaves its incomplete file and its lock
    assert len(list(tmp_path.iterdir())) == 3
    left = gb.Response.load(path)
    system = RUNS["rattling"][0].package()
    whole = system.simulate(**asked("rattling"))
    assert left.time.size < whole.time.size
    assert_same(system.simulate(**asked("rattling"), checkpoint=path), whole)
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


def test_ctrl_c_leaves_the_newest_state(tmp_path):
    path = tmp_path / "run.npz"
    system, options = RUNS["smooth"][0].package(), asked("smooth")

    pause = Pause()

    def interrupt(fraction: float) -> None:
        pause(fraction)
        if fraction > 0.0:
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt) as caught:
        system.simulate(**options, checkpoint=path, progress=interrupt)
    left, kept = caught.value.response, gb.Response.load(path)  # type: ignore[attr-defined]
    assert left.final["state"].tobytes() == kept.final["state"].tobytes()
    # the file contains each time once, in order
    assert np.array_equal(np.unique(left.time), kept.time)
    assert_same(system.simulate(**options, checkpoint=path), system.simulate(**options))


def test_ctrl_c_while_the_file_is_written_leaves_the_previous_file(tmp_path, monkeypatch):
    path = tmp_path / "run.npz"
    system, options = RUNS["smooth"][0].package(), asked("smooth")
    with pytest.raises(EnoughError):
        system.simulate(**options, checkpoint=path, progress=Stop(Pause()))
    before = path.read_bytes()

    def interrupted(file: Any, **_: Any) -> None:
        file.write(b"half of it")
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(np, "savez", interrupted)
        with pytest.raises(KeyboardInterrupt) as caught:
            system.simulate(**options, checkpoint=path, checkpoint_interval=1e-9, progress=Pause())
    assert path.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["run.npz"]
    # the computed results are not lost
    assert caught.value.response.final["time"] > gb.Response.load(path).final["time"]  # type: ignore[attr-defined]
    assert_same(system.simulate(**options, checkpoint=path), system.simulate(**options))


def test_a_run_that_cannot_continue_repeats_its_error(tmp_path):
    bow = gb.Bow.half_sine(8e-3)
    system = RUNS["smooth"][0].package()
    shafts = [gb.Shaft(**{**vars(shaft), "bow": bow}) for shaft in system.shafts]
    bent = system.replace(shafts=shafts, torques=[])
    options = {"duration": 1.0, "speed": 100.0, "initial": "rest", "output_step": 1e-5}
    texts = []
    for _ in range(2):
        with pytest.raises(gb.ContactError) as caught:
            bent.simulate(**options, checkpoint=tmp_path / "run.npz")
        texts.append(str(caught.value))
        assert_same(gb.Response.load(tmp_path / "run.npz"), caught.value.response)
    assert texts[0] == texts[1]


# --- refused --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("other", "text"),
    [
        ({"duration": 2e-3}, r"with duration 0\.001, not 0\.002"),
        ({"speed": 601.0}, "with speed"),
        ({"rtol": 1e-7}, r"with rtol 0\.0001, not 1e-07"),
        ({"method": "rk45"}, "with method exponential, not rk45"),
        ({"output_step": 1e-5}, r"with times\.length 11, not 101"),
        ({"record": ["ga"]}, "with record"),
        ({"initial": "rest"}, "with initial synchronous, not rest"),
        ({"geometry": "frozen"}, "with geometry live, not frozen"),
        ({"stages": 2}, "with stages None, not 2"),
    ],
    ids=lambda value: "" if isinstance(value, str) else str(value),
)
def test_the_file_of_another_run_is_refused(tmp_path, other, text):
    system, options = short()
    path = tmp_path / "run.npz"
    system.simulate(**options, checkpoint=path)
    before = path.read_bytes()
    with pytest.raises(gb.SceneError, match=f"^checkpoint: .*{text}"):
        system.simulate(**{**options, **other}, checkpoint=path)
    assert path.read_bytes() == before


def test_the_file_of_another_system_is_refused(tmp_path):
    system, options = short()
    path = tmp_path / "run.npz"
    system.simulate(**options, checkpoint=path)
    other = with_mesh(stiffness={**SMOOTH, "pair": 1.6e8}).package()
    where = r"scene\.meshes\[0\]\.stiffness\.pair 150000000\.0, not 160000000\.0"
    with pytest.raises(gb.SceneError, match=where):
        other.simulate(**options, checkpoint=path)


def test_a_file_that_is_no_checkpoint_is_not_changed(tmp_path):
    system, options = short()
    path = tmp_path / "run.npz"
    system.simulate(**options).save(path)
    whole = path.read_bytes()
    for content in (whole, whole[: len(whole) // 2], b"", b"notes of a long day"):
        path.write_bytes(content)
        with pytest.raises(gb.SceneError, match=r"^checkpoint: .* exists but is not valid"):
            system.simulate(**options, checkpoint=path)
        assert path.read_bytes() == content
    with pytest.raises(gb.SceneError, match=r"^checkpoint: there is no folder"):
        system.simulate(**options, checkpoint=tmp_path / "missing" / "run.npz")
    with pytest.raises(gb.GearbowError, match=r"^checkpoint: must end with \.npz"):
        system.simulate(**options, checkpoint=tmp_path / "run.csv")
    with pytest.raises(gb.GearbowError, match=r"^checkpoint: .*run\.nc is netCDF.*a file \.npz"):
        system.simulate(**options, checkpoint=tmp_path / "run.nc")
    with pytest.raises(gb.SceneError, match=r"^checkpoint_interval: must be positive, got 0"):
        system.simulate(**options, checkpoint=tmp_path / "other.npz", checkpoint_interval=0)
