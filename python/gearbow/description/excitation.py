"""The excitations of a system, and those that the result of an analysis does not contain."""

from collections.abc import Iterable
from typing import Any

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
