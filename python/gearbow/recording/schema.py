"""Checks of plain data: the valid values of each entry of a file, as a table of small functions.

A check receives a value and its path in the file. It raises `GearbowError` for an invalid value.
`record`, `entries`, `each`, `row` and `optional` combine checks.
"""

import reprlib
import sys
from collections.abc import Callable
from typing import Any, TypeAlias

from gearbow.errors import GearbowError

Check: TypeAlias = Callable[[Any, str], None]

#: Counters are 64-bit integers in the core.
_MOST = 2**63 - 1


def _refuse(where: str, must: str, value: object) -> GearbowError:
    return GearbowError(f"{where}: must be {must}, got {reprlib.repr(value)}")


def text(value: Any, where: str) -> None:
    """Accept a string."""
    if not isinstance(value, str):
        raise _refuse(where, "a text", value)


def whole(value: Any, where: str) -> None:
    """Accept a whole number from 0 to 2⁶³ - 1."""
    if type(value) is not int or not 0 <= value <= _MOST:
        raise _refuse(where, "a whole number, not negative and below 2**63", value)


def number(value: Any, where: str) -> None:
    """Accept a finite number."""
    if type(value) not in {int, float} or not abs(value) <= sys.float_info.max:
        raise _refuse(where, "a finite number", value)


def any_number(value: Any, where: str) -> None:
    """Accept a number, infinity or NaN."""
    if type(value) is not float:
        number(value, where)


def flag(value: Any, where: str) -> None:
    """Accept True and False."""
    if not isinstance(value, bool):
        raise _refuse(where, "true or false", value)


def anything(value: Any, where: str) -> None:
    """Accept every value: another part of the program checks it."""


def optional(check: Check) -> Check:
    """Accept None and every value that `check` accepts."""

    def checked(value: Any, where: str) -> None:
        if value is not None:
            check(value, where)

    return checked


def each(check: Check) -> Check:
    """Accept a list whose entries all pass."""

    def checked(value: Any, where: str) -> None:
        if not isinstance(value, list | tuple):
            raise _refuse(where, "a list", value)
        for i, entry in enumerate(value):
            check(entry, f"{where}[{i}]")

    return checked


def entries(check: Check) -> Check:
    """Accept a mapping whose values all pass."""

    def checked(value: Any, where: str) -> None:
        record()(value, where)
        for name, entry in value.items():
            check(entry, f"{where}.{name}")

    return checked


def row(*checks: Check) -> Check:
    """Accept a list of as many entries as there are checks."""

    def checked(value: Any, where: str) -> None:
        if not isinstance(value, list | tuple) or len(value) != len(checks):
            raise _refuse(where, f"a list of {len(checks)} entries", value)
        for i, (entry, check) in enumerate(zip(value, checks, strict=True)):
            check(entry, f"{where}[{i}]")

    return checked


def record(**checks: Check) -> Check:
    """Accept a mapping that has these entries; it may have others."""

    def checked(value: Any, where: str) -> None:
        if not isinstance(value, dict):
            raise _refuse(where, "a mapping", value)
        for name, check in checks.items():
            place = f"{where}.{name}".lstrip(".")
            if name not in value:
                raise GearbowError(f"{place}: is missing")
            check(value[name], place)

    return checked
