"""Files of sweeps: stores that resume, damage, and sweeps that they do not belong to."""

# Functions of a sweep take all its parameters.
# ruff: noqa: ARG001, ARG005

from __future__ import annotations

import hashlib
import json
import signal
import sqlite3
import sys
import warnings
from contextlib import closing
from functools import partial

import numpy as np
import pytest

import gearbow as gb
from gearbow.sweeps import store as files
from reference.processes import assert_done, python
from test_sweep import AB, GRID, force, mixed, number, odd, pair, plain, same


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
    assert_done(FULL, tmp_path / "map.sweep", size - 200)


KILLED_AT_RANDOM = """
import os, pathlib, random, signal, sys, time
import gearbow as gb
from concurrent.futures import ThreadPoolExecutor
from test_sweep import number, plain

path, chance = pathlib.Path(sys.argv[1]), random.Random(5)
grid = {"a": range(4000), "b": [0, 1]}
for _ in range(8):
    ours, theirs = os.pipe()
    child = os.fork()
    if not child:
        report = lambda fraction: os.write(theirs, b"%d\\n" % round(fraction * 8000))
        gb.sweep(plain, grid, number, ThreadPoolExecutor(1), path, report)
    os.close(theirs)
    begun = os.read(ours, 20)
    time.sleep(chance.uniform(0.0, 0.1))
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    with os.fdopen(ours, "rb") as file:
        reported = int((begun + file.read()).splitlines()[-1])
    kept = gb.Sweep.load(path)
    assert reported <= kept.computed <= reported + 1, (reported, kept.computed)
    for i in range(kept.computed):
        assert kept[i].values["value"] == number(kept[i].parameters)
print("done")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="kills a process")
def test_a_sweep_killed_at_any_instant_keeps_every_reported_point(tmp_path):
    assert_done(KILLED_AT_RANDOM, tmp_path / "map.sweep")


@pytest.mark.parametrize("content", [b"", b"not a sweep", bytes(1000), b"PK\x03\x04" * 100])
def test_a_file_that_is_no_sweep_is_refused(tmp_path, content):
    path = tmp_path / "map.sweep"
    path.write_bytes(content)
    with pytest.raises(gb.GearbowError, match=r"map.sweep: is not a sweep of gearbow, or damaged"):
        gb.Sweep.load(path)
    with pytest.raises(gb.SceneError, match=r"^store: .*not a sweep.*; remove it or give another"):
        gb.sweep(plain, AB, number, store=path)
    assert path.read_bytes() == content


def test_the_damaged_point_is_computed_again_and_all_others_stay(tmp_path, monkeypatch):
    path = tmp_path / "map.sweep"
    grid = {"a": range(100), "b": [0]}
    sweep = gb.sweep(plain, grid, number, store=path)
    content = files._content(40, files.Outcome({"value": np.float64(number({"a": 40, "b": 0}))}))
    data = bytearray(path.read_bytes())
    data[data.index(content) + len(content) - 3] ^= 1
    path.write_bytes(data)
    with pytest.warns(gb.CheckpointWarning, match=r"map.sweep: is damaged: the point 40; they"):
        kept = gb.Sweep.load(path)
    assert kept.computed == 99
    assert kept[40].values is None
    calls = []

    def counted(make, measure, point):
        calls.append(point["a"])
        return files.Outcome({"value": np.float64(number(point))})

    monkeypatch.setattr("gearbow.sweeps.run.compute", counted)
    message = r"^store: .*damaged: the point 40; its 99 intact points stay, and the others are"
    with pytest.warns(gb.CheckpointWarning, match=message):
        same(gb.sweep(plain, grid, number, store=path), sweep)
    assert calls == [40]
    same(gb.Sweep.load(path), sweep)  # without a warning


def test_a_changed_byte_anywhere_is_found(tmp_path):
    """No changed byte gives a wrong value, and none loses a point without a word.

    It loses at most the points of one page of the database, here 7, or is refused.
    """
    path = tmp_path / "map.sweep"
    grid = {"a": range(30), "b": [0]}
    gb.sweep(plain, grid, number, store=path)
    whole = path.read_bytes()
    root = 3 * 512  # the last of the pages on which all points depend
    refused = 0
    for place in range(0, len(whole), 5):
        path.write_bytes(
            whole[:place] + bytes([whole[place] ^ 1 << place % 8]) + whole[place + 1 :]
        )
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            try:
                kept = gb.Sweep.load(path)
            except gb.GearbowError:
                refused += 1
                continue
        assert kept.computed == 30 or caught
        for point in kept:
            assert point.values is None or point.values["value"] == number(point.parameters)
        if place > root:
            assert kept.computed >= 23
    assert refused < root / 5


# The last point stands in the last page, which the rows in descending order begin with.
@pytest.mark.parametrize("point", [50, 99])
def test_a_damaged_structure_loses_only_its_part(tmp_path, point):
    path = tmp_path / "map.sweep"
    grid = {"a": range(100), "b": [0]}
    sweep = gb.sweep(plain, grid, number, store=path)
    content = files._content(
        point, files.Outcome({"value": np.float64(number({"a": point, "b": 0}))})
    )
    data = bytearray(path.read_bytes())
    page = data.index(content) // 512 * 512
    data[page] = 0  # the kind of the page
    path.write_bytes(data)
    with pytest.warns(gb.CheckpointWarning, match=rf"the points .*{point}.* and its structure \("):
        kept = gb.Sweep.load(path)
    assert 93 <= kept.computed < 100
    contents = files.read(path)
    assert contents.damaged == set(range(100)) - set(contents.outcomes)
    with pytest.warns(gb.CheckpointWarning, match="the others are computed again"):
        same(gb.sweep(plain, grid, number, store=path), sweep)
    same(gb.Sweep.load(path), sweep)


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
    with closing(sqlite3.connect(path)) as database, database:
        number_of = about["point"] if about else 0
        row = (number_of, content, hashlib.sha256(content).digest())
        database.execute("INSERT OR REPLACE INTO points VALUES (?, ?, ?)", row)
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
    from gearbow.sweeps.points import identity

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
from gearbow.sweeps.points import identity
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


# --- formats --------------------------------------------------------------------------------------


def values(system: dict[str, float], **_: object) -> dict[str, object]:
    if system["a"] == 2:
        raise ValueError
    a = system["a"]
    return {
        "whole": a,
        "flag": a > 1,
        "phasor": 1 + 2j * a,
        "text": "é" * a,
        "array": np.full(2, a, dtype=np.float16),
    }


def test_the_suffix_of_a_saved_sweep_means_its_format(tmp_path):
    xarray, pandas = pytest.importorskip("xarray"), pytest.importorskip("pandas")
    sweep = gb.sweep(plain, {"a": [1, 2, 3], "b": ["x", "y"]}, values)
    sweep.save(tmp_path / "map.nc")
    with xarray.open_dataset(tmp_path / "map.nc") as data:
        assert data.sizes == {"a": 3, "b": 2, "array_0": 2}
        assert data["b"].values.tolist() == ["x", "y"]
        found = data["phasor_real"] + 1j * data["phasor_imag"]
        np.testing.assert_array_equal(found, sweep.values("phasor"))
        assert float(data["whole"].sel(a=3, b="y")) == 3.0
        assert data["text"].sel(a=3, b="x") == "ééé"
        np.testing.assert_array_equal(data["array"], sweep.values("array"))
    sweep.save(tmp_path / "map.csv")
    table = pandas.read_csv(tmp_path / "map.csv", keep_default_na=False)
    names = list(sweep.to_dataframe().columns)
    place = names.index("phasor")
    assert list(table.columns) == [*names[:place], "phasor re", "phasor im", *names[place + 1 :]]
    numbers, phasors = pandas.read_csv(tmp_path / "map.csv"), sweep.to_dataframe()["phasor"]
    np.testing.assert_array_equal(numbers["phasor re"], np.real(phasors))
    np.testing.assert_array_equal(numbers["phasor im"], np.imag(phasors))
    assert table["error"].tolist() == ["", "", "ValueError", "ValueError", "", ""]
    points = gb.sweep(plain, [{"a": 1, "b": 0}, {"a": 3, "b": 1}], values)
    points.save(tmp_path / "points.nc")
    with xarray.open_dataset(tmp_path / "points.nc") as data:
        assert data["flag"].values.tolist() == [False, True]


@pytest.mark.parametrize("name", ["map", "map.npz", "map.xyz", "map.nc.gz"])
def test_an_unknown_suffix_is_refused(tmp_path, name):
    sweep = gb.sweep(plain, AB, number)
    known = r"must end with \.sweep, \.csv, \.xlsx or \.nc, which is the format, got '.*'$"
    with pytest.raises(gb.SceneError, match=f"^path: {known}"):
        sweep.save(tmp_path / name)
    with pytest.raises(gb.SceneError, match=r"^store: must end with \.sweep, which is the format"):
        gb.sweep(plain, AB, number, store=tmp_path / name)
    with pytest.raises(gb.SceneError, match=r"^path: must end with \.sweep"):
        gb.Sweep.load(tmp_path / name)
    assert not list(tmp_path.iterdir())
