"""Dynamics of geared shaft trains with residual bow.

Describe a `RotorSystem` of shafts, gears, meshes and bearings. Then ask for modes, critical speeds,
the static equilibrium, the response to bow and unbalance, or a run in time.

Numbers are in SI units and radians; `mm`, `rpm` and `degrees` convert. `help(gearbow.Gear)`
describes a part, `help(gearbow.RotorSystem)` the analyses. ``gearbow --help`` lists the commands.

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

import typing as _typing
from importlib import import_module as _import_module
from types import ModuleType as _ModuleType

from gearbow import results as results
from gearbow._core import __version__ as __version__
from gearbow.description.bow import Bow as Bow, BowLimit as BowLimit
from gearbow.description.elastic import Interface as Interface, Surface as Surface
from gearbow.description.gears import (
    Disk as Disk,
    Gear as Gear,
    Mesh as Mesh,
    MeshFriction as MeshFriction,
    TipRelief as TipRelief,
    TransmissionError as TransmissionError,
)
from gearbow.description.journal import (
    JournalBearing as JournalBearing,
    Pad as Pad,
    SqueezeFilm as SqueezeFilm,
    TiltingPadBearing as TiltingPadBearing,
)
from gearbow.description.loads import (
    Bearing as Bearing,
    Coupling as Coupling,
    Drive as Drive,
    Force as Force,
    GroundMotion as GroundMotion,
    MeshExcitation as MeshExcitation,
    ShaftExcitation as ShaftExcitation,
    Torque as Torque,
)
from gearbow.description.places import Housing as Housing, Support as Support
from gearbow.description.planetary import PlanetaryStage as PlanetaryStage, RingGear as RingGear
from gearbow.description.rolling import RollingBearing as RollingBearing
from gearbow.description.shafts import (
    STEEL as STEEL,
    Material as Material,
    Notch as Notch,
    Segment as Segment,
    Shaft as Shaft,
    Sleeve as Sleeve,
)
from gearbow.description.speed import SpeedProfile as SpeedProfile, SpeedTable as SpeedTable
from gearbow.description.stiffness import Stiffness as Stiffness
from gearbow.description.time_series import TimeSeries as TimeSeries
from gearbow.errors import (
    AccuracyWarning as AccuracyWarning,
    ChannelError as ChannelError,
    CheckpointWarning as CheckpointWarning,
    ContactError as ContactError,
    ConvergenceError as ConvergenceError,
    GearbowError as GearbowError,
    MissingExtraError as MissingExtraError,
    SceneError as SceneError,
    SceneWarning as SceneWarning,
    StabilityError as StabilityError,
)
from gearbow.orders.spectrum import waterfall as waterfall
from gearbow.results.response import Response as Response
from gearbow.results.steady import Continuation as Continuation, SteadyState as SteadyState
from gearbow.sensors import (
    Accelerometer as Accelerometer,
    Probe as Probe,
    RingSensor as RingSensor,
    StrainGauge as StrainGauge,
    Tacho as Tacho,
)
from gearbow.system.rotor_system import RotorSystem as RotorSystem
from gearbow.units.speed import degrees as degrees, mm as mm, rpm as rpm

#: Modules of the names that are imported at their first use, with the libraries that they need.
_LAZY = {
    "Measurement": "gearbow.identification.measurement",
    "Sweep": "gearbow.sweeps.result",
    "ThermalBow": "gearbow.description.loads",
    "dataset": "gearbow.studies.dataset",
    "examples": "gearbow.machines.examples",
    "identify": "gearbow.identification.identify",
    "read": "gearbow.system.read",
    "rexs_contents": "gearbow.exchange.rexs",
    "sweep": "gearbow.sweeps.run",
    "unknown": "gearbow.identification",
}

if _typing.TYPE_CHECKING:
    from gearbow.description.loads import ThermalBow as ThermalBow
    from gearbow.exchange.rexs import rexs_contents as rexs_contents
    from gearbow.identification import unknown as unknown
    from gearbow.identification.identify import identify as identify
    from gearbow.identification.measurement import Measurement as Measurement
    from gearbow.machines.examples import examples as examples
    from gearbow.studies.dataset import dataset as dataset
    from gearbow.sweeps.result import Sweep as Sweep
    from gearbow.sweeps.run import sweep as sweep
    from gearbow.system.read import read as read
else:  # a type checker would accept every name

    def __getattr__(name: str) -> object:
        if name not in _LAZY:
            raise AttributeError(f"module 'gearbow' has no attribute {name!r}")
        globals()[name] = getattr(_import_module(_LAZY[name]), name)
        return globals()[name]


# With `__all__` in its place, `help(gearbow)` would describe every class at full length.
def __dir__() -> list[str]:
    own = {
        name
        for name, value in globals().items()
        if not (name.startswith("_") or isinstance(value, _ModuleType))
    }
    return sorted((own | _LAZY.keys() | {"__version__"}) - {"unknown"})  # a module
