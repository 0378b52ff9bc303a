"""Result of a tradeoff study: rows, Pareto front and recommendation."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Generic

from gearbow._convert import positive, truth
from gearbow._extras import extra
from gearbow._result import Column, Result, WithSpeeds
from gearbow._shown import Shown
from gearbow.accuracy import UNIT_OF_ERRORS
from gearbow.analysis.protocol import S
from gearbow.errors import GearbowError
from gearbow.studies.settings import GIVEN

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
        RMS of the difference from the reference / RMS about its mean, at least 2 % of the mean.
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
    >>> system = gb.examples()["bowed_rotor"].load()
    >>> few = {"tolerances": [1e-3], "modes": [], "degrees": [], "elements": [], "repeats": 1}
    >>> tradeoff = system.tradeoff(0.02, 100.0, "disk", methods="exponential", **few)
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

        It is the RMS of the difference / RMS of the signal about its mean, at least 2 % of the
        mean.
        """
        return max(self.errors.values())

    @property
    def bound(self) -> float:
        """Upper bound of the error, at least the uncertainty of the reference."""
        return max(self.error, self.floor)

    @property
    def seconds(self) -> float:
        """CPU time of the whole run [s]."""
        return self.setup + self.stepping

    @property
    def rate(self) -> float:
        """CPU time of stepping per simulated second."""
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
        """The error as text: a number, or "<" and the floor if the error is smaller."""
        return _below(self.error, self.floor)

    def __str__(self) -> str:
        return _together(self.setting, self.model)


@dataclass(frozen=True)
class Skipped(Shown):
    """A setting that a study did not run or complete.

    Parameters
    ----------
    setting, model : str
        Names of the setting and of the model.
    reason : str
        Why it was skipped.

    Examples
    --------
    >>> import gearbow as gb
    >>> print(gb.results.Skipped("rk4", "full", "it is above the stability limit"))
    rk4, full: it is above the stability limit
    """

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


#: Error of the setting that a printed study recommends; that of mesh forces at "engineering".
_RECOMMENDED_ERROR = 1e-2


@dataclass(frozen=True)
class Recommendation(Shown, Generic[S]):
    """The cheapest setting with a given error: `system.simulate(duration, speed, **options)`.

    Parameters
    ----------
    options : dict
        Options of `simulate`.
    system : RotorSystem
        System to run: the given system or the simplified model of this setting.
    trial : Trial
        Error and CPU time of the setting.

    Examples
    --------
    >>> import gearbow as gb
    >>> system = gb.examples()["bowed_rotor"].load()
    >>> few = {"tolerances": [1e-3], "modes": [], "degrees": [], "elements": [], "repeats": 1}
    >>> tradeoff = system.tradeoff(0.02, 100.0, "disk", methods="exponential", **few)
    >>> tradeoff.recommend(error=1e-2).options["method"]
    'exponential'
    """

    options: dict[str, Any]
    system: S = field(repr=False)
    trial: Trial[S] = field(repr=False)

    @property
    def error(self) -> float:
        """Upper bound of the error, as `Trial.bound`."""
        return self.trial.bound

    def __str__(self) -> str:
        trial = self.trial
        return (
            f"{trial}: error {trial.error_text}, CPU time {trial.setup:.2g} s for the set-up "
            f"and {trial.rate:.2g} s per simulated second"
        )


