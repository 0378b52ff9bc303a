"""Shared fixture of the tests at extreme parameters.

It checks a guarantee and records its margin.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "python")]


@pytest.fixture
def hold(record_property: Callable[[str, object], None]) -> Callable[..., None]:
    """Return a function hold(promise, through, found, allowed, beyond) that asserts found < allowed.

    `promise` is the guaranteed property, `through` the tested range, `found` the largest error in this range and
    `allowed` its tolerance. `beyond` describes the warning or error at the limit. `limits.py` prints these values as
    the tables of docs/limits.md.
    """

    def holds(promise: str, through: str, found: float, allowed: float, beyond: str = "") -> None:
        record_property("limit", (promise, through, float(found), float(allowed), beyond))
        assert found < allowed

    return holds
