"""The interface of a system that analyses of its variants need."""

import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, Protocol, TypeVar

from gearbow._core import Model
from gearbow._types import Excitation, Geometry, Plain
from gearbow.description.coordinates import Coordinates
from gearbow.description.layout import Train
from gearbow.description.loads import Torque
from gearbow.description.shafts import Notch
from gearbow.errors import SceneWarning
from gearbow.results.properties import Discretisation
from gearbow.results.response import Response
from gearbow.results.static import Static
from gearbow.results.synchronous import Synchronous
from gearbow.units.speed import SpeedUnit


class System(Train, Protocol):
    """A system that can be modified and analysed; `gearbow.RotorSystem` is one."""

    torques: tuple[Torque, ...]
    notches: tuple[Notch, ...]
    reference: str | None
    accuracy: str
    _model: Model
    _speed_unit: SpeedUnit

    @classmethod
    def _from_description(cls, description: Mapping[str, Plain]) -> Any:
        """Make a system that was checked before, without warnings."""

    @classmethod
    def _from_model(cls, model: Model) -> Any:
        """Make a system of a checked model."""

    @property
    def description(self) -> dict[str, Plain]:
        """Plain description."""

    @property
    def coordinates(self) -> Coordinates:
        """Degrees of freedom by name and place."""

    def _over_time(self, begin: float, duration: float) -> Any:
        """Replace functions of time by their samples over a run."""

    @property
    def discretisation(self) -> Discretisation:
        """Number and degree of the elements of every shaft."""

    def replace(self, **changes: Any) -> Any:
        """Make a system with other parts or options."""

    def _variation(self, **changes: Any) -> Any:
        """Make a system that uses elements and modes of this one, if only loads change."""

    def _require_memory_of_runs(
        self, count: int, duration: float, speed: Any, options: Mapping[str, Any]
    ) -> None:
        """Refuse runs whose records do not fit into memory together."""

    def static(self, speed: float = 0.0, *, geometry: Geometry = "live") -> Static:
        """Find the static equilibrium."""

    def synchronous(self, speeds: Any, *, excitation: Excitation = "both") -> Synchronous:
        """Find the linear response to bow and unbalance."""

    def simulate(self, *args: Any, **options: Any) -> Response:
        """Integrate the equations of motion."""

    def default_output_step(self, duration: float, speed: float) -> float:
        """Give the default time between recorded instants."""


S = TypeVar("S", bound=System)


@contextmanager
def without_scene_warnings() -> Iterator[None]:
    """Ignore warnings about the plausibility of variants of a checked system."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SceneWarning)
        yield


def variant(system: S, **changes: Any) -> S:
    """Make a variant of a checked system without plausibility warnings."""
    with without_scene_warnings():
        made: S = system.replace(**changes)
    return made


def silent(system: System) -> dict[str, Any]:
    """Give the parts of a system without what turns and excites, at the same places."""
    # Their places are nodes: all variants have the same coordinates.
    return {
        "shafts": [replace(shaft, bow=None) for shaft in system.shafts],
        "gears": [replace(gear, unbalance=0.0, runout=0.0) for gear in system.gears],
        "disks": [replace(disk, unbalance=0.0) for disk in system.disks],
        "couplings": [replace(coupling, runout=0.0) for coupling in system.couplings],
        "meshes": [replace(mesh, error=None) for mesh in system.meshes],
        "forces": [
            force if force.order is None else replace(force, value=0.0) for force in system.forces
        ],
    }
