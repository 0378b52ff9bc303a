"""Signals of a study, displacements and mesh forces, and the difference between two runs."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gearbow._types import Array, At
from gearbow.accuracy.levels import root_mean_square, unit_of_errors, variation
from gearbow.analysis.protocol import System
from gearbow.description.coordinates import Coordinates
from gearbow.description.places import is_pair, is_place, place, place_label
from gearbow.errors import GearbowError, SceneError
from gearbow.results.response import Response


@dataclass(frozen=True)
class Signal:
    """A signal of a response: the displacement of a point or the force of a mesh."""

    of: Any

    @property
    def is_force(self) -> bool:
        """Whether the signal is a mesh force."""
        return isinstance(self.of, tuple) and isinstance(self.of[1], str)

    def values(self, response: Response) -> Array:
        """Return the signal of a response."""
        if self.is_force:
            return response.mesh(self.of).force[:, np.newaxis]
        return response.displacement(self.of)

    def __str__(self) -> str:
        if self.is_force:
            return f"the force of {self.of[0]}/{self.of[1]}"
        return f"the displacement of {place_label(self.of)}"


def errors(
    found: Mapping[str, Array], other: Mapping[str, Array], scale: Mapping[str, Array]
) -> dict[str, float]:
    """Return the relative difference of each signal of two runs."""
    return {
        name: root_mean_square(found[name] - other[name]) / unit_of_errors(exact)
        for name, exact in scale.items()
    }


def error(
    found: Mapping[str, Array], other: Mapping[str, Array], scale: Mapping[str, Array]
) -> float:
    """Return the relative difference of two runs for the worst signal."""
    return max(errors(found, other, scale).values())


def check(found: Mapping[str, Array]) -> None:
    """Reject constant signals, for which a relative error is undefined."""
    for name, values in found.items():
        if not variation(values) > 0.0:
            raise SceneError(
                f"signals: {name} is constant in this run, so its relative error is "
                "undefined; give another signal"
            )


def read_signals(system: System, given: object) -> tuple[Signal, ...]:
    """Read the signals of a study and check that the system has them."""
    if given is None:
        names = [gear.name for gear in system.gears] + [disk.name for disk in system.disks]
        if not names:
            raise SceneError("signals: the system has no gear or disk; give (shaft, position)")
        given = names[0]
    single = isinstance(given, str) or is_place(given) or is_pair(given)
    items = [given] if single else given
    if not isinstance(items, Iterable):
        raise SceneError(
            f"signals: must be a name, (shaft, position) or (driver, driven), got {given!r}"
        )
    wanted = tuple(_signal(system, item) for item in items)
    if not wanted:
        raise SceneError("signals: must name at least one signal")
    return wanted


def _signal(system: System, item: Any) -> Signal:
    if is_pair(item):
        if tuple(item) not in {(mesh.driver, mesh.driven) for mesh in system.meshes}:
            raise SceneError(f"signals: no gear {item[0]!r} drives a gear {item[1]!r}")
        return Signal(tuple(item))
    if not (isinstance(item, str) or is_place(item)):
        raise SceneError(
            f"signals: must be a name, (shaft, position) or (driver, driven), got {item!r}"
        )
    at: At = place(item)
    try:
        Coordinates.of(system.dofs, system.gears, system.disks).lateral(at)
    except SceneError as error:
        raise SceneError(f"signals: {str(error).removeprefix('at: ')}") from None
    except GearbowError:
        message = f"signals: {item!r} has no lateral motion; give a mesh, (driver, driven)"
        raise SceneError(message) from None
    return Signal(at)
