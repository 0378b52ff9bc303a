"""Damaged files of every kind: each is read or is an error of gearbow that names the file."""

from __future__ import annotations

import ast
import json
import os
import random
import sys
import time
import warnings
from collections import Counter
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from gearbow.exchange.rexs_file import _from_xml
from gearbow.exchange.tables import read_vectors
from gearbow.exchange.universal import Function, Quantity, function_lines, write
from reference.processes import printed
from test_response import recorded

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

PACKAGE = Path(gb.__file__).parent
#: Damaged files of each kind in `make test`; `make fuzz` reads 50 times as many.
COUNT = 40 * int(os.environ.get("GEARBOW_CASES", "1"))
TABLE = "speed [rpm],k [N/um]\n0,10\n1000,12.5\n2000,1.4e1\n"
MEASURED = "speed [rpm],shaft,position [mm],amplitude [um],phase [deg]\n" + "".join(
    f"{v},input,100,{v / 100},{v / 50}\n" for v in (500, 1000, 1500)
)
CURVES = "frequency [Hz],pinion y re [m],pinion y im [m]\n10,1,2\n20,3,4\n"
ROSS = Path(__file__).parents[3] / "examples" / "ross_files" / "rotor.toml"
#: What takes a part of a file to where no reader expects it.
WORDS = (
    b"",
    b"-1",
    b"1e400",
    b"nan",
    b"9" * 5000,
    b"\xff\xfe",
    b"\0",
    b"=1+1",
    b"[",
    b'"',
    b"1e-9",
)


@cache
def response() -> Any:
    force = gb.Force("pinion", 1.0)
    return rotor().frequency_response(np.array([10.0, 20.0]), source=force, speed=10.0)


@cache
def rotor() -> gb.RotorSystem:
    shaft = gb.Shaft("input", length=0.3, outer_diameter=0.03, elements=2)
    disk = gb.Disk("pinion", "input", 0.1, mass=1.0, polar_inertia=1e-3, diametral_inertia=1e-3)
    bearings = [gb.Bearing("input", x, stiffness=1e7, damping=1e2) for x in (0.0, 0.3)]
    return gb.RotorSystem(shafts=[shaft], disks=[disk], bearings=bearings)


def table(path: Path) -> None:
    if path.suffix == ".xlsx":
        import openpyxl

        book = openpyxl.Workbook()
        for line in TABLE.splitlines():
            book.active.append([float(c) if c[0].isdigit() else c for c in line.split(",")])
        book.save(path)
    elif path.suffix == ".mat":
        from scipy.io import savemat

        savemat(path, {"speed": np.array([0.0, 100.0]), "k": np.array([1e7, 2e7])})
    else:
        path.write_text(TABLE)


def named(x: float) -> float:
    return x


def measured_value(system: float, x: float) -> float:
    return system + x


def sweep(path: Path) -> None:
    gb.sweep(named, {"x": [1.0, 2.0, 3.0]}, measured_value).save(path)


def rexs(path: Path) -> None:
    data = (Path(__file__).parent / "gearbox.rexs").read_bytes()
    if path.suffix == ".rexsj":
        data = json.dumps({"model": _from_xml(data)}).encode()
    if path.suffix == ".rexsz":
        import zipfile

        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("a.rexs", data)
    else:
        path.write_bytes(data)


TIME = np.arange(4000) * 2.5e-4
#: Directions of nodes, quantities with units, and signals of time histories: 20 revolutions per
#: second, 30 µm along −y and 40 µm along z with leads of 0.5 and −0.3 rad; pulses at angle 0.
HISTORIES = [
    ((1, -2), (8, "um"), 5.0 - 30.0 * np.cos(40.0 * np.pi * TIME + 0.5)),
    ((1, 3), (8, "mm"), 0.04 * np.cos(40.0 * np.pi * TIME - 0.3)),
    ((7, 0), (0, "V"), np.where((20.0 * TIME + 0.001) % 1.0 < 0.1, 5.0, 0.0)),
    ((9, 1), (12, "g"), 0.0 * TIME),
]


