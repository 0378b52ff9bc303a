"""Time integration of a system."""

import os
from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gearbow._convert import number, positive, text, whole
from gearbow._core import require_memory
from gearbow._progress import reported, working
from gearbow._times import distinct, grid
from gearbow._types import (
    Accuracy,
    Array,
    CoreCheckpoint,
    Geometry,
    InitialState,
    Method,
    Progress,
    Record,
    RunData,
)
from gearbow.accuracy import DEFAULT, LEVELS, Level, check_reduction, find_level, tolerance
from gearbow.analysis.protocol import S, System
from gearbow.description.layout import Kinematics
from gearbow.description.speed import SpeedProfile, plain_speed
from gearbow.errors import AccuracyWarning, GearbowError, SceneError, warn
from gearbow.recording.record import RunRequest
from gearbow.results.response import Response
from gearbow.results.steady import SteadyState
from gearbow.system.run import beginning, given_speed, in_order, requests, warn_of_early_end

if TYPE_CHECKING:
    from gearbow.system.run import Checkpoint

#: Accepted types of the speed of a run. The text is what `help` shows.
SpeedLike: TypeAlias = "float | SpeedProfile | Callable[[Any], Any] | tuple[ArrayLike, ArrayLike]"


def simulate(
    self: S,
    duration: float,
    speed: SpeedLike,
    *,
    accuracy: Accuracy | None = None,
    method: Method | None = None,
    step: float | None = None,
    rtol: float | None = None,
    stages: int | None = None,
    modes: int | None = None,
    initial: InitialState | Response | SteadyState | Mapping[str, Any] = "synchronous",
    output_step: float | None = None,
    times: "ArrayLike | None" = None,
    record: Iterable[Record] | None = None,
    geometry: Geometry = "live",
    start: float | None = None,
    progress: bool | Progress | None = None,
    checkpoint: str | os.PathLike[str] | None = None,
    checkpoint_interval: float = 60.0,
) -> Response:
    """Integrate the equations of motion at a constant or a changing speed.

    Parameters
    ----------
    duration : float
        Simulated time [s].
    speed : float, SpeedProfile, callable or (times, speeds)
        Speed Ω of the reference shaft [rad/s]. The angle of shaft s is r_s ∫Ω dt from the time
        0. A callable gives the speed at a time [s]; between points the speed is linear. The
        speed may start or end at zero, but must not change its sign. The torque that
        accelerates a section of a shaft acts on this section.
    accuracy : {"draft", "engineering", "reference"}, optional
        Accuracy of this run, instead of method, step, rtol and stages: that of the system or a
        lower one, because the accuracy of the system decides its elements; a higher one needs
        `system.replace(accuracy=...)`. None is that of the system, if neither method, step nor
        rtol is given. `RotorSystem` lists the total errors, `Response.accuracy` says what holds
        for the run, and `Response.errors()` estimates the error. "draft" and "engineering" keep
        as many modes as the error allows (`Statistics.modes`).
    method : {"exponential", "rk45", "rk4", "etdrk4"}, optional
        "exponential" integrates the linear motion exactly and the mesh forces by Gauss
        collocation; it is the default. "rk45" is the Dormand–Prince 5(4) method with error
        control. "rk4" is the classical Runge–Kutta method with fixed steps. "etdrk4" (Cox and
        Matthews 2002) has fixed steps too and integrates the linear motion exactly, so that
        the shortest element does not limit its step; it needs a constant speed.
    step : float, optional
        Fixed step [s] of "rk4", "etdrk4" or "exponential". None chooses a step that resolves
        the fastest motion for "rk4", and variable steps that meet `rtol` for "exponential".
    rtol : float, optional
        Tolerance of the error of a step of "exponential" and "rk45", relative to the motion in
        the energy norm. None is that of the accuracy, or 1e-6 if a method is given. It excludes
        a fixed step.
    stages : int, optional
        Number of Gauss nodes in a step of "exponential", 1 to 4, half of the order. None is 3.
    modes : int, optional
        Number of modes of "exponential" and "etdrk4": the undamped modes and static displacements
        that matter most for the loads are kept. None is all, or as many as the accuracy needs.
        `Statistics.modes_error` gives the error.
    initial : {"synchronous", "static", "rest"}, Response or SteadyState
        Initial state: static equilibrium plus linear synchronous response, static equilibrium,
        or q = q̇ = 0. Transmission errors and run-out do not contribute to the equilibrium, but
        to the synchronous response if they turn once with a shaft. This response is linear:
        where a bow uses up the backlash, the flanks of this
        state overlap, and the run begins with large forces that are no motion of the machine
        (`MeshResponse.contact` is then 3 at the start). Skip the transient, or use
        `steady_state`. A
        response (or its `final`) is continued: at the same speed without rounding, at another
        speed with the same displacements, velocities and shaft angles.
    output_step : float, optional
        Time between recorded instants [s]. None resolves shaft rotation and tooth passing.
    times : array_like, shape (k,), optional
        Recorded times [s] instead, absolute and in any order.
    record : sequence of str or tuple, optional
        Recorded items: names of gears, disks or shafts (all their nodes), of supports, housings
        and points of housings, (shaft, position), (driver, driven), ("bearing", shaft,
        position), and the groups "gears", "disks", "meshes", "bearings", "housings", "nodes",
        "energy". "velocity" and "acceleration" add those of all recorded places. None is "gears"
        and "meshes"; for a system without gears "disks" and "bearings", for one without disks as
        well "nodes" and "bearings".
    geometry : {"live", "frozen"}
        Whether line of action and engagement follow the moving centres, or are those at rest.
    start : float, optional
        Time at the start [s]; 0 by default.
    progress : bool or callable, optional
        True shows a progress bar, None after 2 s on a terminal; a callable gets the fraction.
    checkpoint : str or path-like, optional
        A ``.npz`` file for the state and the recorded data during the run. After an
        interruption, the same call continues the run, with the same result as without
        interruption. At the end the file contains the response, and the same call reads it.
        Only one run at a time can use a file.
    checkpoint_interval : float, optional
        Wall-clock time between two writings of the checkpoint [s].

    Returns
    -------
    Response
        The motion at the recorded times.

    Raises
    ------
    SceneError
        If an argument is invalid, `accuracy` is higher than that of the system, or the
        checkpoint belongs to another run or is in use by another run.
    StabilityError
        If the step is above the stability limit, or the run diverged.
    ContactError
        If the base circles of a pair overlap.
    KeyboardInterrupt
        At Ctrl-C. This and every other exception that ends a run has the attribute
        `.response`: the data recorded so far, or None before the first step.

    Warns
    -----
    SceneWarning
        If the points (times, speeds) end before the run.
    AccuracyWarning
        If the elements are too coarse for the accuracy, and it is given here or the system has
        "reference"; or if the error of a reduction to `modes` exceeds the accuracy level. If the
        modes are nearly parallel, so that "rk45" replaces "exponential".
    CheckpointWarning
        If the checkpoint cannot be written; the run continues, and the file does not change.

    Examples
    --------
    A bowed shaft is released from rest:

    >>> import gearbow as gb
    >>> bow = gb.Bow.half_sine(1e-4)
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, bow=bow)
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e9) for x in (0.0, 1.0)]
    >>> system = gb.RotorSystem(shafts=[rotor], bearings=bearings)
    >>> middle = ("rotor", 0.5)
    >>> options = {"initial": "rest", "record": [middle, "energy"], "rtol": 1e-8}
    >>> response = system.simulate(0.01, speed=0.0, **options)
    >>> print(f"{1e6 * response.displacement(middle)[:, 0].max():.0f} µm")
    200 µm
    """
    duration = number(duration, "duration")
    state, begin = beginning(initial, start)
    profile = given_speed(speed, begin, duration)
    warn_of_early_end(speed, profile, begin + duration)
    given = {"method": method, "step": step, "rtol": rtol}
    if accuracy is not None:
        given |= {"stages": stages}
    with working(None if progress is None else progress is True, "simulate: elements"):
        system = self._over_time(begin, duration)
        level, coarse = accuracy_level(system, accuracy, given, profile)
    if method is None:
        method = "exponential"
    arguments: dict[str, Any] = {
        "duration": duration,
        "speed": plain_speed(profile),
        "method": text(method, "method"),
        "step": None if step is None else number(step, "step"),
        "rtol": None if rtol is None else number(rtol, "rtol"),
        "stages": None if stages is None else whole(stages, "stages"),
        "modes": None if modes is None else whole(modes, "modes"),
        "initial": state,
        "record": requests(record, system),
        "geometry": text(geometry, "geometry"),
        "start": begin,
        "accuracy": None if level is None else level.name,
    }
    wanted, rows = _times(system, arguments, output_step, times)
    identity = {**arguments, "rtol": tolerance(arguments), "times": wanted, "rows": rows}
    with _checkpoint(system, checkpoint, checkpoint_interval, identity) as file:
        if file is not None and file.complete is not None:
            return Response._from_record(file.complete)
        response = _run(system, arguments, profile, (wanted, rows), progress=progress, file=file)
        state_accuracy(response, system, arguments, level, coarse)
        if file is not None:
            file.finish(response._to_record())
    return response


