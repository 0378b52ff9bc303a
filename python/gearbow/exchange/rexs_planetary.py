"""Planetary stages of a REXS file, in torsion: carriers, rings at rest, and what is left out.

The pins and side plates of a carrier are rigid, so that a carrier is one place on its shaft.
Bearings and forces act on bending only.
"""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from gearbow._core import Model
from gearbow.description.planetary import planet_masses
from gearbow.description.train import parts_of
from gearbow.exchange.rexs_file import Component, PlacedShaft, RexsFile, Shafts

#: Stiffness of a rigid support against rotation [N m/rad], as that of a rigid coupling.
_RIGID = 1e10


def with_orbits(description: dict[str, Any]) -> dict[str, Any]:
    """Add the inertia of planets about the axis of their carrier to it, as a disk."""
    if not any("carrier" in mesh for mesh in description.get("meshes", ())):
        return description
    parts = parts_of(description)
    properties = zip(parts["shafts"], Model(description).mass_properties(), strict=True)
    meshes = parts["meshes"]
    disks = planet_masses(
        meshes,
        {(mesh.driver, mesh.driven): mesh.centre_distance for mesh in meshes},
        {gear.name: gear for gear in parts["gears"]},
        {shaft.name: mass for shaft, (mass, *_) in properties},
        "planet masses on {}".format,
    )
    added = list(map(asdict, disks))
    return {**description, "disks": [*description.get("disks", ()), *added]}


class Planets:
    """The planetary stages of a file."""

    def __init__(self, file: RexsFile) -> None:
        self._file = file
        self.stages = file.of_kind("planetary_stage")
        #: Types of components of a file with stages that are read.
        self.kinds = {"planetary_stage", "planet_carrier", "side_plate"} if self.stages else set()
        own = self._shafts("planet_carrier_shaft")
        carried = {part.id for part, whole in file.assembled() if whole.kind == "planet_carrier"}
        plates = {each.id for each in file.of_kind("side_plate")}
        #: Pins and side plates, which are rigid parts of the carrier.
        self.left_out = (self._shafts("planet_pin") | carried | plates | self._between(own)) - own
        self._carriers = own
        #: Where a carrier shaft is joined to its side plate, and a shaft to the casing.
        self._joined: dict[int, Component] = {}
        self._held: list[tuple[Component, Component]] = []

    def _shafts(self, relation: str) -> set[int]:
        """Give the shafts in relations of a type."""
        return {refs["shaft"].id for refs in self._file.related(relation) if "shaft" in refs}

    def _between(self, carriers: set[int]) -> set[int]:
        """Give the shafts that only join the two shafts of a carrier."""
        partners: dict[int, set[int]] = {}
        for refs in self._file.related("side"):
            ends = [refs[role] for role in ("inner_part", "outer_part") if role in refs]
            for own, other in (ends, ends[::-1]) if len(ends) == 2 else ():
                partners.setdefault(own.id, set()).add(other.id)
        return (
            {shaft for shaft, others in partners.items() if others <= carriers}
            if carriers
            else set()
        )

    def take(self, joint: Component, inner: Component, outer: Component) -> bool:
        """Tell whether a joint belongs to a rigid carrier, or holds a shaft at rest."""
        if not self.stages:
            return False
        if outer.kind == "gear_casing" and "coupling" in joint.kind:
            if joint.flag("is_engaged") is not False:
                self._held.append((joint, inner))
            return True
        if inner.id in self._carriers and outer.kind == "side_plate":
            self._joined.setdefault(inner.id, joint)
        return bool({inner.id, outer.id} & self.left_out)

    def add(
        self,
        description: dict[str, Any],
        shafts: Shafts,
        placed: Mapping[int, PlacedShaft],
        notes: list[str],
    ) -> None:
        """Give the meshes of planets their carrier, and hold the shafts that the casing holds."""
        if not self.stages:
            return
        names = {each["name"]: each["shaft"] for each in description["gears"]}
        for stage in self.stages:
            of_stage = [
                (relation, refs["shaft"])
                for relation in ("planet_shaft", "planet_carrier_shaft")
                for refs in self._file.related(relation)
                if refs.get("planetary_stage") is stage and "shaft" in refs
            ]
            planets = {placed[each.id].name for kind, each in of_stage if kind == "planet_shaft"}
            carriers = [each for kind, each in of_stage if kind == "planet_carrier_shaft"]
            if not planets or not carriers:
                raise stage.error("no relations of its planets and of its carrier to their shafts")
            first, *others = ([placed[e.id].name, self._at(e, shafts, placed)] for e in carriers)
            for mesh in description["meshes"]:
                if planets & {names[mesh["driver"]], names[mesh["driven"]]}:
                    mesh["carrier"] = first
                    if "centre_distance" not in mesh:
                        raise stage.error(
                            f'the mesh of "{mesh["driver"]}" and "{mesh["driven"]}" needs a '
                            "center_distance, which is that of the planets from the axis"
                        )
            for other in others:
                rigid = {"a": first, "b": other, "torsional_stiffness": _RIGID}
                description["couplings"].append(rigid)
        for joint, shaft in self._held:
            on = placed[shaft.id]
            held = next(each for each in description["shafts"] if each["name"] == on.name)
            held["speed_ratio"] = 0.0
            given = joint.number("rotational_stiffness", "couplings.torsional_stiffness", _RIGID)
            at = shafts.locate(joint, on, "u_coordinate_on_shaft_inner_side")
            drive = {"at": [on.name, at], "stiffness": min(given, _RIGID)}
            description.setdefault("drives", []).append(drive)
        notes.append(
            "planetary stages are computed in torsion: pins and side plates are rigid, bearings "
            "are left out, and the phases of the teeth of the planets are equal"
        )

    def _at(self, carrier: Component, shafts: Shafts, placed: Mapping[int, PlacedShaft]) -> float:
        """Give the position on a carrier shaft at which its side plate is, or its left end [m]."""
        joint = self._joined.get(carrier.id)
        if joint is None:
            return 0.0
        return shafts.locate(joint, placed[carrier.id], "u_coordinate_on_shaft_inner_side")

    def leave_bending_out(self, description: dict[str, Any], notes: list[str]) -> None:
        """Leave out forces and weight, which torsion does not have."""
        if not self.stages:
            return
        description["motion"] = "torsion"
        if description.pop("gravity", None) or description.pop("forces", None):
            notes.append("forces and weight are left out, because torsion has no bending")
