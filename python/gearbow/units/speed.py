"""Speeds in rad/s or rpm, as the user gave them, and numbers in SI units from rpm, mm, degrees.

Speeds are in rad/s everywhere. Only what is shown has the other unit: a result remembers the unit
of the speed that was given (`in_given_unit`), and while it is shown (`showing_in`), tables and
figures write speeds in this unit.
"""

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import wraps
from typing import Any, Literal, TypeAlias, TypeVar, get_args, overload

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import matrix, one_of
from gearbow._types import Array
from gearbow.units.fields import is_quantity

#: Unit of speeds in tables and figures.
SpeedUnit: TypeAlias = Literal["rad/s", "rpm"]
#: Revolutions per minute.
PER_MINUTE: SpeedUnit = "rpm"
#: What multiplies a speed in rad/s.
_FACTORS: dict[str, float] = {"rad/s": 1.0, PER_MINUTE: 30.0 / math.pi}


class _RevolutionsPerMinute(float):
    """A speed in rad/s that the user gave in rpm, by `gearbow.rpm`."""

    __slots__ = ()


class _RevolutionsPerMinuteArray(np.ndarray[Any, np.dtype[np.float64]]):
    """Speeds in rad/s that the user gave in rpm, by `gearbow.rpm`."""

    def __repr__(self) -> str:
        return repr(np.asarray(self))


def as_given(speeds: Any, unit: SpeedUnit | None) -> Any:
    """Give speeds in rad/s, or None, as if the user had given them in a unit."""
    if speeds is None or unit != PER_MINUTE:
        return speeds
    if isinstance(speeds, tuple):
        return tuple(as_given(speed, unit) for speed in speeds)
    if isinstance(speeds, np.ndarray):
        return speeds.view(_RevolutionsPerMinuteArray)
    return _RevolutionsPerMinute(speeds)


def other_unit(unit: SpeedUnit) -> SpeedUnit:
    """Give the other unit of speeds."""
    return PER_MINUTE if unit == "rad/s" else "rad/s"


#: Unit of the tables and figures that are being made; None outside of them.
_SHOWN: ContextVar[SpeedUnit | None] = ContextVar("shown unit of speeds", default=None)

_Call = TypeVar("_Call", bound=Callable[..., Any])


@contextmanager
def showing_in(unit: SpeedUnit) -> Iterator[None]:
    """Write speeds in a unit within the context."""
    one_of(unit, get_args(SpeedUnit), "speed_unit")
    before = _SHOWN.set(unit)
    try:
        yield
    finally:
        _SHOWN.reset(before)


def shown_unit(usual: SpeedUnit = "rad/s") -> SpeedUnit:
    """Give the unit in which speeds are written now; outside of `showing_in`, the usual one."""
    return _SHOWN.get() or usual


def speed_factor(unit: str | None = None) -> float:
    """Give what multiplies a speed in rad/s; None is the unit in which speeds are written now."""
    return _FACTORS[one_of(unit or shown_unit(), get_args(SpeedUnit), "speed_unit")]


def speed_text(speed: float, unit: SpeedUnit | None = None, form: str = ".6g") -> str:
    """Write a speed in rad/s with its unit, e.g. "1500 rpm"."""
    return f"{speed_factor(unit) * speed:{form}} {unit or shown_unit()}"


def given_unit(speeds: Any) -> SpeedUnit | None:
    """Give the unit in which the user gave speeds; None for plain numbers."""
    if isinstance(speeds, list | tuple):
        return next(filter(None, map(given_unit, speeds)), None)
    if isinstance(speeds, str):
        return PER_MINUTE if unit_in_texts(speeds) == PER_MINUTE else None
    if isinstance(speeds, _RevolutionsPerMinute | _RevolutionsPerMinuteArray):
        return PER_MINUTE
    if is_quantity(speeds) and "revolutions_per_minute" in str(speeds.units):
        return PER_MINUTE
    return "rad/s" if is_quantity(speeds) and "radian" in str(speeds.units) else None


