"""Scenes of the comparison. All start from rest at 100 rad/s, with the same transient."""

import functools
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

import gearbow as gb
from gearbow._types import Geometry

Array: TypeAlias = NDArray[np.float64]

SPEED = 100.0  # of the first shaft, rad/s
TORQUE = 50.0  # at the first gear, N m
BOW = 1.5e-4  # amplitude of the bow of every shaft, m
ELEMENT = 1.0 / 15.0  # element length of the shafts, m
SEAT = 2e-3  # element length of a bearing seat, m


@dataclass(frozen=True)
class Scene:
    """A system, the points that are compared, and the run."""

    title: str
    build: Callable[[], gb.RotorSystem]
    points: tuple[tuple[str, float], ...]  # (shaft, position) of the compared displacements
    geometry: Geometry = "frozen"
    duration: float = 0.05  # s
    stretch: float = 0.01  # shorter duration of slow methods, s
    sample: float = 1e-4  # time between the compared samples, s
    ross: bool = False  # whether ROSS can model the scene
    error: float = 1e-3  # required error
    own: bool = False  # whether only gearbow can model the scene
    speed: float | gb.SpeedProfile = SPEED  # of the first shaft, rad/s

    def shortened(self) -> "Scene":
        """Return the scene with a tenth of the duration, for a quick comparison."""
        return replace(self, duration=self.duration / 10, stretch=self.stretch / 10)

    def times(self, duration: float) -> Array:
        """Return the times of the compared samples [s]."""
        return np.linspace(0.0, duration, round(duration / self.sample) + 1)


def shaft(name: str, *, seats: bool = False, elements: int = 15, bow: float = BOW) -> gb.Shaft:
    """Return a bowed shaft of 1 m; seats add 2 mm elements at both ends of 15 elements."""
    seat = gb.Segment(SEAT, 0.05)
    inner = [gb.Segment(ELEMENT - SEAT, 0.05), gb.Segment(13 * ELEMENT, 0.05, elements=13)]
    whole = [gb.Segment(1.0, 0.05, elements=elements)]
    segments = [seat, *inner, inner[0], seat] if seats else whole
    return gb.Shaft(name, segments=segments, bow=gb.Bow.half_sine(bow) if bow else None)


def bearings(*names: str) -> list[gb.Bearing]:
    """Return bearings at both ends of every shaft."""
    return [gb.Bearing(name, x, stiffness=1e8, damping=500.0) for name in names for x in (0.0, 1.0)]


def single() -> gb.RotorSystem:
    """Return one bowed shaft on its bearings."""
    return gb.RotorSystem([shaft("rotor")], bearings=bearings("rotor"))


def unbalanced() -> gb.RotorSystem:
    """Return a shaft with a disk with unbalance in the middle, on damped bearings."""
    return gb.RotorSystem(
        [shaft("rotor", bow=0.0)],
        disks=[gb.Disk("disk", "rotor", 7 * ELEMENT, 10.0, 0.05, 0.1, unbalance=1e-3)],
        bearings=bearings("rotor"),
    )


def jeffcott() -> gb.RotorSystem:
    """Return a disk with unbalance in the middle of a shaft, critical at about 110 rad/s."""
    return gb.RotorSystem(
        [gb.Shaft("rotor", length=1.0, outer_diameter=0.025, elements=10)],
        disks=[gb.Disk("disk", "rotor", 0.5, 10.0, 0.05, 0.1, unbalance=1e-3)],
        bearings=[gb.Bearing("rotor", x, stiffness=1e7) for x in (0.0, 1.0)],
        modal_damping=0.02,
    )


