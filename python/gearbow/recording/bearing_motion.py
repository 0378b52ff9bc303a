"""Force on a journal or rolling bearing, and the motion in it."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from gearbow._read_only import ReadOnly
from gearbow._types import Array, Plain
from gearbow.description.places import Places
from gearbow.errors import ChannelError


@dataclass(frozen=True, eq=False)
class BearingMotion(ReadOnly):
    """Force on a journal or rolling bearing, with the place of the journal or the load of elements.

    At an equilibrium the values are those of one instant, in a response those of its k times.

    Parameters
    ----------
    force : ndarray, shape (2,) or (k, 2)
        Force of the shaft on the bearing along y and z [N].
    eccentricity_ratio : float or ndarray, shape (k,), optional
        Displacement of the journal over the radial clearance; None for a rolling bearing.
    attitude_angle : float or ndarray, shape (k,), optional
        Angle from the force to the displacement, from y towards z [rad], between −π and π. In a
        steady film it has the sign of the rotation of the shaft. None for a rolling bearing.
    loaded_elements : ndarray, shape (k,), optional
        Number of rolling elements that carry load; None for a journal bearing.
    largest_contact_force : ndarray, shape (k,), optional
        Contact force of the most loaded rolling element [N]; None for a journal bearing.

    Examples
    --------
    >>> import gearbow as gb
    >>> size = {"diameter": 0.05, "length": 0.02, "clearance": 5e-5}
    >>> films = [gb.JournalBearing("rotor", x, viscosity=0.02, **size) for x in (0.0, 1.0)]
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05)
    >>> system = gb.RotorSystem([rotor], bearings=films, gravity=9.81)
    >>> print(f"{system.static(speed=300.0).journal(('rotor', 0.0)).eccentricity_ratio:.3f}")
    0.185
    >>> size = {"elements": 9, "element_diameter": 0.0127, "pitch_diameter": 0.065}
    >>> bearings = [
    ...     gb.RollingBearing("rotor", x, **size, clearance=1e-5, damping=100.0) for x in (0.0, 1.0)
    ... ]
    >>> run = system.replace(bearings=bearings).simulate(0.01, 300.0, record=["bearings"])
    >>> run.rolling(("rotor", 0.0)).loaded_elements.shape == run.time.shape
    True
    """

    force: Array
    eccentricity_ratio: Array | None = None
    attitude_angle: Array | None = None
    loaded_elements: Array | None = None
    largest_contact_force: Array | None = None


def journal_motion(
    bearings: Iterable[Mapping[str, Plain]],
    at: tuple[str, float],
    displacement: Array,
    force: Array,
) -> BearingMotion:
    """Find the motion of a journal from the displacement of the shaft relative to its bearing."""
    journals = [bearing for bearing in bearings if "viscosity" in bearing]
    known = Places("bearing", ([(each["shaft"], each["position"])] for each in journals))
    i = known.find(at)
    if i is None:
        raise ChannelError(f"no journal bearing at {at!r}; there are {known}")
    (y, z), (along_y, along_z) = np.moveaxis(displacement, -1, 0), np.moveaxis(force, -1, 0)
    return BearingMotion(
        force=force,
        eccentricity_ratio=np.hypot(y, z) / float(journals[i]["clearance"]),
        attitude_angle=np.arctan2(along_y * z - along_z * y, along_y * y + along_z * z),
    )
