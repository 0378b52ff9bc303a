"""Shared set-up of the tests at the extremes: a fixture that holds a promise and notes how far it was from breaking."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "python")]


@pytest.fixture
def hold(record_property: Callable[[str, object], None]) -> Callable[..., None]:
    """hold(promise, through, found, allowed, beyond): `limits.py` prints what was held, docs/limits.md keeps it.

    `found` is the largest error met while the range `through` was driven through, `beyond` what happens outside it.
    """

    def holds(promise: str, through: str, found: float, allowed: float, beyond: str = "") -> None:
        record_property("limit", (promise, through, float(found), float(allowed), beyond))
        assert found < allowed

    return holds
