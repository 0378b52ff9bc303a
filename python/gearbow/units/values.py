"""Values with a unit in plain data: quantities of pint, and texts.

This module does not import pint: a value can only be a quantity of pint if the user imported it.
"""

import math
import sys
from collections.abc import Mapping
from typing import Any

from gearbow.errors import SceneError
from gearbow.units.fields import is_frequency, unit_of


def quantities_exist() -> bool:
    """Return whether pint is imported, without which no value is a quantity."""
    return "pint" in sys.modules


def is_quantity(value: object) -> bool:
    """Return whether a value is a quantity of pint."""
    pint = sys.modules.get("pint")
    return pint is not None and isinstance(value, pint.Quantity)


def has_quantity(value: object) -> bool:
    """Return whether a value is a quantity of pint, or a nested sequence with one."""
    if not quantities_exist():
        return False
    if isinstance(value, list | tuple):
        return any(has_quantity(item) for item in value)
    if isinstance(value, Mapping):
        return any(has_quantity(item) for item in value.values())
    return is_quantity(value)


def magnitude(quantity: Any, path: str) -> Any:
    """Convert a quantity of pint to the SI unit of its field."""
    pint = sys.modules["pint"]
    unit = unit_of(path)
    if unit is None:
        raise SceneError(f"{path}: must not be one quantity, got {quantity}")
    # pint converts 50 Hz to 50 rad/s, although 50 cycles or turns per second are 314 rad/s.
    if unit == "rad/s" and "hertz" in str(quantity.units):
        if is_frequency(path):
            return 2.0 * math.pi * quantity.to("Hz").magnitude
        raise SceneError(
            f"{path}: a speed in Hz is ambiguous, got {quantity}; give rad/s, rpm or turns/s"
        )
    try:
        return quantity.to("" if unit == "1" else unit).magnitude
    except pint.DimensionalityError:
        wanted = "have no unit" if unit == "1" else f"have a unit that converts to {unit}"
        raise SceneError(f"{path}: must {wanted}, got {quantity}") from None


def without_texts(plain: Mapping[str, Any]) -> dict[str, Any]:
    """Convert texts with a unit in a plain description, such as "500 mm", to SI units."""
    listed = plain.get("housings")
    parts = listed if isinstance(listed, list | tuple) else ()
    names = [each.get("name") for each in parts if isinstance(each, Mapping)]
    return {key: _without_texts(value, str(key), names) for key, value in plain.items()}


def _without_texts(plain: Any, path: str, housings: list[Any]) -> Any:
    """Convert the texts in an entry; the second one of (housing, interface) is a name."""
    if isinstance(plain, Mapping):
        return {key: _without_texts(item, f"{path}.{key}", housings) for key, item in plain.items()}
    if isinstance(plain, list | tuple):
        if path.endswith(".support") and plain and plain[0] in housings:
            return list(plain)
        return [_without_texts(item, f"{path}[{i}]", housings) for i, item in enumerate(plain)]
    if isinstance(plain, str) and unit_of(path) not in (None, "1"):
        from gearbow.units.parse import parsed  # noqa: PLC0415  # most descriptions have no texts

        return parsed(plain, path)
    return plain
