"""Simplified and refined models of a system."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from gearbow._types import Plain

if TYPE_CHECKING:
    from gearbow.system import RotorSystem

__all__ = ["GIVEN", "Model", "copy", "refined", "simplified"]

#: Name of the model without simplification.
GIVEN = "as given"

#: Stiffness models that are constant over the mesh cycle.
_STEADY = ("constant", "iso6336")


@dataclass(frozen=True, eq=False)
class Model:
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
    system: "RotorSystem"
    options: Mapping[str, Any] = field(default_factory=dict)
    methods: tuple[str, ...] | None = None


def simplified(
    system: "RotorSystem",
    *,
    frozen: bool,
    mean_stiffness: bool,
    factors: Sequence[float],
    modes: Sequence[int],
) -> list[Model]:
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


def refined(system: "RotorSystem", factors: Sequence[float]) -> Model | None:
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


def copy(system: "RotorSystem") -> "RotorSystem":
    """Copy a system without its stored results.

    Parameters
    ----------
    system : RotorSystem
        The system.

    Returns
    -------
    RotorSystem
        A system with the same description.
    """
    return type(system)._from_description(system.description)


def _moves(system: "RotorSystem", gear: str) -> bool:
    return system._model.indices(gear)[0] is not None


def _with_mean_stiffness(system: "RotorSystem") -> "RotorSystem | None":
    """Replace time-varying mesh stiffness by its mean, without tip relief.

    Tip relief belongs to single tooth pairs, which a constant stiffness does not have.
    """
    description = system.description
    meshes = description.get("meshes", [])
    varying = [i for i, mesh in enumerate(meshes) if _varies(mesh.get("stiffness"))]
    if not varying:
        return None
    # Without backlash and tip relief the equilibrium has the mean stiffness of the cycle.
    closed = [_without(mesh, "backlash", "tip_relief") for mesh in meshes]
    static = type(system)._from_description({**description, "meshes": closed}).static()
    for i in varying:
        mean = static.mesh(meshes[i]["driver"], meshes[i]["driven"]).stiffness
        meshes[i] = {**_without(meshes[i], "tip_relief"), "stiffness": mean}
    return type(system)._from_description({**description, "meshes": meshes})


def _varies(stiffness: Plain) -> bool:
    return isinstance(stiffness, Mapping) and stiffness["model"] not in _STEADY


def _without(description: Mapping[str, Plain], *keys: str) -> dict[str, Plain]:
    return {key: value for key, value in description.items() if key not in keys}


def _with_elements(system: "RotorSystem", factor: float) -> "RotorSystem | None":
    """Multiply the number of elements of every segment; None if nothing changes."""
    description = system.description
    for shaft in description["shafts"]:
        for segment in shaft.get("segments") or [shaft]:
            segment["elements"] = max(1, round(segment.get("elements", 1) * factor))
    other = type(system)._from_description(description)
    return None if other.dofs == system.dofs else other
