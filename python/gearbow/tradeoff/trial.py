"""One setting of a study: what is known of it, as a row of a table."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from gearbow.tradeoff.models import GIVEN

if TYPE_CHECKING:
    from gearbow.system import RotorSystem

__all__ = ["Skipped", "Trial", "table"]

_TITLES = (
    "",
    "setting",
    "model",
    "error",
    "of integration",
    "of model",
    "CPU [s]",
    "set-up [s]",
    "per s [s/s]",
    "steps",
    "evaluations",
    "limited by",
)


@dataclass(frozen=True, eq=False)
class Trial:
    """One setting: how far it is from the reference, and what it takes.

    Parameters
    ----------
    setting : str
        Method, and step or tolerance.
    model : str
        "as given", or what is simplified.
    options : mapping
        Options of `simulate`.
    system : RotorSystem
        The system that was run.
    method : str
        Name of the method.
    errors : mapping of {str: float}
        Distance of each signal to the reference: RMS of the difference over the RMS of the swing.
    integration_error : float
        Distance to a tight run of the same model.
    model_error : float
        Distance of that to the reference: what the simplification alone changes.
    floor : float
        How well the reference is known; a smaller error says only that it is below.
    setup : float
        CPU time before the first step [s].
    stepping : float
        CPU time from there on [s].
    duration : float
        What was simulated in it [s].
    steps : int
        Accepted steps.
    evaluations : int
        Evaluations of the right-hand side.
    limited_by : str
        What set the length of most steps.
    repeats : int
        Of how many runs the times are medians.
    """

    setting: str
    model: str
    options: Mapping[str, Any]
    system: "RotorSystem" = field(repr=False)
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
        """Distance to the reference, of the signal that is worst.

        Returns
        -------
        float
            RMS of the difference over the RMS of the swing.
        """
        return max(self.errors.values())

    @property
    def bound(self) -> float:
        """What the error is at most, as far as the reference is known.

        Returns
        -------
        float
            The error, or the floor where that is larger.
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
            Time over time.
        """
        return self.stepping / self.duration

    def cost(self, duration: float | None = None) -> float:
        """CPU time of a run that is longer or shorter.

        Parameters
        ----------
        duration : float, optional
            Simulated time [s]; None is that of the study.

        Returns
        -------
        float
            Set-up and steps [s].
        """
        return self.seconds if duration is None else self.setup + self.rate * duration

    @property
    def error_text(self) -> str:
        """The error in words.

        Returns
        -------
        str
            A number, or "<" and the floor.
        """
        return _below(self.error, self.floor)

    def __str__(self) -> str:
        return _together(self.setting, self.model)


@dataclass(frozen=True)
class Skipped:
    """A setting of which nothing is known, and why.

    Parameters
    ----------
    setting : str
        Method, and step or tolerance.
    model : str
        "as given", or what is simplified.
    reason : str
        What would have been too slow, or went wrong.
    """

    setting: str
    model: str
    reason: str

    def __str__(self) -> str:
        return f"{_together(self.setting, self.model)}: {self.reason}"


def table(trials: Iterable[Trial], front: Sequence[Trial]) -> str:
    """Lay rows out as text.

    Parameters
    ----------
    trials : iterable of Trial
        The rows.
    front : sequence of Trial
        Those that get a star.

    Returns
    -------
    str
        One line for each, under a line of titles.
    """
    rows = [_TITLES]
    for trial in trials:
        simplified = trial.model != GIVEN
        rows.append(
            (
                "*" if trial in front else "",
                trial.setting,
                trial.model,
                trial.error_text,
                _below(trial.integration_error, trial.floor),
                _below(trial.model_error, trial.floor) if simplified else "–",
                f"{trial.seconds:.3g}",
                f"{trial.setup:.2g}",
                f"{trial.rate:.3g}",
                f"{trial.steps}",
                f"{trial.evaluations}",
                trial.limited_by,
            )
        )
    widths = [max(len(cell) for cell in column) for column in zip(*rows, strict=True)]
    words = {"setting", "model", "limited by"}
    return "\n".join(
        "  ".join(
            cell.ljust(width) if title in words else cell.rjust(width)
            for title, cell, width in zip(_TITLES, row, widths, strict=True)
        ).rstrip()
        for row in rows
    )


def _together(setting: str, model: str) -> str:
    return setting if model == GIVEN else f"{setting}, {model}"


def _below(error: float, floor: float) -> str:
    return f"{error:.1e}" if error > floor else f"<{floor:.1e}"
