"""Finding names and places, and suggesting those that were meant."""

from collections.abc import Iterable, Sequence
from difflib import get_close_matches

from gearbow._convert import real
from gearbow._types import At
from gearbow.errors import GearbowError


def nearest(given: str, names: Iterable[str]) -> str:
    """Give the end of a message that suggests the name nearest to a misspelt one."""
    found = get_close_matches(given, list(names), n=1)
    return f'; did you mean "{found[0]}"?' if found else ""


def locate(places: Sequence[tuple[str, float]], shaft: str, position: float) -> int | None:
    """Find (shaft, position) in a list of places; positions a nanometre apart are the same."""
    position = real(position, "position")
    for i, (other, x) in enumerate(places):
        if other == shaft and abs(x - position) <= 1e-9 * max(1.0, abs(x)):
            return i
    return None


def require(index: int | None, name: At, motion: str) -> int:
    """Give the index of a degree of freedom that a system may not have."""
    if index is None:
        raise GearbowError(f"{name!r} has no {motion}: the system was made without that motion")
    return index
