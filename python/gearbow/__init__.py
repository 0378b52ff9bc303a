"""How a geared train moves when its shafts are bent.

Timoshenko shafts with residual bow, gears whose mesh geometry follows their moving centres,
bearings and torques: describe a `RotorSystem`, then ask it for matrices, modes, synchronous
response, equilibrium or a time history. SI units and radians throughout.
"""

from gearbow._core import __version__
from gearbow.balance import Balance
from gearbow.bow import Bow
from gearbow.campbell import Campbell, ExcitationLine, Intersection
from gearbow.critical import CriticalSpeedMap
from gearbow.energy import EnergyBalance
from gearbow.errors import (
    AccuracyWarning,
    ChannelError,
    CheckpointWarning,
    ContactError,
    ConvergenceError,
    GearbowError,
    MissingExtraError,
    RunTimeWarning,
    SceneError,
    SceneWarning,
    StabilityError,
)
from gearbow.modes import Modes
from gearbow.orders import Order, Orders, Spectrum, Waterfall, waterfall
from gearbow.peak import Peak
from gearbow.response import Event, MeshResponse, Response
from gearbow.results import Matrices, Static
from gearbow.scene import STEEL, Bearing, Disk, Gear, Material, Mesh, Segment, Shaft, Torque
from gearbow.speed import SpeedProfile
from gearbow.speed_table import SpeedTable
from gearbow.stiffness import Stiffness, TipRelief, TransmissionError
from gearbow.synchronous import Synchronous
from gearbow.system import RotorSystem
from gearbow.tradeoff import Recommendation, Tradeoff, Trial

__all__ = [
    "STEEL",
    "AccuracyWarning",
    "Balance",
    "Bearing",
    "Bow",
    "Campbell",
    "ChannelError",
    "CheckpointWarning",
    "ContactError",
    "ConvergenceError",
    "CriticalSpeedMap",
    "Disk",
    "EnergyBalance",
    "Event",
    "ExcitationLine",
    "Gear",
    "GearbowError",
    "Intersection",
    "Material",
    "Matrices",
    "Mesh",
    "MeshResponse",
    "MissingExtraError",
    "Modes",
    "Order",
    "Orders",
    "Peak",
    "Recommendation",
    "Response",
    "RotorSystem",
    "RunTimeWarning",
    "SceneError",
    "SceneWarning",
    "Segment",
    "Shaft",
    "Spectrum",
    "SpeedProfile",
    "SpeedTable",
    "StabilityError",
    "Static",
    "Stiffness",
    "Synchronous",
    "TipRelief",
    "Torque",
    "Tradeoff",
    "TransmissionError",
    "Trial",
    "Waterfall",
    "__version__",
    "waterfall",
]
