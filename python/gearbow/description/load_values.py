"""Values of forces and torques: their plain form, and functions of time."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from gearbow._types import Plain
from gearbow.description.part import Part
from gearbow.description.speed import evaluated
from gearbow.description.time_series import TimeSeries
from gearbow.errors import SceneError

P = TypeVar("P", bound=Part)

#: Time at the beginning of a function from which elements are chosen [s]: that over which the
#: accuracy levels promise errors. Number of its samples; they show tones up to 10 kHz.
_OUTLINE, _SAMPLES = 0.1, 4097


def described_value(value: object, path: str, read: Callable[[object, str], Plain]) -> Plain:
    """Convert the value of a load to plain data."""
    if isinstance(value, Part):
        return value._describe(path)
    if callable(value):
        return _outline(value, path)
    return read(value, path)


def _outline(function: Callable[[Any], Any], path: str) -> dict[str, Plain]:
    """Give samples of the beginning of a function; zeros for one that has no numbers there."""
    times = np.linspace(0.0, _OUTLINE, _SAMPLES)
    try:
        with np.errstate(all="ignore"):
            real, imaginary = (
                evaluated(lambda t, part=part: part(function(t)), times, path)  # type: ignore[misc]
                for part in (np.real, np.imag)
            )
    except (ArithmeticError, LookupError, TypeError, ValueError):
        # A run reports what is wrong with the function.
        real, imaginary = np.zeros((2, _SAMPLES))
    values = np.stack([real, imaginary], axis=1) if imaginary.any() else real
    return {"times": times.tolist(), "values": values.tolist()}


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
