"""Steady motion of several sources without a common period, as the sum of their steady motions.

This is exact where the equation of motion is linear with constant coefficients. Everything that
turns with a shaft is in the synchronous response; each other source has a period of its own.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gearbow._core import has_constant_coefficients, initial_state, steady_state, user_order
from gearbow._types import Array
from gearbow.accuracy.levels import tolerance
from gearbow.analysis.protocol import System, silent, variant
from gearbow.description.gears import Mesh
from gearbow.description.kinematics import Kinematics
from gearbow.description.teeth import TransmissionError
from gearbow.description.time_series import TimeSeries
from gearbow.orders.separation import SEPARATION

#: Turns of the slowest shaft in a record that does not separate its orders, and the largest number
#: for one that does: of example machines with rolling bearings, ten turns take up to 4.8 s.
_UNSEPARATED, _MOST = 2.0, 10.0
#: Part by which the record is longer than its orders need, because it leaves out its last instant.
_MARGIN = 0.02
#: Options of the run that are those of a steady state, whose start does not depend on them.
_FIXED = {"initial": "static", "modes": None, "accuracy": None}


@dataclass(frozen=True)
class Superposition:
    """The sources of a system at a constant speed."""

    system: System
    speed: float

    @classmethod
    def of(cls, system: System, speed: float, geometry: str) -> "Superposition | None":
        """Give the superposition if the motions of the sources of a system superpose."""
        values: list[Any] = [torque.value for torque in system.torques]
        values += [force.value for force in system.forces]
        over_time = any(isinstance(value, TimeSeries) or callable(value) for value in values)
        if over_time or speed == 0.0 or not has_constant_coefficients(system._model, geometry):
            return None
        return cls(system, speed)

    def solve(self, arguments: dict[str, Any]) -> tuple[Array, float, int]:
        """Find the state at the start, and describe the solutions that it consists of."""
        options = {key: value for key, value in arguments.items() if key != "record"} | _FIXED
        options["rtol"] = tolerance(arguments)
        # Variants have the elements of this system, which may depend on what excites it.
        meshed = type(self.system)._from_description(self.system._model.resolved())
        parts = silent(meshed)
        # Transmission errors are sources of their own, also with their first orders.
        smooth = variant(meshed, meshes=parts["meshes"])._model
        rest = initial_state(smooth, **options)
        state = initial_state(smooth, **{**options, "initial": "synchronous"})
        residual, periods = 0.0, 0
        for period, changes in self._sources():
            model = variant(meshed, **{**parts, **changes})._model
            given = {**options, "duration": period}
            data, about = steady_state(
                model, **given, slowest=None, samples=1, record=[], progress=None
            )
            state = state + user_order(model, data["final"]["state"]) - rest
            residual = max(residual, about["residual"])
            periods += about["periods"]
        return state, residual, periods

    def _sources(self) -> Iterator[tuple[float, dict[str, Any]]]:
        """Give period and parts of each source that the synchronous response does not contain."""
        system, parts = self.system, silent(self.system)
        for i, mesh in enumerate(system.meshes):
            for ratio, error in self._errors(mesh):
                meshes = list(parts["meshes"])
                meshes[i] = replace(mesh, error=error)
                yield self._turn(ratio), {"meshes": meshes}
        for i, force in enumerate(system.forces):
            if force.order is None or force.order == 1.0:
                continue
            forces = list(parts["forces"])
            forces[i] = force
            yield self._turn(self._ratio(force.at) * (force.order or 1.0)), {"forces": forces}

    def _errors(self, mesh: Mesh) -> Iterator[tuple[float, TransmissionError]]:
        """Give the parts of a transmission error with their orders of the reference shaft."""
        error = mesh.error
        if error is None:
            return
        driver, driven = (self._ratio(gear) for gear in (mesh.driver, mesh.driven))
        teeth = next(gear.teeth for gear in self.system.gears if gear.name == mesh.driver)
        if error.tooth is not None or error.table is not None:
            yield driver * teeth, TransmissionError(tooth=error.tooth, table=error.table)
        if error.driver is not None:
            yield driver, TransmissionError(driver=error.driver)
        if error.driven is not None:
            yield driven, TransmissionError(driven=error.driven)

    def _ratio(self, at: Any) -> float:
        """Give the speed of the shaft of a place over that of the reference shaft."""
        shafts = {gear.name: gear.shaft for gear in self.system.gears}
        shafts |= {disk.name: disk.shaft for disk in self.system.disks}
        name = shafts[at] if isinstance(at, str) else at[0]
        names = [shaft.name for shaft in self.system.shafts]
        return float(self.system.speed_ratios[names.index(name)])

    def _turn(self, order: float) -> float:
        """Give the period of an order of the reference shaft [s]."""
        return _turn(order, self.speed)


def recorded_duration(system: System, speed: float, longest: float) -> float:
    """Give the duration of the record without a period [s]: what orders need, or two turns."""
    turn = _turn(float(min(abs(system.speed_ratios))), speed)
    gaps = np.diff([0.0, *(order.value for order in Kinematics.of(system).orders())])
    separate = (1.0 + _MARGIN) * SEPARATION * _turn(float(gaps.min()), speed)
    is_short = separate <= min(_MOST * turn, longest)
    return min(max(turn, separate) if is_short else _UNSEPARATED * turn, longest)


def _turn(order: float, speed: float) -> float:
    return 2.0 * math.pi / abs(order * speed)
