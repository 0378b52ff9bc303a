"""How accurate a run shall be, in one word, and what is known of the settings that stand for it.

The numbers are measured: ``make measure`` runs each word on three scenes against a verified
reference and prints the table that stands in docs/tradeoff.md. The error expected of a word is the
largest of them, rounded up.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from gearbow.errors import SceneError
from gearbow.response import Response

__all__ = ["ACCURACIES", "Accuracy", "accuracy_of"]

#: What the errors were measured on.
SCENES = "a bowed shaft, a double-stage train and the same with seats of 2 mm"


@dataclass(frozen=True)
class Accuracy:
    """A word for how accurate a run shall be.

    Parameters
    ----------
    word : str
        The word that `simulate` takes.
    method : str
        The method that it stands for.
    rtol : float
        The tolerance of that.
    error : float
        What to expect: RMS of the error over the RMS of the swing, of the worst gear or mesh force.
    """

    word: str
    method: str
    rtol: float
    error: float

    def explain(self, response: Response) -> None:
        """Write into a response what error to expect of it, and why.

        Parameters
        ----------
        response : Response
            A run with these options.
        """
        sentence = (
            f"{self.word}: {self.method}, rtol {self.rtol:.0e}; at most {self.error:.0e} of the "
            f"swing of gears and mesh forces, measured on {SCENES} by `make measure`"
        )
        if any(event.kind == "separation" for event in response.events):
            sentence += (
                "; flanks parted in this run, and small differences grow with every impact: "
                "the error is that of the first few, statistics of the motion hold for longer"
            )
        response.expected_error = self.error
        response.accuracy = sentence


#: The words, from cheap to accurate.
ACCURACIES = {
    each.word: each
    for each in (
        Accuracy("draft", "exponential", 1e-3, 1e-2),
        Accuracy("engineering", "exponential", 1e-5, 1e-4),
        Accuracy("reference", "exponential", 1e-12, 1e-8),
    )
}


def accuracy_of(word: object, given: Mapping[str, Any], *, constant: bool = True) -> Accuracy:
    """Find what a word stands for.

    Parameters
    ----------
    word : str
        The word.
    given : mapping
        Options that say the same in other terms, None where they were left out.
    constant : bool
        Whether the speed stays the same.

    Returns
    -------
    Accuracy
        Its setting and its error.

    Raises
    ------
    SceneError
        If there is no such word, one of the options was given beside it, or the speed changes.
    """
    if not isinstance(word, str) or word not in ACCURACIES:
        raise SceneError(f"accuracy: must be one of {', '.join(ACCURACIES)}, got {word!r}")
    for name, value in given.items():
        if value is not None:
            raise SceneError(f"accuracy: cannot be given together with {name}")
    if not constant:
        raise SceneError("accuracy: known at constant speed only; give method and rtol instead")
    return ACCURACIES[word]
