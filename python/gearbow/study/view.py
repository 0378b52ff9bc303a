"""A study with its results, and short names for what is asked of it often."""

import math
from dataclasses import replace
from pathlib import Path

from gearbow.study.case import ALL, Case, middle
from gearbow.study.measure import Measured, measure
from gearbow.study.runs import Results, find
from gearbow.study.settings import Settings

__all__ = ["Study"]


class Study:
    """A study with its results, and short names for what is asked of it often.

    Parameters
    ----------
    settings : Settings
        The study.
    results : mapping of {Case: Measured}
        What its runs gave.
    folder : path-like, optional
        Where further runs are kept, as `limits` needs them; None keeps none.
    """

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
        # Without bow it does not matter where there is none.
        return self.results[replace(case, where=ALL) if not case.bow else case]

    def find(self, case: Case) -> Measured:
        """Give the run of any case, and make it where it is missing.

        Parameters
        ----------
        case : Case
            The case.

        Returns
        -------
        Measured
            Its run.
        """
        try:
            return self[case]
        except KeyError:
            if self.folder is None:
                return measure(self.settings, case)
            return find(self.settings, case, self.folder)

    def amplitude(self, bow: float) -> float:
        """Give the amplitude of a bow on the first shaft [m].

        Parameters
        ----------
        bow : float
            Over the radius.

        Returns
        -------
        float
            Amplitude [m].
        """
        return bow * float(self.settings.scene["shafts"][0]["outer_diameter"]) / 2.0

    def gear(self, name: str) -> dict[str, float]:
        """Give what is said of a gear.

        Parameters
        ----------
        name : str
            Its name.

        Returns
        -------
        dict
            Teeth, module and pressure angle among others.
        """
        (found,) = [gear for gear in self.settings.scene["gears"] if gear["name"] == name]
        return {"pressure_angle": math.radians(20.0), **found}

    def pair(self, name: str) -> tuple[float, float, float]:
        """Give the geometry of a pair of full-depth gears at rest.

        Parameters
        ----------
        name : str
            Name of the pair.

        Returns
        -------
        tuple of (float, float, float)
            Centre distance [m], pressure angle [rad] and base pitch [m].
        """
        driver, driven = (self.gear(gear) for gear in name.split("/"))
        module, angle = driver["module"], driver["pressure_angle"]
        distance = module * (driver["teeth"] + driven["teeth"]) / 2.0
        return distance, angle, math.pi * module * math.cos(angle)
