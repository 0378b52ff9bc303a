"""Differences between two pieces of plain data: why a file belongs to other work."""

import reprlib
from collections.abc import Iterator
from typing import Any


def short(value: Any) -> str:
    """Format a value of a file for a message, shortened if necessary."""
    return str(value) if isinstance(value, str | float | int | None) else reprlib.repr(value)


def differences(was: Any, now: Any, where: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Find the differences between two pieces of plain data."""
    if isinstance(was, dict) and isinstance(now, dict):
        for name in {**was, **now}:
            place = f"{where}.{name}".lstrip(".")
            yield from differences(was.get(name), now.get(name), place)
    elif isinstance(was, list) and isinstance(now, list) and len(was) == len(now):
        for i, (a, b) in enumerate(zip(was, now, strict=True)):
            yield from differences(a, b, f"{where}[{i}]")
    elif repr(was) != repr(now):
        yield where, was, now
