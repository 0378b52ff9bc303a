"""Python programs in processes of their own, which can import the tests."""

from __future__ import annotations

import subprocess
import sys


def python(script: str, *given: object) -> subprocess.CompletedProcess[str]:
    """Run a program; `conftest.py` sets where it finds the tests."""
    return subprocess.run(
        [sys.executable, "-c", script, *map(str, given)],
        check=False,
        capture_output=True,
        text=True,
    )


def printed(script: str, *given: object) -> str:
    """Run a program to its end, and return what it prints."""
    ended = python(script, *given)
    assert ended.returncode == 0, ended.stderr[-2000:]
    return ended.stdout


def assert_done(script: str, *given: object) -> None:
    """Check that a program ends with the word "done"."""
    ended = python(script, *given)
    assert (ended.returncode, ended.stdout) == (0, "done\n"), ended.stderr
