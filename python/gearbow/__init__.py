"""Dynamics of geared shaft trains with residual bow.

Timoshenko shafts with residual bow, gears whose mesh geometry follows their moving centres,
bearings and torques. Describe a `RotorSystem`, then compute matrices, modes, synchronous response,
equilibrium or a time history. All quantities are in SI units and radians.

The layers, each of which depends only on those before it:

- `gearbow.units`: units of all fields and arguments,
- `gearbow.description`: parts of a system, and the geometry and kinematics that follow from them,
- `gearbow.recording` and `gearbow.orders`: recorded runs, their files, spectra and orders,
- `gearbow.accuracy`: accuracy levels, and the estimated error of a run,
- `gearbow.results`: results of the analyses,
- `gearbow.analysis` and `gearbow.tradeoff`: analyses that run variants of a system,
- `gearbow.sweeps`: sweeps over parameters, in parallel,
- `gearbow.system`: the class `RotorSystem`.

Methods named `plot` import `gearbow.plotting`, whose functions take arrays.

The compiled core `gearbow._core` computes everything except the following:

- sampling of functions into splines (`Bow.function`, `SpeedProfile.function`),
- amplitude spectra (`orders.spectrum`) and least-squares amplitudes at orders (`orders.fit`),
- least-squares balancing (`analysis.balance`),
- amplification factors and separation margins of peaks (`results.peak`),
- shares of kinetic energy in modes (`results.modes`), semi-axes and phases of orbits
  (`results.synchronous`), totals and residuals of energies (`recording.energy`),
- RMS differences of runs (`accuracy.estimate`, `tradeoff.signals`), CPU times (`tradeoff.clock`),
- measures of the bow study (`study.measure`).
"""

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
from gearbow.results.critical_speeds import CriticalSpeedMap
from gearbow.results.discretisation import Discretisation
from gearbow.results.matrices import Matrices, SparseMatrices
from gearbow.results.modes import Modes
from gearbow.results.peak import Peak
from gearbow.results.response import Response
from gearbow.results.static import Static
from gearbow.results.synchronous import Synchronous
from gearbow.sweeps.result import Sweep, SweepPoint
from gearbow.sweeps.run import sweep
from gearbow.system.rotor_system import RotorSystem
from gearbow.tradeoff.result import Recommendation, Tradeoff
from gearbow.tradeoff.trial import Trial
from gearbow.units.values import degrees, mm, rpm

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
    "Stiffness",
    "Support",
    "Sweep",
    "SweepPoint",
    "Synchronous",
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


def __dir__() -> list[str]:
    return sorted(__all__)
