"""Units of the recorded quantities, by kind of item.

The core lists what a run can record of a mesh or a bearing (`Connection::channels`).
"""

from gearbow._core import connection_channels

__all__ = ["BEARING", "MESH", "POINT", "ROLLING"]

_CONNECTION = connection_channels()

#: Quantities of a node.
POINT = {"v": "m", "w": "m", "twist": "rad", "u": "m"}
#: Quantities of a mesh: the fields of `MeshResponse`.
MESH = _CONNECTION["mesh"]
#: Quantities of the bearings at a node: the components of their force.
BEARING = _CONNECTION["bearing"]
#: Quantities of the rolling bearings at a node: the fields of `RollingMotion` besides the force.
ROLLING = _CONNECTION["rolling"]
