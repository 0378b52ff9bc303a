"""Choice of the harmonics of tooth frequencies that carry a significant part of a signal."""

from collections.abc import Sequence

import numpy as np

from gearbow._types import Array
from gearbow.description.kinematics import Order

__all__ = ["ALWAYS", "MOST_HARMONICS", "SEPARATION", "significant"]

#: Smallest phase difference of neighbouring orders over the record, in periods.
SEPARATION = 0.5
#: Number of harmonics of every tooth frequency that belong to the default, and largest number.
ALWAYS, MOST_HARMONICS = 3, 30
#: Largest number of orders that are added to those, which bounds the cost of the fit.
_MOST_ADDED = 100
#: Smallest amplitude of an added order, relative to the largest amplitude of all orders. A figure
#: with a linear scale shows no smaller one.
_SIGNIFICANT = 0.01


def significant(
    time: Array, remainder: Array, candidates: Sequence[Order], hertz: float, fitted: Array
) -> list[int]:
    """Choose orders that carry a significant part of what a fit leaves."""
    frequencies = np.array([order.value for order in candidates]) * hertz
    span, step = float(time[-1] - time[0]), float(np.diff(time).max())
    resolved = np.flatnonzero(frequencies * step < 0.5)
    sizes = np.zeros(len(candidates))
    # The window keeps a line from appearing at the others.
    weights = 1.0 - np.cos(2.0 * np.pi * (time - time[0]) / span)
    weighted = 2.0 * weights * remainder / weights.sum()
    for j in resolved:
        sizes[j] = abs(np.exp(-2j * np.pi * frequencies[j] * (time - time[0])) @ weighted)
    least = _SIGNIFICANT * max(fitted[:, 1].max(initial=0.0), sizes.max(initial=0.0))
    most = min(_MOST_ADDED, (time.size - 2) // 2 - len(fitted))
    taken: list[float] = fitted[:, 0].tolist()
    chosen: list[int] = []
    for j in resolved[np.argsort(-sizes[resolved], kind="stable")]:
        if len(chosen) >= most or not sizes[j] > least:
            break
        if np.abs(np.array(taken) - frequencies[j]).min(initial=np.inf) * span >= SEPARATION:
            taken.append(float(frequencies[j]))
            chosen.append(int(j))
    return chosen
