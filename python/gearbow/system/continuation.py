"""Branches of steady states of a system over a parameter."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gearbow._convert import number, one_of, positive, text, whole
from gearbow._core import (
    KeptModes,
    common_period,
    corrected_states,
    kept_modes,
    multipliers,
    recorded_period,
    user_order,
)
from gearbow._progress import reported
from gearbow._types import (
    Accuracy,
    Array,
    BranchParameter,
    ComplexArray,
    Geometry,
    InitialState,
    Progress,
    Record,
    RunData,
)
from gearbow.accuracy import LEVELS, check_reduction
from gearbow.analysis.arclength import BranchPoint, Settings, branch
from gearbow.analysis.protocol import System, variant
from gearbow.description.bow import scaled
from gearbow.description.layout import Kinematics
from gearbow.errors import AccuracyWarning, GearbowError, SceneError, warn
from gearbow.results.response import Response
from gearbow.results.steady import (
    SMALLEST_MULTIPLIER,
    UNITS,
    BranchData,
    Continuation,
    SteadyState,
    summary,
)
from gearbow.system.linear import matrices
from gearbow.system.run import requests
from gearbow.system.simulation import accuracy_level
from gearbow.system.steady import period_samples, steady_state

#: Smallest number of recorded instants in a period.
_SAMPLES = 128
#: Refinement of the recorded instants in which the smallest deflection is sought.
_FINER = 8
#: Largest residual of a point, in multiples of the tolerance of the integration.
_RESIDUAL = 10.0


def continuation(
    self: System,
    parameter: BranchParameter,
    begin: float,
    end: float,
    *,
    speed: float | None = None,
    periods: int = 1,
    max_period: float = 10.0,
    accuracy: Accuracy | None = None,
    rtol: float | None = None,
    first_step: float = 0.02,
    max_points: int = 400,
    initial: InitialState | SteadyState = "static",
    record: Iterable[Record] | None = None,
    geometry: Geometry = "live",
    progress: bool | Progress | None = None,
) -> Continuation:
    """Follow the steady motion over a parameter, through folds, with its stability.

    Parameters
    ----------
    parameter : {"speed", "torque", "bow", "backlash"}
        Speed of the reference shaft [rad/s], factor of all constant torques, factor of all
        bows, or backlash of all meshes that have one [m].
    begin, end : float
        Interval of the parameter. The branch starts at `begin` and stops where it leaves the
        interval, at `end` or, after a fold, at `begin`.
    speed : float, optional
        Speed of the reference shaft [rad/s], if it is not the parameter.
    periods : int
        Period of the motion in common periods of the excitation.
    max_period : float
        Longest accepted common period [s].
    accuracy : {"draft", "engineering", "reference"}, optional
        Accuracy of the motion, as for `simulate`. All points keep the same modes: those that
        the motion at `begin` needs, at the faster end of a branch over the speed.
    rtol : float, optional
        Tolerance of the integration in place of the accuracy; all modes are kept.
    first_step : float
        First step along the branch, over the interval.
    max_points : int
        Largest number of points.
    initial : {"synchronous", "static", "rest"} or SteadyState
        Motion from which the first search starts; a steady state that started at time 0.
    record : sequence of str or tuple, optional
        Recorded items, as for `simulate`.
    geometry : {"live", "frozen"}
        As for `simulate`.
    progress : bool or callable, optional
        True shows a progress bar, None after 2 s on a terminal; a callable gets the fraction.

    Returns
    -------
    Continuation
        The branch. `Continuation.message` and an `AccuracyWarning` say why it ends early.

    Raises
    ------
    ConvergenceError
        If there is no steady state at `begin`.
    KeyboardInterrupt
        At Ctrl-C. The exception has the attribute `.branch`: the branch so far.
    """
    _check(parameter, begin, end, speed)
    begin, end = number(begin, "begin"), number(end, "end")
    length, most = positive(first_step, "first_step"), whole(max_points, "max_points")
    at = begin if speed is None else number(speed, "speed")
    text(geometry, "geometry")
    periods = whole(periods, "periods")
    fastest = max(begin, end, key=abs) if speed is None else at
    level, _ = accuracy_level(self, accuracy, {"rtol": rtol}, fastest)
    if rtol is not None:
        rtol = number(rtol, "rtol")
    family = _Family(self, parameter, at)
    first = family.system(begin)
    longest = number(max_period, "max_period")
    common = periods * common_period(first._model, at, None, longest)
    wanted = requests(record, self)
    found = steady_state(
        first,
        at,
        period=common,
        accuracy=accuracy,
        rtol=rtol,
        initial=initial,
        geometry=geometry,
        record=wanted,
    )
    motion = _Motion(
        family,
        wanted,
        _RunSettings(None if level is None else level.name, rtol, geometry),
        (periods, longest),
        _samples(self, common, at),
    )
    if level is not None:
        motion.keep_modes(begin, fastest)
    settings = Settings(
        begin,
        end,
        length,
        most,
        tolerance=_RESIDUAL * motion.run.tolerance,
    )
    return _followed(motion, motion.unknowns(found), settings, progress)


def _check(parameter: str, begin: float, end: float, speed: float | None) -> None:
    """Check what is followed."""
    one_of(parameter, UNITS, "parameter")
    first, last = number(begin, "begin"), number(end, "end")
    if first == last:
        raise SceneError(f"end: must differ from begin, got {last}")
    if (parameter == "speed") == (speed is not None):
        raise SceneError('speed: give it for every parameter except "speed"')


def _followed(
    motion: "_Motion", first: Array, settings: Settings, progress: bool | Progress | None
) -> Continuation:
    """Follow a branch, and keep what was computed where it ends early."""
    points: list[BranchPoint] = []
    message = ""
    try:
        with reported(
            progress, settings.max_points, "points", what="continuation", estimate=False
        ) as report:
            for point in branch(motion, first, settings):
                points.append(point)
                if report is not None:
                    report(min(1.0, len(points) / settings.max_points))
    except KeyboardInterrupt as error:
        error.branch = motion.result(points, "interrupted") if points else None  # type: ignore[attr-defined]
        raise
    except GearbowError as error:
        if not points:
            raise
        message = str(error)
    ended = len(points) > 1 and points[-1].value in (settings.begin, settings.end)
    if not message and not ended:
        message = f"max_points: {settings.max_points} points reach {points[-1].value:.6g}"
    if message:
        parameter = motion.family.parameter
        text = f"continuation: the branch ends before {parameter} {settings.end:.6g}: {message}"
        warn(text, AccuracyWarning)
    return motion.result(points, message)


def _samples(system: System, period: float, speed: float) -> int:
    """Give the number of recorded instants in a period."""
    return max(_SAMPLES, period_samples(system, period, speed, None))


class _Family:
    """Systems over the parameter."""

    def __init__(self, base: System, parameter: str, speed: float) -> None:
        if parameter != "speed":
            # The elements must not follow the loads: all systems have the same coordinates.
            base = type(base)._from_description(base._model.resolved())
        self.base, self.parameter, self.fixed = base, parameter, speed
        self._last: tuple[float, System] = (math.nan, base)

    def speed(self, value: float) -> float:
        """Speed of the reference shaft [rad/s]."""
        return value if self.parameter == "speed" else self.fixed

    def system(self, value: float) -> System:
        """Give the system at a value."""
        if self.parameter == "speed":
            return self.base
        if self._last[0] != value:
            self._last = (value, variant(self.base, **self._changes(value)))
        return self._last[1]

    def _changes(self, value: float) -> dict[str, Any]:
        base = self.base
        if self.parameter == "torque":
            return {"torques": [_scaled_torque(torque, value) for torque in base.torques]}
        if self.parameter == "bow":
            if all(shaft.bow is None for shaft in base.shafts):
                raise SceneError("bow: no shaft has a bow; give one to a shaft")
            shafts = [replace(each, bow=scaled(each.bow, value)) for each in base.shafts]
            return {"shafts": shafts}
        if all(mesh.backlash is None for mesh in base.meshes):
            raise SceneError("backlash: no mesh has a backlash; give one to a mesh")
        return {
            "meshes": [
                mesh if mesh.backlash is None else replace(mesh, backlash=value)
                for mesh in base.meshes
            ]
        }


def _scaled_torque(torque: Any, factor: float) -> Any:
    if not isinstance(torque.value, (int, float)):
        return torque
    return replace(torque, value=factor * torque.value)


@dataclass(frozen=True)
class _Modes:
    """Undamped modes as a basis: elastic ones by ωη and η̇, rigid-body motions by η̇."""

    shapes: Array
    frequencies: Array
    inverse: Array
    #: Number of rigid-body modes, which come first.
    rigid: int

    @classmethod
    def of(cls, system: System, speed: float) -> "_Modes":
        found = matrices(system, speed)
        factor = np.linalg.inv(np.linalg.cholesky(found.mass))
        stiffness = (found.stiffness + found.stiffness.T) / 2.0
        squares, vectors = np.linalg.eigh(factor @ stiffness @ factor.T)
        # Directions of negative stiffness, which oil films have, are no rigid-body motions.
        order = np.argsort(np.abs(squares))
        shapes = factor.T @ vectors[:, order]
        frequencies = np.sqrt(np.abs(squares[order]))
        rigid = int(np.sum(frequencies < 1e-6 * frequencies[-1])) if frequencies.size else 0
        return cls(shapes, frequencies, shapes.T @ found.mass, rigid)

    def unknowns(self, states: Array) -> Array:
        """Convert displacements and velocities, (k, 2n)."""
        n = self.frequencies.size
        q, v = states[:, :n] @ self.inverse.T, states[:, n:] @ self.inverse.T
        return np.hstack([(q * self.frequencies)[:, self.rigid :], v])

    def states(self, unknowns: Array) -> Array:
        """Convert unknowns, (k, 2n − rigid), with rigid-body motions at their origin."""
        n, rigid = self.frequencies.size, self.rigid
        q = np.zeros((unknowns.shape[0], n))
        q[:, rigid:] = unknowns[:, : n - rigid] / self.frequencies[rigid:]
        return np.hstack([q @ self.shapes.T, unknowns[:, n - rigid :] @ self.shapes.T])


@dataclass(frozen=True)
class _RunSettings:
    """Accuracy and geometry of the runs."""

    accuracy: str | None
    rtol: float | None
    geometry: str

    @property
    def tolerance(self) -> float:
        """Relative tolerance of the integration."""
        return LEVELS[self.accuracy].rtol if self.accuracy is not None else self.rtol or 0.0


class _Motion:
    """Steady states over the unknowns of the first system: a `gearbow.analysis.arclength.Map`."""

    def __init__(
        self,
        family: _Family,
        record: list[Any],
        run: _RunSettings,
        period: tuple[int, float],
        samples: int,
    ) -> None:
        self.family, self.record, self.samples = family, record, samples
        self.run = run
        self.periods, self.longest = period
        self.modes = _Modes.of(family.base, family.fixed)
        self._levels: bytes | None = None
        self._kept: KeptModes | None = None

    def keep_modes(self, value: float, fastest: float) -> None:
        """Keep the modes that the system of one value needs at the fastest speed."""
        system, options = self._options(value)
        options |= {"speed": fastest, "initial": "synchronous"}
        options["duration"] = self._period(system, fastest)
        self._kept = kept_modes(system._model, record=self.record, **options)
        if self._kept is not None and self.run.accuracy is not None:
            check_reduction(self._kept, LEVELS[self.run.accuracy], given=False)

    def unknowns(self, found: SteadyState) -> Array:
        """Give the unknowns of the first steady state."""
        final = found.response.final
        state = user_order(self.family.base._model, final["state"])
        unknowns: Array = self.modes.unknowns(state[None])[0]
        return unknowns

    def images(self, states: Array, value: float, *, adapt: bool = False) -> Array:
        """Give the unknowns after one step of the iteration for the steady state."""
        system, options = self._options(value)
        corrected, self._levels = corrected_states(
            system._model,
            states=np.ascontiguousarray(self.modes.states(states)),
            levels=None if adapt else self._levels,
            kept=self._kept,
            **options,
        )
        return self.modes.unknowns(corrected)

    def observed(self, state: Array, value: float) -> tuple[RunData, float]:
        """Give the recorded period, and the smallest deflection of a mesh with backlash."""
        system, options = self._options(value)
        data = recorded_period(
            system._model,
            state=self.modes.states(state[None])[0],
            samples=self.samples,
            record=self.record,
            kept=self._kept,
            **options,
        )
        meshes = {(mesh.driver, mesh.driven): mesh for mesh in self.family.base.meshes}
        margin = math.inf
        for column, pair in enumerate(data["meshes"]):
            if meshes[tuple(pair)].backlash is not None:  # type: ignore[index]
                margin = min(margin, _smallest(data["mesh"]["deflection"][:, column]))
        return data, margin

    def multipliers(self, kept: RunData, value: float) -> ComplexArray:
        """Compute the multipliers as those of a steady state."""
        system, options = self._options(value)
        last = kept["final"]
        options |= {"initial": last, "start": last["time"]}
        return multipliers(
            system._model,
            **options,
            smallest=SMALLEST_MULTIPLIER,
            record=[],
            progress=None,
            kept=self._kept,
        )

    def _options(self, value: float) -> tuple[System, dict[str, Any]]:
        """Give the system at a value, and the options of its runs."""
        system, speed = self.family.system(value), self.family.speed(value)
        return system, {
            "initial": "static",
            "duration": self._period(system, speed),
            "speed": speed,
            "method": "exponential",
            "step": None,
            "rtol": self.run.rtol,
            "stages": None,
            "modes": None,
            "accuracy": self.run.accuracy,
            "geometry": self.run.geometry,
            "start": 0.0,
        }

    def _period(self, system: System, speed: float) -> float:
        """Give the period of the motion [s]."""
        return self.periods * common_period(system._model, speed, None, self.longest)

    def result(self, points: list[BranchPoint], message: str) -> Continuation:
        """Give the points as a result."""
        speed = self.family.fixed
        signals = Response(summary([point.kept for point in points]), speed)
        signals.kinematics = Kinematics.of(self.family.base)
        multipliers = [
            [(float(z.real), float(z.imag)) for z in point.multipliers] for point in points
        ]
        data = BranchData(
            parameter=self.family.parameter,
            speed=speed,
            unknowns=points[0].state.size,
            values=[float(point.value) for point in points],
            kinds=[point.kind for point in points],
            multipliers=multipliers,
            message=message,
        )
        return Continuation(signals, data)


def _smallest(values: Array) -> float:
    """Give the smallest value of a periodic signal, by a parabola through its finest samples."""
    spectrum = np.fft.rfft(values)
    fine = np.fft.irfft(spectrum, _FINER * values.size) * _FINER
    at = int(np.argmin(fine))
    before, lowest, after = fine[at - 1], fine[at], fine[(at + 1) % fine.size]
    curvature = before - 2.0 * lowest + after
    if curvature <= 0.0:
        return float(lowest)
    return float(lowest - (after - before) ** 2 / (8.0 * curvature))