@dataclass(frozen=True, eq=False)
class Tradeoff(WithSpeeds, Result, Generic[S]):
    """Error and CPU time of many settings; made by `gearbow.RotorSystem.tradeoff`.

    Parameters
    ----------
    trials : tuple of Trial
        The rows, the given system first, each from loose to tight settings.
    skipped : tuple of Skipped
        Settings that were not run or not completed.
    reference : str
        Setting of the reference run.
    check : str
        Setting of the independent run that verifies the reference.
    floor : float
        Difference of these two runs, at least round-off: the uncertainty of the reference.
    discretisation : tuple of (str, mapping of {str: float}), optional
        Name of a model with more elements, and the difference from it for each signal.
    duration : float
        Simulated time [s].
    speed : float
        Speed of the reference shaft [rad/s].
    signals : tuple of str
        Names of the compared signals.

    Examples
    --------
    >>> import gearbow as gb
    >>> system = gb.examples()["bowed_rotor"].load()
    >>> few = {"tolerances": [1e-3], "modes": [], "degrees": [], "elements": [], "repeats": 1}
    >>> tradeoff = system.tradeoff(0.02, 100.0, "disk", methods="exponential", **few)
    >>> tradeoff.trials[0].setting
    'exponential, rtol 1e-03'
    """

    trials: tuple[Trial[S], ...]
    skipped: tuple[Skipped, ...]
    reference: str
    check: str
    floor: float
    discretisation: tuple[str, Mapping[str, float]] | None
    duration: float
    speed: float
    signals: tuple[str, ...]

    def front(
        self, *, duration: float | None = None, simplified: bool = True
    ) -> tuple[Trial[S], ...]:
        """Return the Pareto front: no other setting is better in both error and CPU time.

        Parameters
        ----------
        duration : float, optional
            Simulated time of the compared runs [s]; None is the duration of the study.
        simplified : bool
            Whether to include simplified models.

        Returns
        -------
        tuple of Trial
            From the cheapest to the most accurate.
        """
        simplified = truth(simplified, "simplified")
        front: list[Trial[S]] = []
        ranked = sorted(self.trials, key=lambda trial: (trial.cost(duration), trial.bound))
        for trial in ranked:
            if (simplified or trial.model == GIVEN) and (
                not front or trial.bound < front[-1].bound
            ):
                front.append(trial)
        return tuple(front)

    def recommend(
        self, error: float = 1e-4, *, duration: float | None = None, simplified: bool = True
    ) -> Recommendation[S]:
        """Return the cheapest setting whose error is small enough.

        Parameters
        ----------
        error : float
            RMS of the difference / RMS of the signal about its mean, at least 2 % of the mean.
        duration : float, optional
            Simulated time of the compared runs [s]; None is the duration of the study.
        simplified : bool
            Whether to include simplified models.

        Returns
        -------
        Recommendation
            Options of `simulate` and the system to run.

        Raises
        ------
        GearbowError
            If no setting meets the error.
        """
        wanted = positive(error, "error")
        front = self.front(duration=duration, simplified=simplified)
        for trial in front:
            if trial.bound <= wanted:
                return Recommendation(dict(trial.options), trial.system, trial)
        best = front[-1]
        raise GearbowError(
            f"error: no setting of this study meets {wanted:g}; the most accurate is {best} with "
            f"{best.error_text}, the uncertainty of the reference is {self.floor:.1e}; give a "
            "larger error or a longer budget"
        )

    def plot(self, *, duration: float | None = None, ax: Any = None) -> "Figure":
        """Draw a work-precision diagram: CPU time against error, both on logarithmic axes.

        Parameters
        ----------
        duration : float, optional
            Simulated time of the compared runs [s]; None is the duration of the study.
        ax : Axes, optional
            Panel for the diagram; None makes a new figure.

        Returns
        -------
        matplotlib.figure.Figure
            A line for each method, open markers for simplified models, and the Pareto front.
        """
        with extra("plot"):
            from gearbow.plotting import analyses as figures  # noqa: PLC0415

        def _points(trials: Sequence[Trial[S]]) -> tuple[list[float], list[float]]:
            # A run below the uncertainty of the reference is drawn at this uncertainty.
            return [trial.bound for trial in trials], [trial.cost(duration) for trial in trials]

        given = [trial for trial in self.trials if trial.model == GIVEN]
        simpler = [trial for trial in self.trials if trial.model != GIVEN]
        methods = {
            method: _points([trial for trial in given if trial.method == method])
            for method in dict.fromkeys(trial.method for trial in given)
        }
        models = {}
        for model in dict.fromkeys(trial.model for trial in simpler):
            # The last run of a model is its reference run: it shows the model error, not the
            # saving.
            chosen = [trial for trial in simpler if trial.model == model]
            models[model] = _points(chosen[:-1] or chosen)
        return figures.work_precision(
            methods,
            models,
            _points(self.front(duration=duration)),
            floor=self.floor,
            worst=max(trial.bound for trial in self.trials),
            simulated=self.duration if duration is None else duration,
            ax=ax,
        )

    def _series(self) -> list[Column]:
        """Give all errors and CPU times of each setting; "seconds" is the whole run."""
        trials, front = self.trials, self.front()
        found: dict[str, list[Any]] = {
            "setting": [trial.setting for trial in trials],
            "model": [trial.model for trial in trials],
            "error": [trial.error for trial in trials],
            "integration error": [trial.integration_error for trial in trials],
            "model error": [trial.model_error for trial in trials],
        }
        names = [name for trial in trials[:1] for name in trial.errors if len(trial.errors) > 1]
        found |= {name: [trial.errors[name] for trial in trials] for name in names}
        found |= {
            "below floor": [trial.error <= trial.floor for trial in trials],
            "seconds": [trial.seconds for trial in trials],
            "set-up seconds": [trial.setup for trial in trials],
            "seconds per simulated second": [trial.rate for trial in trials],
            "steps": [trial.steps for trial in trials],
            "evaluations": [trial.evaluations for trial in trials],
            "limited by": [trial.limited_by for trial in trials],
            "front": [trial in front for trial in trials],
        }
        return [Column(name, values) for name, values in found.items()]

    def _columns(self) -> list[Column]:
        """Give a row for each setting; a star marks the Pareto front."""
        return columns(self.trials, self.front())

    def _heading(self) -> list[str]:
        worst = ", worst signal" if len(self.signals) > 1 else ""
        speed = self._speed_text(self.speed)
        lines = [
            f"{self.duration:g} s at {speed}; signals: {', '.join(self.signals)}",
            f"error: RMS of the difference / {UNIT_OF_ERRORS}{worst}",
            f"reference: {self.reference}; uncertainty {self.floor:.1e} (check: {self.check})",
        ]
        if self.discretisation is not None:
            model, errors = self.discretisation
            worst = f"{max(errors.values()):.1e}"
            lines.append(f"discretisation: the given model differs from {model} by {worst}")
        lines.append(
            "CPU times (medians): whole run, set-up before first step, steps per simulated second"
        )
        return [*lines, ""]

    def _remarks(self) -> list[str]:
        """Explain the star, list what was not run, and recommend a setting."""
        lines = ["", "* Pareto front: no other setting is faster and at least as accurate"]
        if self.skipped:
            lines += ["not run:", *(f"  {skipped}" for skipped in self.skipped)]
        try:
            found = self.recommend(_RECOMMENDED_ERROR)
            wanted = f"for an error of {_RECOMMENDED_ERROR:g}"
        except GearbowError:
            best = self.front()[-1]
            found, wanted = Recommendation(dict(best.options), best.system, best), "most accurate"
        return [*lines, f"recommended {wanted}: {found}"]

    def __repr__(self) -> str:
        return (
            f"Tradeoff({len(self.trials)} settings, {len(self.skipped)} skipped; "
            f"uncertainty of the reference {self.floor:.1e})"
        )
