"""Positions of shafts, gears, disks and bearings at rest: the geometry for a drawing."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
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
from gearbow.description.shafts import Segment, Shaft, segments_of
from gearbow.description.supports import Housing

__all__ = [
    "BaseOutline",
    "BodyOutline",
    "Layout",
    "ShaftOutline",
    "ShearLengths",
    "layout",
    "reference_radius",
    "shear_lengths",
]

#: End and shear length √(12EI/(κGA)) of each segment of a shaft [m].
ShearLengths: TypeAlias = tuple[tuple[float, float], ...]


@dataclass(frozen=True, eq=False)
class ShaftOutline(ReadOnly):
    """Outline of one shaft."""

    name: str
    origin: Array
    steps: tuple[tuple[float, float], ...]
    bores: tuple[float, ...]
    shear_lengths: tuple[float, ...]

    @property
    def length(self) -> float:
        """Length of the shaft."""
        return self.steps[-1][0]

    def outer_radius(self, position: float) -> float:
        """Look up the outer radius at a position."""
        return self.steps[self._segment(position)][1]

    def shear_length(self, position: float) -> float:
        """Look up the shear length at a position."""
        return self.shear_lengths[self._segment(position)]

    def _segment(self, position: float) -> int:
        """Find the segment at a position; at a step, that on the left."""
        inner = [end for end, _ in self.steps[:-1]]
        return next((i for i, end in enumerate(inner) if position <= end), len(inner))


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
            tuple(segment.inner_diameter / 2.0 for segment in segments_of(shaft)),
            tuple(_shear_length(shaft, segment) for segment in segments_of(shaft)),
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


def _steps(shaft: Shaft) -> tuple[tuple[float, float], ...]:
    """Give the end and the outer radius of every segment of a shaft."""
    segments = segments_of(shaft)
    ends = np.cumsum([segment.length for segment in segments])
    return tuple(
        (float(end), segment.outer_diameter / 2.0)
        for end, segment in zip(ends, segments, strict=True)
    )


def shear_lengths(shaft: Shaft) -> ShearLengths:
    """Give the end [m] and the shear length of each segment of a shaft."""
    ends = (end for end, _ in _steps(shaft))
    lengths = (_shear_length(shaft, segment) for segment in segments_of(shaft))
    return tuple(zip(ends, lengths, strict=True))


def _shear_length(shaft: Shaft, segment: Segment) -> float:
    """Give √(12EI/(κGA)) of a hollow circular section, with κ of Cowper (1966) [m]."""
    if not shaft.shear:
        return 0.0
    material = shaft.material
    ratio = material.poisson_ratio
    if ratio is None:
        ratio = material.youngs_modulus / (2.0 * (material.shear_modulus or 1.0)) - 1.0
    square = (segment.inner_diameter / segment.outer_diameter) ** 2
    total = (1.0 + square) ** 2
    kappa = (
        6.0 * (1.0 + ratio) * total / ((7.0 + 6.0 * ratio) * total + (20.0 + 12.0 * ratio) * square)
    )
    # I/A = (d² + d_i²)/16 and E/G = 2(1 + ν).
    gyration = segment.outer_diameter**2 * (1.0 + square) / 16.0
    return float(np.sqrt(24.0 * (1.0 + ratio) * gyration / kappa))