def default_output_step(self: System, duration: float, speed: SpeedLike) -> float:
    """Give the default time between recorded instants.

    Parameters
    ----------
    duration : float
        Simulated time [s]; infinity gives the step for any duration.
    speed : float, SpeedProfile, callable or (times, speeds)
        Speed of the reference shaft [rad/s], as for `simulate`.

    Returns
    -------
    float
        Time [s]: a fraction of the shortest period of a shaft rotation or tooth passing.
    """
    duration = number(duration, "duration", infinite=True)
    given = given_speed(speed, 0.0, duration)
    return self._model.default_output_step(duration, plain_speed(given), 0.0)


def accuracy_level(
    system: System, accuracy: str | None, given: Mapping[str, Any], speed: SpeedProfile | float
) -> tuple[Level | None, str | None]:
    """Find the accuracy level, and why the elements are too coarse for it."""
    level = find_level(accuracy, system.accuracy, given)
    constant = speed if isinstance(speed, float) else None
    coarse = None if level is None else level.coarse(system._model, constant)
    # Otherwise `Response.accuracy` says what holds.
    is_asked = accuracy is not None or LEVELS[system.accuracy].is_stricter(LEVELS[DEFAULT])
    if is_asked and level is not None and coarse is not None:
        message = (
            f"accuracy: the elements are too coarse for {level.name!r}: {coarse}; "
            f"{level.finer(system._model, system.accuracy)}"
        )
        warn(message, AccuracyWarning)
    return level, coarse


