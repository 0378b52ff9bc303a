"""Units of speeds in tables and figures: rad/s, or rpm where the user gave it."""

import math
import re
from typing import Any, Literal, TypeAlias, get_args

import numpy as np

from gearbow._lookup import one_of
from gearbow.units.convert import is_quantity

__all__ = [
    "RevolutionsPerMinute",
    "RevolutionsPerMinuteArray",
    "SpeedUnit",
    "given_unit",
    "speed_factor",
    "speed_text",
    "unit_in_texts",
]

#: Unit of speeds in tables and figures.
SpeedUnit: TypeAlias = Literal["rad/s", "rpm"]
#: What multiplies a speed in rad/s.
_FACTORS: dict[str, float] = {"rad/s": 1.0, "rpm": 30.0 / math.pi}
#: A text that gives a speed in rpm.
_IN_RPM = re.compile(r"\s*[-+]?[\d.]\S*\s*rpm\s*")


class RevolutionsPerMinute(float):
    """A speed in rad/s that the user gave in rpm, by `gearbow.rpm`."""

    __slots__ = ()


class RevolutionsPerMinuteArray(np.ndarray[Any, np.dtype[np.float64]]):
    """Speeds in rad/s that the user gave in rpm, by `gearbow.rpm`."""

    def __repr__(self) -> str:
        return repr(np.asarray(self))


def speed_factor(unit: str) -> float:
    """Give what multiplies a speed in rad/s."""
    return _FACTORS[one_of(unit, get_args(SpeedUnit), "speed_unit")]


def speed_text(speed: float, unit: SpeedUnit) -> str:
    """Write a speed in rad/s with its unit, e.g. "1500 rpm"."""
    return f"{speed_factor(unit) * speed:.6g} {unit}"


def given_unit(speeds: Any) -> SpeedUnit | None:
    """Give the unit in which the user gave speeds; None for plain numbers."""
    if isinstance(speeds, list | tuple):
        return next(filter(None, map(given_unit, speeds)), None)
    if isinstance(speeds, RevolutionsPerMinute | RevolutionsPerMinuteArray):
        return "rpm"
    if is_quantity(speeds):
        return "rpm" if "revolutions_per_minute" in str(speeds.units) else "rad/s"
    return None


def unit_in_texts(plain: Any) -> SpeedUnit:
    """Give the unit of speeds in the texts of a plain description, such as "1500 rpm"."""
    if isinstance(plain, dict):
        plain = list(plain.values())
    if isinstance(plain, list):
        return "rpm" if any(unit_in_texts(item) == "rpm" for item in plain) else "rad/s"
    is_rpm = (
        isinstance(plain, str) and plain.split()[-1:] == ["rpm"] and plain[0] in "+-.0123456789"
    )
    return "rpm" if is_rpm else "rad/s"
