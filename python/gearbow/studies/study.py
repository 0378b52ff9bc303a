"""Runs of a tradeoff study: a reference and its check, then a sweep over models and settings.

Signals are displacements and mesh forces; the error is the difference between two runs.
"""

import math
import sys
import time
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

import numpy as np

from gearbow._types import Array, At, Progress
from gearbow.accuracy import root_mean_square, unit_of_errors, variation
from gearbow.analysis.protocol import S, System, variant
from gearbow.description.places import is_pair, is_place, place, place_label
from gearbow.errors import AccuracyWarning, ContactError, GearbowError, SceneError
from gearbow.results.response import Response
from gearbow.studies.result import Skipped, Tradeoff, Trial
from gearbow.studies.settings import GIVEN, METHODS, Model, Setting, references, refined
from gearbow.sweeps.result import SweepPoint
from gearbow.sweeps.run import sweep


@dataclass(frozen=True)
class Signal:
    """A signal of a response: the displacement of a point or the force of a mesh."""

    of: Any

    @property
    def is_force(self) -> bool:
        """Whether the signal is a mesh force."""
        return isinstance(self.of, tuple) and isinstance(self.of[1], str)

    def values(self, response: Response) -> Array:
        """Return the signal of a response."""
        if self.is_force:
            return response.mesh(self.of).force[:, np.newaxis]
        return response.displacement(self.of)

    def __str__(self) -> str:
        if self.is_force:
            return f"the force of {self.of[0]}/{self.of[1]}"
        return f"the displacement of {place_label(self.of)}"


def signal_errors(
    found: Mapping[str, Array], other: Mapping[str, Array], scale: Mapping[str, Array]
) -> dict[str, float]:
    """Return the relative difference of each signal of two runs."""
    return {
        name: root_mean_square(found[name] - other[name]) / unit_of_errors(exact)
        for name, exact in scale.items()
    }


def signal_error(
    found: Mapping[str, Array], other: Mapping[str, Array], scale: Mapping[str, Array]
) -> float:
    """Return the relative difference of two runs for the worst signal."""
    return max(signal_errors(found, other, scale).values())


def check_signals(found: Mapping[str, Array]) -> None:
    """Reject constant signals, for which a relative error is undefined."""
    for name, values in found.items():
        if not variation(values) > 0.0:
            raise SceneError(
                f"signals: {name} is constant in this run, so its relative error is "
                "undefined; give another signal"
            )


def read_signals(system: System, given: object) -> tuple[Signal, ...]:
    """Read the signals of a study and check that the system has them."""
    if given is None:
        names = [gear.name for gear in system.gears] + [disk.name for disk in system.disks]
        if not names:
            raise SceneError("signals: the system has no gear or disk; give (shaft, position)")
        given = names[0]
    single = isinstance(given, str) or is_place(given) or is_pair(given)
    items = [given] if single else given
    if not isinstance(items, Iterable):
        raise SceneError(
            f"signals: must be a name, (shaft, position) or (driver, driven), got {given!r}"
        )
    wanted = tuple(_signal(system, item) for item in items)
    if not wanted:
        raise SceneError("signals: must name at least one signal")
    return wanted


def _signal(system: System, item: Any) -> Signal:
    if is_pair(item):
        if tuple(item) not in {(mesh.driver, mesh.driven) for mesh in system.meshes}:
            raise SceneError(f"signals: no gear {item[0]!r} drives a gear {item[1]!r}")
        return Signal(tuple(item))
    if not (isinstance(item, str) or is_place(item)):
        raise SceneError(
            f"signals: must be a name, (shaft, position) or (driver, driven), got {item!r}"
        )
    at: At = place(item)
    try:
        system.coordinates.lateral(at)
    except SceneError as error:
        raise SceneError(f"signals: {str(error).removeprefix('at: ')}") from None
    except GearbowError:
        message = f"signals: {item!r} has no lateral motion; give a mesh, (driver, driven)"
        raise SceneError(message) from None
    return Signal(at)


