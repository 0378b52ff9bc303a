"""The arrays over time that a run records: unit, what they belong to, and quantities of each.

Files, tables, data sets, spectra and sensors read this table. The core lists what a run can record
of a mesh or a bearing (`Connection::channels`).
"""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from gearbow._core import connection_channels
from gearbow._types import Array, RunData
from gearbow.recording.energy import ENERGIES, WORKS

#: Entry of the data of a run that lists the places of each kind of owner.
OWNERS = {
    "point": "points",
    "mesh": "meshes",
    "bearing": "bearings",
    "rolling": "rolling_bearings",
}


class RecordedChannel(NamedTuple):
    """One array over time; arrays of one `group` may be absent together."""

    unit: str
    owner: str | None
    quantities: tuple[str, ...]
    group: str | None = None

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the axes of the array."""
        owner = () if self.owner is None else (self.owner,)
        return ("time", *owner, *(("axis",) if len(self.quantities) > 1 else ()))


def _connections(owner: str) -> dict[str, RecordedChannel]:
    """List the quantities of a kind of connection, an array each."""
    return {
        f"{owner}_{name}": RecordedChannel(unit, owner, (name,))
        for name, unit in connection_channels()[owner].items()
    }


_point = "point"
#: Every array over time, by its name in a file.
CHANNELS: dict[str, RecordedChannel] = {
    "displacement": RecordedChannel("m", _point, ("y", "z")),
    "twist": RecordedChannel("rad", _point, ("twist",)),
    "axial": RecordedChannel("m", _point, ("x",), "axial"),
    "velocity": RecordedChannel("m/s", _point, ("velocity_y", "velocity_z"), "velocity"),
    "twist_rate": RecordedChannel("rad/s", _point, ("twist_rate",), "twist_rate"),
    "acceleration": RecordedChannel(
        "m/s²", _point, ("acceleration_y", "acceleration_z"), "acceleration"
    ),
    "axial_velocity": RecordedChannel("m/s", _point, ("velocity_x",), "axial_velocity"),
    "axial_acceleration": RecordedChannel(
        "m/s²", _point, ("acceleration_x",), "axial_acceleration"
    ),
    **_connections("mesh"),
    "bearing_force": RecordedChannel("N", "bearing", tuple(connection_channels()["bearing"])),
    "axial_bearing_force": RecordedChannel("N", "bearing", ("force_x",), "axial"),
    "bearing_displacement": RecordedChannel(
        "m", "bearing", ("displacement_y", "displacement_z"), "bearing_displacement"
    ),
    **_connections("rolling"),
    "energy": RecordedChannel("J", None, ("energy",), "energy"),
    **{
        f"energy_{name}": RecordedChannel("J", None, (f"energy {name}",), "energy")
        for name in ENERGIES
    },
    **{f"energy_{name}": RecordedChannel("J", None, (f"work {name}",), "energy") for name in WORKS},
}


def quantities(owner: str) -> Iterator[tuple[str, str, int | None]]:
    """Give each quantity of a kind of owner with its array and its component in it."""
    for name, channel in CHANNELS.items():
        if channel.owner == owner:
            for component, quantity in enumerate(channel.quantities):
                yield quantity, name, component if len(channel.quantities) > 1 else None


def signals(data: RunData) -> dict[str, Array]:
    """Collect the recorded arrays over time in the order of the table."""
    plain: dict[str, Any] = dict(data)
    found = {name: plain[name] for name in CHANNELS if plain.get(name) is not None}
    for owner, values in (("mesh", data["mesh"]), ("energy", data["energy_terms"] or {})):
        found |= {f"{owner}_{name}": series for name, series in values.items()}
    if data["rolling_bearings"]:
        for k, (_, name, _) in enumerate(quantities("rolling")):
            found[name] = data["rolling_contact"][:, :, k].copy()
    return {name: found[name] for name in CHANNELS if name in found}


def with_signals(data: Mapping[str, Any], time: Array, found: Mapping[str, Array]) -> RunData:
    """Replace the times of a run and its arrays over time."""

    def _nested(owner: str) -> dict[str, Array]:
        begin = f"{owner}_"
        return {k.removeprefix(begin): v for k, v in found.items() if k.startswith(begin)}

    rolling = list(_nested("rolling").values())
    nothing = np.empty((time.size, 0, sum(1 for _ in quantities("rolling"))))
    plain: dict[str, Any] = {
        **data,
        **{k: v for k, v in found.items() if not k.startswith(("mesh_", "rolling_", "energy_"))},
        "time": time,
        "mesh": _nested("mesh"),
        "rolling_contact": np.stack(rolling, 2) if rolling else nothing,
        "energy": found.get("energy"),
        "energy_terms": _nested("energy") or None,
    }
    return plain  # type: ignore[return-value]
