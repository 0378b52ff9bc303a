"""What a system assumes where its description says nothing: defaults of physical models."""

from collections.abc import Sequence
from typing import Any

from gearbow.description.gears import Gear, Mesh
from gearbow.description.places import place_label
from gearbow.description.rolling import RollingBearing
from gearbow.description.shafts import STEEL, Shaft, segments_of
from gearbow.description.stiffness import Stiffness

#: Models of tooth pairs, which have an engagement.
_PAIRS = ("square", "parabolic", "potential_energy")


def _engages_by_default(mesh: Mesh) -> bool:
    """Return whether a mesh has tooth pairs with the default length of engagement."""
    model = mesh.stiffness
    return isinstance(model, Stiffness) and model.model in _PAIRS and model.engagement is None


def _uses_steel(shaft: Shaft) -> bool:
    """Return whether a part of a shaft has the default material."""
    return shaft.material == STEEL and any(each.material is None for each in segments_of(shaft))


def assumptions(
    shafts: Sequence[Shaft], gears: Sequence[Gear], meshes: Sequence[Mesh], bearings: Sequence[Any]
) -> list[str]:
    """List the defaults of physical models that these parts use, with the parts that use them."""
    steel = [shaft.name for shaft in shafts if _uses_steel(shaft)]
    tips = [gear.name for gear in gears if gear.tip_radius is None]
    disks = [gear.name for gear in gears if gear.mass is None]

    chosen = {
        "mean stiffness of ISO 6336-1": [mesh.stiffness is None for mesh in meshes],
        "tooth pairs engage over 0.1 of the base pitch": [
            _engages_by_default(mesh) for mesh in meshes
        ],
        "no damping": [mesh.damping is None and mesh.damping_ratio == 0.0 for mesh in meshes],
        "contact on both flanks, without backlash": [mesh.backlash is None for mesh in meshes],
        "no damping in separation": [
            mesh.backlash is not None and not mesh.damping_in_separation for mesh in meshes
        ],
    }
    names = [f"{mesh.driver}–{mesh.driven}" for mesh in meshes]
    found = [
        ("shafts", "steel with E = 207 GPa, ν = 0.3, ρ = 7850 kg/m³", steel, len(shafts)),
        ("gears", "tip radius of full-depth teeth", tips, len(gears)),
        ("gears", "mass and inertia of solid steel disks", disks, len(gears)),
    ]
    estimated = {
        place_label((each.shaft, each.position)): estimate.stiffness_uncertainty
        for each in bearings
        if isinstance(each, RollingBearing) and (estimate := each.estimate) is not None
    }
    if estimated:
        error = f"{max(estimated.values()):.0%}"
        text = f"number and size of rolling elements by estimates, stiffness within {error}"
        found.append(("bearings", text, list(estimated), len(bearings)))
    for text, used in chosen.items():
        own = [name for name, is_used in zip(names, used, strict=True) if is_used]
        found.append(("meshes", text, own, len(meshes)))
    return [
        f"{kind}: {text}" + ("" if len(own) == total else f" ({', '.join(own)})")
        for kind, text, own, total in found
        if own
    ]
