"""The function `gearbow.sweep`."""

import inspect
import os
import pickle
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future
from contextlib import AbstractContextManager, nullcontext
from typing import Any

from gearbow._convert import checked, shown
from gearbow._parallel import ParallelCalls
from gearbow._progress import reported
from gearbow._types import Progress
from gearbow.errors import GearbowError, SceneError
from gearbow.sweeps.points import Outcome, Parameters, Points, compute, failure, identity
from gearbow.sweeps.result import Sweep
from gearbow.sweeps.store import Store, head_of


@checked
def sweep(  # noqa: PLR0917  # the parameters of the public interface
    make: Callable[..., Any],
    parameters: Parameters,
    measure: Callable[..., Any],
    executor: Executor | None = None,
    store: str | os.PathLike[str] | None = None,
    progress: bool | Progress | None = None,
) -> Sweep:
    """Make a system for each point of a grid or a list, and measure it, in parallel.

    The result has the same bits for every executor and every number of workers.

    Parameters
    ----------
    make : callable
        ``make(**parameters)`` returns the system of a point.
    parameters : mapping of {str: sequence} or sequence of mapping
        The values of each parameter, all combinations of which are points, the last one fastest; or
        the parameters of each point by the same names. NumPy numbers become those of Python.
    measure : callable
        ``measure(system, **parameters)`` returns a number, an array, a text, or a dict of them.
    executor : concurrent.futures.Executor, optional
        Runs the points; it stays open. None is one thread for each core: an analysis leaves the
        other threads running. Functions for a `ProcessPoolExecutor` must be at the top of a module
        that the processes can import. `distributed.Client.get_executor` gives an executor for a
        cluster. At most 1000 points are submitted at the same time.
    store : str or path-like, optional
        A ".sweep" file to which each finished point is written at once. The same call with an
        existing file computes the missing and the failed points only. A file of another sweep is
        refused: other parameters, functions, or versions of gearbow or Python. What `make` and
        `measure` call in other modules is not compared.
    progress : bool or callable, optional
        True shows a progress bar, None after 2 s on a terminal; a callable gets the fraction.

    Returns
    -------
    Sweep
        The values of all points; one with an error is among `Sweep.failed`.

    Raises
    ------
    SceneError
        If an argument is invalid, or the store belongs to another sweep or is in use. A damaged
        point of the store is a `CheckpointWarning`.
    GearbowError
        If the workers of the executor have ended, or cannot import the functions.
    KeyboardInterrupt
        At Ctrl-C. This and every other exception after the start has the attribute `.sweep`: the
        points computed so far. Analyses in threads end within 0.5 s.

    Examples
    --------
    >>> import gearbow as gb
    >>> def rotor(bow):
    ...     bent = gb.Bow.half_sine(bow)
    ...     shaft = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=2, bow=bent)
    ...     bearings = [gb.Bearing("rotor", x, stiffness=1e8, damping=1e3) for x in (0.0, 1.0)]
    ...     return gb.RotorSystem(shafts=[shaft], bearings=bearings)
    >>> def amplitude(system, bow):
    ...     middle = ("rotor", 0.5)
    ...     return abs(system.synchronous(100.0).displacement(middle)).max()
    >>> found = gb.sweep(rotor, {"bow": [1e-4, 2e-4]}, amplitude)
    >>> print((found.values() / [1e-4, 2e-4]).round(3))
    [1.026 1.026]
    """
    points = Points(parameters)
    for name, function, leading in (("make", make, ()), ("measure", measure, (None,))):
        check_call(name, function, leading, points[0])
    functions = (identity(make), identity(measure))
    outcomes: dict[int, Outcome] = {}
    try:
        with _opened(store, functions, points) as file:
            if file is not None:
                outcomes |= file.known
            missing = [number for number in range(len(points)) if number not in outcomes]

            def keep(place: int, future: "Future[Outcome]") -> None:
                outcome = outcomes[missing[place]] = _outcome(future)
                if file is not None:
                    file.add(missing[place], outcome)

            calls = ParallelCalls(compute, ((make, measure, points[i]) for i in missing), executor)
            total = len(points)
            with reported(
                progress, total, "points", what="sweep", estimate=False, numbers=".0f"
            ) as report:
                if report is not None:  # a resumed sweep begins with a completed fraction
                    report(len(outcomes) / total)
                calls.collect(keep, lambda: report and report(len(outcomes) / total))
    except BaseException as error:
        error.sweep = Sweep(points, outcomes, functions)  # type: ignore[attr-defined]
        raise
    return Sweep(points, outcomes, functions)


def check_call(name: str, function: object, leading: tuple[Any, ...], point: Any) -> None:
    """Refuse a function that does not take the parameters, before anything is computed."""
    if not callable(function):
        raise SceneError(f"{name}: must be a function, got {shown(function)}")
    try:
        signature = inspect.signature(function)
    except ValueError:  # some functions of C have none
        return
    try:
        signature.bind(*leading, **point)
    except TypeError as error:
        what = "a system and the parameters" if leading else "the parameters"
        raise SceneError(f"{name}: must take {what} {', '.join(point)} by name: {error}") from None


def _opened(
    store: str | os.PathLike[str] | None,
    functions: tuple[dict[str, str], dict[str, str]],
    points: Points,
) -> AbstractContextManager[Store | None]:
    if store is None:
        return nullcontext()
    return Store(store, head_of(*functions, points.plain()))


def _outcome(future: "Future[Outcome]") -> Outcome:
    """Return the outcome of a call. Errors within a point do not reach its future."""
    try:
        return future.result()
    except (BrokenExecutor, CancelledError) as error:
        reason = str(error) or type(error).__name__
        raise GearbowError(
            f"executor: its workers have ended: {reason}; the computed points are in the attribute "
            "`sweep` of this error. Functions for processes must be at the top of a module"
        ) from error
    except Exception as error:
        if isinstance(error, pickle.PicklingError) or "pickle" in str(error):
            raise SceneError(
                f"make, measure: cannot be sent to another process: {error}; define them at the "
                "top of a module, or use threads (executor=None)"
            ) from error
        return failure(error)  # for example a cluster that gives the point up
