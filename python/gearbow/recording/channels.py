"""Units of the recorded quantities, by kind of item.

The core lists what a run can record of a mesh or a bearing (`Connection::channels`).
"""

from gearbow._core import connection_channels

__all__ = ["BEARING", "MESH", "POINT", "RATES", "RATE_UNITS", "ROLLING"]

_CONNECTION = connection_channels()

#: Recorded rates of a node, by the name of their array: the quantities along its axes.
RATES = {
    "velocity": ("velocity_y", "velocity_z"),
    "twist_rate": ("twist_rate",),
    "acceleration": ("acceleration_y", "acceleration_z"),
    "axial_velocity": ("velocity_x",),
    "axial_acceleration": ("acceleration_x",),
}
#: Units of recorded rates.
RATE_UNITS = {
    "velocity": "m/s",
    "twist_rate": "rad/s",
    "acceleration": "m/s²",
    "axial_velocity": "m/s",
    "axial_acceleration": "m/s²",
}
#: Quantities of a node.
POINT = {"y": "m", "z": "m", "twist": "rad", "x": "m"} | {
    quantity: RATE_UNITS[array] for array, quantities in RATES.items() for quantity in quantities
}
#: Quantities of a mesh: the fields of `MeshResponse`.
MESH = _CONNECTION["mesh"]
#: Quantities of the bearings at a node: the components of their force.
BEARING = _CONNECTION["bearing"]
#: Quantities of the rolling bearings at a node: those fields of `BearingMotion`.
ROLLING = _CONNECTION["rolling"]
