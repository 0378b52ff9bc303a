"""Steady-state response of a system."""

import math
from collections.abc import Iterable, Mapping
from typing import Any

from gearbow._convert import LARGEST_COUNT, number, text, whole
from gearbow._core import (
    common_period,
    recorded_period,
    slowest_period,
    steady_state as steady_period,
)
from gearbow._progress import reported
from gearbow._types import Accuracy, Geometry, InitialState, Progress, Record, RunData
from gearbow.accuracy.levels import LEVELS, check_reduction
from gearbow.analysis.protocol import S, System
from gearbow.description.kinematics import Kinematics
from gearbow.description.speed import plain_speed
from gearbow.errors import SceneError
from gearbow.recording.request import RunRequest
from gearbow.results.response import Response
from gearbow.results.steady import SteadyState
from gearbow.system.run import beginning, given_speed, in_order, requests
from gearbow.system.simulation import accuracy_level
from gearbow.system.superposition import Superposition, recorded_duration
from gearbow.units.speed import given_unit


def steady_state(
    self: S,
    speed: float,
    *,
    period: float | None = None,
    max_period: float = 10.0,
    accuracy: Accuracy | None = None,
    step: float | None = None,
    rtol: float | None = None,
    stages: int | None = None,
    modes: int | None = None,
    initial: "InitialState | Response | SteadyState | Mapping[str, Any]" = "synchronous",
    output_step: float | None = None,
    record: Iterable[Record] | None = None,
    geometry: Geometry = "live",
    start: float | None = None,
    progress: bool | Progress | None = None,
) -> SteadyState:
    """Find the motion that remains after the transient, at a constant speed.

    The motion is periodic with the common period of all excitations. The solution takes about
    ten periods, where running in takes up to hundreds. A motion that is unstable is found too.
    Without a common period, or with one longer than `max_period`, the motion is found as the
    sum of the steady motions of the sources, if the system is linear with constant
    coefficients; otherwise it runs in, and a motion that is unstable is not found.

    Parameters
    ----------
    speed : float
        Speed Ω of the reference shaft [rad/s].
    period : float, optional
        Period of the motion [s]; a multiple of the common period gives motions that repeat
        after several of them. None is the common period, which follows from the numbers of
        teeth and from what excites: bow, unbalance, teeth, errors, run-out and loads.
    max_period : float
        Longest accepted common period, and longest record without one [s]. Motions with a
        longer period are found like those without one.
    accuracy : {"draft", "engineering", "reference"}, optional
        Accuracy of the motion, as for `simulate`.
    step : float, optional
        Fixed step [s]; the period is divided into steps of at most this length.
    rtol : float, optional
        Tolerance of the integration, as for `simulate`. The iteration ends where its error is
        below it.
    stages : int, optional
        Number of Gauss nodes in a step, 1 to 4.
    modes : int, optional
        Number of modes, as for `simulate`.
    initial : {"synchronous", "static", "rest"}, Response or SteadyState
        Motion from which the iteration starts. Where several motions exist, it decides which
        is found.
    output_step : float, optional
        Longest time between recorded instants [s], which divide the period evenly. None
        resolves shaft rotation and tooth passing.
    record : sequence of str or tuple, optional
        Recorded items, as for `simulate`.
    geometry : {"live", "frozen"}
        As for `simulate`.
    start : float, optional
        Time at the start [s]; 0 by default.
    progress : bool or callable, optional
        True shows a progress bar; None shows one on a terminal after 2 s; a callable receives
        the completed fraction.

    Returns
    -------
    SteadyState
        One period of the motion. Without a common period, one to ten turns of the slowest shaft if
        these separate the default orders of `Response.orders`, otherwise two; at most `max_period`.

    Raises
    ------
    SceneError
        If an argument is invalid, or the excitation has no common period up to `max_period`
        and contains a load over time.
    ConvergenceError
        If the iteration does not converge; the message gives the residual. Without a common period,
        if the motion does not settle.
    StabilityError, ContactError
        As for `simulate`.

    Examples
    --------
    >>> import gearbow as gb
    >>> bow = gb.Bow.half_sine(1e-4)
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=4, bow=bow)
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e8, damping=1e3) for x in (0.0, 1.0)]
    >>> system = gb.RotorSystem(shafts=[rotor], bearings=bearings)
    >>> steady = system.steady_state(100.0, record=[("rotor", 0.5)])
    >>> steady.instability() is None
    True
    """
    state, begin = beginning(initial, start)
    unit = given_unit(speed) or self._speed_unit
    speed = number(speed, "speed")
    longest = number(max_period, "max_period", infinite=True)
    text(geometry, "geometry")
    period, without = _period(self, speed, period, longest, geometry)
    system = self._over_time(begin, period)
    given = {"method": None, "step": step, "rtol": rtol}
    if accuracy is not None:
        given |= {"stages": stages}
    level, coarse = accuracy_level(system, accuracy, given, speed)
    arguments: dict[str, Any] = {
        "duration": period,
        "speed": plain_speed(given_speed(speed, begin, period)),
        "method": "exponential",
        "step": None if step is None else number(step, "step"),
        "rtol": None if rtol is None else number(rtol, "rtol"),
        "stages": None if stages is None else whole(stages, "stages"),
        "modes": None if modes is None else whole(modes, "modes"),
        "initial": state,
        "record": requests(record, system),
        "geometry": geometry,
        "start": begin,
        "accuracy": None if level is None else level.name,
    }
    samples = period_samples(system, period, speed, output_step)
    data, about = _solved(system, without, (arguments, samples), progress)
    response = _response(system, data, speed, arguments)
    if level is not None and stages is None and modes is None:
        response.accuracy = level.explanation(response.events, coarse)
    if modes is not None or level is not None:
        level = level or LEVELS[system.accuracy]
        check_reduction(response.statistics, level, given=modes is not None)
    response.speed_unit = unit
    return SteadyState(response, about, system._model)


