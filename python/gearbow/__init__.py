"""How a geared train moves when its shafts are bent.

Timoshenko shafts with residual bow, gears whose mesh geometry follows their moving centres,
bearings and torques: describe a `RotorSystem`, then ask it for matrices, modes, synchronous
response, equilibrium or a time history. SI units and radians throughout.
"""

from gearbow._core import __version__
from gearbow.bow import Bow
from gearbow.energy import EnergyBalance
from gearbow.errors import (
    ChannelError,
    CheckpointWarning,
    ContactError,
    ConvergenceError,
    GearbowError,
    SceneError,
    SceneWarning,
    StabilityError,
)
from gearbow.modes import Modes
from gearbow.response import Event, MeshResponse, Response
from gearbow.results import Matrices, Static, Synchronous
from gearbow.scene import STEEL, Bearing, Disk, Gear, Material, Mesh, Segment, Shaft, Torque
from gearbow.speed import SpeedProfile
from gearbow.stiffness import Stiffness, TipRelief, TransmissionError
from gearbow.system import RotorSystem
from gearbow.tradeoff import Recommendation, Tradeoff, Trial

__all__ = [
    "STEEL",
    "Bearing",
    "Bow",
    "ChannelError",
    "CheckpointWarning",
    "ContactError",
    "ConvergenceError",
    "Disk",
    "EnergyBalance",
    "Event",
    "Gear",
    "GearbowError",
    "Material",
    "Matrices",
    "Mesh",
    "MeshResponse",
    "Modes",
    "Recommendation",
    "Response",
    "RotorSystem",
    "SceneError",
    "SceneWarning",
    "Segment",
    "Shaft",
    "SpeedProfile",
    "StabilityError",
    "Static",
    "Stiffness",
    "Synchronous",
    "TipRelief",
    "Torque",
    "Tradeoff",
    "TransmissionError",
    "Trial",
    "__version__",
]
