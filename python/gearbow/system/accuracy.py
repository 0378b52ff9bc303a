"""Accuracy levels: settings with a measured error.

``make measure`` compares each level with a verified reference on three scenes, and prints the table
in docs/tradeoff.md. The expected error of a level is the largest of the three, rounded up.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from gearbow.errors import SceneError
from gearbow.recording.record import Event

__all__ = ["ACCURACIES", "Accuracy", "accuracy_of"]

#: Scenes of the measurement.
SCENES = "a bowed shaft, a double-stage train and the same with seats of 2 mm"


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
    """

    word: str
    method: str
    rtol: float
    error: float

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
        Accuracy("draft", "exponential", 1e-3, 1e-2),
        Accuracy("engineering", "exponential", 1e-5, 1e-4),
        Accuracy("reference", "exponential", 1e-12, 1e-8),
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
