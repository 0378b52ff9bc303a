"""Runs of a study: reference, check, settings and models, within a time budget."""

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Generic

from gearbow._types import Progress
from gearbow.analysis.protocol import S
from gearbow.errors import ContactError, GearbowError
from gearbow.results.response import Response
from gearbow.tradeoff.clock import Budget, Cost, TooSlowError, measure
from gearbow.tradeoff.models import GIVEN, Model, refined
from gearbow.tradeoff.plan import Plan
from gearbow.tradeoff.result import Tradeoff
from gearbow.tradeoff.settings import METHODS, Setting, references
from gearbow.tradeoff.signals import Signals
from gearbow.tradeoff.trial import Skipped, Trial

__all__ = ["carry_out"]

#: Relative rounding error of double precision.
ROUND_OFF = sys.float_info.epsilon
#: Fraction of the budget for the reference run, and the same for its check.
_FOR_REFERENCE = 0.3
#: Limit of one run divided by an equal share of the remaining budget.
_PATIENCE = 4.0
#: An integration error below this fraction of the model error needs no tighter setting.
_NEGLIGIBLE = 0.1


def carry_out(plan: Plan[S], budget: float, report: Progress) -> Tradeoff[S]:
    """Run all settings that the budget allows."""
    return _Study(plan, Budget(budget), report).result()


@dataclass(frozen=True, eq=False)
class _Run(Generic[S]):
    """A completed run with its CPU time."""

    model: Model[S]
    setting: Setting
    options: dict[str, Any]
    response: Response
    cost: Cost
    signals: Signals


