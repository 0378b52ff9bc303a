"""Result of one point of a sweep: its measured values, or the error that ended it."""

import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._convert import shown
from gearbow.errors import SceneError

if TYPE_CHECKING:
    from numpy.typing import NDArray

#: Name of the value if `measure` returns no dict.
SINGLE = "value"

#: Measured values by name: NumPy scalars, and arrays.
Values = Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class Outcome:
    """Measured values of a point, or its error."""

    values: Values | None = None
    error: str = ""
    details: str = field(default="", repr=False)


def compute(
    make: Callable[..., Any], measure: Callable[..., Any], parameters: dict[str, Any]
) -> Outcome:
    """Make the system of a point and measure it."""
    try:
        return Outcome(_values(measure(make(**parameters), **parameters)))
    except Exception as error:  # noqa: BLE001  # the other points continue
        return failure(error)


def failure(error: BaseException) -> Outcome:
    """Return the outcome of a failed point."""
    name = type(error).__qualname__
    text = f"{name}: {error}" if str(error) else name
    return Outcome(None, text, "".join(traceback.format_exception(error)))


def _values(found: object) -> dict[str, Any]:
    if not isinstance(found, Mapping):
        return {SINGLE: _value(found, "measure")}
    if not found:
        raise SceneError("measure: must return at least one value, got an empty dict")
    for name in found:
        if not isinstance(name, str):
            raise SceneError(f"measure: the name of a value must be text, got {shown(name)}")
    return {str(name): _value(value, f"measure: {name!r}") for name, value in found.items()}


def _value(value: object, where: str) -> Any:
    wanted = "must be a number, a text or an array of them"
    if isinstance(value, np.ma.MaskedArray):
        raise SceneError(f"{where}: must not be a masked array; give its `.filled()` values")
    try:
        array: NDArray[Any] = np.asarray(value)
    except (TypeError, ValueError):  # rows of different lengths
        raise SceneError(f"{where}: {wanted}, got {shown(value)}") from None
    if array.dtype.kind not in "biufcU":
        raise SceneError(f"{where}: {wanted}, got {shown(value)}")
    kind = array.dtype.newbyteorder("=")
    if kind.char in "gG":  # extended precision depends on the machine
        kind = np.dtype(np.float64 if kind.char == "g" else np.complex128)
    # A copy: `measure` may change its array later. `[()]` makes a scalar of an array without axes.
    return np.array(array, dtype=kind, order="C")[()]
