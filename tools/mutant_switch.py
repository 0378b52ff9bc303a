"""Switch one mutant of the Python package on, and record which tests reach which mutants.

`tools/mutants.py` writes calls of `is_active` into a copy of the package, and loads this module as
a plugin of pytest. The environment variable GEARBOW_MUTANT names the mutant that is switched on.
GEARBOW_RECORD names the file that the record is appended to, one JSON object a line: a mutant and
the test that reached it; or a test, its phase, duration [s] and outcome; or a test and the number
of its cases, of which the first runs. The processes that a test
starts inherit both variables, and the name of the test from pytest.
"""

from __future__ import annotations

import json
import os
import signal
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from collections.abc import Generator

ACTIVE = os.environ.get("GEARBOW_MUTANT")
RECORD = os.environ.get("GEARBOW_RECORD")
#: Time limit of one phase of a test while the record is made [s]; 0 is none.
LIMIT = float(os.environ.get("GEARBOW_TEST_LIMIT", "0"))

_reached: set[str] = set()


def is_active(mutant: str) -> bool:
    """Return whether a mutant is switched on. The first call in a phase of a test is recorded."""
    if RECORD and mutant not in _reached:
        _reached.add(mutant)
        # pytest writes the name of the test and its phase: NAME (call).
        test = os.environ.get("PYTEST_CURRENT_TEST", "").rpartition(" (")
        _write({"mutant": mutant, "test": test[0], "when": test[2].rstrip(")")})
    return mutant == ACTIVE


def _write(entry: dict[str, Any]) -> None:
    """Append a line to the record; one call, so that lines of several processes do not mix."""
    file = os.open(str(RECORD), os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o644)
    os.write(file, (json.dumps(entry) + "\n").encode())
    os.close(file)


def _end(_signal: int, _frame: object) -> None:
    pytest.fail("exceeds the time limit of a test")


def _limited() -> Generator[None, Any, Any]:
    """Run a phase of a test: forget what was reached before, and end it at the time limit."""
    from gearbow import _core  # noqa: PLC0415 - coverage of the import belongs to the tests

    _reached.clear()
    _core.forget_reached()  # type: ignore[attr-defined]  # of the copy
    signal.signal(signal.SIGALRM, _end)
    signal.setitimer(signal.ITIMER_REAL, LIMIT)
    try:
        return (yield)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)


if RECORD:

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_setup() -> Generator[None, Any, Any]:
        """Record what the fixtures of a test reach."""
        return (yield from _limited())

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_call() -> Generator[None, Any, Any]:
        """Record what a test reaches."""
        return (yield from _limited())

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport() -> Generator[None, Any, Any]:
        """Record the duration and the outcome of a phase of a test."""
        report: Any = yield
        _write(
            {
                "test": report.nodeid,
                "when": report.when,
                "duration": report.duration,
                "outcome": report.outcome,
            }
        )
        return report

    def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
        """Keep one case of each test, and leave out what an earlier record has to its end."""
        record = Path(str(RECORD))
        earlier = [path for path in record.parent.glob(f"*{record.suffix}") if path != record]
        lines = [line for path in earlier for line in path.read_text("utf-8").splitlines()]
        entries = [json.loads(line) for line in lines]
        ended = {entry["test"] for entry in entries if entry.get("when") == "teardown"}
        cases: dict[str, list[pytest.Item]] = {}
        for item in items:
            cases.setdefault(item.nodeid.split("[", maxsplit=1)[0], []).append(item)
        items[:] = [each[0] for each in cases.values() if each[0].nodeid not in ended]
        for first, *others in cases.values():
            if others:
                _write({"test": first.nodeid, "cases": 1 + len(others)})
