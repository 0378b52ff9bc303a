"""Frequencies that a train excites, as orders of its reference shaft, and their names.

A shaft at the speed r_s Ω excites the harmonics n |r_s|. A mesh excites the harmonics m z |r_s| of
its tooth frequency. A shaft modulates the mesh force; this gives the sidebands m z |r| ± n |r_s|
(Randall, *A new method of modeling gear faults*, J. Mech. Design 104, 1982). A force that turns
with n times the angle of its shaft excites n |r_s|, where n need not be a whole number.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Protocol

from gearbow._convert import whole
from gearbow._shown import Shown
from gearbow._types import Array
from gearbow.description.couplings import Force
from gearbow.description.gears import Disk, Gear, Mesh
from gearbow.description.journal import JournalBearing
from gearbow.description.loads import Bearing
from gearbow.description.places import place_label
from gearbow.description.rolling import RollingBearing
from gearbow.description.shafts import Shaft

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
    bearings: tuple[Bearing | JournalBearing | RollingBearing, ...]
    disks: tuple[Disk, ...]
    forces: tuple[Force, ...]

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
        signed = {
            shaft.name: float(ratio)
            for shaft, ratio in zip(system.shafts, system.speed_ratios, strict=True)
        }
        ratios = {name: abs(ratio) for name, ratio in signed.items()}
        gears = {gear.name: gear for gear in system.gears}
        meshes = []
        for mesh in system.meshes:
            driver, driven = gears[mesh.driver], gears[mesh.driven]
            tooth = driver.teeth * ratios[driver.shaft]
            meshes.append((driver.name, driven.name, driver.shaft, driven.shaft, tooth))
        bearings = {}
        for bearing in system.bearings:
            if isinstance(bearing, RollingBearing):
                outer = signed[bearing.support[0]] if isinstance(bearing.support, tuple) else 0.0
                own = bearing.cage_order
                cage = abs(own * signed[bearing.shaft] + (1.0 - own) * outer)
                name = f"{bearing.shaft}@{bearing.position:g}"
                bearings[name] = (cage, bearing._count * cage)
        rolling = tuple((name, *orders) for name, orders in bearings.items())
        bodies = {gear.name: gear.shaft for gear in system.gears}
        bodies |= {disk.name: disk.shaft for disk in system.disks}
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
        for n in range(1, harmonics + 1):
            for name, ratio in self.shafts:
                yield n * abs(ratio), f"{n}× {name}"

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
                    for shaft in shafts:
                        for sign, word in ((1.0, "+"), (-1.0, "−")):
                            value = m * tooth + sign * n * ratios[shaft]
                            if value > 0.0:
                                yield value, f"{name} {word} {n}× {shaft}"
