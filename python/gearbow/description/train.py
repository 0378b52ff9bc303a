"""Parts of a system made from its plain description, and what a drawing of the train needs."""

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gearbow._core import Model, mesh_geometry
from gearbow._read_only import ReadOnly
from gearbow._types import Array, ComplexArray, Dof, Plain
from gearbow.description.couplings import Coupling, Drive, Force
from gearbow.description.gears import Disk, Gear, Mesh
from gearbow.description.layout import Layout, layout
from gearbow.description.loads import Bearing, Torque
from gearbow.description.part import Part
from gearbow.description.shafts import Shaft, Sleeve
from gearbow.description.supports import Housing, Support
from gearbow.errors import AccuracyWarning

#: Class of the parts of each list of a system.
PARTS: dict[str, type[Part]] = {
    "shafts": Shaft,
    "gears": Gear,
    "meshes": Mesh,
    "bearings": Bearing,
    "torques": Torque,
    "disks": Disk,
    "supports": Support,
    "housings": Housing,
    "couplings": Coupling,
    "drives": Drive,
    "forces": Force,
    "sleeves": Sleeve,
}


def parts_of(description: Mapping[str, Plain]) -> dict[str, tuple[Any, ...]]:
    """Make the parts of a system from its plain description."""
    return {
        key: tuple(kind._from_description(part) for part in description.get(key, ()))
        for key, kind in PARTS.items()
    }


@dataclass(frozen=True, eq=False)
class Train(ReadOnly):
    """A train at rest: parts, positions, senses of rotation and bows."""

    parts: Mapping[str, tuple[Any, ...]]
    layout: Layout
    ratios: Mapping[str, float]
    dofs: tuple[Dof, ...]
    bow: ComplexArray

    @classmethod
    def of(cls, description: Mapping[str, Plain], ratios: Array) -> "Train":
        """Make the train of a plain description."""
        parts = parts_of(description)
        lists = ("shafts", "gears", "disks", "meshes", "bearings")
        bows = [_bow(description, shaft.name) for shaft in parts["shafts"] if shaft.bow is not None]
        return cls(
            parts=parts,
            layout=layout(
                *(parts[key] for key in lists),
                centre_distances=[mesh["centre_distance"] for mesh in mesh_geometry(description)],
                couplings=parts["couplings"],
                sleeves=parts["sleeves"],
            ),
            ratios={s.name: float(r) for s, r in zip(parts["shafts"], ratios, strict=True)},
            dofs=tuple(dof for dofs, _ in bows for dof in dofs),
            bow=np.concatenate([np.empty(0, complex), *(values for _, values in bows)]),
        )


def _bow(description: Mapping[str, Plain], name: str) -> tuple[list[Dof], ComplexArray]:
    """Give the degrees of freedom and the bow of one shaft, from a model of this shaft alone."""
    own: dict[str, list[Plain]] = {
        key: [part for part in description.get(key, ()) if part["shaft"] == name]
        for key in ("gears", "disks", "bearings", "sleeves")
    }
    # Of the bearings, also of those that stand on the shaft, a sag depends on the positions only.
    positions = [bearing["position"] for bearing in own["bearings"]]
    bases = [bearing.get("support") for bearing in description.get("bearings", ())]
    positions += [base[1] for base in bases if isinstance(base, list) and base[0] == name]
    own["bearings"] = [{"shaft": name, "position": x, "stiffness": 1e8} for x in positions]
    shafts = (shaft for shaft in description["shafts"] if shaft["name"] == name)
    own["shafts"] = [{**shaft, "speed_ratio": 1.0} for shaft in shafts]
    model = Model({**own, "motion": "lateral"})
    with warnings.catch_warnings():
        # The conditioning of the modes does not affect the bow.
        warnings.simplefilter("ignore", AccuracyWarning)
        bow: ComplexArray = model.synchronous(np.empty(0), "bow", 1)["bow"]
    return list(model.dofs), bow
