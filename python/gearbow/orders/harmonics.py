"""Choice of the harmonics of tooth frequencies that carry a significant part of a signal."""

from collections.abc import Sequence

import numpy as np

from gearbow.description.kinematics import Order
from gearbow.orders.segments import OrderFit, SignalSegment
from gearbow.orders.separation import Sampling

#: Number of harmonics of every tooth frequency that belong to the default, and largest number.
ALWAYS, MOST_HARMONICS = 3, 30
#: Largest number of orders that are added to those, which bounds the cost of the fit.
_MOST_ADDED = 100
#: Smallest amplitude of an added order, relative to the largest amplitude of all orders. A figure
#: with a linear scale shows no smaller one.
_SIGNIFICANT = 0.01


def significant(
    segments: Sequence[SignalSegment],
    fitted: OrderFit,
    candidates: Sequence[Order],
    sampling: Sampling,
) -> list[Order]:
    """Choose orders that carry a significant part of what a fit leaves."""
    resolved = [order for order in candidates if sampling.resolves(order.value)]
    values = np.array([order.value for order in resolved])
    sizes = np.zeros(values.size)
    for segment, remainder in zip(segments, fitted.remainders, strict=True):
        # The window keeps a line from appearing at the others.
        weighted = 2.0 * segment.window * remainder
        for j, value in enumerate(values):
            wave = np.exp(-2j * np.pi * value * (segment.turns - segment.turns[0]))
            sizes[j] = max(sizes[j], abs(wave @ weighted))
    least = _SIGNIFICANT * max(fitted.largest.max(initial=0.0), sizes.max(initial=0.0))
    most = min(_MOST_ADDED, sampling.most_orders - len(fitted.orders))
    taken: list[float] = fitted.values.tolist()
    chosen: list[Order] = []
    for j in np.argsort(-sizes, kind="stable"):
        if len(chosen) >= most or not sizes[j] > least:
            break
        if np.abs(np.array(taken) - values[j]).min(initial=np.inf) >= sampling.distance:
            taken.append(float(values[j]))
            chosen.append(resolved[j])
    return chosen
