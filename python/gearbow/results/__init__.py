"""Results of the analyses. A result contains arrays and coordinates, not the system.

The methods of a system and of other results make them. Those that a file can hold are names of
`gearbow` too, such as `gearbow.Response`, for `Response.load`.

Examples
--------
>>> import gearbow as gb
>>> gb.results.Contact.DRIVE
<Contact.DRIVE: 1>
"""

import typing as _typing
from importlib import import_module as _import_module

from gearbow.description.journal import (
    FilmCoefficients as FilmCoefficients,
    PadFilm as PadFilm,
    SqueezeCoefficients as SqueezeCoefficients,
)
from gearbow.description.layout import Order as Order
from gearbow.description.rolling import (
    RingCoefficients as RingCoefficients,
    RollingCoefficients as RollingCoefficients,
    RollingEstimate as RollingEstimate,
)
from gearbow.orders.fit import Orders as Orders
from gearbow.orders.spectrum import Spectrum as Spectrum, Waterfall as Waterfall
from gearbow.recording.access import (
    BearingMotion as BearingMotion,
    EnergyBalance as EnergyBalance,
)
from gearbow.recording.record import (
    Contact as Contact,
    ContactShares as ContactShares,
    ErrorEstimate as ErrorEstimate,
    Event as Event,
    MeshResponse as MeshResponse,
    Statistics as Statistics,
)
from gearbow.results.bearing_life import (
    BearingLife as BearingLife,
    RatedBearing as RatedBearing,
    SpectrumCase as SpectrumCase,
)
from gearbow.results.bow_limits import BowLimits as BowLimits, ReachedLimit as ReachedLimit
from gearbow.results.campbell import (
    Campbell as Campbell,
    ExcitationLine as ExcitationLine,
    Intersection as Intersection,
    StabilityThreshold as StabilityThreshold,
)
from gearbow.results.critical_speeds import CriticalSpeedMap as CriticalSpeedMap
from gearbow.results.frequency_response import FrequencyResponse as FrequencyResponse
from gearbow.results.harmonic import FrequencyComparison as FrequencyComparison
from gearbow.results.modes import ModeComparison as ModeComparison, Modes as Modes
from gearbow.results.peak import Peak as Peak, Peaks as Peaks
from gearbow.results.properties import (
    Discretisation as Discretisation,
    MassProperties as MassProperties,
    Matrices as Matrices,
    ShaftElements as ShaftElements,
)
from gearbow.results.response import Response as Response
from gearbow.results.section_forces import SectionForces as SectionForces
from gearbow.results.sensitivity import (
    ResponseSensitivity as ResponseSensitivity,
    Sensitivity as Sensitivity,
)
from gearbow.results.static import (
    Efficiency as Efficiency,
    MeshState as MeshState,
    Static as Static,
)
from gearbow.results.steady import Continuation as Continuation, SteadyState as SteadyState
from gearbow.results.stresses import Stresses as Stresses
from gearbow.results.synchronous import Synchronous as Synchronous
from gearbow.results.thermal import (
    ThermalSpiral as ThermalSpiral,
    ThermalStability as ThermalStability,
)

#: Names of modules that import results, or that few programs need. Each is imported at its first
#: use.
_MODULES = {
    "Balance": "gearbow.analysis.balance",
    "Correction": "gearbow.identification.correction",
    "TrialInfluence": "gearbow.identification.correction",
    "Identification": "gearbow.identification.result",
    "ProbeResidual": "gearbow.identification.result",
    "MeasuredCurve": "gearbow.exchange.harmonic",
    "LoadCase": "gearbow.exchange.rexs",
    "RexsContents": "gearbow.exchange.rexs",
    "MissingValue": "gearbow.exchange.rexs_joints",
    "MeasuredShapes": "gearbow.exchange.universal",
    "Sweep": "gearbow.sweeps.result",
    "SweepPoint": "gearbow.sweeps.result",
    "Recommendation": "gearbow.studies.result",
    "Skipped": "gearbow.studies.result",
    "Tradeoff": "gearbow.studies.result",
    "Trial": "gearbow.studies.result",
}

if _typing.TYPE_CHECKING:
    from gearbow.analysis.balance import Balance as Balance
    from gearbow.exchange.harmonic import MeasuredCurve as MeasuredCurve
    from gearbow.exchange.rexs import LoadCase as LoadCase, RexsContents as RexsContents
    from gearbow.exchange.rexs_joints import MissingValue as MissingValue
    from gearbow.identification.correction import (
        Correction as Correction,
        TrialInfluence as TrialInfluence,
    )
    from gearbow.identification.result import (
        Identification as Identification,
        ProbeResidual as ProbeResidual,
    )
    from gearbow.studies.result import (
        Recommendation as Recommendation,
        Skipped as Skipped,
        Tradeoff as Tradeoff,
        Trial as Trial,
    )
    from gearbow.sweeps.result import Sweep as Sweep, SweepPoint as SweepPoint
else:  # a type checker would accept every name

    def __getattr__(name: str) -> object:
        if name not in _MODULES:
            raise AttributeError(f"module 'gearbow.results' has no attribute {name!r}")
        globals()[name] = getattr(_import_module(_MODULES[name]), name)
        return globals()[name]


def __dir__() -> list[str]:
    own = {name for name, value in globals().items() if isinstance(value, type)}
    return sorted(own | _MODULES.keys())
