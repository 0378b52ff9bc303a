"""Values of forces and torques: their plain form, and functions of time."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeVar

from gearbow._types import Plain
from gearbow.description.part import Part
from gearbow.description.time_series import TimeSeries
from gearbow.errors import SceneError

__all__ = ["described_value", "functions", "over_time", "refuse_functions"]

P = TypeVar("P", bound=Part)


def described_value(value: object, path: str, read: Callable[[object, str], Plain]) -> Plain:
    """Convert the value of a load to plain data.

    A function of time has no plain form: a run replaces it by its samples. Zero stands for it in
    every other analysis.
    """
    if isinstance(value, Part):
        return value._describe(path)
    if callable(value):
        return {"times": [0.0, 1.0], "values": [0.0, 0.0]}
    return read(value, path)


def functions(**lists: Sequence[Part]) -> list[str]:
    """Give the paths of the values that are functions of time, in named lists of loads."""
    return [
        f"{key}[{i}].value"
        for key, loads in lists.items()
        for i, load in enumerate(loads)
        if callable(getattr(load, "value", None))
    ]


def refuse_functions(**lists: Sequence[Part]) -> None:
    """Refuse functions of time, which have no plain form, in named lists of loads."""
    for path in functions(**lists):
        raise SceneError(
            f"{path}: a function of time has no plain form; give "
            "gb.TimeSeries.function(f, duration)"
        )


def over_time(loads: Sequence[P], begin: float, duration: float, path: str) -> tuple[P, ...]:
    """Replace functions of time in the values of loads by their samples over a run."""
    found = []
    for i, load in enumerate(loads):
        value = getattr(load, "value", None)
        if callable(value):
            series = TimeSeries.function(value, duration, begin=begin, path=f"{path}[{i}].value")
            found.append(replace(load, value=series))  # type: ignore[type-var]  # a dataclass
        else:
            found.append(load)
    return tuple(found)
