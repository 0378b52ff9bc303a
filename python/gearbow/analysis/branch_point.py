"""A point of a branch, and the functions whose signs change at special points."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gearbow._types import Array, ComplexArray
from gearbow.analysis.low_rank import LowRank

__all__ = ["KINDS", "BranchPoint", "critical"]

#: Kinds of located points.
KINDS = ("fold", "flip", "contact loss")


@dataclass
class BranchPoint:
    """A fixed point with its derivative.

    Parameters
    ----------
    state : ndarray, shape (n,)
        The fixed point.
    value : float
        The parameter.
    scale : float
        Size of the states.
    derivative : LowRank
        Derivative of N(x) − x over states / scale and parameter / interval.
    tangent : ndarray, shape (n + 1,)
        Unit tangent of the branch over the same.
    margin : float
        Distance from the first contact loss.
    kept : object
        What the map keeps of the point.
    multipliers : ndarray
        The largest multipliers.
    kind : str
        "" or one of `KINDS` for a located point.
    """

    state: Array
    value: float
    scale: float
    derivative: LowRank
    tangent: Array = field(default_factory=lambda: np.zeros(0))
    margin: float = np.inf
    kept: Any = None
    multipliers: ComplexArray = field(default_factory=lambda: np.zeros(0, complex))
    kind: str = ""


def critical(point: BranchPoint, kind: str) -> float:
    """Give the function whose sign changes at a kind of special points.

    Parameters
    ----------
    point : BranchPoint
        A point.
    kind : str
        One of `KINDS`.

    Returns
    -------
    float
        Its value.
    """
    if kind == "fold":
        return float(point.tangent[-1])
    if kind == "contact loss":
        return point.margin
    negative = point.multipliers.real[(point.multipliers.imag == 0.0)]
    return 1.0 + float(min(negative, default=0.0))
