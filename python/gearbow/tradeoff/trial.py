"""One setting of a study as a row of a table."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Generic

from gearbow._convert import positive
from gearbow._result import Column
from gearbow._shown import Shown
from gearbow.analysis.protocol import S
from gearbow.tradeoff.models import GIVEN


@dataclass(frozen=True, eq=False)
class Trial(Shown, Generic[S]):
    """Error and CPU time of one setting.

    Parameters
    ----------
    setting : str
        Method, and step or tolerance.
    model : str
        "as given" or the simplification.
    options : mapping
        Options of `simulate`.
    system : RotorSystem
        The system that was run.
    method : str
        Name of the method.
    errors : mapping of {str: float}
        Error of each signal: RMS of the difference from the reference / RMS of the reference
        about its mean, at least 2 % of its mean.
    integration_error : float
        Difference from the reference run of the same model.
    model_error : float
        Difference of that run from the reference: the effect of the simplification alone.
    floor : float
        Uncertainty of the reference; smaller errors are not resolved.
    setup : float
        CPU time before the first step [s].
    stepping : float
        CPU time of all steps [s].
    duration : float
        Simulated time [s].
    steps : int
        Accepted steps.
    evaluations : int
        Evaluations of the right-hand side.
    limited_by : str
        What limited the length of most steps.
    repeats : int
        Number of runs of which the CPU times are medians.

    Examples
    --------
    >>> import gearbow as gb
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=4,
    ...                  bow=gb.Bow.half_sine(1e-4))
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e8) for x in (0.0, 1.0)]
    >>> system = gb.RotorSystem([rotor], bearings=bearings)
    >>> options = {"tolerances": [1e-3], "modes": [], "degrees": [], "elements": [], "repeats": 1}
    >>> options |= {"methods": "exponential", "frozen": False, "mean_stiffness": False}
    >>> tradeoff = system.tradeoff(0.02, 100.0, ("rotor", 0.5), initial="rest", **options)
    >>> trial = tradeoff.trials[0]
    >>> trial.method, trial.steps > 0
    ('exponential', True)
    """

    setting: str
    model: str
    options: Mapping[str, Any]
    system: S = field(repr=False)
    method: str
    errors: Mapping[str, float]
    integration_error: float
    model_error: float
    floor: float
    setup: float
    stepping: float
    duration: float
    steps: int
    evaluations: int
    limited_by: str
    repeats: int

    @property
    def error(self) -> float:
        """Error of the worst signal.

        Returns
        -------
        float
            RMS of the difference / RMS of the signal about its mean, at least 2 % of the mean.
        """
        return max(self.errors.values())

    @property
    def bound(self) -> float:
        """Upper bound of the error, at least the uncertainty of the reference.

        Returns
        -------
        float
            The larger of error and floor.
        """
        return max(self.error, self.floor)

    @property
    def seconds(self) -> float:
        """CPU time of the whole run.

        Returns
        -------
        float
            Time [s].
        """
        return self.setup + self.stepping

    @property
    def rate(self) -> float:
        """CPU time of stepping per simulated second.

        Returns
        -------
        float
            CPU time / simulated time.
        """
        return self.stepping / self.duration

    def cost(self, duration: float | None = None) -> float:
        """CPU time of a run of another duration.

        Parameters
        ----------
        duration : float, optional
            Simulated time [s]; None is the duration of the study.

        Returns
        -------
        float
            CPU time of set-up and steps [s].
        """
        if duration is None:
            return self.seconds
        return self.setup + self.rate * positive(duration, "duration")

    @property
    def error_text(self) -> str:
        """The error as text.

        Returns
        -------
        str
            A number, or "<" and the floor if the error is smaller.
        """
        return _below(self.error, self.floor)

    def __str__(self) -> str:
        return _together(self.setting, self.model)


@dataclass(frozen=True)
class Skipped(Shown):
    """A skipped setting."""

    setting: str
    model: str
    reason: str

    def __str__(self) -> str:
        return f"{_together(self.setting, self.model)}: {self.reason}"


def columns(trials: Sequence[Trial[S]], front: Sequence[Trial[S]]) -> list[Column]:
    """Give the columns of a table of settings, with a star for those of the Pareto front."""

    def bounded(name: str) -> list[str]:
        return [_below(getattr(trial, name), trial.floor) for trial in trials]

    model_errors = zip(trials, bounded("model_error"), strict=True)
    return [
        Column("", ["*" if trial in front else "" for trial in trials]),
        Column("setting", [trial.setting for trial in trials]),
        Column("model", [trial.model for trial in trials]),
        Column("error", [trial.error_text for trial in trials]),
        Column("integration error", bounded("integration_error")),
        Column("model error", ["–" if t.model == GIVEN else text for t, text in model_errors]),
        Column("CPU", [trial.seconds for trial in trials], "s", ".3g"),
        Column("set-up", [trial.setup for trial in trials], "s", ".2g"),
        Column("CPU per s", [trial.rate for trial in trials], "s/s", ".3g"),
        Column("steps", [trial.steps for trial in trials]),
        Column("evaluations", [trial.evaluations for trial in trials]),
        Column("limited by", [trial.limited_by for trial in trials]),
    ]


def _together(setting: str, model: str) -> str:
    return setting if model == GIVEN else f"{setting}, {model}"


def _below(error: float, floor: float) -> str:
    return f"{error:.1e}" if error > floor else f"<{floor:.1e}"
