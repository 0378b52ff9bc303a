"""What a study found: the rows, the front of the best of them, and what to take."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from gearbow._convert import number
from gearbow.errors import GearbowError, SceneError
from gearbow.tradeoff.models import GIVEN
from gearbow.tradeoff.trial import Skipped, Trial, table

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from gearbow.system import RotorSystem

__all__ = ["Recommendation", "Tradeoff"]


@dataclass(frozen=True)
class Recommendation:
    """The cheapest setting that keeps an error: `system.simulate(duration, speed, **options)`.

    Parameters
    ----------
    options : dict
        Options of `simulate`.
    system : RotorSystem
        What to run: the system that was studied, or the simpler one of this setting.
    trial : Trial
        What is known of it.
    """

    options: dict[str, Any]
    system: "RotorSystem" = field(repr=False)
    trial: Trial = field(repr=False)

    @property
    def error(self) -> float:
        """What the error is at most, as far as the reference is known.

        Returns
        -------
        float
            RMS of the difference over the RMS of the swing.
        """
        return self.trial.bound

    def __str__(self) -> str:
        trial = self.trial
        return (
            f"{trial}: error {trial.error_text}, {trial.setup:.2g} s "
            f"and {trial.rate:.2g} s of CPU time per simulated second"
        )


@dataclass(frozen=True, eq=False)
class Tradeoff:
    """What accuracy costs in one run; made by `gearbow.RotorSystem.tradeoff`.

    Parameters
    ----------
    trials : tuple of Trial
        The rows, those of the system as given first, each from loose to tight.
    skipped : tuple of Skipped
        What was not run, or did not end.
    reference : str
        The setting that errors are measured against.
    check : str
        The independent setting that the reference was verified with.
    floor : float
        The distance of the two: how well the reference is known.
    discretisation : tuple of (str, mapping of {str: float}), optional
        A model with more elements, and how far the system as given is from it in each signal.
    duration : float
        Simulated time [s].
    speed : float
        Speed of the reference shaft [rad/s].
    of : tuple of str
        What was compared.
    """

    trials: tuple[Trial, ...]
    skipped: tuple[Skipped, ...]
    reference: str
    check: str
    floor: float
    discretisation: tuple[str, Mapping[str, float]] | None
    duration: float
    speed: float
    of: tuple[str, ...]

    def front(self, *, duration: float | None = None, simplified: bool = True) -> tuple[Trial, ...]:
        """Find the settings that none beats in both error and time.

        Parameters
        ----------
        duration : float, optional
            Simulated time that they are to be compared at [s]; None is that of the study.
        simplified : bool
            Whether simplified models are among them.

        Returns
        -------
        tuple of Trial
            From the cheapest to the most accurate.
        """
        duration = _duration(duration)
        front: list[Trial] = []
        ranked = sorted(self.trials, key=lambda trial: (trial.cost(duration), trial.bound))
        for trial in ranked:
            if (simplified or trial.model == GIVEN) and (
                not front or trial.bound < front[-1].bound
            ):
                front.append(trial)
        return tuple(front)

    def recommend(
        self, error: float = 1e-4, *, duration: float | None = None, simplified: bool = True
    ) -> Recommendation:
        """Name the cheapest setting that keeps an error.

        Parameters
        ----------
        error : float
            RMS of the difference over the RMS of the swing.
        duration : float, optional
            Simulated time that is to be cheap [s]; None is that of the study.
        simplified : bool
            Whether simplified models are among them.

        Returns
        -------
        Recommendation
            Options of `simulate`, and the system to run.

        Raises
        ------
        SceneError
            If the error is not a positive number.
        GearbowError
            If no setting is known to keep it.
        """
        wanted = number(error, "error")
        if not 0.0 < wanted < math.inf:
            raise SceneError(f"error: must be positive and finite, got {error!r}")
        front = self.front(duration=duration, simplified=simplified)
        for trial in front:
            if trial.bound <= wanted:
                return Recommendation(dict(trial.options), trial.system, trial)
        best = front[-1]
        raise GearbowError(
            f"error: no setting of this study is known to keep {wanted:g}; the best is "
            f"{best} with {best.error_text}, "
            f"the reference is known to {self.floor:.1e}"
        )

    def plot(self, *, duration: float | None = None) -> "Figure":
        """Draw time against error, both on logarithmic axes: a work-precision diagram.

        Parameters
        ----------
        duration : float, optional
            Simulated time that the CPU time is for [s]; None is that of the study.

        Returns
        -------
        matplotlib.figure.Figure
            The figure: a line for each method, open markers for simplified models, and the front.
        """
        from gearbow.tradeoff import figure  # noqa: PLC0415  # matplotlib is an extra

        return figure.work_precision(self, _duration(duration))

    def to_dataframe(self) -> "pd.DataFrame":
        """Give the rows as a table.

        Returns
        -------
        pandas.DataFrame
            One row for each setting; times are CPU time, "seconds" that of the whole run.
        """
        import pandas as pd  # noqa: PLC0415  # an extra

        front = self.front()
        rows = [
            {
                "setting": trial.setting,
                "model": trial.model,
                "error": trial.error,
                "integration error": trial.integration_error,
                "model error": trial.model_error,
                **(trial.errors if len(trial.errors) > 1 else {}),
                "below floor": trial.error <= trial.floor,
                "seconds": trial.seconds,
                "set-up seconds": trial.setup,
                "seconds per simulated second": trial.rate,
                "steps": trial.steps,
                "evaluations": trial.evaluations,
                "limited by": trial.limited_by,
                "front": trial in front,
            }
            for trial in self.trials
        ]
        table: pd.DataFrame = pd.DataFrame(rows)
        return table

    def table(self) -> str:
        """Lay the rows out as text.

        Returns
        -------
        str
            One line for each setting; a star marks the front.
        """
        return table(self.trials, self.front())

    def __str__(self) -> str:
        worst = ", of the worst" if len(self.of) > 1 else ""
        lines = [
            f"{self.duration:g} s at {self.speed:g} rad/s, by {', '.join(self.of)}",
            f"error: RMS of the difference over the RMS of the swing{worst}",
            f"reference: {self.reference}; known to {self.floor:.1e} by {self.check}",
        ]
        if self.discretisation is not None:
            model, errors = self.discretisation
            worst = f"{max(errors.values()):.1e}"
            lines.append(f"discretisation: as given, it is {worst} away from {model}")
        lines.append(
            "CPU: of the whole run, median; before its first step; of the steps, a simulated second"
        )
        lines += ["", self.table()]
        if self.skipped:
            lines += ["", "not run:", *(f"  {skipped}" for skipped in self.skipped)]
        return "\n".join(lines)

    def __repr__(self) -> str:
        return (
            f"Tradeoff({len(self.trials)} settings, {len(self.skipped)} skipped; "
            f"reference known to {self.floor:.1e})"
        )


def _duration(duration: float | None) -> float | None:
    if duration is None:
        return None
    value = number(duration, "duration")
    if not 0.0 < value < math.inf:
        raise SceneError(f"duration: must be positive and finite, got {duration!r}")
    return value
