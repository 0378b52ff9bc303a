"""Smooth curves through computed points."""

import numpy as np

from gearbow._types import Array

__all__ = ["smooth"]

#: Number of parts of the interval between two points.
_PARTS = 16
#: Points closer than this part of the whole range count as one.
_SAME = 1e-9


def smooth(x: Array, y: Array) -> tuple[Array, Array]:
    """Draw a monotone cubic through points, so that a curve has no corners and no overshoot."""
    order = np.argsort(x, kind="stable")
    x, y = x[order], y[order]
    distinct = np.diff(x, prepend=-np.inf) > _SAME * np.ptp(x) if x.size else np.empty(0, bool)
    x, y = x[distinct], y[distinct]
    if x.size < 3:
        return x, y
    step = np.diff(x)
    secant = np.diff(y) / step
    slope = np.concatenate([secant[:1], np.zeros(x.size - 2), secant[-1:]])
    left, right = secant[:-1], secant[1:]
    rising = left * right > 0.0
    weights = 2.0 * step[1:] + step[:-1], step[1:] + 2.0 * step[:-1]
    means = (weights[0] + weights[1])[rising] / (
        weights[0][rising] / left[rising] + weights[1][rising] / right[rising]
    )
    slope[1:-1][rising] = means
    part = np.arange(_PARTS) / _PARTS
    low, high = 1.0 - part, part
    # Cubic Hermite polynomial of each interval, shape (intervals, parts).
    values = (
        np.outer(y[:-1], low**2 * (1.0 + 2.0 * high))
        + np.outer(y[1:], high**2 * (1.0 + 2.0 * low))
        + np.outer(step * slope[:-1], low**2 * high)
        - np.outer(step * slope[1:], high**2 * low)
    )
    places = x[:-1, np.newaxis] + np.outer(step, part)
    return np.append(places.ravel(), x[-1]), np.append(values.ravel(), y[-1])
