"""What follows from the parts alone: outlines at rest, frequencies, excitations, assumptions.

A shaft at the speed r_s Ω excites the harmonics n |r_s|. A mesh excites the harmonics m z |r_s| of
its tooth frequency. A shaft modulates the mesh force; this gives the sidebands m z |r| ± n |r_s|
(Randall, *A new method of modeling gear faults*, J. Mech. Design 104, 1982). A force that turns
with n times the angle of its shaft excites n |r_s|, where n need not be a whole number.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Protocol

import numpy as np

from gearbow._convert import whole
from gearbow._core import Model
from gearbow._shown import ReadOnly, Shown
from gearbow._types import Array, Dof
from gearbow.description.gears import Disk, Gear, Mesh
from gearbow.description.loads import AnyBearing, Coupling, Force
from gearbow.description.places import (
    Housing,
    Support,
    housing_and_interface,
    name_of_housing,
    other_shaft,
    place_label,
)
from gearbow.description.rolling import RollingBearing
from gearbow.description.shafts import STEEL, Shaft, Sleeve, segments_of
from gearbow.description.stiffness import Stiffness

#: Largest number of harmonics and of sidebands, which bounds the memory for the list of orders.
MOST_HARMONICS = 1000

#: Orders with a smaller relative difference are equal: speed ratios are rounded.
SAME = 1e-9

#: Largest number of names that the text of an order contains.
_SHOWN_NAMES = 4


class Train(Protocol):
    """A system with shafts, gears and meshes."""

    shafts: tuple[Shaft, ...]
    gears: tuple[Gear, ...]
    meshes: tuple[Mesh, ...]
    bearings: tuple[AnyBearing, ...]
    disks: tuple[Disk, ...]
    supports: tuple[Support, ...]
    housings: tuple[Housing, ...]
    couplings: tuple[Coupling, ...]
    forces: tuple[Force, ...]
    sleeves: tuple[Sleeve, ...]
    _model: Model

    @property
    def dofs(self) -> tuple[Dof, ...]:
        """Degrees of freedom."""

    @property
    def speed_ratios(self) -> Array:
        """Signed speed of each shaft over that of the reference shaft."""


@dataclass(frozen=True)
class Order(Shown):
    """One frequency of a train, as an order of the reference shaft.

    Parameters
    ----------
    value : float
        Frequency over that of the reference shaft.
    names : tuple of str
        Its excitations, the simplest first, e.g. "1× input" and "2× middle". Orders that a record
        does not separate are one order with the names of all of them.

    Examples
    --------
    >>> import gearbow as gb
    >>> order = gb.results.Order(25.0, ("1× mesh g1–g2", "25× input"))
    >>> print(order)
    1× mesh g1–g2 = 25× input
    """

    value: float
    names: tuple[str, ...]

    def __str__(self) -> str:
        more = len(self.names) - _SHOWN_NAMES
        shown = " = ".join(self.names[:_SHOWN_NAMES])
        return shown if more <= 0 else f"{shown} and {more} more"


def ratios_by_shaft(system: Train) -> dict[str, float]:
    """Give the signed speed of each shaft over that of the reference shaft by its name."""
    names = [shaft.name for shaft in system.shafts]
    return dict(zip(names, system.speed_ratios.tolist(), strict=True))


def shafts_of_bodies(system: Train) -> dict[str, str]:
    """Give the shaft of each gear and disk by its name."""
    shafts = {gear.name: gear.shaft for gear in system.gears}
    return shafts | {disk.name: disk.shaft for disk in system.disks}


def mesh_orders(system: Train) -> list[float]:
    """Give the tooth frequency of each mesh over the speed of the reference shaft."""
    ratios = ratios_by_shaft(system)
    gears = {gear.name: gear for gear in system.gears}
    shafts = shafts_of_bodies(system)
    found = []
    for mesh in system.meshes:
        driver, carrier = gears[mesh.driver], 0.0
        if mesh.carrier is not None:  # teeth meet at the speed of the gears relative to it
            place = mesh.carrier
            carrier = ratios[shafts[place] if isinstance(place, str) else place[0]]
        found.append(driver.teeth * abs(ratios[driver.shaft] - carrier))
    return found


def tooth_orders(system: Train) -> dict[str, float]:
    """Give the tooth frequency of each gear over the speed of the reference shaft by its name."""
    ratios = ratios_by_shaft(system)
    found = {gear.name: gear.teeth * abs(ratios[gear.shaft]) for gear in system.gears}
    for mesh, order in zip(system.meshes, mesh_orders(system), strict=True):
        found[mesh.driver] = found[mesh.driven] = order
    return found


@dataclass(frozen=True)
class Kinematics(Shown):
    """Speed ratios and tooth frequencies, which determine the orders of a train.

    Parameters
    ----------
    shafts : tuple of (str, float)
        Name of each shaft, and its speed ratio with the sign of its rotation.
    meshes : tuple of (str, str, str, str, float)
        Driving and driven gear, their shafts, and the order of the tooth frequency.
    bearings : tuple of (str, float, float)
        Name of each rolling bearing, "shaft@position", the order of its cage and the order at which
        its elements pass a direction that is fixed in space.
    forces : tuple of (str, str, float)
        Place and shaft of each force that turns, and its order relative to the shaft.

    Examples
    --------
    >>> from gearbow.orders import Kinematics
    >>> train = Kinematics(
    ...     shafts=(("input", 1.0), ("output", -0.5)),
    ...     meshes=(("g1", "g2", "input", "output", 25.0),),
    ... )
    >>> for order in train.orders(shaft_harmonics=2, mesh_harmonics=1, sidebands=1):
    ...     print(f"{order.value:g}", order)
    0.5 1× output
    1 1× input = 2× output
    2 2× input
    24 1× mesh g1–g2 − 1× input
    24.5 1× mesh g1–g2 − 1× output
    25 1× mesh g1–g2
    25.5 1× mesh g1–g2 + 1× output
    26 1× mesh g1–g2 + 1× input
    """

    shafts: tuple[tuple[str, float], ...]
    meshes: tuple[tuple[str, str, str, str, float], ...]
    bearings: tuple[tuple[str, float, float], ...] = ()
    forces: tuple[tuple[str, str, float], ...] = ()

    @classmethod
    def of(cls, system: Train) -> "Kinematics":
        """Find the kinematics of a system."""
        signed = ratios_by_shaft(system)
        bodies = shafts_of_bodies(system)
        meshes = [
            (mesh.driver, mesh.driven, bodies[mesh.driver], bodies[mesh.driven], order)
            for mesh, order in zip(system.meshes, mesh_orders(system), strict=True)
        ]
        bearings = {}
        for bearing in system.bearings:
            if isinstance(bearing, RollingBearing):
                other = other_shaft(bearing.support)
                outer = 0.0 if other is None else signed[other[0]]
                own = bearing.cage_order
                cage = abs(own * signed[bearing.shaft] + (1.0 - own) * outer)
                name = f"{bearing.shaft}@{bearing.position:g}"
                bearings[name] = (cage, bearing._count * cage)
        rolling = tuple((name, *orders) for name, orders in bearings.items())
        forces = tuple(
            (
                place_label(force.at),
                bodies[force.at] if isinstance(force.at, str) else force.at[0],
                abs(float(force.order)),
            )
            for force in system.forces
            if force.order
        )
        return cls(tuple(signed.items()), tuple(meshes), rolling, forces)

    @classmethod
    def from_plain(cls, plain: dict[str, Any] | None) -> "Kinematics | None":
        """Read the kinematics from plain data, the inverse of `dataclasses.asdict`."""
        if plain is None:
            return None
        keys = ("shafts", "meshes", "bearings", "forces")
        return cls(*(tuple(tuple(row) for row in plain[key]) for key in keys))

    @property
    def reference(self) -> str:
        """Name of the reference shaft, whose speed ratio is 1."""
        return next(name for name, ratio in self.shafts if ratio == 1.0)

    def orders(
        self,
        shaft_harmonics: int = 4,
        mesh_harmonics: int = 3,
        sidebands: int = 1,
        bearing_harmonics: int = 3,
    ) -> tuple[Order, ...]:
        """List the orders. Equal orders are merged. The orders of forces are always among them."""
        found = self.ranked(shaft_harmonics, mesh_harmonics, sidebands, bearing_harmonics)
        return tuple(sorted(found, key=lambda order: order.value))

    def ranked(
        self, shaft_harmonics: int, mesh_harmonics: int, sidebands: int, bearing_harmonics: int
    ) -> list[Order]:
        """List the same orders, the simplest first: shafts, teeth, sidebands, bearings, forces."""
        shaft_harmonics = whole(shaft_harmonics, "shaft_harmonics", 0, MOST_HARMONICS)
        mesh_harmonics = whole(mesh_harmonics, "mesh_harmonics", 0, MOST_HARMONICS)
        sidebands = whole(sidebands, "sidebands", 0, MOST_HARMONICS)
        bearing_harmonics = whole(bearing_harmonics, "bearing_harmonics", 0, MOST_HARMONICS)
        named = [
            *self._shafts(shaft_harmonics),
            *self._meshes(mesh_harmonics, 0),
            *(self._meshes(mesh_harmonics, sidebands) if sidebands else ()),
            *self._bearings(bearing_harmonics),
            *self._forces(),
        ]
        merged: list[tuple[float, list[str]]] = []
        # The sort is stable: among equal orders the simplest name stays first.
        for value, name in sorted(named, key=lambda pair: pair[0]):
            if merged and math.isclose(merged[-1][0], value, rel_tol=SAME):
                merged[-1][1].append(name)
            else:
                merged.append((value, [name]))
        rank = {name: place for place, (_, name) in enumerate(named)}
        found = [
            Order(value, tuple(sorted(names, key=rank.__getitem__))) for value, names in merged
        ]
        return sorted(found, key=lambda order: rank[order.names[0]])

    def _shafts(self, harmonics: int) -> Iterator[tuple[float, str]]:
        turning = [(name, abs(ratio)) for name, ratio in self.shafts if ratio]
        for n in range(1, harmonics + 1):
            for name, ratio in turning:
                yield n * ratio, f"{n}× {name}"

    def _forces(self) -> Iterator[tuple[float, str]]:
        ratios = {name: abs(ratio) for name, ratio in self.shafts}
        for at, shaft, order in dict.fromkeys(self.forces):
            yield order * ratios[shaft], f"{order:g}× force at {at}"

    def _bearings(self, harmonics: int) -> Iterator[tuple[float, str]]:
        """Give the orders of cages, and of the elements that pass a fixed direction."""
        for name, cage, passing in self.bearings:
            if harmonics:
                yield cage, f"1× cage {name}"
            for k in range(1, harmonics + 1):
                yield k * passing, f"{k}× ball pass {name}"

    def _meshes(self, harmonics: int, sidebands: int) -> Iterator[tuple[float, str]]:
        """Give the tooth frequencies, or their sidebands if `sidebands` is not 0."""
        ratios = {name: abs(ratio) for name, ratio in self.shafts}
        for m in range(1, harmonics + 1):
            for driver, driven, *shafts, tooth in self.meshes:
                name = f"{m}× mesh {driver}–{driven}"
                if not sidebands:
                    yield m * tooth, name
                for n in range(1, sidebands + 1):
                    for shaft in filter(ratios.get, shafts):
                        for sign, word in ((1.0, "+"), (-1.0, "−")):
                            value = m * tooth + sign * n * ratios[shaft]
                            if value > 0.0:
                                yield value, f"{name} {word} {n}× {shaft}"


#: Excitations that turn once with a shaft, which the synchronous vibration contains.
_TURNING = (
    "bow",
    "unbalance",
    "run-out of gears",
    "run-out of couplings",
    "forces of order 1",
    "transmission errors of order 1",
)


def left_out(system: Any, contained: Iterable[str] = _TURNING) -> tuple[str, ...]:
    """Name the vibration sources of a system that an analysis does not contain."""
    return tuple(name for name, acts in _excitations(system) if acts and name not in contained)


def _excitations(system: Any) -> Iterable[tuple[str, bool]]:
    """Give every kind of excitation, and whether a system has it."""
    errors = [mesh.error for mesh in system.meshes if mesh.error is not None]
    of_shafts = [own for error in errors for own in (error.driver, error.driven) if own]
    loads = [load.value for load in (*system.torques, *system.forces)]
    orders = [force.order for force in system.forces if force.order is not None]
    yield "bow", any(shaft.bow is not None for shaft in system.shafts)
    yield "unbalance", any(body.unbalance != 0.0 for body in (*system.gears, *system.disks))
    yield "run-out of gears", any(gear.runout != 0.0 for gear in system.gears)
    yield "run-out of couplings", any(coupling.runout != 0.0 for coupling in system.couplings)
    yield "forces of order 1", 1.0 in orders
    yield "forces of other orders", any(order != 1.0 for order in orders)
    yield "transmission errors of order 1", any(own[0][0] != 0.0 for own in of_shafts)
    yield (
        "other transmission errors",
        any(error.tooth is not None or error.table is not None for error in errors)
        or any(len(own) > 1 for own in of_shafts),
    )
    yield "loads over time", any(callable(one) or hasattr(one, "times") for one in loads)


#: Models of tooth pairs, which have an engagement.
_PAIRS = ("square", "parabolic", "potential_energy")


def _engages_by_default(mesh: Mesh) -> bool:
    """Return whether a mesh has tooth pairs with the default length of engagement."""
    model = mesh.stiffness
    return isinstance(model, Stiffness) and model.model in _PAIRS and model.engagement is None


def _uses_steel(shaft: Shaft) -> bool:
    """Return whether a part of a shaft has the default material."""
    return shaft.material == STEEL and any(each.material is None for each in segments_of(shaft))


def assumptions(system: Train) -> list[str]:
    """List the defaults of physical models that a system uses, with the parts that use them."""
    shafts, gears = system.shafts, system.gears
    meshes, bearings = system.meshes, system.bearings
    steel = [shaft.name for shaft in shafts if _uses_steel(shaft)]
    tips = [gear.name for gear in gears if gear.tip_radius is None]
    disks = [gear.name for gear in gears if gear.mass is None and not gear.internal]
    rings = [gear.name for gear in gears if gear.mass is None and gear.internal]

    chosen = {
        "mean stiffness of ISO 6336-1": [mesh.stiffness is None for mesh in meshes],
        "tooth pairs engage over 0.1 of the base pitch": [
            _engages_by_default(mesh) for mesh in meshes
        ],
        "no damping": [mesh.damping is None and mesh.damping_ratio == 0.0 for mesh in meshes],
        "contact on both flanks, without backlash": [mesh.backlash is None for mesh in meshes],
        "no damping in separation": [
            mesh.backlash is not None and not mesh.damping_in_separation for mesh in meshes
        ],
    }
    names = [f"{mesh.driver}–{mesh.driven}" for mesh in meshes]
    found = [
        ("shafts", "steel with E = 207 GPa, ν = 0.3, ρ = 7850 kg/m³", steel, len(shafts)),
        ("gears", "tip radius of full-depth teeth", tips, len(gears)),
        ("gears", "mass and inertia of solid steel disks", disks, len(gears)),
        ("gears", "mass and inertia of steel rings", rings, len(gears)),
    ]
    estimated = {
        place_label((each.shaft, each.position)): estimate.stiffness_uncertainty
        for each in bearings
        if isinstance(each, RollingBearing) and (estimate := each.estimate) is not None
    }
    if estimated:
        error = f"{max(estimated.values()):.0%}"
        text = f"number and size of rolling elements by estimates, stiffness within {error}"
        found.append(("bearings", text, list(estimated), len(bearings)))
    for text, used in chosen.items():
        own = [name for name, is_used in zip(names, used, strict=True) if is_used]
        found.append(("meshes", text, own, len(meshes)))
    return [
        f"{kind}: {text}" + ("" if len(own) == total else f" ({', '.join(own)})")
        for kind, text, own, total in found
        if own
    ]


@dataclass(frozen=True, eq=False)
class ShaftOutline(ReadOnly):
    """Outline of one shaft."""

    name: str
    origin: Array
    steps: tuple["Step", ...]
    sleeves: tuple["Step", ...]

    @property
    def length(self) -> float:
        """Length of the shaft."""
        return self.steps[-1].end

    def outer_radius(self, position: float) -> float:
        """Look up the outer radius at a position; at a step, that on the left."""
        step = next((step for step in self.steps if position <= step.end), self.steps[-1])
        return step.radius(position)


@dataclass(frozen=True)
class Step:
    """Outline of a segment or a sleeve: its ends, with outer and inner radius at both [m]."""

    begin: float
    end: float
    outer: tuple[float, float]
    inner: tuple[float, float]

    def radius(self, position: float) -> float:
        """Give the outer radius at a position."""
        return float(np.interp(position, (self.begin, self.end), self.outer))

    @property
    def largest(self) -> float:
        """Largest outer radius."""
        return max(self.outer)


@dataclass(frozen=True)
class BodyOutline(Shown):
    """Outline of one gear or disk."""

    name: str
    shaft: str
    position: float
    radius: float
    internal: bool = False

    @property
    def signed_radius(self) -> float:
        """Radius [m], negative for an internal gear."""
        return -self.radius if self.internal else self.radius


@dataclass(frozen=True, eq=False)
class InterfaceOutline(ReadOnly):
    """An interface of an elastic housing."""

    name: str
    #: Position (x, y, z) [m].
    position: Array
    #: Displacements along x, y and z in each mode of the housing, shape (3, modes).
    rows: Array
    #: Position of its bearing on the shaft [m]; None if it carries no bearing.
    bearing: float | None


@dataclass(frozen=True, eq=False)
class BaseOutline(ReadOnly):
    """What bearings stand on: its centre [m], and (shaft, position [m]) of these bearings."""

    name: str
    centre: Array
    feet: tuple[tuple[str, float], ...]
    interfaces: tuple[InterfaceOutline, ...] = ()


@dataclass(frozen=True, eq=False)
class Layout(Shown):
    """Geometry of a train at rest."""

    shafts: tuple[ShaftOutline, ...]
    bodies: tuple[BodyOutline, ...]
    bearings: tuple[tuple[str, float], ...]
    bases: tuple[BaseOutline, ...] = ()

    def shaft(self, name: str) -> ShaftOutline:
        """Look up a shaft."""
        return next(shaft for shaft in self.shafts if shaft.name == name)


def layout(system: Train, origins: Sequence[Sequence[float]]) -> Layout:
    """Collect the geometry of a train whose shafts begin at the origins [m]."""
    given: list[Gear | Disk] = [*system.gears, *system.disks]
    outlines = tuple(
        ShaftOutline(
            shaft.name,
            np.array(origin),
            _steps(shaft),
            tuple(_around(sleeve) for sleeve in system.sleeves if sleeve.shaft == shaft.name),
        )
        for shaft, origin in zip(system.shafts, origins, strict=True)
    )
    bodies = tuple(
        BodyOutline(
            body.name,
            body.shaft,
            float(body.position),
            reference_radius(body),
            isinstance(body, Gear) and body.internal,
        )
        for body in given
    )
    bearings = tuple((bearing.shaft, float(bearing.position)) for bearing in system.bearings)
    return Layout(outlines, bodies, bearings, tuple(_bases(outlines, system)))


def _bases(shafts: Sequence[ShaftOutline], system: Train) -> Iterator[BaseOutline]:
    """Give the supports and housings; a support is at the middle of its bearings."""
    listed = {support.name: support for support in system.supports}
    origins = {shaft.name: shaft.origin for shaft in shafts}
    feet: dict[str, list[tuple[str, float]]] = {}
    carried: dict[str, float] = {}
    for bearing in system.bearings:
        base: Any = bearing.support
        base = listed.get(base, base) if isinstance(base, str) else base
        under: list[Any] = [base]
        if isinstance(base, Support):
            under = [base.name, base.support]
        for each in under:
            seat, name = housing_and_interface(each), name_of_housing(each)
            if seat is not None:
                carried[seat[1]] = float(bearing.position)
            if name is not None:
                feet.setdefault(name, []).append((bearing.shaft, float(bearing.position)))
    centres: dict[str, Array] = {
        housing.name: np.array(housing.position, dtype=np.float64) for housing in system.housings
    }
    for name, own in feet.items():
        at = [origins[shaft] + np.array([x, 0.0, 0.0]) for shaft, x in own]
        middle: Array = np.mean(at, axis=0)
        interfaces = tuple(
            InterfaceOutline(
                place,
                np.array(given["position"], dtype=np.float64),
                np.array(given["rows"], dtype=np.float64)[:3],
                carried.get(place),
            )
            for housing in system.housings
            if housing.name == name and housing.elastic is not None
            for place, given in housing.elastic.interfaces.items()
        )
        yield BaseOutline(name, centres.get(name, middle), tuple(own), interfaces)


def reference_radius(body: Gear | Disk) -> float:
    """Give the radius at which a gear or disk is drawn."""
    if isinstance(body, Disk):
        return float(np.sqrt(2.0 * body.polar_inertia / body.mass)) if body.mass > 0.0 else 0.0
    helix = float(np.cos(body.helix_angle))
    if body.module is not None:
        return body.module * body.teeth / 2.0 / helix
    transverse = np.arctan2(np.tan(body.pressure_angle), helix)
    return (body.base_radius or 0.0) / float(np.cos(transverse))


def _steps(shaft: Shaft) -> tuple[Step, ...]:
    """Give the outline of every segment of a shaft."""
    segments = segments_of(shaft)
    ends = [0.0, *np.cumsum([segment.length for segment in segments]).tolist()]
    found = []
    for (begin, end), segment in zip(pairwise(ends), segments, strict=True):
        outer, inner = (np.array(segment._ends).T / 2.0).tolist()
        found.append(Step(begin, end, tuple(outer), tuple(inner)))
    return tuple(found)


def _around(sleeve: Sleeve) -> Step:
    """Give the outline of a sleeve."""
    outer, inner = sleeve.outer_diameter / 2.0, sleeve.inner_diameter / 2.0
    return Step(sleeve.begin, sleeve.end, (outer, outer), (inner, inner))
