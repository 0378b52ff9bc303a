"""Times at which a run is recorded."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gearbow._convert import array
from gearbow._types import Array
from gearbow.errors import SceneError

#: Largest number of recorded times. With more, the gears of one pair alone would take 10 GB.
MAX_TIMES = 100_000_000


def distinct(times: ArrayLike) -> tuple[Array, NDArray[np.intp]]:
    """Sort the times without duplicates, and give the row of each given time."""
    return np.unique(array(times, "times", least=0), return_inverse=True)


def grid(start: float, duration: float, step: float) -> Array:
    """Give equally spaced times from the start; the end is included if a step ends there."""
    if not 0.0 < duration < np.inf:
        return np.array([start])  # the core rejects such a duration
    if not 0.0 < step < np.inf:
        raise SceneError(f"output_step: must be positive and finite, got {step!r}")
    with np.errstate(over="ignore"):
        steps = np.floor(np.float64(duration) / step * (1.0 + 1e-12))
    if not steps < MAX_TIMES:
        raise SceneError(
            f"output_step: {step!r} s in a run of {duration!r} s gives {steps:.3g} times, "
            f"more than the {MAX_TIMES:.0e} that a response may have"
        )
    count = int(steps) + 1
    times: Array = np.minimum(start + step * np.arange(count), start + duration)
    return times
