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

#: Module of each name. It is imported at the first use, because the modules of the package import
#: each other's results.
_MODULES = {
    "Balance": "gearbow.analysis.balance",
    "FilmCoefficients": "gearbow.description.journal",
    "Order": "gearbow.description.kinematics",
    "RingCoefficients": "gearbow.description.rolling",
    "RollingCoefficients": "gearbow.description.rolling",
    "RollingEstimate": "gearbow.description.rolling",
    "Correction": "gearbow.identification.correction",
    "Identification": "gearbow.identification.result",
    "TrialInfluence": "gearbow.identification.trials",
    "ProbeResidual": "gearbow.identification.result",
    "MeasuredCurve": "gearbow.exchange.harmonic",
    "LoadCase": "gearbow.exchange.rexs",
    "RexsContents": "gearbow.exchange.rexs",
    "MissingValue": "gearbow.exchange.rexs_joints",
    "Orders": "gearbow.orders.fit",
    "Spectrum": "gearbow.orders.spectrum",
    "Waterfall": "gearbow.orders.waterfall",
    "BearingMotion": "gearbow.recording.access",
    "Contact": "gearbow.recording.contact",
    "ContactShares": "gearbow.recording.contact",
    "EnergyBalance": "gearbow.recording.energy",
    "Event": "gearbow.recording.record",
    "MeshResponse": "gearbow.recording.record",
    "BowLimits": "gearbow.results.bow_limits",
    "ReachedLimit": "gearbow.results.bow_limits",
    "Campbell": "gearbow.results.campbell",
    "ExcitationLine": "gearbow.results.campbell",
    "Intersection": "gearbow.results.campbell",
    "Continuation": "gearbow.results.continuation",
    "CriticalSpeedMap": "gearbow.results.critical_speeds",
    "Discretisation": "gearbow.results.properties",
    "Efficiency": "gearbow.results.static",
    "FrequencyComparison": "gearbow.results.harmonic",
    "FrequencyResponse": "gearbow.results.frequency_response",
    "MassProperties": "gearbow.results.properties",
    "Matrices": "gearbow.results.properties",
    "MeasuredShapes": "gearbow.exchange.mode_shapes",
    "ModeComparison": "gearbow.results.modes",
    "Modes": "gearbow.results.modes",
    "Peak": "gearbow.results.peak",
    "Peaks": "gearbow.results.peak",
    "Response": "gearbow.results.response",
    "ResponseSensitivity": "gearbow.results.sensitivity",
    "Sensitivity": "gearbow.results.sensitivity",
    "Static": "gearbow.results.static",
    "SteadyState": "gearbow.results.steady",
    "Synchronous": "gearbow.results.synchronous",
    "StabilityThreshold": "gearbow.results.campbell",
    "ThermalSpiral": "gearbow.results.thermal",
    "ThermalStability": "gearbow.results.thermal",
    "Sweep": "gearbow.sweeps.result",
    "SweepPoint": "gearbow.sweeps.result",
    "Recommendation": "gearbow.tradeoff.result",
    "Tradeoff": "gearbow.tradeoff.result",
    "Trial": "gearbow.tradeoff.trial",
}

if _typing.TYPE_CHECKING:
    from gearbow.analysis.balance import Balance as Balance
    from gearbow.description.journal import FilmCoefficients as FilmCoefficients
    from gearbow.description.kinematics import Order as Order
    from gearbow.description.rolling import (
        RingCoefficients as RingCoefficients,
        RollingCoefficients as RollingCoefficients,
        RollingEstimate as RollingEstimate,
    )
    from gearbow.exchange.harmonic import MeasuredCurve as MeasuredCurve
    from gearbow.exchange.rexs import LoadCase as LoadCase, RexsContents as RexsContents
    from gearbow.exchange.rexs_joints import MissingValue as MissingValue
    from gearbow.identification.correction import Correction as Correction
    from gearbow.identification.result import (
        Identification as Identification,
        ProbeResidual as ProbeResidual,
    )
    from gearbow.identification.trials import TrialInfluence as TrialInfluence
    from gearbow.orders.fit import Orders as Orders
    from gearbow.orders.spectrum import Spectrum as Spectrum
    from gearbow.orders.waterfall import Waterfall as Waterfall
    from gearbow.recording.access import BearingMotion as BearingMotion
    from gearbow.recording.contact import (
        Contact as Contact,
        ContactShares as ContactShares,
    )
    from gearbow.recording.energy import EnergyBalance as EnergyBalance
    from gearbow.recording.record import (
        Event as Event,
        MeshResponse as MeshResponse,
    )
    from gearbow.results.bow_limits import BowLimits as BowLimits, ReachedLimit as ReachedLimit
    from gearbow.results.campbell import (
        Campbell as Campbell,
        ExcitationLine as ExcitationLine,
        Intersection as Intersection,
        StabilityThreshold as StabilityThreshold,
    )
    from gearbow.results.continuation import Continuation as Continuation
    from gearbow.results.critical_speeds import CriticalSpeedMap as CriticalSpeedMap
    from gearbow.results.frequency_response import FrequencyResponse as FrequencyResponse
    from gearbow.results.harmonic import (
        FrequencyComparison as FrequencyComparison,
    )
    from gearbow.results.modes import ModeComparison as ModeComparison, Modes as Modes
    from gearbow.results.peak import (
        Peak as Peak,
        Peaks as Peaks,
    )
    from gearbow.results.properties import (
        Discretisation as Discretisation,
        MassProperties as MassProperties,
        Matrices as Matrices,
    )
    from gearbow.results.response import Response as Response
    from gearbow.results.sensitivity import (
        ResponseSensitivity as ResponseSensitivity,
        Sensitivity as Sensitivity,
    )
    from gearbow.results.static import Efficiency as Efficiency, Static as Static
    from gearbow.results.steady import SteadyState as SteadyState
    from gearbow.results.synchronous import Synchronous as Synchronous
    from gearbow.results.thermal import (
        ThermalSpiral as ThermalSpiral,
        ThermalStability as ThermalStability,
    )
    from gearbow.sweeps.result import (
        Sweep as Sweep,
        SweepPoint as SweepPoint,
    )
    from gearbow.tradeoff.result import (
        Recommendation as Recommendation,
        Tradeoff as Tradeoff,
    )
    from gearbow.tradeoff.trial import Trial as Trial
else:  # a type checker would accept every name

    def __getattr__(name: str) -> object:
        if name not in _MODULES:
            raise AttributeError(f"module 'gearbow.results' has no attribute {name!r}")
        globals()[name] = getattr(_import_module(_MODULES[name]), name)
        return globals()[name]


def __dir__() -> list[str]:
    return sorted(_MODULES)
