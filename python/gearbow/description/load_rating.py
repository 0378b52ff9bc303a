"""Load ratings of rolling bearings, equivalent loads, and life: ISO 281, ISO 76, ISO/TS 16281.

Every life of the package is computed here. Lengths are in m and forces in N; the formulas of the
standards have mm.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal, TypeAlias

import numpy as np

from gearbow._convert import number
from gearbow._shown import Shown
from gearbow._types import Array
from gearbow.description.loads import Bearing
from gearbow.description.places import other_shaft
from gearbow.description.rolling import RollingBearing, RollingEstimate
from gearbow.errors import SceneError

#: Where a rating comes from: an entry of the bearing, the catalogue below, or the formulas.
RatingSource: TypeAlias = Literal["given", "catalogue", "computed"]

#: Bore code, and basic dynamic and static ratings [kN] of its deep groove ball bearings in the
#: series 60, 62 and 63. SKF, *Rolling bearings*, catalogue PUB BU/P1 17000/1 EN, October 2018. They
#: were not compared with the print. For 60 of the sizes, those of NTN's catalogue 2203 are between
#: 0.93 and 1.19 times the dynamic and 0.89 and 1.05 times the static ratings.
_CATALOGUE = """
00   4.75  1.96   5.4  2.36  8.52   3.4
01    5.4  2.36  7.28   3.1  10.1  4.15
02   5.85  2.85  8.06  3.75  11.9   5.4
03   6.37  3.25  9.95  4.75  14.3  6.55
04   9.95     5  13.5  6.55  16.8   7.8
05   11.9  6.55  14.8   7.8  23.4  11.6
06   13.8   8.3  20.3  11.2  29.6    16
07   16.8  10.2    27  15.3  35.1    19
08   17.8    11  32.5    19  42.3    24
09   22.1  14.6  35.1  21.6  55.3  31.5
10   22.9    16  37.1  23.2    65    38
11   29.6  21.2  46.2    29  74.1    45
12   30.7  23.2  55.3    36  85.2    52
13   31.9    25  58.5  40.5  97.5    60
14   39.7    31  63.7    45   111    68
15   41.6  33.5  68.9    49   119  76.5
16   49.4    40  72.8    55   130  86.5
17     52    43  87.1    64   140  96.5
18   60.5    50   101  73.5   151   108
19   63.7    54   114  81.5   159   118
20   63.7    54   127    93   174   140
21   76.1  65.5   140   104   182   153
22   85.2  73.5   151   118   203   180
24   88.4    80   146   118   208   186
26    112   100   156   132   229   216
28    111   108   165   150   251   245
30    125   125   174   166   276   285
"""

#: Relative axial loads f₀ F_a/C₀ and contact angles [rad] of the factors of ball bearings.
_AXIAL_LOADS = (0.172, 0.345, 0.689, 1.03, 1.38, 2.07, 3.45, 5.17, 6.89)
_ANGLES = tuple(np.radians([0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0]))
#: Limit e of F_a/F_r and factors X and Y of single-row ball bearings (ISO 281:2007, table 3), a row
#: for each contact angle. That of 5° has the values of radial contact.
_RADIAL_E = (0.19, 0.22, 0.26, 0.28, 0.30, 0.34, 0.38, 0.42, 0.44)
_RADIAL_Y = (2.30, 1.99, 1.71, 1.55, 1.45, 1.31, 1.15, 1.04, 1.00)
_E = np.array(
    [
        _RADIAL_E,
        _RADIAL_E,
        (0.29, 0.32, 0.36, 0.38, 0.40, 0.44, 0.49, 0.54, 0.54),
        (0.38, 0.40, 0.43, 0.46, 0.47, 0.50, 0.55, 0.56, 0.56),
        *([each] * len(_AXIAL_LOADS) for each in (0.57, 0.68, 0.80, 0.95, 1.14, 1.34)),
    ]
)
_Y = np.array(
    [
        _RADIAL_Y,
        _RADIAL_Y,
        (1.88, 1.71, 1.52, 1.41, 1.34, 1.23, 1.10, 1.01, 1.00),
        (1.47, 1.40, 1.30, 1.23, 1.19, 1.12, 1.02, 1.00, 1.00),
        *([each] * len(_AXIAL_LOADS) for each in (1.00, 0.87, 0.76, 0.66, 0.57, 0.50)),
    ]
)
_X = (0.56, 0.56, 0.46, 0.44, 0.43, 0.41, 0.39, 0.37, 0.35, 0.33)
#: Static factors X₀ and Y₀ of single-row ball bearings by contact angle (ISO 76:2006, table 2,
#: not compared with the print). Those of 15°, 25° and 40° are also in LYC's table "Equivalent
#: static load - angular contact ball bearings" (www.lycbearing.com), that of 40° in sheets of FAG.
_X_STATIC = (0.6, *[0.5] * 9)
_Y_STATIC = (0.5, 0.52, 0.50, 0.46, 0.42, 0.38, 0.33, 0.29, 0.26, 0.22)
#: Largest contact angle of a radial bearing [rad] in ISO 281.
_MOST_ANGLE = math.radians(45.0)
#: Reliability S, and life at it over the life that 90 % of bearings reach (ISO 281:2007, table 12):
#: 0.95 (ln(1/S)/ln(1/0.9))^(2/3) + 0.05 in two digits, Weibull's distribution with the exponent 1.5
#: and a smallest life of 0.05 (ISO/TR 1281-2:2008).
_RELIABILITY = {
    0.90: 1.0,
    0.95: 0.64,
    0.96: 0.55,
    0.97: 0.47,
    0.98: 0.37,
    0.99: 0.25,
    0.992: 0.22,
    0.994: 0.19,
    0.996: 0.16,
    0.998: 0.12,
    0.999: 0.093,
    0.9992: 0.087,
    0.9994: 0.080,
    0.9995: 0.077,
}


@dataclass(frozen=True)
class _Elements:
    """Rolling elements of a bearing: count, diameter [m], γ = d cos α/D, and length of a roller."""

    count: int
    diameter: float
    gamma: float
    length: float | None
    #: Groove radii of inner and outer race over the diameter of a ball.
    grooves: tuple[float, float]

    @property
    def weakness(self) -> float:
        """Rating of the inner race over that of the outer one, to the power of the formulas."""
        ratio = (1.0 - self.gamma) / (1.0 + self.gamma)
        if self.length is not None:
            return float(ratio ** (143.0 / 108.0))
        inner, outer = self.grooves
        osculation = inner / outer * (2.0 * outer - 1.0) / (2.0 * inner - 1.0)
        return float(ratio**1.72 * osculation**0.41)


@dataclass(frozen=True)
class LoadRating(Shown):
    """Basic load ratings of a rolling bearing, with what equivalent load and life need of it."""

    dynamic: float
    #: NaN if unknown.
    static: float
    source: RatingSource
    rolls: bool
    #: Contact angle, not negative [rad].
    angle: float
    elements: _Elements | None

    @property
    def exponent(self) -> float:
        """Exponent p of the life (C/P)^p."""
        return 10.0 / 3.0 if self.rolls else 3.0

    @property
    def carries_thrust(self) -> bool:
        """Whether the contacts carry thrust: all but rollers without contact angle."""
        return not self.rolls or self.angle > 0.0

    def equivalent_load(self, radial: Any, thrust: float) -> Any:
        """Give P = X F_r + Y F_a of ISO 281 for radial forces and one thrust [N]."""
        thrust = abs(thrust)
        if not self.carries_thrust:
            return radial
        if self.rolls:
            limit, x, y = 1.5 * math.tan(self.angle), 0.4, 0.4 / math.tan(self.angle)
        else:
            # Without a static rating, the smallest relative thrust gives the largest load.
            relative = 0.0
            if not math.isnan(self.static):
                # The standard lists relative loads for each angle: those of 0° over its cosine.
                relative = self._f0 * thrust * math.cos(self.angle) / self.static
            limit, y = (
                _at_angle(self.angle, [np.interp(relative, _AXIAL_LOADS, row) for row in table])
                for table in (_E, _Y)
            )
            x = _at_angle(self.angle, _X)
        # Over the limit, the formula is above F_r but for the rounded factors of the table.
        combined = np.maximum(radial, x * radial + y * thrust)
        return np.where(thrust > limit * radial, combined, radial)

    def static_load(self, radial: float, thrust: float) -> float:
        """Give the equivalent static load P₀ of ISO 76 [N]."""
        if not self.carries_thrust:
            return radial
        if self.rolls:
            x, y = 0.5, 0.22 / math.tan(self.angle)
        else:
            x, y = (_at_angle(self.angle, table) for table in (_X_STATIC, _Y_STATIC))
        return max(radial, x * radial + y * abs(thrust))

    @property
    def _f0(self) -> float:
        """Factor f₀ of ISO 76; that of γ = 0.2 for unknown elements, of which it is 12 to 17."""
        return _static_factor(0.2 if self.elements is None else self.elements.gamma)

    def revolutions_of_elements(self, forces: Array, rotating: tuple[bool, bool]) -> float:
        """Give the life [million turns] under forces on the elements around the bearing [N]."""
        # ISO/TS 16281, with laminae of equal load. `rotating` says which of the inner and the outer
        # ring turns relative to the load. Edge stresses of rollers are not known, so that their
        # factor 0.83 stays in the ratings of the lines.
        own = self.elements
        if own is None:
            raise AssertionError("only bearings with elements have loads of elements")
        largest = float(forces.max())
        if largest == 0.0:
            return math.inf
        loads = forces / largest
        line = self.rolls
        # The first power of the cosine: that of the force of all elements across the shaft.
        across = own.count * math.cos(self.angle)
        slope, power = (1.038, 4.5) if line else (1.044, 10.0 / 3.0)
        # J_r/J₁ and J_r/J₂ of a bearing that is loaded on half of its circumference (Harris 2001):
        # for balls 0.2288/0.5625 and 0.2288/0.5875, for lines 0.2453/0.6495 and 0.2453/0.6744.
        factors = (0.378, 0.364) if line else (0.407, 0.389)
        weakness = (slope * own.weakness) ** power
        life = 0.0
        for factor, part, turns in zip(factors, (weakness, 1.0 / weakness), rotating, strict=True):
            rating = self.dynamic / (factor * across) * (1.0 + part) ** (1.0 / power)
            # A ring at rest relative to the load has a mean of a higher power.
            mean_power = (4.0 if turns else 4.5) if line else (3.0 if turns else 10.0 / 3.0)
            mean = largest * float(np.mean(loads**mean_power)) ** (1.0 / mean_power)
            life += (rating / mean) ** -power
        return float(life ** (-8.0 / 9.0 if line else -0.9))


def _at_angle(angle: float, values: Any) -> float:
    """Interpolate a factor of ball bearings over the contact angle."""
    return float(np.interp(angle, _ANGLES, values))


def rating_of(bearing: object) -> LoadRating | None:
    """Give the ratings of a bearing: given, from the catalogue, or computed; None if unknown."""
    if isinstance(bearing, Bearing):
        if bearing.dynamic_rating is None:
            return None
        static = math.nan if bearing.static_rating is None else bearing.static_rating
        rolls, angle = bearing.contact == "roller", abs(bearing.contact_angle or 0.0)
        return LoadRating(bearing.dynamic_rating, static, "given", rolls, angle, None)
    if not isinstance(bearing, RollingBearing):
        return None
    rolls, angle, own = bearing._rolls, abs(bearing._angle), _elements(bearing)
    listed = _listed(bearing.estimate)
    dynamic, static = listed or (_dynamic(own, angle), _static(own, angle))
    source: RatingSource = "computed" if listed is None else "catalogue"
    if bearing.dynamic_rating is not None:
        source, dynamic = "given", bearing.dynamic_rating
    if bearing.static_rating is not None:
        static = bearing.static_rating
    return None if math.isnan(dynamic) else LoadRating(dynamic, static, source, rolls, angle, own)


def _elements(bearing: RollingBearing) -> _Elements:
    """Give the rolling elements, given or estimated."""
    estimate = bearing.estimate

    def known(name: str) -> float:
        own = getattr(bearing, name)
        found = getattr(estimate, name, None) if own is None else own
        # A roller whose stiffness is given may have no length: its ratings are then unknown.
        return math.nan if found is None else float(found)

    diameter = known("element_diameter")
    return _Elements(
        count=int(known("elements")),
        diameter=diameter,
        gamma=diameter / known("pitch_diameter") * math.cos(bearing._angle),
        length=known("roller_length") if bearing._rolls else None,
        grooves=(bearing.inner_groove or 0.52, bearing.outer_groove or 0.52),
    )


def _listed(estimate: RollingEstimate | None) -> tuple[float, float] | None:
    """Look up dynamic and static rating [N] of a deep groove ball bearing by its dimensions."""
    if estimate is None or estimate.kind != "deep_groove":
        return None
    return _catalogue().get(_in_tenths(estimate))


@cache
def _catalogue() -> dict[tuple[int, ...], tuple[float, float]]:
    """Give the ratings [N] of the catalogue by bore, outside diameter and width [0.1 mm]."""
    found = {}
    for code, *ratings in (row.split() for row in _CATALOGUE.strip().split("\n")):
        pairs = zip(ratings[::2], ratings[1::2], strict=True)
        for series, (dynamic, static) in zip(("60", "62", "63"), pairs, strict=True):
            estimate = RollingBearing("", 0.0, series + code).estimate
            if estimate is not None:
                found[_in_tenths(estimate)] = (1e3 * float(dynamic), 1e3 * float(static))
    return found


def _in_tenths(estimate: RollingEstimate) -> tuple[int, ...]:
    """Give bore, outside diameter and width [0.1 mm]."""
    return tuple(round(1e4 * size) for size in (estimate.bore, estimate.outer, estimate.width))


def _dynamic(own: _Elements, angle: float) -> float:
    """Compute the basic dynamic rating [N] of ISO 281; NaN for a thrust bearing."""
    if angle > _MOST_ANGLE:
        return math.nan
    # The formulas behind the tables of f_c (ISO/TR 1281-1), which they reproduce within 0.1 %.
    gamma, size = own.gamma, 1e3 * own.diameter
    if own.length is not None:
        weakness = (1.0 + (1.04 * own.weakness) ** 4.5) ** (-2.0 / 9.0)
        shape = gamma ** (2.0 / 9.0) * (1.0 - gamma) ** (29.0 / 27.0) / (1.0 + gamma) ** 0.25
        factor = 1.1 * 0.83 * 0.377 * 551.13373 * weakness * shape
        along = (1e3 * own.length * math.cos(angle)) ** (7.0 / 9.0)
        return float(factor * along * own.count**0.75 * size ** (29.0 / 27.0))
    inner = own.grooves[0]
    weakness = (1.0 + (1.04 * own.weakness) ** (10.0 / 3.0)) ** -0.3
    shape = gamma**0.3 * (1.0 - gamma) ** 1.39 / (1.0 + gamma) ** (1.0 / 3.0)
    osculation = (2.0 * inner / (2.0 * inner - 1.0)) ** 0.41
    factor = 1.3 * 0.95 * 0.41 * 98.0665 * weakness * shape * osculation
    # Large balls have a smaller exponent (ISO 281, formula 2).
    power = size**1.8 if size <= 25.4 else 3.647 * size**1.4
    return float(factor * math.cos(angle) ** 0.7 * own.count ** (2.0 / 3.0) * power)


def _static(own: _Elements, angle: float) -> float:
    """Compute the basic static rating [N] of ISO 76."""
    size = 1e3 * own.diameter
    if own.length is None:
        return _static_factor(own.gamma) * own.count * size**2 * math.cos(angle)
    return 44.0 * (1.0 - own.gamma) * own.count * 1e3 * own.length * size * math.cos(angle)


def _static_factor(gamma: float) -> float:
    """Give f₀ of ISO 76 [N/mm²]: force on the most loaded ball, 5/Z of that on the bearing."""
    # At the rating, the contact pressure is 4200 MPa with grooves of 0.52 and 0.53 ball diameters
    # in inner and outer ring. The ellipse is that of Brewe and Hamrock; the table of the standard
    # is met within 1.7 %.
    modulus, poisson, pressure = 2.07e5, 0.3, 4200.0
    found = []
    for groove, sign in ((0.52, -1.0), (0.53, 1.0)):
        along, across = (1.0 + sign * gamma) / 2.0, groove / (2.0 * groove - 1.0)
        ratio = across / along
        ellipse = 1.0339 * ratio**0.636 * (1.0003 + 0.5968 / ratio) ** 2
        curvature = 1.0 / along + 1.0 / across
        shear = (1.0 - poisson**2) ** 2 / (modulus * curvature) ** 2
        found.append(32.0 * math.pi / 3.0 * ellipse * shear * pressure**3 / 5.0)
    return float(min(found))


def ring_ratios(bearing: Any, ratios: Mapping[str, float]) -> tuple[float, float]:
    """Give the speeds of the inner and the outer ring over that of the reference shaft."""
    other = other_shaft(bearing.support)
    return ratios[bearing.shaft], 0.0 if other is None else ratios[other[0]]


def life_hours(revolutions: float, speed: float) -> float:
    """Convert a life [million turns] to hours at a relative speed of the rings [rad/s]."""
    turns_per_hour = 3600.0 * abs(speed) / (2.0 * math.pi)
    return 1e6 * revolutions / turns_per_hour if turns_per_hour else math.inf


def life_revolutions(dynamic: float, load: float, exponent: float) -> float:
    """Give the basic rating life (C/P)^p [million turns]."""
    return (dynamic / load) ** exponent if load else math.inf


def load_for_hours(hours: float, speed: float, dynamic: float, exponent: float) -> float:
    """Give the load with a basic rating life [h] at a relative speed of the rings [rad/s]."""
    one = life_hours(1.0, speed)
    return math.inf if math.isinf(one) else dynamic * (one / hours) ** (1.0 / exponent)


def reliability_factor(reliability: float) -> float:
    """Give the factor a₁ of ISO 281 for a reliability from 0.9 to 0.9995."""
    # Between the values of its table, the logarithm of a₁ is linear in that of -ln(reliability), as
    # in a Weibull distribution.
    known = np.array(list(_RELIABILITY))
    given = number(reliability, "reliability")
    if not known[0] <= given <= known[-1]:
        raise SceneError(
            f"reliability: must be between {known[0]:g} and {known[-1]:g}, got {given}; 0.9 is "
            "that of the basic rating life"
        )
    # From the largest reliability on, -ln grows.
    scale, factors = np.log(-np.log(known[::-1])), np.log(list(_RELIABILITY.values())[::-1])
    return float(np.exp(np.interp(math.log(-math.log(given)), scale, factors)))
