"""One recorded signal with its label and unit."""

from dataclasses import dataclass

from gearbow._convert import text
from gearbow._shown import Shown
from gearbow._types import Array, Record
from gearbow.description.places import place, place_label
from gearbow.errors import ChannelError
from gearbow.recording.channels import BEARING, MESH, POINT
from gearbow.recording.recording import Recording
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


def channel(
    recording: Recording, of: Record | SignalSensor, quantity: str | None = None
) -> Channel:
    """Find one recorded signal."""
    if isinstance(of, SignalSensor):
        if quantity is not None:
            raise ChannelError(f"quantity: a sensor has one signal; leave out {quantity!r}")
        return Channel(of.label, of.unit, of.measure(recording))
    item: Record = place(of, "of")
    if isinstance(item, tuple) and len(item) == 3:
        values: Array
        name, component = _chosen(item, quantity, _BEARING)
        if name == "x":
            values = recording.axial_bearing_force(item[1], item[2])
        else:
            values = recording.bearing_force(item[1], item[2])[:, component]
        return Channel(f"bearing {item[1]} at {item[2]:g} m {name}", _BEARING[name], values)
    if item == "energy":
        _chosen(item, quantity, {"energy": "J"})
        return Channel("energy", "J", recording.energy)
    if isinstance(item, tuple) and isinstance(item[1], str):
        name, _ = _chosen(item, quantity, {"force": MESH["force"], **MESH})
        values = getattr(recording.mesh(item[0], item[1]), name)
        return Channel(f"{item[0]}/{item[1]} {name.replace('_', ' ')}", MESH[name], values)
    name, _ = _chosen(item, quantity, POINT)
    at = item if isinstance(item, str) else (item[0], float(item[1]))
    single = {
        "twist": recording.twist,
        "u": recording.axial,
        "twist_rate": recording.twist_rate,
        "velocity_u": recording.axial_velocity,
        "acceleration_u": recording.axial_acceleration,
    }
    lateral = {
        "": recording.displacement,
        "velocity": recording.velocity,
        "acceleration": recording.acceleration,
    }
    kind, _, axis = name.rpartition("_")
    motion = single[name](at) if name in single else lateral[kind](at)[:, "vw".index(axis)]
    return Channel(f"{place_label(at)} {name}", POINT[name], motion)


def _chosen(of: Record, quantity: str | None, known: dict[str, str]) -> tuple[str, int]:
    names = list(known)
    name = names[0] if quantity is None else quantity
    if text(name, "quantity") not in names:
        raise ChannelError(f"quantity: {of!r} has {', '.join(names)}, got {quantity!r}")
    return name, names.index(name)
