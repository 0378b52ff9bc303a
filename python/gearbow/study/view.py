"""Access to the results of the bow study for its tables and figures."""

import math
from dataclasses import replace
from pathlib import Path

from gearbow._core import mesh_geometry
from gearbow._types import MeshGeometry
from gearbow.study.case import ALL, Case, middle
from gearbow.study.measure import Measured, measure
from gearbow.study.runs import Results, find
from gearbow.study.settings import Settings

__all__ = ["Study"]


class Study:
    """Settings and results of a study, with the cases that tables and figures use."""

    def __init__(self, settings: Settings, results: Results, folder: Path | None = None) -> None:
        self.settings = settings
        self.results = results
        self.folder = folder
        self.layout = next(iter(settings.layouts))
        self.shafts = [shaft["name"] for shaft in settings.scene["shafts"]]
        self.gears = [gear["name"] for gear in settings.scene["gears"]]
        self.pairs = [f"{mesh['driver']}/{mesh['driven']}" for mesh in settings.scene["meshes"]]
        self.bows = [bow for bow in settings.bows if bow]
        self.base = Case(
            self.layout, max(settings.torques), middle(settings.speeds), accuracy=settings.accuracy
        )
        self.bent = replace(self.base, bow=settings.phase_bow)

    def __getitem__(self, case: Case) -> Measured:
        # A case without bow does not depend on the shaft that the bow is on.
        return self.results[replace(case, where=ALL) if not case.bow else case]

    def find(self, case: Case) -> Measured:
        """Return the result of any case; simulate the case if there is no result."""
        try:
            return self[case]
        except KeyError:
            if self.folder is None:
                return measure(self.settings, case)
            return find(self.settings, case, self.folder)

    def amplitude(self, bow: float) -> float:
        """Return the amplitude of a bow on the first shaft."""
        return bow * float(self.settings.scene["shafts"][0]["outer_diameter"]) / 2.0

    def gear(self, name: str) -> dict[str, float]:
        """Return the description of a gear."""
        (found,) = [gear for gear in self.settings.scene["gears"] if gear["name"] == name]
        return dict(found)

    def mesh(self, name: str) -> MeshGeometry:
        """Return the geometry of a mesh at rest."""
        return mesh_geometry(self.settings.scene)[self.pairs.index(name)]

    def pair(self, name: str) -> tuple[float, float, float]:
        """Return centre distance, pressure angle and base pitch of a mesh at rest."""
        mesh, driver = self.mesh(name), self.gear(name.split("/", maxsplit=1)[0])
        pitch = 2.0 * math.pi * mesh["base_radii"][0] / driver["teeth"]
        return mesh["centre_distance"], mesh["pressure_angle"], pitch

    def clearance(self, name: str) -> float:
        """Return the smaller tip clearance of a mesh at rest."""
        mesh = self.mesh(name)
        reach = (
            tip + root
            for tip, root in zip(mesh["tip_radii"], mesh["root_radii"][::-1], strict=True)
        )
        return mesh["centre_distance"] - max(reach)
