"""Numbers in SI units from rpm, millimetres and degrees."""

from typing import overload

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import matrix
from gearbow._types import Array
from gearbow.units.speed import RevolutionsPerMinute, RevolutionsPerMinuteArray

__all__ = ["degrees", "mm", "rpm"]


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
    found = _given(matrix(value, "rpm") * np.pi / 30.0)
    if isinstance(found, float):
        return RevolutionsPerMinute(found)
    return found.view(RevolutionsPerMinuteArray)


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
