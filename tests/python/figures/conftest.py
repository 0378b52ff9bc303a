"""Shared set-up of the tests of figures."""

from __future__ import annotations

import contextlib

import pytest

with contextlib.suppress(ImportError):
    import matplotlib as mpl


@pytest.fixture(autouse=True)
def unchanged_settings():
    """Check that no figure changes the settings of matplotlib."""
    before = dict(mpl.rcParams) if "mpl" in globals() else None
    yield
    assert before is None or dict(mpl.rcParams) == before