def histories(path: Path, given: Any = HISTORIES, time: Any = TIME) -> Path:
    """Write real signals at equal intervals, as programs of instruments do."""
    sets = []
    for response_, quantity, values in given:
        quantities = (Quantity(17, "s"), Quantity(*quantity), Quantity())
        lines = list(
            function_lines(Function(1, ["run"] * 5, response_, (0, 0), time, values, quantities))
        )[:11]
        lines[6] = f"{4:10d}{time.size:10d}{1:10d}{0.0:13.5E}{time[1]:13.5E}{0.0:13.5E}"
        lines += ["".join(f"{x:20.12E}" for x in values[i : i + 4]) for i in range(0, time.size, 4)]
        sets.append((58, lines))
    write(path, sets)
    return path


def ross(path: Path) -> None:
    data = ROSS.read_bytes()
    if path.suffix == ".json":
        data = json.dumps(tomllib.loads(data.decode())).encode()
    path.write_bytes(data)


def unbalanced() -> gb.RotorSystem:
    return rotor().replace(disks=[gb.Disk("pinion", "input", 0.1, 1.0, 1e-3, 1e-3, unbalance=1e-5)])


def steady(path: Path) -> None:
    unbalanced().steady_state(100.0).save(path)


def branch(path: Path) -> None:
    unbalanced().continuation("speed", 100.0, 110.0).save(path)


def text(content: str) -> Callable[[Path], None]:
    return lambda path: path.write_text(content) and None


def matrices(path: Path) -> None:
    """Write the mass and stiffness of a chain of masses."""
    given = {"M": np.diag([5.0, 4.0, 3.0]), "K": 1e6 * (3.0 * np.eye(3) - np.eye(3, k=1).T)}
    given["K"] = given["K"] + given["K"].T
    if path.suffix == ".npz":
        np.savez(path, **given)
    elif path.suffix == ".npy":
        np.save(path, given["K"])
    elif path.suffix == ".mtx":
        lines = [f"{i + 1} {j + 1} {given['K'][i, j]:.9e}" for i in range(3) for j in range(i + 1)]
        head = "%%MatrixMarket matrix coordinate real symmetric\n% chain\n3 3 6\n"
        path.write_text(head + "\n".join(lines))
    elif path.suffix == ".pch":
        lines = ["DMIG,K,0,6,2,2"]
        for j in range(3):
            lines.append(f"DMIG,K,{j + 1},3,,{j + 1},3,{given['K'][j, j]:.9e}")
        path.write_text("\n".join(lines))
    else:
        from scipy import io, sparse

        io.savemat(path, {name: sparse.csc_matrix(matrix) for name, matrix in given.items()})


def sparse_matrix(path: Path) -> None:
    from scipy import sparse

    sparse.save_npz(path, sparse.csc_matrix(3e6 * np.eye(3)))


def housing(path: Path) -> gb.Housing:
    return gb.Housing.from_matrices(
        "housing",
        mass=np.eye(3),
        stiffness=path,
        interfaces={"seat": gb.Interface((0.0, 0.0, 0.0), rows=[0, 1, 2])},
        highest_frequency=1e3,
    )


