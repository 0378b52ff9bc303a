"""One recorded signal, by what it belongs to and which quantity it is."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from gearbow._describe import place
from gearbow._types import Array, Record
from gearbow.errors import ChannelError

if TYPE_CHECKING:
    from gearbow.response import Response

__all__ = ["Channel", "channel"]

_POINT = {"v": "m", "w": "m", "twist": "rad"}
_BEARING = {"y": "N", "z": "N"}
_MESH = {
    "force": "N",
    "deflection": "m",
    "stiffness": "N/m",
    "pressure_angle": "rad",
    "centre_distance": "m",
    "centre_line_angle": "rad",
    "contact_ratio": "1",
    "pairs_in_contact": "1",
}


@dataclass(frozen=True, eq=False)
class Channel:
    """A signal over time.

    Parameters
    ----------
    label : str
        What it is, e.g. "g1 v".
    unit : str
        Its unit.
    values : ndarray, shape (k,)
        The signal.
    """

    label: str
    unit: str
    values: Array


def channel(response: "Response", of: Record, quantity: str | None = None) -> Channel:
    """Take one signal out of a response.

    Parameters
    ----------
    response : Response
        The response.
    of : str or tuple
        A gear or disk, (shaft, position [m]), (driver, driven), ("bearing", shaft, position [m])
        or "energy".
    quantity : str, optional
        "v", "w" or "twist" of a place, "y" or "z" of the force on a bearing, a field of
        `MeshResponse`; None is the first of these, or the force of a mesh.

    Returns
    -------
    Channel
        The signal.

    Raises
    ------
    ChannelError
        If it was not recorded, or there is no such quantity.
    """
    of = place(of, "of")
    if isinstance(of, tuple) and len(of) == 3:
        name, component = _chosen(of, quantity, _BEARING)
        force = response.bearing_force(of[1], of[2])
        return Channel(f"bearing {of[1]} at {of[2]:g} m {name}", "N", force[:, component])
    if of == "energy":
        _chosen(of, quantity, {"energy": "J"})
        return Channel("energy", "J", response.energy)
    if isinstance(of, tuple) and isinstance(of[1], str):
        name, _ = _chosen(of, quantity, _MESH)
        values: Array = getattr(response.mesh(of[0], of[1]), name)
        return Channel(f"{of[0]}/{of[1]} {name.replace('_', ' ')}", _MESH[name], values)
    name, component = _chosen(of, quantity, _POINT)
    at = of if isinstance(of, str) else (of[0], float(of[1]))
    label = at if isinstance(at, str) else f"{at[0]} at {at[1]:g} m"
    motion = response.twist(at) if name == "twist" else response.displacement(at)[:, component]
    return Channel(f"{label} {name}", _POINT[name], motion)


def _chosen(of: Record, quantity: str | None, known: dict[str, str]) -> tuple[str, int]:
    names = list(known)
    name = names[0] if quantity is None else quantity
    if name not in names:
        raise ChannelError(f"quantity: {of!r} has {', '.join(names)}, got {quantity!r}")
    return name, names.index(name)
