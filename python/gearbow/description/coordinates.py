"""Coordinates of a system: its degrees of freedom, and the positions of gears and disks."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from gearbow._lookup import nearest, nodal
from gearbow._shown import Shown
from gearbow._types import At, Dof
from gearbow.description.gears import Disk, Gear
from gearbow.description.places import place
from gearbow.description.supports import Housing
from gearbow.errors import GearbowError, SceneError

__all__ = ["Coordinates"]

#: Positions with a smaller difference, relative to the length of the shaft, are equal. The core
#: uses the same value.
_SAME_POSITION = 1e-9


@dataclass(frozen=True, eq=False)
class Coordinates(Shown):
    """Degrees of freedom of a system, found by name or place.

    Parameters
    ----------
    dofs : tuple of (str, float or (float, float), str)
        Shaft, position [m] and direction ("u", "v", "w", "B", "G" or "twist") of each degree of
        freedom.
        Those within an element have the positions of its ends and a degree ("v2").
    bodies : mapping of {str: (str, float)}
        Shaft and position [m] of each gear and disk; name and position of each support or housing.
    points : mapping of {str: (str, (float, float, float))}
        Housing of each of its points, and the vector (x, y, z) from its centre of mass [m].
    """

    dofs: tuple[Dof, ...]
    bodies: Mapping[str, tuple[str, float]]
    points: Mapping[str, tuple[str, tuple[float, ...]]] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        dofs: Sequence[Dof],
        gears: Sequence[Gear],
        disks: Sequence[Disk],
        bases: Sequence[str] = (),
        housings: Sequence[Housing] = (),
    ) -> "Coordinates":
        """Collect the coordinates of a system.

        Parameters
        ----------
        dofs : sequence of (str, float or (float, float), str)
            The degrees of freedom.
        gears : sequence of Gear
            The gears.
        disks : sequence of Disk
            The disks.
        bases : sequence of str
            Names of supports and housings.
        housings : sequence of Housing
            The housings, whose points have names.

        Returns
        -------
        Coordinates
            The coordinates.
        """
        given: list[Gear | Disk] = [*gears, *disks]
        bodies = {body.name: (body.shaft, float(body.position)) for body in given}
        bodies |= {name: (name, x) for name, x, _ in nodal(dofs) if name in bases}
        points = {
            name: (housing.name, tuple(np.subtract(point, housing.position).tolist()))
            for housing in housings
            for name, point in housing.points.items()
        }
        return cls(tuple(dofs), bodies, points)

    def displacement(self, values: Any, at: At) -> Any:
        """Give the lateral displacement of a place.

        Parameters
        ----------
        values : ndarray, shape (..., n)
            Displacements or amplitudes of all degrees of freedom [m, rad].
        at : str or tuple of (str, float)
            A gear, disk, support, housing or point of a housing by name, or (shaft, position [m]).

        Returns
        -------
        ndarray, shape (..., 2)
            Displacements v and w [m].

        Raises
        ------
        SceneError
            If there is no such place.
        GearbowError
            If the system has no lateral motion.
        """
        at = place(at)
        if not isinstance(at, str) or at not in self.points:
            return values[..., self.lateral(at)]
        housing, (x, y, z) = self.points[at]
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
        """Give the axial displacement of a place.

        Parameters
        ----------
        values : ndarray, shape (..., n)
            Displacements or amplitudes of all degrees of freedom [m, rad].
        at : str or tuple of (str, float)
            A gear, disk, support, housing or point of a housing by name, or (shaft, position [m]).

        Returns
        -------
        ndarray, shape (...)
            Displacement u [m].

        Raises
        ------
        SceneError
            If there is no such place.
        GearbowError
            If the system has no axial motion, or the support or housing does not move along the
            axis.
        """
        at = place(at)
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

    def shaft(self, at: At) -> str:
        """Find the shaft of a place.

        Parameters
        ----------
        at : str or tuple of (str, float)
            A gear or disk by name, or (shaft, position [m]).

        Returns
        -------
        str
            Name of the shaft.

        Raises
        ------
        SceneError
            If there is no such gear, disk or shaft.
        """
        return self._node(at)[0]

    def lateral(self, at: At) -> list[int]:
        """Find the lateral displacements of a place.

        Parameters
        ----------
        at : str or tuple of (str, float)
            A gear or disk by name, or (shaft, position [m]).

        Returns
        -------
        list of int, length 2
            Indices of v and w.

        Raises
        ------
        SceneError
            If there is no such node.
        GearbowError
            If the system has no lateral motion.
        """
        return [self._index(at, "v", "lateral motion"), self._index(at, "w", "lateral motion")]

    def twist(self, at: At) -> int:
        """Find the twist of a place.

        Parameters
        ----------
        at : str or tuple of (str, float)
            A gear or disk by name, or (shaft, position [m]).

        Returns
        -------
        int
            Index of the twist.

        Raises
        ------
        SceneError
            If there is no such node.
        GearbowError
            If the system has no twist.
        """
        return self._index(at, "twist", "twist")

    def axial(self, at: At) -> int:
        """Find the axial displacement of a place.

        Parameters
        ----------
        at : str or tuple of (str, float)
            A gear or disk by name, or (shaft, position [m]).

        Returns
        -------
        int
            Index of u.

        Raises
        ------
        SceneError
            If there is no such node.
        GearbowError
            If the system has no axial motion.
        """
        return self._index(at, "u", "axial motion")

    def _index(self, at: At, direction: str, motion: str) -> int:
        index = self._indices.get((*self._node(at), direction))
        if index is None:
            raise GearbowError(f"{at!r} has no {motion}: the system does not model this motion")
        return index

    @cached_property
    def _indices(self) -> dict[Dof, int]:
        """Index of each degree of freedom."""
        return {dof: index for index, dof in enumerate(self.dofs)}

    @cached_property
    def _positions(self) -> dict[str, list[float]]:
        """Positions of the nodes of each shaft, support and housing [m]."""
        found: dict[str, dict[float, None]] = {}
        for name, x, _ in nodal(self.dofs):
            found.setdefault(name, {})[x] = None
        return {name: list(positions) for name, positions in found.items()}

    def _node(self, at: At) -> tuple[str, float]:
        """Find the shaft and the exact position of a node."""
        at = place(at)
        if isinstance(at, str):
            if at in self.points:
                raise SceneError(
                    f'at: "{at}" is a point of a housing, which only displacements accept; name '
                    f'the housing "{self.points[at][0]}"'
                )
            if at not in self.bodies:
                similar = nearest(at, [*self.bodies, *self.points])
                raise SceneError(f'at: no gear, disk, support or housing is called "{at}"{similar}')
            shaft, position = self.bodies[at]
        else:
            shaft, position = at
        positions = self._positions.get(shaft)
        if not positions:
            names = dict.fromkeys(name for name, _, _ in self.dofs)
            raise SceneError(f'at: no shaft is called "{shaft}"{nearest(shaft, names)}')
        tolerance = _SAME_POSITION * positions[-1]
        for x in positions:
            if abs(x - position) <= tolerance:
                return shaft, x
        near = min(positions, key=lambda x: abs(x - position))
        raise SceneError(
            f'at: shaft "{shaft}" has no node at {position} m; the nearest is at {near} m'
        )
