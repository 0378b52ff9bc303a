"""Names and places: a gear or disk by its name, or a position on a shaft."""

import numbers
from collections.abc import Iterable, Mapping
from typing import Any

from gearbow._convert import BYTES, real, shown
from gearbow.description.supports import Housing, Support
from gearbow.errors import SceneError
from gearbow.units.convert import is_quantity

__all__ = ["is_pair", "is_place", "names_of_bases", "place", "place_label", "places"]


def place(at: object, path: str = "at") -> Any:
    """Convert a name, (shaft, position) or another recorded item to plain Python."""
    if isinstance(at, str):
        return at
    if isinstance(at, (tuple, list)) and len(at) in (2, 3) and isinstance(at[0], str):
        return tuple(
            item if isinstance(item, str) else real(item, f"{path}[{i}]", "a name or a number")
            for i, item in enumerate(at)
        )
    raise SceneError(
        f"{path}: must be a name or a tuple such as (shaft, position), got {shown(at)}"
    )


def is_place(at: object) -> bool:
    """Return whether this is (shaft, position)."""
    return (
        isinstance(at, tuple)
        and len(at) == 2
        and isinstance(at[0], str)
        and (isinstance(at[1], numbers.Real) or is_quantity(at[1]))
    )


def is_pair(at: object) -> bool:
    """Return whether this is (driver, driven)."""
    return isinstance(at, tuple) and len(at) == 2 and all(isinstance(name, str) for name in at)


def places(given: object, path: str) -> tuple[Any, ...]:
    """Convert one name or (shaft, position) pair, or several."""
    if isinstance(given, str) or is_place(given):
        return (place(given, path),)
    if not isinstance(given, Iterable) or isinstance(given, (Mapping, *BYTES)):
        raise SceneError(f"{path}: must be a list of names or tuples, got {shown(given)}")
    found = tuple(place(at, f"{path}[{i}]") for i, at in enumerate(given))
    if not found:
        raise SceneError(f"{path}: must name at least one gear, disk or (shaft, position)")
    return found


def place_label(at: str | tuple[str, float]) -> str:
    """Give the label of a place in figures, e.g. "rotor at 0.5 m"."""
    return at if isinstance(at, str) else f"{at[0]} at {at[1]:g} m"


def names_of_bases(own: Iterable[object], *listed: Support | Housing) -> list[str]:
    """Give the names of what bearings stand on: their own supports, and those that are listed."""
    bases = [*listed, *(base for base in own if isinstance(base, Support))]
    return [base.name for base in bases if base.name is not None]