def geared(
    where: dict[str, tuple[str, int, int]],
    pairs: tuple[tuple[str, str], ...],
    stiffness: gb.Stiffness,
    damping_ratio: float,
    *,
    seats: bool = False,
    backlash: float | None = None,
    modal_damping: float | None = None,
    elements: int = 15,
    bow: float = BOW,
) -> gb.RotorSystem:
    """Return shafts with gears at nodes and balanced torques."""
    names = tuple(dict.fromkeys(name for name, _, _ in where.values()))
    options: dict[str, Any] = {"module": 3e-3, "face_width": 0.03}
    return gb.RotorSystem(
        shafts=[
            shaft(name, seats=seats and name != "middle", elements=elements, bow=bow)
            for name in names
        ],
        gears=[
            gb.Gear(gear, on, round(cut * elements / 15) / elements, teeth, **options)
            for gear, (on, cut, teeth) in where.items()
        ],
        meshes=[
            gb.Mesh(*pair, stiffness=stiffness, damping_ratio=damping_ratio, backlash=backlash)
            for pair in pairs
        ],
        bearings=bearings(*names),
        torques=[gb.Torque(pairs[0][0], TORQUE), gb.Torque.balance(pairs[-1][1])],
        modal_damping=modal_damping,
    )


PAIR = {"g1": ("input", 7, 25), "g2": ("output", 5, 50)}
TRAIN = {
    "g1": ("input", 7, 25),
    "g2": ("middle", 5, 50),
    "g3": ("middle", 10, 25),
    "g4": ("output", 7, 50),
}
STAGES = (("g1", "g2"), ("g3", "g4"))
SQUARE = gb.Stiffness.square(pair=2e8, engagement="sharp")
SMOOTH = gb.Stiffness.square(pair=2e8, engagement=0.2)
MEAN = gb.Stiffness.constant(3.4e8)


def bodies(system: gb.RotorSystem) -> list[gb.Disk | gb.Gear]:
    """Return all gears and disks."""
    return [*system.gears, *system.disks]


def places(where: dict[str, tuple[str, int, int]]) -> tuple[tuple[str, float], ...]:
    """Return the (shaft, position) of every gear."""
    return tuple((on, cut * ELEMENT) for on, cut, _ in where.values())


SCENES = {
    "shaft": Scene(
        "One bowed shaft, 16 nodes",
        single,
        (("rotor", 5 * ELEMENT), ("rotor", 10 * ELEMENT)),
        duration=1.0,
        ross=True,
    ),
    "pair": Scene(
        "Geared pair, constant mesh stiffness, frozen geometry, 32 nodes",
        functools.partial(geared, PAIR, (("g1", "g2"),), MEAN, 0.0),
        places(PAIR),
        duration=1.0,
        ross=True,
    ),
    "square": Scene(
        "Double-stage train, square mesh stiffness, sharp engagement, frozen geometry, n = 240",
        functools.partial(geared, TRAIN, STAGES, SQUARE, 0.05),
        places(TRAIN),
    ),
    "seats": Scene(
        "The same train with four additional elements of 2 mm, n = 260",
        functools.partial(geared, TRAIN, STAGES, SQUARE, 0.05, seats=True),
        places(TRAIN),
    ),
    "live": Scene(
        "Double-stage train, constant mesh stiffness, live geometry, n = 240",
        functools.partial(geared, TRAIN, STAGES, MEAN, 0.05),
        places(TRAIN),
        geometry="live",
    ),
    "separation": Scene(
        "Double-stage train, square mesh stiffness, backlash, live geometry, n = 240",
        functools.partial(geared, TRAIN, STAGES, SMOOTH, 0.05, backlash=1e-4),
        places(TRAIN),
        geometry="live",
        duration=0.1,
        error=5e-5,
        own=True,
    ),
    "jeffcott": Scene(
        "Jeffcott rotor, 10 elements, 2 % modal damping, run-up through its critical speed",
        jeffcott,
        (("rotor", 0.5),),
        duration=8.0,
        sample=1e-3,
        own=True,
        speed=gb.SpeedProfile.ramp(20.0, 200.0, 8.0),
    ),
    "run-up": Scene(
        "Double-stage train, square mesh stiffness, 2 % modal damping, live geometry, run-up",
        functools.partial(geared, TRAIN, STAGES, SMOOTH, 0.05, modal_damping=0.02),
        places(TRAIN),
        geometry="live",
        error=1e-4,
        own=True,
        speed=gb.SpeedProfile.ramp(0.0, 300.0, 0.05),
    ),
}
