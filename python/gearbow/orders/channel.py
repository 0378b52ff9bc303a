"""One recorded signal with its label and unit."""

from dataclasses import dataclass
from typing import Any

from gearbow._convert import text
from gearbow._shown import Shown
from gearbow._types import (
    Array,
    Record,
    SignalQuantity,
)
from gearbow.description.places import is_pair, place, place_label
from gearbow.errors import ChannelError
from gearbow.recording import access
from gearbow.recording.channels import CHANNELS, quantities
from gearbow.recording.record import RunRecord
from gearbow.sensors.sensor import SignalSensor

#: Quantities of each kind of place: array, component and unit.
_MOTION, _MESH = (
    {quantity: (array, component, CHANNELS[array].unit) for quantity, array, component in known}
    for known in map(quantities, ("point", "mesh"))
)
#: Components of the force on a bearing.
_BEARING = {
    quantity.removeprefix("force_"): (array, component, CHANNELS[array].unit)
    for quantity, array, component in quantities("bearing")
    if quantity.startswith("force_")
}


@dataclass(frozen=True, eq=False)
class Channel(Shown):
    """A signal over time."""

    label: str
    unit: str
    values: Array


def channel(
    run: RunRecord, at: Record | SignalSensor, quantity: SignalQuantity | None = None
) -> Channel:
    """Find one recorded signal."""
    if isinstance(at, SignalSensor):
        if quantity is not None:
            raise ChannelError(f"quantity: a sensor has one signal; leave out {quantity!r}")
        return Channel(at.label, at.unit, at.measure(run))
    item: Any = place(at)
    if isinstance(item, tuple) and len(item) == 3:
        return _of_bearing(run, item, quantity)
    if item == "energy":
        _chosen(item, quantity, ["energy"])
        return Channel("energy", "J", access.energy(run))
    if is_pair(item):
        name = _chosen(item, quantity, ["force", *(name for name in _MESH if name != "force")])
        values = getattr(access.mesh(run, item), name)
        driver, driven = access.mesh_names(run, item)
        return Channel(f"{driver}/{driven} {name.replace('_', ' ')}", _MESH[name][2], values)
    name = _chosen(item, quantity, list(_MOTION))
    array, component, unit = _MOTION[name]
    motion = access.motion(run, array, item)  # type: ignore[arg-type]
    values = motion if component is None else motion[:, component]
    return Channel(f"{place_label(item)} {name}", unit, values)


def _of_bearing(
    run: RunRecord, item: tuple[str, str, float], quantity: SignalQuantity | None
) -> Channel:
    """Find a component of the force on a bearing, ("bearing", shaft, position)."""
    _, shaft, position = item
    name = _chosen(item, quantity, list(_BEARING))
    _, component, unit = _BEARING[name]
    if component is None:
        values = access.axial_bearing_force(run, (shaft, position))
    else:
        values = access.bearing_force(run, (shaft, position))[:, component]
    return Channel(f"bearing {shaft} at {position:g} m {name}", unit, values)


def _chosen(at: Record, quantity: SignalQuantity | None, names: list[str]) -> str:
    name = names[0] if quantity is None else quantity
    if text(name, "quantity") not in names:
        raise ChannelError(f"quantity: {at!r} has {', '.join(names)}, got {quantity!r}")
    return name
