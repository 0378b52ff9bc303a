"""Files of sweeps: stores that resume, damage, and sweeps that they do not belong to."""

# Functions of a sweep take all its parameters.
# ruff: noqa: ARG001, ARG005

from __future__ import annotations

import json
import signal
import sys
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np
import pytest

import gearbow as gb
from gearbow.sweeps import store as files
from test_sweep import AB, GRID, force, mixed, number, odd, pair, plain, python, same


def test_a_store_contains_the_sweep(tmp_path):
    path = tmp_path / "map.sweep"
    sweep = gb.sweep(plain, AB, mixed, store=path)
    same(sweep, gb.Sweep.load(path))
    same(sweep, gb.sweep(plain, AB, mixed, store=path))
    sweep.save(tmp_path / "other.sweep")
    same(sweep, gb.Sweep.load(tmp_path / "other.sweep"))
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["map.sweep", "other.sweep"]
    assert repr(gb.Sweep.load(path)) == repr(sweep) == "Sweep(a 3 × b 2: 6 points, 1 failed)"


def test_failed_points_are_computed_again(tmp_path, monkeypatch):
    path = tmp_path / "map.sweep"
    gb.sweep(plain, AB, odd, store=path)
    calls = []
    monkeypatch.setattr(
        "gearbow.sweeps.run.compute",
        lambda make, measure, p: calls.append(p) or files.Outcome({"value": np.float64(1.0)}),
    )
    sweep = gb.sweep(plain, AB, odd, store=path)
    assert [p["b"] for p in calls] == [1, 1, 1]
    assert not sweep.failed
    same(sweep, gb.Sweep.load(path))


KILLED = """
import os, sys, time
import gearbow as gb
from test_sweep import GRID, force, pair

def report(fraction):
    if fraction > 0.4:
        os.kill(os.getpid(), 9)

gb.sweep(pair, GRID, force, store=sys.argv[1], progress=report)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="kills a process")
def test_a_killed_sweep_is_resumed(tmp_path):
    path = tmp_path / "map.sweep"
    assert python(KILLED, path).returncode == -signal.SIGKILL
    kept = gb.Sweep.load(path)
    assert 0 < kept.computed < len(kept) == 6
    assert repr(kept).endswith(f"{6 - kept.computed} not computed)")
    fractions: list[float] = []
    sweep = gb.sweep(pair, GRID, force, store=path, progress=fractions.append)
    assert fractions[0] == kept.computed / 6
    same(sweep, gb.sweep(pair, GRID, force))
    assert [entry.name for entry in tmp_path.iterdir()] == ["map.sweep"]


FULL = """
import resource, sys
import gearbow as gb
from concurrent.futures import ThreadPoolExecutor
from test_sweep import AB, number, plain, same

path = sys.argv[1]
whole = gb.sweep(plain, AB, number)
soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]), hard))
try:
    gb.sweep(plain, AB, number, ThreadPoolExecutor(1), path)
except OSError as error:
    computed = error.sweep.computed
else:
    raise SystemExit("the space was enough")
resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
kept = gb.Sweep.load(path).computed
assert 0 < kept < 6 and kept <= computed, (kept, computed)
same(gb.sweep(plain, AB, number, store=path), whole)
print("done")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="limits of a process")
def test_a_full_disk_keeps_the_complete_records(tmp_path):
    gb.sweep(plain, AB, number, store=tmp_path / "whole.sweep")
    size = (tmp_path / "whole.sweep").stat().st_size
    ended = python(FULL, tmp_path / "map.sweep", size - 200)
    assert (ended.returncode, ended.stdout) == (0, "done\n"), ended.stderr


def test_an_incomplete_record_at_the_end_is_ignored(tmp_path):
    path = tmp_path / "map.sweep"
    sweep = gb.sweep(plain, AB, number, ThreadPoolExecutor(1), path)
    whole = path.read_bytes()
    first = 48 + int.from_bytes(whole[:8], "little") - 8
    record = (len(whole) - first) // 6
    for size in range(len(whole) - record + 1, len(whole)):
        path.write_bytes(whole[:size])
        assert gb.Sweep.load(path).computed == 5
    path.write_bytes(whole[:-10] + bytes(10))  # a loss of power
    assert gb.Sweep.load(path).computed == 5
    path.write_bytes(whole[:-record] + bytes(300))
    assert gb.Sweep.load(path).computed == 5
    same(gb.sweep(plain, AB, number, store=path), sweep)
    assert gb.Sweep.load(path).computed == 6


@pytest.mark.parametrize("content", [b"", b"not a sweep", bytes(1000), b"PK\x03\x04" * 100])
def test_a_file_that_is_no_sweep_is_refused(tmp_path, content):
    path = tmp_path / "map.sweep"
    path.write_bytes(content)
    with pytest.raises(gb.GearbowError, match=r"map.sweep: not a sweep of gearbow, or damaged"):
        gb.Sweep.load(path)
    with pytest.raises(gb.SceneError, match=r"^store: .*not a sweep.*; remove it or give another"):
        gb.sweep(plain, AB, number, store=path)
    assert path.read_bytes() == content


def test_a_changed_byte_is_found(tmp_path):
    path = tmp_path / "map.sweep"
    gb.sweep(plain, AB, number, store=path)
    whole = path.read_bytes()
    last = len(whole) - 60  # in the last record, which counts as incomplete
    for place in range(0, last, 7):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1 :])
        try:
            kept = gb.Sweep.load(path)
        except gb.GearbowError:
            continue
        for point in kept:  # a changed length can look like an incomplete record
            assert point.values is None or point.values["value"] == number(point.parameters)


