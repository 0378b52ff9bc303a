"""The package on systems without the modules and functions of Unix.

A process of its own hides them, and treats open files as Windows does: they can be neither removed
nor renamed. It finds open files in /proc.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from reference.processes import printed

WITHOUT_UNIX = """
import fcntl, os, pathlib, sys, types
import concurrent.futures, multiprocessing, sqlite3, subprocess, tempfile  # they need Unix here

def locking(number, mode, size):
    try:
        fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise PermissionError(13, "Permission denied") from None

sys.modules["msvcrt"] = types.SimpleNamespace(locking=locking, LK_NBLCK=2)

def refuses_open_files(method):
    def call(path, *given, **named):
        files = [path.absolute(), *(pathlib.Path(one).absolute() for one in given)]
        for name in os.listdir("/proc/self/fd"):
            try:
                target = pathlib.Path(os.readlink(f"/proc/self/fd/{name}"))
            except OSError:
                continue
            if target in files:
                raise PermissionError(13, "The process cannot access the file", str(target))
        return method(path, *given, **named)
    return call

for name in ("unlink", "rename", "replace"):
    setattr(pathlib.Path, name, refuses_open_files(getattr(pathlib.Path, name)))
hidden = {"fcntl", "grp", "pwd", "resource", "syslog", "termios"}
for name in hidden:
    sys.modules[name] = None
for name in ("O_NOFOLLOW", "fork", "posix_fallocate", "sched_getaffinity"):
    delattr(os, name)
"""
linux = pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")


def without_unix(script: str, *given: object) -> str:
    """Run a script without the modules and functions of Unix, and return what it prints."""
    return printed(WITHOUT_UNIX + script, *given)


@linux
def test_every_module_imports_without_the_modules_of_unix():
    printed = without_unix("""
import importlib, pkgutil
import gearbow
names = [one.name for one in pkgutil.walk_packages(gearbow.__path__, "gearbow.")]
for name in names:
    if not name.endswith("__main__"):
        importlib.import_module(name)
assert gearbow._files.fcntl is None
print(len(names))
""")
    assert int(printed) > 50


@linux
def test_files_are_written_replaced_and_locked_without_unix(tmp_path: Path):
    without_unix(
        """
import gearbow as gb
from reference.machines import bowed_pair
from test_file_failures import names, read
from test_response import recorded

folder = pathlib.Path(sys.argv[1])
for rows in (5, 10):
    for suffix in (".npz", ".nc"):
        recorded(rows=rows).save(folder / f"run{suffix}")
        assert read(folder / f"run{suffix}").time.size == rows
bowed_pair().save(folder / "train.toml")
assert gb.RotorSystem.load(folder / "train.toml").description == bowed_pair().description

lock, other = (gb._files.FileLock(folder / "run.npz", "checkpoint", "run") for _ in range(2))
lock.acquire()
try:
    other.acquire()
except gb.SceneError as error:
    assert "is in use by another run" in str(error), error
else:
    raise SystemExit("two owners of one lock")
lock.release()
other.acquire()
other.release()

def square(value):
    return {"square": value**2}

for values in ([1.0, 2.0], [1.0, 2.0]):
    gb.sweep(square, {"value": values}, lambda found, value: found, store=folder / "s.sweep")
bowed_pair().simulate(1e-3, 100.0, output_step=1e-5, checkpoint=folder / "c.npz")
assert names(folder) == ["c.npz", "run.nc", "run.npz", "s.sweep", "train.toml"], names(folder)
""",
        tmp_path,
    )


@linux
def test_the_program_runs_without_unix(tmp_path: Path):
    printed = without_unix(
        """
from gearbow.cli.main import main
scene, out = pathlib.Path(sys.argv[1]) / "train.toml", pathlib.Path(sys.argv[1]) / "run.npz"
for given in (
    ["new", str(scene)],
    ["run", str(scene), "--duration", "1 ms", "--speed", "100", "--out", str(out)],
):
    try:
        main(given)
    except SystemExit as end:
        assert end.code == 0, end.code
""",
        tmp_path,
    )
    assert "run.npz" in printed


@linux
def test_a_file_that_another_program_reads_for_a_moment_is_replaced(tmp_path: Path):
    without_unix(
        """
import threading
from gearbow._files import replacing

path = pathlib.Path(sys.argv[1]) / "run.npz"
path.write_bytes(b"old")
reader = path.open("rb")
threading.Timer(0.1, reader.close).start()
with replacing(path) as file:
    file.write(b"new")
assert path.read_bytes() == b"new"

with path.open("rb"):
    try:
        with replacing(path) as file:
            file.write(b"newer")
    except PermissionError as error:
        assert error.filename == str(path), error
    else:
        raise SystemExit("replaced an open file")
assert path.read_bytes() == b"new"
assert os.listdir(path.parent) == ["run.npz"]
""",
        tmp_path,
    )


@linux
def test_abandoned_temporary_files_are_removed_when_they_are_old(tmp_path: Path):
    old, new, opened = (tmp_path / f".run.npz.{digit * 16}.part" for digit in "012")
    for part in (old, new, opened):
        part.write_bytes(b"part")
    for part in (old, opened):
        os.utime(part, (0.0, 0.0))
    without_unix(
        """
from gearbow._files import replacing

folder = pathlib.Path(sys.argv[1])
with pathlib.Path(sys.argv[2]).open("rb"), replacing(folder / "run.npz") as file:
    file.write(b"new")
""",
        tmp_path,
        opened,
    )
    assert not old.exists()
    assert new.exists()
    assert opened.exists()


@pytest.mark.skipif(os.name != "posix", reason="links")
def test_a_link_to_a_file_that_a_program_has_opened_is_refused(tmp_path: Path):
    from gearbow._files import check_output

    link = tmp_path / "run.npz"
    link.symlink_to("/dev/fd/1")
    with pytest.raises(OSError, match="it is a device, not a file"):
        check_output(link)
