"""From the parts that a user writes to the plain description that the core checks, and back.

Nothing physical is checked here: a part says what it was given, the core says whether that can be.
What only Python can get wrong, an object of the wrong class, is a `SceneError` with its path like
every other.
"""

import dataclasses
import numbers
from collections.abc import Iterable, Mapping
from typing import Any, TypeVar

import numpy as np

from gearbow._types import At, Plain
from gearbow.errors import SceneError

P = TypeVar("P", bound="Part")


class Part:
    """Base of every dataclass that describes a piece of a system."""

    def _describe(self, path: str) -> dict[str, Plain]:
        """Give the fields that differ from their default as plain data.

        A default is left to the core: it is stated once, and an option that was not given cannot
        contradict one that was.
        """
        given = {}
        for field in dataclasses.fields(self):  # type: ignore[arg-type]  # every Part is a dataclass
            value = getattr(self, field.name)
            if not _is_default(value, field.default):
                given[field.name] = plain(value, f"{path}.{field.name}")
        return given

    @classmethod
    def _from_description(cls: type[P], description: Mapping[str, Plain]) -> P:
        """Give the part back from its plain description."""
        return cls(**description)


def plain(value: object, path: str) -> Plain:
    """Turn a value into dict, list, str, bool, int and float; complex becomes [re, im]."""
    if isinstance(value, Part):
        return value._describe(path)
    if isinstance(value, np.ndarray):
        return plain(value.tolist(), path)
    if isinstance(value, (str, bool, np.bool_)):
        return value if isinstance(value, str) else bool(value)
    if isinstance(value, numbers.Integral):
        return int(value)
    if isinstance(value, numbers.Real):
        return float(value)
    if isinstance(value, numbers.Complex):
        return [float(value.real), float(value.imag)]
    if isinstance(value, Mapping):
        return {str(key): plain(item, f"{path}.{key}") for key, item in value.items()}
    if isinstance(value, Iterable):
        return [plain(item, f"{path}[{i}]") for i, item in enumerate(value)]
    raise SceneError(f"{path}: must be a number, text or an array, got {value!r}")


def freeze(part: Part, *names: str) -> None:
    """Make lists of a part, of whatever kind they were given, tuples that compare and hash."""
    for name in names:
        value = getattr(part, name)
        if value is not None:
            object.__setattr__(part, name, _tuples(plain(value, name)))


def _tuples(value: Plain) -> Plain:
    # What is not a list is wrong, and the core says so where it stands.
    return tuple(_tuples(item) for item in value) if isinstance(value, list) else value


def expect(value: object, kind: type[P], path: str) -> P:
    """Give the value back if it is of the class that belongs here."""
    if not isinstance(value, kind):
        raise SceneError(f"{path}: must be a gb.{kind.__name__}, got {value!r}")
    return value


def parts(given: Iterable[P], kind: type[P], path: str) -> tuple[P, ...]:
    """Collect a list of parts of one class."""
    if isinstance(given, (str, bytes, Mapping)) or not isinstance(given, Iterable):
        raise SceneError(f"{path}: must be a list of gb.{kind.__name__}, got {given!r}")
    return tuple(expect(part, kind, f"{path}[{i}]") for i, part in enumerate(given))


def place(at: object) -> Any:
    """Turn (shaft, position) with NumPy numbers into plain Python; names pass."""
    if isinstance(at, (tuple, list)):
        return tuple(item if isinstance(item, str) else plain(item, "at") for item in at)
    return at


def is_place(at: object) -> bool:
    """Tell whether this is (shaft, position)."""
    return (
        isinstance(at, tuple)
        and len(at) == 2
        and isinstance(at[0], str)
        and isinstance(at[1], numbers.Real)
    )


def is_pair(at: object) -> bool:
    """Tell whether this is (driver, driven)."""
    return isinstance(at, tuple) and len(at) == 2 and all(isinstance(name, str) for name in at)


def places(given: At | Iterable[At]) -> list[At]:
    """Collect names and (shaft, position) from one of them or from several."""
    if isinstance(given, str) or is_place(given):
        return [place(given)]
    return [place(at) for at in given]


def complex_number(value: Plain) -> complex | float:
    """Read a complex number of a description: a real one or [re, im]."""
    return complex(*value) if isinstance(value, (list, tuple)) else value


def _is_default(value: object, default: object) -> bool:
    # An array has no truth value to compare by; no default is one.
    return value is None or (isinstance(value, (numbers.Number, str, Part)) and value == default)
