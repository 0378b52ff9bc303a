"""One run of a study, and the list of all of them."""

import copy
import hashlib
import json
import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace

from gearbow._core import __version__
from gearbow._types import Plain
from gearbow.study.settings import Settings
from gearbow.system import RotorSystem

__all__ = ["ALL", "Case", "cases", "description", "key", "system"]

#: The word for bows on every shaft.
ALL = "all"

#: Raised whenever what a file of a result holds changes.
_FORMAT = 2


@dataclass(frozen=True)
class Case:
    """One run.

    Parameters
    ----------
    layout : str
        Where the gears sit.
    torque : float
        Value of the first torque [N m].
    speed : float
        Speed of the reference shaft [rad/s].
    bow : float
        Half-sine bow over the radius of the shaft.
    where : str
        The shaft that has it, or "all".
    phases : tuple of (float, float)
        Phases of the bows of the second and the third shaft [rad]; that of the first is 0.
    geometry : str
        "live" or "frozen".
    accuracy : str
        Accuracy of the run.
    refine : int
        Elements over those of the scene.
    """

    layout: str
    torque: float
    speed: float
    bow: float = 0.0
    where: str = ALL
    phases: tuple[float, float] = (0.0, 0.0)
    geometry: str = "live"
    accuracy: str = "engineering"
    refine: int = 1


def cases(settings: Settings) -> tuple[Case, ...]:
    """List every run of a study once.

    Parameters
    ----------
    settings : Settings
        The study.

    Returns
    -------
    tuple of Case
        Bows on all shafts and on each at every torque and speed, in both layouts; bows over their
        phases; the frozen geometry beside the live one; and what tells the error of the others.

    Examples
    --------
    >>> from gearbow.study import Settings, cases
    >>> len(cases(Settings.load()))
    344
    """
    return tuple(dict.fromkeys(_all(settings)))


def middle(values: tuple[float, ...]) -> float:
    """Give the value in the middle of a list.

    Parameters
    ----------
    values : tuple of float
        The list.

    Returns
    -------
    float
        The value.
    """
    return values[len(values) // 2]


def phases(settings: Settings) -> tuple[float, ...]:
    """Give the phases that bows are turned to.

    Parameters
    ----------
    settings : Settings
        The study.

    Returns
    -------
    tuple of float
        Angles over a whole turn [rad].
    """
    steps = settings.phase_steps
    return tuple(2.0 * math.pi * step / steps for step in range(steps))


def _all(settings: Settings) -> Iterator[Case]:
    shafts = [shaft["name"] for shaft in settings.scene["shafts"]]
    loaded = max(settings.torques)
    for layout in settings.layouts:
        for torque in settings.torques:
            for speed in settings.speeds:
                for bow in settings.bows:
                    case = Case(layout, torque, speed, bow, accuracy=settings.accuracy)
                    yield case
                    if bow:
                        yield from (replace(case, where=shaft) for shaft in shafts)
        case = Case(layout, loaded, middle(settings.speeds), accuracy=settings.accuracy)
        bent = replace(case, bow=settings.phase_bow)
        for second in phases(settings):
            for third in phases(settings):
                yield replace(bent, phases=(second, third))
    first = next(iter(settings.layouts))
    for speed in settings.speeds:
        for bow in settings.bows:
            yield Case(first, loaded, speed, bow, geometry="frozen", accuracy=settings.accuracy)
    yield from checks(settings)


def checks(settings: Settings) -> Iterator[Case]:
    """List the runs that tell the error of the others.

    Parameters
    ----------
    settings : Settings
        The study.

    Yields
    ------
    Case
        The same at the accuracy "reference", and with twice the elements at that of the study: in
        the first layout, at the largest torque, the middle speed and `phase_bow`, and without bow.
    """
    first = next(iter(settings.layouts))
    for bow in (0.0, settings.phase_bow):
        case = Case(first, max(settings.torques), middle(settings.speeds), bow)
        yield replace(case, accuracy="reference")
        yield replace(case, accuracy=settings.accuracy, refine=2)


def description(settings: Settings, case: Case) -> dict[str, Plain]:
    """Describe the system of a case as plain data.

    Parameters
    ----------
    settings : Settings
        The study.
    case : Case
        The case.

    Returns
    -------
    dict
        What `RotorSystem.description` would give.
    """
    scene = copy.deepcopy(dict(settings.scene))
    for shaft, phase in zip(scene["shafts"], (0.0, *case.phases), strict=True):
        if case.bow and case.where in (ALL, shaft["name"]):
            radius = shaft["outer_diameter"] / 2.0
            shaft["bow"] = {"shape": "half_sine", "amplitude": case.bow * radius, "phase": phase}
        shaft["elements"] *= case.refine
    for gear in scene["gears"]:
        gear["position"] = settings.layouts[case.layout][gear["name"]]
    scene["torques"][0]["value"] = case.torque
    return scene


def system(settings: Settings, case: Case) -> RotorSystem:
    """Make the system of a case.

    Parameters
    ----------
    settings : Settings
        The study.
    case : Case
        The case.

    Returns
    -------
    RotorSystem
        The system.
    """
    return RotorSystem._from_description(description(settings, case))


def key(settings: Settings, case: Case) -> str:
    """Name a case by all that its result depends on.

    Parameters
    ----------
    settings : Settings
        The study.
    case : Case
        The case.

    Returns
    -------
    str
        Digits; another parameter or another version gives others.
    """
    whole = {
        "format": _FORMAT,
        "version": __version__,
        "scene": description(settings, case),
        "case": asdict(case),
        "settle": settings.settle,
        "samples": settings.samples,
    }
    text = json.dumps(whole, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:32]
