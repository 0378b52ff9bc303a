"""Steady states, periodic or as sums of periodic motions."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gearbow._convert import LARGEST_COUNT, number, positive, text, whole
from gearbow._core import (
    common_period,
    has_constant_coefficients,
    initial_state,
    recorded_period,
    slowest_period,
    steady_state as steady_period,
    user_order,
)
from gearbow._progress import reported
from gearbow._types import Accuracy, Array, Geometry, InitialState, Progress, Record, RunData
from gearbow.accuracy import tolerance
from gearbow.analysis.protocol import S, System, silent, variant
from gearbow.description.gears import Mesh, TransmissionError
from gearbow.description.layout import Kinematics, ratios_by_shaft, shafts_of_bodies
from gearbow.description.speed import plain_speed
from gearbow.description.time_series import TimeSeries
from gearbow.errors import SceneError
from gearbow.orders.separation import SEPARATION
from gearbow.results.response import Response  # noqa: TC001  # type hints of the signature
from gearbow.results.steady import SteadyState
from gearbow.system.run import beginning, given_speed, requests
from gearbow.system.simulation import accuracy_level, response_of, state_accuracy

# Steady motion of several sources without a common period, as the sum of their steady motions.
#
# This is exact where the equation of motion is linear with constant coefficients. Everything that
# turns with a shaft is in the synchronous response; each other source has a period of its own.

#: Turns of the slowest shaft in a record that does not separate its orders, and the largest number
#: for one that does: of example machines with rolling bearings, ten turns take up to 4.8 s.
_UNSEPARATED, _MOST = 2.0, 10.0
#: Part by which the record is longer than its orders need, because it leaves out its last instant.
_MARGIN = 0.02
#: Options of the run that are those of a steady state, whose start does not depend on them.
_FIXED = {"initial": "static", "modes": None, "accuracy": None}


@dataclass(frozen=True)
class Superposition:
    """The sources of a system at a constant speed."""

    system: System
    speed: float

    @classmethod
    def of(cls, system: System, speed: float, geometry: str) -> "Superposition | None":
        """Give the superposition if the motions of the sources of a system superpose."""
        values: list[Any] = [torque.value for torque in system.torques]
        values += [force.value for force in system.forces]
        over_time = any(isinstance(value, TimeSeries) or callable(value) for value in values)
        if over_time or speed == 0.0 or not has_constant_coefficients(system._model, geometry):
            return None
        return cls(system, speed)

    def solve(self, arguments: dict[str, Any]) -> tuple[Array, float, int]:
        """Find the state at the start, and describe the solutions that it consists of."""
        options = {key: value for key, value in arguments.items() if key != "record"} | _FIXED
        options["rtol"] = tolerance(arguments)
        # Variants have the elements of this system, which may depend on what excites it.
        meshed = type(self.system)._from_description(self.system._model.resolved())
        parts = silent(meshed)
        # Transmission errors are sources of their own, also with their first orders.
        smooth = variant(meshed, meshes=parts["meshes"])._model
        rest = initial_state(smooth, **options)
        state = initial_state(smooth, **{**options, "initial": "synchronous"})
        residual, periods = 0.0, 0
        for period, changes in self._sources():
            model = variant(meshed, **{**parts, **changes})._model
            given = {**options, "duration": period}
            data, about = steady_period(
                model, **given, slowest=None, samples=1, record=[], progress=None
            )
            state = state + user_order(model, data["final"]["state"]) - rest
            residual = max(residual, about["residual"])
            periods += about["periods"]
        return state, residual, periods

    def _sources(self) -> Iterator[tuple[float, dict[str, Any]]]:
        """Give period and parts of each source that the synchronous response does not contain."""
        system, parts = self.system, silent(self.system)
        for i, mesh in enumerate(system.meshes):
            for ratio, error in self._errors(mesh):
                meshes = list(parts["meshes"])
                meshes[i] = replace(mesh, error=error)
                yield self._turn(ratio), {"meshes": meshes}
        for i, force in enumerate(system.forces):
            if force.order is None or force.order == 1.0:
                continue
            forces = list(parts["forces"])
            forces[i] = force
            yield self._turn(self._ratio(force.at) * (force.order or 1.0)), {"forces": forces}

    def _errors(self, mesh: Mesh) -> Iterator[tuple[float, TransmissionError]]:
        """Give the parts of a transmission error with their orders of the reference shaft."""
        error = mesh.error
        if error is None:
            return
        driver, driven = self._ratio(mesh.driver), self._ratio(mesh.driven)
        teeth = next(gear.teeth for gear in self.system.gears if gear.name == mesh.driver)
        if error.tooth is not None or error.table is not None:
            yield driver * teeth, TransmissionError(tooth=error.tooth, table=error.table)
        if error.driver is not None:
            yield driver, TransmissionError(driver=error.driver)
        if error.driven is not None:
            yield driven, TransmissionError(driven=error.driven)

    def _ratio(self, at: Any) -> float:
        """Give the speed of the shaft of a place over that of the reference shaft."""
        name = shafts_of_bodies(self.system)[at] if isinstance(at, str) else at[0]
        return ratios_by_shaft(self.system)[name]

    def _turn(self, order: float) -> float:
        """Give the period of an order of the reference shaft [s]."""
        return _turn(order, self.speed)


def recorded_duration(system: System, speed: float, longest: float) -> float:
    """Give the duration of the record without a period [s]: what orders need, or two turns."""
    ratios = np.abs(system.speed_ratios)
    turn = _turn(float(ratios[ratios > 0.0].min()), speed)
    gaps = np.diff([0.0, *(order.value for order in Kinematics.of(system).orders())])
    separate = (1.0 + _MARGIN) * SEPARATION * _turn(float(gaps.min()), speed)
    is_short = separate <= min(_MOST * turn, longest)
    return min(max(turn, separate) if is_short else _UNSEPARATED * turn, longest)


def _turn(order: float, speed: float) -> float:
    return 2.0 * math.pi / abs(order * speed)


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
        Longest common period, and record without one [s]; a longer period counts as none.
    accuracy : {"draft", "engineering", "reference"}, optional
        Accuracy of the motion, as for `simulate`.
    step : float, optional
        Fixed step [s]; the period is divided into steps of at most this length.
    rtol : float, optional
        Tolerance of the integration, as for `simulate`, and of the error of the iteration.
    stages : int, optional
        Number of Gauss nodes in a step, 1 to 4.
    modes : int, optional
        Number of modes, as for `simulate`.
    initial : {"synchronous", "static", "rest"}, Response or SteadyState
        Motion from which the iteration starts; it decides which of several ones is found.
    output_step : float, optional
        Longest time between recorded instants [s]; None resolves shaft rotation and tooth passing.
    record : sequence of str or tuple, optional
        Recorded items, as for `simulate`.
    geometry : {"live", "frozen"}
        As for `simulate`.
    start : float, optional
        Time at the start [s]; 0 by default.
    progress : bool or callable, optional
        True shows a progress bar, None after 2 s on a terminal; a callable gets the fraction.

    Returns
    -------
    SteadyState
        One period of the motion. Without a common period, one to ten turns of the slowest shaft if
        these separate the default orders of `Response.orders`, otherwise two; at most `max_period`.

    Raises
    ------
    SceneError
        If there is no common period up to `max_period`, and a load over time.
    ConvergenceError
        If the iteration does not converge, or without a common period the motion does not settle.
    StabilityError, ContactError
        As for `simulate`.

    Examples
    --------
    >>> import gearbow as gb
    >>> system = gb.examples()["bowed_rotor"].load()
    >>> steady = system.steady_state(100.0, record=["disk"])
    >>> steady.instability() is None
    True
    """
    state, begin = beginning(initial, start)
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
    # A simulation that continues from the end of the period has the same motion.
    final = dict(data["final"])
    again = {**arguments, "initial": final, "start": final["time"]}
    response = response_of(system, data, None, speed, again)
    state_accuracy(response, system, arguments, level, coarse)
    return SteadyState(response, about, system._model)


def _period(
    system: S, speed: float, given: float | None, longest: float, geometry: str
) -> tuple[float, "Superposition | float | None"]:
    """Give the period; without one, the duration of the record, and the sources or `slowest`."""
    if given is not None:
        given = positive(given, "period")
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


def period_samples(system: System, period: float, speed: float, output_step: float | None) -> int:
    """Give the number of recorded instants in a period."""
    if output_step is None:
        output_step = system._model.default_output_step(period, speed, 0.0)
    output_step = positive(output_step, "output_step")
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