def state_accuracy(
    response: Response,
    system: System,
    arguments: Mapping[str, Any],
    level: Level | None,
    coarse: str | None,
) -> None:
    """State the accuracy of a run, and check what the modes that it leaves out cost."""
    is_given = arguments["modes"] is not None
    if level is not None and arguments["stages"] is None and not is_given:
        response.accuracy = level.explanation(response.events, coarse)
    if level is not None or is_given:
        check_reduction(response.statistics, level or LEVELS[system.accuracy], given=is_given)


def _checkpoint(
    system: System,
    path: str | os.PathLike[str] | None,
    interval: float,
    identity: Mapping[str, Any],
) -> "AbstractContextManager[Checkpoint | None]":
    """Open the checkpoint file of this run; None without a path."""
    interval = positive(interval, "checkpoint_interval", infinite=True)
    if path is None:
        return nullcontext()
    from gearbow.system.run import Checkpoint  # noqa: PLC0415  # with libraries for files

    return Checkpoint(path, interval, {"scene": system.description, **identity})


def _times(
    system: System,
    arguments: Mapping[str, Any],
    output_step: float | None,
    times: "ArrayLike | None",
) -> tuple[Array, NDArray[np.intp] | None]:
    """Find the recorded times, ascending, and the row of each given time."""
    duration, speed, begin = (arguments[name] for name in ("duration", "speed", "start"))
    if times is None:
        if output_step is None:
            output_step = system._model.default_output_step(duration, speed, begin)
        return grid(begin, duration, number(output_step, "output_step")), None
    if output_step is not None:
        raise SceneError("times: cannot be given together with output_step")
    return distinct(times)


def require_memory_of_runs(
    system: System, count: int, duration: float, speed: Any, options: Mapping[str, Any]
) -> None:
    """Refuse runs whose records do not fit into memory together."""
    try:
        times = options.get("times")
        if times is None:
            step = options.get("output_step")
            step = system.default_output_step(duration, speed) if step is None else step
            size = min(number(duration, "duration") / number(step, "output_step"), 1e18)
        else:
            size = np.size(times)
        record = requests(options.get("record"), system)
        needed = system._model.record_bytes(record, int(size) + 1)
    except (GearbowError, ArithmeticError, TypeError, ValueError):
        return
    remedy = (
        "record fewer places or quantities (record=) or fewer times (output_step=, times=), or "
        "measure each run by gearbow.sweep"
    )
    require_memory("variations", f"the records of {count} runs", float(count * needed), remedy)


def _run(
    system: System,
    arguments: dict[str, Any],
    speed: float | SpeedProfile,
    times: tuple[Array, NDArray[np.intp] | None],
    *,
    progress: bool | Progress | None,
    file: "Checkpoint | None",
) -> Response:
    """Run with or without a checkpoint. An exception carries the response so far."""
    wanted, rows = times

    def core(left: Array, checkpoint: CoreCheckpoint | None, report: Progress | None) -> RunData:
        return system._model.simulate(
            **arguments, times=left, checkpoint=checkpoint, progress=report
        )

    try:
        with reported(
            progress, arguments["duration"], what="simulate", setup="modes, pilot runs"
        ) as report:
            if file is None:
                data = core(wanted, None, report)
            else:
                data = file.run(core, wanted, speed, report)
    except BaseException as error:
        partial: RunData | None = getattr(error, "partial", None)
        if partial is not None:
            error.response = response_of(system, partial, rows, speed, arguments)  # type: ignore[attr-defined]
            del error.partial  # type: ignore[attr-defined]
        elif not hasattr(error, "response"):
            error.response = None  # type: ignore[attr-defined]  # no step was done
        raise
    return response_of(system, data, rows, speed, arguments)


def response_of(
    system: System,
    data: RunData,
    rows: NDArray[np.intp] | None,
    speed: float | SpeedProfile,
    arguments: dict[str, Any],
) -> Response:
    """Give the response of recorded data, with the request that continues the run."""
    response = Response(in_order(data, rows), speed)
    response.kinematics = Kinematics.of(system)
    response.request = RunRequest(system.description, arguments)
    return response