#: Relative rounding error of double precision.
ROUND_OFF = sys.float_info.epsilon
#: Fraction of the budget for the reference run, and the same for its check.
_FOR_REFERENCE = 0.3
#: Limit of one run divided by an equal share of the remaining budget.
_PATIENCE = 4.0
#: An integration error below this fraction of the model error needs no tighter setting.
_NEGLIGIBLE = 0.1


class _NotNeededError(Exception):
    """A setting would show nothing new."""


@dataclass(frozen=True, eq=False)
class _Run(Generic[S]):
    """A completed run."""

    model: Model[S]
    setting: Setting
    signals: dict[str, Array]
    #: Costs, as arguments of `Trial`.
    costs: dict[str, Any]


@dataclass(eq=False)
class Study(Generic[S]):
    """The checked arguments of a study, and its runs."""

    system: S
    duration: float
    speed: float
    wanted: tuple[Signal, ...]
    #: Options of `simulate` that all runs share.
    options: dict[str, Any]
    settings: list[Setting]
    simpler: list[Model[S]]
    degrees: list[int]
    repeats: int
    budget: float
    #: Run of each model with the tightest setting that the budget permits.
    own: dict[str, _Run[S]] = field(default_factory=dict)
    trials: list[Trial[S]] = field(default_factory=list)
    skipped: list[Skipped] = field(default_factory=list)
    #: Names of simplified models whose integration error has become negligible.
    finished: set[str] = field(default_factory=set)
    #: Number of runs that share the remaining budget.
    waiting: int = 1

    def __post_init__(self) -> None:
        self.end = time.perf_counter() + self.budget
        self.given = Model(GIVEN, self.system)

    def carried_out(self, progress: bool | Progress | None) -> Tradeoff[S]:
        """Run all settings that the budget permits."""
        candidates = references(self.system, self.speed)
        self.reference = self._verified(candidates, "reference")
        check_signals(self.reference.signals)
        # Another method, or the same method with another setting.
        used = self.reference.setting
        same = [setting for setting in candidates if setting.method == used.method]
        others = [setting for setting in candidates if setting.method != used.method]
        others += [Setting(used.method, 0.5 * used.value), *same[same.index(used) + 1 :]]
        self.check = self._verified(others, "check of the reference")
        self.own[GIVEN] = self.exact = self.reference
        # Runs that agree to the last bit are still rounded: no error below that is known.
        self.floor = max(self._error(self.check, self.reference), ROUND_OFF)
        points = self._points()
        if not points:  # all settings are those of the reference and its check
            return self._tradeoff(())
        self.waiting = len(points)
        # One run after the other: another one would change its time.
        with ThreadPoolExecutor(1) as executor:
            try:
                found = sweep(_system, points, self._measured, executor, progress=progress)
            except KeyboardInterrupt as stop:
                stop.tradeoff = self._tradeoff(stop.sweep.failed)  # type: ignore[attr-defined]
                raise
        return self._tradeoff(found.failed)

    def _points(self) -> list[dict[str, Any]]:
        """List the models and settings. None is the tightest setting, which comes first."""
        finer = [refined(self.system, self.degrees)] if self.degrees else []
        known = (self.reference.setting, self.check.setting)
        runs: list[tuple[Model[S], Setting | None]] = [(model, None) for model in finer]
        runs += [(self.given, setting) for setting in self.settings if setting not in known]
        for model in self.simpler:
            methods = model.methods or (self.settings[0].method,)
            own = [setting for setting in self.settings if setting.method in methods]
            runs += [(model, setting) for setting in (None, *own)]
        return [{"model": model, "setting": setting} for model, setting in runs]

    def _measured(self, _: S, *, model: Model[S], setting: Setting | None) -> Mapping[str, Any]:
        """Run a setting of a model within its share of the remaining budget."""
        share = self._share()
        self.waiting -= 1
        if setting is None:
            run = self.own[model.name] = self._tightest(model)
            if model not in self.simpler:
                self.exact = run
            return run.costs
        if model.name in self.finished or model.name not in self.own:
            raise _NotNeededError
        trial = self._trial(self._run(model, setting, _PATIENCE * share, share))
        self.trials.append(trial)
        if model in self.simpler and trial.integration_error < _NEGLIGIBLE * trial.model_error:
            # A tighter setting costs more and does not reduce the total error.
            self.finished.add(model.name)
        return trial.errors

    def _verified(self, candidates: list[Setting], what: str) -> _Run[S]:
        """Run the given system with the first setting that its part of the budget permits."""
        for setting in candidates:
            try:
                return self._run(self.given, setting, _FOR_REFERENCE * self.budget)
            except ContactError:
                raise  # the error is independent of the setting
            except (TooSlowError, GearbowError) as error:
                self.skipped.append(Skipped(str(setting), GIVEN, str(error)))
        tried = "; ".join(map(str, self.skipped))
        raise GearbowError(f"budget: too short for a {what} ({tried})")

    def _tightest(self, model: Model[S]) -> _Run[S]:
        """Run a model with the setting of the reference, or with a similar one."""
        used = self.reference.setting
        others = references(model.system, self.speed)
        same = [setting for setting in others if setting.method == used.method]
        errors: list[Exception] = []
        for setting in dict.fromkeys((used, *same, *others)):
            if model.methods is None or setting.method in model.methods:
                try:
                    return self._run(model, setting, _PATIENCE * self._share())
                except (TooSlowError, GearbowError) as error:
                    errors.append(error)
        raise errors[0]

    def _share(self) -> float:
        """Return the remaining budget per remaining run."""
        return self._left() / max(1, self.waiting)

    def _left(self) -> float:
        return max(0.0, self.end - time.perf_counter())

    def _run(
        self, model: Model[S], setting: Setting, allowance: float, share: float = 0.0
    ) -> _Run[S]:
        left = self._left()
        if left == 0.0:
            raise TooSlowError
        response, cost = measure(
            model.system,
            self.duration,
            self.speed,
            {**self.options, **setting.options, **model.options},
            allowance=min(allowance, left),
            share=share,
            repeats=self.repeats,
        )
        found = response.statistics
        costs = {name: getattr(found, name) for name in ("steps", "evaluations", "limited_by")}
        values = {str(signal): signal.values(response) for signal in self.wanted}
        return _Run(model, setting, values, {**vars(cost), **costs})

    def _error(self, run: _Run[S], other: _Run[S]) -> float:
        return signal_error(run.signals, other.signals, self.exact.signals)

    def _trial(self, run: _Run[S]) -> Trial[S]:
        own, exact = self.own[run.model.name], self.exact
        return Trial(
            setting=str(run.setting),
            model=run.model.name,
            options={**run.setting.options, **run.model.options},
            system=run.model.system,
            method=run.setting.method,
            errors=signal_errors(run.signals, exact.signals, exact.signals),
            integration_error=self._error(run, own),
            model_error=self._error(own, exact),
            floor=self.floor,
            duration=self.duration,
            **run.costs,
        )

    def _tradeoff(self, failed: Sequence[SweepPoint]) -> Tradeoff[S]:
        """Return the result, complete or not."""
        order = [GIVEN, *(model.name for model in self.simpler)]
        own = [run for run in self.own.values() if run.model.name in order]
        # The tightest run of a model is its last row.
        trials = [*self.trials, *map(self._trial, (self.check, *own))]
        trials.sort(key=lambda trial: (order.index(trial.model), list(METHODS).index(trial.method)))
        for point in failed:
            reason = point.error.removeprefix(f"{TooSlowError.__name__}: ")
            if reason != _NotNeededError.__name__:
                setting = point.parameters["setting"] or self.reference.setting
                model = point.parameters["model"].name
                self.skipped.append(Skipped(str(setting), model, reason))
        finer = None
        if self.exact is not self.reference:
            exact = self.exact.signals
            finer = (self.exact.model.name, signal_errors(self.reference.signals, exact, exact))
        return Tradeoff(
            trials=tuple(trials),
            skipped=tuple(self.skipped),
            reference=str(self.reference.setting),
            check=str(self.check.setting),
            floor=self.floor,
            discretisation=finer,
            duration=self.duration,
            speed=self.speed,
            signals=tuple(map(str, self.wanted)),
        )


def _system(model: Model[S], setting: Setting | None) -> S:
    del setting
    return model.system


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
