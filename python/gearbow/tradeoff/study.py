"""Runs of a study: a reference and its check, then a sweep over models and settings."""

import math
import sys
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

import numpy as np

from gearbow._types import Array, Progress
from gearbow.analysis.protocol import S, System, variant
from gearbow.errors import AccuracyWarning, ContactError, GearbowError
from gearbow.results.response import Response
from gearbow.sweeps.result import SweepPoint
from gearbow.sweeps.run import sweep
from gearbow.tradeoff import signals
from gearbow.tradeoff.models import GIVEN, Model, refined
from gearbow.tradeoff.result import Tradeoff
from gearbow.tradeoff.settings import METHODS, Setting, references
from gearbow.tradeoff.signals import Signal
from gearbow.tradeoff.trial import Skipped, Trial

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
        signals.check(self.reference.signals)
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
        return signals.error(run.signals, other.signals, self.exact.signals)

    def _trial(self, run: _Run[S]) -> Trial[S]:
        """Return the row of a run."""
        own, exact = self.own[run.model.name], self.exact
        return Trial(
            setting=str(run.setting),
            model=run.model.name,
            options={**run.setting.options, **run.model.options},
            system=run.model.system,
            method=run.setting.method,
            errors=signals.errors(run.signals, exact.signals, exact.signals),
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
            finer = (self.exact.model.name, signals.errors(self.reference.signals, exact, exact))
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
            speed_unit=self.system._speed_unit,
        )


def _system(model: Model[S], setting: Setting | None) -> S:
    """Return the system of a point."""
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
