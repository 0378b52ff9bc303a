"""Dynamics of geared shaft trains with residual bow.

Describe a `RotorSystem` of shafts, gears, meshes and bearings. Then ask for modes, critical speeds,
the static equilibrium, the response to bow and unbalance, or a run in time.

Numbers are in SI units and radians. `mm`, `rpm` and `degrees` convert, and quantities of pint and
texts in scene files have units. `help(gearbow.Gear)` describes a part, `help(gearbow.RotorSystem)`
the system with its analyses. On the command line, ``gearbow --help`` lists the commands.

Examples
--------
>>> import gearbow as gb
>>> rotor = gb.Shaft("rotor", length=gb.mm(800), outer_diameter=gb.mm(50))
>>> bearings = [gb.Bearing("rotor", x, stiffness=1e8, damping=500.0) for x in (0.0, 0.8)]
>>> wheel = gb.Disk("wheel", "rotor", 0.4, mass=20.0, diametral_inertia=0.1, polar_inertia=0.2)
>>> system = gb.RotorSystem([rotor], bearings=bearings, disks=[wheel])
>>> print(f"{system.modes(gb.rpm(3000), count=1).frequencies_hz[0]:.1f} Hz")
74.6 Hz
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from gearbow._core import __version__
from gearbow.analysis.balance import Balance
from gearbow.description.bow import Bow
from gearbow.description.couplings import Coupling, Drive, Force
from gearbow.description.gears import Disk, Gear, Mesh
from gearbow.description.journal import FilmCoefficients, JournalBearing, JournalMotion
from gearbow.description.kinematics import Order
from gearbow.description.loads import Bearing, Torque
from gearbow.description.rolling import RollingBearing, RollingCoefficients, RollingMotion
from gearbow.description.shafts import STEEL, Material, Segment, Shaft
from gearbow.description.speed import SpeedProfile
from gearbow.description.speed_table import SpeedTable
from gearbow.description.stiffness import Stiffness
from gearbow.description.supports import Housing, Support
from gearbow.description.teeth import TipRelief, TransmissionError
from gearbow.description.time_series import TimeSeries
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
from gearbow.orders.fit import Orders
from gearbow.orders.spectrum import Spectrum
from gearbow.orders.waterfall import Waterfall, waterfall
from gearbow.recording.energy import EnergyBalance
from gearbow.recording.record import Event, MeshResponse
from gearbow.results.campbell import Campbell, ExcitationLine, Intersection
from gearbow.results.continuation import Continuation
from gearbow.results.critical_speeds import CriticalSpeedMap
from gearbow.results.discretisation import Discretisation
from gearbow.results.matrices import Matrices, SparseMatrices
from gearbow.results.modes import Modes
from gearbow.results.peak import Peak
from gearbow.results.response import Response
from gearbow.results.static import Static
from gearbow.results.steady import SteadyState
from gearbow.results.synchronous import Synchronous
from gearbow.sensors.accelerometer import Accelerometer
from gearbow.sensors.probe import Probe
from gearbow.sensors.tacho import Tacho
from gearbow.system.rotor_system import RotorSystem
from gearbow.tradeoff.result import Recommendation, Tradeoff
from gearbow.tradeoff.trial import Trial
from gearbow.units.values import degrees, mm, rpm

__all__ = [
    "STEEL",
    "Accelerometer",
    "AccuracyWarning",
    "Balance",
    "Bearing",
    "Bow",
    "Campbell",
    "ChannelError",
    "CheckpointWarning",
    "ContactError",
    "Continuation",
    "ConvergenceError",
    "Coupling",
    "CriticalSpeedMap",
    "Discretisation",
    "Disk",
    "Drive",
    "EnergyBalance",
    "Event",
    "ExcitationLine",
    "FilmCoefficients",
    "Force",
    "Gear",
    "GearbowError",
    "Housing",
    "Intersection",
    "JournalBearing",
    "JournalMotion",
    "Material",
    "Matrices",
    "Mesh",
    "MeshResponse",
    "MissingExtraError",
    "Modes",
    "Order",
    "Orders",
    "Peak",
    "Probe",
    "Recommendation",
    "Response",
    "RollingBearing",
    "RollingCoefficients",
    "RollingMotion",
    "RotorSystem",
    "RunTimeWarning",
    "SceneError",
    "SceneWarning",
    "Segment",
    "Shaft",
    "SparseMatrices",
    "Spectrum",
    "SpeedProfile",
    "SpeedTable",
    "StabilityError",
    "Static",
    "SteadyState",
    "Stiffness",
    "Support",
    "Sweep",
    "SweepPoint",
    "Synchronous",
    "Tacho",
    "TimeSeries",
    "TipRelief",
    "Torque",
    "Tradeoff",
    "TransmissionError",
    "Trial",
    "Waterfall",
    "__version__",
    "degrees",
    "mm",
    "rpm",
    "sweep",
    "waterfall",
]

#: Modules of the names that are imported at their first use, with the libraries of a sweep.
_LAZY = {
    "Sweep": "gearbow.sweeps.result",
    "SweepPoint": "gearbow.sweeps.result",
    "sweep": "gearbow.sweeps.run",
}

if TYPE_CHECKING:
    from gearbow.sweeps.result import Sweep, SweepPoint
    from gearbow.sweeps.run import sweep
else:  # a type checker would accept every name

    def __getattr__(name: str) -> Any:
        if name not in _LAZY:
            raise AttributeError(f"module 'gearbow' has no attribute {name!r}")
        globals()[name] = getattr(import_module(_LAZY[name]), name)
        return globals()[name]


def __dir__() -> list[str]:
    return sorted(__all__)
