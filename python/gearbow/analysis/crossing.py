"""The first root of a function that is positive at first: doubling steps, then Illinois' method.

Steps double from a first one, so that a dip of the function within one step is missed. Method: M.
Dowell and P. Jarratt, *A modified regula falsi method for computing the root of an equation*, BIT
11 (1971).
"""

import math
from collections.abc import Callable


def first_crossing(
    margin: Callable[[float], float], first: float, most: float, tolerance: float
) -> float | None:
    """Find the smallest value up to `most` with a margin that is not positive; None without one."""
    low, below = 0.0, margin(0.0)
    if below <= 0.0:
        return 0.0
    high = min(first, most)
    while (above := margin(high)) > 0.0:
        if high >= most:
            return None
        low, below, high = high, above, min(2.0 * high, most)
    kept = 0
    root = low
    while high - low > tolerance * high:
        # An infinite margin, beyond which there is no motion, has no slope.
        part = below / (below - above) if math.isfinite(above) else 0.5
        before, root = root, low + (high - low) * part
        if abs(root - before) <= 0.5 * tolerance * root:
            return root
        value = margin(root)
        if value > 0.0:
            low, below = root, value
            above = above / 2.0 if kept > 0 else above
            kept = 1
        else:
            high, above = root, value
            below = below / 2.0 if kept < 0 else below
            kept = -1
    return (low + high) / 2.0
