"""Accuracy levels: the total error that they promise, and the tolerance that they use.

The total error is that of elements, modes and integration, RMS of the difference over RMS of the
signal about its mean, or over 2 % of the mean if this is larger (`scale`).
`benches/accuracy/measure.py` measures it.
"""

import warnings
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from gearbow._core import Model
from gearbow.accuracy.scale import SHARE_OF_MEAN
from gearbow.errors import AccuracyWarning, SceneError, outside
from gearbow.recording.record import Event, Statistics

__all__ = ["DEFAULT", "LEVELS", "Level", "check_reduction", "find_level"]


#: Share of the total error that a reduction to fewer modes may use.
REDUCTION_SHARE = 1.0 / 3.0
#: What happens at events after which an impact follows.
CHANGES_OF_CONTACT = {"separation": "flanks separated", "tight": "both flanks touched"}


@dataclass(frozen=True)
class Level:
    """An accuracy level."""

    name: str
    rtol: float
    displacement: float
    mesh_force: float

    @property
    def reduction(self) -> tuple[float, float] | None:
        """Give the largest errors from a reduction to fewer modes."""
        if self.name == "reference":
            return None
        return REDUCTION_SHARE * self.displacement, REDUCTION_SHARE * self.mesh_force

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

    def coarse(self, model: Model, speed: float | None) -> str | None:
        """Say why the elements of a system are too coarse for the level."""
        permitted = self.mesh_force if model.has_meshes else self.displacement
        expected = model.expected_error()
        if model.choice is not None:
            resolution = LEVELS[model.choice[0]]
            reason = f"they have the resolution {resolution.name!r}"
            is_finer = resolution.mesh_force <= self.mesh_force
            if is_finer:
                reason += " with the largest number of coordinates that gearbow chooses"
        else:
            reason, is_finer = "the shafts give their numbers", True
        if is_finer and expected <= permitted:
            expected = expected if speed is None else model.expected_error(speed)
            if expected <= permitted:
                return None
            reason = f"the teeth excite natural frequencies at {speed:g} rad/s"
        return f"{reason}, and an expected error of {expected:.0e}"

    def finer(self, model: Model) -> str:
        """Say how to get elements that are fine enough for the level."""
        if model.choice is not None and LEVELS[model.choice[0]].mesh_force <= self.mesh_force:
            finer = [name for name in LEVELS if LEVELS[name].mesh_force < self.mesh_force]
            more = f"resolution={finer[0]!r} to RotorSystem, or " if finer else ""
            advice = "compare `response.errors()`, which often is below it"
            return f"{advice}, or give {more}the shafts elements"
        return (
            f"leave out the numbers of elements, and give resolution={self.name!r} to RotorSystem"
        )


#: Accuracy levels by name, from cheap to accurate.
LEVELS = {
    each.name: each
    for each in (
        Level("draft", 1e-3, displacement=1e-2, mesh_force=1e-1),
        Level("engineering", 1e-4, displacement=1e-3, mesh_force=1e-2),
        Level("reference", 1e-7, displacement=1e-6, mesh_force=1e-4),
    )
}
#: Level of a run without other settings.
DEFAULT = "engineering"


def find_level(name: object, given: Mapping[str, Any]) -> Level | None:
    """Find the accuracy level of a run."""
    other = next((option for option, value in given.items() if value is not None), None)
    if name is None:
        return LEVELS[DEFAULT] if other is None else None
    if not isinstance(name, str) or name not in LEVELS:
        raise SceneError(f"accuracy: must be one of {', '.join(LEVELS)}, got {name!r}")
    if other is not None:
        raise SceneError(f"accuracy: cannot be given together with {other}")
    return LEVELS[name]


def check_reduction(statistics: Statistics, level: Level | None, *, given: bool) -> None:
    """Warn if the error of a reduction to fewer modes exceeds an accuracy level."""
    if statistics.modes_error is None:
        return
    level = level or LEVELS[DEFAULT]
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
