"""Positions of shafts, gears, disks and bearings at rest: the geometry for a drawing."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, pairwise
from typing import TypeAlias

import numpy as np

from gearbow._read_only import ReadOnly
from gearbow._shown import Shown
from gearbow._types import Array
from gearbow.description.couplings import Coupling
from gearbow.description.gears import Disk, Gear, Mesh
from gearbow.description.journal import JournalBearing
from gearbow.description.loads import Bearing
from gearbow.description.rolling import RollingBearing
from gearbow.description.shafts import Material, Shaft, Sleeve, segments_of
from gearbow.description.supports import Housing

#: End and shear length √(12EI/(κGA)) of each part of a shaft [m].
ShearLengths: TypeAlias = tuple[tuple[float, float], ...]


@dataclass(frozen=True, eq=False)
class ShaftOutline(ReadOnly):
    """Outline of one shaft."""

    name: str
    origin: Array
    steps: tuple["Step", ...]
    sleeves: tuple["Step", ...]
    shear_lengths: ShearLengths

    @property
    def length(self) -> float:
        """Length of the shaft."""
        return self.steps[-1].end

    def outer_radius(self, position: float) -> float:
        """Look up the outer radius at a position; at a step, that on the left."""
        step = next((step for step in self.steps if position <= step.end), self.steps[-1])
        return step.radius(position)

    def shear_length(self, position: float) -> float:
        """Look up the shear length at a position."""
        lengths = (length for end, length in self.shear_lengths if position <= end)
        return next(lengths, self.shear_lengths[-1][1])


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


@dataclass(frozen=True, eq=False)
class BaseOutline(ReadOnly):
    """What bearings stand on: its centre [m], and (shaft, position [m]) of these bearings."""

    name: str
    centre: Array
    feet: tuple[tuple[str, float], ...]


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


def layout(
    shafts: Sequence[Shaft],
    gears: Sequence[Gear],
    disks: Sequence[Disk],
    meshes: Sequence[Mesh],
    bearings: Sequence[Bearing | JournalBearing | RollingBearing],
    *,
    centre_distances: Sequence[float],
    couplings: Sequence[Coupling] = (),
    housings: Sequence[Housing] = (),
    sleeves: Sequence[Sleeve] = (),
) -> Layout:
    """Find the geometry of a train at rest."""
    by_name = {gear.name: gear for gear in gears}
    origins = {shafts[0].name: np.zeros(3)}
    given: list[Gear | Disk] = [*gears, *disks]
    places = {body.name: (body.shaft, body.position) for body in given}
    while found := next(
        chain(
            _next_origin(meshes, centre_distances, by_name, origins),
            _next_coaxial(_coaxial(couplings, bearings, places), origins),
        ),
        None,
    ):
        origins[found[0]] = found[1]
    outlines = tuple(
        ShaftOutline(
            shaft.name,
            origins.get(shaft.name, np.zeros(3)),
            _steps(shaft),
            tuple(_around(sleeve) for sleeve in sleeves if sleeve.shaft == shaft.name),
            shear_lengths(shaft, sleeves),
        )
        for shaft in shafts
    )
    bodies = tuple(
        BodyOutline(body.name, body.shaft, float(body.position), reference_radius(body))
        for body in given
    )
    bearing_places = tuple((bearing.shaft, float(bearing.position)) for bearing in bearings)
    return Layout(outlines, bodies, bearing_places, tuple(_bases(outlines, bearings, housings)))


def _bases(
    shafts: Sequence[ShaftOutline],
    bearings: Sequence[Bearing | JournalBearing | RollingBearing],
    housings: Sequence[Housing],
) -> Iterator[BaseOutline]:
    """Give the supports and housings; a support is at the middle of its bearings."""
    origins = {shaft.name: shaft.origin for shaft in shafts}
    feet: dict[str, list[tuple[str, float]]] = {}
    for bearing in bearings:
        base = bearing.support
        name = base if isinstance(base, str) else getattr(base, "name", None)
        if name is not None:
            feet.setdefault(name, []).append((bearing.shaft, float(bearing.position)))
    centres: dict[str, Array] = {
        housing.name: np.array(housing.position, dtype=np.float64) for housing in housings
    }
    for name, own in feet.items():
        at = [origins[shaft] + np.array([x, 0.0, 0.0]) for shaft, x in own]
        middle: Array = np.mean(at, axis=0)
        yield BaseOutline(name, centres.get(name, middle), tuple(own))


def reference_radius(body: Gear | Disk) -> float:
    """Give the radius at which a gear or disk is drawn."""
    if isinstance(body, Disk):
        return float(np.sqrt(2.0 * body.polar_inertia / body.mass)) if body.mass > 0.0 else 0.0
    helix = float(np.cos(body.helix_angle))
    if body.module is not None:
        return body.module * body.teeth / 2.0 / helix
    transverse = np.arctan2(np.tan(body.pressure_angle), helix)
    return (body.base_radius or 0.0) / float(np.cos(transverse))


def _next_origin(
    meshes: Sequence[Mesh],
    centre_distances: Sequence[float],
    gears: dict[str, Gear],
    origins: dict[str, Array],
) -> Iterator[tuple[str, Array]]:
    """Give the origins of shafts that mesh with a shaft whose origin is known."""
    for mesh, distance in zip(meshes, centre_distances, strict=True):
        driver, driven = gears[mesh.driver], gears[mesh.driven]
        angle = mesh.centre_line_angle
        offset = np.array(
            [
                driver.position - driven.position,
                distance * np.cos(angle),
                distance * np.sin(angle),
            ]
        )
        for known, new, sign in ((driver, driven, 1.0), (driven, driver, -1.0)):
            if known.shaft in origins and new.shaft not in origins:
                yield new.shaft, origins[known.shaft] + sign * offset


def _coaxial(
    couplings: Sequence[Coupling],
    bearings: Sequence[Bearing | JournalBearing | RollingBearing],
    places: dict[str, tuple[str, float]],
) -> Iterator[tuple[tuple[str, float], tuple[str, float]]]:
    """Give the places that couplings, and bearings between two shafts, put at one point."""
    for coupling in couplings:
        a, b = (places[at] if isinstance(at, str) else at for at in (coupling.a, coupling.b))
        yield a, b
    for bearing in bearings:
        if isinstance(bearing.support, tuple):
            yield (bearing.shaft, bearing.position), bearing.support


def _next_coaxial(
    pairs: Iterable[tuple[tuple[str, float], tuple[str, float]]], origins: dict[str, Array]
) -> Iterator[tuple[str, Array]]:
    """Give the origins of shafts on the axis of a shaft whose origin is known."""
    for a, b in pairs:
        for (known, x), (new, position) in ((a, b), (b, a)):
            if known in origins and new not in origins:
                yield new, origins[known] + np.array([x - position, 0.0, 0.0])


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


def shear_lengths(shaft: Shaft, sleeves: Sequence[Sleeve] = ()) -> ShearLengths:
    """Give the end [m] and the shear length of each part of a shaft, of a cone in its middle."""
    own = [sleeve for sleeve in sleeves if sleeve.shaft == shaft.name]
    steps, segments = _steps(shaft), segments_of(shaft)
    cuts = {step.end for step in steps} | {x for each in own for x in (each.begin, each.end)}
    found = []
    for begin, end in pairwise(sorted(cuts | {0.0})):
        middle = (begin + end) / 2.0
        at = next(i for i, step in enumerate(steps) if middle <= step.end)
        (outer, inner), material = np.mean(segments[at]._ends, axis=0), segments[at].material
        sums = _rigidities(outer, inner, material or shaft.material)
        for each in own:
            if each.begin <= middle <= each.end:
                tube = _rigidities(each.outer_diameter, each.inner_diameter, each.material)
                sums = sums + each._fraction * tube
        found.append((end, float(np.sqrt(12.0 * sums[0] / sums[1])) if shaft.shear else 0.0))
    return tuple(found)


def _rigidities(outer: float, inner: float, material: Material) -> Array:
    """Give EI and κGA of a hollow circular section, with κ of Cowper (1966) [N m², N]."""
    ratio, shear = material.poisson_ratio, material.shear_modulus
    if ratio is None:
        ratio = material.youngs_modulus / (2.0 * (shear or 1.0)) - 1.0
    shear = material.youngs_modulus / (2.0 * (1.0 + ratio)) if shear is None else shear
    square = (inner / outer) ** 2
    total = (1.0 + square) ** 2
    kappa = (
        6.0 * (1.0 + ratio) * total / ((7.0 + 6.0 * ratio) * total + (20.0 + 12.0 * ratio) * square)
    )
    area = np.pi / 4.0 * (outer**2 - inner**2)
    second = area * (outer**2 + inner**2) / 16.0
    return np.array([material.youngs_modulus * second, kappa * shear * area])