@pytest.mark.parametrize(
    ("about", "data", "message"),
    [
        ({"point": 0, "values": [["v", "f8", [2]]]}, bytes(8), "not a sweep"),
        ({"point": 0, "values": [["v", "f8", [1]]]}, bytes(16), "has 16 bytes of values, not 8"),
        ({"point": 0, "values": [["v", "O8", [1]]]}, bytes(8), "'O8' is not a type"),
        ({"point": 0, "values": [["v", "f8", [-1]]]}, b"", "not negative"),
        ({"point": 0}, b"", "values: is missing"),
        ({"point": 9, "values": []}, b"", "contains the point 9, but there are 6 points"),
        ([], b"", "must be a mapping"),
    ],
)
def test_invalid_records_are_refused(tmp_path, about, data, message):
    path = tmp_path / "map.sweep"
    gb.sweep(plain, AB, number, store=path)
    content = json.dumps(about).encode() + b"\n" + data
    path.write_bytes(path.read_bytes() + files._sealed(content))
    with pytest.raises(gb.GearbowError, match=message):
        gb.Sweep.load(path)


FACTOR = 2.0


def scaled(system: dict[str, float], **_: object) -> float:
    return FACTOR * number(system)


@pytest.mark.parametrize(
    ("parameters", "make", "measure", "message"),
    [
        ({"a": [1, 2, 4], "b": [0, 1]}, plain, number, r"parameters.grid.a\[2\] 3, not 4"),
        ({"a": [1, 2, 3]}, plain, lambda system, a: a, "measure.name number, not "),
        (AB, plain, partial(number, unused=1.0), "measure.digest"),
        (AB, lambda a, b: {"a": a, "b": b}, number, "make.name plain, not "),
        ([{"a": 1, "b": 0}], plain, number, "parameters.grid"),
    ],
)
def test_a_store_of_another_sweep_is_refused(tmp_path, parameters, make, measure, message):
    path = tmp_path / "map.sweep"
    gb.sweep(plain, AB, number, store=path)
    before = path.read_bytes()
    with pytest.raises(gb.SceneError, match=rf"^store: .* belongs to a sweep with {message}"):
        gb.sweep(make, parameters, measure, store=path)
    assert path.read_bytes() == before


def test_a_changed_function_or_global_value_makes_another_sweep(tmp_path, monkeypatch):
    path = tmp_path / "map.sweep"
    gb.sweep(plain, AB, scaled, store=path)
    gb.sweep(plain, AB, scaled, store=path)
    monkeypatch.setattr(sys.modules[__name__], "FACTOR", 3.0)
    with pytest.raises(gb.SceneError, match=r"measure\.digest"):
        gb.sweep(plain, AB, scaled, store=path)
    monkeypatch.undo()
    monkeypatch.setattr(sys.modules[__name__], "number", lambda system: 0.0)
    with pytest.raises(gb.SceneError, match=r"measure\.digest"):
        gb.sweep(plain, AB, scaled, store=path)


def test_the_identity_of_a_function_is_that_of_its_content():
    from gearbow.sweeps.functions import identity

    def closure(system, factor):
        return lambda **p: (system, factor)

    base = pair(100.0, 0.0)
    again = identity(closure(pair(100.0, 0.0), 1.0))
    assert identity(closure(base, 1.0)) == again
    assert identity(closure(base, 2.0)) != again
    assert identity(closure(base.replace(gravity=9.81), 1.0)) != again
    one = base.replace(forces=[gb.Force("g1", lambda time: 1.0 * time)])
    other = base.replace(forces=[gb.Force("g1", lambda time: 2.0 * time)])
    assert identity(closure(one, 1.0)) != identity(closure(other, 1.0))
    assert identity(closure({"a", "b"}, np.arange(3))) == identity(
        closure({"b", "a"}, np.arange(3))
    )
    assert identity(closure(None, np.arange(3))) != identity(closure(None, np.arange(4)))


IDENTITY = """
from gearbow.sweeps.functions import identity
from test_sweep import force, mixed, pair
from test_sweep_files import scaled
print([identity(function)["digest"] for function in (pair, force, mixed, scaled)])
"""


def test_the_identity_of_a_function_is_the_same_in_every_process():
    one, other = python(IDENTITY), python(IDENTITY)
    assert one.returncode == 0, one.stderr
    assert one.stdout == other.stdout


def test_a_store_serves_one_sweep_at_a_time(tmp_path):
    path = tmp_path / "map.sweep"

    def nested(system, a):
        gb.sweep(plain, {"a": [1]}, nested, store=path)

    sweep = gb.sweep(plain, {"a": [1]}, nested, store=path)
    assert "is in use by another sweep" in sweep.failed[0].error


def test_parameters_that_a_file_cannot_contain(tmp_path):
    bows = {"bow": [gb.Bow.half_sine(1e-4)]}
    sweep = gb.sweep(plain, bows, lambda system, bow: bow.amplitude)
    assert sweep.values().tolist() == [1e-4]
    for write in (
        sweep.save,
        lambda path: gb.sweep(plain, bows, lambda system, bow: 1.0, store=path),
    ):
        with pytest.raises(gb.SceneError, match=r"^parameters.bow\[0\]: a file contains only"):
            write(tmp_path / "map.sweep")
    with pytest.raises(gb.SceneError, match=r"^store: there is no folder"):
        gb.sweep(plain, AB, number, store=tmp_path / "none" / "map.sweep")