def _period(
    system: S, speed: float, given: float | None, longest: float, geometry: str
) -> tuple[float, "Superposition | float | None"]:
    """Give the period; without one, the duration of the record, and the sources or `slowest`."""
    if given is not None:
        given = number(given, "period")
        if not given > 0.0:
            raise SceneError(f"period: must be positive, got {given}")
    try:
        return common_period(system._model, speed, given, longest), None
    except SceneError:
        sources = Superposition.of(system, speed, geometry)
        if sources is not None:
            return recorded_duration(system, speed, longest), sources
        slowest = slowest_period(system._model, speed)
        if slowest is None or slowest > longest:
            raise
        return recorded_duration(system, speed, longest), slowest


def _response(system: System, data: RunData, speed: float, arguments: dict[str, Any]) -> Response:
    """Give the recorded period; its request continues from its end, with the same motion."""
    response = Response(in_order(data, None), speed)
    response.kinematics = Kinematics.of(system)
    response.speed_unit = system._speed_unit
    again = {**arguments, "initial": response.final, "start": response.final["time"]}
    response.request = RunRequest(system.description, again)
    return response


def period_samples(system: System, period: float, speed: float, output_step: float | None) -> int:
    """Give the number of recorded instants in a period."""
    if output_step is None:
        output_step = system._model.default_output_step(period, speed, 0.0)
    output_step = number(output_step, "output_step")
    if not output_step > 0.0:
        raise SceneError(f"output_step: must be positive, got {output_step}")
    samples = period / output_step * (1.0 - 1e-12)
    if samples > LARGEST_COUNT:
        raise SceneError(
            f"output_step: the period of {period:g} s has {samples:.3g} recorded instants at a "
            f"distance of {output_step:g} s, at most {LARGEST_COUNT} are possible; give a "
            "longer output_step or a shorter period"
        )
    return max(1, math.ceil(samples))


def _solved(
    system: System,
    without: "Superposition | float | None",
    run: tuple[dict[str, Any], int],
    progress: bool | Progress | None,
) -> tuple[RunData, dict[str, Any]]:
    """Record a periodic motion, or one without a period."""
    arguments, samples = run
    with reported(progress, 1.0, "", what="steady state", setup="modes, pilot runs") as report:
        if not isinstance(without, Superposition):
            return steady_period(
                system._model,
                **arguments,
                slowest=without,
                samples=samples,
                progress=report,
            )
    state, residual, periods = without.solve(arguments)
    given = {**arguments, "initial": "static"}
    data = recorded_period(system._model, state=state, samples=samples, **given)
    about = {"period": math.inf, "residual": residual, "periods": periods}
    return data, {**about, "method": "superposition"}
