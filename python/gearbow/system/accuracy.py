"""Accuracy levels: settings with a measured error.

``make measure`` compares each level with a verified reference on three scenes, and prints the table
in docs/tradeoff.md. The expected error of a level is the largest of the three, rounded up.
"""

import warnings
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from gearbow.errors import AccuracyWarning, SceneError
from gearbow.recording.record import Event, Statistics

__all__ = ["ACCURACIES", "Accuracy", "accuracy_of", "check_reduction"]

#: Scenes of the measurement.
SCENES = "a bowed shaft, a double-stage train and the same with seats of 2 mm"
#: Share of the total error that a reduction to fewer modes may use.
REDUCTION_SHARE = 1.0 / 3.0


@dataclass(frozen=True)
class Accuracy:
    """An accuracy level.

    Parameters
    ----------
    word : str
        Name of the level.
    method : str
        Integration method.
    rtol : float
        Tolerance of the method.
    error : float
        Expected error: RMS of the error / RMS of the signal about its mean, for the worst gear
        displacement or mesh force.
    total : tuple of float
        Largest total error of displacements and of mesh forces, in the same measure.
    """

    word: str
    method: str
    rtol: float
    error: float
    total: tuple[float, float]

    @property
    def reduction(self) -> tuple[float, float] | None:
        """Give the largest errors from a reduction to fewer modes.

        Returns
        -------
        tuple of float, optional
            Errors of displacements and of mesh forces; None keeps all modes.
        """
        if self.word == "reference":
            return None
        displacement, mesh_force = self.total
        return REDUCTION_SHARE * displacement, REDUCTION_SHARE * mesh_force

    def explanation(self, events: Iterable[Event]) -> str:
        """Explain the expected error of a run.

        Parameters
        ----------
        events : iterable of Event
            Events of the run.

        Returns
        -------
        str
            Settings, expected error, and the scenes of the measurement.
        """
        sentence = (
            f"{self.word}: {self.method}, rtol {self.rtol:.0e}; error at most {self.error:.0e} of "
            f"the RMS about the mean of gear displacements and mesh forces, measured on {SCENES} "
            "by `make measure`"
        )
        if any(event.kind == "separation" for event in events):
            sentence += (
                "; flanks separated in this run, and every impact amplifies small differences: the "
                "expected error holds for the first impacts only, statistics of the motion hold "
                "for longer"
            )
        return sentence


#: Accuracy levels by name, from cheap to accurate.
ACCURACIES = {
    each.word: each
    for each in (
        Accuracy("draft", "exponential", 1e-3, 1e-2, (1e-2, 1e-1)),
        Accuracy("engineering", "exponential", 1e-5, 1e-4, (1e-3, 1e-2)),
        Accuracy("reference", "exponential", 1e-12, 1e-8, (1e-6, 1e-4)),
    )
}


def accuracy_of(word: object, given: Mapping[str, Any], *, constant: bool = True) -> Accuracy:
    """Find an accuracy level.

    Parameters
    ----------
    word : str
        Name of the level.
    given : mapping
        Other options that determine the accuracy; None if not given.
    constant : bool
        Whether the speed is constant.

    Returns
    -------
    Accuracy
        Settings and expected error.

    Raises
    ------
    SceneError
        If the level is unknown, another option determines the accuracy, or the speed changes.
    """
    if not isinstance(word, str) or word not in ACCURACIES:
        raise SceneError(f"accuracy: must be one of {', '.join(ACCURACIES)}, got {word!r}")
    for name, value in given.items():
        if value is not None:
            raise SceneError(f"accuracy: cannot be given together with {name}")
    if not constant:
        raise SceneError("accuracy: is known at constant speed only; give method and rtol instead")
    return ACCURACIES[word]


def check_reduction(statistics: Statistics, level: Accuracy | None) -> None:
    """Warn if the error of a reduction to a given number of modes exceeds an accuracy level.

    Parameters
    ----------
    statistics : Statistics
        Statistics of the run.
    level : Accuracy, optional
        Accuracy level of the run; None is "engineering".

    Warns
    -----
    AccuracyWarning
        If the error of displacements or of mesh forces is above the level.
    """
    if statistics.modes_error is None:
        return
    level = level or ACCURACIES["engineering"]
    kinds = ("displacements", "mesh forces")
    for kind, error, most in zip(kinds, statistics.modes_error, level.total, strict=True):
        if error > most:
            message = (
                f"modes: {statistics.modes} modes leave an error of {error:.1e} in {kind}, above "
                f"{most:.0e} of accuracy {level.word!r}; keep more modes, or leave out modes"
            )
            warnings.warn(message, AccuracyWarning, stacklevel=3)
