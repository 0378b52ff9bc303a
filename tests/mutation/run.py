"""Plant each fault of `faults.py` in a copy of the package and check that a test fails.

    python tests/mutation/run.py [WORD ...]

With words, the script plants only faults whose module or source text contains one of them. The
exit status is 1 if the tests catch fewer than 29 of 30 faults. The script takes minutes, so the
test suite does not include it: run it after a change of the Python package or of its tests.

Every test run is a fork of this process, which has imported the large libraries but not gearbow.
"""

from __future__ import annotations

import importlib
import multiprocessing
import os
import shutil
import sys
import tempfile
import time
from importlib.util import find_spec
from pathlib import Path

import pytest
from faults import FAULTS, Fault

ROOT = Path(__file__).parents[2]
#: Fraction of the faults that the tests must catch.
WANTED = 29 / 30
#: Time limit of a test run [s]. A fault that exceeds it counts as not caught.
PATIENCE = 300.0
#: Modules that the tests import besides gearbow. They are imported once.
LIBRARIES = (
    "h5netcdf", "matplotlib.figure", "mpl_toolkits.mplot3d.art3d", "numpy", "pandas",
    "scipy.interpolate", "tqdm", "xarray",
)  # fmt: skip


def main(words: list[str]) -> int:
    """Plant the faults and print the result of each."""
    spec = find_spec("gearbow")
    if spec is None or spec.origin is None:
        raise SystemExit("gearbow is not installed")
    chosen = [
        fault
        for fault in FAULTS
        if not words or any(word in fault.module or word in fault.text for word in words)
    ]
    for name in LIBRARIES:
        importlib.import_module(name)
    # Bytecode files would hide a fault that changes neither the size nor the time stamp [s].
    sys.dont_write_bytecode = True
    caught = 0
    with tempfile.TemporaryDirectory() as folder:
        package = Path(folder) / "gearbow"
        shutil.copytree(
            Path(spec.origin).parent, package, ignore=shutil.ignore_patterns("__pycache__")
        )
        names = tuple(dict.fromkeys(name for fault in chosen for name in fault.tests))
        if outcome(package, names) != "missed":
            raise SystemExit(f"the tests fail without a fault: {', '.join(names)}")
        for fault in chosen:
            begin = time.perf_counter()
            what = plant(package, fault)
            caught += what == "caught"
            took = time.perf_counter() - begin
            change = f"{fault.text} → {fault.replacement}"
            print(f"{what:7} {took:5.1f} s  {fault.module}: {change}", flush=True)
    print(f"{caught} of {len(chosen)} faults caught")
    return int(not chosen or caught < WANTED * len(chosen))


def plant(package: Path, fault: Fault) -> str:
    """Plant one fault, run its tests, and restore the source."""
    path = package / fault.module
    source = path.read_text(encoding="utf-8")
    if source.count(fault.text) != 1:
        return "no text"
    path.write_text(source.replace(fault.text, fault.replacement), encoding="utf-8")
    try:
        return outcome(package, fault.tests)
    finally:
        path.write_text(source, encoding="utf-8")


def outcome(package: Path, names: tuple[str, ...]) -> str:
    """Give "missed" if all tests pass, "caught" if one fails, or the reason why no test ran."""
    run = multiprocessing.get_context("fork").Process(target=test, args=(package, names))
    run.start()
    run.join(PATIENCE)
    if run.is_alive():
        run.kill()
        run.join()
        return "hangs"
    return {0: "missed", 1: "caught"}.get(run.exitcode, "no run")


def test(package: Path, names: tuple[str, ...]) -> None:
    """Run test files on the copy of the package until one test fails; exit with the result."""
    os.chdir(ROOT)
    with Path(os.devnull).open("w", encoding="utf-8") as nowhere:
        os.dup2(nowhere.fileno(), 1)
        os.dup2(nowhere.fileno(), 2)
    sys.path.insert(0, str(package.parent))
    if Path(importlib.import_module("gearbow").__file__ or "").parent != package:
        sys.exit(5)  # the tests would import another package
    files = [f"tests/python/test_{name}.py" for name in names]
    # The tests of interrupts depend on how fast a shared machine is.
    options = ["-x", "-q", "-p", "no:cacheprovider", "-k", "not ctrl_c"]
    try:
        code = int(pytest.main([*options, *files]))
    except Exception:  # noqa: BLE001  # an error of pytest itself must not count as a failed test
        code = 3
    sys.exit(code)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
