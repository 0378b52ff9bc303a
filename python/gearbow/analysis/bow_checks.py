"""Margins of the limits of a bow: each is positive below its limit, over phases and instants."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, TypeVar

import numpy as np

from gearbow._core import mesh_geometry
from gearbow._types import Array, MeshGeometry
from gearbow.analysis.bow_motion import BowMotion, BowSignal, Variants
from gearbow.analysis.protocol import variant
from gearbow.description.bow_limit import DISPLACEMENTS, VELOCITIES, BowLimit
from gearbow.description.gears import Gear, Mesh
from gearbow.description.journal import JournalBearing
from gearbow.description.loads import Bearing
from gearbow.description.places import Places, place_label
from gearbow.description.rolling import RollingBearing
from gearbow.description.supports import Support
from gearbow.errors import ChannelError, GearbowError
from gearbow.results.response import Response

__all__ = ["Check", "added_check", "mesh_checks", "mesh_rows"]

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
#: Stiffnesses [N/m] whose difference gives the direction of a mesh in the coordinates.
_SOFT, _STIFF = 1e8, 2e8


_Kind = TypeVar("_Kind", JournalBearing, RollingBearing)


@dataclass(frozen=True, eq=False)
class Check:
    """A limit with its margin as a function of the bow [m]; without one, `why` is the reason."""

    limit: str
    at: str
    why: str
    margin: Callable[[float], Array] | None = None
    #: First and largest bow of the search, and what ends it.
    first: float = 0.0
    most: float = math.inf
    beyond: str = ""
    #: Margin of one period of a steady state, in place of `margin`. It is sought up to `stretch`
    #: times the bow at which `proxy` ends in the linear motion, with the worst phase for `proxy`.
    steady: Callable[[Response], float] | None = None
    proxy: Callable[[float], Array] | None = None
    stretch: float = 1.0


def mesh_rows(variants: Variants) -> dict[tuple[str, str], Array]:
    """Give the gradient of each mesh deflection in all coordinates, up to its sign."""
    # The stiffness matrix contains k g gᵀ for a mesh: two stiffnesses k give g, with tilts and
    # axial displacements of helical teeth.
    base = variants.base
    # Bearings without equilibrium: their stiffness must not depend on that of the mesh.
    plain = [
        Bearing(
            each.shaft,
            each.position,
            stiffness=1.0,
            axial_stiffness=each.axial_stiffness,
            support=each.support,
        )
        for each in base.bearings
    ]
    free = {"bearings": plain, "torques": [], "forces": [], "gravity": None, "modal_damping": None}
    rows = {}
    for mesh in base.meshes:
        stiffness = [
            variant(base, **free, meshes=_with_stiffness(base.meshes, mesh, k))._model.matrices()
            for k in (_SOFT, _STIFF)
        ]
        part = (stiffness[1]["stiffness"] - stiffness[0]["stiffness"]) / (_STIFF - _SOFT)
        largest = int(np.argmax(np.diag(part)))
        rows[mesh.driver, mesh.driven] = part[largest] / math.sqrt(part[largest, largest])
    return rows


def _with_stiffness(meshes: tuple[Mesh, ...], changed: Mesh, stiffness: float) -> list[Mesh]:
    return [
        replace(mesh, stiffness=stiffness, tip_relief=None) if mesh is changed else mesh
        for mesh in meshes
    ]


@dataclass(frozen=True, eq=False)
class _Teeth:
    """Geometry of a mesh, and its centres in motion."""

    mesh: Mesh
    gears: tuple[Gear, Gear]
    geometry: MeshGeometry
    centres: BowSignal

    @property
    def at(self) -> str:
        return f"{self.mesh.driver}/{self.mesh.driven}"

    def distance(self, bow: float) -> Array:
        """Give the centre distance [m], (phases, instants)."""
        angle, rest = self.mesh.centre_line_angle, self.geometry["centre_distance"]
        moved = self.centres.at(bow) + rest * np.array([math.cos(angle), math.sin(angle)])
        distance: Array = np.hypot(moved[..., 0], moved[..., 1])
        return distance

    def tangent(self, bow: float) -> Array:
        """Give C sin α [m], zero where the base circles overlap."""
        squares = self.distance(bow) ** 2 - sum(self.geometry["base_radii"]) ** 2
        tangent: Array = np.sqrt(np.maximum(squares, 0.0))
        return tangent

    @property
    def base_helix_cosine(self) -> float:
        """Cosine of the helix angle on the base cylinder."""
        gear = self.gears[0]
        return math.sqrt(1.0 - (math.sin(gear.helix_angle) * math.cos(gear.pressure_angle)) ** 2)

    @property
    def reach(self) -> tuple[float, float]:
        """√(tip radius² − base radius²) of both gears [m]."""
        radii = zip(self.geometry["tip_radii"], self.geometry["base_radii"], strict=True)
        first, second = (math.sqrt(tip**2 - base**2) for tip, base in radii)
        return first, second

    def gap(self, bow: float, deflection: BowSignal) -> Array:
        """Give the distance of the back flanks along the line of action [m]."""
        total = sum(self.geometry["base_radii"])
        slope, rest = self.tangent(bow) / total, math.tan(self.geometry["pressure_angle"])
        longer = total * (slope - np.arctan(slope) - rest + math.atan(rest))
        left: Array = (
            (self.mesh.backlash or 0.0)
            + deflection.at(bow)[..., 0]
            + 2.0 * self.base_helix_cosine * longer
        )
        return left

    def tips(self, bow: float) -> Array:
        """Give the smaller clearance of a tip and the root of the other gear [m]."""
        tips, roots = self.geometry["tip_radii"], self.geometry["root_radii"]
        return self.distance(bow) - max(tips[0] + roots[1], tips[1] + roots[0])

    def involutes(self, bow: float) -> Array:
        """Give the distance of the tips from the ends of the involutes along the path [m]."""
        return self.tangent(bow) - max(self.reach)

    def contact_ratio(self, bow: float) -> Array:
        """Give the contact ratio, of helical teeth the total one."""
        tangent, (first, second) = self.tangent(bow), self.reach
        path = np.minimum(first, tangent) - np.maximum(tangent - second, 0.0)
        width = min(gear.face_width or 0.0 for gear in self.gears)
        sine = abs(math.sin(self.gears[0].helix_angle)) * math.cos(self.gears[0].pressure_angle)
        pitch = 2.0 * math.pi * self.geometry["base_radii"][0] / self.gears[0].teeth
        ratio: Array = (path + width * sine / self.base_helix_cosine) / pitch
        return ratio


def _teeth(motion: BowMotion) -> dict[tuple[str, str], _Teeth]:
    """Give the teeth of every mesh."""
    base = motion.variants.base
    gears = {gear.name: gear for gear in base.gears}
    return {
        (mesh.driver, mesh.driven): _Teeth(
            mesh,
            (gears[mesh.driver], gears[mesh.driven]),
            geometry,
            motion.displacement(mesh.driven) - motion.displacement(mesh.driver),
        )
        for mesh, geometry in zip(base.meshes, mesh_geometry(base.description), strict=True)
    }


def mesh_checks(motion: BowMotion, rows: Mapping[tuple[str, str], Array]) -> Iterator[Check]:
    """Give the limits that every mesh has."""
    for pair, teeth in _teeth(motion).items():
        backlash = teeth.mesh.backlash
        if backlash is None:
            yield Check("backlash used up", teeth.at, "the mesh has no backlash")
        else:
            gap = partial(teeth.gap, deflection=_deflection(motion, teeth, rows[pair]))
            why = f"back flanks touch: backlash {1e6 * backlash:.4g} µm"
            yield _geometric("backlash used up", teeth, gap, why)
        yield _geometric("tips touch roots", teeth, teeth.tips, "tip and root circles touch")
        why = "a tip reaches the base circle of the other gear"
        yield _geometric("involutes end", teeth, teeth.involutes, why)
        yield _ratio_check(teeth, 1.0)


def _ratio_check(teeth: _Teeth, least: float) -> Check:
    """Give the limit of the contact ratio."""
    why = f"contact ratio below {least:g}"
    return _geometric("contact ratio", teeth, lambda bow: teeth.contact_ratio(bow) - least, why)


def _geometric(limit: str, teeth: _Teeth, margin: Callable[[float], Array], why: str) -> Check:
    """Give a limit of the centre distance, sought until the base circles overlap."""
    moved = teeth.centres.size
    shortest = teeth.geometry["centre_distance"] - sum(teeth.geometry["base_radii"])
    if moved < _MIN_MOTION:
        why = f"the bow moves these gears by less than {_MIN_MOTION:g} of its size"
        return Check(limit, teeth.at, why)
    most = shortest / moved
    return Check(limit, teeth.at, why, margin, most / 2**_STEPS, most, "the base circles overlap")


def _deflection(motion: BowMotion, teeth: _Teeth, row: Array) -> BowSignal:
    """Give the mesh deflection of the drive flanks [m]."""
    base, driver = motion.variants.base, teeth.gears[0]
    state = motion.static.mesh((teeth.mesh.driver, teeth.mesh.driven))
    spin = float(base.speed_ratios[[each.name for each in base.shafts].index(driver.shaft)])
    try:
        turn = row[base.coordinates.twist(driver.name)]
    except GearbowError:  # without twist, the mesh moves the flanks apart only
        turn = 0.0
    sense = math.copysign(1.0, spin * (motion.speed or 1.0))
    return motion.combined(state.deflection, row * sense * math.copysign(1.0, turn))


def added_check(motion: BowMotion, limit: BowLimit, rows: Mapping[tuple[str, str], Array]) -> Check:
    """Give the check of a limit that the user adds."""
    if limit.kind == "mesh_force":
        return _mesh_force(motion, limit, rows)
    kind: Callable[[BowMotion, BowLimit], Check] = {
        "displacement": _displacement,
        "velocity": _velocity,
        "contact_ratio": _contact_ratio,
        "bearing_force": _bearing_force,
        "bearing_life": _bearing_life,
        "film": _film,
        "clearance": _clearance,
    }[limit.kind]
    return kind(motion, limit)


def _towards(limit: BowLimit) -> Array:
    """Give the unit vectors of the direction of a limit, or of all directions, (2, d)."""
    angles = math.pi * np.arange(_DIRECTIONS) / _DIRECTIONS if limit.angle is None else limit.angle
    return np.array([np.cos(np.atleast_1d(angles)), np.sin(np.atleast_1d(angles))])


def _linear(
    limit: BowLimit, why: str, signal: BowSignal, allowed: float, value: Callable[[Array], Array]
) -> Check:
    """Give a limit of a signal that grows with the bow without end."""
    name, at = limit.kind.replace("_", " "), place_label(limit.at)
    if signal.size == 0.0:
        return Check(name, at, "the bow does not move this place")

    def margin(bow: float) -> Array:
        return allowed - value(signal.at(bow))

    return Check(name, at, why, margin, allowed / signal.size)


def _displacement(motion: BowMotion, limit: BowLimit) -> Check:
    signal = motion.displacement(limit.at)
    if limit.support is not None:
        signal = signal - motion.displacement(limit.support)
    why, given = "peak-to-peak", limit.value
    if isinstance(given, str):
        turns = 30.0 / math.pi * abs(motion.speed * _ratio(motion, limit.at))
        factor, largest = DISPLACEMENTS[given]
        allowed, why = min(factor / math.sqrt(turns) if turns else math.inf, largest), given
    else:
        allowed = given
    directions = _towards(limit)
    return _linear(
        limit,
        f"{1e6 * allowed:.4g} µm {why}",
        signal,
        allowed,
        lambda values: np.ptp(values @ directions, axis=1).max(axis=-1),
    )


def _ratio(motion: BowMotion, at: Any) -> float:
    """Give the speed ratio of the shaft of a place; that of the bowed one for a housing."""
    base = motion.variants.base
    names = [shaft.name for shaft in base.shafts]
    own = base.coordinates.shaft(at)
    return float(base.speed_ratios[names.index(own if own in names else motion.variants.shafts[0])])


def _velocity(motion: BowMotion, limit: BowLimit) -> Check:
    given = limit.value
    allowed, why = (VELOCITIES[given], given) if isinstance(given, str) else (given, "RMS")
    directions = _towards(limit)
    return _linear(
        limit,
        f"{1e3 * allowed:.4g} mm/s {why}",
        motion.velocity(limit.at),
        allowed,
        lambda values: np.sqrt(np.mean((values @ directions) ** 2, axis=1)).max(axis=-1),
    )


def _contact_ratio(motion: BowMotion, limit: BowLimit) -> Check:
    return _ratio_check(_mesh(motion, limit), float(limit.value))


def _mesh(motion: BowMotion, limit: BowLimit) -> _Teeth:
    motion.static.mesh(limit.at)  # an unknown mesh is an error that lists the known ones
    teeth = _teeth(motion)
    return teeth[limit.at] if limit.at in teeth else teeth[limit.at[::-1]]


def _bearing_force(motion: BowMotion, limit: BowLimit) -> Check:
    allowed = float(limit.value)
    return _linear(
        limit,
        f"{allowed:.4g} N",
        motion.bearing_force(limit.at),
        allowed,
        lambda values: np.hypot(values[..., 0], values[..., 1]),
    )


def _bearing_life(motion: BowMotion, limit: BowLimit) -> Check:
    hours, power = float(limit.value), limit.exponent or math.nan
    turns = 60.0 * hours * 30.0 / math.pi * abs(motion.speed * _ratio(motion, limit.at))
    allowed = (limit.capacity or math.nan) * (1e6 / turns) ** (1.0 / power) if turns else math.inf
    why = f"life {hours:g} h: mean force {allowed:.4g} N"

    def mean_force(values: Array) -> Array:
        forces = np.hypot(values[..., 0], values[..., 1])
        mean: Array = np.mean(forces**power, axis=1) ** (1.0 / power)
        return mean

    if math.isinf(allowed):
        return Check("bearing life", place_label(limit.at), "the shaft does not turn")
    return _linear(limit, why, motion.bearing_force(limit.at), allowed, mean_force)


def _mesh_force(motion: BowMotion, limit: BowLimit, rows: Mapping[tuple[str, str], Array]) -> Check:
    teeth, factor = _mesh(motion, limit), float(limit.value)
    static = abs(motion.static.mesh(limit.at).force)
    if static == 0.0:
        return Check("mesh force", teeth.at, "the mesh carries no static force")
    why = f"{factor:g} times the static {static:.4g} N"
    ends, beyond = teeth.tips, "tips touch roots"
    if teeth.mesh.backlash is not None:
        # Where both flanks are in contact, the recorded force is the difference of theirs.
        row = rows[teeth.mesh.driver, teeth.mesh.driven]
        ends = partial(teeth.gap, deflection=_deflection(motion, teeth, row))
        beyond = "back flanks touch"
    found = _geometric("mesh force", teeth, ends, why)
    if found.margin is None:
        return found

    def margin(period: Response) -> float:
        return factor - float(np.abs(period.mesh(limit.at).force).max()) / static

    return replace(found, margin=None, proxy=found.margin, steady=margin, beyond=beyond)


def _bearing(motion: BowMotion, limit: BowLimit, kind: type[_Kind]) -> _Kind:
    """Give the bearing of a limit."""
    for each in motion.variants.base.bearings:
        here = Places("bearing", [[(each.shaft, each.position)]]).find(limit.at) == 0
        if isinstance(each, kind) and here:
            return each
    raise ChannelError(
        f"limits: the bearing at {place_label(limit.at)} is no {kind.__name__}, which the limit "
        f"{limit.kind!r} needs"
    )


def _clearance(motion: BowMotion, limit: BowLimit) -> Check:
    motion.static.bearing_force(limit.at)  # an unknown bearing is an error that lists the known
    bearing, approach = _bearing(motion, limit, RollingBearing), float(limit.value)
    signal = motion.displacement(limit.at)
    support = bearing.support
    name = support.name if isinstance(support, Support) else support
    if support is not None and name is None:
        raise GearbowError(
            f"limits: the support of the bearing at {place_label(limit.at)} has no name, so that "
            "its motion is unknown; give Support(name=)"
        )
    if name is not None:
        signal = signal - motion.displacement(name)
    allowed = bearing.clearance / 2.0 + approach
    return _linear(
        limit,
        f"{1e6 * allowed:.4g} µm: gap and {1e6 * approach:.4g} µm of approach",
        signal,
        allowed,
        lambda values: np.hypot(values[..., 0], values[..., 1]),
    )


def _film(motion: BowMotion, limit: BowLimit) -> Check:
    motion.static.journal(limit.at)  # an unknown journal bearing is an error that lists the known
    clearance = _bearing(motion, limit, JournalBearing).clearance
    thickness = float(limit.value)
    signal = motion.displacement(limit.at)

    def margin(period: Response) -> float:
        moved = period.bearing_displacement(limit.at)
        return clearance - float(np.hypot(moved[:, 0], moved[:, 1]).max()) - thickness

    found = _linear(
        limit,
        f"thickness {1e6 * thickness:.4g} µm",
        signal,
        clearance,
        lambda values: np.hypot(values[..., 0], values[..., 1]),
    )
    if found.margin is None:
        return found
    # The film stiffens towards the wall: the linear motion is no bound, only a scale.
    found = replace(found, beyond=f"{_STRETCH:g} times that of the linear motion", stretch=_STRETCH)
    return replace(found, margin=None, proxy=found.margin, steady=margin)
