"""Accuracy levels: the total error that they promise, and the tolerance that they use.

The total error is that of elements, modes and integration, RMS of the difference over RMS of the
signal about its mean, or over 2 % of the mean if this is larger (`unit_of_errors`).
`benches/accuracy/measure.py` measures it.
"""

import warnings
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol, cast

import numpy as np

from gearbow._core import SHARE_OF_MEAN, Model, accuracy_levels
from gearbow._types import Accuracy, Array
from gearbow.errors import AccuracyWarning, SceneError, outside
from gearbow.recording.record import Event

#: What happens at events after which an impact follows.
CHANGES_OF_CONTACT = {"separation": "flanks separated", "tight": "both flanks touched"}


class Reduction(Protocol):
    """Number of modes that runs keep, and the error of displacements and mesh forces."""

    @property
    def modes(self) -> int | None:
        """Number of modes."""

    @property
    def modes_error(self) -> tuple[float, float] | None:
        """Estimated errors."""


@dataclass(frozen=True)
class Level:
    """An accuracy level."""

    name: Accuracy
    rtol: float
    displacement: float
    mesh_force: float

    def explanation(self, events: Iterable[Event], coarse: str | None) -> str:
        """Say what the level promises for a run."""
        sentence = (
            f"{self.name}: total error at most {self.displacement:.0e} of the RMS about the mean "
            f"of displacements and {self.mesh_force:.0e} of mesh forces (where the RMS is below "
            f"{SHARE_OF_MEAN:.0%} of the mean, of this share), over the first 0.1 s or the time "
            "that damping needs to forget; afterwards the error applies to RMS values and "
            f"spectra; rtol {self.rtol:.0e}"
        )
        if coarse is not None:
            sentence += f"; this promise does not include the elements: {coarse}"
        kinds = {event.kind for event in events}
        contact = [text for kind, text in CHANGES_OF_CONTACT.items() if kind in kinds]
        if contact:
            sentence += (
                f"; {' and '.join(contact)} in this run, and impacts can amplify small "
                "differences: after chaotic contact the error holds neither for the time history "
                "nor for spectra (`errors` tells whether the contact is chaotic)"
            )
        return sentence

    def is_stricter(self, other: "Level") -> bool:
        """Tell whether this level permits smaller errors than another one."""
        return self.mesh_force < other.mesh_force

    def coarse(self, model: Model, speed: float | None) -> str | None:
        """Say why the elements of a system are too coarse for the level."""
        permitted = self.mesh_force if model.has_meshes else self.displacement
        expected = model.expected_error()
        if expected > permitted:
            reason = (
                "the shafts give their numbers"
                if model.choice is None
                else "they have the largest number of coordinates that gearbow chooses"
            )
        elif speed is not None and model.expected_error(speed) > permitted:
            expected = model.expected_error(speed)
            reason = f"the teeth excite natural frequencies at {speed:g} rad/s"
        else:
            return None
        return f"{reason}, and an expected error of {expected:.0e}"

    def finer(self, model: Model, accuracy: str) -> str:
        """Say how a system of an accuracy gets elements that are fine enough for the level."""
        if model.choice is None:
            return "leave out the numbers of elements"
        finer = [name for name in LEVELS if LEVELS[name].is_stricter(LEVELS[accuracy])]
        more = f"call system.replace(accuracy={finer[0]!r}), or " if finer else ""
        advice = "compare `response.errors()`, which often is below it"
        return f"{advice}, or {more}give the shafts elements"


#: Accuracy levels by name, from cheap to accurate; `src/scene/accuracy.rs` contains the numbers.
LEVELS = {
    name: Level(cast("Accuracy", name), **numbers) for name, numbers in accuracy_levels().items()
}
#: Accuracy of a system for which none is given.
DEFAULT: Accuracy = "engineering"


def find_level(name: object, accuracy: str, given: Mapping[str, Any]) -> Level | None:
    """Find the accuracy level of a run of a system with an accuracy, which a run may loosen."""
    other = next((option for option, value in given.items() if value is not None), None)
    if name is None:
        return LEVELS[accuracy] if other is None else None
    if not isinstance(name, str) or name not in LEVELS:
        raise SceneError(f"accuracy: must be one of {', '.join(LEVELS)}, got {name!r}")
    if other is not None:
        raise SceneError(f"accuracy: cannot be given together with {other}")
    if LEVELS[name].is_stricter(LEVELS[accuracy]):
        raise SceneError(
            f"accuracy: {name!r} is stricter than {accuracy!r}, the accuracy of the system, which "
            f"decides its elements; run system.replace(accuracy={name!r})"
        )
    return LEVELS[name]


def tolerance(options: Mapping[str, Any]) -> float | None:
    """Give the tolerance of a run: the given one, or that of its accuracy level."""
    accuracy = options["accuracy"]
    rtol: float | None = options["rtol"]
    return LEVELS[accuracy].rtol if rtol is None and accuracy is not None else rtol


def check_reduction(statistics: Reduction, level: Level, *, given: bool) -> None:
    """Warn if the error of a reduction to fewer modes exceeds an accuracy level."""
    if statistics.modes_error is None:
        return
    kinds = ("displacements", "mesh forces")
    permitted = (level.displacement, level.mesh_force)
    cure = (
        "keep more modes, or leave out modes"
        if given
        else "give rtol instead of accuracy, which keeps all modes, for example "
        f"rtol={level.rtol / 100:.0e}"
    )
    for kind, error, most in zip(kinds, statistics.modes_error, permitted, strict=True):
        if error > most:
            message = (
                f"{'modes' if given else 'accuracy'}: {statistics.modes} modes leave an error of "
                f"{error:.1e} in {kind}, above {most:.0e} of accuracy {level.name!r}; {cure}"
            )
            warnings.warn(message, AccuracyWarning, stacklevel=outside())


#: The unit in the words of tables and figures.
UNIT_OF_ERRORS = "RMS of the signal about its mean, at least 2 % of the mean"
#: A signal varies if its variation exceeds this fraction of its RMS: round-off varies less.
_VARIES = 1e-9


def unit_of_errors(values: Array) -> float:
    """Give the number by which the RMS of a difference is divided."""
    mean = float(np.linalg.norm(values.mean(axis=0)))
    return max(root_mean_square(values - values.mean(axis=0)), SHARE_OF_MEAN * mean)


def variation(values: Array) -> float:
    """Give the RMS of a signal about its mean; 0 if it is constant to round-off."""
    found = root_mean_square(values - values.mean(axis=0))
    return found if found > _VARIES * root_mean_square(values) else 0.0


def root_mean_square(values: Array) -> float:
    """Give the root mean square over time of the vector length."""
    return float(np.sqrt(np.mean(np.sum(values**2, axis=1))))
