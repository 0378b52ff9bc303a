"""Simplified and refined models of a system."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Generic

from gearbow.analysis.protocol import S, System, variant
from gearbow.description.shafts import Shaft
from gearbow.description.stiffness import Stiffness

__all__ = ["GIVEN", "Model", "refined", "simplified"]

#: Name of the model without simplification.
GIVEN = "as given"

#: Stiffness models that are constant over the mesh cycle.
_STEADY = ("constant", "iso6336")


@dataclass(frozen=True, eq=False)
class Model(Generic[S]):
    """A given or simplified system.

    Parameters
    ----------
    name : str
        The simplification, or "as given".
    system : RotorSystem
        The system to run.
    options : mapping
        Options of `simulate` for this model.
    methods : tuple of str, optional
        Methods that can run the model; None is all.
    """

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
    modes: Sequence[int],
) -> list[Model[S]]:
    """Make the simplified models that differ from the given system.

    Parameters
    ----------
    system : RotorSystem
        The system.
    frozen : bool
        Whether to make a model with frozen mesh geometry.
    mean_stiffness : bool
        Whether to make a model with the mean of a time-varying mesh stiffness.
    factors : sequence of float
        Factors on the numbers of elements; only factors below 1 are used.
    modes : sequence of int
        Numbers of modes of the reduced models.

    Returns
    -------
    list of Model
        The models.
    """
    found = []
    if frozen and any(_moves(system, mesh.driver) for mesh in system.meshes):
        found.append(Model("frozen geometry", system, {"geometry": "frozen"}))
    if mean_stiffness:
        mean = _with_mean_stiffness(system)
        if mean is not None:
            found.append(Model("mean stiffness", mean))
    for factor in factors:
        coarser = _with_elements(system, factor) if factor < 1.0 else None
        if coarser is not None:
            found.append(Model(f"elements × {factor:g}", coarser))
    found += [
        Model(f"{count} modes", system, {"modes": count}, ("exponential",)) for count in modes
    ]
    return found


def refined(system: S, factors: Sequence[float]) -> Model[S] | None:
    """Make the model with the largest number of elements, if a factor exceeds 1.

    Parameters
    ----------
    system : RotorSystem
        The system.
    factors : sequence of float
        Factors on the numbers of elements.

    Returns
    -------
    Model or None
        The finer model.
    """
    factor = max(factors, default=1.0)
    finer = _with_elements(system, factor) if factor > 1.0 else None
    return None if finer is None else Model(f"elements × {factor:g}", finer)


def _moves(system: System, gear: str) -> bool:
    """Tell whether the system models the lateral motion of a gear."""
    (shaft,) = (other.shaft for other in system.gears if other.name == gear)
    return any(name == shaft and direction == "v" for name, _, direction in system.dofs)


def _with_mean_stiffness(system: S) -> S | None:
    """Replace time-varying mesh stiffness by its mean, without tip relief.

    Tip relief belongs to single tooth pairs, which a constant stiffness does not have.
    """
    varying = [mesh for mesh in system.meshes if _varies(mesh.stiffness)]
    if not varying:
        return None
    # Without backlash and tip relief the equilibrium has the mean stiffness of the cycle.
    closed = [replace(mesh, backlash=None, tip_relief=None) for mesh in system.meshes]
    static = variant(system, meshes=closed).static()
    meshes = []
    for mesh in system.meshes:
        if mesh in varying:
            mean = static.mesh(mesh.driver, mesh.driven).stiffness
            mesh = replace(mesh, tip_relief=None, stiffness=mean)  # noqa: PLW2901
        meshes.append(mesh)
    return variant(system, meshes=meshes)


def _varies(stiffness: object) -> bool:
    return isinstance(stiffness, Stiffness) and stiffness.model not in _STEADY


def _with_elements(system: S, factor: float) -> S | None:
    """Multiply the number of elements of every segment; None if nothing changes."""
    other = variant(system, shafts=[_scaled(shaft, factor) for shaft in system.shafts])
    return None if other.dofs == system.dofs else other


def _scaled(shaft: Shaft, factor: float) -> Shaft:
    """Multiply the number of elements of a shaft."""

    def scaled(elements: int | None) -> int:
        return max(1, round((elements or 1) * factor))

    if shaft.segments is None:
        return replace(shaft, elements=scaled(shaft.elements))
    segments = [replace(segment, elements=scaled(segment.elements)) for segment in shaft.segments]
    return replace(shaft, segments=segments)
