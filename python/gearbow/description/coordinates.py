"""Coordinates of a system: its degrees of freedom, and the positions of gears and disks."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from gearbow._convert import nearest, nodal
from gearbow._core import shaft_motion
from gearbow._shown import Shown
from gearbow._types import Array, At, Dof, Plain
from gearbow.description.layout import Train
from gearbow.description.places import Places, is_place, names_of_bases, place
from gearbow.errors import GearbowError, SceneError

#: Smallest number of intervals between the drawn positions of a shaft.
_INTERVALS = 48


@dataclass(frozen=True, eq=False)
class Coordinates(Shown):
    """Degrees of freedom of a system, found by name or place."""

    dofs: tuple[Dof, ...]
    bodies: Mapping[str, tuple[str, float]]
    points: Mapping[str, tuple[str, tuple[float, ...]]] = field(default_factory=dict)
    #: Names of the shafts.
    shafts: tuple[str, ...] = ()
    #: Housing and rows (6, modes) of each interface of an elastic housing.
    seats: Mapping[str, tuple[str, Array]] = field(default_factory=dict, repr=False)
    #: Description of the system with its elements: from it the core finds the motion between nodes.
    resolved: Mapping[str, Plain] = field(default_factory=dict, repr=False)

    @classmethod
    def of(cls, system: Train) -> "Coordinates":
        """Collect the coordinates of a system."""
        dofs, housings = system.dofs, system.housings
        own = (bearing.support for bearing in system.bearings)
        bases = names_of_bases(own, *system.supports, *housings)
        parts: Any = (*system.gears, *system.disks)
        bodies = {body.name: (body.shaft, float(body.position)) for body in parts}
        rigid = [(name, x) for name, x, kind in nodal(dofs) if not kind.startswith("mode")]
        bodies |= {name: (name, x) for name, x in rigid if name in bases}
        points = {
            name: (housing.name, tuple(np.subtract(point, housing.position).tolist()))
            for housing in housings
            for name, point in housing.points.items()
        }
        shafts = tuple(shaft.name for shaft in system.shafts)
        seats = {
            name: (housing.name, np.array(own["rows"], dtype=np.float64))
            for housing in housings
            if housing.elastic is not None
            for name, own in housing.elastic.interfaces.items()
        }
        return cls(tuple(dofs), bodies, points, shafts, seats, system._model.resolved())

    def along(self, shaft: str, positions: Sequence[float]) -> dict[str, Array]:
        """Give the motion at positions [m] as factors (positions, n) by direction."""
        return shaft_motion(self.resolved, shaft, list(positions))

    def motion(self, values: Any, quantity: str, at: At) -> Any:
        """Give the displacement or twist of a place of which a quantity is a time derivative."""
        if quantity == "twist":
            return self.twisted(values, at)
        if quantity.startswith("axial"):
            return self.axial_displacement(values, at)
        return self.displacement(values, at)

    def displacement(self, values: Any, at: At) -> Any:
        """Give the lateral displacement of a place."""
        at = place(at)
        if isinstance(at, str) and at in self.seats:
            return self._in_seat(values, at, slice(1, 3))
        within = self._within(at)
        if within is not None:
            planes = [self._combined(values, within, at, kind, "lateral motion") for kind in "vw"]
            return np.stack(planes, axis=-1)
        if not isinstance(at, str) or at not in self.points:
            return values[..., self.lateral(at)]
        return self._of_point(values, *self.points[at])

    def _of_point(self, values: Any, housing: str, arm: Sequence[float]) -> Any:
        """Give the lateral displacement of a point at a distance from the centre of a housing."""
        x, y, z = arm
        moved = values[..., self.lateral(housing)].copy()
        if (*self._node(housing), "twist") in self._indices:
            b, g, twist = (
                values[..., self._index(housing, direction, "rotation")]
                for direction in ("B", "G", "twist")
            )
            moved[..., 0] += g * x - twist * z
            moved[..., 1] += -b * x + twist * y
        return moved

    def axial_displacement(self, values: Any, at: At) -> Any:
        """Give the axial displacement of a place."""
        at = place(at)
        if isinstance(at, str) and at in self.seats:
            return self._in_seat(values, at, 0)
        within = self._within(at)
        if within is not None:
            return self._combined(values, within, at, "u", "axial motion")
        if not isinstance(at, str) or at not in self.points:
            return values[..., self.axial(at)]
        housing, (_, y, z) = self.points[at]
        node = self._node(housing)
        turns = (*node, "twist") in self._indices and any(dof[2] == "u" for dof in self.dofs)
        # A housing that does not rotate has the motion of its centre of mass; without it, an error.
        moved = (
            0.0 if turns and (*node, "u") not in self._indices else values[..., self.axial(housing)]
        )
        if turns:
            b, g = (values[..., self._index(housing, kind, "rotation")] for kind in ("B", "G"))
            moved = moved + b * z - g * y
        return moved

    def twisted(self, values: Any, at: At) -> Any:
        """Give the twist of a place."""
        if isinstance(at, str) and at in self.seats:
            return self._in_seat(values, at, 3)
        within = self._within(place(at))
        if within is not None:
            return self._combined(values, within, at, "twist", "twist")
        return values[..., self.twist(at)]

    def _in_seat(self, values: Any, name: str, axes: Any) -> Any:
        """Give motions of an interface of an elastic housing."""
        housing, rows = self.seats[name]
        return values[..., self.modes_of(housing)] @ rows[axes].T

    def modes_of(self, housing: str) -> list[int]:
        """Find the modal coordinates of an elastic housing."""
        return [
            n
            for n, (part, _, kind) in enumerate(self.dofs)
            if part == housing and kind.startswith("mode")
        ]

    def shaft(self, at: At) -> str:
        """Find the shaft of a place."""
        at = place(at)
        return at[0] if self._within(at) is not None else self._node(at)[0]

    def lateral(self, at: At) -> list[int]:
        """Find the lateral displacements of a place."""
        return [self._index(at, "v", "lateral motion"), self._index(at, "w", "lateral motion")]

    def twist(self, at: At) -> int:
        """Find the twist of a place."""
        return self._index(at, "twist", "twist")

    def axial(self, at: At) -> int:
        """Find the axial displacement of a place."""
        return self._index(at, "u", "axial motion")

    def _within(self, at: Any) -> dict[str, Array] | None:
        """Give the factors of a place between two nodes by direction; None for another place."""
        if not is_place(at) or at[0] not in self.shafts or self._nodes.find(at) is not None:
            return None
        shaft, position = at
        return {direction: rows[0] for direction, rows in self.along(shaft, [position]).items()}

    @staticmethod
    def _combined(
        values: Any, within: Mapping[str, Array], at: At, direction: str, motion: str
    ) -> Any:
        """Give a direction of a place between two nodes."""
        if direction not in within:
            raise _missing(at, motion)
        return values @ within[direction]

    def bends(self, at: At) -> bool:
        """Tell whether a place moves laterally: some shafts only twist."""
        return at in self.seats or (*self._node(at), "v") in self._indices

    def _index(self, at: At, direction: str, motion: str) -> int:
        index = self._indices.get((*self._node(at), direction))
        if index is None:
            raise _missing(at, motion)
        return index

    @cached_property
    def _indices(self) -> dict[Dof, int]:
        """Index of each degree of freedom."""
        return {dof: index for index, dof in enumerate(self.dofs)}

    @cached_property
    def _nodes(self) -> Places:
        """Nodes with the names of what is there."""
        names: dict[tuple[str, float], list[str]] = {}
        for name, x, _ in nodal(self.dofs):
            names.setdefault((name, x), [])
        nodes = Places("place", ([node] for node in names))
        for name, at in self.bodies.items():
            index = nodes.find(at)
            if index is not None:
                names[nodes.known[index][0]].append(name)
        return Places("place", ([node, *own] for node, own in names.items()))

    def _node(self, at: At) -> tuple[str, float]:
        """Find the shaft and the exact position of a node."""
        nodes = self._nodes
        index = nodes.find(at)
        if index is not None:
            node: tuple[str, float] = nodes.known[index][0]
            return node
        at = place(at)
        if isinstance(at, str):
            if at in self.points:
                raise SceneError(
                    f'at: "{at}" is a point of a housing, which only displacements accept; name '
                    f'the housing "{self.points[at][0]}"'
                )
            if at in self.seats or any(at == housing for housing, _ in self.seats.values()):
                names = [name for name, (housing, _) in self.seats.items() if at in (name, housing)]
                raise SceneError(
                    f'at: "{at}" belongs to an elastic housing, of which the interfaces '
                    f"{', '.join(names)} have displacements and the twist"
                )
            known = [*self.bodies, *self.points, *self.seats]
            raise SceneError(
                f'at: no gear, disk, support or housing is called "{at}"{_similar(at, known)}'
            )
        shaft, position = at
        positions = nodes.positions(shaft)
        if not positions:
            shafts = dict.fromkeys(name for name, _, _ in self.dofs)
            raise SceneError(f'at: no shaft is called "{shaft}"{_similar(shaft, shafts)}')
        near = min(positions, key=lambda x: abs(x - position))
        raise SceneError(
            f'at: shaft "{shaft}" has no node at {position} m; the nearest is at {near} m'
        )


def drawn_positions(nodes: Sequence[float]) -> list[float]:
    """Give the positions at which the motion of a shaft is drawn: its nodes, and others between."""
    found = list(nodes[:1])
    for begin, end in pairwise(nodes):
        count = 1 + int(np.ceil(_INTERVALS * (end - begin) / (nodes[-1] - nodes[0])))
        found += [*np.linspace(begin, end, count)[1:-1].tolist(), end]
    return found


def time_derivatives(quantity: str) -> int:
    """Count the derivatives with respect to time from a displacement to a quantity."""
    return 2 if quantity.endswith("acceleration") else int(quantity.endswith("velocity"))


def _missing(at: At, motion: str) -> GearbowError:
    return GearbowError(f"{at!r} has no {motion}: the system does not model this motion")


def _similar(name: str, known: Iterable[str]) -> str:
    """Suggest the most similar name, or list the known ones."""
    listed = list(known)
    return nearest(name, listed) or f"; there are {', '.join(listed) or 'none'}"
