"""One recorded signal with its label and unit."""

from dataclasses import dataclass
from typing import Any

from gearbow._convert import text
from gearbow._shown import Shown
from gearbow._types import Array, Record
from gearbow.description.places import is_pair, place, place_label
from gearbow.errors import ChannelError
from gearbow.recording import access
from gearbow.recording.channels import BEARING, MESH, POINT, RATES
from gearbow.recording.record import RunRecord
from gearbow.sensors.sensor import SignalSensor

__all__ = ["Channel", "channel"]

#: Components of the force on a bearing.
_BEARING = {name.removeprefix("force_"): unit for name, unit in BEARING.items()} | {"x": "N"}


@dataclass(frozen=True, eq=False)
class Channel(Shown):
    """A signal over time."""

    label: str
    unit: str
    values: Array


#: Quantities of the motion of a place: array and component.
_MOTION: dict[str, tuple[Any, int | None]] = {
    "y": ("displacement", 0),
    "z": ("displacement", 1),
    "twist": ("twist", None),
    "x": ("axial", None),
    **{
        quantity: (array, component if len(quantities) > 1 else None)
        for array, quantities in RATES.items()
        for component, quantity in enumerate(quantities)
    },
}


def channel(run: RunRecord, at: Record | SignalSensor, quantity: str | None = None) -> Channel:
    """Find one recorded signal."""
    if isinstance(at, SignalSensor):
        if quantity is not None:
            raise ChannelError(f"quantity: a sensor has one signal; leave out {quantity!r}")
        return Channel(at.label, at.unit, at.measure(run))
    item: Any = place(at)
    if isinstance(item, tuple) and len(item) == 3:
        return _of_bearing(run, item, quantity)
    if item == "energy":
        _chosen(item, quantity, {"energy": "J"})
        return Channel("energy", "J", access.energy(run))
    if is_pair(item):
        name, _ = _chosen(item, quantity, {"force": MESH["force"], **MESH})
        values = getattr(access.mesh(run, item), name)
        driver, driven = access.mesh_names(run, item)
        return Channel(f"{driver}/{driven} {name.replace('_', ' ')}", MESH[name], values)
    name, _ = _chosen(item, quantity, POINT)
    array, component = _MOTION[name]
    motion = access.motion(run, array, item)
    values = motion if component is None else motion[:, component]
    return Channel(f"{place_label(item)} {name}", POINT[name], values)


def _of_bearing(run: RunRecord, item: tuple[str, str, float], quantity: str | None) -> Channel:
    """Find a component of the force on a bearing, ("bearing", shaft, position)."""
    _, shaft, position = item
    name, component = _chosen(item, quantity, _BEARING)
    if name == "x":
        values = access.axial_bearing_force(run, (shaft, position))
    else:
        values = access.bearing_force(run, (shaft, position))[:, component]
    return Channel(f"bearing {shaft} at {position:g} m {name}", _BEARING[name], values)


def _chosen(at: Record, quantity: str | None, known: dict[str, str]) -> tuple[str, int]:
    names = list(known)
    name = names[0] if quantity is None else quantity
    if text(name, "quantity") not in names:
        raise ChannelError(f"quantity: {at!r} has {', '.join(names)}, got {quantity!r}")
    return name, names.index(name)