#: Each kind of file: how it is written, and how it is read.
KINDS: dict[str, tuple[Callable[[Path], Any], Callable[[Path], Any]]] = {
    "scene.toml": (lambda path: rotor().save(path), gb.RotorSystem.load),
    "run.npz": (lambda path: recorded(rows=2).save(path), gb.Response.load),
    "steady.npz": (steady, gb.SteadyState.load),
    "branch.npz": (branch, gb.results.Continuation.load),
    "map.sweep": (sweep, gb.results.Sweep.load),
    "table.csv": (table, gb.SpeedTable.read_table),
    "table.xlsx": (table, gb.SpeedTable.read_table),
    "table.mat": (table, gb.SpeedTable.read_table),
    "measured.csv": (text(MEASURED), gb.Measurement.read_csv),
    "curves.csv": (text(CURVES), lambda path: response().compare(path)),
    "curves.uff": (lambda path: response().save(path), lambda path: response().compare(path)),
    "modes.uff": (
        lambda path: rotor().modes(count=2).save(path),
        lambda path: rotor().modes(count=2).compare(path),
    ),
    "histories.uff": (
        histories,
        lambda path: gb.Measurement.read_uff(
            path, {1: ("input", 0.1), 7: gb.Tacho("input")}, revolutions=6
        ),
    ),
    "rotor.toml": (ross, gb.RotorSystem.from_ross),
    "rotor.json": (ross, gb.RotorSystem.from_ross),
    "matrices.npz": (matrices, housing),
    "sparse.npz": (sparse_matrix, housing),
    "matrix.npy": (matrices, housing),
    "matrices.mat": (matrices, housing),
    "matrix.mtx": (matrices, housing),
    "matrix.pch": (matrices, housing),
    "gearbox.rexs": (rexs, gb.rexs_contents),
    "gearbox.rexsj": (rexs, gb.rexs_contents),
    "gearbox.rexsz": (rexs, gb.rexs_contents),
}
#: Functions of the package that read bytes of a file. Each parses in `parsing`, and each kind that
#: it reads is above. Those of the command line, of locks and of checks before reading are not here.
READERS = {
    "_files.reading",
    "exchange.matrices._from_numpy",
    "exchange.tables._decoded",
    "exchange.tables._from_excel",
    "exchange.tables.read_variables",
    "exchange.rexs_file._read",
    "exchange.universal.data_sets",
    "recording.container.opened",
    "sweeps.store.read",
    "system.bodies._with_body",  # its digest refuses damage before it is parsed
}


def damaged(data: bytes, dice: random.Random) -> bytes:
    """Change, remove or insert bytes, or cut the file."""
    for _ in range(dice.choice((1, 1, 1, 2, 4))):
        at = dice.randrange(len(data) + 1)
        kind = dice.randrange(6)
        if kind < 2:
            data = data[:at] + bytes([dice.randrange(256)]) + data[at + 1 :]
        elif kind == 2:
            data = data[:at]
        elif kind == 3:
            data = data[:at] + data[at + dice.choice((1, 4, 30)) :]
        elif kind == 4:
            data = data[:at] + dice.choice(WORDS) + data[at + dice.choice((0, 1, 8)) :]
        else:
            other = dice.randrange(len(data) + 1)
            data = data[:at] + data[other : other + dice.choice((4, 40))] + data[at:]
    return data


def read_damaged(name: str, folder: Path, count: int, seed: int) -> Counter[str]:
    """Read damaged files of a kind; give the number of those read, refused and changed."""
    write, read = KINDS[name]
    path, dice = folder / name, random.Random(f"{name} {seed}")
    write(path)
    data, found = path.read_bytes(), Counter[str]()
    for _ in range(count):
        content = damaged(data, dice)
        path.write_bytes(content)
        begin = time.process_time()
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                read(path)
            found["read"] += 1
        except gb.GearbowError:
            found["refused"] += 1
        except Exception as error:  # noqa: BLE001  # counted
            found[f"{type(error).__name__}: {str(error)[:80]}"] += 1
        if time.process_time() - begin > 5.0:
            found["slow"] += 1
        # A reader leaves the file as it was.
        if path.read_bytes() != content:
            found["changed"] += 1
    return found


def test_a_wrong_place_of_the_members_of_a_workbook_is_an_error(tmp_path: Path):
    pytest.importorskip("openpyxl")
    write, read = KINDS["table.xlsx"]
    path = tmp_path / "table.xlsx"
    write(path)
    data = bytearray(path.read_bytes())
    at = (
        data.rindex(b"PK\5\6") + 16
    )  # the place of the directory, in the last record of the archive
    data[at : at + 4] = (int.from_bytes(data[at : at + 4], "little") + 1_000_000).to_bytes(
        4, "little"
    )
    path.write_bytes(data)
    with pytest.raises(gb.SceneError, match=r"table\.xlsx: is not an Excel file"):
        read(path)


WORKER = """
import pathlib, sys
from test_damaged_files import read_damaged

name, folder, count, seed = sys.argv[1:]
print(dict(read_damaged(name, pathlib.Path(folder), int(count), int(seed))))
"""


