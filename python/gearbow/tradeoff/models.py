"""Simplified and refined models of a system."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Generic

from gearbow.accuracy.estimate import MAX_DEGREE
from gearbow.analysis.protocol import S, System, variant
from gearbow.description.shafts import Shaft
from gearbow.description.stiffness import Stiffness
from gearbow.results.properties import ShaftElements

#: Name of the model without simplification.
GIVEN = "as given"

#: Stiffness models that are constant over the mesh cycle.
_STEADY = ("constant", "iso6336")


@dataclass(frozen=True, eq=False)
class Model(Generic[S]):
    """A given or simplified system."""

    name: str
    system: S
    options: Mapping[str, Any] = field(default_factory=dict)
    methods: tuple[str, ...] | None = None


def simplified(
    system: S,
    *,
    frozen: bool,
    mean_stiffness: bool,
    factors: Sequence[float],
    degrees: Sequence[int],
    modes: Sequence[int],
) -> list[Model[S]]:
    """Make the simplified models that differ from the given system."""
    found = []
    if frozen and any(_moves(system, mesh.driver) for mesh in system.meshes):
        found.append(Model("frozen geometry", system, {"geometry": "frozen"}))
    if mean_stiffness:
        mean = _with_mean_stiffness(system)
        if mean is not None:
            found.append(Model("mean stiffness", mean))
    others = {f"elements × {factor:g}": _with_elements(system, factor) for factor in factors}
    others |= {f"degree {degree}": _with_elements(system, degree=degree) for degree in degrees}
    found += [Model(name, other) for name, other in others.items() if other is not None]
    found += [
        Model(f"{count} modes", system, {"modes": count}, ("exponential",)) for count in modes
    ]
    return found


def refined(system: S, degrees: Sequence[int]) -> Model[S]:
    """Make the model with finer elements than all others: the reference of the total error."""
    degree = max(*degrees, *degrees_of(system)) + 1
    # Degree 2 improves the lowest frequencies of few elements too little.
    degree = max(degree, 3)
    if degree <= MAX_DEGREE:
        return Model(f"degree {degree}", _with_elements(system, degree=degree) or system)
    finer = _with_elements(system, factor=2.0, degree=MAX_DEGREE)
    return Model(f"elements × 2, degree {MAX_DEGREE}", finer or system)


def degrees_of(system: System) -> list[int]:
    """Give the degrees of the elements of a system."""
    return [each.degree for each in system.discretisation.shafts.values()]


def _moves(system: System, gear: str) -> bool:
    """Tell whether the system models the lateral motion of a gear."""
    (shaft,) = (other.shaft for other in system.gears if other.name == gear)
    return any(name == shaft and direction == "v" for name, _, direction in system.dofs)


def _with_mean_stiffness(system: S) -> S | None:
    """Replace time-varying mesh stiffness by its mean, without tip relief."""
    varying = [mesh for mesh in system.meshes if _varies(mesh.stiffness)]
    if not varying:
        return None
    # Without backlash and tip relief the equilibrium has the mean stiffness of the cycle.
    closed = [replace(mesh, backlash=None, tip_relief=None) for mesh in system.meshes]
    static = variant(system, meshes=closed).static()
    meshes = []
    for mesh in system.meshes:
        if mesh in varying:
            mean = static.mesh((mesh.driver, mesh.driven)).stiffness
            mesh = replace(mesh, tip_relief=None, stiffness=mean)  # noqa: PLW2901
        meshes.append(mesh)
    return variant(system, meshes=meshes)


def _varies(stiffness: object) -> bool:
    return isinstance(stiffness, Stiffness) and stiffness.model not in _STEADY


def _with_elements(system: S, factor: float = 1.0, degree: int | None = None) -> S | None:
    """Multiply the numbers of elements, and change the degree; None if nothing changes."""
    known = system.discretisation.shafts
    shafts = [_scaled(shaft, known[shaft.name], factor, degree) for shaft in system.shafts]
    other = variant(system, shafts=shafts)
    return None if other.dofs == system.dofs else other


def _scaled(shaft: Shaft, known: ShaftElements, factor: float, degree: int | None) -> Shaft:
    """Multiply the numbers of elements of a shaft, and change the degree."""
    numbers = [max(1, round(number * factor)) for number in known.numbers]
    shaft = replace(shaft, degree=known.degree if degree is None else degree)
    if shaft.segments is None:
        return replace(shaft, elements=numbers[0])
    segments = [
        replace(segment, elements=number)
        for segment, number in zip(shaft.segments, numbers, strict=True)
    ]
    return replace(shaft, segments=segments)
