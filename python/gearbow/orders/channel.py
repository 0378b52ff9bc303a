"""One recorded signal with its label and unit."""

from dataclasses import dataclass

from gearbow._shown import Shown
from gearbow._types import Array, Record
from gearbow.description.places import place, place_label
from gearbow.errors import ChannelError
from gearbow.recording.channels import BEARING, MESH, POINT
from gearbow.recording.recording import Recording

__all__ = ["Channel", "channel"]

#: Components of the force on a bearing.
_BEARING = {name.removeprefix("force_"): unit for name, unit in BEARING.items()} | {"x": "N"}


@dataclass(frozen=True, eq=False)
class Channel(Shown):
    """A signal over time.

    Parameters
    ----------
    label : str
        Name of the signal, e.g. "g1 v".
    unit : str
        Unit of the signal.
    values : ndarray, shape (k,)
        The signal.
    """

    label: str
    unit: str
    values: Array


def channel(recording: Recording, of: Record, quantity: str | None = None) -> Channel:
    """Find one recorded signal.

    Parameters
    ----------
    recording : Recording
        The recorded run.
    of : str or tuple
        A gear or disk, (shaft, position [m]), (driver, driven), ("bearing", shaft, position [m])
        or "energy".
    quantity : str, optional
        "v", "w", "twist" or "u" of a place, "y", "z" or "x" of the force on a bearing, or a
        field of `MeshResponse`. None is "v", "y" or the mesh force.

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
        values: Array
        name, component = _chosen(of, quantity, _BEARING)
        if name == "x":
            values = recording.axial_bearing_force(of[1], of[2])
        else:
            values = recording.bearing_force(of[1], of[2])[:, component]
        return Channel(f"bearing {of[1]} at {of[2]:g} m {name}", _BEARING[name], values)
    if of == "energy":
        _chosen(of, quantity, {"energy": "J"})
        return Channel("energy", "J", recording.energy)
    if isinstance(of, tuple) and isinstance(of[1], str):
        name, _ = _chosen(of, quantity, {"force": MESH["force"], **MESH})
        values = getattr(recording.mesh(of[0], of[1]), name)
        return Channel(f"{of[0]}/{of[1]} {name.replace('_', ' ')}", MESH[name], values)
    name, component = _chosen(of, quantity, POINT)
    at = of if isinstance(of, str) else (of[0], float(of[1]))
    single = {"twist": recording.twist, "u": recording.axial}
    motion = single[name](at) if name in single else recording.displacement(at)[:, component]
    return Channel(f"{place_label(at)} {name}", POINT[name], motion)


def _chosen(of: Record, quantity: str | None, known: dict[str, str]) -> tuple[str, int]:
    names = list(known)
    name = names[0] if quantity is None else quantity
    if name not in names:
        raise ChannelError(f"quantity: {of!r} has {', '.join(names)}, got {quantity!r}")
    return name, names.index(name)
