"""Full disks, killed processes and shared files: no file is lost or incomplete."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import gearbow as gb
from gearbow._files import FileLock, replacing
from reference.cases import each_case
from reference.machines import bowed_pair
from reference.processes import assert_done, python
from test_checkpoint import RUNS, EnoughError, Pause, Stop, asked
from test_persistence import assert_same
from test_response import recorded

SUFFIXES = [".npz", ".nc", ".toml"]
posix = pytest.mark.skipif(os.name != "posix", reason="signals and limits of a process")


def names(folder: Path) -> list[str]:
    return sorted(entry.name for entry in folder.iterdir())


def big() -> gb.RotorSystem:
    """Return a system whose description is larger than the disk limits of these tests."""
    system = bowed_pair()
    disks = [
        gb.Disk(f"disk {i}", "input", 0.25, mass=1e-3, polar_inertia=1e-6, diametral_inertia=1e-6)
        for i in range(1200)
    ]
    return gb.RotorSystem(
        system.shafts, system.gears, system.meshes, system.bearings, system.torques, disks=disks
    )


def write(path: Path, *, small: bool = False) -> None:
    """Write a file in the format of the suffix, larger than 100 kB unless it is small."""
    if path.suffix == ".toml":
        (bowed_pair() if small else big()).save(path)
    else:
        recorded(rows=5 if small else 1000).save(path)


def read(path: Path) -> Any:
    if path.suffix == ".toml":
        return gb.RotorSystem.load(path).description
    if path.suffix == ".npz":
        return gb.Response.load(path)
    import xarray

    with xarray.open_dataset(path, engine="h5netcdf", decode_times=False) as data:
        return data.load()


# --- a full disk ----------------------------------------------------------------------------------

LIMITED = """
import pathlib, resource, sys
from test_file_failures import names, write

path = pathlib.Path(sys.argv[1])
soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)

def full(limit):
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, hard))
    try:
        write(path)
    except OSError as error:
        assert error.filename == str(path), error
        assert "cannot be written and is unchanged" in str(error), error
    else:
        raise SystemExit(f"{limit} bytes were enough")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))

for limit in (100, 20_000, 60_000):
    full(limit)
    assert names(path.parent) == [], names(path.parent)
write(path, small=True)
before = path.read_bytes()
for limit in (100, 20_000, 60_000):
    full(limit)
    assert path.read_bytes() == before
    assert names(path.parent) == [path.name], names(path.parent)
write(path)
print("done")
"""


@posix
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_file_that_does_not_fit_leaves_the_previous_file(tmp_path, suffix):
    assert_done(LIMITED, tmp_path / f"file{suffix}")
    read(tmp_path / f"file{suffix}")


@pytest.fixture
def small_disk(tmp_path):
    """Mount a disk of 100 kB, if the tests are allowed to."""
    folder = tmp_path / "disk"
    folder.mkdir()
    try:
        mounted = subprocess.run(
            ["mount", "-t", "tmpfs", "-o", "size=100k", "tmpfs", folder],
            check=False,
            capture_output=True,
        )
    except FileNotFoundError:
        pytest.skip("there is no mount")
    if mounted.returncode:
        pytest.skip("it is not permitted to mount a disk")
    yield folder
    subprocess.run(["umount", folder], check=True)


SHORT = """
import pathlib, resource, sys
from test_file_failures import read, write
from test_response import recorded

