"""A point of a branch, and the functions whose signs change at special points."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gearbow._types import Array, ComplexArray
from gearbow.analysis.low_rank import LowRank

#: Kinds of located points.
KINDS = ("fold", "flip", "contact loss")


@dataclass
class BranchPoint:
    """A fixed point with its derivative."""

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
    """Give the function whose sign changes at a kind of special points."""
    if kind == "fold":
        return float(point.tangent[-1])
    if kind == "contact loss":
        return point.margin
    negative = point.multipliers.real[(point.multipliers.imag == 0.0)]
    return 1.0 + float(min(negative, default=0.0))