def in_given_unit(analysis: _Call) -> _Call:
    """Let the result of a method show speeds in the unit of those given to it."""

    @wraps(analysis)
    def call(*args: Any, **options: Any) -> Any:
        owner, *given = *args, *options.values()
        # Without a unit, it is that of a result among the arguments, or that of the system.
        unit = given_unit(given) or _unit_of([*given, owner]) or "rad/s"
        try:
            found = analysis(*args, **options)
        except BaseException as error:
            for partial in vars(error).values():
                if hasattr(partial, "_remember"):
                    partial._remember(unit)
            raise
        found._remember(unit)
        return found

    return call  # type: ignore[return-value]  # it has the parameters of the analysis


def _unit_of(given: Any) -> SpeedUnit | None:
    """Give the unit that a result, the record of a run, or a system remembers."""
    if isinstance(given, list | tuple):
        return next(filter(None, map(_unit_of, given)), None)
    found: SpeedUnit | None = getattr(given, "speed_unit", getattr(given, "_speed_unit", None))
    return found


def unit_in_texts(plain: Any) -> SpeedUnit:
    """Give the unit of speeds in the texts of a plain description, such as "1500 rpm"."""
    if isinstance(plain, dict):
        plain = list(plain.values())
    if isinstance(plain, list):
        return PER_MINUTE if any(unit_in_texts(item) == PER_MINUTE for item in plain) else "rad/s"
    is_rpm = (
        isinstance(plain, str) and plain.split()[-1:] == ["rpm"] and plain[0] in "+-.0123456789"
    )
    return PER_MINUTE if is_rpm else "rad/s"


def parsed_speed(text: str, path: str, *, bare: bool = False) -> float:
    """Read a speed with its unit, which is the given one; a `bare` number is in rad/s."""
    from gearbow.units.parse import parsed  # noqa: PLC0415  # only texts need it

    found: float = as_given(parsed(text, path, bare=bare), unit_in_texts(text))
    return found


@overload
def rpm(value: float) -> float: ...  # numpydoc ignore=GL08


@overload
def rpm(value: "ArrayLike") -> float | Array: ...  # numpydoc ignore=GL08


def rpm(value: "ArrayLike") -> float | Array:
    """Convert revolutions per minute to rad/s.

    Parameters
    ----------
    value : float or array_like
        Speed [rpm].

    Returns
    -------
    float or ndarray
        Speed [rad/s]. Tables and figures of its results write speeds in rpm.

    Examples
    --------
    >>> import gearbow as gb
    >>> print(f"{gb.rpm(1500):.4f}")
    157.0796
    >>> gb.rpm([0, 60]) / (2 * 3.141592653589793)
    array([0., 1.])
    """
    found: float | Array = as_given(_given(matrix(value, "rpm") * np.pi / 30.0), "rpm")
    return found


@overload
def mm(value: float) -> float: ...  # numpydoc ignore=GL08


@overload
def mm(value: "ArrayLike") -> float | Array: ...  # numpydoc ignore=GL08


def mm(value: "ArrayLike") -> float | Array:
    """Convert millimetres to metres.

    Parameters
    ----------
    value : float or array_like
        Length [mm].

    Returns
    -------
    float or ndarray
        Length [m].

    Examples
    --------
    >>> import gearbow as gb
    >>> gb.mm(5)
    0.005
    >>> gb.mm([250, 500])
    array([0.25, 0.5 ])
    """
    return _given(matrix(value, "mm") / 1000.0)


@overload
def degrees(value: float) -> float: ...  # numpydoc ignore=GL08


@overload
def degrees(value: "ArrayLike") -> float | Array: ...  # numpydoc ignore=GL08


def degrees(value: "ArrayLike") -> float | Array:
    """Convert degrees to radians.

    Parameters
    ----------
    value : float or array_like
        Angle [°].

    Returns
    -------
    float or ndarray
        Angle [rad].

    Examples
    --------
    >>> import gearbow as gb
    >>> print(f"{gb.degrees(20):.4f}")
    0.3491
    """
    return _given(np.radians(matrix(value, "degrees")))


def _given(values: Array) -> float | Array:
    """Give a float for a scalar."""
    return float(values) if np.ndim(values) == 0 else values
