"""Finding a place in what the core gave."""

from collections.abc import Sequence

from gearbow._types import At
from gearbow.errors import GearbowError


def locate(places: Sequence[tuple[str, float]], shaft: str, position: float) -> int | None:
    """Find (shaft, position) in a list of places; positions a nanometre apart are the same."""
    for i, (other, x) in enumerate(places):
        if other == shaft and abs(x - position) <= 1e-9 * max(1.0, abs(x)):
            return i
    return None


def require(index: int | None, name: At, motion: str) -> int:
    """Give the index of a degree of freedom that a system may not have."""
    if index is None:
        raise GearbowError(f"{name!r} has no {motion}: the system was made without that motion")
    return index
