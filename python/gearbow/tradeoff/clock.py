"""Runs on the clock: what they cost in CPU time, and an end to those that would cost too much."""

import math
import time
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING, Any, TypeVar

from gearbow.errors import RunTimeWarning
from gearbow.response import Response
from gearbow.tradeoff.models import copy

if TYPE_CHECKING:
    from gearbow.system import RotorSystem

__all__ = ["Budget", "Cost", "TooSlowError", "measure"]

T = TypeVar("T")

#: How long a run is watched before it is judged [s]: the core reports every 50 ms.
_WATCHED = 0.2
#: The same, over the time that it may take.
_PATIENCE = 0.1


class TooSlowError(Exception):
    """A run that was ended, or not begun, for it would have taken too long.

    Parameters
    ----------
    seconds : float, optional
        How long it would have taken [s]; None where there was no time to find out.
    """

    def __init__(self, seconds: float | None = None) -> None:
        super().__init__("the budget is spent" if seconds is None else f"takes {seconds:.2g} s")


class Budget:
    """What is left of the time that a study may take.

    Parameters
    ----------
    seconds : float
        Time from now on [s], by the clock on the wall.
    """

    def __init__(self, seconds: float) -> None:
        self._begin = time.perf_counter()
        self._seconds = seconds

    @property
    def spent(self) -> float:
        """What has been taken.

        Returns
        -------
        float
            Time [s].
        """
        return time.perf_counter() - self._begin

    @property
    def left(self) -> float:
        """What remains.

        Returns
        -------
        float
            Time [s], not below zero.
        """
        return max(0.0, self._seconds - self.spent)


@dataclass(frozen=True)
class Cost:
    """What a run takes, in CPU time of the process.

    Parameters
    ----------
    setup : float
        Before the first step, in a system of which nothing has been computed [s].
    stepping : float
        From the first step on [s].
    repeats : int
        Of how many runs these are the medians.
    """

    setup: float
    stepping: float
    repeats: int


def measure(
    system: "RotorSystem",
    duration: float,
    speed: float,
    options: Mapping[str, Any],
    *,
    allowance: float,
    share: float,
    repeats: int,
) -> tuple[Response, Cost]:
    """Run, and run again, and give the medians of what that took.

    Parameters
    ----------
    system : RotorSystem
        The system.
    duration : float
        Simulated time [s].
    speed : float
        Speed of the reference shaft [rad/s].
    options : mapping
        Other options of `simulate`.
    allowance : float
        The longest that one run may take [s].
    share : float
        The longest that the repeats may take together [s]; the first run is not among them.
    repeats : int
        How many runs at most.

    Returns
    -------
    Response
        The first of the responses, which are all the same.
    Cost
        What it took.

    Raises
    ------
    TooSlowError
        If a run would exceed the allowance.
    """
    begin = time.perf_counter()
    response, cost = _once(system, duration, speed, options, allowance)
    costs = [cost]
    last = time.perf_counter() - begin
    while len(costs) < repeats and time.perf_counter() - begin + last <= share:
        costs.append(_once(system, duration, speed, options, math.inf)[1])
    setup, stepping = (median(part) for part in zip(*costs, strict=True))
    return response, Cost(setup, stepping, len(costs))


def _once(
    system: "RotorSystem",
    duration: float,
    speed: float,
    options: Mapping[str, Any],
    allowance: float,
) -> tuple[Response, tuple[float, float]]:
    fresh = copy(system)
    nothing = {**options, "times": [0.0]}
    # A run of no duration does everything but step; the second finds what the first has prepared.
    setup, _ = _timed(lambda: fresh.simulate(0.0, speed, **nothing))
    if setup > max(_WATCHED, allowance):
        raise TooSlowError(setup)
    again, _ = _timed(lambda: fresh.simulate(0.0, speed, **nothing))
    with warnings.catch_warnings():
        # The allowance ends a run that takes too long, and says so.
        warnings.simplefilter("ignore", RunTimeWarning)
        whole, response = _timed(
            lambda: fresh.simulate(duration, speed, progress=_watch(allowance), **options)
        )
    return response, (setup, max(0.0, whole - again))


def _watch(allowance: float) -> Callable[[float], None]:
    """Give what the core calls with the fraction done: it ends a run that will take too long."""
    begin = time.perf_counter()
    reports = [(0.0, 0.0)]

    def report(fraction: float) -> None:
        elapsed = time.perf_counter() - begin
        reports.append((elapsed, fraction))
        if elapsed < max(_WATCHED, _PATIENCE * allowance):
            return
        # The first steps may be short: the pace is that of the second half of the time.
        then, done = next(report for report in reports if report[0] >= elapsed / 2.0)
        left = (1.0 - fraction) * (elapsed - then) / (fraction - done) if fraction > done else 0.0
        if elapsed + left > allowance:
            raise TooSlowError(elapsed + left)

    return report


def _timed(run: Callable[[], T]) -> tuple[float, T]:
    begin = time.process_time()
    result = run()
    return time.process_time() - begin, result
