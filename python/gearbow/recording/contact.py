"""Contact of the flanks of a mesh over a recorded run, from its events."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from gearbow._core import mesh_geometry
from gearbow._shown import Shown
from gearbow._types import Array
from gearbow.description.gears import Gear
from gearbow.recording.record import Event, RunRequest


class Contact(IntEnum):
    """Flanks of a mesh that are in contact.

    NONE is 0, DRIVE 1, BACK 2 and BOTH 3. The drive flanks push the driven gear in its direction of
    rotation, the back flanks against it. Both are in contact where the displacements of the shafts
    reduce the centre distance by more than the backlash allows.

    Examples
    --------
    >>> import gearbow as gb
    >>> gb.results.Contact(2)
    <Contact.BACK: 2>
    """

    NONE = 0
    DRIVE = 1
    BACK = 2
    BOTH = 3


#: Contact after each kind of event that changes it.
_AFTER = {
    "contact": Contact.DRIVE,
    "back contact": Contact.BACK,
    "separation": Contact.NONE,
    "tight": Contact.BOTH,
}


@dataclass(frozen=True)
class ContactShares(Shown):
    """Shares of the time in each state of contact of a mesh; their sum is 1.

    Parameters
    ----------
    drive : float
        Share with contact of the drive flanks only.
    back : float
        Share with contact of the back flanks only.
    both : float
        Share with contact of both flanks.
    none : float
        Share without contact.

    Examples
    --------
    >>> import gearbow as gb
    >>> shares = gb.results.ContactShares(drive=0.9, back=0.02, both=0.0, none=0.08)
    >>> print(f"{shares.lost:.2f}")
    0.10
    """

    drive: float
    back: float
    both: float
    none: float

    @property
    def lost(self) -> float:
        """Share of the time without contact of the drive flanks.

        Returns
        -------
        float
            Sum of `back` and `none`.
        """
        return self.back + self.none


def contact_at(times: Array, events: Sequence[Event], first: Contact) -> NDArray[np.int8]:
    """Find the contact of a mesh at given times."""
    changes, states = _changes(events)
    after = np.array([first, *states], dtype=np.int8)
    return after[np.searchsorted(changes, times, side="right")]


def shares(begin: float, end: float, events: Sequence[Event], first: Contact) -> ContactShares:
    """Find the share of each state of contact between two times."""
    changes, _ = _changes(events)
    bounds = np.concatenate([[begin], changes[(changes > begin) & (changes < end)], [end]])
    lengths = np.diff(bounds)
    weights = lengths / (end - begin) if end > begin else np.ones(1)
    found = contact_at(bounds[:-1], events, first)
    total = np.bincount(found, weights=weights, minlength=len(Contact))
    return ContactShares(
        **{name: float(total[Contact[name.upper()]]) for name in ("drive", "back", "both", "none")}
    )


def first_contact(
    time: Array, mesh: Mapping[str, Array], events: Sequence[Event], scene: "MeshScene | None"
) -> Contact:
    """Find the contact before the first change, which no event tells."""
    changes, _ = _changes(events)
    before = int(np.searchsorted(time, changes[0])) if changes.size else time.size
    if before == 0 or (scene is not None and scene.backlash is None):
        return Contact.DRIVE
    at = {name: float(values[before - 1]) for name, values in mesh.items()}
    if at["stiffness"] == 0.0:
        return Contact.NONE
    if scene is None:
        return Contact.DRIVE if at["force"] >= 0.0 else Contact.BACK
    if scene.back_deflection(at) > 0.0:
        return Contact.BOTH if at["deflection"] > 0.0 else Contact.BACK
    return Contact.DRIVE


@dataclass(frozen=True)
class MeshScene(Shown):
    """Backlash of a mesh, and what lets it change with the centre distance."""

    backlash: float | None
    centre_distance: float
    pressure_angle: float
    base_helix_cosine: float
    frozen: bool

    @classmethod
    def of(cls, request: RunRequest, driver: str, driven: str) -> "MeshScene":
        """Take the data of one mesh from the scene of a run."""
        plain = {entry["name"]: entry for entry in request.description["gears"]}
        gear: Gear = Gear._from_description(plain[driver])
        pairs = [(entry["driver"], entry["driven"]) for entry in request.description["meshes"]]
        index = pairs.index((driver, driven))
        at_rest = mesh_geometry(request.description)[index]
        return cls(
            request.description["meshes"][index].get("backlash"),
            at_rest["centre_distance"],
            at_rest["pressure_angle"],
            math.sqrt(1.0 - (math.sin(gear.helix_angle) * math.cos(gear.pressure_angle)) ** 2),
            request.options.get("geometry") == "frozen",
        )

    def back_deflection(self, at: Mapping[str, float]) -> float:
        """Find the deflection of the back flanks, positive in contact."""
        distance, angle, rest = at["centre_distance"], at["pressure_angle"], self.pressure_angle
        if self.frozen:
            longer = math.sin(rest) * (distance - self.centre_distance)
        else:
            involute = math.tan(angle) - angle - math.tan(rest) + rest
            longer = distance * math.cos(angle) * involute
        return -at["deflection"] - (self.backlash or 0.0) - 2.0 * longer * self.base_helix_cosine


def _changes(events: Sequence[Event]) -> tuple[Array, list[Contact]]:
    """Give the times at which the contact changes, and the contact after each."""
    changes = [event for event in events if event.kind in _AFTER]
    changes.sort(key=lambda event: event.time)
    return np.array([event.time for event in changes]), [_AFTER[each.kind] for each in changes]
