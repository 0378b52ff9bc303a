"""Cases of the bow study: the parameters of each run, and the list of all runs."""

import copy
import hashlib
import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace

from gearbow._core import __version__
from gearbow._types import Plain
from gearbow.study.settings import Settings
from gearbow.system import RotorSystem

__all__ = ["ALL", "Case", "cases", "description", "influential", "key", "system"]

#: Value of `Case.where` for a bow on every shaft.
ALL = "all"


@dataclass(frozen=True)
class Case:
    """Parameters of one run."""

    layout: str
    torque: float
    speed: float
    bow: float = 0.0
    where: str = ALL
    phases: tuple[float, float] = (0.0, 0.0)
    geometry: str = "live"
    accuracy: str = "engineering"


def cases(settings: Settings) -> tuple[Case, ...]:
    """List every run of a study once.

    Parameters
    ----------
    settings : Settings
        The study.

    Returns
    -------
    tuple of Case
        Every bow on all shafts and on each shaft, at every torque and speed, in every layout;
        a grid of bow phases; runs with frozen geometry; and the runs that measure the error.

    Examples
    --------
    >>> from gearbow.study import Settings, cases
    >>> len(cases(Settings.load()))
    342
    """
    return tuple(dict.fromkeys(_all(settings)))


def middle(values: tuple[float, ...]) -> float:
    """Return the middle value of a list."""
    return values[len(values) // 2]


def phases(settings: Settings) -> tuple[float, ...]:
    """Return the phases of the phase grid."""
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
    """List the runs that measure the error of the study."""
    first = next(iter(settings.layouts))
    for bow in (0.0, settings.phase_bow):
        speed = middle(settings.speeds)
        yield Case(first, max(settings.torques), speed, bow, accuracy="reference")


def description(settings: Settings, case: Case) -> dict[str, Plain]:
    """Return the system of a case as plain data."""
    scene = copy.deepcopy(dict(settings.scene))
    for shaft, phase in zip(scene["shafts"], (0.0, *case.phases), strict=True):
        if case.bow and case.where in (ALL, shaft["name"]):
            radius = shaft["outer_diameter"] / 2.0
            shaft["bow"] = {"shape": "half_sine", "amplitude": case.bow * radius, "phase": phase}
    for gear in scene["gears"]:
        gear["position"] = settings.layouts[case.layout][gear["name"]]
    scene["torques"][0]["value"] = case.torque
    scene["resolution"] = case.accuracy
    return scene


def system(settings: Settings, case: Case) -> RotorSystem:
    """Create the system of a case."""
    return RotorSystem._from_description(description(settings, case))


def influential(settings: Settings) -> Settings:
    """Return the settings that a run of a given case depends on."""
    return replace(
        settings,
        bows=(),
        torques=(),
        speeds=(),
        accuracy="",
        phase_steps=0,
        phase_bow=0.0,
        modes=0,
        backlash=0.0,
    )


def key(settings: Settings, wanted: Sequence[Case]) -> str:
    """Return a file name for runs, a digest of everything that their results depend on."""
    whole = {
        "version": __version__,
        "settings": asdict(influential(settings)),
        "cases": [asdict(case) for case in wanted],
    }
    text = json.dumps(whole, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:32]
