"""The function `gearbow.RotorSystem.tradeoff` and its arguments."""

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, get_args

from gearbow._convert import items, number, one_of, positive, truth, whole
from gearbow._times import grid
from gearbow._types import InitialState, Progress
from gearbow.accuracy import MAX_DEGREE
from gearbow.analysis.protocol import S, System
from gearbow.errors import SceneError

if TYPE_CHECKING:
    from gearbow.studies.result import Tradeoff


def tradeoff(  # numpydoc ignore=PR01
    self: S,
    duration: float,
    speed: float,
    signals: Any = None,
    *,
    methods: str | Iterable[str] | None = None,
    steps: Iterable[float] | None = None,
    tolerances: Iterable[float] | None = None,
    modes: Iterable[int] | None = None,
    elements: Iterable[float] = (0.5,),
    degrees: Iterable[int] | None = None,
    frozen: bool = True,
    mean_stiffness: bool = True,
    initial: InitialState = "synchronous",
    output_step: float | None = None,
    repeats: int = 3,
    budget: float = 60.0,
    progress: bool | Progress | None = None,
) -> "Tradeoff[S]":
    """Measure the total error and the CPU time of methods, tolerances, elements, modes and models.

    Parameters
    ----------
    duration : float
        Simulated time [s]; errors refer to the whole time.
    speed : float
        Speed Ω of the reference shaft [rad/s].
    signals : str, tuple or list of them, optional
        Signals to compare: the displacement of a gear, disk or (shaft, position), or the force of
        a mesh (driver, driven). With several signals the worst error counts. None is the first
        gear, or the first disk of a system without gears.
    methods : str or list of str, optional
        Methods to run, of `gearbow.studies.METHODS`; None is all. Simplified models use the first.
    steps : list of float, optional
        Steps of the methods with fixed steps [s]; None is a series of steps for each method.
    tolerances : list of float, optional
        Tolerances of the other methods; None is a series of tolerances for each method.
    modes : list of int, optional
        Numbers of modes of the reduced models; None is 1/2, 1/4 and 1/8 of all modes.
    elements : list of float
        Factors on the numbers of elements; each gives a model.
    degrees : list of int, optional
        Degrees of the elements; each gives a model, and the reference has a higher degree. None is
        one below and one above the degree of the system. With an empty list the reference has the
        given elements: the errors do not contain theirs.
    frozen : bool
        Whether to run a simplified model with geometry="frozen".
    mean_stiffness : bool
        Whether to run a simplified model with the mean of a time-varying mesh stiffness.
    initial : {"synchronous", "static", "rest"}
        Initial state of every run.
    output_step : float, optional
        Time between the compared samples [s]; None is the default of `simulate`.
    repeats : int
        Number of runs of each setting; the CPU time is their median. Slow settings run fewer times.
    budget : float
        Limit of the wall-clock time of the study [s]; settings that would exceed it are skipped.
    progress : bool or callable, optional
        True shows a progress bar; None shows one on a terminal after 2 s; a callable receives
        the completed fraction of the settings, which run after the reference and its check.

    Returns
    -------
    Tradeoff
        One row for each setting, with Pareto front, diagram and recommendation.

    Raises
    ------
    GearbowError
        If the budget is too short for a reference.
    KeyboardInterrupt
        At Ctrl-C. After the reference runs it has the attribute `.tradeoff`: the settings so far.

    Examples
    --------
    >>> import gearbow as gb
    >>> bow = gb.Bow.half_sine(1e-4)
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=4, bow=bow)
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e8) for x in (0.0, 1.0)]
    >>> system = gb.RotorSystem(shafts=[rotor], bearings=bearings, accuracy="draft")
    >>> tradeoff = system.tradeoff(0.02, speed=100.0, signals=("rotor", 0.5), initial="rest")
    >>> best = tradeoff.recommend(error=1e-2)
    >>> best.error <= 1e-2
    True
    >>> response = best.system.simulate(
    ...     0.02, speed=100.0, initial="rest", record=[("rotor", 0.5)], **best.options
    ... )
    """
    # Few scripts ask for a study.
    from gearbow.studies.settings import METHODS, degrees_of, ladders, simplified  # noqa: PLC0415
    from gearbow.studies.study import Study, read_signals  # noqa: PLC0415

    duration = positive(duration, "duration")
    speed = number(speed, "speed")
    one_of(initial, get_args(InitialState), "initial")
    if output_step is None:
        output_step = self.default_output_step(duration, speed)
    orders, factors = _degrees(degrees, degrees_of(self)), _numbers(elements, "elements")
    names = _methods(methods, METHODS)
    settings = ladders(
        self,
        speed,
        names,
        None if steps is None else _numbers(steps, "steps"),
        None if tolerances is None else _numbers(tolerances, "tolerances", most=1.0),
    )
    if not settings:
        raise SceneError(f"methods: no settings for {', '.join(names)}; give tolerances or steps")
    wanted = read_signals(self, signals)
    times = grid(0.0, duration, number(output_step, "output_step"))
    simpler = simplified(
        self,
        frozen=truth(frozen, "frozen"),
        mean_stiffness=truth(mean_stiffness, "mean_stiffness"),
        factors=factors,
        degrees=orders,
        modes=_modes(modes, names, self),
    )
    seconds = positive(budget, "budget", infinite=True)
    return Study(
        system=self,
        duration=duration,
        speed=speed,
        wanted=wanted,
        options={
            "times": times,
            "record": list(dict.fromkeys(signal.of for signal in wanted)),
            "initial": initial,
        },
        settings=settings,
        simpler=simpler,
        degrees=orders,
        repeats=whole(repeats, "repeats"),
        budget=seconds,
    ).carried_out(progress)


def _methods(given: str | Iterable[str] | None, known: Iterable[str]) -> list[str]:
    if given is None:
        return list(known)
    names = [given] if isinstance(given, str) else items(given, "methods", "names")
    for i, name in enumerate(names):
        one_of(name, known, f"methods[{i}]")
    if not names:
        raise SceneError("methods: must name at least one method, got an empty list")
    return list(dict.fromkeys(names))


def _modes(given: Iterable[int] | None, names: list[str], system: System) -> list[int]:
    """Read the numbers of modes; the default is 1/2, 1/4 and 1/8 of all modes."""
    if "exponential" not in names:
        return []
    if given is None:
        return [count for count in (len(system.dofs) // part for part in (2, 4, 8)) if count]
    return [whole(count, f"modes[{i}]") for i, count in enumerate(items(given, "modes", "numbers"))]


def _degrees(given: Iterable[int] | None, known: Sequence[int]) -> list[int]:
    """Read the degrees; the default is one below and one above those of the system."""
    if given is None:
        return [degree for degree in (min(known) - 1, max(known) + 1) if 1 <= degree <= MAX_DEGREE]
    found = [
        whole(degree, f"degrees[{i}]")
        for i, degree in enumerate(items(given, "degrees", "numbers"))
    ]
    for i, degree in enumerate(found):
        if degree > MAX_DEGREE:
            raise SceneError(f"degrees[{i}]: must be from 1 to {MAX_DEGREE}, got {degree}")
    return found


def _numbers(values: Iterable[object], name: str, most: float = math.inf) -> list[float]:
    """Read a list of positive numbers without duplicates."""
    found = []
    for i, value in enumerate(items(values, name, "numbers")):
        found.append(positive(value, f"{name}[{i}]", most))
    return list(dict.fromkeys(found))
