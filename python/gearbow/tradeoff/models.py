"""Simpler models of a system, and finer ones, for a study to hold against it as it is given."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from gearbow._types import Plain

if TYPE_CHECKING:
    from gearbow.system import RotorSystem

__all__ = ["GIVEN", "Model", "copy", "refined", "simplified"]

#: Name of the model that nothing is left out of.
GIVEN = "as given"

#: Stiffness models that do not change while the teeth pass.
_STEADY = ("constant", "iso6336")


@dataclass(frozen=True, eq=False)
class Model:
    """A system as it is given, or simplified.

    Parameters
    ----------
    name : str
        What was simplified, "as given" for nothing.
    system : RotorSystem
        The system to run.
    options : mapping
        Options of `simulate` that belong to it.
    methods : tuple of str, optional
        The methods that can run it; None is all.
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
    """Make the simplified models that differ from the system as it is given.

    Parameters
    ----------
    system : RotorSystem
        The system.
    frozen : bool
        Whether to freeze the geometry of the meshes.
    mean_stiffness : bool
        Whether to take the mean of stiffnesses that vary.
    factors : sequence of float
        Numbers of elements over those given; those below one are taken.
    modes : sequence of int
        Numbers of modes to keep.

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
    """Make the model with the most elements, if more than given are asked for.

    Parameters
    ----------
    system : RotorSystem
        The system.
    factors : sequence of float
        Numbers of elements over those given.

    Returns
    -------
    Model or None
        The finer model.
    """
    factor = max(factors, default=1.0)
    finer = _with_elements(system, factor) if factor > 1.0 else None
    return None if finer is None else Model(f"elements × {factor:g}", finer)


def copy(system: "RotorSystem") -> "RotorSystem":
    """Make the system anew, so that nothing of it has been computed.

    Parameters
    ----------
    system : RotorSystem
        The system.

    Returns
    -------
    RotorSystem
        One with the same description.
    """
    return type(system)._from_description(system.description)


def _moves(system: "RotorSystem", gear: str) -> bool:
    return system._model.indices(gear)[0] is not None


def _with_mean_stiffness(system: "RotorSystem") -> "RotorSystem | None":
    """Replace stiffnesses that vary by their mean; relief belongs to pairs, which are gone then."""
    description = system.description
    meshes = description.get("meshes", [])
    varying = [i for i, mesh in enumerate(meshes) if _varies(mesh.get("stiffness"))]
    if not varying:
        return None
    # Where no flank parts and no tip is relieved, the equilibrium has the mean of the cycle.
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
    """Multiply the elements of every segment; None where that leaves all as they are."""
    description = system.description
    for shaft in description["shafts"]:
        for segment in shaft.get("segments") or [shaft]:
            segment["elements"] = max(1, round(segment.get("elements", 1) * factor))
    other = type(system)._from_description(description)
    return None if other.dofs == system.dofs else other
