"""Times at which a run is recorded."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gearbow._convert import array, number, positive, shown
from gearbow._core import require_memory
from gearbow._types import Array
from gearbow.errors import SceneError

#: Largest number of recorded times. With more, the gears of one pair alone would take 10 GB.
MAX_TIMES = 100_000_000
#: Steps of the safeguarded Newton iteration of `crossings`; bisection alone reaches round-off in as
#: many.
_CROSSING_STEPS = 64


def distinct(times: ArrayLike) -> tuple[Array, NDArray[np.intp]]:
    """Sort the times without duplicates, and give the row of each given time."""
    return np.unique(array(times, "times", least=0), return_inverse=True)


def grid(start: float, duration: float, step: float) -> Array:
    """Give equally spaced times from the start; the end is included if a step ends there."""
    if not 0.0 < duration < np.inf:
        return np.array([start])  # the core rejects such a duration
    positive(step, "output_step")
    with np.errstate(over="ignore"):
        steps = np.floor(np.float64(duration) / step * (1.0 + 1e-12))
    if not steps < MAX_TIMES:
        raise SceneError(
            f"output_step: {step!r} s in a run of {duration!r} s gives {steps:.3g} times, "
            f"more than the {MAX_TIMES:.0e} that a response may have"
        )
    count = int(steps) + 1
    # Whole numbers, their products and the times.
    remedy = "give a longer output_step or a shorter duration"
    require_memory("output_step", f"{count} times", 24.0 * count, remedy)
    times: Array = np.minimum(start + step * np.arange(count), start + duration)
    return times


def begin_after(times: Array, skip_time: object) -> float:
    """Give the time at which the transient of a record ends."""
    given = number(skip_time, "skip_time")
    span = float(times[-1] - times[0]) if times.size else 0.0
    if not 0.0 <= given < max(span, 1e-300):
        raise SceneError(
            f"skip_time: must be from 0 to below the length {span:g} s of the record, got {given:g}"
        )
    return float(times[0]) + given


def within(times: Array, given: object) -> tuple[float, float]:
    """Check the first and the last time of a part of a record."""
    found = array(given, "times")
    if found.shape != (2,):
        raise SceneError(f"times: must be (first, last), got {shown(given)}")
    begin, end = float(found[0]), float(found[1])
    first, last = (float(times[0]), float(times[-1])) if times.size else (np.nan, np.nan)
    if not first <= begin < end <= last:
        raise SceneError(
            f"times: must ascend within the record, {first:g} s to {last:g} s, got {given!r}"
        )
    return begin, end


def window(times: Array, given: object) -> slice:
    """Find the recorded times between a first and a last one; None is the complete record."""
    if given is None:
        return slice(None)
    begin, end = within(times, given)
    cut = slice(int(np.searchsorted(times, begin)), int(np.searchsorted(times, end, "right")))
    if cut.stop - cut.start < 2:
        raise SceneError(f"times: the record has fewer than two instants within {shown(given)}")
    return cut


def crossings(
    nodes: Array, turned: Callable[[Array], Array], rate: Callable[[Array], Array]
) -> Array:
    """Find the times at which a function, monotone between the nodes, is a whole number."""
    values = turned(nodes)
    low, high, levels = [], [], []
    for begin, end, first, last in zip(nodes, nodes[1:], values, values[1:], strict=False):
        if last > first:
            whole_numbers = np.arange(np.ceil(first), np.ceil(last))
        else:
            whole_numbers = np.arange(np.floor(first), np.floor(last), -1.0)
        levels.append(whole_numbers)
        low.append(np.full(whole_numbers.size, begin))
        high.append(np.full(whole_numbers.size, end))
    if not levels:
        return np.empty(0)
    level, left, right = (np.concatenate(parts) for parts in (levels, low, high))
    rising = turned(right) > turned(left)
    t = (left + right) / 2.0
    for _ in range(_CROSSING_STEPS):
        excess = turned(t) - level
        passed = (excess >= 0.0) == rising
        left, right = np.where(passed, left, t), np.where(passed, t, right)
        with np.errstate(divide="ignore", invalid="ignore"):
            newton = t - excess / rate(t)
        # Newton's step, or the middle of the bracket where the step leaves it.
        following = np.where((newton >= left) & (newton <= right), newton, (left + right) / 2.0)
        if np.array_equal(following, t):
            break
        t = following
    return np.sort(t)