class _Study(Generic[S]):
    def __init__(self, plan: Plan[S], budget: Budget, report: Progress) -> None:
        self.plan = plan
        self.budget = budget
        self.report = report
        self.given = Model(GIVEN, plan.system)
        self.for_reference = _FOR_REFERENCE * budget.left
        self.skipped: list[Skipped] = []
        self.jobs = 3 + len(plan.settings)
        self.jobs += sum(1 + len(plan.settings_of(model)) for model in plan.simpler)
        self.done = 0

    def result(self) -> Tradeoff[S]:
        reference = self.reference = self._reference()
        check = self.check = self._check()
        # Runs that agree to the last bit are still rounded: no error below that is known.
        self.floor = max(check.signals.error(reference.signals, reference.signals), ROUND_OFF)
        self.exact = self._exact()
        trials: list[Trial[S]] = []
        try:
            self._measure(trials)
        except KeyboardInterrupt as stop:
            stop.tradeoff = self._tradeoff(trials)  # type: ignore[attr-defined]
            raise
        self.report(1.0)
        return self._tradeoff(trials)

    def _measure(self, trials: list[Trial[S]]) -> None:
        """Run all settings and simplified models."""
        known = (self.reference.setting.options, self.check.setting.options)
        settings = [each for each in self.plan.settings if each.options not in known]
        try:
            for run in self._runs(self.given, settings):
                trials.append(self._trial(run, self.reference))
        finally:  # an interrupted study contains them too
            trials += [self._trial(run, self.reference) for run in (self.check, self.reference)]
        for model in self.plan.simpler:
            trials += self._simpler(model)

    def _tradeoff(self, trials: list[Trial[S]]) -> Tradeoff[S]:
        plan = self.plan
        order = [GIVEN, *(model.name for model in plan.simpler)]
        trials.sort(key=lambda trial: (order.index(trial.model), list(METHODS).index(trial.method)))
        return Tradeoff(
            trials=tuple(trials),
            skipped=tuple(self.skipped),
            reference=str(self.reference.setting),
            check=str(self.check.setting),
            floor=self.floor,
            discretisation=self._discretisation(),
            duration=plan.duration,
            speed=plan.speed,
            signals=tuple(str(signal) for signal in plan.wanted),
        )

    def _reference(self) -> _Run[S]:
        for setting in references(self.plan.system, self.plan.speed):
            run = self._run(self.given, setting, self.for_reference)
            if run is not None:
                run.signals.check()
                self._count()
                return run
        raise self._nothing("reference")

    def _check(self) -> _Run[S]:
        """Verify the reference by another method, or by the same method with another setting."""
        used = self.reference.setting
        candidates = references(self.plan.system, self.plan.speed)
        others = [setting for setting in candidates if setting.method != used.method]
        same = [setting for setting in candidates if setting.method == used.method]
        for setting in (*others, used.halved(), *same[same.index(used) + 1 :]):
            run = self._run(self.given, setting, self.for_reference)
            if run is not None:
                self._count()
                return run
        raise self._nothing("check of the reference")

    def _exact(self) -> _Run[S]:
        """Run finer elements, from which total errors count."""
        degrees = self.plan.degrees
        run = self._tight(refined(self.plan.system, degrees)) if degrees else None
        self._count()
        return run or self.reference

    def _discretisation(self) -> tuple[str, dict[str, float]] | None:
        """Give the error of the given elements; None if the budget has no finer elements."""
        if self.exact is self.reference:
            return None
        exact = self.exact.signals
        return self.exact.model.name, self.reference.signals.errors(exact, exact)

    def _tight(self, model: Model[S]) -> _Run[S] | None:
        """Run another model with the reference setting, or with a similar one within the budget."""
        tried = len(self.skipped)
        used = self.reference.setting
        others = references(model.system, self.plan.speed)
        same = [setting for setting in others if setting.method == used.method]
        for setting in dict.fromkeys((used, *same, *others)):
            if model.methods is None or setting.method in model.methods:
                run = self._run(model, setting, _PATIENCE * self._share())
                if run is not None:
                    del self.skipped[tried:]
                    return run
        del self.skipped[tried + 1 :]
        return None

    def _simpler(self, model: Model[S]) -> Iterator[Trial[S]]:
        """Measure the model error of a simplification, then the CPU time of its settings."""
        settings = self.plan.settings_of(model)
        own = self._tight(model)
        self._count()
        if own is None:
            self._count(len(settings))
            return
        tight = self._trial(own, own)
        for rung, run in enumerate(self._runs(model, settings)):
            trial = self._trial(run, own)
            yield trial
            if trial.integration_error < _NEGLIGIBLE * trial.model_error:
                # A tighter setting costs more and does not reduce the total error.
                self._count(len(settings) - 1 - rung)
                break
        yield tight

    def _runs(self, model: Model[S], settings: Sequence[Setting]) -> Iterator[_Run[S]]:
        for setting in settings:
            share = self._share()
            run = self._run(model, setting, _PATIENCE * share, share)
            self._count()
            if run is not None:
                yield run

    def _share(self) -> float:
        """Return the remaining budget per remaining run."""
        return self.budget.left / max(1, self.jobs - self.done)

    def _run(
        self, model: Model[S], setting: Setting, allowance: float, share: float = 0.0
    ) -> _Run[S] | None:
        """Run one setting, or record why it was skipped."""
        plan = self.plan
        options = {**setting.options, **model.options}
        left = self.budget.left
        try:
            if left == 0.0:
                raise TooSlowError
            response, cost = measure(
                model.system,
                plan.duration,
                plan.speed,
                {**plan.common(), **options},
                allowance=min(allowance, left),
                share=share,
                repeats=plan.repeats,
            )
        except ContactError:
            raise  # the error is independent of the setting
        except TooSlowError as error:
            reason = str(error)
        except GearbowError as error:
            reason = str(error)
        else:
            return _Run(model, setting, options, response, cost, Signals(plan.wanted, response))
        self.skipped.append(Skipped(str(setting), model.name, reason))
        return None

    def _count(self, jobs: int = 1) -> None:
        self.done += jobs
        self.report(min(1.0, self.done / self.jobs))

    def _trial(self, run: _Run[S], own: _Run[S]) -> Trial[S]:
        """Return the row of a run; `own` is the reference run of the same model."""
        reference = self.exact.signals
        statistics = run.response.statistics
        errors = run.signals.errors(reference, reference)
        return Trial(
            setting=str(run.setting),
            model=run.model.name,
            options=run.options,
            system=run.model.system,
            method=run.setting.method,
            errors=errors,
            integration_error=run.signals.error(own.signals, reference),
            model_error=own.signals.error(reference, reference),
            floor=self.floor,
            setup=run.cost.setup,
            stepping=run.cost.stepping,
            duration=self.plan.duration,
            steps=statistics.steps,
            evaluations=statistics.evaluations,
            limited_by=statistics.limited_by,
            repeats=run.cost.repeats,
        )

    def _nothing(self, what: str) -> GearbowError:
        tried = "; ".join(str(skipped) for skipped in self.skipped)
        return GearbowError(f"budget: too short for a {what} ({tried})")