@pytest.mark.implausible
@pytest.mark.parametrize("name", KINDS)
def test_every_damaged_file_is_read_or_refused(tmp_path: Path, name: str):
    """A process of its own: a crash of a library is a failure of this test, not its end."""
    if Path(name).suffix == ".xlsx":
        pytest.importorskip("openpyxl")
    if Path(name).suffix == ".mat" or KINDS[name][1] is housing:
        pytest.importorskip("scipy")
    if name.startswith("rotor.") and not ROSS.exists():
        pytest.skip("the examples are not installed")
    # `make fuzz` reads new files in each call.
    seed = random.randrange(10**6) if COUNT > 40 else 1
    found = ast.literal_eval(printed(WORKER, name, tmp_path, COUNT, seed).splitlines()[-1])
    print(name, found)
    assert set(found) <= {"read", "refused"}, (seed, found)


def functions_with(*calls: str) -> set[str]:
    """Give the functions of the package that call one of these names."""
    found = set()
    for path in PACKAGE.rglob("*.py"):
        module = ".".join(path.relative_to(PACKAGE).with_suffix("").parts)
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for function in ast.walk(tree):
            if isinstance(function, ast.FunctionDef):
                for node in ast.walk(function):
                    if isinstance(node, ast.Call):
                        called = node.func
                        name = getattr(called, "attr", getattr(called, "id", ""))
                        if name in calls:
                            found.add(f"{module}.{function.name}")
    return found


def test_every_reader_is_tested():
    """A function that takes the bytes of a file or opens one is a reader of this list."""
    found = functions_with("read_bytes", "read_text", "open", "_connect", "loadmat", "UFF")
    others = {
        *(name for name in found if name.startswith(("_files.", "cli.", "plotting."))),
        *(f"recording.container.{name}" for name in ("header", "read")),  # of `opened`
        "exchange.rexs_file._unzipped",  # of bytes
        *(f"exchange.fmu.{name}" for name in ("__init__", "write_fmu")),  # of a unit, which is code
        "system.read.format_of",  # only tells formats apart
        "machines.examples.described",  # a file of the package
        "_sheets._write_sheet",  # opens a member of an archive that it writes
        "studies.dataset._check_card",  # any text
        *("report.page.write", "report.page.german"),  # files of the package
        *(f"sweeps.store.{name}" for name in ("_open", "write")),
    }
    assert found - others == READERS - {"_files.reading"}
    parse = functions_with("parsing", "reading")
    assert READERS - {"exchange.rexs_file._read"} <= parse
    assert "exchange.rexs_file.read_rexs_file" in parse


def test_vectors_of_matlab_are_those_of_scipy(tmp_path: Path):
    scipy = pytest.importorskip("scipy.io")
    given = {
        "speed": np.linspace(0.0, 5.0, 7),
        "k": np.arange(7.0)[:, None],
        "n": np.arange(7, dtype=np.int16),
        "x": np.array([1.5, 2.5], dtype=np.float32),
    }
    for format_, packed in (("4", False), ("5", False), ("5", True)):
        path = tmp_path / "a.mat"
        scipy.savemat(path, given, format=format_, do_compression=packed)
        found = read_vectors(path)
        assert list(found) == list(given)
        for name, values in scipy.loadmat(path).items():
            if not name.startswith("__"):
                np.testing.assert_array_equal(found[name], values.ravel())
    for wrong in ({"t": "text"}, {"z": np.array([1j, 2.0])}, {"s": {"a": 1.0}}, {"m": np.eye(2)}):
        scipy.savemat(path, wrong)
        with pytest.raises(gb.SceneError, match=r"a\.mat: .: must be a vector"):
            read_vectors(path)


def test_a_long_cell_takes_no_time(tmp_path: Path):
    begin = time.process_time()
    for cell in ("1" * 50_000 + "x", "1." * 20_000, "1" * 50_000):
        path = tmp_path / "a.csv"
        path.write_text(f"speed [rpm],k [N/um]\n0,{cell}\n")
        with pytest.raises(gb.SceneError, match=r"a\.csv"):
            gb.SpeedTable.read_table(path)
    path.write_text(f"speed [rpm],k{' ' * 50_000}x\n0,1\n")
    with pytest.raises(gb.SceneError, match=r"a\.csv: line 1: 'k .* is too long for a heading"):
        gb.SpeedTable.read_table(path)
    # Some milliseconds; with the time of the square of the length, a minute.
    assert time.process_time() - begin < 5.0
