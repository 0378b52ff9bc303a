"""Cases of the bow study: the parameters of each run, and the list of all runs."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import gearbow as gb

#: Value of `Case.where` for a bow on every shaft.
ALL = "all"


@dataclass(frozen=True)
class Case:
    """Parameters of one run."""

    layout: str
    torque: float  # of the first gear, N m
    speed: float  # of the first shaft, rad/s
    bow: float = 0.0  # amplitude of the half-sine bow / shaft radius
    where: str = ALL  # the bowed shaft
    phases: tuple[float, float] = (0.0, 0.0)  # of the bows of the second and third shaft, rad
    geometry: Literal["live", "frozen"] = "live"
    accuracy: str = "engineering"


def scene() -> gb.RotorSystem:
    """Return the train with straight shafts."""
    return gb.RotorSystem.load(Path(__file__).with_name("scene.toml"))


@dataclass(frozen=True)
class Settings:
    """The train and the values that the study varies."""

    train: gb.RotorSystem = field(default_factory=scene)
    layouts: Mapping[str, Mapping[str, float]] = field(  # positions of the gears, m
        default_factory=lambda: {
            "quarter": {"g1": 0.25, "g2": 0.125, "g3": 0.375, "g4": 0.25},
            "half": {"g1": 0.25, "g2": 0.25, "g3": 0.375, "g4": 0.25},
        }
    )
    bows: tuple[float, ...] = (0.0, 0.01, 0.025, 0.05, 0.075, 0.1)
    torques: tuple[float, ...] = (0.0, 250.0)
    speeds: tuple[float, ...] = (50.0, 100.0, 150.0)
    settle: int = 2  # revolutions of the slowest shaft before the recorded one
    samples: int = 4000  # output times in the recorded revolution
    accuracy: str = "engineering"
    phase_steps: int = 6  # bow phases of the second and of the third shaft, over one revolution
    phase_bow: float = 0.05  # bow of the phase grid; one of `bows`
    modes: int = 12  # number of modes in the table of modes at rest
    backlash: float = 1.5e-4  # m, for the table of limits only; the meshes have no backlash

    @property
    def base(self) -> Case:
        """Return the case without bow to which the others are compared."""
        speed = self.speeds[len(self.speeds) // 2]
        return Case(next(iter(self.layouts)), max(self.torques), speed, accuracy=self.accuracy)

    @property
    def phases(self) -> tuple[float, ...]:
        """Return the phases of the phase grid."""
        return tuple(2.0 * math.pi * step / self.phase_steps for step in range(self.phase_steps))


def quick(settings: Settings) -> Settings:
    """Return a small part of a study."""
    return replace(
        settings,
        bows=(0.0, settings.phase_bow),
        torques=settings.torques[-1:],
        speeds=(settings.base.speed,),
        phase_steps=2,
        accuracy="draft",
    )


def cases(settings: Settings) -> tuple[Case, ...]:
    """List every run of a study once."""
    return tuple(dict.fromkeys(_all(settings)))


def _all(settings: Settings) -> Iterator[Case]:
    base = settings.base
    for layout in settings.layouts:
        for torque in settings.torques:
            for speed in settings.speeds:
                for bow in settings.bows:
                    case = replace(base, layout=layout, torque=torque, speed=speed, bow=bow)
                    yield case
                    if bow:
                        yield from (replace(case, where=s.name) for s in settings.train.shafts)
        bent = replace(base, layout=layout, bow=settings.phase_bow)
        for second in settings.phases:
            for third in settings.phases:
                yield replace(bent, phases=(second, third))
    for speed in settings.speeds:
        for bow in settings.bows:
            yield replace(base, speed=speed, bow=bow, geometry="frozen")
    # These runs measure the error of the study.
    for bow in (0.0, settings.phase_bow):
        yield replace(base, bow=bow, accuracy="reference")


def train(settings: Settings, case: Case) -> gb.RotorSystem:
    """Return the system of a case."""
    straight, positions = settings.train, settings.layouts[case.layout]
    return straight.replace(
        shafts=bent(straight.shafts, case),
        gears=[replace(gear, position=positions[gear.name]) for gear in straight.gears],
        torques=[replace(straight.torques[0], value=case.torque), *straight.torques[1:]],
        accuracy=case.accuracy,
    )


def bent(shafts: Sequence[gb.Shaft], case: Case) -> list[gb.Shaft]:
    """Return the shafts with the bows of a case."""
    found = []
    for shaft, phase in zip(shafts, (0.0, *case.phases), strict=True):
        bow = None
        if case.bow and case.where in (ALL, shaft.name):
            bow = gb.Bow.half_sine(case.bow * radius(shaft), phase=phase)
        found.append(replace(shaft, bow=bow))
    return found


def radius(shaft: gb.Shaft) -> float:
    """Return the outer radius of a shaft [m]."""
    assert shaft.outer_diameter is not None
    return shaft.outer_diameter / 2.0
