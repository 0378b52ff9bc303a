"""CPU time of runs, and early termination of runs that would take too long."""

import math
import time
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from gearbow.analysis.protocol import System, variant
from gearbow.errors import AccuracyWarning
from gearbow.results.response import Response

T = TypeVar("T")

#: Shortest time before a run may be stopped [s]; the core reports its progress every 50 ms.
_WATCHED = 0.2
#: The same time as a fraction of the time limit of the run.
_PATIENCE = 0.1


class TooSlowError(Exception):
    """A run was stopped or not started because it would take too long."""

    def __init__(self, seconds: float | None = None) -> None:
        super().__init__("the budget is spent" if seconds is None else f"takes {seconds:.2g} s")


@dataclass(frozen=True)
class Cost:
    """CPU time of a run."""

    setup: float
    stepping: float
    repeats: int


def measure(
    system: System,
    duration: float,
    speed: float,
    options: Mapping[str, Any],
    *,
    allowance: float,
    share: float,
    repeats: int,
) -> tuple[Response, Cost]:
    """Run a simulation several times and return the median CPU times."""
    begin = time.perf_counter()
    response, cost = _once(system, duration, speed, options, allowance)
    costs = [cost]
    last = time.perf_counter() - begin
    while len(costs) < repeats and time.perf_counter() - begin + last <= share:
        costs.append(_once(system, duration, speed, options, math.inf)[1])
    setup, stepping = (float(np.median(part)) for part in zip(*costs, strict=True))
    return response, Cost(setup, stepping, len(costs))


def _once(
    system: System,
    duration: float,
    speed: float,
    options: Mapping[str, Any],
    allowance: float,
) -> tuple[Response, tuple[float, float]]:
    fresh = variant(system)  # a copy without stored results
    nothing = {**options, "times": [0.0]}
    # A run of zero duration does the set-up only; the second one uses the stored results.
    setup, _ = _timed(lambda: fresh.simulate(0.0, speed, **nothing))
    if setup > max(_WATCHED, allowance):
        raise TooSlowError(setup)
    again, _ = _timed(lambda: fresh.simulate(0.0, speed, **nothing))
    with warnings.catch_warnings():
        # The allowance ends a run that takes too long, and says so.
        warnings.filterwarnings("ignore", "simulate: takes about ", AccuracyWarning)
        # A study measures the error of a number of modes.
        warnings.filterwarnings("ignore", "modes: ", AccuracyWarning)
        whole, response = _timed(
            lambda: fresh.simulate(duration, speed, progress=_watch(allowance), **options)
        )
    return response, (setup, max(0.0, whole - again))


def _watch(allowance: float) -> Callable[[float], None]:
    """Return a progress callback that stops a run whose estimated duration is too long."""
    begin = time.perf_counter()
    reports = [(0.0, 0.0)]

    def report(fraction: float) -> None:
        elapsed = time.perf_counter() - begin
        reports.append((elapsed, fraction))
        if elapsed < max(_WATCHED, _PATIENCE * allowance):
            return
        # The first steps may be short: estimate the rate from the second half of the elapsed time.
        then, done = next(report for report in reports if report[0] >= elapsed / 2.0)
        left = (1.0 - fraction) * (elapsed - then) / (fraction - done) if fraction > done else 0.0
        if elapsed + left > allowance:
            raise TooSlowError(elapsed + left)

    return report


def _timed(run: Callable[[], T]) -> tuple[float, T]:
    begin = time.process_time()
    result = run()
    return time.process_time() - begin, result