path = pathlib.Path(sys.argv[1])
write(path, small=True)  # imports the libraries
run = recorded(rows=500_000)
used = int(pathlib.Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + 40_000_000, resource.RLIM_INFINITY))
run.save(path)
resource.setrlimit(resource.RLIMIT_AS, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
assert path.stat().st_size > 80_000_000
read(path).displacement.equals(run.to_xarray().displacement) or sys.exit("other values")
print("done")
"""


@pytest.mark.skipif(sys.platform != "linux", reason="the limit of the address space is Linux's")
def test_a_netcdf_file_needs_no_memory_of_its_size(tmp_path):
    assert_done(SHORT, tmp_path / "run.nc")


FULL = """
import pathlib, sys
from test_file_failures import write

try:
    write(pathlib.Path(sys.argv[1]))
except OSError as error:
    print(error.errno, error.filename)
"""


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_full_disk_is_an_error_of_the_system(small_disk, suffix):
    import errno

    path = small_disk / f"file{suffix}"
    write(path, small=True)
    before = path.read_bytes()
    ended = python(FULL, path)
    assert (ended.returncode, ended.stdout) == (0, f"{errno.ENOSPC} {path}\n"), ended.stderr
    assert path.read_bytes() == before
    assert names(small_disk) == [path.name]


CHECKPOINT = """
import pathlib, resource, sys, warnings
import gearbow as gb
from test_checkpoint import RUNS, Pause, asked
from test_file_failures import names
from test_persistence import assert_same

path, limit = pathlib.Path(sys.argv[1]), int(sys.argv[2])
system, options = RUNS["smooth"][0].package(), asked("smooth")
whole = system.simulate(**options)
before = names(path.parent), [entry.read_bytes() for entry in path.parent.iterdir()]
soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
resource.setrlimit(resource.RLIMIT_FSIZE, (limit, hard))
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    found = system.simulate(**options, checkpoint=path, checkpoint_interval=1e-9, progress=Pause())
resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
assert caught and all(entry.category is gb.CheckpointWarning for entry in caught), caught
assert "could not be written and is unchanged" in str(caught[0].message)
assert_same(found, whole)
assert (names(path.parent), [entry.read_bytes() for entry in path.parent.iterdir()]) == before
print("done")
"""


@posix
@pytest.mark.parametrize("there", [True, False])
def test_a_full_disk_does_not_end_a_run(tmp_path, there):
    path = tmp_path / "run.npz"
    system, options = RUNS["smooth"][0].package(), asked("smooth")
    if there:
        with pytest.raises(EnoughError):
            system.simulate(**options, checkpoint=path, progress=Stop(Pause()))
    # A checkpoint of this run has more than 20 kB.
    assert_done(CHECKPOINT, path, 100 if there else 10_000)
    assert_same(system.simulate(**options, checkpoint=path), system.simulate(**options))


# --- killed processes ------------------------------------------------------------------------

#: Repeatedly start an endless writer and kill it at a random time after its first file.
#: Every process is a fork of this one, so that nothing is imported again.
KILLS = """
import os, pathlib, random, signal, sys, time
import gearbow as gb
from reference.machines import bowed_pair
from test_checkpoint import RUNS, asked
from test_file_failures import big, read, write

path, chance = pathlib.Path(sys.argv[1]), random.Random(11)
system, options = RUNS["smooth"][0].package(), asked("smooth")
texts = [bowed_pair().description, big().description]

def work():
    while path.suffix != ".npz":
        write(path, small=True)
        write(path)
    system.simulate(**options, checkpoint=path, checkpoint_interval=1e-9, progress=lambda _: time.sleep(0.06))
    os._exit(0)

for attempt in range(10):
    child = os.fork()
    if not child:
        work()
    while not path.exists() and not os.waitpid(child, os.WNOHANG)[0]:
        time.sleep(0.001)
    time.sleep(chance.uniform(0.0, 0.3))
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    found = read(path)
    assert path.suffix != ".toml" or found in texts
print("done")
"""


@posix
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_killed_writer_leaves_a_complete_file(tmp_path, suffix):
    path = tmp_path / f"run{suffix}"
    assert_done(KILLS, path)
    if suffix == ".npz":
        system, options = RUNS["smooth"][0].package(), asked("smooth")
        assert_same(system.simulate(**options, checkpoint=path), system.simulate(**options))
    write(path, small=True)  # A complete checkpoint is only read; the next writer cleans up.
    assert suffix != ".toml" or read(path) == bowed_pair().description
    left = [name for name in names(tmp_path) if not name.endswith(".lock")]
    assert left == [path.name]


# --- shared files ----------------------------------------------------------------------

OWNER = """
import sys, time
from test_checkpoint import RUNS, asked

def progress(fraction):
    print(fraction, flush=True)
    time.sleep(0.06 if fraction == 0.0 else 3600.0)

RUNS["smooth"][0].package().simulate(**asked("smooth"), checkpoint=sys.argv[1], checkpoint_interval=1e-9, progress=progress)
"""


@posix
def test_a_second_process_is_refused_until_the_first_has_ended(tmp_path):
    path = tmp_path / "run.npz"
    system, options = RUNS["smooth"][0].package(), asked("smooth")
    command = [sys.executable, "-c", OWNER, path]
    with subprocess.Popen(command, cwd=Path(__file__).parents[1], stdout=subprocess.PIPE) as owner:
        assert owner.stdout is not None
        try:
            while float(owner.stdout.readline()) == 0.0:
                pass
            with pytest.raises(
                gb.SceneError, match=r"run\.npz is in use by another run.*a file of its own"
            ):
                system.simulate(**options, checkpoint=path)
        finally:
            owner.kill()
        owner.wait()
    assert_same(system.simulate(**options, checkpoint=path), system.simulate(**options))
    assert names(tmp_path) == [path.name]


def test_a_second_run_in_one_process_is_refused(tmp_path):
    path = tmp_path / "run.npz"
    system, options = RUNS["smooth"][0].package(), asked("smooth")
    refused = []

    def progress(_: float) -> None:
        if not refused:
            with pytest.raises(gb.SceneError, match="in use by another run") as caught:
                system.simulate(**options, checkpoint=path)
            refused.append(caught)

    found = system.simulate(**options, checkpoint=path, progress=progress)
    assert refused
    assert_same(found, system.simulate(**options))
    assert names(tmp_path) == [path.name]
    # Any number of processes can read a complete file.
    lock = FileLock(path, "checkpoint", "run")
    lock.acquire()
    assert_same(system.simulate(**options, checkpoint=path), found)
    lock.release()


WRITERS = """
import os, pathlib, sys
from test_file_failures import read, write

path, writers = pathlib.Path(sys.argv[1]), []
write(path)
for small in (True, False, True):
    child = os.fork()
    if not child:
        for _ in range(6):
            write(path, small=small)
        os._exit(0)
    writers.append(child)
loads = 0
while writers:
    read(path)
    loads += 1
    if os.waitpid(writers[0], os.WNOHANG)[0]:
        writers.pop(0)
print("done" if loads > 3 else loads)
"""


@posix
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_writers_of_one_file_do_not_disturb_each_other(tmp_path, suffix):
    path = tmp_path / f"file{suffix}"
    assert_done(WRITERS, path)
    assert names(tmp_path) == [path.name]


# --- the writer and the lock ----------------------------------------------------------------------


@posix
def test_a_file_has_default_permissions_and_keeps_changed_ones(tmp_path):
    path, other = tmp_path / "rotor.toml", tmp_path / "other"
    bowed_pair().save(path)
    other.touch()
    assert path.stat().st_mode == other.stat().st_mode
    path.chmod(0o600)
    bowed_pair().save(path)
    assert path.stat().st_mode & 0o777 == 0o600


@posix
def test_links_and_devices_are_not_replaced(tmp_path):
    (tmp_path / "folder").mkdir()
    link = tmp_path / "rotor.toml"
    link.symlink_to(tmp_path / "folder" / "rotor.toml")
    bowed_pair().save(link)
    assert link.is_symlink()
    assert read(tmp_path / "folder" / "rotor.toml") == bowed_pair().description
    os.mkfifo(tmp_path / "pipe.toml")
    (tmp_path / "folder.toml").mkdir()
    for target in (tmp_path / "pipe.toml", tmp_path / "folder.toml"):
        with pytest.raises(OSError, match="cannot be written and is unchanged") as caught:
            bowed_pair().save(target)
        assert str(target) in str(caught.value)
    with pytest.raises(FileNotFoundError, match="missing"):
        bowed_pair().save(tmp_path / "missing" / "rotor.toml")
    assert names(tmp_path) == ["folder", "folder.toml", "pipe.toml", "rotor.toml"]


@posix
def test_remains_of_killed_writers_are_removed(tmp_path):
    path = tmp_path / "file"
    remains = tmp_path / f".file.{16 * '0'}.part"
    foreign = tmp_path / ".file.notes.part"
    for left in (remains, foreign):
        left.touch()
    with replacing(path) as first:
        first.write(b"1")
        assert not remains.exists()
        with replacing(path) as second:
            second.write(b"2")
            assert len(names(tmp_path)) == 3
    assert path.read_bytes() == b"1"
    assert names(tmp_path) == [foreign.name, path.name]


@posix
def test_a_lock_is_released_with_its_file(tmp_path):
    first, second = (FileLock(tmp_path / "run.npz", "checkpoint", "run") for _ in range(2))
    first.acquire()
    assert names(tmp_path) == [".run.npz.lock"]
    first.release()
    first.release()
    assert names(tmp_path) == []
    second.acquire()
    second.release()
    (tmp_path / ".run.npz.lock").touch()  # the lock of a killed run
    first.acquire()
    first.release()
    assert names(tmp_path) == []


def test_long_names_with_a_common_beginning_have_locks_of_their_own(tmp_path):
    beginning = "map of the mesh force over speed and bow, " * 5
    paths = [tmp_path / f"{beginning}{i}.sweep" for i in range(2)]
    paths += [tmp_path / f"{beginning[:45]}{i}.sweep" for i in range(2)]
    locks = [FileLock(path, "store", "sweep") for path in paths]
    for lock in locks:
        lock.acquire()
    with pytest.raises(gb.SceneError, match=r"^store: .*1.sweep is in use by another sweep"):
        FileLock(paths[1], "store", "sweep").acquire()
    for lock in locks:
        lock.release()
    for path in paths:
        with replacing(path) as file:
            file.write(b"1")
    assert names(tmp_path) == sorted(path.name for path in paths)


@posix
def test_a_loop_of_links_is_an_error_of_the_system(tmp_path):
    (tmp_path / "a.toml").symlink_to(tmp_path / "b.toml")
    (tmp_path / "b.toml").symlink_to(tmp_path / "a.toml")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    for path in (tmp_path / "a.toml", tmp_path / "loop" / "a.toml"):
        with pytest.raises(OSError, match=r"(Too many levels|Symlink loop|symbolic links)"):
            bowed_pair().save(path)
        with pytest.raises(OSError, match="Too many levels"):
            gb.RotorSystem.load(path)
    (tmp_path / "a.npz").symlink_to(tmp_path / "a.npz")
    system, options = RUNS["smooth"][0].package(), asked("smooth")
    with pytest.raises(gb.SceneError, match=r"^checkpoint: .*Too many levels"):
        system.simulate(**options, checkpoint=tmp_path / "a.npz")


STDOUT = """
import sys
from test_response import recorded

link = sys.argv[1]
try:
    recorded().save(link)
except OSError as error:
    sys.stderr.write(str(error))
print("printed before")
"""


@posix
def test_a_link_to_stdout_does_not_replace_the_redirected_file(tmp_path):
    link, out = tmp_path / "link.npz", tmp_path / "out"
    link.symlink_to("/dev/stdout")
    with out.open("wb") as file:
        subprocess.run(
            [sys.executable, "-c", STDOUT, str(link)],
            cwd=Path(__file__).parents[1],
            check=True,
            stdout=file,
        )
    assert out.read_text() == "printed before\n"
    assert sorted(names(tmp_path)) == ["link.npz", "out"]


@each_case("path", ["", "rotor", "rotor.npz", "rotor\0.toml", 3, None, b"rotor.toml"])
def test_a_name_that_is_no_file_of_a_known_format_is_refused(path):
    with pytest.raises(gb.SceneError, match=r"^path: must (be the name of a file|end with \.toml)"):
        bowed_pair().save(path)
    with pytest.raises(gb.SceneError, match=r"^path: must (be the name of a file|end with \.npz)"):
        recorded().save(path if path != "rotor.npz" else "rotor.toml")


def test_a_folder_without_locks_is_an_error(tmp_path, monkeypatch):
    system, options = RUNS["smooth"][0].package(), asked("smooth")

    def none(*_: object) -> None:
        raise OSError(30, os.strerror(30))

    monkeypatch.setattr("gearbow._files._lock", none)
    with pytest.raises(
        gb.SceneError, match=r"^checkpoint: .*run\.npz cannot be protected from other runs"
    ):
        system.simulate(**options, checkpoint=tmp_path / "run.npz")
