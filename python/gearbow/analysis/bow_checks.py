"""Margins of the limits of a bow: each is positive below its limit, over phases and instants."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from gearbow._core import mesh_geometry
from gearbow._types import Array, MeshGeometry
from gearbow.analysis.bow_motion import BowMotion, BowSignal, Margin
from gearbow.description.bow import VELOCITIES, BowLimit, largest_displacement
from gearbow.description.gears import Gear, Mesh
from gearbow.description.journal import JournalBearing, TiltingPadBearing
from gearbow.description.layout import ratios_by_shaft
from gearbow.description.load_rating import load_for_hours, rating_of, ring_ratios
from gearbow.description.loads import AnyBearing, Bearing
from gearbow.description.places import Places, Support, housing_and_interface, place_label
from gearbow.description.rolling import RollingBearing
from gearbow.errors import ChannelError, GearbowError, SceneError
from gearbow.results.response import Response
from gearbow.results.stresses import Strength, equivalent, notch_at, of_tones

#: Directions in which the largest vibration is sought, over half a turn; a maximum between two of
#: them is missed by at most 1 − cos(π/72) = 0.1 %.
_DIRECTIONS = 36
#: Number of doubled steps in which a limit is sought up to the largest bow.
_STEPS = 8
#: Smallest displacement of gear centres relative to the bow that counts as motion.
_MIN_MOTION = 1e-3
#: Largest bow at which an oil film is examined, over that at which the journal touches in the
#: linear motion.
_STRETCH = 16.0
#: Bow [m] from which the utilisation of a section is extrapolated.
_SMALL_BOW = 1e-6
#: Difference of positions [m] for slopes of the margins of teeth.
_DIFFERENCE = 1e-6
#: Steps to the instant of the smallest margin of teeth; the limits of random helical trains did not
#: change after the first one.
_LINEAR_STEPS = 3

_Kind = TypeVar("_Kind", bound=AnyBearing)


@dataclass(frozen=True, eq=False)
class Check:
    """A limit with its margin as a function of the bow [m]; without one, `why` is the reason."""

    limit: str
    at: str
    why: str
    margin: Margin | None = None
    #: Whether the margin is the smallest one of single instants. Phases of NaN then stand for all.
    of_instants: bool = False
    #: First and largest bow of the search, and what ends it.
    first: float = 0.0
    most: float = math.inf
    beyond: str = ""
    #: Margin of one period of a steady state, in place of `margin`. It is sought up to `stretch`
    #: times the bow at which `proxy` ends in the linear motion, with the worst phase for `proxy`.
    steady: Callable[[Response], float] | None = None
    proxy: Margin | None = None
    stretch: float = 1.0


@dataclass(frozen=True, eq=False)
class _Teeth:
    """Geometry of a mesh, and the motion of its teeth; methods take values of it, (..., 3)."""

    mesh: Mesh
    gears: tuple[Gear, Gear]
    geometry: MeshGeometry
    #: Displacement of the base circle of the driven gear relative to that of the driver along y and
    #: z, and deflection of the drive flanks without transmission error [m], three components.
    motion: BowSignal

    @property
    def at(self) -> str:
        return f"{self.mesh.driver}/{self.mesh.driven}"

    @property
    def base_circles(self) -> float:
        """Sum of the base radii [m]; negative if a gear is internal."""
        return sum(self.geometry["base_radii"])

    def distance(self, values: Array) -> Array:
        """Give the centre distance [m]."""
        angle, rest = self.mesh.centre_line_angle, self.geometry["centre_distance"]
        moved = values[..., :2] + rest * np.array([math.cos(angle), math.sin(angle)])
        distance: Array = np.hypot(moved[..., 0], moved[..., 1])
        return distance

    def tangent(self, values: Array) -> Array:
        """Give C sin α [m], zero where the base circles overlap; negative if a gear is internal."""
        squares = self.distance(values) ** 2 - self.base_circles**2
        tangent: Array = np.copysign(np.sqrt(np.maximum(squares, 0.0)), self.base_circles)
        return tangent

    @property
    def base_helix_cosine(self) -> float:
        """Cosine of the helix angle on the base cylinder."""
        gear = self.gears[0]
        return math.sqrt(1.0 - (math.sin(gear.helix_angle) * math.cos(gear.pressure_angle)) ** 2)

    @property
    def reach(self) -> tuple[float, float]:
        """√(tip radius² − base radius²) of both gears [m]; negative for an internal gear."""
        radii = zip(self.geometry["tip_radii"], self.geometry["base_radii"], strict=True)
        first, second = (math.copysign(math.sqrt(tip**2 - base**2), tip) for tip, base in radii)
        return first, second

    def gap(self, values: Array) -> Array:
        """Give the distance of the back flanks along the line of action [m]."""
        total = self.base_circles
        slope, rest = self.tangent(values) / total, math.tan(self.geometry["pressure_angle"])
        longer = total * (slope - np.arctan(slope) - rest + math.atan(rest))
        backlash = self.mesh.backlash or 0.0
        left: Array = backlash + values[..., 2] + 2.0 * self.base_helix_cosine * longer
        return left

    def tips(self, values: Array) -> Array:
        """Give the smaller clearance of a tip and the root of the other gear [m]."""
        tips, roots = self.geometry["tip_radii"], self.geometry["root_radii"]
        distance = np.copysign(self.distance(values), self.base_circles)
        clearance: Array = distance - max(tips[0] + roots[1], tips[1] + roots[0])
        return clearance

    def involutes(self, values: Array) -> Array:
        """Give the distance of the tips from the ends of the involutes along the path [m]."""
        reach = max(self.reach) if self.base_circles > 0.0 else min(self.reach)
        return self.tangent(values) - reach

    def contact_ratio(self, values: Array) -> Array:
        """Give the contact ratio, of helical teeth the total one."""
        tangent, (first, second) = self.tangent(values), self.reach
        if self.base_circles > 0.0:
            path = np.minimum(first, tangent) - np.maximum(tangent - second, 0.0)
        else:
            path = max(self.reach) - np.maximum(tangent - min(self.reach), 0.0)
        width = min(gear.face_width or 0.0 for gear in self.gears)
        sine = abs(math.sin(self.gears[0].helix_angle)) * math.cos(self.gears[0].pressure_angle)
        pitch = 2.0 * math.pi * abs(self.geometry["base_radii"][0]) / self.gears[0].teeth
        ratio: Array = (path + width * sine / self.base_helix_cosine) / pitch
        return ratio

    def smallest(self, value: Callable[[Array], Array], bow: float, phases: Array) -> Array:
        """Find the smallest value over all instants, (phases,)."""
        # The values are nearly linear in the motion: the instant with the smallest linear part of
        # each group, about the last point, is that of the smallest value after one or two steps.
        # The contact ratio may fall towards both sides.
        rest, curves = self.motion.static, self.motion.curves(bow, phases)
        size = phases.shape[0]
        found = np.broadcast_to(value(rest), (size,))
        for sign in (1.0, -1.0):
            slope = sign * _gradient(value, np.broadcast_to(rest, (size, 3)))
            for _ in range(_LINEAR_STEPS):
                at = rest + sum(_lowest(curve, slope) for curve in curves)
                found, slope = np.minimum(found, value(at)), _gradient(value, at)
        return found


def _gradient(value: Callable[[Array], Array], at: Array) -> Array:
    """Differentiate a value at points (k, 3), by differences."""
    steps = _DIFFERENCE * np.eye(3)
    gradient: Array = value(at[:, None] + steps) - value(at[:, None] - steps)
    return gradient


def _lowest(curve: Array, slope: Array) -> Array:
    """Give the instant of a curve (k or 1, instants, 3) with the smallest component, (k, 3)."""
    index = np.einsum("kic,kc->ki", np.broadcast_to(curve, (len(slope), *curve.shape[1:])), slope)
    lowest: Array = curve[np.arange(len(slope)) % len(curve), index.argmin(axis=1)]
    return lowest


def mesh_teeth(motion: BowMotion) -> dict[tuple[str, str], _Teeth]:
    """Give the teeth of the meshes that a bow moves: none with a carrier that turns."""
    base = motion.variants.base
    gears = {gear.name: gear for gear in base.gears}
    gradients = base._model.mesh_gradients(motion.speed)
    return {
        (mesh.driver, mesh.driven): _Teeth(
            mesh,
            (gears[mesh.driver], gears[mesh.driven]),
            geometry,
            _motion(motion, (gears[mesh.driver], gears[mesh.driven]), gradient),
        )
        for mesh, geometry, gradient in zip(
            base.meshes, mesh_geometry(base.description), gradients, strict=True
        )
        if mesh.carrier is None
    }


def _motion(motion: BowMotion, gears: tuple[Gear, Gear], gradient: Array) -> BowSignal:
    """Give the motion of the base circles and the deflection of a mesh."""
    base = motion.variants.base
    rows = np.zeros((3, gradient.size))
    rows[2] = gradient
    runout = np.zeros((len(base.shafts), 3), dtype=np.complex128)
    names = [shaft.name for shaft in base.shafts]
    for sign, gear in zip((-1.0, 1.0), gears, strict=True):
        lateral = base.coordinates.lateral(gear.name)
        rows[[0, 1], lateral] += sign
        turning = gear.runout * np.array([1.0, -1j])
        added = np.array([*(sign * turning), gradient[lateral] @ turning])
        runout[names.index(gear.shaft)] += added
    driver, driven = (motion.static.displacement(gear.name) for gear in gears)
    deflection = motion.static.mesh((gears[0].name, gears[1].name)).deflection
    return motion.rows(np.array([*(driven - driver), deflection]), rows, runout)


def mesh_checks(teeth: Iterable[_Teeth]) -> Iterator[Check]:
    """Give the limits that every mesh has."""
    for each in teeth:
        backlash = each.mesh.backlash
        if backlash is None:
            yield Check("backlash used up", each.at, "the mesh has no backlash")
        else:
            why = f"back flanks touch: backlash {1e6 * backlash:.4g} µm"
            yield _geometric("backlash used up", each, each.gap, why)
        yield _geometric("tips touch roots", each, each.tips, "tip and root circles touch")
        why = "a tip reaches the base circle of the other gear"
        yield _geometric("involutes end", each, each.involutes, why)
        yield _ratio_check(each, 1.0)


def _ratio_check(teeth: _Teeth, least: float) -> Check:
    """Give the limit of the contact ratio."""
    why = f"contact ratio below {least:g}"
    return _geometric("contact ratio", teeth, lambda at: teeth.contact_ratio(at) - least, why)


def _geometric(limit: str, teeth: _Teeth, value: Callable[[Array], Array], why: str) -> Check:
    """Give a limit of the motion of the teeth, sought until the base circles overlap."""
    moved = sum(float(np.abs(unit[:, :2]).max()) for unit in teeth.motion.units)
    shortest = teeth.geometry["centre_distance"] - abs(teeth.base_circles)
    if moved < _MIN_MOTION:
        why = f"the bow moves these gears by less than {_MIN_MOTION:g} of its size"
        return Check(limit, teeth.at, why)
    most = shortest / moved

    def margin(bow: float, phases: Array) -> Array:
        return teeth.smallest(value, bow, phases)

    beyond = "the base circles overlap"
    return Check(limit, teeth.at, why, margin, True, most / 2**_STEPS, most, beyond)


def added_check(
    motion: BowMotion, limit: BowLimit, teeth: Mapping[tuple[str, str], _Teeth]
) -> Check:
    """Give the check of a limit that the user adds."""
    if limit.kind in ("mesh_force", "contact_ratio"):
        motion.static.mesh(limit.at)  # an unknown mesh is an error that lists the known ones
        own = teeth.get(limit.at) or teeth.get(limit.at[::-1])
        if own is None:
            raise SceneError(
                f"limits: a bow does not move the mesh {'/'.join(limit.at)}, whose "
                "carrier turns; give a mesh of gears on fixed axes"
            )
        if limit.kind == "contact_ratio":
            return _ratio_check(own, float(limit.value))
        return _mesh_force(motion, limit, own)
    kind: Callable[[BowMotion, BowLimit], Check] = {
        "displacement": _displacement,
        "velocity": _velocity,
        "bearing_force": _bearing_force,
        "bearing_life": _bearing_life,
        "stress": _stress,
        "film": _film,
        "clearance": _clearance,
    }[limit.kind]
    return kind(motion, limit)


def _towards(limit: BowLimit) -> Array:
    """Give the unit vectors of the direction of a limit, or of all directions, (2, d)."""
    angles = math.pi * np.arange(_DIRECTIONS) / _DIRECTIONS if limit.angle is None else limit.angle
    return np.array([np.cos(np.atleast_1d(angles)), np.sin(np.atleast_1d(angles))])


def _linear(
    limit: BowLimit,
    why: str,
    signal: BowSignal,
    allowed: float,
    value: Margin,
    *,
    of_instants: bool = False,
) -> Check:
    """Give a limit of a signal that grows with the bow without end."""
    name, at = limit.kind.replace("_", " "), place_label(limit.at)
    if signal.size == 0.0:
        return Check(name, at, "the bow does not move this place")

    def margin(bow: float, phases: Array) -> Array:
        return allowed - value(bow, phases)

    return Check(name, at, why, margin, of_instants, allowed / signal.size)


def _radius(signal: BowSignal) -> Margin:
    """Give the largest distance from the origin as a function of bow and phases."""
    angles = math.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    directions = np.array([np.cos(angles), np.sin(angles)])
    return lambda bow, phases: signal.largest(bow, phases, directions)


def _displacement(motion: BowMotion, limit: BowLimit) -> Check:
    signal = motion.displacement(limit.at)
    if limit.support is not None:
        signal = motion.relative(limit.at, limit.support)
    why, given = "peak-to-peak", limit.value
    if isinstance(given, str):
        speed = motion.speed * _ratio(motion, limit.at)
        allowed, why = largest_displacement(given, speed), given
    else:
        allowed = given
    directions = _towards(limit)

    def spread(bow: float, phases: Array) -> Array:
        # Groups turn independently: their peak-to-peak values along a direction add up.
        curves = signal.curves(bow, phases)
        along: Array = sum(np.ptp(curve @ directions, axis=1) for curve in curves)
        largest: Array = along.max(axis=-1)
        return largest

    return _linear(limit, f"{1e6 * allowed:.4g} µm {why}", signal, allowed, spread)


def _ratio(motion: BowMotion, at: Any) -> float:
    """Give the speed ratio of the shaft of a place; that of the bowed one for a housing."""
    base = motion.variants.base
    ratios = ratios_by_shaft(base)
    return ratios.get(base.coordinates.shaft(at), ratios[motion.variants.shafts[0]])


def _velocity(motion: BowMotion, limit: BowLimit) -> Check:
    given = limit.value
    allowed, why = (VELOCITIES[given], given) if isinstance(given, str) else (given, "RMS")
    directions, signal = _towards(limit), motion.velocity(limit.at)

    def rms(bow: float, phases: Array) -> Array:
        curves = signal.curves(bow, phases)
        squares = sum(np.mean((curve @ directions) ** 2, axis=1) for curve in curves)
        largest: Array = np.sqrt(squares).max(axis=-1)
        return largest

    return _linear(limit, f"{1e3 * allowed:.4g} mm/s {why}", signal, allowed, rms)


def _bearing_force(motion: BowMotion, limit: BowLimit) -> Check:
    allowed, signal = float(limit.value), motion.bearing_force(limit.at)
    return _linear(limit, f"{allowed:.4g} N", signal, allowed, _radius(signal), of_instants=True)


def _bearing_life(motion: BowMotion, limit: BowLimit) -> Check:
    signal = motion.bearing_force(limit.at)  # an unknown bearing is an error that lists the known
    bearing = _bearing(motion, limit, (Bearing, JournalBearing, TiltingPadBearing, RollingBearing))
    rating = rating_of(bearing)
    capacity, power = limit.capacity, limit.exponent
    if rating is not None:
        capacity, power = capacity or rating.dynamic, power or rating.exponent
    if capacity is None or power is None:
        raise GearbowError(
            f"limits: the bearing at {place_label(limit.at)} has no dynamic rating; give capacity= "
            "and exponent=, or dynamic_rating= of the bearing"
        )
    inner, outer = ring_ratios(bearing, ratios_by_shaft(motion.variants.base))
    hours, speed = float(limit.value), motion.speed * (inner - outer)
    allowed = load_for_hours(hours, speed, capacity, power)
    thrust = motion.static.axial_bearing_force(limit.at)

    def mean_load(bow: float, phases: Array) -> Array:
        values = signal.instants(bow, phases)
        loads = np.hypot(values[..., 0], values[..., 1])
        if rating is not None:
            loads = rating.equivalent_load(loads, thrust)
        mean: Array = np.mean(loads**power, axis=1) ** (1.0 / power)
        return mean

    if math.isinf(allowed):
        return Check("bearing life", place_label(limit.at), "the rings turn together")
    why = f"life {hours:g} h: mean load {allowed:.4g} N"
    return _linear(limit, why, signal, allowed, mean_load)


def _stress(motion: BowMotion, limit: BowLimit) -> Check:
    sections, tones = motion.forces_in_sections(limit.at)
    (shaft, x, _), base = sections[0], motion.variants.base
    given = (limit.value, limit.tensile_strength, limit.line)
    strength = Strength.of([shaft], *given)  # type: ignore[arg-type]
    notch = notch_at(base.notches, shaft, x)
    factors = [each for _, each in base._model.sections(shaft, [x])]

    def margin(bow: float, phases: Array) -> Array:
        def _use(turned: Array) -> float:
            found = tones(bow, turned)
            fibres = (of_tones(found, k, each) for k, each in enumerate(factors))
            return max(float(equivalent(f, shaft, notch, strength)[2].max()) for f in fibres)

        return np.array([1.0 - _use(turned) for turned in phases])

    name = place_label(limit.at)
    nothing = np.zeros((1, len(motion.variants.shafts)))
    # The utilisation by the bow alone is about proportional to it: the search begins at its limit.
    unit = margin(0.0, nothing)[0] - margin(_SMALL_BOW, nothing)[0]
    if unit <= 0.0:
        return Check("stress", name, "the bow does not load this section")
    why = f"endurance limit {1e-6 * float(limit.value):.4g} MPa"
    return Check("stress", name, why, margin, first=_SMALL_BOW / unit)


def _mesh_force(motion: BowMotion, limit: BowLimit, teeth: _Teeth) -> Check:
    factor, static = float(limit.value), abs(motion.static.mesh(limit.at).force)
    if static == 0.0:
        return Check("mesh force", teeth.at, "the mesh carries no static force")
    why = f"{factor:g} times the static {static:.4g} N"
    ends, beyond = teeth.tips, "tips touch roots"
    if teeth.mesh.backlash is not None:
        # Where both flanks are in contact, the recorded force is the difference of theirs.
        ends, beyond = teeth.gap, "back flanks touch"
    found = _geometric("mesh force", teeth, ends, why)
    if found.margin is None:
        return found

    def margin(period: Response) -> float:
        return factor - float(np.abs(period.mesh(limit.at).force).max()) / static

    return replace(found, margin=None, proxy=found.margin, steady=margin, beyond=beyond)


def _bearing(
    motion: BowMotion, limit: BowLimit, kind: type[_Kind] | tuple[type[_Kind], ...]
) -> _Kind:
    for each in motion.variants.base.bearings:
        here = Places("bearing", [[(each.shaft, each.position)]]).find(limit.at) == 0
        if isinstance(each, kind) and here:
            return each
    wanted = kind.__name__ if isinstance(kind, type) else "bearing"
    raise ChannelError(
        f"limits: the bearing at {place_label(limit.at)} is no {wanted}, which the limit "
        f"{limit.kind!r} needs"
    )


def _clearance(motion: BowMotion, limit: BowLimit) -> Check:
    motion.static.bearing_force(limit.at)  # an unknown bearing is an error that lists the known
    bearing, approach = _bearing(motion, limit, RollingBearing), float(limit.value)
    signal = motion.displacement(limit.at)
    support = bearing.support
    seat = housing_and_interface(support)
    name: Any = support.name if isinstance(support, Support) else support
    name = name if seat is None else seat[1]
    if support is not None and name is None:
        raise GearbowError(
            f"limits: the support of the bearing at {place_label(limit.at)} has no name, so that "
            "its motion is unknown; give Support(name=)"
        )
    if name is not None:
        signal = motion.relative(limit.at, name)
    if bearing.clearance is None:
        raise GearbowError(
            f"limits: the clearance of the bearing at {place_label(limit.at)} is unknown; give "
            "RollingBearing(clearance=)"
        )
    allowed = bearing.clearance / 2.0 + approach
    why = f"{1e6 * allowed:.4g} µm: gap and {1e6 * approach:.4g} µm of approach, linear motion"
    return _linear(limit, why, signal, allowed, _radius(signal), of_instants=True)


def _film(motion: BowMotion, limit: BowLimit) -> Check:
    motion.static.journal(limit.at)  # an unknown journal bearing is an error that lists the known
    bearing = _bearing(motion, limit, JournalBearing)
    clearance = bearing.clearance
    if bearing.pads is not None or bearing.profile not in (None, "plain", "two axial grooves"):
        raise SceneError(
            f"limits: the thickness of a film is known for a cylindrical bore, and the bearing at "
            f"{limit.at} has lobes; limit the displacement of its shaft"
        )
    thickness = float(limit.value)
    signal = motion.displacement(limit.at)

    def margin(period: Response) -> float:
        moved = period.bearing_displacement(limit.at)
        return clearance - float(np.hypot(moved[:, 0], moved[:, 1]).max()) - thickness

    why = f"thickness {1e6 * thickness:.4g} µm"
    found = _linear(limit, why, signal, clearance, _radius(signal), of_instants=True)
    if found.margin is None:
        return found
    # The film stiffens towards the wall: the linear motion is no bound, only a scale.
    found = replace(found, beyond=f"{_STRETCH:g} times that of the linear motion", stretch=_STRETCH)
    return replace(found, margin=None, proxy=found.margin, steady=margin)
